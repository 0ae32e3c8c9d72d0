//! Austin's laws in f64, as the ideal for the core's delays.
//!
//! A travel is N steps up from c₀, some at the speed reached, and J − 1 down; the J-th is the hold after
//! the last pulse. An implementation of [`Ramps`] computes a delay from the delay before by the
//! [`equations`](crate::equations). Times are summed in 104 bits.

use std::cell::RefCell;

use stepwright_oracle::{Double, Number};

use crate::watch::{Walk, Watch};

/// The ramps up and down of a law.
pub(crate) trait Ramps {
    /// Goes one step up on the ramp from rest.
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
    /// n, for laws whose n is not `i`.
    pub n: f64,
    /// The number of breaks so far.
    pub crossed: usize,
}

/// The turn of a travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Turns {
    /// N.
    pub up: u32,
    /// J.
    pub down: u32,
    /// Whether the ramp reached its end, and the travel is not too short for it.
    pub complete: bool,
}

/// A travel by Austin's equations.
pub(crate) struct Formula {
    pulses: u32,
    ramps: Box<dyn Ramps>,
    /// c₀ as emitted, and c₀ from which the ramp continues.
    first: (f64, f64),
    /// c_min.
    least: f64,
    /// Delays up, level and down, and the unclamped level delay.
    up: u32,
    level: u32,
    down: u32,
    /// J: the step of the ramp down at which braking begins, for travels of any length.
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
    /// A travel of `pulses` pulses with c₀ as emitted and c₀ from which the ramp continues. No delay is
    /// shorter than `least`.
    pub fn new(
        ramps: Box<dyn Ramps>,
        pulses: u32,
        first: (f64, f64),
        least: f64,
        turns: Turns,
        watch: Watch<'_>,
    ) -> Formula {
        let delays = pulses.saturating_sub(1);
        // The first delay is c₀, even if the travel is shorter than the way down.
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

    /// The number of pulses.
    pub fn pulses(&self) -> u32 {
        self.pulses
    }

    /// The delays up, level and down.
    pub fn parts(&self) -> (u32, u32, u32) {
        (self.up, self.level, self.down)
    }

    /// Whether the travel was long enough for the ramp.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// The shortest delay.
    pub fn shortest(&self) -> f64 {
        let held = if self.up + self.level > 1 { self.held } else { self.first.0 };
        held.max(self.least)
    }

    /// The time of pulse `n`, in ticks after the first. Fast if asked in order.
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

    /// Goes to the next pulse, or at once through the level part, but not beyond `n`.
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

/// Computes the turn for a law without a closed form. The way down is a ramp of its own, entered at its
/// first step that is as fast as the way up. Delays of `enough` or less count as the top speed.
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
            // With a power term the speed approaches a limit and never reaches it.
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
