//! Clocks, resets, the time, and the functions of pins, according to the RP2040's datasheet.

use stepwright_controller::Register;
use stepwright_device::Reset;

use crate::board::LASER;

/// A register.
const fn register(address: usize) -> Register {
    // SAFETY: every address below is that of a register, in the datasheet's tables.
    unsafe { Register::at(address) }
}

/// The offset of the alias that sets a register's bits atomically; [`CLEAR`] clears them.
pub const SET: usize = 0x2000;
/// See [`SET`].
pub const CLEAR: usize = 0x3000;

const RESETS: usize = 0x4000_C000;
const CLOCKS: usize = 0x4000_8000;
const XOSC: usize = 0x4002_4000;
const PLL: usize = 0x4002_8000;
const PLL_USB: usize = 0x4002_C000;
const WATCHDOG: usize = 0x4005_8000;
const TIMER: usize = 0x4005_4000;
const VOLTAGE: usize = 0x4006_4000;
const PINS: usize = 0x4001_4000;
const PADS: usize = 0x4001_C000;
/// Slice 0, whose output A is GPIO 16.
const PWM: usize = 0x4005_0000;

/// Pins, pads, PIO 0, PLL, timer, UART 0.
const USED: u32 = 1 << 5 | 1 << 8 | 1 << 10 | 1 << 12 | 1 << 21 | 1 << 22;
const AFTER_CLOCKS: u32 = 1 << 22;

/// Waits until these bits of a register are set.
fn until(register: Register, bits: u32) {
    while register.read() & bits != bits {}
}

/// Runs the processor at 125 MHz from a crystal of 12 MHz, and takes the used peripherals out of
/// reset.
///
/// # Safety
/// Called once, first.
pub unsafe fn start() {
    register(RESETS + CLEAR).write(USED & !AFTER_CLOCKS);
    until(register(RESETS + 8), USED & !AFTER_CLOCKS);
    // The crystal needs 1 ms to start.
    register(XOSC + 0x0C).write(47);
    register(XOSC).write(0xFAB << 12 | 0xAA0);
    until(register(XOSC + 4), 1 << 31);
    // The reference clock, and meanwhile the processor's, come from the crystal.
    register(CLOCKS + 0x30).write(2);
    until(register(CLOCKS + 0x38), 1 << 2);
    register(CLOCKS + 0x3C + CLEAR).write(1);
    until(register(CLOCKS + 0x44), 1);
    // 12 MHz · 125 / 6 / 2.
    register(PLL).write(1);
    register(PLL + 8).write(125);
    register(PLL + 4 + CLEAR).write(1 << 0 | 1 << 5);
    until(register(PLL), 1 << 31);
    register(PLL + 0xC).write(6 << 16 | 2 << 12);
    register(PLL + 4 + CLEAR).write(1 << 3);
    register(CLOCKS + 0x3C).write(0);
    register(CLOCKS + 0x3C).write(1);
    until(register(CLOCKS + 0x44), 1 << 1);
    // The UART's clock is the processor's.
    register(CLOCKS + 0x48).write(1 << 11);
    register(RESETS + CLEAR).write(AFTER_CLOCKS);
    until(register(RESETS + 8), AFTER_CLOCKS);
    // The timer counts microseconds.
    register(WATCHDOG + 0x2C).write(1 << 9 | 12);
}

/// Gives the USB controller its 48 MHz, and takes it out of reset.
///
/// # Safety
/// Called once, after [`start`].
pub unsafe fn start_usb() {
    register(RESETS + CLEAR).write(1 << 13);
    until(register(RESETS + 8), 1 << 13);
    // 12 MHz · 120 / 6 / 5.
    register(PLL_USB).write(1);
    register(PLL_USB + 8).write(120);
    register(PLL_USB + 4 + CLEAR).write(1 << 0 | 1 << 5);
    until(register(PLL_USB), 1 << 31);
    register(PLL_USB + 0xC).write(6 << 16 | 5 << 12);
    register(PLL_USB + 4 + CLEAR).write(1 << 3);
    register(CLOCKS + 0x54).write(1 << 11);
    register(RESETS + CLEAR).write(1 << 24);
    until(register(RESETS + 8), 1 << 24);
}

/// Starts PWM at 7.8 kHz on [`LASER`], with duty 0. Before that the pad's pull-down, which is on
/// after each reset, keeps the pin low.
///
/// # Safety
/// Called once, after [`start`].
pub unsafe fn start_laser() {
    const SLICE: u32 = 1 << 14;
    register(RESETS + CLEAR).write(SLICE);
    until(register(RESETS + 8), SLICE);
    // 125 MHz / 63 / 255.
    register(PWM + 4).write(63 << 4);
    register(PWM + 0x10).write(254);
    set_duty(0);
    register(PWM).write(1);
    give(LASER, Function::Pulses, false);
}

