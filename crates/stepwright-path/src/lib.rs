//! Several axes on one path: lines, arcs and circles under one ramp, with a constant speed along the path.
//! Planned on a host, in floating point.
//!
//! A [`Law`] gives the place on the path at each time. A curve ([`Line`], [`Arc`]) gives the places at which
//! each axis steps. [`Steps`] combines both into the steps that a cycle plays
//! ([`Program::Paced`](stepwright_cycle::Program::Paced)).
//!
//! ```
//! use stepwright::Rate;
//! use stepwright_cycle as cycle;
//! use stepwright_path::{Line, Pace, Steps};
//! let line = Line { steps: [300, -100], step: [1.0, 1.0] };
//! // An S-curve: without the jerk it is a trapezoid.
//! let pace = Pace::new(500.0, 2_000.0).with_jerk(20_000.0);
//! let [x, y] = Steps::line(&line, pace, Rate::MHZ, 1_000)?;
//! let steps = |axis: Steps| axis.filter(|pace| matches!(pace, cycle::Pace::Step { .. })).count();
//! assert_eq!((steps(x), steps(y)), (300, 100));
//! # Ok::<(), stepwright_path::Unplannable>(())
//! ```
//!
//! A [`Route`] passes many lines and arcs at speed, without a stop between them: pieces in, steps out, within
//! the limits of each axis.
//!
//! **Changes on the way.** A path may be paused, made faster or slower, ended early, or led to a new end.
//! All axes' [`Steps`] share a [`LivePath`], which changes all of them at once. Steps that were handed out, at
//! most [`LOOK`] ahead, stay as they are. All axes therefore stay on the path, whatever the change and
//! its time.
//!
//! ```
//! use stepwright::Rate;
//! use stepwright_path::{Line, Pace, Steps};
//! let line = Line { steps: [2_000, 1_000], step: [1.0, 1.0] };
//! let [x, y] = Steps::line(&line, Pace::new(500.0, 2_000.0), Rate::MHZ, 1_000)?;
//! let path = x.law();
//! path.within(&[800.0, 800.0])?; // steps/s that the motors can follow
//! path.scale(0.5, 1.5)?;         // from 0.5 s on half as fast again
//! path.pause(1.0);               // brakes along the line
//! path.resume(2.0);              // and goes on along it
//! path.retarget(2.5, &[3_000, 1_500])?; // further on the same line: no stop
//! path.retarget(3.0, &[0, 1_500])?;     // elsewhere: brakes, and straight there
//! # Ok::<(), stepwright_path::Unplannable>(())
//! ```

mod arc_fit;
mod beyond;
mod bucket;
mod cell;
mod change;
mod chords;
mod course;
mod curve;
mod glide;
mod joint;
mod kink;
mod laser;
mod law;
mod lead;
mod legs;
mod lens;
mod loose;
mod moves;
mod pace;
mod paces;
mod passes;
mod piece;
mod ramp;
mod road;
mod route;
mod runs;
mod shape;
mod smooth;
mod span;
mod stream;
mod stretch;
mod sweep;
mod trial;
mod turning;
mod watch;

use std::sync::{Arc as Shared, Mutex, PoisonError};

use stepwright::{Rate, Ticks};
use stepwright_cycle as cycle;

pub use arc_fit::ArcFit;
pub use curve::{Arc, Line, Mark, Marks};
pub use glide::Glide;
pub use laser::LaserMove;
pub use law::{Law, SCALES};
pub use lead::{Lead, Planned};
pub use legs::legs;
pub use moves::{decimal, length, millimetres, mm};
pub use pace::{PACES, Pace, Unplannable};
pub use paces::paces;
use road::Road;
pub use route::{AxisPace, Route, RouteStep, SOONEST};
pub use stream::{AxisStream, StepSource, Stream};
pub use stretch::Stretch;
pub use sweep::ArcSweep;

