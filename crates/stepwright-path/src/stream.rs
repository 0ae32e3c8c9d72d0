//! A source of steps that is played while it is planned. Each axis asks for its own steps.
//!
//! ```text
//!   source ──► steps of all axes in the order of their times
//!                 │ at most 2·LOOK ahead of the axis that asks
//!                 ▼
//!   axis 0 ◄── queue        axis 1 ◄── queue        …
//! ```
//!
//! If the next step of an axis is later than that, the axis waits and asks again. Later steps can therefore
//! still be changed, and only the steps of some milliseconds are kept.
//!
//! If a path turns just behind the middle between two positions, a step and the same step back are due at
//! almost the same time. No motor can do that. If the step back comes sooner than the shortest interval of the
//! axis, both are left out. The axis stays where it is while the path leads a part of a step beyond the middle.

use std::collections::VecDeque;
use std::sync::{Arc as Shared, Mutex, MutexGuard, PoisonError};

use stepwright::{Rate, Ticks};
use stepwright_cycle::Pace;

use crate::LOOK;
use crate::route::{Route, RouteStep};

/// A source of the steps of several axes.
pub trait StepSource {
    /// Returns the next step; times never fall. `None` once there are no more, or while the source is held.
    fn next_step(&mut self) -> Option<RouteStep>;

    /// The time from the start to the end, in s, once there are no more steps.
    fn duration(&self) -> f64;

    /// Whether the source is held: it has no step for now, and is not over.
    fn is_held(&self) -> bool {
        false
    }
}

/// A closed route, which has all of its pieces.
impl<const N: usize> StepSource for Route<N> {
    fn next_step(&mut self) -> Option<RouteStep> {
        self.next()
    }

    fn duration(&self) -> f64 {
        self.time()
    }

    fn is_held(&self) -> bool {
        Route::is_held(self)
    }
}

/// The source, and the steps that its axes have not played yet.
struct Open<S, const N: usize> {
    source: S,
    queues: [VecDeque<RouteStep>; N],
    /// The shortest time from a step of each axis to the same step back, in s.
    turns: [f64; N],
    /// The time up to which all steps were made, in s.
    made: f64,
    /// The time of its end, in s, once it is known.
    end: Option<f64>,
}

/// A source whose steps are played, and which can be changed meanwhile.
pub struct Stream<S, const N: usize>(Shared<Mutex<Open<S, N>>>);

impl<S, const N: usize> Clone for Stream<S, N> {
    fn clone(&self) -> Self {
        Stream(self.0.clone())
    }
}

impl<S: StepSource, const N: usize> Stream<S, N> {
    /// Returns the stream, and the steps of each axis in ticks of a timer of this rate. The first steps come at
    /// least `lead` ticks after the start. `shortest` is the shortest interval of each axis, in ticks: a step
    /// whose step back comes sooner is left out with it. Steps of an axis beyond N are left out.
    ///
    /// ```
    /// use stepwright::Rate;
    /// use stepwright_cycle::Pace;
    /// use stepwright_path::{AxisPace, Route, Stream};
    /// let axis = AxisPace { step: 0.01, speed: 100.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };
    /// let mut route = Route::new([axis; 2])?;
    /// route.line_to([10.0, 5.0], 80.0)?;
    /// route.close();
    /// let (stream, [x, y]) = Stream::new(route, Rate::MHZ, 1_000, [50; 2]);
    /// let steps = |paces: &[Pace]| paces.iter().filter(|p| matches!(p, Pace::Step { .. })).count();
    /// let [x, y] = [x, y].map(|axis| axis.collect::<Vec<Pace>>());
    /// assert_eq!((steps(&x), steps(&y)), (1_000, 500));
    /// assert!(stream.look(|route| route.is_over()));
    /// # Ok::<(), stepwright_path::Unplannable>(())
    /// ```
    pub fn new(
        source: S,
        rate: Rate,
        lead: Ticks,
        shortest: [Ticks; N],
    ) -> (Stream<S, N>, [AxisStream<S, N>; N]) {
        let queues = [const { VecDeque::new() }; N];
        let hz = f64::from(rate.hz());
        // One tick more, as both times may be rounded.
        let turns = shortest.map(|ticks| (f64::from(ticks) + 1.0) / hz);
        let open = Shared::new(Mutex::new(Open { source, queues, turns, made: 0.0, end: None }));
        let look = ((hz * LOOK).ceil() as u64).max(1);
        let axis = |axis| AxisStream { open: open.clone(), axis, rate, hz, lead, look, gone: 0 };
        let axes = std::array::from_fn(axis);
        (Stream(open), axes)
    }

