//! The timed driver over the serial line: orders, wirings and questions by
//! `stepwright timed --port`, or by whoever writes the lines of `stepwright_timed::line`.
//!
//! An Uno has one motor, on timer 1; a Mega has four, on its timers 1, 3, 4 and 5. Each is on any
//! pins of any one port, but for the serial line's.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use core::array::IntoIter;
use core::iter::Skip;

use stepwright_avr::chip;
use stepwright_avr::console::{Console, Digits};
use stepwright_avr::timed::{AnyPort, AvrEngine, Timer, Timer1, Windings, io_clock_now, shield};
#[cfg(feature = "mega")]
use stepwright_avr::timed::{Timer3, Timer4, Timer5};
use stepwright_protocol::{bare, crc, hex};
use stepwright_timed::fit::Hardware;
use stepwright_timed::line::{LONGEST, Line, NAME, Report, Wire};
use stepwright_timed::{Call, Code, Control, Driver, Model, SetSpeed};

macro_rules! motor {
    ($name:ident, $timer:ident, $vector:ident) => {
        mod $name {
            use stepwright::drive::sequence::SHIELD;
            use stepwright_avr::slot::Slot;
            use stepwright_avr::timed::{AnyPort, AvrEngine, Motor, Timer, $timer};

            static MOTOR: Slot<Motor<AnyPort>> = Slot::new(Motor::new(AnyPort::NONE));

            stepwright_avr::handler!($vector, $vector, {
                // SAFETY: the interrupt that owns them; it comes with interrupts off.
                unsafe { MOTOR.get().on_compare(&mut $timer::steal()) };
            });

            /// Takes the motor, which has no pins yet.
            ///
            /// # Safety
            /// To be called once, with interrupts off.
            pub unsafe fn take() -> AvrEngine<AnyPort, $timer> {
                // SAFETY: the caller's promise; it is this timer's interrupt.
                unsafe { AvrEngine::new(&MOTOR, AnyPort::NONE, SHIELD, 0, 0) }
            }
        }
    };
}

motor!(first, Timer1, TIMER1_COMPA);
#[cfg(feature = "mega")]
motor!(third, Timer3, TIMER3_COMPA);
#[cfg(feature = "mega")]
motor!(fourth, Timer4, TIMER4_COMPA);
#[cfg(feature = "mega")]
motor!(fifth, Timer5, TIMER5_COMPA);

#[cfg(feature = "mega")]
const ABOUT: &str = " mega hz=";
#[cfg(feature = "uno")]
const ABOUT: &str = " uno hz=";
#[cfg(feature = "mega")]
const TIMERS: &str = " timers=1,3,4,5";
#[cfg(feature = "uno")]
const TIMERS: &str = " timers=1";

/// A motor and its driver.
struct Station<T: Timer> {
    held: AvrEngine<AnyPort, T>,
    driver: Driver,
    /// Its own among the motors that share a shield's enables.
    bit: u8,
    /// It has pins.
    wired: bool,
    /// From check to check of the main program, in ms; 0: none.
    check: u16,
    /// When it was checked last, on the board's clock.
    checked: u32,
    /// The call on the board's clock, and what the caller's shows then.
    call: u32,
    shown: u32,
    reached: Option<u32>,
    fault: Option<u32>,
}

impl<T: Timer> Station<T> {
    fn new(held: AvrEngine<AnyPort, T>, bit: u8) -> Station<T> {
        Station {
            held,
            driver: Driver::new(Hardware::avr16(io_clock_now()), Model::Ideal),
            bit,
            wired: false,
            check: 0,
            checked: 0,
            call: 0,
            shown: 0,
            reached: None,
            fault: None,
        }
    }

    /// The caller's clock.
    fn caller(&self, now: u32) -> u32 {
        now.wrapping_sub(self.call).wrapping_add(self.shown)
    }

    /// Does what a line says, and answers; a report goes to `answer`.
    #[inline(never)]
    fn obey(&mut self, line: &Line, voice: &mut Voice, answer: &mut Answer) {
        let now = voice.console.millis();
        let done = match line {
            Line::Wire(_, wire) => self.wire(wire),
            Line::Latched(_, latched) => {
                let model = if *latched { Model::Latched } else { Model::Ideal };
                let rests = !self.held.is_moving();
                if rests {
                    self.driver = Driver::new(*self.driver.hardware(), model);
                }
                rests
            }
            Line::Check(_, ms) => {
                self.check = *ms;
                true
            }
            Line::Move(_, order, shown) => return self.order(order, *shown, now, voice),
            Line::Look(_) => return *answer = Answer::of(&self.look(now), voice.sum.take()),
            Line::Info => false,
        };
        voice.text(if done { "Y" } else { "E" });
    }

