//! The ways of a path, one after another, and the progress of each axis on them.
//!
//! A new end is one of two things:
//!
//! ```text
//!   on the line     ━━━━━━━━━━━━━━━┿━━━━━━━━━━━━━━━▶ new      no stop, no turn
//!
//!   anywhere else   ━━━━━━━━━━━┿━━━━┓┄┄┄┄▷ old
//!                     asked for    rest ╲
//!                                        ◥ new
//! ```
//!
//! Steps that were handed out are not taken back. The steps after the place where a way is left belong to the
//! new way.

use crate::curve::{Mark, Marks};
use crate::law::Law;
use crate::pace::Unplannable;

/// A straight line as it was ordered.
#[derive(Clone)]
struct Straight {
    /// The beginning: along the path, and of each axis in steps.
    begin: f64,
    from: Vec<i64>,
    /// The steps of each axis, and the length.
    steps: Vec<i64>,
    length: f64,
}

/// A way of the path: its beginning and end, and the steps of each axis.
struct Way {
    begin: f64,
    end: f64,
    marks: Vec<Marks>,
    /// The position of each axis before its first step on this way, and the place of its last step along the
    /// path.
    from: Vec<(i64, f64)>,
    line: Option<Straight>,
}

/// The progress of an axis by the steps handed out.
#[derive(Clone)]
struct Cursor {
    way: usize,
    marks: Marks,
    made: usize,
}

/// All ways of a path, and its law.
pub(crate) struct Road {
    pub law: Law,
    ways: Vec<Way>,
    cursors: Vec<Cursor>,
    /// The length of a step, and the highest speed in steps/s, of each axis.
    step: Vec<f64>,
    fastest: Vec<f64>,
    /// The time up to which an axis has been handed out, in s.
    asked: f64,
}

/// The tolerance of the highest speed, for rounding.
const ROUNDED: f64 = 1.0 + 1e-9;

/// The distance beside a line, in steps, that counts as on the line.
const BESIDE: f64 = 0.5 + 1e-9;

impl Road {
    pub fn new(law: Law, marks: Vec<Marks>, step: &[f64]) -> Road {
        let cursor = |marks: &Marks| Cursor { way: 0, marks: marks.clone(), made: 0 };
        let cursors = marks.iter().map(cursor).collect();
        let (end, from) = (f64::INFINITY, vec![(0, 0.0); marks.len()]);
        let ways = vec![Way { begin: 0.0, end, marks, from, line: None }];
        let fastest = vec![f64::INFINITY; step.len()];
        Road { law, ways, cursors, step: step.to_vec(), fastest, asked: 0.0 }
    }

    /// Declares that the way is a line of these steps.
    pub fn of_line(mut self, steps: &[i32]) -> Road {
        let length = self.law.length();
        if let Some(way) = self.ways.first_mut() {
            let (from, steps) = (vec![0; steps.len()], steps.iter().map(|n| i64::from(*n)));
            way.line = Some(Straight { begin: 0.0, from, steps: steps.collect(), length });
        }
        self
    }

    /// Limits the speed of each axis, in steps/s, as ordered and after changes.
    pub fn within(&mut self, fastest: &[f64]) -> Result<(), Unplannable> {
        if fastest.len() != self.cursors.len() {
            return Err(Unplannable::Axes);
        }
        let marks = self.ways.first().map_or(&[][..], |way| way.marks.as_slice());
        let each = marks.iter().zip(fastest).map(|(marks, fastest)| marks.closest() * fastest);
        // The slowest axis determines the limit.
        let slowest = each.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        let (axis, most) = slowest.unwrap_or((0, f64::INFINITY));
        if self.law.peak() > most * ROUNDED {
            return Err(Unplannable::TooFast { axis, most });
        }
        self.fastest = fastest.to_vec();
        self.law.limit(most);
        Ok(())
    }

    /// The highest speed of an axis, in steps/s.
    pub fn fastest(&self, axis: usize) -> f64 {
        self.fastest.get(axis).copied().unwrap_or(f64::INFINITY)
    }

    /// When a change asked for at `at` takes effect: not before the steps that were handed out.
    pub fn moment(&self, at: f64) -> f64 {
        at.max(self.asked)
    }

    /// The next step of an axis; `None` if no further step is known.
    pub fn next(&self, axis: usize) -> Option<Mark> {
        self.look(axis).map(|(mark, _)| mark)
    }

