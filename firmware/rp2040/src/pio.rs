//! The player that uses the state machines of the first PIO: see [`program`](crate::program).

use stepwright::drive::Axes;
use stepwright::{HoldOff, Ticks, Timing};
use stepwright_controller::Register;
use stepwright_sink::{Halted, Player, StepGroup};

use crate::board::{DIR, MACHINES, STEP};
use crate::chip::{self, CLEAR, Function, SET};
use crate::program::{FIRST, FIXED, Program};
use crate::vectors::{PIO0_NUMBER, UART0_NUMBER};

/// A register of the PIO.
#[inline(always)]
const fn pio(offset: usize) -> Register {
    // SAFETY: the datasheet's table of PIO.
    unsafe { Register::at(0x5020_0000 + offset) }
}

const CTRL: usize = 0x000;
const FDEBUG: Register = pio(0x008);
const FLEVEL: Register = pio(0x00C);
const IRQ: Register = pio(0x030);
const MEMORY: usize = 0x048;
const IRQ0_INTE: Register = pio(0x12C);
const IRQ0_INTS: Register = pio(0x134);

/// Offsets of the registers of the first state machine.
const EXECCTRL: usize = 0x0CC;
const SHIFTCTRL: usize = 0x0D0;
const ADDR: usize = 0x0D4;
const INSTR: usize = 0x0D8;
const PINCTRL: usize = 0x0DC;

/// A register of an axis's state machine.
#[inline(always)]
const fn machine(axis: u8, offset: usize) -> Register {
    pio(offset + 0x18 * axis as usize)
}

/// Autopull at 32 bits, OUT shifts right; the FIFOs apart, and joined for sending.
const APART: u32 = 1 << 17 | 1 << 19 | 1 << 18;
const JOINED: u32 = APART | 1 << 30;

/// The side-set bit for a high STEP.
const SIDE: u32 = 1 << 12;
const JMP_0: u32 = 0x0000;
const MOV_ISR_Y: u32 = 0xA0C2;
const PUSH: u32 = 0x8000;
const SET_PINDIR: u32 = 0xE081;

/// Four axes on the first PIO.
pub struct PioPlayer {
    program: Program,
    /// Cycles from edge to edge without the wait; and up to the first edge of the next group of
    /// each axis, which differs until the axis gets a group after a halt.
    fixed: u32,
    first: [u32; MACHINES],
}

impl PioPlayer {
    /// Gives the pins to the PIO, low, with all machines at rest.
    ///
    /// # Safety
    /// Called once.
    pub unsafe fn new() -> PioPlayer {
        for axis in 0..MACHINES as u8 {
            let (step, dir) = (STEP + u32::from(axis), DIR + u32::from(axis));
            // Sets the pins' directions with SET, one after the other.
            for pin in [step, dir] {
                machine(axis, PINCTRL).write(1 << 26 | pin << 5);
                machine(axis, INSTR).write(SET_PINDIR);
                chip::pull_up(pin, false);
                chip::give(pin, Function::Pio, false);
            }
            machine(axis, PINCTRL).write(1 << 29 | 1 << 20 | step << 10 | dir);
            machine(axis, SHIFTCTRL).write(JOINED);
        }
        let all = (1 << MACHINES) - 1;
        IRQ0_INTE.write(all << 8);
        let program = Program::of_pulse(0);
        let mut player = PioPlayer { program, fixed: 0, first: [FIRST; MACHINES] };
        player.load(program);
        pio(CTRL).write(all << 8 | all << 4);
        for axis in 0..MACHINES as u8 {
            machine(axis, INSTR).write(JMP_0);
        }
        player
    }

    /// Loads another program. All machines must rest at its first line, which is the same.
    fn load(&mut self, program: Program) {
        for (line, instruction) in program.code().enumerate() {
            pio(MEMORY + 4 * line).write(instruction.into());
        }
        for axis in 0..MACHINES as u8 {
            machine(axis, EXECCTRL).write(u32::from(program.wrap()) << 12);
        }
        (self.program, self.fixed) = (program, program.high + FIXED);
    }

    /// The words in the FIFO of an axis. One more word may have been taken out in advance.
    #[inline(always)]
    fn level(axis: u8) -> u32 {
        FLEVEL.read() >> (8 * u32::from(axis)) & 15
    }

    /// The next line of the program.
    #[inline(always)]
    fn line(axis: u8) -> u8 {
        machine(axis, ADDR).read() as u8 & 31
    }

    /// Whether this machine exists.
    #[inline(always)]
    const fn has(axis: u8) -> bool {
        (axis as usize) < MACHINES
    }
}

