//! Motors on a board that plays streams.

use std::time::Duration;

use stepwright::Board;
use stepwright_feeder::{FeedState, FeedTerms, StreamFeeder};
use stepwright_grbl::{FedRun, Grbl, GrblSettings, RateJudge, VirtualMill};
use stepwright_plan::gcode::{BoardRefusal, JobPlan, Peak};
use stepwright_play::stream::{LOOK, StreamedBoard};

use crate::failure::Failure;
use crate::gcode::port::meet;
use crate::order::target::PortArgs;
use crate::say;

/// A board that sends nothing for this long has nothing more to send.
const QUIET: Duration = Duration::from_millis(20);
/// Alarms: a switch has closed; the board has left the path or was lost.
const LIMIT: u8 = 1;
const LOST: u8 = 3;

/// The board.
pub struct Fed {
    board: StreamedBoard,
    /// The board's positions at the machine's zero.
    zero: [i64; 3],
    /// The current run, and the link's time at its start.
    run: Option<(FedRun, Duration)>,
    /// Seconds of the session, and the link's time at the last read.
    now: f64,
    seen: Duration,
    /// Whether the board is to be killed.
    pub dead: bool,
}

impl Fed {
    /// Opens the port. The board's present position becomes the machine's zero.
    pub fn open(port: &PortArgs) -> Result<Fed, Failure> {
        let mut board = meet(port, "grbl")?;
        let unknown = board.zero_unknown()?;
        let [x, y, z] = board.places.map(Option::unwrap_or_default);
        let name = &board.name;
        if unknown {
            say::note(format_args!(
                "{name} did not know where its axes are: they are at the machine's zero now"
            ));
        } else if [x, y, z] != [0; 3] {
            say::note(format_args!("{name} is at {x} {y} {z}: that is the machine's zero"));
        }
        let seen = board.session.now();
        Ok(Fed { board, zero: [x, y, z], run: None, now: 0.0, seen, dead: false })
    }

    /// Judges whether the board can make steps at given rates: as for a job.
    pub fn judge(&self) -> RateJudge {
        let board = self.board.board;
        Box::new(move |rates| judged(&board, rates))
    }

    /// Whether the board has an output for a laser.
    pub fn lasers(&self) -> bool {
        self.board.laser
    }

    /// Seconds of the session.
    pub fn now(&self) -> f64 {
        self.now
    }

    /// Whether the board has a run.
    pub fn is_busy(&self) -> bool {
        self.run.is_some()
    }

    /// Feeds the board, and reads its answers for a millisecond.
    ///
    /// # Errors
    /// The board is lost; the session has been given its alarm.
    pub fn turn(&mut self, grbl: &mut Grbl<VirtualMill>) -> Result<(), Failure> {
        if self.dead {
            return Err(self.board.kill().into());
        }
        let done = self.look(grbl);
        done.inspect_err(|_| {
            grbl.off_path(grbl.position(), LOST, "Board lost: it brakes by itself");
        })
    }

    fn look(&mut self, grbl: &mut Grbl<VirtualMill>) -> Result<(), Failure> {
        let mut buffer = [0; 256];
        let read = self.board.session.link().read(&mut buffer, LOOK);
        let count = read.map_err(|error| self.board.gone(&error))?;
        let now = self.board.session.now();
        let since = now.saturating_sub(self.seen).as_secs_f64();
        self.seen = now;
        let heard = buffer.get(..count).unwrap_or_default();
        let Some((run, begun)) = &mut self.run else {
            if !grbl.has_run() {
                self.now += since;
            } else if let Some(feeder) = self.feeder(grbl.settings()) {
                self.run = FedRun::begin(grbl, self.now, feeder).map(|run| (run, now));
            } else {
                grbl.off_path(grbl.position(), LOST, "Acceleration below 8 steps/s2");
            }
            return Ok(());
        };
        let micros = now.saturating_sub(*begun).as_micros() as u64;
        let bytes = run.turn(grbl, heard, micros);
        self.now = run.now();
        if !bytes.is_empty() {
            let written = self.board.session.link().write(&bytes);
            written.map_err(|error| self.board.gone(&error))?;
        }
        let state = run.state();
        // Frames may still be under way to a board that has not begun.
        let quiet = if run.is_dropped() { 5 * QUIET } else { QUIET };
        if state.is_end() { self.ended(state, quiet, grbl) } else { Ok(()) }
    }

    /// A feeder for a run; `None` if the board could not brake with these settings.
    fn feeder(&self, settings: &GrblSettings) -> Option<StreamFeeder> {
        let decels = [0, 1, 2].map(|n| settings.get(120 + n) * settings.get(100 + n));
        let terms = FeedTerms {
            inputs: if settings.is_on(21) { 0b111 } else { 0 },
            laser: self.board.laser,
            ..self.board.terms(decels)?
        };
        Some(StreamFeeder::new(terms, 0))
    }

    /// Handles the end of a run: regular, or off the path.
    fn ended(
        &mut self,
        state: FeedState,
        quiet: Duration,
        grbl: &mut Grbl<VirtualMill>,
    ) -> Result<(), Failure> {
        self.run = None;
        self.board.hush(quiet);
        if state == FeedState::Lost {
            return Err(self.board.silent().into());
        }
        self.board.rest()?;
        // Drops the board's messages about its rest.
        self.board.hush(QUIET);
        let places = self.board.positions()?;
        self.seen = self.board.session.now();
        let counted = [0, 1, 2].map(|n| places[n].map(|place| place - self.zero[n]));
        let at = [0, 1, 2].map(|n| counted[n].unwrap_or(grbl.position()[n]));
        match state {
            FeedState::Over if at == grbl.position() => {}
            FeedState::Tripped => grbl.off_path(at, LIMIT, "Switch closed: braked, place known"),
            FeedState::Over => grbl.off_path(at, LOST, "Board counts another place"),
            FeedState::Wrong => grbl.off_path(at, LOST, "Board refused a record, place known"),
            _ => grbl.off_path(at, LOST, "Board ran short: braked off the path, place known"),
        }
        Ok(())
    }

    /// The board's positions and its number of late steps.
    pub fn tells(&mut self) -> Result<([Option<i64>; 3], u64), Failure> {
        Ok(self.board.tells()?)
    }
}

fn judged(board: &Board<3>, rates: [f64; 3]) -> Option<String> {
    let peaks = rates.map(|rate| Peak { rate, line: 0 });
    let plan = JobPlan { peaks, ..JobPlan::default() };
    let BoardRefusal { axis, wanted, most, .. } = plan.refused_by(board)?;
    let name = ["X", "Y", "Z"].get(axis)?;
    Some(format!(
        "{name} at {:.0} steps/s: the board can do {:.0}, lower $11{axis}",
        wanted.ceil(),
        most.floor()
    ))
}

#[cfg(test)]
mod tests {
    use stepwright_sim::Description;

    use super::*;

    #[test]
    fn a_board_has_rates_that_it_can_make() {
        let judge = |rates| judged(&Description::uno().board, rates);
        for rates in [[100_000.0, 0.0, 0.0], [40_000.0, 40_000.0, 0.0], [20_000.0; 3], [0.0; 3]] {
            assert_eq!(judge(rates), None, "{rates:?}");
        }
        let told = judge([500_000.0, 0.0, 0.0]).unwrap();
        assert_eq!(told, "X at 500000 steps/s: the board can do 128000, lower $110");
        let told = judge([10_000.0, 28_000.0, 27_000.0]).unwrap();
        assert!(told.starts_with("Y at 28000 ") && told.ends_with("lower $111"), "{told}");
    }
}
