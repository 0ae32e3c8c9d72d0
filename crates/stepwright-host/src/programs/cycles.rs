//! A board that runs the program `cycles`: several motors at once, each with a program of its own.

use std::time::Duration;

use stepwright_cycle::line::{CycleFault, CycleLine, CycleReport, LineAct, NAME};

use super::{ProgramRow, ProgramSession, RowProblem};

/// The time between two looks at the motors.
const LOOK: Duration = Duration::from_millis(100);

/// A board that plays motor cycles.
///
/// ```no_run
/// use stepwright_cycle::line::{CycleLine, LineProgram};
/// use stepwright_cycle::{Calibration, Motor};
/// use stepwright_host::link::serial::{LeaseWait, SerialLink, Share};
/// use stepwright_host::programs::CycleSession;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// // Motor cycles know no lease.
/// let free = |_: &_| LeaseWait::Over;
/// let link = SerialLink::open("/dev/ttyUSB0".as_ref(), 115_200, Share::Alone, free)?;
/// let mut board = CycleSession::on(Box::new(link))?;
/// board.say(&CycleLine::New)?;
/// board.say(&CycleLine::Motor(0, Motor::new(1, 1_000)))?;
/// let steps = LineProgram::Steps { count: -400, delay: 1_000 };
/// board.say(&CycleLine::Prepare(0, Calibration::None, steps))?;
/// let report = board.play(|_| true)?;
/// println!("{}", report.motors[0].position);
/// # Ok(())
/// # }
/// ```
pub type CycleSession = ProgramSession<CycleLine>;

/// Why a row of cycles was not obeyed.
pub type CycleProblem = RowProblem<CycleLine>;

impl ProgramRow for CycleLine {
    const GREETING: &'static str = NAME;
    type Reason = CycleFault;

    fn is_harmless_twice(&self) -> bool {
        true
    }
}

impl CycleSession {
    /// The number of motors.
    pub fn motors(&self) -> usize {
        self.count("axes")
    }

    /// The number of legs that the board can keep, for all series together.
    pub fn legs(&self) -> usize {
        self.count("legs")
    }

    fn count(&self, word: &str) -> usize {
        self.word(word).and_then(|count| count.parse().ok()).unwrap_or(0)
    }

    /// The state of the board.
    ///
    /// # Errors
    /// [`RowProblem::Lost`], [`RowProblem::Noise`], [`RowProblem::Nonsense`]
    pub fn look(&mut self) -> Result<CycleReport, CycleProblem> {
        let row = CycleLine::Look;
        let answer = self.ask(&row)?;
        CycleReport::read(answer.as_bytes()).ok_or(RowProblem::Nonsense { row, answer })
    }

    /// Starts the prepared cycle, and waits until it is over. `see` is called for every look, 10 times a
    /// second. If it returns `false` the cycle is finished: every motor stops at once, and its position stays
    /// known.
    ///
    /// # Errors
    /// [`RowProblem::Refused`]: nothing moves. After [`RowProblem::Lost`] the cycle goes on.
    pub fn play(
        &mut self,
        mut see: impl FnMut(&CycleReport) -> bool,
    ) -> Result<CycleReport, CycleProblem> {
        let last = self.look()?.number;
        self.say(&CycleLine::Start(next_number(last)))?;
        loop {
            let report = self.look()?;
            if !report.running {
                return Ok(report);
            }
            if !see(&report) {
                self.say(&CycleLine::Now(LineAct::Finish))?;
            }
            self.pause(LOOK)?;
        }
    }
}

/// The number of the next cycle: 1 … 255.
fn next_number(last: u8) -> u8 {
    last.checked_add(1).unwrap_or(1)
}
