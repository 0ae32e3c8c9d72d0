//! The step rates of moves, and whether the machine can make them.

use std::fmt;

use stepwright_gcode::{FeedRate, Move, MoveKind};
use stepwright_path::{millimetres, mm};

use crate::machine::GrblMachine;
use crate::session::Grbl;
use crate::settings::GrblSettings;

/// Judges the highest step rates of X, Y and Z in a move, in steps/s. Returns what is wrong with them, as the
/// words of a message.
pub type RateJudge = Box<dyn Fn([f64; 3]) -> Option<String> + Send>;

/// The judge of a session.
pub(crate) struct Judge(pub RateJudge);

impl fmt::Debug for Judge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Judge")
    }
}

/// The highest step rate of an axis without another judge.
const MOST: f64 = 1e6;

/// The judge of virtual motors.
pub(crate) fn virtual_rates(rates: [f64; 3]) -> Option<String> {
    let axis = (0..3).find(|axis| rates[*axis] > MOST * 1.000_001)?;
    let (name, rate) = (["X", "Y", "Z"][axis], rates[axis]);
    Some(format!("{name} at {rate:.0} steps/s: at most {MOST:.0}, lower $11{axis} or $10{axis}"))
}

/// The highest step rates of a move. An override may double its feed rate.
fn rates(part: &Move, settings: &GrblSettings) -> [f64; 3] {
    let (steps, speeds) = (settings.axes(100), settings.axes(110).map(|speed| speed / 60.0));
    let (from, to) = (millimetres(part.from), millimetres(part.to));
    let way = [0, 1, 2].map(|axis| (to[axis] - from[axis]).abs());
    let feed = match part.kind {
        MoveKind::Feed(rate) | MoveKind::Probe(_, rate) | MoveKind::Arc(_, rate) => rate,
        MoveKind::Rapid => FeedRate::Inverse(Default::default()),
    };
    let feed = match feed {
        FeedRate::PerMinute(rate) => 2.0 * mm(rate) / 60.0,
        FeedRate::Inverse(_) => f64::INFINITY,
    };
    if let MoveKind::Arc(arc, _) = part.kind {
        let moves = |axis| way[axis] > 0.0 || arc.plane.axes()[..2].contains(&axis);
        let speed = |axis| if moves(axis) { feed.min(speeds[axis]) } else { 0.0 };
        return [0, 1, 2].map(|axis| speed(axis) * steps[axis]);
    }
    let length = way.into_iter().fold(0.0, f64::hypot);
    if length == 0.0 {
        return [0.0; 3];
    }
    let shares = way.map(|way| way / length);
    // Infinite for an axis that rests.
    let speed = (0..3).fold(feed, |speed, axis| speed.min(speeds[axis] / shares[axis]));
    [0, 1, 2].map(|axis| speed * shares[axis] * steps[axis])
}

impl<M: GrblMachine> Grbl<M> {
    /// Refuses moves by this judge: `ALARM:2` behind its message, before anything moves; `error:15` for a jog.
    /// Virtual motors make up to 1,000,000 steps/s.
    pub fn judged_by(mut self, judge: RateJudge) -> Grbl<M> {
        self.judge = Judge(judge);
        self
    }

    /// Whether the machine can make the steps of a move. If not, says why.
    pub(crate) fn is_playable(&mut self, part: &Move) -> bool {
        let wrong = (self.judge.0)(rates(part, &self.settings));
        if let Some(words) = &wrong {
            self.say(&format!("[MSG:{words}]\r\n"));
        }
        wrong.is_none()
    }
}