/// The time after which an axis checks again when its next step is due, in s.
///
/// A step is handed out up to twice this time ahead. Changes take effect after that.
pub const LOOK: f64 = 0.002;

/// A path that several axes follow, and that can be changed meanwhile.
///
/// Times are in s after the start of the path. A change takes effect at the given time, but not before the
/// last change, and not before steps that were handed out already ([`LOOK`]). A time of 0 therefore means
/// at once. Every method returns the time at which its change takes effect.
#[derive(Clone)]
pub struct LivePath(Shared<Mutex<Road>>);

impl LivePath {
    fn look<T>(&self, look: impl FnOnce(&mut Road) -> T) -> T {
        look(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Limits the speed of each axis, in steps/s: no override and no new end exceeds it. To be called before
    /// the first change.
    ///
    /// # Errors
    /// [`Unplannable::Axes`] unless there is a limit for each axis; [`Unplannable::TooFast`] if the ordered
    /// path is faster than an axis can follow.
    pub fn within(&self, fastest: &[f64]) -> Result<(), Unplannable> {
        self.look(|road| road.within(fastest))
    }

    /// Brakes along the path, and rests until it is resumed: [`Law::pause`].
    pub fn pause(&self, at: f64) -> f64 {
        self.change(at, |law, at| law.pause(at))
    }

    /// Continues along the path: [`Law::resume`].
    pub fn resume(&self, at: f64) -> f64 {
        self.change(at, |law, at| law.resume(at))
    }

    /// Brakes along the path, and drops the rest of it: [`Law::finish`].
    pub fn finish(&self, at: f64) -> f64 {
        self.change(at, |law, at| law.finish(at))
    }

    fn change(&self, at: f64, change: impl FnOnce(&mut Law, f64)) -> f64 {
        self.look(|road| {
            let at = road.moment(at);
            change(&mut road.law, at);
            at
        })
    }

    /// Overrides the speed along the path by this factor: [`Law::scale`].
    ///
    /// # Errors
    /// [`Unplannable::Scale`] if the factor is NaN; [`Unplannable::Over`] if the path is over.
    pub fn scale(&self, at: f64, scale: f64) -> Result<f64, Unplannable> {
        self.look(|road| {
            let at = road.moment(at);
            road.law.scale(at, scale)?;
            Ok(at)
        })
    }

    /// Sets a new end, in steps of each axis from the beginning of the path.
    ///
    /// If the new end is ahead on the present line, and the path can stop there, the line continues to it
    /// without a stop; the steps of each axis are evenly spaced from its last step on. Otherwise, and on an
    /// arc, all axes brake along the path to rest, and a straight line with the same pace leads from there to
    /// the new end. An override and a pause stay in force.
    ///
    /// # Errors
    /// [`Unplannable`]; the path continues unchanged.
    pub fn retarget(&self, at: f64, to: &[i32]) -> Result<f64, Unplannable> {
        self.look(|road| road.retarget(at, to))
    }

    /// The time of the end: [`Law::end`].
    pub fn end(&self) -> Option<f64> {
        self.look(|road| road.law.end())
    }

    /// The present law.
    pub fn now(&self) -> Law {
        self.look(|road| road.law.clone())
    }
}

impl std::fmt::Debug for LivePath {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("LivePath").field(&self.now()).finish()
    }
}

/// The steps of one axis in ticks of a timer, for
/// [`Program::Paced`](stepwright_cycle::Program::Paced).
///
/// Each step is at the tick nearest to its time; errors do not accumulate. All axes end with the path: an
/// axis without further steps waits until then.
#[derive(Debug)]
pub struct Steps {
    axis: usize,
    path: LivePath,
    rate: Rate,
    hz: f64,
    lead: Ticks,
    look: Ticks,
    /// Ticks from the start to the last step or wait.
    gone: u64,
    /// Ticks from the start to the last step.
    last: Option<u64>,
}

impl Steps {
    fn all<const N: usize>(road: Road, rate: Rate, lead: Ticks) -> [Steps; N] {
        let path = LivePath(Shared::new(Mutex::new(road)));
        let hz = f64::from(rate.hz());
        let look = (hz * LOOK).ceil() as Ticks;
        std::array::from_fn(|axis| Steps {
            axis,
            path: path.clone(),
            rate,
            hz,
            lead,
            look,
            gone: 0,
            last: None,
        })
    }

