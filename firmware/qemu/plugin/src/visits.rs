//! What each visit of an interrupt costs: instructions, and cycles of a Cortex-M0.
//!
//! The cycles are those of ARM's Technical Reference Manual of the Cortex-M0 (r0p0, "Instruction
//! set summary"), with a memory that makes nobody wait: 1 for what works on registers, 2 for a
//! load or a store, 1 + N for N of them, 3 for a branch that is taken and 1 for one that is not,
//! 4 for a call, 3 more for a return by POP. An interrupt's entry and its end, 16 each, are not in it.
//! For other processors the instructions alone count.

use std::ffi::{c_uint, c_void};
use std::fs::File;
use std::io::{self, Write};
use std::ops::Range;
use std::slice;
use std::sync::Mutex;

use crate::api::*;

/// An instruction of the firmware.
struct Known {
    at: u64,
    size: u64,
    cycles: u64,
    /// Cycles more if the next instruction is not the one behind it.
    taken: u64,
    returns: bool,
}

/// A visit under way.
#[derive(Default)]
struct Visit {
    inside: bool,
    instructions: u64,
    cycles: u64,
    /// A branch, whose next instruction is not known yet: where that is if it isn't taken, and
    /// the cycles if it is.
    branch: Option<(u64, u64)>,
}

/// All visits.
pub struct Visits {
    entry: u64,
    handler: Range<u64>,
    state: Mutex<(Visit, File)>,
}

/// An instruction with the visits, for QEMU's callback.
struct Followed {
    known: Known,
    visits: &'static Visits,
}

impl Visits {
    /// Visits of the interrupt whose first instruction is at `entry`, to a file.
    pub fn new(entry: u64, handler: Range<u64>, out: &str) -> io::Result<Visits> {
        // Written at once: QEMU may be killed.
        let out = File::create(out)?;
        Ok(Visits { entry, handler, state: Mutex::new((Visit::default(), out)) })
    }

    /// Looks at every execution of an instruction.
    ///
    /// # Safety
    /// QEMU's instruction, of a block that is being translated.
    pub unsafe fn follow(&'static self, instruction: *mut Instruction) {
        // SAFETY: the caller's promise; QEMU has as many bytes as it says.
        let (at, code) = unsafe {
            let size = qemu_plugin_insn_size(instruction);
            let data: *const u8 = qemu_plugin_insn_data(instruction).cast();
            (qemu_plugin_insn_vaddr(instruction), slice::from_raw_parts(data, size))
        };
        // QEMU keeps it for as long as the code, which is to the end.
        let followed = Box::leak(Box::new(Followed { known: known(at, code), visits: self }));
        let data: *mut Followed = followed;
        // SAFETY: QEMU's instruction, a function of that type, and data that stays.
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
        if own.returns && self.handler.contains(&own.at) {
            // A full disk shows in what is missing.
            let _ = writeln!(out, "{} {}", visit.instructions, visit.cycles);
            *visit = Visit::default();
        }
    }
}

/// QEMU is about to execute an instruction.
unsafe extern "C" fn executed(_: c_uint, data: *mut c_void) {
    // SAFETY: `follow` gave this.
    let followed = unsafe { &*data.cast::<Followed>() };
    followed.visits.executed(&followed.known);
}

/// What is known of an instruction by its code: Thumb, or RISC-V's `mret`.
fn known(at: u64, code: &[u8]) -> Known {
    let (cycles, taken, returns) = match *code {
        [0x73, 0x00, 0x20, 0x30] => (1, 0, true),
        [a, b] => narrow(u16::from_le_bytes([a, b])),
        [a, b, c, d] => wide(u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])),
        _ => (1, 0, false),
    };
    Known { at, size: code.len() as u64, cycles, taken, returns }
}

/// Cycles, cycles more if it branches, and whether it returns.
fn narrow(code: u16) -> (u64, u64, bool) {
    let listed = |bits: u16| u64::from((code & bits).count_ones());
    match code {
        // BX LR; BX and BLX of another.
        0x4770 => (3, 0, true),
        _ if code & 0xFF00 == 0x4700 => (3, 0, false),
        // A high register: PC.
        _ if matches!(code & 0xFF87, 0x4487 | 0x4687) => (3, 0, false),
        // Conditional branches; the last two conditions are UDF and SVC.
        _ if code >> 12 == 0xD && code >> 8 & 0xF < 14 => (1, 2, false),
        _ if code >> 11 == 0b11100 => (3, 0, false),
        // PUSH; POP, with PC or without.
        _ if code >> 9 == 0b1011010 => (1 + listed(0x1FF), 0, false),
        _ if code >> 8 == 0xBD => (4 + listed(0xFF), 0, true),
        _ if code >> 8 == 0xBC => (1 + listed(0xFF), 0, false),
        // STM, LDM.
        _ if code >> 12 == 0xC => (1 + listed(0xFF), 0, false),
        // Loads and stores: by PC, registers, an offset, SP.
        _ if code >> 11 == 0b01001 || matches!(code >> 12, 5..=9) => (2, 0, false),
        _ => (1, 0, false),
    }
}

/// Likewise: BL, and barriers; of other cores POP and LDR with PC.
fn wide(first: u16, second: u16) -> (u64, u64, bool) {
    let returns = (first == 0xE8BD && second & 0x8000 != 0) || (first, second) == (0xF85D, 0xFB04);
    (4, 0, returns)
}