/// Sets the duty of [`LASER`], in 255ths, from the next period on.
pub fn set_duty(duty: u8) {
    register(PWM + 0xC).write(duty.into());
}

/// Takes the second PIO and the DMA out of reset.
///
/// # Safety
/// Called once, after [`start`].
pub unsafe fn start_capture() {
    const BOTH: u32 = 1 << 11 | 1 << 2;
    register(RESETS + CLEAR).write(BOTH);
    until(register(RESETS + 8), BOTH);
}

/// The processor's clock in kHz, measured by the timer, which counts the crystal's microseconds.
pub fn khz() -> u32 {
    const MICROS: u32 = 10_000;
    // SysTick, at the processor's clock, counts down 24 bits: 134 ms.
    let (control, reload, count) = (0xE000_E010, 0xE000_E014, 0xE000_E018);
    register(reload).write(0x00FF_FFFF);
    register(count).write(0);
    register(control).write(1 << 2 | 1);
    let edge = || {
        let now = micros_low();
        while micros_low() == now {}
        (micros_low(), register(count).read())
    };
    let (begun, first) = edge();
    while micros_low().wrapping_sub(begun) < MICROS {}
    let (ended, last) = edge();
    let cycles = first.wrapping_sub(last) & 0x00FF_FFFF;
    let micros = ended.wrapping_sub(begun);
    // Rounded: the 1,250,000 cycles are accurate to about ten.
    (cycles.saturating_mul(1_000).wrapping_add(micros / 2)).checked_div(micros).unwrap_or(0)
}

/// Microseconds since the start.
#[inline(always)]
pub fn micros() -> u64 {
    let mut high = register(TIMER + 0x24).read();
    loop {
        let low = register(TIMER + 0x28).read();
        let again = register(TIMER + 0x24).read();
        if again == high {
            return u64::from(high) << 32 | u64::from(low);
        }
        high = again;
    }
}

/// The low half of the microseconds.
#[inline(always)]
pub fn micros_low() -> u32 {
    register(TIMER + 0x28).read()
}

/// The function of a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    /// The serial line.
    Uart = 2,
    /// The pulses of a laser.
    Pulses = 4,
    /// A pin that the program sets or reads.
    Program = 5,
    /// The first PIO.
    Pio = 6,
}

/// Selects the function of a pin; its output is `inverted` if true.
pub fn give(pin: u32, function: Function, inverted: bool) {
    let control = PINS + 4 + 8 * pin as usize;
    register(control).write(function as u32 | u32::from(inverted) << 8);
}

/// Switches a pin's pull-up on or off.
pub fn pull_up(pin: u32, up: bool) {
    // An input with a Schmitt trigger, 4 mA.
    register(PADS + 4 + 4 * pin as usize).write(0x52 | u32::from(up) << 3);
}

/// The levels of all pins.
#[inline(always)]
pub fn levels() -> u32 {
    register(0xD000_0004).read()
}

/// Sets the level of a pin with [`Function::Program`].
pub fn set_level(pin: u32, high: bool) {
    register(if high { 0xD000_0014 } else { 0xD000_0018 }).write(1 << pin);
}

/// Makes a pin with [`Function::Program`] an output.
pub fn make_output(pin: u32) {
    register(0xD000_0024).write(1 << pin);
}

/// Starts the watchdog: 250 ms.
pub fn start_watchdog() {
    // It resets everything except the oscillators.
    register(0x4001_0008).write(0x1_FFFC);
    feed();
    register(WATCHDOG).write(1 << 30 | 7 << 24);
}

/// Feeds the watchdog. (It counts down twice a microsecond: erratum RP2040-E1.)
pub fn feed() {
    register(WATCHDOG + 4).write(500_000);
}

/// The reason of the last reset. The chip does not distinguish a brown-out from power-up.
pub fn reset() -> Reset {
    // REASON: the watchdog's timer, or a reset that a program forced through it. A reset of the
    // whole chip clears both, and CHIP_RESET distinguishes these: HAD_POR, RUN (the button), or the
    // debugger.
    match register(WATCHDOG + 8).read() & 3 {
        0 if register(VOLTAGE + 8).read() >> 8 & 1 != 0 => Reset::Power,
        0 | 2 => Reset::Other,
        _ => Reset::Watchdog,
    }
}