    /// The steps of a line. The line begins `lead` ticks after the start, from rest: the first step of each
    /// axis comes after the first interval of its own ramp.
    ///
    /// # Errors
    /// [`Unplannable`].
    pub fn line<const N: usize>(
        line: &Line<N>,
        pace: Pace,
        rate: Rate,
        lead: Ticks,
    ) -> Result<[Steps; N], Unplannable> {
        let marks = line.marks()?.to_vec();
        let law = Law::new(line.length(), pace)?;
        Ok(Steps::all(Road::new(law, marks, &line.step).of_line(&line.steps), rate, lead))
    }

    /// The steps of an arc. The arc begins `lead` ticks after the start, or a little later, so that no first
    /// step comes sooner than the ramp takes over one step.
    ///
    /// # Errors
    /// [`Unplannable`].
    pub fn arc(arc: &Arc, pace: Pace, rate: Rate, lead: Ticks) -> Result<[Steps; 2], Unplannable> {
        let marks = arc.marks()?.to_vec();
        let law = Law::new(arc.length(), pace)?;
        // The first step of an axis is at least half a step away.
        let over = |way: f64| law.time(way.min(law.length())).unwrap_or(0.0);
        let rest = arc.step.map(|step| over(step) - over(step / 2.0));
        let rest = (rest[0].max(rest[1]) * f64::from(rate.hz())).ceil() as Ticks;
        let lead = lead.saturating_add(rest);
        Ok(Steps::all(Road::new(law, marks, &arc.step), rate, lead))
    }

    /// Ticks from the start to the beginning of the path.
    pub fn lead(&self) -> Ticks {
        self.lead
    }

    /// The rate of the timer.
    pub fn rate(&self) -> Rate {
        self.rate
    }

    /// The path, which all axes share.
    pub fn law(&self) -> LivePath {
        self.path.clone()
    }
}

impl Iterator for Steps {
    type Item = cycle::Pace;

    fn next(&mut self) -> Option<cycle::Pace> {
        let (hz, lead, gone) = (self.hz, u64::from(self.lead), self.gone);
        let ticks =
            |time: f64| ((time * hz).round() as u64).saturating_add(lead).saturating_sub(gone);
        let (wait, last) = (u64::from(self.look), self.last);
        let pace = self.path.look(|road| {
            // A path that rests has no steps beyond that place, for now.
            let mark = road.next(self.axis);
            let due = mark.and_then(|mark| Some((mark.forward, road.law.time(mark.at)?)));
            if let Some((forward, time)) = due
                && ticks(time) <= 2 * wait
            {
                // Rounding may put the step one tick too close to the last one.
                let least = (hz / road.fastest(self.axis)).round() as u64;
                let early = last.is_some_and(|last| gone + ticks(time) + 1 == last + least);
                let ticks = ticks(time) + u64::from(early);
                road.hand_out(self.axis, time);
                self.last = Some(gone + ticks);
                return Some(cycle::Pace::Step { ticks: ticks as Ticks, forward });
            }
            let left = match (due, road.law.end()) {
                (None, Some(end)) => ticks(end),
                _ => u64::MAX,
            };
            let ticks = left.min(wait) as Ticks;
            road.wait((gone + u64::from(ticks)).saturating_sub(lead) as f64 / hz);
            (ticks > 0).then_some(cycle::Pace::Wait { ticks })
        })?;
        let (cycle::Pace::Step { ticks, .. } | cycle::Pace::Wait { ticks }) = pace;
        self.gone += u64::from(ticks);
        Some(pace)
    }
}
