//! Whose event comes next: what an engine on a wide counter keeps from visit to visit.
//!
//! ```text
//!   X at 100 │ Z at 130 │ Y at 180      X is played, and comes at 160 again:
//!   Z at 130 │ X at 160 │ Y at 180
//! ```
//!
//! All axes are looked at only where several were due, or the foreground has changed something.

use crate::timer::Count;

/// Its event is no step.
const OTHER: u8 = 0x80;
/// No axis.
const NONE: u8 = u8::MAX;

/// An axis, and when its event comes.
#[derive(Clone, Copy, Debug)]
struct Due<C> {
    at: C,
    /// With [`OTHER`].
    axis: u8,
}

/// The axes that wait for something, by the time of their events.
#[derive(Clone, Copy, Debug)]
pub(super) struct Agenda<C, const N: usize>([Due<C>; N]);

impl<C: Count, const N: usize> Agenda<C, N> {
    /// Nobody waits.
    pub const EMPTY: Agenda<C, N> = Agenda([Due { at: C::ZERO.0, axis: NONE }; N]);

    /// The axis whose event comes first, and alone; 127 if there is none, or if there is more than that
    /// to see to.
    #[inline(always)]
    pub fn first(&self) -> u8 {
        self.first_step() & !OTHER
    }

    /// Likewise, if its event is a step; more than 127 if not.
    #[inline(always)]
    pub fn first_step(&self) -> u8 {
        self.0.first().map_or(NONE, |due| due.axis)
    }

    /// Whether the events of all others come after this time.
    #[inline(always)]
    pub fn others_after(&self, at: C) -> bool {
        self.0.get(1).is_none_or(|due| due.at.is_after(at))
    }

    /// Nobody waits: a look round, three eighths of the counter from `now`. Events come at most a
    /// quarter after `now`; one that is late by less than an eighth is before that, too.
    #[inline(always)]
    pub fn clear(&mut self, now: C) {
        self.0 = [Due { at: now.plus(C::HOP + C::HOP / 2), axis: NONE }; N];
    }

    /// Something else comes before the first event.
    pub fn hide_first(&mut self) {
        if let Some(due) = self.0.first_mut() {
            due.axis = NONE;
        }
    }

    /// An axis waits, that has not so far; for a step, for another event of its entries, or (`None`)
    /// for an entry.
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

    /// The event of the first axis comes at this time now, and is a step or not. Returns when the first
    /// event comes.
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

    /// Axes that step at once are no matter of the first.
    #[inline(always)]
    pub fn hide_twins(&mut self) {
        if let [first, second, ..] = &self.0[..]
            && first.at == second.at
        {
            self.hide_first();
        }
    }

    /// When the first event comes.
    #[inline(always)]
    pub fn next(&self, none: C) -> C {
        self.0.first().map_or(none, |due| due.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whoever comes next by looking at all of them is first, over many turns of the counter, with
    /// events up to a quarter of it away; so it is where an axis is late.
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
                    // A look round, which may come too early and never too late.
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