impl Player for PioPlayer {
    const DEPTH: u8 = 4;
    /// `jmp y--`, `out isr`, `out pins`, and one cycle to fill the output register.
    const LAG: Ticks = 4;

    #[inline(always)]
    fn now(&self) -> u64 {
        chip::micros().wrapping_mul(125)
    }

    fn set_timing(&mut self, timing: &Timing) {
        let program = Program::of_pulse(timing.pulse);
        if program != self.program {
            self.load(program);
        }
    }

    #[inline(always)]
    fn has_room(&self, axis: u8) -> bool {
        Self::has(axis) && Self::level(axis) <= 6
    }

    #[inline(always)]
    fn put(&mut self, axis: u8, group: StepGroup) {
        let Some(first) = self.first.get_mut(usize::from(axis)) else { return };
        let fixed = core::mem::replace(first, self.fixed);
        let fifo = pio(0x010 + 4 * usize::from(axis));
        fifo.write(group.interval.saturating_sub(fixed));
        fifo.write(group.steps.wrapping_sub(1) << 1 | u32::from(group.forward));
    }

    fn start(&mut self, axes: Axes) {
        FDEBUG.write(u32::from(axes) << 24);
        pio(CTRL + SET).write(axes.into());
    }

    #[inline(always)]
    fn waiting(&self, axis: u8) -> u8 {
        // If only one word of a group is in the FIFO, the other word has been taken out in advance.
        if Self::has(axis) { Self::level(axis).div_ceil(2) as u8 } else { 0 }
    }

    #[inline(always)]
    fn rests(&self, axis: u8) -> bool {
        !Self::has(axis) || Self::level(axis) == 0 && Self::line(axis) == 0
    }

    #[inline(always)]
    fn ran_dry(&mut self, axis: u8) -> bool {
        let bit = 1u32.wrapping_shl(24 + u32::from(axis));
        let dry = FDEBUG.read() & bit != 0;
        if dry {
            FDEBUG.write(bit);
        }
        dry
    }

    fn halt(&mut self, axes: Axes) {
        pio(CTRL + CLEAR).write(axes.into());
    }

    fn forget(&mut self, axis: u8) -> Halted {
        if !Self::has(axis) {
            return Halted { waiting: 0, left: 0 };
        }
        let (waiting, line) = (self.waiting(axis), Self::line(axis));
        // Ends the delay or wait in progress.
        pio(CTRL + SET).write(0x10u32.wrapping_shl(axis.into()));
        // The FIFOs apart: the waiting groups are discarded, and the receive FIFO takes Y.
        machine(axis, SHIFTCTRL).write(APART);
        let high = self.program.is_high(line);
        let side = if high { SIDE } else { 0 };
        machine(axis, INSTR).write(MOV_ISR_Y | side);
        machine(axis, INSTR).write(PUSH | side);
        let y = pio(0x020 + 4 * usize::from(axis)).read();
        machine(axis, SHIFTCTRL).write(JOINED);
        if high {
            // Waits for the rest of the pulse.
            cortex_m::asm::delay(self.program.high);
        }
        machine(axis, INSTR).write(JMP_0);
        IRQ.write(1u32.wrapping_shl(axis.into()));
        if let Some(first) = self.first.get_mut(usize::from(axis)) {
            *first = FIRST;
        }
        Halted { waiting, left: self.program.left(line, y) }
    }
}

/// The axes on which a group has begun, for the interrupt. Clears their requests.
#[inline(always)]
pub fn begun() -> Axes {
    let axes = IRQ0_INTS.read() >> 8 & 15;
    IRQ.write(axes);
    axes as Axes
}

/// The PIO's interrupt, and the line's, which is less urgent.
pub struct PioInterrupt;

const HELD: u32 = 1 << PIO0_NUMBER | 1 << UART0_NUMBER;

// SAFETY: the enable bits, 0 after a reset, include that of the one interrupt that serves the sink;
// barriers follow them. Pending interrupts stay pending.
unsafe impl HoldOff for PioInterrupt {
    #[inline(always)]
    fn hold() {
        // SAFETY: ARMv6-M: ICER; a written 0 changes nothing.
        unsafe { Register::at(0xE000_E180) }.write(HELD);
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
    }

    #[inline(always)]
    fn release() {
        cortex_m::asm::dsb();
        // SAFETY: ARMv6-M: ISER; a written 0 changes nothing.
        unsafe { Register::at(0xE000_E100) }.write(HELD);
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
    }
}
