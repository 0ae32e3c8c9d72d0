//! The controller: it takes lines, and moves three motors.
#![no_std]
#![no_main]

use esp_hal::gpio::Level;
use esp_hal::uart::{Config, Uart as Driver};
use panic_halt as _;
use stepwright_controller::ControllerEngine;
use stepwright_esp32c3::board::BOARD;
use stepwright_esp32c3::pins::{BoardPins, StepPins, output};
use stepwright_esp32c3::timer::{self, StepInterrupt, Timer};
use stepwright_esp32c3::uart::Uart;

static ENGINE: ControllerEngine<Timer, StepPins, StepInterrupt> = ControllerEngine::empty();

#[esp_hal::handler]
fn on_compare() {
    // SAFETY: this is the step interrupt.
    unsafe { ENGINE.on_compare() };
}

#[esp_hal::main]
fn main() -> ! {
    let chip =
        esp_hal::init(esp_hal::Config::default().with_cpu_clock(esp_hal::clock::CpuClock::max()));
    // STEP, and DIR.
    output(chip.GPIO4, Level::Low);
    output(chip.GPIO5, Level::Low);
    output(chip.GPIO6, Level::Low);
    output(chip.GPIO0, Level::Low);
    output(chip.GPIO1, Level::Low);
    output(chip.GPIO2, Level::Low);
    // The drivers are off.
    output(chip.GPIO7, Level::High);
    let line = Driver::new(chip.UART0, Config::default()).expect("115200 baud");
    let mut line = Uart::new(line.with_tx(chip.GPIO21).with_rx(chip.GPIO20));
    let timer = timer::start(chip.SYSTIMER, on_compare);
    // SAFETY: once.
    let pins = unsafe { StepPins::new() };
    stepwright_controller::run(&ENGINE, timer, pins, BOARD, BoardPins::new(chip.GPIO10), &mut line)
}
