//! `mtime`, free-running at 10 MHz with 64 bits, and `mtimecmp`, both in the CLINT: the interrupt
//! is pending while `mtime` is at or past `mtimecmp`.

use core::arch::asm;

use stepwright::HoldOff;
use stepwright::timer::StepTimer;
use stepwright_controller::Register;

/// A register of the CLINT.
const fn clint(offset: usize) -> Register {
    // SAFETY: the memory map of `virt`: CLINT at 0x200_0000, words.
    unsafe { Register::at(0x0200_0000 + offset) }
}

const COMPARE: Register = clint(0x4000);
const COMPARE_HIGH: Register = clint(0x4004);
const TIME: Register = clint(0xBFF8);
const TIME_HIGH: Register = clint(0xBFFC);

/// MTIE of `mie`.
const BIT: usize = 1 << 7;

/// The step timer: the low half of `mtime`.
pub struct Timer(());

impl Timer {
    /// Takes `mtimecmp`, whose interrupt stays held off, and enables interrupts.
    ///
    /// # Safety
    /// Called once.
    pub unsafe fn start() -> Timer {
        COMPARE_HIGH.write(u32::MAX);
        // SAFETY: MIE of `mstatus`; no interrupt of `mie` is enabled yet.
        unsafe { asm!("csrc mie, {bit}", "csrsi mstatus, 8", bit = in(reg) BIT, options(nostack)) };
        Timer(())
    }
}

/// The counter. Called in the main loop, with the step interrupt enabled.
#[inline(always)]
pub fn count() -> u32 {
    TIME.read()
}

/// All of `mtime`.
#[inline(always)]
fn time() -> u64 {
    loop {
        let high = TIME_HIGH.read();
        let low = TIME.read();
        if TIME_HIGH.read() == high {
            return u64::from(high) << 32 | u64::from(low);
        }
    }
}

impl StepTimer for Timer {
    type Count = u32;
    /// Leaving and entering the interrupt takes some 80 instructions.
    const LINGER: u32 = 10;
    /// Some 100 instructions up to the edge of a single due step; twice as many for several steps.
    const REACTION: u32 = 200;

    #[inline(always)]
    fn now(&mut self) -> u32 {
        TIME.read()
    }

    #[inline(always)]
    fn wake_at(&mut self, at: u32) {
        let now = time();
        let ahead = at.wrapping_sub(now as u32) as i32;
        let at = now.saturating_add_signed(ahead.into());
        // The order of the privileged architecture: no intermediate value may match.
        COMPARE.write(u32::MAX);
        COMPARE_HIGH.write((at >> 32) as u32);
        COMPARE.write(at as u32);
    }
}

/// The timer's interrupt.
pub struct StepInterrupt;

// SAFETY: MTIE of `mie`, 0 after a reset; a write to a control register is complete with its
// instruction, and the assembly is a barrier for the compiler. A pending interrupt stays pending:
// it is a level.
unsafe impl HoldOff for StepInterrupt {
    #[inline(always)]
    fn hold() {
        // SAFETY: one bit of `mie`.
        unsafe { asm!("csrc mie, {bit}", bit = in(reg) BIT, options(nostack)) };
    }

    #[inline(always)]
    fn release() {
        // SAFETY: as above.
        unsafe { asm!("csrs mie, {bit}", bit = in(reg) BIT, options(nostack)) };
    }
}

/// Runs the body of the step interrupt with other interrupts enabled. They are more urgent then: a
/// RISC-V without its own interrupt controller has no priorities.
///
/// # Safety
/// Called by the step interrupt. The interrupts that nest do not hold it off, and so must not use
/// the motors.
#[inline(always)]
pub unsafe fn visit<R>(visit: impl FnOnce() -> R) -> R {
    StepInterrupt::hold();
    let (back, state): (usize, usize);
    // SAFETY: the return address and the state of the interrupt are kept; then MIE of `mstatus` is
    // set. This interrupt is held off, so it does not nest.
    unsafe {
        asm!("csrr {back}, mepc", "csrr {state}, mstatus", "csrsi mstatus, 8",
            back = out(reg) back, state = out(reg) state, options(nostack));
    }
    let end = visit();
    // SAFETY: restores both; MIE was clear.
    unsafe {
        asm!("csrw mstatus, {state}", "csrw mepc, {back}",
            back = in(reg) back, state = in(reg) state, options(nostack));
    }
    StepInterrupt::release();
    end
}
