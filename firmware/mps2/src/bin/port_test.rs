//! Tests whether the step timer keeps the contract of `StepTimer`, and sends the result on the
//! line.
#![no_std]
#![no_main]

use stepwright_controller::TimerTrial;
use stepwright_mps2::timer::{StepInterrupt, Timer};
use stepwright_mps2::uart::Uart;

static TRIAL: TimerTrial<Timer, StepInterrupt> = TimerTrial::empty();

#[unsafe(no_mangle)]
extern "C" fn DUALTIMER() {
    // SAFETY: this is the step interrupt.
    unsafe { TRIAL.on_compare() };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: each of them once; the interrupt has been held off since the timer's start.
    unsafe {
        let (timer, mut line) = (Timer::start(), Uart::start());
        // 1,000 ticks: the interrupt with its work.
        TRIAL.run(timer, 1_000, &mut line)
    }
}
