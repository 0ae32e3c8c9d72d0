//! The timed driver over the serial line: orders, wirings and queries by `stepwright timed --port`,
//! or by any sender of the rows of `stepwright_timed::line`.
//!
//! An Uno has one motor, on timer 1; a Mega has four, on its timers 1, 3, 4 and 5. Each is on any
//! pins of one port, except the serial line's.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use stepwright_avr::chip;
use stepwright_avr::clock::Millis;
use stepwright_avr::console::PolledLine;
use stepwright_avr::timed::{AnyPort, AvrEngine, Timer1, io_clock_now};
#[cfg(feature = "mega")]
use stepwright_avr::timed::{Timer3, Timer4, Timer5};
use stepwright_device::ProgramDevice;
use stepwright_device::main_loop;
use stepwright_protocol::{BoardProgram, Fault, Numbers, Piece, Said, flash_text};
use stepwright_timed::TimedStation;
use stepwright_timed::fit::Hardware;
use stepwright_timed::line::{LONGEST, Line, Report, Unwired};

macro_rules! motor {
    ($name:ident, $timer:ident, $vector:ident) => {
        mod $name {
            use stepwright::drive::sequence::SHIELD;
            use stepwright_avr::slot::Slot;
            use stepwright_avr::timed::{AnyPort, AvrEngine, Motor, Timer, $timer};

            static MOTOR: Slot<Motor<AnyPort>> = Slot::new(Motor::new(AnyPort::NONE));

            stepwright_avr::handler!($vector, $vector, {
                // SAFETY: this is the interrupt that owns them; it runs with interrupts off.
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
const ABOUT: &str = "stepwright-timed mega hz=";
#[cfg(feature = "uno")]
const ABOUT: &str = "stepwright-timed uno hz=";
#[cfg(feature = "mega")]
const TIMERS: &str = " axes=0 can=sum timers=1,3,4,5";
#[cfg(feature = "uno")]
const TIMERS: &str = " axes=0 can=sum timers=1";

type Motor<T> = TimedStation<AvrEngine<AnyPort, T>>;

/// All motors, and the clock.
struct Motors {
    clock: Millis,
    /// The numbers of the last report.
    report: [u32; Report::NUMBERS],
    first: Motor<Timer1>,
    #[cfg(feature = "mega")]
    third: Motor<Timer3>,
    #[cfg(feature = "mega")]
    fourth: Motor<Timer4>,
    #[cfg(feature = "mega")]
    fifth: Motor<Timer5>,
}

/// Evaluates an expression for each motor.
macro_rules! each {
    ($motors:expr, $motor:ident => $what:expr) => {{
        let $motor = &mut $motors.first;
        $what;
        #[cfg(feature = "mega")]
        {
            let $motor = &mut $motors.third;
            $what;
            let $motor = &mut $motors.fourth;
            $what;
            let $motor = &mut $motors.fifth;
            $what;
        }
    }};
}

impl BoardProgram for Motors {
    type Row = Line;
    type Reason = Unwired;

    fn about(&mut self, n: u8) -> Option<Piece> {
        Some(match n {
            0 => Piece::Text(flash_text!(ABOUT)),
            1 => Piece::Number(io_clock_now()),
            2 => Piece::Text(flash_text!(TIMERS)),
            _ => return None,
        })
    }

    fn axes(&self) -> u8 {
        0
    }

    fn read(&self, letter: u8, numbers: &mut Numbers<'_>) -> Option<Line> {
        Line::read(letter, numbers)
    }

    #[inline(never)]
    fn carry_out(&mut self, line: &Line) -> Result<Said, Fault<Unwired>> {
        let mut now = self.clock.get();
        if matches!(line, Line::Move(..)) {
            // At the beginning of a millisecond.
            now = now.wrapping_add(1);
            self.clock.wait_until(now);
        }
        match line.timer() {
            1 => self.first.carry_out(line, now, &mut self.report),
            #[cfg(feature = "mega")]
            3 => self.third.carry_out(line, now, &mut self.report),
            #[cfg(feature = "mega")]
            4 => self.fourth.carry_out(line, now, &mut self.report),
            #[cfg(feature = "mega")]
            5 => self.fifth.carry_out(line, now, &mut self.report),
            _ => Err(Fault::Own(Unwired::Timer)),
        }
    }

    fn number(&mut self, n: u8) -> Option<i64> {
        self.report.get(usize::from(n)).map(|number| (*number).into())
    }

    fn is_busy(&mut self) -> bool {
        let mut busy = false;
        each!(self, station => busy |= station.motor().is_moving());
        busy
    }

    fn position(&mut self, _: u8) -> Option<i64> {
        None
    }

    fn set_zero(&mut self, _: u8) {}

    fn mark_unknown(&mut self) {}

    #[inline(never)]
    fn stop(&mut self) {
        let now = self.clock.get();
        each!(self, station => station.stop(now));
    }

    fn kill(&mut self) {
        self.stop();
    }

    /// Checks the motors that are due.
    #[inline(never)]
    fn poll(&mut self) {
        let now = self.clock.get();
        each!(self, station => station.poll(now));
    }
}

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: they are taken only here, and interrupts are off.
    let chip = unsafe { chip::Peripherals::steal() };
    let hardware = Hardware::avr16(io_clock_now());
    // SAFETY: called once each, with interrupts off.
    let motors = unsafe {
        Motors {
            clock: Millis::start(chip.TC0),
            report: [0; Report::NUMBERS],
            first: TimedStation::new(first::take(), hardware),
            #[cfg(feature = "mega")]
            third: TimedStation::new(third::take(), hardware),
            #[cfg(feature = "mega")]
            fourth: TimedStation::new(fourth::take(), hardware),
            #[cfg(feature = "mega")]
            fifth: TimedStation::new(fifth::take(), hardware),
        }
    };
    let (mut board, mut line) = (ProgramDevice::new(motors, ()), PolledLine::start(chip.USART0));
    serve(&mut board, &mut line)
}

/// Handles lines for ever.
#[inline(never)]
fn serve(board: &mut ProgramDevice<Motors, (), LONGEST>, line: &mut PolledLine) -> ! {
    // SAFETY: everything that an interrupt uses is set up.
    unsafe { avr_device::interrupt::enable() };
    main_loop::run(board, line)
}
