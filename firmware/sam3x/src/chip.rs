//! Clocks, peripherals and priorities, according to the SAM3X's datasheet and ARM's manual of the
//! core.

use stepwright_controller::Register;

use crate::vectors::{TC0_NUMBER, UART_NUMBER};

/// A register.
pub(crate) const fn register(address: usize) -> Register {
    // SAFETY: every address in this crate is that of a register, in the datasheet's tables.
    unsafe { Register::at(address) }
}

/// The power management controller.
const fn power(offset: usize) -> Register {
    register(0x400E_0600 + offset)
}

const OSCILLATOR: Register = power(0x20);
const PLL: Register = power(0x28);
const CLOCK: Register = power(0x30);
const STATE: Register = power(0x68);

/// A higher number is less urgent.
const STEP_PRIORITY: u8 = 0x80;
const LINE_PRIORITY: u8 = 0xC0;

fn until(bit: u32) {
    while STATE.read() >> bit & 1 == 0 {}
}

/// Runs the processor at 84 MHz from a crystal of 12 MHz, switches on the used peripherals, and
/// sets the priorities of both interrupts.
///
/// # Safety
/// Called once, first.
pub unsafe fn start() {
    // Four wait states of both banks of flash.
    register(0x400E_0A00).write(4 << 8);
    register(0x400E_0C00).write(4 << 8);
    // The crystal, 15.6 ms to start at most; then it clocks the processor.
    let key = 0x37 << 16;
    OSCILLATOR.write(key | 8 << 8 | 1 << 3 | 1);
    until(0);
    OSCILLATOR.write(key | 1 << 24 | 8 << 8 | 1 << 3 | 1);
    until(16);
    CLOCK.write(CLOCK.read() & !3 | 1);
    until(3);
    // 12 MHz · 14 / 2.
    PLL.write(1 << 29 | 13 << 16 | 0x3F << 8 | 1);
    until(1);
    CLOCK.write(1 << 4 | 1);
    until(3);
    CLOCK.write(1 << 4 | 2);
    until(3);
    // The line, ports A and C, the timer's first channel.
    power(0x10).write(1 << UART_NUMBER | 1 << 11 | 1 << 13 | 1 << TC0_NUMBER);
    for (number, priority) in [(TC0_NUMBER, STEP_PRIORITY), (UART_NUMBER, LINE_PRIORITY)] {
        // SAFETY: NVIC_IPR, a byte for each interrupt; neither is enabled yet.
        unsafe { ((0xE000_E400 + number) as *mut u8).write_volatile(priority) };
    }
}

/// Enables an interrupt. It still has to pass the priority mask.
pub(crate) fn let_in(number: usize) {
    register(0xE000_E100).write(1 << number);
}

/// Requests an interrupt.
#[inline(always)]
pub(crate) fn pend(number: usize) {
    register(0xE000_E200).write(1 << number);
}

/// Holds off the step interrupt, and the line's, which is less urgent.
#[inline(always)]
pub(crate) fn hold() {
    // SAFETY: it only masks more; `release` unmasks the same interrupts.
    unsafe { cortex_m::register::basepri::write(STEP_PRIORITY) };
    cortex_m::asm::isb();
}

/// Releases the interrupts.
#[inline(always)]
pub(crate) fn release() {
    // SAFETY: nothing else uses the priority mask.
    unsafe { cortex_m::register::basepri::write(0) };
    cortex_m::asm::isb();
}
