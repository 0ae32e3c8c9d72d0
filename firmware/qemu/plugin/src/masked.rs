//! Measures how long all interrupts are masked: the sequences of instructions during which not even
//! the most urgent interrupt is taken.
//!
//! On a Cortex-M this is from CPSID to CPSIE, or to the write of PRIMASK that restores the value
//! read before. On RISC-V it is from a trap's entry to its MRET, or to an instruction in between
//! that sets MIE of `mstatus`; and from an instruction that clears MIE to one that sets it. A write
//! there whose value is in a register counts as masking, or as nothing: a sequence is rather too
//! long than too short.

use std::ffi::{c_uint, c_void};
use std::fs::File;
use std::io::{self, Write};
use std::slice;
use std::sync::Mutex;

use crate::api::*;

/// The effect of an instruction on the mask.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mask {
    Shut,
    Open,
    /// The mask is read, to be restored.
    Look,
    /// The mask is restored to the value read last.
    Restore,
}

/// The longest sequence.
pub struct Masked {
    /// The first instruction of all traps, which begin masked; 0 where they don't.
    trap: u64,
    state: Mutex<State>,
}

struct State {
    /// The instructions since interrupts were masked.
    shut: Option<u64>,
    /// The values read and not restored yet: whether interrupts were unmasked.
    looks: Vec<bool>,
    longest: u64,
    out: File,
}

/// An instruction, for QEMU's callback.
struct Followed {
    at: u64,
    does: Option<Mask>,
    masked: &'static Masked,
}

impl Masked {
    /// Each sequence that is longer than those before is a line: instructions, and the last one's
    /// address.
    pub fn new(trap: u64, out: &str) -> io::Result<Masked> {
        let out = File::create(out)?;
        Ok(Masked {
            trap,
            state: Mutex::new(State { shut: None, looks: Vec::new(), longest: 0, out }),
        })
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
        let followed = Box::leak(Box::new(Followed { at, does: does(code), masked: self }));
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

    fn executed(&self, own: &Followed) {
        let Ok(mut state) = self.state.lock() else { return };
        state.executed(own.at, own.does, own.at == self.trap && self.trap != 0);
    }
}

impl State {
    fn executed(&mut self, at: u64, does: Option<Mask>, trap: bool) {
        if trap {
            self.shut = Some(0);
        }
        if let Some(count) = &mut self.shut {
            *count += 1;
        }
        let opens = match does {
            Some(Mask::Open) => true,
            Some(Mask::Look) => {
                self.looks.push(self.shut.is_none());
                false
            }
            Some(Mask::Restore) => self.looks.pop().unwrap_or(false),
            Some(Mask::Shut) | None => false,
        };
        match (does, self.shut) {
            (Some(Mask::Shut), None) => self.shut = Some(0),
            (_, Some(count)) if opens => {
                (self.shut, self.looks) = (None, Vec::new());
                if count > self.longest {
                    self.longest = count;
                    // If the disk is full, lines are missing.
                    let _ = writeln!(self.out, "{count} {at:#x}");
                }
            }
            _ => {}
        }
    }
}

/// Called before QEMU executes an instruction.
unsafe extern "C" fn executed(_: c_uint, data: *mut c_void) {
    // SAFETY: `follow` passed this pointer.
    let followed = unsafe { &*data.cast::<Followed>() };
    followed.masked.executed(followed);
}

/// The effect of an instruction, by its code: Thumb's CPS and MSR, RISC-V's accesses to `mstatus`,
/// and MRET.
fn does(code: &[u8]) -> Option<Mask> {
    match *code {
        [0x72, 0xB6] => Some(Mask::Shut),
        [0x62, 0xB6] => Some(Mask::Open),
        // MRS and MSR of PRIMASK.
        [0xEF, 0xF3, 0x10, to] if to & 0xF0 == 0x80 => Some(Mask::Look),
        [_, 0xF3, 0x10, 0x88] => Some(Mask::Restore),
        [0x73, 0x00, 0x20, 0x30] => Some(Mask::Open),
        [a, b, c, d] if a & 0x7F == 0x73 && u16::from_le_bytes([c, d]) >> 4 == 0x300 => {
            let value = (u16::from(c) << 1 | u16::from(b) >> 7) & 31;
            match b >> 4 & 7 {
                // A write, from a register or an immediate.
                1 | 5 => Some(Mask::Shut),
                // Sets bits from a register, or from an immediate.
                6 if value & 8 != 0 => Some(Mask::Open),
                // Clears bits, from either.
                3 if value != 0 => Some(Mask::Shut),
                7 if value & 8 != 0 => Some(Mask::Shut),
                _ => None,
            }
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_masks_is_known_by_its_code() {
        let word = |code: u32| does(&code.to_le_bytes());
        let thumb = |code: u16| does(&code.to_le_bytes());
        assert_eq!(thumb(0xB672), Some(Mask::Shut)); // cpsid i
        assert_eq!(thumb(0xB662), Some(Mask::Open)); // cpsie i
        assert_eq!(thumb(0xB671), None); // cpsid f
        assert_eq!(does(&[0xEF, 0xF3, 0x10, 0x80]), Some(Mask::Look)); // mrs r0, primask
        assert_eq!(does(&[0x80, 0xF3, 0x10, 0x88]), Some(Mask::Restore)); // msr primask, r0
        assert_eq!(does(&[0x80, 0xF3, 0x11, 0x88]), None); // msr basepri, r0
        assert_eq!(word(0x3000_2573), None); // csrr a0, mstatus
        assert_eq!(word(0x3004_6073), Some(Mask::Open)); // csrsi mstatus, 8
        assert_eq!(word(0x3004_7573), Some(Mask::Shut)); // csrrci a0, mstatus, 8
        assert_eq!(word(0x3005_2073), None); // csrs mstatus, a0
        assert_eq!(word(0x3005_3073), Some(Mask::Shut)); // csrc mstatus, a0
        assert_eq!(word(0x3005_1073), Some(Mask::Shut)); // csrw mstatus, a0
        assert_eq!(word(0x3044_6073), None); // csrsi mie, 8
        assert_eq!(word(0x3020_0073), Some(Mask::Open)); // mret
    }

    #[test]
    fn a_stretch_begins_behind_what_masks_and_ends_with_what_lets_in() {
        let name = format!("stepwright-masked-{}", std::process::id());
        let path = std::env::temp_dir().join(name);
        let mut state =
            State { shut: None, looks: Vec::new(), longest: 0, out: File::create(&path).unwrap() };
        let (shut, open) = (Some(Mask::Shut), Some(Mask::Open));
        // Initially nothing is masked; masking again begins no new sequence.
        for (at, does) in [(2, open), (4, shut), (6, None), (8, shut), (10, open), (12, None)] {
            state.executed(at, does, false);
        }
        // A nested section: its end unmasks nothing.
        let (look, restore) = (Some(Mask::Look), Some(Mask::Restore));
        for does in [look, shut, look, shut, restore] {
            state.executed(14, does, false);
        }
        assert_eq!(state.shut, Some(3));
        state.executed(16, restore, false);
        // A trap, and another of the same length.
        for at in [20, 30] {
            state.executed(at, None, true);
            (0..3).for_each(|_| state.executed(at, None, false));
            state.executed(at, open, false);
        }
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "3 0xa\n4 0x10\n5 0x14\n");
        std::fs::remove_file(path).unwrap();
    }
}
