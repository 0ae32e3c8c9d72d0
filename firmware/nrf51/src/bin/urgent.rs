//! The controller beside a program's own interrupt that is more urgent than the step interrupt: it
//! measures how long that interrupt waits. QEMU's plugin sees each wait as a store.
#![no_std]
#![no_main]

use stepwright_controller::{ControllerEngine, Register};
use stepwright_nrf51::board::BOARD;
use stepwright_nrf51::pins::{BoardPins, StepPins};
use stepwright_nrf51::timer::{StepInterrupt, Timer};
use stepwright_nrf51::uart::{self, Uart};
use stepwright_nrf51::vectors::TIMER1_NUMBER;

#[path = "../../../qemu/chip/waits.rs"]
mod waits;

use waits::Waits;

static ENGINE: ControllerEngine<Timer, StepPins, StepInterrupt> = ControllerEngine::empty();

#[unsafe(no_mangle)]
static WAITS: Waits = Waits::new();

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

/// A register of TIMER1.
const fn timer(offset: usize) -> Register {
    // SAFETY: the manual's table of TIMER.
    unsafe { Register::at(0x4000_9000 + offset) }
}

const COMPARED: Register = timer(0x140);
const COMPARE: Register = timer(0x540);
const CAPTURED: Register = timer(0x544);

/// The program's own interrupt. Its priority is that of a reset: the most urgent.
#[unsafe(no_mangle)]
extern "C" fn TIMER1() {
    timer(0x044).write(1); // // captures the counter
    let now = CAPTURED.read();
    // 16 bits.
    WAITS.tell(now.wrapping_sub(COMPARE.read()) & 0xFFFF);
    COMPARE.write(now.wrapping_add(400 + WAITS.luck(12)) & 0xFFFF);
    COMPARED.write(0);
}

/// Starts TIMER1 without a prescaler: 16 bits, 16 MHz.
fn start_urgent() {
    timer(0x508).write(0);
    timer(0x510).write(0);
    COMPARE.write(1_000);
    timer(0x304).write(1 << 16);
    timer(0x000).write(1);
    // SAFETY: ISER; the interrupt uses only its timer and `WAITS`.
    unsafe { Register::at(0xE000_E100) }.write(1 << TIMER1_NUMBER);
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: each of them once.
    let (timer, pins, panel, mut line) =
        unsafe { (Timer::start(), StepPins::new(), BoardPins::new(), Uart::start()) };
    start_urgent();
    stepwright_controller::run(&ENGINE, timer, pins, BOARD, panel, &mut line)
}
