//! Plays seeded orders, reads back its own STEP, and sends a line that `stepwright selftest`
//! checks. The processor stamps each pulse as it raises it, and reads the pin back; no wire is
//! needed.
#![no_std]
#![no_main]

use stepwright::{Board, SharedEngine};
use stepwright_controller::{AXES, RUNS, StampedPins};
use stepwright_selftest::STM32F411;
use stepwright_stm32f4::chip::Chip;
use stepwright_stm32f4::pins::{self, Port};
use stepwright_stm32f4::timer::{self, StepInterrupt, Timer};
use stepwright_stm32f4::uart::{self, Uart};
use stm32f4xx_hal::interrupt;

const BOARD: Board<AXES> = STM32F411.board();

static ENGINE: SharedEngine<Timer, StampedPins<Port>, StepInterrupt, AXES, RUNS> =
    SharedEngine::empty();

#[interrupt]
fn TIM2() {
    // SAFETY: this is the step interrupt.
    unsafe { ENGINE.on_compare() };
}

#[interrupt]
fn USART2() {
    // SAFETY: this is the line's interrupt.
    unsafe { uart::on_receive() };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    if let Some(chip) = Chip::take() {
        let steps = pins::start_pins(&chip.port);
        let (timer, mut line) = (timer::start(chip.timer), Uart::start(chip.line));
        stepwright_controller::run_stamped(&ENGINE, timer, steps, &STM32F411, BOARD, &mut line)
    }
    // No program takes the chip twice.
    loop {
        cortex_m::asm::wfe();
    }
}
