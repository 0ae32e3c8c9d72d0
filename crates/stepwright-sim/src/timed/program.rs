//! The program `timed` of a chip, on simulated pins: one motor, on timer 1.

use stepwright::drive::{Coils, Sequence};
use stepwright_protocol::{BoardProgram, Fault, Numbers, Piece, Said, flash_text};
use stepwright_timed::fit::Hardware;
use stepwright_timed::line::{LONGEST, Line, Report, Unwired, Wire};
use stepwright_timed::{TimedStation, WiredMotor};

use super::Motion;
use crate::pins::Lines;
use crate::program::{ProgramBoard, SimProgram};

/// Clocks of the timer in a millisecond.
const MILLIS: u64 = 16_000;

/// A virtual Uno that takes the rows of `stepwright_timed::line`.
///
/// ```
/// use stepwright_sim::timed::TimedLineBoard;
/// let mut board = TimedLineBoard::uno();
/// for byte in *b":W1,66,48,0,0,1,0,0,16,48,32\r:M1,128,32000,3,0,0,0,0\r" {
///     board.receive(byte);
/// }
/// assert_eq!(board.take_answers(), b"Y\r0\r");
/// board.run_until(board.now() + 16_000_000);
/// assert_eq!(board.program().steps().len(), 3);
/// ```
pub type TimedLineBoard = ProgramBoard<TimedMotor, LONGEST>;

impl TimedLineBoard {
    /// Switches a virtual Uno on.
    pub fn uno() -> TimedLineBoard {
        let coils = Coils::new(Lines::default(), stepwright::drive::sequence::SHIELD, 0);
        let station = TimedStation::new(Motion::new(coils), Hardware::avr16(16_000_000));
        ProgramBoard::of(TimedMotor { station, report: [0; Report::NUMBERS] }, MILLIS / 4)
    }
}

/// A motor, its driver and the numbers of the last report.
pub struct TimedMotor {
    station: TimedStation<Motion>,
    report: [u32; Report::NUMBERS],
}

impl TimedMotor {
    /// The times of all steps so far, in clocks since the board was switched on.
    pub fn steps(&mut self) -> &[u64] {
        &self.station.motor().steps
    }

    fn millis(&mut self) -> u32 {
        (self.station.motor().now / MILLIS) as u32
    }
}

/// Whether an Uno has these pins of a port, except those of the serial line: `AnyPort::of` of `stepwright-avr`.
const fn has_pins(port: u8, mask: u8) -> bool {
    let pins = match port {
        b'B' | b'C' => 0b0011_1111,
        b'D' => 0b1111_1100,
        _ => return false,
    };
    mask & !pins == 0
}

impl WiredMotor for Motion {
    fn rewire(&mut self, wire: &Wire) -> bool {
        let Wire { port, mask, sequence, phase, .. } = *wire;
        if !has_pins(port, mask) {
            return false;
        }
        let sequence: Sequence = sequence;
        self.stepper.wire(Lines::default(), sequence, 0xFF);
        self.stepper.coils().off();
        self.stepper.coils().restore(phase);
        self.note();
        true
    }

    fn phase(&mut self) -> u8 {
        self.stepper.phase()
    }
}

impl BoardProgram for TimedMotor {
    type Row = Line;
    type Reason = Unwired;

    fn about(&mut self, n: u8) -> Option<Piece> {
        const ABOUT: &str = "stepwright-timed uno hz=16000000 axes=0 can=sum timers=1";
        (n == 0).then(|| Piece::Text(flash_text!(ABOUT)))
    }

    fn axes(&self) -> u8 {
        0
    }

    fn read(&self, letter: u8, numbers: &mut Numbers<'_>) -> Option<Line> {
        Line::read(letter, numbers)
    }

    fn carry_out(&mut self, line: &Line) -> Result<Said, Fault<Unwired>> {
        let mut now = self.millis();
        if matches!(line, Line::Move(..)) {
            // At the beginning of a millisecond.
            now += 1;
            self.station.motor().run_until(u64::from(now) * MILLIS);
        }
        match line.timer() {
            1 => self.station.carry_out(line, now, &mut self.report),
            _ => Err(Fault::Own(Unwired::Timer)),
        }
    }

    fn number(&mut self, n: u8) -> Option<i64> {
        self.report.get(usize::from(n)).map(|number| (*number).into())
    }

    fn is_busy(&mut self) -> bool {
        self.station.motor().is_moving()
    }

    fn position(&mut self, _: u8) -> Option<i64> {
        None
    }

    fn set_zero(&mut self, _: u8) {}

    fn mark_unknown(&mut self) {}

    fn stop(&mut self) {
        let now = self.millis();
        self.station.stop(now);
    }

    fn kill(&mut self) {
        self.stop();
    }

    fn poll(&mut self) {
        let now = self.millis();
        self.station.poll(now);
    }
}

impl SimProgram for TimedMotor {
    fn pass_until(&mut self, time: u64) -> u64 {
        let motor = self.station.motor();
        motor.run_until(time);
        motor.now
    }
}
