//! Tests whether the step timer keeps the contract of `StepTimer`, and sends the result on the
//! line.
#![no_std]
#![no_main]

use stepwright_controller::TimerTrial;
use stepwright_sam3x::chip;
use stepwright_sam3x::timer::{self, StepInterrupt, Timer};
use stepwright_sam3x::uart::{self, Uart};

static TRIAL: TimerTrial<Timer, StepInterrupt> = TimerTrial::empty();

#[unsafe(no_mangle)]
extern "C" fn TC0() {
    // SAFETY: this is the step interrupt.
    unsafe { TRIAL.on_compare() };
}

#[unsafe(no_mangle)]
extern "C" fn UART() {
    // SAFETY: this is the line's interrupt.
    unsafe { uart::on_receive() };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: first, and each of them once; the interrupt has been held off since the timer's
    // start.
    unsafe {
        chip::start();
        let (timer, mut line) = (timer::start(), Uart::start());
        // 1,000 ticks: the interrupt with its work.
        TRIAL.run(timer, 1_000, &mut line)
    }
}