    /// Reads or changes the source. A change takes effect after the steps that were made.
    pub fn look<T>(&self, look: impl FnOnce(&mut S) -> T) -> T {
        look(&mut lock(&self.0).source)
    }

    /// The same, with the time up to which steps were made, in s: a change takes effect from then on.
    pub fn change<T>(&self, change: impl FnOnce(&mut S, f64) -> T) -> T {
        let mut open = lock(&self.0);
        let made = open.made;
        change(&mut open.source, made)
    }
}

/// The steps of one axis of a [`Stream`], as a motor cycle plays them. All axes end at the same tick.
pub struct AxisStream<S, const N: usize> {
    open: Shared<Mutex<Open<S, N>>>,
    axis: usize,
    rate: Rate,
    hz: f64,
    lead: Ticks,
    look: u64,
    /// The ticks from the start to the last step or wait.
    gone: u64,
}

impl<S, const N: usize> AxisStream<S, N> {
    /// The rate of the timer.
    pub fn rate(&self) -> Rate {
        self.rate
    }
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<S: StepSource, const N: usize> Open<S, N> {
    /// Makes steps until this axis has one that is not left out, or until all steps up to this time are made.
    fn make(&mut self, axis: usize, until: f64) -> Option<RouteStep> {
        let turn = self.turns.get(axis).copied().unwrap_or(0.0);
        loop {
            if let Some(queue) = self.queues.get_mut(axis)
                && let Some(step) = queue.front().copied()
            {
                match queue.get(1) {
                    Some(next) if next.time - step.time < turn && next.forward != step.forward => {
                        queue.drain(..2);
                        continue;
                    }
                    None if self.end.is_none() && self.made < step.time + turn => {}
                    _ => return Some(step),
                }
            }
            let queued = self.queues.get(axis).is_some_and(|queue| !queue.is_empty());
            if self.end.is_some() || (self.made > until && !queued) {
                return None;
            }
            match self.source.next_step() {
                Some(step) => {
                    self.made = step.time;
                    if let Some(queue) = self.queues.get_mut(step.axis) {
                        queue.push_back(step);
                    }
                }
                None if self.source.is_held() => {
                    self.made = self.made.max(until);
                    // While the source is held, no step back follows the last step.
                    match self.queues.get(axis).and_then(VecDeque::front) {
                        Some(step) => self.made = self.made.max(step.time + turn),
                        None => return None,
                    }
                }
                None => self.end = Some(self.source.duration()),
            }
        }
    }
}

impl<S: StepSource, const N: usize> Iterator for AxisStream<S, N> {
    type Item = Pace;

    fn next(&mut self) -> Option<Pace> {
        let (hz, lead, gone) = (self.hz, u64::from(self.lead), self.gone);
        let ticks =
            |time: f64| ((time * hz).round() as u64).saturating_add(lead).saturating_sub(gone);
        let mut open = lock(&self.open);
        let until = (gone + 2 * self.look).saturating_sub(lead) as f64 / hz;
        let step = open.make(self.axis, until).filter(|step| ticks(step.time) <= 2 * self.look);
        let pace = if let Some(RouteStep { time, forward, .. }) = step {
            if let Some(queue) = open.queues.get_mut(self.axis) {
                queue.pop_front();
            }
            Pace::Step { ticks: ticks(time) as Ticks, forward }
        } else {
            let queued = open.queues.get(self.axis).is_some_and(|queue| !queue.is_empty());
            let left = open.end.filter(|_| !queued).map_or(self.look, ticks);
            if left == 0 {
                return None;
            }
            Pace::Wait { ticks: left.min(self.look) as Ticks }
        };
        let (Pace::Step { ticks, .. } | Pace::Wait { ticks }) = pace;
        self.gone += u64::from(ticks);
        Some(pace)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AxisPace, paces};