    fn look(&self, axis: usize) -> Option<(Mark, Cursor)> {
        let mut at = self.cursors.get(axis)?.clone();
        loop {
            let way = self.ways.get(at.way)?;
            if let Some(mark) = at.marks.next().filter(|mark| mark.at <= way.end) {
                at.made += 1;
                return Some((mark, at));
            }
            let marks = self.ways.get(at.way + 1)?.marks.get(axis)?.clone();
            at = Cursor { way: at.way + 1, marks, made: 0 };
        }
    }

    /// Hands out the next step of an axis, at `time`.
    pub fn hand_out(&mut self, axis: usize, time: f64) {
        if let Some((_, cursor)) = self.look(axis)
            && let Some(known) = self.cursors.get_mut(axis)
        {
            *known = cursor;
        }
        self.wait(time);
    }

    /// Promises that nothing changes up to `time`.
    pub fn wait(&mut self, time: f64) {
        self.asked = self.asked.max(time);
    }

    /// Leaves the last way at `place`. Returns the position of each axis there, and the place of its last step.
    fn leave(&mut self, place: f64) -> Vec<(i64, f64)> {
        // Drop ways that no axis has entered yet.
        while let [.., last] = self.ways.as_slice() {
            let number = self.ways.len() - 1;
            let gone = self.cursors.iter().any(|cursor| cursor.way >= number);
            if number == 0 || last.begin < place || gone {
                break;
            }
            self.ways.pop();
        }
        let number = self.ways.len() - 1;
        let Some(way) = self.ways.last_mut() else { return Vec::new() };
        way.end = way.end.min(place);
        let axes = way.marks.iter().zip(&way.from).zip(&self.cursors);
        let left = axes.map(|((marks, from), cursor)| {
            let made = if cursor.way == number { cursor.made } else { 0 };
            let marks = marks.clone().enumerate();
            let gone = marks.take_while(|(n, mark)| *n < made || mark.at <= place);
            gone.fold(*from, |(at, _), (_, mark)| (at + if mark.forward { 1 } else { -1 }, mark.at))
        });
        left.collect()
    }

    /// The length of these steps of all axes.
    fn length(&self, steps: &[i64]) -> f64 {
        let ways = steps.iter().zip(&self.step).map(|(n, d)| *n as f64 * d);
        ways.map(|way| way * way).sum::<f64>().sqrt()
    }

    /// The speed along a line at which the first axis reaches its highest speed.
    fn most(&self, steps: &[i64], length: f64) -> f64 {
        let axes = steps.iter().zip(&self.fastest).filter(|(n, _)| **n != 0);
        axes.map(|(n, fastest)| fastest * length / n.unsigned_abs() as f64)
            .fold(f64::INFINITY, f64::min)
    }

    /// The end of the path if it continues straight to `to`, and its line; `None` if `to` is elsewhere, or too
    /// near to stop there.
    fn straight_on(&self, at: f64, to: &[i64]) -> Option<(f64, Straight)> {
        let line = self.ways.last()?.line.as_ref()?;
        let way: Vec<i64> = to.iter().zip(&line.from).map(|(to, from)| to - from).collect();
        let length = self.length(&way);
        let end = line.begin + length;
        let part = length / line.length;
        let mut axes = way.iter().zip(&line.steps);
        let on_it = axes.all(|(n, old)| (*n as f64 - *old as f64 * part).abs() <= BESIDE);
        let rolling = self.law.standing(at).is_none();
        (on_it && rolling && self.law.stop_from(at) < end).then(|| (end, line.clone()))
    }

