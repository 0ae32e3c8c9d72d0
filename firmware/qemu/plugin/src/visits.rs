//! The cost of each visit of an interrupt: instructions, and cycles of a Cortex-M0.
//!
//! The cycles are those of ARM's Technical Reference Manual of the Cortex-M0 (r0p0, "Instruction
//! set summary"), with a memory without wait states: 1 for an instruction on registers, 2 for a
//! load or a store, 1 + N for N of them, 3 for a taken branch and 1 for one that is not taken, 4
//! for a call, 3 more for a return by POP. An interrupt's entry and its end, 16 each, are not
//! included. For other processors only the instructions count.

use std::ffi::{c_uint, c_void};
use std::fs::File;
use std::io::{self, Write};
use std::slice;
use std::sync::Mutex;

use crate::api::*;

/// An instruction of the firmware.
struct Known {
    at: u64,
    size: u64,
    cycles: u64,
    /// The additional cycles if the next instruction is not the following one.
    taken: u64,
    flow: Flow,
}

/// The control flow after an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Flow {
    /// To the following instruction, or to another place in the same call.
    On,
    /// Into a call.
    Call,
    /// Out of a call, or out of the interrupt.
    Return,
    /// Out of the interrupt.
    End,
}

/// A visit in progress.
#[derive(Default)]
struct Visit {
    inside: bool,
    instructions: u64,
    cycles: u64,
    /// A branch whose next instruction is not known yet: the address after it, and the additional
    /// cycles if it is taken.
    branch: Option<(u64, u64)>,
    /// The calls that have not returned.
    depth: u64,
    /// The same for a call or a return, which may be conditional.
    flow: Option<(u64, Flow)>,
}

/// All visits.
pub struct Visits {
    entry: u64,
    state: Mutex<(Visit, File)>,
}

/// An instruction with the visits, for QEMU's callback.
struct Followed {
    known: Known,
    visits: &'static Visits,
}

impl Visits {
    /// The visits of the interrupt whose first instruction is at `entry`, written to a file.
    pub fn new(entry: u64, out: &str) -> io::Result<Visits> {
        // Unbuffered, because QEMU may be killed.
        let out = File::create(out)?;
        Ok(Visits { entry, state: Mutex::new((Visit::default(), out)) })
    }

    /// Follows every execution of an instruction.
    ///
    /// # Safety
    /// It is QEMU's instruction, of a block that is being translated.
    pub unsafe fn follow(&'static self, instruction: *mut Instruction) {
        // SAFETY: the caller's promise; QEMU has as many bytes as it says.
        let (at, code) = unsafe {
            let size = qemu_plugin_insn_size(instruction);
            let data: *const u8 = qemu_plugin_insn_data(instruction).cast();
            (qemu_plugin_insn_vaddr(instruction), slice::from_raw_parts(data, size))
        };
        // QEMU keeps it as long as the code, which is to the end.
        let followed = Box::leak(Box::new(Followed { known: known(at, code), visits: self }));
        let data: *mut Followed = followed;
        // SAFETY: QEMU's instruction, a function of the required type, and data that is never
        // freed.
        unsafe {
            qemu_plugin_register_vcpu_insn_exec_cb(
                instruction,
                executed,
                NO_REGISTERS,
                data.cast(),
            );
        }
    }

    fn executed(&self, own: &Known) {
        let Ok(mut state) = self.state.lock() else { return };
        let (visit, out) = &mut *state;
        if let Some((behind, cycles)) = visit.branch.take()
            && own.at != behind
        {
            visit.cycles += cycles;
        }
        let flow = visit.flow.take().filter(|(behind, _)| own.at != *behind);
        match flow {
            Some((_, Flow::Return)) if visit.depth > 0 => visit.depth -= 1,
            Some((_, Flow::Return | Flow::End)) => {
                // If the disk is full, lines are missing.
                let _ = writeln!(out, "{} {}", visit.instructions, visit.cycles);
                *visit = Visit::default();
            }
            Some((_, Flow::Call)) => visit.depth += 1,
            Some((_, Flow::On)) | None => {}
        }
        if own.at == self.entry {
            *visit = Visit { inside: true, ..Visit::default() };
        }
        if !visit.inside {
            return;
        }
        visit.instructions += 1;
        visit.cycles += own.cycles;
        if own.taken != 0 {
            visit.branch = Some((own.at + own.size, own.taken));
        }
        if own.flow != Flow::On {
            visit.flow = Some((own.at + own.size, own.flow));
        }
    }
}

/// Called before QEMU executes an instruction.
unsafe extern "C" fn executed(_: c_uint, data: *mut c_void) {
    // SAFETY: `follow` passed this pointer.
    let followed = unsafe { &*data.cast::<Followed>() };
    followed.visits.executed(&followed.known);
}

