//! Austin's laws in f64: what the core's delays are measured against.
//!
//! A travel is N steps up from c₀, some at the speed reached, and J − 1 down,
//! the J-th being the hold after the last pulse. One of [`Ramps`] makes a delay
//! from the one before, by the [`equations`](crate::equations); times are added up in 104 bits.

use std::cell::RefCell;

use stepwright_oracle::{Double, Number};

use crate::watch::{Walk, Watch};

/// Both ramps of a law.
pub(crate) trait Ramps {
    /// From rest one step up.
    fn faster(&self, at: &mut At);

    /// The delay after `c` on the way down, j steps before the end.
    fn slower(&self, c: f64, j: u32) -> f64;
}

/// A place on a ramp from rest.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct At {
    /// Steps from rest.
    pub i: u32,
    /// The delay.
    pub c: f64,
    /// n, where it is another number.
    pub n: f64,
    /// Breaks so far.
    pub crossed: usize,
}

/// Where a travel turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Turns {
    /// N.
    pub up: u32,
    /// J.
    pub down: u32,
    /// Whether the ramp ended by itself, not because the travel is too short.
    pub complete: bool,
}

/// A travel by Austin's equations.
pub(crate) struct Formula {
    pulses: u32,
    ramps: Box<dyn Ramps>,
    /// c₀ as emitted, and as the ramp goes on from it.
    first: (f64, f64),
    /// c_min.
    least: f64,
    /// Delays up, level and down, and the unclamped delay that is held.
    up: u32,
    level: u32,
    down: u32,
    /// J: the way down begins there, whatever is left of the travel.
    braking: u32,
    held: f64,
    complete: bool,
    cursor: RefCell<Cursor>,
}

/// The last pulse asked for.
#[derive(Clone, Copy)]
struct Cursor {
    pulse: u32,
    at: At,
    time: Double,
}

impl Formula {
    /// `pulses` pulses: c₀ as emitted and as the ramp goes on from it; no delay
    /// is shorter than `least`.
    pub fn new(
        ramps: Box<dyn Ramps>,
        pulses: u32,
        first: (f64, f64),
        least: f64,
        turns: Turns,
        watch: Watch<'_>,
    ) -> Formula {
        let delays = pulses.saturating_sub(1);
        // The first delay is c₀, also of a travel that is shorter than its way down.
        let down = turns.down.saturating_sub(1).min(delays.saturating_sub(1));
        let up = (turns.up + 1).min(delays - down);
        let begin =
            Cursor { pulse: 0, at: At { c: first.1, ..At::default() }, time: Double::whole(0) };
        let mut at = begin.at;
        let mut work = Walk::new("ramp at", pulses, watch);
        for n in 1..up {
            ramps.faster(&mut at);
            work.at(n);
        }
        Formula {
            pulses,
            ramps,
            first,
            least,
            up,
            level: delays - down - up,
            down,
            braking: turns.down.max(1),
            held: at.c,
            complete: turns.complete,
            cursor: RefCell::new(begin),
        }
    }

    /// Pulses in all.
    pub fn pulses(&self) -> u32 {
        self.pulses
    }

    /// Delays up, level, down.
    pub fn parts(&self) -> (u32, u32, u32) {
        (self.up, self.level, self.down)
    }

    /// Whether the ramp was long enough for all it wanted.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// The shortest delay.
    pub fn shortest(&self) -> f64 {
        let held = if self.up + self.level > 1 { self.held } else { self.first.0 };
        held.max(self.least)
    }

    /// When pulse `n` comes, in ticks after the first. Quick when asked in order.
    pub fn time(&self, n: u32) -> Double {
        let mut cursor = self.cursor.borrow_mut();
        if n < cursor.pulse {
            let at = At { c: self.first.1, ..At::default() };
            *cursor = Cursor { pulse: 0, at, time: Double::whole(0) };
        }
        while cursor.pulse < n {
            self.step(&mut cursor, n);
        }
        cursor.time
    }

    /// To the next pulse, or at once through what is held, but not beyond `n`.
    fn step(&self, cursor: &mut Cursor, n: u32) {
        let Cursor { pulse, at, time } = cursor;
        let level = self.up + self.level;
        if *pulse < level && *pulse >= self.up {
            let held = Double::from_f64(self.held.max(self.least));
            let steps = n.min(level) - *pulse;
            *time = *time + held * Double::whole(steps.into());
            *pulse += steps;
            return;
        }
        let c = if *pulse == 0 {
            self.first.0
        } else if *pulse < self.up {
            self.ramps.faster(at);
            at.c
        } else {
            at.c = self.ramps.slower(at.c, self.braking - (*pulse - level));
            at.c
        };
        *time = *time + Double::from_f64(c.max(self.least));
        *pulse += 1;
    }
}

/// Turns for a law without a closed form: the way down is a ramp of its own,
/// followed at the first of its steps that is as fast. Delays of `enough` and
/// less are the top speed.
pub fn shadow(
    pulses: u32,
    enough: f64,
    mut rise: At,
    mut fall: At,
    faster: impl Fn(&mut At),
    mut follow: impl FnMut(&mut At),
    watch: Watch<'_>,
) -> Turns {
    let mut to = |fall: &mut At, c: f64, left: u64| {
        let mut next = *fall;
        while next.c > c.max(enough) {
            if u64::from(next.i) >= left {
                return false;
            }
            let before = next.c;
            follow(&mut next);
            // A power term comes near to a speed of its own, and no nearer.
            if next.c >= before {
                return false;
            }
        }
        *fall = next;
        u64::from(next.i) <= left
    };
    to(&mut fall, rise.c, u64::MAX);
    let turns = |rise: &At, fall: &At, complete| Turns { up: rise.i, down: fall.i, complete };
    let mut work = Walk::new("turn sought at", pulses, watch);
    while rise.c > enough {
        let mut next = rise;
        faster(&mut next);
        work.at(next.i);
        let left = u64::from(pulses).checked_sub(u64::from(next.i) + 1);
        if !left.is_some_and(|left| to(&mut fall, next.c, left)) {
            return turns(&rise, &fall, false);
        }
        rise = next;
    }
    turns(&rise, &fall, true)
}
