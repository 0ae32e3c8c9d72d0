//! A program as a source of entries, which is asked for each run.
//!
//! A queue is filled ahead. A program with bounds, switches and callbacks must react at a step, so
//! it is asked for a run when the last step of the previous run has been made. An entry is "pins,
//! then wait", and the wait of that step is not known before. So the step is an entry with a wait
//! of 0, and its wait is an entry without pins.
//!
//! ```text
//!             asked                                 asked
//!   step        │ nothing  step     step     step     │ nothing
//!   ────────────┴───────────┴────────┴────────┴───────┴──────────► ticks
//!   entries   0 │ wait      │ wait   │ wait   │ 0     │ wait
//! ```

use super::{Loaded, Source};
use crate::engine::{FACE, STEP, TURN};
use crate::entry::{NEAR, Play};
use crate::run::Run;
use crate::units::Ticks;

/// The answer of a [`Feed`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// Play this run.
    Run(Run),
    /// Play this run, whose intervals are all equal, with its first step after this many ticks: a
    /// part of the first interval has already passed.
    After(Ticks, Run),
    /// No run yet, but the travel is not over: the feed is late.
    Late,
    /// The travel is over.
    End,
}

/// A program that is asked for one run after another.
///
/// Called from the step interrupt, once per run: MUST NOT block, and should take no longer than the
/// shortest run.
pub trait Feed {
    /// Whether any of its runs has intervals that differ; if not, the code for them is left out.
    const GROWS: bool = true;

    /// The next run.
    fn take(&mut self) -> Taken;

    /// Forgets everything that is planned, after a kill.
    fn clear(&mut self);
}

/// A program as a source of entries.
#[derive(Clone, Debug)]
pub struct Asked<F> {
    /// The program.
    pub feed: F,
    /// What is left of the present run.
    run: Run,
    /// Whole ticks left of the first interval of `run`.
    wait: Ticks,
    due: Due,
    /// Whether the axis faces forward after all that was handed out.
    forward: bool,
}

/// What is handed out next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Due {
    /// The program is asked.
    Nothing,
    /// The wait before the run's first step or turn.
    Wait,
    /// The run's step or turn.
    Pins,
}

/// A long wait is handed out in pieces of 2^`PIECE` ticks …
const PIECE: u32 = 14;
/// … and at most this many pieces at a time.
const PIECES: Ticks = 1 << 15;

impl<F: Feed> Asked<F> {
    /// A program that has not been asked yet, for an axis that faces forward.
    pub const fn new(feed: F) -> Asked<F> {
        Asked { feed, run: Run::steady(0, 0), wait: 0, due: Due::Nothing, forward: true }
    }

    /// Steps of the present run that have not been handed out as entries.
    pub(crate) fn left(&self) -> u16 {
        if self.due == Due::Nothing { 0 } else { self.run.count }
    }

    /// Limits these to `steps`.
    pub(crate) fn cut(&mut self, steps: u16) {
        if steps == 0 {
            self.due = Due::Nothing;
        } else if self.run.count != 0 {
            self.run.count = steps;
        }
    }

    /// Hands out a piece of the wait.
    #[inline(always)]
    fn wait(&mut self, play: &mut Play) {
        if self.wait >= NEAR {
            // The last piece is a long one: a program's last step is late after half of it.
            let pieces = (self.wait >> PIECE).saturating_sub(1).clamp(1, PIECES);
            self.wait = self.wait.wrapping_sub(pieces << PIECE);
            return play.set(0, 1 << (PIECE + 16), pieces as u16);
        }
        self.due = Due::Pins;
        play.set(0, self.wait << 16 | Ticks::from(self.run.part), 1);
    }

    /// Hands out the turn, or the run's next steps.
    #[inline(always)]
    fn pins(&mut self, play: &mut Play) {
        let Run { ticks, part, count, add } = self.run;
        self.due = Due::Nothing;
        if count == 1 {
            return play.set(STEP, 0, 1);
        }
        if count == 0 {
            let forward = add != 0;
            let turns = core::mem::replace(&mut self.forward, forward) != forward;
            return play.set(if turns { FACE | TURN } else { FACE }, 0, 1);
        }
        if add == 0 && ticks < NEAR {
            // All steps but the last, whose wait is the program's next.
            (self.run.count, self.due) = (1, Due::Pins);
            return play.set(STEP, ticks << 16 | Ticks::from(part), count.wrapping_sub(1));
        }
        if add == 0 || !F::GROWS {
            // Step by step, as the interval is long.
            (self.run.count, self.wait, self.due) = (count.wrapping_sub(1), ticks, Due::Wait);
        } else {
            self.grow();
        }
        play.set(STEP, 0, 1);
    }