/// The properties of an instruction, by its code: Thumb, or RISC-V's `mret`.
fn known(at: u64, code: &[u8]) -> Known {
    let (cycles, taken, flow) = match *code {
        [0x73, 0x00, 0x20, 0x30] => (1, 0, Flow::End),
        [a, b] => narrow(u16::from_le_bytes([a, b])),
        [a, b, c, d] => wide(u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])),
        _ => (1, 0, Flow::On),
    };
    Known { at, size: code.len() as u64, cycles, taken, flow }
}

/// The cycles, the additional cycles of a taken branch, and the control flow.
fn narrow(code: u16) -> (u64, u64, Flow) {
    let listed = |bits: u16| u64::from((code & bits).count_ones());
    match code {
        // BX LR; BLX; BX of another register.
        0x4770 => (3, 0, Flow::Return),
        _ if code & 0xFF80 == 0x4780 => (3, 0, Flow::Call),
        _ if code & 0xFF00 == 0x4700 => (3, 0, Flow::On),
        // The high register PC.
        _ if matches!(code & 0xFF87, 0x4487 | 0x4687) => (3, 0, Flow::On),
        // Conditional branches; the last two conditions are UDF and SVC.
        _ if code >> 12 == 0xD && code >> 8 & 0xF < 14 => (1, 2, Flow::On),
        _ if code >> 11 == 0b11100 => (3, 0, Flow::On),
        // PUSH; POP, with PC or without.
        _ if code >> 9 == 0b1011010 => (1 + listed(0x1FF), 0, Flow::On),
        _ if code >> 8 == 0xBD => (4 + listed(0xFF), 0, Flow::Return),
        _ if code >> 8 == 0xBC => (1 + listed(0xFF), 0, Flow::On),
        // STM, LDM.
        _ if code >> 12 == 0xC => (1 + listed(0xFF), 0, Flow::On),
        // Loads and stores: relative to PC, by registers, by an offset, relative to SP.
        _ if code >> 11 == 0b01001 || matches!(code >> 12, 5..=9) => (2, 0, Flow::On),
        _ => (1, 0, Flow::On),
    }
}

/// The same for 32-bit instructions: BL, and barriers; on other cores POP and LDR with PC.
fn wide(first: u16, second: u16) -> (u64, u64, Flow) {
    let flow = match (first, second) {
        (0xE8BD, _) if second & 0x8000 != 0 => Flow::Return,
        (0xF85D, 0xFB04) => Flow::Return,
        _ if first & 0xF800 == 0xF000 && second & 0xD000 == 0xD000 => Flow::Call,
        _ => Flow::On,
    };
    (4, 0, flow)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_and_returns_are_known_by_their_codes() {
        let flow = |code: &[u8]| known(0, code).flow;
        assert_eq!(flow(&[0x70, 0x47]), Flow::Return); // bx lr
        assert_eq!(flow(&[0x10, 0x47]), Flow::On); // bx r2
        assert_eq!(flow(&[0x90, 0x47]), Flow::Call); // blx r2
        assert_eq!(flow(&[0xF0, 0xBD]), Flow::Return); // pop {r4-r7, pc}
        assert_eq!(flow(&[0xF0, 0xBC]), Flow::On); // pop {r4-r7}
        assert_eq!(flow(&[0xBD, 0xE8, 0xF0, 0x81]), Flow::Return); // pop.w {r4-r8, pc}
        assert_eq!(flow(&[0xBD, 0xE8, 0xF0, 0x41]), Flow::On); // pop.w {r4-r8, lr}
        assert_eq!(flow(&[0x00, 0xF0, 0x01, 0xF8]), Flow::Call); // bl
        assert_eq!(flow(&[0x00, 0xF0, 0x01, 0xB8]), Flow::On); // b.w
        assert_eq!(flow(&[0x73, 0x00, 0x20, 0x30]), Flow::End); // mret
    }

    /// A visit that calls, comes back, and leaves by the return of a function that it has jumped
    /// to.
    #[test]
    fn a_visit_ends_with_its_own_return() {
        let path = std::env::temp_dir().join(format!("stepwright-flow-{}", std::process::id()));
        let visits = Visits::new(0x100, path.to_str().unwrap()).unwrap();
        let one = |at, flow| {
            visits.executed(&Known { at, size: 2, cycles: 1, taken: 0, flow });
        };
        one(0x50, Flow::Return);
        for (at, flow) in [
            (0x100, Flow::Return), // // conditional, not taken
            (0x102, Flow::Call),
            (0x200, Flow::On),
            (0x202, Flow::Return),
            (0x104, Flow::On), // a jump
            (0x300, Flow::Return),
            (0x52, Flow::On),
        ] {
            one(at, flow);
        }
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "6 6\n");
        std::fs::remove_file(path).unwrap();
    }
}