    /// Sets a new end, in steps from the beginning of the path. Returns when it takes effect.
    pub fn retarget(&mut self, at: f64, to: &[i32]) -> Result<f64, Unplannable> {
        if to.len() != self.cursors.len() {
            return Err(Unplannable::Axes);
        }
        let at = self.moment(at);
        if self.law.is_over(at) || self.law.is_finished() {
            return Err(Unplannable::Over);
        }
        let to: Vec<i64> = to.iter().map(|n| i64::from(*n)).collect();
        let straight = self.straight_on(at, &to);
        let place = match straight {
            Some(_) => self.law.place(at),
            None => self.law.corner(at),
        };
        let from = self.leave(place);
        let steps = to.iter().zip(&from).map(|(to, (at, _))| to - at).collect::<Vec<_>>();
        let length = self.length(&steps);
        let way = match straight {
            Some((end, line)) => {
                self.law.stretch(at, end, self.most(&steps, end - place));
                let axes = steps.iter().zip(&from);
                let marks = axes.map(|(n, (_, last))| Marks::onward(*n, *last, end, place));
                let marks = marks.collect();
                Way { begin: place, end: f64::INFINITY, marks, from, line: Some(line) }
            }
            None => {
                let end = place + length;
                self.law.lead(end, self.most(&steps, length));
                let marks = steps.iter().map(|n| Marks::onward(*n, place, end, place)).collect();
                let begins = from.iter().map(|(at, _)| *at).collect();
                let line = Straight { begin: place, from: begins, steps, length };
                let from = from.into_iter().map(|(at, _)| (at, place)).collect();
                Way { begin: place, end: f64::INFINITY, marks, from, line: Some(line) }
            }
        };
        self.ways.push(way);
        Ok(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Line, Pace, SCALES};
    use proptest::prelude::*;

    #[derive(Clone, Copy, Debug)]
    enum Act {
        Scale(f64),
        Pause,
        Resume,
        Finish,
        On(i32),
        Elsewhere([i32; 2]),
    }

    fn act() -> impl Strategy<Value = Act> {
        prop_oneof![
            2 => (0.05f64..2.5).prop_map(Act::Scale),
            1 => Just(Act::Pause),
            2 => Just(Act::Resume),
            1 => Just(Act::Finish),
            3 => (1i32..300).prop_map(Act::On),
            3 => prop::array::uniform2(-2_000i32..2_000).prop_map(Act::Elsewhere),
        ]
    }

    /// Each piece begins where the one before ends, and no piece exceeds a limit.
    fn check(law: &Law, pace: &Pace) {
        let Pace { speed, accel, decel, jerk } = *pace;
        let most = speed * SCALES.end();
        let near = |a: f64, b: f64, all: f64| (a - b).abs() <= 1e-7 * all;
        let (mut at, long) = (None, 1e-7 * law.length() / speed);
        for piece in law.pieces() {
            let (from, to) = (piece.from, piece.to);
            assert!(to.t >= from.t - long && to.s >= from.s - 1e-7, "{piece:?}");
            for (v, a) in [(from.v, from.a), (to.v, to.a)] {
                assert!((-1e-6..=most * 1.000_001).contains(&v), "{piece:?}");
                assert!(a <= accel * 1.000_001 && a >= -decel * 1.000_001, "{piece:?}");
            }
            assert!(piece.jerk.abs() <= jerk, "{piece:?}");
            if let Some((t, s, v, a)) = at.replace((to.t, to.s, to.v, to.a)) {
                assert!(near(t, from.t, 1.0 + t) && near(s, from.s, 1.0 + s), "{s} {piece:?}");
                assert!(near(v, from.v, most), "{v} {piece:?}");
                assert!(jerk.is_infinite() || near(a, from.a, accel + decel), "{a} {piece:?}");
            }
        }
        if let Some((_, s, v, _)) = at
            && law.end().is_some()
        {
            assert!(near(s, law.length(), 1.0 + s) && v == 0.0, "{s}, not {}", law.length());
        }
    }

    proptest! {
        /// After any changes speed, acceleration and jerk stay within their limits and do not jump, and the
        /// past does not change.
        #[test]
        fn no_change_leaps(
            unit in prop::array::uniform2(-9i32..9),
            times in 10i32..200,
            speed in 50.0f64..5_000.0,
            accel in 200.0f64..20_000.0,
            decel in 200.0f64..20_000.0,
            bend in prop::option::of(0.005f64..0.5),
            acts in prop::collection::vec((0.0f64..0.5, act()), 1..10),
        ) {
            prop_assume!(unit != [0, 0]);
            let line = Line { steps: unit.map(|n| n * times), step: [1.0, 0.7] };
            let pace = Pace::new(speed, accel).with_decel(decel);
            let pace = bend.map_or(pace, |bend| pace.with_jerk(accel.max(decel) / bend));
            let law = Law::new(line.length(), pace).unwrap();
            let marks = line.marks().unwrap().to_vec();
            let mut road = Road::new(law, marks, &line.step).of_line(&line.steps);
            check(&road.law, &pace);
            let mut now = 0.0;
            for (later, act) in acts {
                now += later;
                let before = road.law.clone();
                let at = road.moment(now);
                match act {
                    Act::Scale(part) => _ = road.law.scale(at, part),
                    Act::Pause => road.law.pause(at),
                    Act::Resume => road.law.resume(at),
                    Act::Finish => road.law.finish(at),
                    Act::On(times) => _ = road.retarget(now, &unit.map(|n| n * times)),
                    Act::Elsewhere(to) => _ = road.retarget(now, &to),
                }
                check(&road.law, &pace);
                for n in 0..20 {
                    let t = at * f64::from(n) / 20.0;
                    let (was, is) = (before.place(t), road.law.place(t));
                    prop_assert!((was - is).abs() <= 1e-9 * (1.0 + was), "{was}, now {is} at {t}");
                }
            }
        }
    }
}