    fn route() -> Route<2> {
        let axis =
            AxisPace { step: 0.01, speed: 100.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };
        let mut route = Route::new([axis; 2]).unwrap();
        route.line_to([0.0, 5.0], 60.0).unwrap();
        route.arc([0, 1], [0.0, 10.0], 5.0, [0.0; 2], 80.0).unwrap();
        route.close();
        route
    }

    /// The ticks of the steps, each with its direction, and the tick of the end.
    fn played(paces: impl IntoIterator<Item = Pace>) -> (Vec<(u64, bool)>, u64) {
        let (mut at, mut steps) = (0, Vec::new());
        for pace in paces {
            match pace {
                Pace::Step { ticks, forward } => {
                    at += u64::from(ticks);
                    steps.push((at, forward));
                }
                Pace::Wait { ticks } => at += u64::from(ticks),
            }
        }
        (steps, at)
    }

    #[test]
    fn each_step_is_where_it_is_in_a_list() {
        let rate = Rate::MHZ;
        let [x, y] = paces(route(), rate, 500);
        let (stream, [a, b]) = Stream::new(route(), rate, 500, [50; 2]);
        // One axis after the other, so one is far ahead of the other.
        let ((a, end), (b, same)) = (played(a), played(b));
        assert_eq!((a, b), (played(x).0, played(y).0));
        let time = stream.look(|route| route.duration());
        assert_eq!((end, same), ((time * 1e6).round() as u64 + 500, end));
    }

    /// With a long shortest interval, the search for a step back looks further ahead than steps are made. Each
    /// step still comes in time.
    #[test]
    fn a_slow_axis_has_its_steps_in_time() {
        let axis =
            AxisPace { step: 0.01, speed: 100.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };
        let mut route = Route::new([axis; 2]).unwrap();
        route.line_to([10.0, 0.3], 60.0).unwrap();
        route.line_to([20.0, 0.3], 60.0).unwrap();
        route.close();
        let [x, y] = paces(route.clone(), Rate::MHZ, 500);
        let (_, [a, b]) = Stream::new(route, Rate::MHZ, 500, [20_000; 2]);
        let (b, a) = (played(b).0, played(a).0);
        assert_eq!((a, b), (played(x).0, played(y).0));
    }

    /// A turn a little behind a middle makes no steps; a turn almost half a step behind it does.
    #[test]
    fn no_step_is_taken_back_at_once() {
        let axis =
            AxisPace { step: 0.01, speed: 100.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };
        for (beyond, count) in [(0.000_000_1, 200), (0.004, 202)] {
            let mut route = Route::new([axis; 2]).unwrap();
            route.line_to([1.005 + beyond, 0.0], 60.0).unwrap();
            route.line_to([0.0, 0.0], 60.0).unwrap();
            route.close();
            assert_eq!(route.clone().count(), 202);
            let (_, [x, y]) = Stream::new(route, Rate::MHZ, 500, [50; 2]);
            let ((steps, end), (none, same)) = (played(x), played(y));
            assert_eq!((steps.len(), none.len(), end), (count, 0, same));
            assert!(steps.windows(2).all(|pair| pair[1].0 - pair[0].0 >= 50), "{steps:?}");
            let at: i32 = steps.iter().map(|step| if step.1 { 1 } else { -1 }).sum();
            assert_eq!(at, 0);
        }
    }

    /// A change takes effect after the steps that were made, some ms ahead.
    #[test]
    fn a_change_on_the_way_is_heard() {
        let (stream, [mut x, mut y]) = Stream::new(route(), Rate::MHZ, 500, [50; 2]);
        while x.gone < 100_000 {
            x.next();
        }
        while y.gone < x.gone {
            y.next();
        }
        stream.look(|route| route.cancel(0.0));
        let begun = x.gone;
        let end = begun + played(&mut x).1;
        assert_eq!(y.gone + played(&mut y).1, end);
        // Y braked from 43 mm/s, and steps were made 4 ms ahead.
        assert!((40_000..50_000).contains(&(end - begun)), "{begun} {end}");
        assert_eq!((x.next(), y.next()), (None, None));
    }
}
