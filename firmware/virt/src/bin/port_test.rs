//! Tests whether the step timer keeps the contract of `StepTimer`, and sends the result on the
//! line.
#![no_std]
#![no_main]

use riscv::interrupt::Interrupt;
use stepwright_controller::TimerTrial;
use stepwright_virt::timer::{self, StepInterrupt, Timer};
use stepwright_virt::uart::Uart;

static TRIAL: TimerTrial<Timer, StepInterrupt> = TimerTrial::empty();

#[riscv_rt::core_interrupt(Interrupt::MachineTimer)]
fn on_compare() {
    // SAFETY: this is the step interrupt.
    unsafe { timer::visit(|| TRIAL.on_compare()) };
}

#[riscv_rt::entry]
fn main() -> ! {
    // SAFETY: each of them once; the interrupt is off at power-up.
    unsafe {
        let (timer, mut line) = (Timer::start(), Uart::start());
        // 1,000 ticks: the interrupt with its work.
        TRIAL.run(timer, 1_000, &mut line)
    }
}
