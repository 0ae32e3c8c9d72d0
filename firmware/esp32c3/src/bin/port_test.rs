//! Tests whether the step timer keeps the contract of `StepTimer`, and sends the result on the
//! line.
#![no_std]
#![no_main]

use esp_hal::uart::{Config, Uart as Driver};
use panic_halt as _;
use stepwright_controller::TimerTrial;
use stepwright_esp32c3::timer::{self, StepInterrupt, Timer};
use stepwright_esp32c3::uart::Uart;

static TRIAL: TimerTrial<Timer, StepInterrupt> = TimerTrial::empty();

#[esp_hal::handler]
fn on_compare() {
    // SAFETY: this is the step interrupt.
    unsafe { TRIAL.on_compare() };
}

#[esp_hal::main]
fn main() -> ! {
    let chip = esp_hal::init(esp_hal::Config::default());
    let line = Driver::new(chip.UART0, Config::default()).expect("115200 baud");
    let mut line = Uart::new(line.with_tx(chip.GPIO21).with_rx(chip.GPIO20));
    let timer = timer::start(chip.SYSTIMER, on_compare);
    // 1,000 ticks: the interrupt with its work.
    // SAFETY: once; the interrupt has been held off since the timer's start.
    unsafe { TRIAL.run(timer, 1_000, &mut line) }
}
