//! SYSTIMER: 52 bits at 16 MHz, of which the engine has the low 32. Target 2 steps; what has passed is
//! due at once.

use esp_hal::interrupt::{self, InterruptHandler};
use esp_hal::peripherals::{Interrupt, SYSTIMER};
use esp_hal::timer::systimer::{SystemTimer, Unit};
use stepwright::HoldOff;
use stepwright::timer::StepTimer;

/// Which of the three targets; `esp-hal` itself has none of them.
const TARGET: usize = 2;

/// The step timer.
pub struct Timer(());

/// Takes the target, its interrupt held off until the first [`HoldOff::release`].
pub fn start(timer: SYSTIMER<'static>, handler: InterruptHandler) -> Timer {
    StepInterrupt::hold();
    // It switches the timer on, and its three alarms come to nobody.
    let _ = SystemTimer::new(timer);
    let registers = SYSTIMER::regs();
    registers
        .target_conf(TARGET)
        .modify(|_, w| w.timer_unit_sel().bit(false).period_mode().bit(false));
    registers.conf().modify(|_, w| w.target2_work_en().set_bit());
    registers.int_ena().modify(|_, w| w.target(TARGET as u8).set_bit());
    interrupt::bind_handler(Interrupt::SYSTIMER_TARGET2, handler);
    Timer(())
}

/// The counter, for the main loop, while the step interrupt may come.
#[inline(always)]
pub fn count() -> u32 {
    SystemTimer::unit_value(Unit::Unit0) as u32
}

impl StepTimer for Timer {
    type Count = u32;
    /// Leaving and entering takes some 100 instructions.
    const LINGER: u32 = 16;
    /// Guessed: 5 µs.
    const REACTION: u32 = 80;

    #[inline(always)]
    fn now(&mut self) -> u32 {
        count()
    }

    #[inline(always)]
    fn wake_at(&mut self, at: u32) {
        let now = SystemTimer::unit_value(Unit::Unit0);
        let ahead = at.wrapping_sub(now as u32) as i32;
        let at = now.saturating_add_signed(ahead.into());
        let registers = SYSTIMER::regs();
        let target = registers.trgt(TARGET);
        // SAFETY: all values of the registers.
        target.hi().write(|w| unsafe { w.bits((at >> 32) as u32) });
        // SAFETY: likewise.
        target.lo().write(|w| unsafe { w.bits(at as u32) });
        // The old request, before the new value counts: its own comes when it is loaded.
        registers.int_clr().write(|w| w.target(TARGET as u8).clear_bit_by_one());
        registers.comp_load(TARGET).write(|w| w.load().set_bit());
    }
}

/// All interrupts of the processor: the programs here have one.
pub struct StepInterrupt;

// SAFETY: MIE of `mstatus`; a write to a control register is over with its instruction. The timer keeps
// its request.
unsafe impl HoldOff for StepInterrupt {
    #[inline(always)]
    fn hold() {
        riscv::interrupt::disable();
    }

    #[inline(always)]
    fn release() {
        // SAFETY: `hold` came before, in the main loop.
        unsafe { riscv::interrupt::enable() };
    }
}