    fn wire(&mut self, wire: &Wire) -> bool {
        if self.held.is_moving() {
            return false;
        }
        let Some(port) = AnyPort::of(wire.port, wire.mask) else { return false };
        if wire.shield {
            shield::pins();
        }
        let bit = if wire.shield { self.bit } else { 0 };
        self.held.rewire(port, wire.sequence, wire.mask, bit);
        self.held.restore(wire.phase);
        self.wired = true;
        true
    }

    /// Begins as a millisecond does, so that the checks come whole milliseconds after the call.
    fn order(&mut self, order: &SetSpeed, shown: u32, now: u32, voice: &mut Voice) {
        let now = now.wrapping_add(1);
        voice.console.wait_until(now);
        (self.call, self.shown, self.checked) = (now, shown, now);
        (self.reached, self.fault) = (None, None);
        let code = if self.wired || order.top == 0 || !order.control.has(Control::DRV_EN) {
            self.driver.set_speed(&mut self.held, order, shown)
        } else {
            Code::NOT_WIRED
        };
        let code = code.get();
        if code < 0 {
            voice.text("-");
        }
        voice.number(code.unsigned_abs().into());
    }

    fn look(&mut self, now: u32) -> Report {
        let phase = self.held.phase();
        let dump = self.driver.dump(&mut self.held, phase);
        Report {
            ms: now.wrapping_sub(self.call),
            dump,
            moving: self.held.is_moving(),
            reached: self.reached,
            fault: self.fault,
        }
    }

    /// The main program's check, when it is due.
    fn poll(&mut self, now: u32) {
        if self.check == 0 || now.wrapping_sub(self.checked) < self.check.into() {
            return;
        }
        self.checked = self.checked.wrapping_add(self.check.into());
        let at = self.checked.wrapping_sub(self.call);
        let time = self.caller(self.checked);
        let (reached, fault) = (&mut self.reached, &mut self.fault);
        self.driver.update_check(&mut self.held, time, |call| match call {
            Call::Reached => *reached = Some(at),
            Call::Fault => *fault = Some(at),
        });
    }
}

/// A line as it comes.
struct Text {
    bytes: [u8; LONGEST],
    length: usize,
    /// A byte was damaged, or there were too many.
    bad: bool,
}

impl Text {
    /// Takes a byte; true at the end of a line.
    fn take(&mut self, byte: Option<u8>) -> bool {
        match byte {
            Some(b'\r') => return true,
            // Between two lines; within one it is a damaged byte.
            Some(b'\n') if self.length == 0 => {}
            Some(b'\n') => self.bad = true,
            Some(byte) => match self.bytes.get_mut(self.length) {
                Some(place) => {
                    *place = byte;
                    self.length = self.length.wrapping_add(1);
                }
                None => self.bad = true,
            },
            None => self.bad = true,
        }
        false
    }

    /// The line, whether it was marked as one with a checksum, and begins the next one. `Err`:
    /// its checksum is that of another line.
    #[inline(never)]
    fn line(&mut self) -> (Result<Option<Line>, ()>, bool) {
        let text = self.bytes.get(..self.length).unwrap_or_default();
        let text = if self.bad { &[] } else { text };
        let line = bare(text).map(|(line, _)| Line::read(line)).ok_or(());
        let marked = text.contains(&b'*');
        (self.length, self.bad) = (0, false);
        (line, marked)
    }
}

/// What answers a line: with its checksum, if the line had one.
struct Voice<'c> {
    console: &'c mut Console,
    /// That of what was said.
    sum: Option<u8>,
}

impl Voice<'_> {
    fn byte(&mut self, byte: u8) {
        self.sum = self.sum.map(|sum| crc(sum, byte));
        self.console.byte(byte);
    }

    fn text(&mut self, text: &str) {
        text.bytes().for_each(|byte| self.byte(byte));
    }

    fn number(&mut self, number: u32) {
        Digits::of(number).for_each(|digit| self.byte(digit));
    }

    /// The end of the answer.
    fn end(self) {
        tail(self.sum).for_each(|byte| self.console.byte(byte));
    }
}

/// The checksum of an answer, if it has one, and its end.
fn tail(sum: Option<u8>) -> Skip<IntoIter<u8, 4>> {
    let value = sum.unwrap_or(0);
    let tail = [b'*', hex(value >> 4), hex(value), b'\r'];
    tail.into_iter().skip(if sum.is_some() { 0 } else { 3 })
}

