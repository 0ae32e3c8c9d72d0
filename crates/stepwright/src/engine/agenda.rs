//! The order of the axes' next events, which an engine on a wide counter keeps between visits.
//!
//! ```text
//!   X at 100 │ Z at 130 │ Y at 180      X is played, and comes at 160 again:
//!   Z at 130 │ X at 160 │ Y at 180
//! ```
//!
//! All axes are examined again only after several were due at once, or after a change by the
//! foreground.

use crate::timer::Count;

/// Marks an axis whose event is not a step.
const OTHER: u8 = 0x80;
/// No axis.
const NONE: u8 = u8::MAX;

/// An axis and the time of its event.
#[derive(Clone, Copy, Debug)]
struct Due<C> {
    at: C,
    /// The axis, with [`OTHER`] if its event is not a step.
    axis: u8,
}

/// The axes that have events, in the order of their times.
#[derive(Clone, Copy, Debug)]
pub(super) struct Agenda<C, const N: usize>([Due<C>; N]);

impl<C: Count, const N: usize> Agenda<C, N> {
    /// No axis has an event.
    pub const EMPTY: Agenda<C, N> = Agenda([Due { at: C::ZERO.0, axis: NONE }; N]);

    /// The axis whose event comes first, and alone; 127 if there is none, or if there is more to do
    /// than that event.
    #[inline(always)]
    pub fn first(&self) -> u8 {
        self.first_step() & !OTHER
    }

    /// Like [`first`](Agenda::first) if the event is a step; more than 127 if not.
    #[inline(always)]
    pub fn first_step(&self) -> u8 {
        self.0.first().map_or(NONE, |due| due.axis)
    }

    /// Whether the events of all other axes come after this time.
    #[inline(always)]
    pub fn others_after(&self, at: C) -> bool {
        self.0.get(1).is_none_or(|due| due.at.is_after(at))
    }

    /// Removes all axes. All are examined again three eighths of the counter from `now`: events
    /// come at most a quarter of the counter after `now`, and an event that is late by less than an
    /// eighth still comes before that.
    #[inline(always)]
    pub fn clear(&mut self, now: C) {
        self.0 = [Due { at: now.plus(C::HOP + C::HOP / 2), axis: NONE }; N];
    }

    /// Hides the first axis, because something else comes before its event.
    pub fn hide_first(&mut self) {
        if let Some(due) = self.0.first_mut() {
            due.axis = NONE;
        }
    }

    /// Adds an axis whose event is a step (`true`), another event of its entries (`false`), or the
    /// arrival of an entry (`None`).
    #[inline(always)]
    pub fn insert(&mut self, axis: u8, at: C, steps: Option<bool>) {
        let axis = match steps {
            Some(true) => axis,
            Some(false) => axis | OTHER,
            None => NONE,
        };
        let mut places = self.0.iter_mut().rev();
        let Some(mut hole) = places.next() else { return };
        for due in places {
            if !due.at.is_after(at) {
                break;
            }
            *hole = *due;
            hole = due;
        }
        *hole = Due { at, axis };
    }

    /// Moves the event of the first axis to this time; `steps` if it is a step. Returns the time of
    /// the first event then.
    #[inline(always)]
    pub fn put_off(&mut self, at: C, steps: bool) -> C {
        let axis = if steps { self.first() } else { self.first() | OTHER };
        let mut places = self.0.iter_mut();
        let Some(mut hole) = places.next() else { return at };
        for due in places {
            if due.at.is_after(at) {
                break;
            }
            *hole = *due;
            hole = due;
        }
        *hole = Due { at, axis };
        self.hide_twins();
        self.next(at)
    }

    /// Hides the first axis if the second has its event at the same time.
    #[inline(always)]
    pub fn hide_twins(&mut self) {
        if let [first, second, ..] = &self.0[..]
            && first.at == second.at
        {
            self.hide_first();
        }
    }

    /// The time of the first event.
    #[inline(always)]
    pub fn next(&self, none: C) -> C {
        self.0.first().map_or(none, |due| due.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first axis is the one found by looking at all of them, over many turns of the counter,
    /// with events up to a quarter of the counter away; also where an axis is late.
    #[test]
    fn the_first_is_the_one_that_comes_next() {
        let mut seed = 1u64;
        let mut random = |below: u32| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 33) as u32 % below
        };
        for waiting in 1..=3usize {
            let mut agenda = Agenda::<u32, 3>::EMPTY;
            let mut now = 0xFFFF_0000u32;
            let mut times = [1, 2, 3].map(|ahead| now.wrapping_add(ahead));
            let fill = |agenda: &mut Agenda<u32, 3>, now: u32, times: &[u32; 3]| {
                agenda.clear(now);
                (0..waiting)
                    .for_each(|axis| agenda.insert(axis as u8, times[axis], Some(axis != 1)));
                agenda.hide_twins();
            };
            fill(&mut agenda, now, &times);
            for _ in 0..20_000 {
                let ahead = |axis: &usize| times[*axis].wrapping_sub(now) as i32;
                let next = (0..waiting).min_by_key(ahead).unwrap();
                if (0..waiting).filter(|axis| times[*axis] == times[next]).count() > 1 {
                    assert_eq!(agenda.first(), 127);
                    times[next] = times[next].wrapping_sub(1);
                    fill(&mut agenda, now, &times);
                    continue;
                }
                if agenda.first() == 127 {
                    // All are examined again here, possibly too early and never too late.
                    assert!(!agenda.next(0).is_after(times[next]), "{now} {times:?} {agenda:?}");
                    fill(&mut agenda, now, &times);
                }
                assert_eq!(usize::from(agenda.first()), next, "{now} {times:?} {agenda:?}");
                assert_eq!(agenda.first_step() < OTHER, next != 1);
                assert_eq!(agenda.next(0), times[next]);
                now = if random(4) == 0 { now } else { times[next] };
                now = now.wrapping_add(random(10) * random(100));
                let far = if random(4) == 0 { 1 << 30 } else { 1 << 12 };
                times[next] = now.wrapping_add(1 + random(far));
                if random(4) == 0 {
                    // Several were due, or the foreground has changed something.
                    fill(&mut agenda, now, &times);
                } else {
                    let at = agenda.put_off(times[next], next != 1);
                    assert!((0..waiting).all(|axis| !at.is_after(times[axis])));
                }
            }
        }
    }
}