    /// Hands out the run's first wait and all its steps but the last in one entry, if its first and
    /// last interval are near: so a small chip does not run this at each step.
    #[inline(always)]
    fn whole(&mut self, play: &mut Play) -> Option<()> {
        let Run { ticks, part, count, add } = self.run;
        if ticks >= NEAR || count < 2 || add == 0 {
            return None;
        }
        // 16-bit products, which a small chip has.
        let (by, steps) = (add.unsigned_abs(), u32::from(count.wrapping_sub(1)));
        let high = (by >> 16).wrapping_mul(steps);
        if high >= NEAR {
            return None;
        }
        let way = (high << 16).wrapping_add((by & 0xFFFF).wrapping_mul(steps));
        let first = ticks << 16 | Ticks::from(part);
        let last = if add < 0 { first.checked_sub(way)? } else { first.checked_add(way)? };
        if last >> 16 >= NEAR || last >> 16 == 0 {
            return None;
        }
        play.grow(0, STEP, first, add, count);
        (self.run.count, self.due) = (1, Due::Pins);
        Some(())
    }

    /// Removes the first step from the run.
    #[cold]
    #[inline(never)]
    fn grow(&mut self) {
        let next = self.run.interval().wrapping_add_signed(self.run.add.into());
        self.run = Run::new(next, self.run.add, self.run.count.wrapping_sub(1));
        (self.wait, self.due) = (self.run.ticks, Due::Wait);
    }
}

impl<F: Feed> Source for Asked<F> {
    #[inline]
    fn load(&mut self, play: &mut Play) -> Loaded {
        match self.due {
            Due::Pins => {
                self.pins(play);
                return Loaded::Entry;
            }
            Due::Wait => {}
            Due::Nothing => {
                match self.feed.take() {
                    Taken::Run(run) => {
                        (self.run, self.wait) = (run, run.ticks);
                        if F::GROWS && self.whole(play).is_some() {
                            return Loaded::Entry;
                        }
                    }
                    Taken::After(wait, run) => (self.run, self.wait) = (run, wait),
                    Taken::Late => return Loaded::Late,
                    Taken::End => return Loaded::End,
                }
                self.due = Due::Wait;
            }
        }
        self.wait(play);
        Loaded::Entry
    }

    fn clear(&mut self, forward: bool) {
        (self.due, self.forward) = (Due::Nothing, forward);
        self.feed.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Once(Option<Run>);

    impl Feed for Once {
        fn take(&mut self) -> Taken {
            self.0.take().map_or(Taken::End, Taken::Run)
        }

        fn clear(&mut self) {}
    }

    #[test]
    fn a_long_wait_ends_with_a_long_piece() {
        for ticks in [1, 700, NEAR - 1, NEAR, 0x7FFF, 0x8000, 0x8001, 33_600, 1 << 20, Ticks::MAX] {
            let mut asked = Asked::new(Once(Some(Run::steady(ticks, 1))));
            let (mut waited, mut last) = (0, 0);
            loop {
                let mut play = Play::NONE;
                assert!(matches!(asked.load(&mut play), Loaded::Entry), "{ticks}");
                let Some((pins, wait)) = play.next() else { panic!("an entry without an event") };
                if pins & STEP != 0 {
                    break;
                }
                last = u64::from(wait);
                waited += last;
                waited += play.map(|(_, wait)| u64::from(wait)).sum::<u64>();
            }
            assert_eq!(waited, u64::from(ticks) << 16);
            // Nor is it longer than what a near wait may be.
            assert!(last >= (u64::from(ticks) << 16).min(16_000 << 16), "{ticks}: {last}");
            assert!(last < u64::from(NEAR) << 16, "{ticks}: {last}");
        }
    }
}
