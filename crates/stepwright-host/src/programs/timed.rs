//! A board that runs the timed driver: speeds that change on a clock.

use stepwright_timed::line::{Line, NAME, Report, Unwired, Wire};
use stepwright_timed::{Code, SetSpeed};

use super::{ProgramRow, ProgramSession, RowProblem};

/// A board with motors on timers of their own.
///
/// ```
/// use stepwright::drive::sequence::SHIELD;
/// use stepwright_host::link::simulated::{VirtualLink, VirtualProgram};
/// use stepwright_host::programs::TimedSession;
/// use stepwright_sim::timed::TimedLineBoard;
/// use stepwright_timed::line::Wire;
/// use stepwright_timed::{Code, Control, SetSpeed};
///
/// # fn main() -> Result<(), stepwright_host::programs::TimedProblem> {
/// let board = VirtualProgram::new(TimedLineBoard::uno(), 16_000_000, 1_388);
/// let mut board = TimedSession::on(Box::new(VirtualLink::new(board, true)))?;
/// let sequence = SHIELD.on_bits(&[4, 5]);
/// board.wire(1, Wire { port: b'B', mask: 0x30, sequence, shield: true, phase: 0 })?;
/// // 250 steps/s: 64,000 ticks of 16 MHz a step.
/// let order = SetSpeed { limit: 300, ..SetSpeed::fixed(Control::DRV_EN, 64_000) };
/// assert_eq!(board.set_speed(1, order, 0)?, Code::FINE);
/// while board.look(1)?.moving {
///     board.pause(std::time::Duration::from_millis(100))?;
/// }
/// # Ok(())
/// # }
/// ```
pub type TimedSession = ProgramSession<Line>;

/// Why a row of the timed driver was not obeyed.
pub type TimedProblem = RowProblem<Line>;

impl ProgramRow for Line {
    const GREETING: &'static str = NAME;
    type Reason = Unwired;

    /// A repeated speed begins again; a repeated stop is harmless.
    fn is_harmless_twice(&self) -> bool {
        !matches!(self, Line::Move(_, order, _) if *order != SetSpeed::STOP)
    }
}

impl TimedSession {
    /// The timers that have a motor.
    pub fn timers(&self) -> impl Iterator<Item = u8> {
        let timers = self.word("timers").unwrap_or_default();
        timers.split(',').filter_map(|timer| timer.parse().ok())
    }

    /// Sets the pins of a timer's motor.
    ///
    /// # Errors
    /// [`RowProblem::Refused`] while the motor moves, or if the board does not have these pins; and the others.
    pub fn wire(&mut self, timer: u8, wire: Wire) -> Result<(), TimedProblem> {
        self.say(&Line::Wire(timer, wire))
    }

    /// Sets a speed, `ms` milliseconds after the caller's time 0, and returns the driver's result code. If
    /// noise spoils the answer, stops the motor.
    ///
    /// # Errors
    /// [`RowProblem::Noise`], [`RowProblem::Nonsense`], [`RowProblem::Lost`]
    pub fn set_speed(&mut self, timer: u8, order: SetSpeed, ms: u32) -> Result<Code, TimedProblem> {
        let row = Line::Move(timer, order, ms);
        match self.ask(&row) {
            Ok(answer) => match answer.parse() {
                Ok(code) => Ok(Code::new(code)),
                Err(_) => Err(RowProblem::Nonsense { row, answer }),
            },
            Err(problem @ RowProblem::Noise { .. }) => {
                self.ask(&Line::Move(timer, SetSpeed::STOP, 0))?;
                Err(problem)
            }
            Err(problem) => Err(problem),
        }
    }

    /// Stops a timer's motor, and switches its driver off.
    ///
    /// # Errors
    /// [`RowProblem::Nonsense`] if the code is not [`Code::FINE`], or the board has no motor on this timer; and
    /// the others.
    pub fn stop(&mut self, timer: u8) -> Result<(), TimedProblem> {
        match self.set_speed(timer, SetSpeed::STOP, 0)? {
            Code::FINE => Ok(()),
            code => {
                let row = Line::Move(timer, SetSpeed::STOP, 0);
                Err(RowProblem::Nonsense { row, answer: code.get().to_string() })
            }
        }
    }

    /// The state of a timer's motor.
    ///
    /// # Errors
    /// [`RowProblem::Lost`], [`RowProblem::Noise`], [`RowProblem::Nonsense`]
    pub fn look(&mut self, timer: u8) -> Result<Report, TimedProblem> {
        let row = Line::Look(timer);
        let answer = self.ask(&row)?;
        Report::read(answer.as_bytes()).ok_or(RowProblem::Nonsense { row, answer })
    }
}
