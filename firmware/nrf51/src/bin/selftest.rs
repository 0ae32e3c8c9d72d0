//! Plays seeded orders, reads back its own STEP, and sends a line that `stepwright selftest`
//! checks. The processor stamps each pulse as it raises it, and reads the pin back; no wire is
//! needed.
#![no_std]
#![no_main]

use stepwright::{Board, SharedEngine};
use stepwright_controller::{AXES, RUNS, StampedPins};
use stepwright_nrf51::pins::{self, Port, StepPins};
use stepwright_nrf51::timer::{StepInterrupt, Timer};
use stepwright_nrf51::uart::{self, Uart};
use stepwright_selftest::NRF51;

const BOARD: Board<AXES> = NRF51.board();

static ENGINE: SharedEngine<Timer, StampedPins<Port>, StepInterrupt, AXES, RUNS> =
    SharedEngine::empty();

#[unsafe(no_mangle)]
extern "C" fn TIMER0() {
    // SAFETY: this is the step interrupt.
    unsafe { ENGINE.on_compare() };
}

#[unsafe(no_mangle)]
extern "C" fn UART0() {
    // SAFETY: this is the line's interrupt.
    unsafe { uart::on_receive() };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: each of them once.
    let (timer, steps, mut line) = unsafe { (Timer::start(), StepPins::new(), Uart::start()) };
    pins::read_back();
    stepwright_controller::run_stamped(&ENGINE, timer, steps, &NRF51, BOARD, &mut line)
}
