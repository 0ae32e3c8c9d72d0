//! SYSTIMER: 52 bits at 16 MHz, of which the engine uses the low 32. Target 2 makes the steps; a
//! target in the past is due at once.

use esp_hal::interrupt::{self, InterruptHandler};
use esp_hal::peripherals::{Interrupt, SYSTIMER};
use esp_hal::timer::systimer::{SystemTimer, Unit};
use stepwright::HoldOff;
use stepwright::timer::StepTimer;

/// The target of the three that is used; `esp-hal` itself uses none of them.
const TARGET: usize = 2;

/// The step timer.
pub struct Timer(());

/// Takes the target, with its interrupt held off until the first [`HoldOff::release`].
pub fn start(timer: SYSTIMER<'static>, handler: InterruptHandler) -> Timer {
    StepInterrupt::hold();
    // This switches the timer on; its three alarms are not used.
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

/// The counter. Called in the main loop, with the step interrupt enabled.
#[inline(always)]
pub fn count() -> u32 {
    SystemTimer::unit_value(Unit::Unit0) as u32
}

impl StepTimer for Timer {
    type Count = u32;
    /// Leaving and entering the interrupt takes some 100 instructions.
    const LINGER: u32 = 16;
    /// Estimated: 5 µs.
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
        // SAFETY: the registers may have any value.
        target.hi().write(|w| unsafe { w.bits((at >> 32) as u32) });
        // SAFETY: as above.
        target.lo().write(|w| unsafe { w.bits(at as u32) });
        // Clears the old request before the new value is loaded: its own request comes after that.
        registers.int_clr().write(|w| w.target(TARGET as u8).clear_bit_by_one());
        registers.comp_load(TARGET).write(|w| w.load().set_bit());
    }
}

/// All interrupts of the processor: the programs here use only one.
pub struct StepInterrupt;

// SAFETY: MIE of `mstatus`; a write to a control register is complete with its instruction. The
// timer keeps its request.
unsafe impl HoldOff for StepInterrupt {
    #[inline(always)]
    fn hold() {
        riscv::interrupt::disable();
    }

    #[inline(always)]
    fn release() {
        // SAFETY: `hold` was called before, in the main loop.
        unsafe { riscv::interrupt::enable() };
    }
}