/// A report on its way to the line, byte by byte: whole, it takes 5 ms, and checks are due
/// meanwhile.
struct Answer {
    numbers: [u32; Report::NUMBERS],
    /// Numbers that have begun.
    begun: usize,
    digits: Option<Digits>,
    /// The checksum so far, if it is to have one.
    sum: Option<u8>,
    tail: Option<Skip<IntoIter<u8, 4>>>,
}

impl Answer {
    /// Nothing to be sent.
    const SENT: Answer =
        Answer { numbers: [0; Report::NUMBERS], begun: 0, digits: None, sum: None, tail: None };

    fn of(report: &Report, sum: Option<u8>) -> Answer {
        let numbers = report.numbers();
        let digits = numbers.first().map(|first| Digits::of(*first));
        Answer { numbers, begun: 1, digits, sum, tail: None }
    }

    /// The byte that follows.
    #[inline(never)]
    fn next(&mut self) -> Option<u8> {
        if let Some(tail) = &mut self.tail {
            return tail.next();
        }
        let byte = match self.digits.as_mut()?.next() {
            Some(digit) => digit,
            None => {
                self.digits = self.numbers.get(self.begun).map(|number| Digits::of(*number));
                self.begun = self.begun.wrapping_add(1);
                if self.digits.is_none() {
                    return self.tail.insert(tail(self.sum)).next();
                }
                b','
            }
        };
        self.sum = self.sum.map(|sum| crc(sum, byte));
        Some(byte)
    }
}

/// All motors.
struct Motors {
    first: Station<Timer1>,
    #[cfg(feature = "mega")]
    third: Station<Timer3>,
    #[cfg(feature = "mega")]
    fourth: Station<Timer4>,
    #[cfg(feature = "mega")]
    fifth: Station<Timer5>,
}

impl Motors {
    /// Checks those that are due.
    #[inline(never)]
    fn poll(&mut self, now: u32) {
        self.first.poll(now);
        #[cfg(feature = "mega")]
        {
            self.third.poll(now);
            self.fourth.poll(now);
            self.fifth.poll(now);
        }
    }

    /// Does what a line says, and answers.
    #[inline(never)]
    fn obey(&mut self, line: Option<Line>, voice: &mut Voice, answer: &mut Answer) {
        let Some(line) = line else { return voice.text("E") };
        match line.timer() {
            0 => about(voice),
            1 => self.first.obey(&line, voice, answer),
            #[cfg(feature = "mega")]
            3 => self.third.obey(&line, voice, answer),
            #[cfg(feature = "mega")]
            4 => self.fourth.obey(&line, voice, answer),
            #[cfg(feature = "mega")]
            5 => self.fifth.obey(&line, voice, answer),
            _ => voice.text("E"),
        }
    }
}

/// What the board is.
fn about(voice: &mut Voice) {
    voice.text(NAME);
    voice.text(ABOUT);
    voice.number(io_clock_now());
    voice.text(TIMERS);
}

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: called once each, with interrupts off.
    let mut motors = unsafe {
        Motors {
            first: Station::new(first::take(), 1),
            #[cfg(feature = "mega")]
            third: Station::new(third::take(), 2),
            #[cfg(feature = "mega")]
            fourth: Station::new(fourth::take(), 4),
            #[cfg(feature = "mega")]
            fifth: Station::new(fifth::take(), 8),
        }
    };
    serve(&mut motors)
}

/// Hears lines for ever.
#[inline(never)]
fn serve(motors: &mut Motors) -> ! {
    // SAFETY: the only time that anybody takes them, and interrupts are off.
    let chip = unsafe { chip::Peripherals::steal() };
    let mut console = Console::start(chip.USART0, chip.TC0);
    let mut text = Text { bytes: [0; LONGEST], length: 0, bad: false };
    // SAFETY: all that an interrupt touches has been made.
    unsafe { avr_device::interrupt::enable() };
    let mut answer = Answer::SENT;
    loop {
        motors.poll(console.millis());
        if console.is_free()
            && let Some(byte) = answer.next()
        {
            console.byte(byte);
        }
        if let Some(byte) = console.received()
            && text.take(byte)
        {
            let (line, marked) = text.line();
            // Whoever did not wait for an answer has it whole all the same.
            while let Some(byte) = answer.next() {
                console.byte(byte);
            }
            let mut voice = Voice { console: &mut console, sum: marked.then_some(0) };
            match line {
                Ok(line) => motors.obey(line, &mut voice, &mut answer),
                Err(()) => voice.text("E sum"),
            }
            // A report goes by itself.
            if answer.digits.is_none() {
                voice.end();
            }
        }
    }
}
