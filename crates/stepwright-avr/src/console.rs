//! The serial line and the milliseconds without an interrupt, so that nothing delays a step's edge.
//!
//! Sending waits for the line and reads the clock meanwhile.

use stepwright_device::main_loop::{Received, SerialPort};
use stepwright_timed::{Code, Dump, Field};

use crate::chip::{TC0, USART0};
use crate::clock::Millis;

/// 16 MHz / 8 / 115200 − 1.
const DIVISOR: u16 = 16;

/// The decimal digits of a number, computed one after another without a division, which a small
/// chip lacks.
pub struct Digits {
    rest: u32,
    units: core::slice::Iter<'static, u32>,
    /// A digit was returned: zeros are significant from now on.
    begun: bool,
}

impl Digits {
    /// The digits of `number`.
    pub fn of(number: u32) -> Digits {
        const UNITS: &[u32] = &[
            1_000_000_000,
            100_000_000,
            10_000_000,
            1_000_000,
            100_000,
            10_000,
            1_000,
            100,
            10,
            1,
        ];
        Digits { rest: number, units: UNITS.iter(), begun: false }
    }
}

impl Iterator for Digits {
    type Item = u8;
    fn next(&mut self) -> Option<u8> {
        loop {
            let unit = *self.units.next()?;
            let mut digit = b'0';
            while self.rest >= unit {
                self.rest = self.rest.wrapping_sub(unit);
                digit = digit.wrapping_add(1);
            }
            self.begun |= digit != b'0' || unit == 1;
            if self.begun {
                return Some(digit);
            }
        }
    }
}

/// The serial line at 115200 baud, polled: a byte must be read within 170 µs while a line arrives.
pub struct PolledLine(USART0);

impl PolledLine {
    /// Sets up the line.
    pub fn start(usart: USART0) -> PolledLine {
        usart.ucsr0a().write(|w| w.u2x0().set_bit());
        usart.ubrr0().write(|w| w.set(DIVISOR));
        usart.ucsr0c().write(|w| w.ucsz0().chr8());
        usart.ucsr0b().write(|w| w.txen0().set_bit().rxen0().set_bit());
        PolledLine(usart)
    }

    /// Whether the receiver's interrupt is enabled.
    pub fn interrupts(&self) -> bool {
        self.0.ucsr0b().read().rxcie0().bit_is_set()
    }

    /// Enables the receiver's interrupt, which reads bytes with [`received`].
    pub fn interrupt(&mut self) {
        self.0.ucsr0b().modify(|_, w| w.rxcie0().set_bit());
    }
}

/// The next received byte, or its error, if there is one.
#[inline(always)]
pub fn received(usart: &USART0) -> Option<Received> {
    let status = usart.ucsr0a().read();
    if status.rxc0().bit_is_clear() {
        return None;
    }
    let whole = status.fe0().bit_is_clear() && status.dor0().bit_is_clear();
    let byte = usart.udr0().read().bits();
    Some(if whole { Received::Byte(byte) } else { Received::Garbled })
}

impl SerialPort for PolledLine {
    #[inline(always)]
    fn receive(&mut self) -> Option<Received> {
        received(&self.0)
    }

    #[inline(always)]
    fn has_room(&self) -> bool {
        self.0.ucsr0a().read().udre0().bit_is_set()
    }

    #[inline(always)]
    fn send(&mut self, byte: u8) {
        // SAFETY: sending a byte affects no memory.
        self.0.udr0().write(|w| unsafe { w.bits(byte) });
    }
}

/// The line and the clock.
pub struct Console {
    line: PolledLine,
    clock: Millis,
}

impl Console {
    /// Starts the line at 115200 baud, and the clock at 0.
    pub fn start(usart: USART0, timer: TC0) -> Console {
        Console { line: PolledLine::start(usart), clock: Millis::start(timer) }
    }

    /// The milliseconds since the start. Call it at least every 16 ms.
    pub fn millis(&mut self) -> u32 {
        self.clock.get()
    }

    /// Waits until the clock reaches `millis`.
    pub fn wait_until(&mut self, millis: u32) {
        self.clock.wait_until(millis);
    }

    /// Sends a byte, after waiting for room.
    pub fn byte(&mut self, byte: u8) {
        while !self.line.has_room() {
            self.millis();
        }
        self.line.send(byte);
    }

    /// Sends a text.
    pub fn text(&mut self, text: &str) {
        text.bytes().for_each(|byte| self.byte(byte));
    }

    /// Sends a text as a line.
    pub fn line(&mut self, text: &str) {
        self.text(text);
        self.text("\r\n");
    }

    /// Sends a number in decimal digits.
    pub fn number(&mut self, number: u32) {
        Digits::of(number).for_each(|digit| self.byte(digit));
    }

    /// Sends a position in decimal digits.
    pub fn position(&mut self, position: i64) {
        if position < 0 {
            self.byte(b'-');
        }
        let mut digits = [b'0'; 20];
        let (mut rest, mut count) = (position.unsigned_abs(), 0);
        for digit in &mut digits {
            *digit = b'0' + (rest % 10) as u8;
            (rest, count) = (rest / 10, count + 1);
            if rest == 0 {
                break;
            }
        }
        digits.iter().take(count).rev().for_each(|digit| self.byte(*digit));
    }

    /// Sends two hexadecimal digits.
    fn hex(&mut self, byte: u8) {
        for digit in [byte >> 4, byte & 0x0F] {
            self.byte(if digit < 10 { b'0' + digit } else { b'A' - 10 + digit });
        }
    }

    /// Prints the article's debug dump.
    pub fn dump(&mut self, dump: &Dump) {
        for (name, field) in dump.fields() {
            self.text(name);
            self.text(": ");
            match field {
                Field::Hex(byte) => {
                    self.text("0x");
                    self.hex(byte);
                }
                Field::Number(number) => self.number(number),
            }
            self.line("");
        }
    }

    /// Prints a `motorSetSpeed` as in the article.
    pub fn set_speed(&mut self, dump: &Dump, code: Code) {
        self.line(">>>motorSetSpeed");
        self.line(if cfg!(feature = "mega") { "Arduino Mega" } else { "Arduino Uno" });
        self.dump(dump);
        self.text("Exit Code: ");
        if code.is_error() {
            self.text("-");
        }
        self.hex(code.get().unsigned_abs());
        self.line("");
    }
}
