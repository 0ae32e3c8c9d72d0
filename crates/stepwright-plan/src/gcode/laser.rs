//! The power of a laser as a signal over time, computed from the speeds of its job.
//!
//! ```text
//!   power   1 ┤      ┌──────────┐                M4 S1000: in proportion to the speed
//!             │   ┌──┘          └──┐
//!           ½ ┤ ┌─┘                └─┐  ┌──┐
//!             │┌┘                    └┐┌┘  └┐
//!           0 ┼┘                      └┘    └────────────┐
//!              ├── G1 ───────────────┴── G1 ┤  G4, G0    time
//! ```
//!
//! Each change holds until the next one, as with a pulse width. Along a ramp the changes are so close that
//! the power is never further than [`WITHIN`] from the wanted power. Where the wanted power is constant, the
//! signal is exact, and so are the times at which it turns on and off.

use std::collections::VecDeque;

use stepwright_path::{Glide, LaserMove};

/// How far the power may be off while it changes: one step of a pulse width of 8 bits.
pub const WITHIN: f64 = 1.0 / 255.0;

/// The shortest part of a ramp, in s.
const SHORTEST: f64 = 1e-6;

/// The laser has this power from this time on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerChange {
    /// Time in s after the start.
    pub time: f64,
    /// Power from 0, off, to 1.
    pub power: f64,
}

/// The power so far, and the changes not yet taken.
#[derive(Clone, Debug)]
pub(super) struct LaserSignal {
    /// S at full power.
    most: f64,
    power: f64,
    pub changes: VecDeque<PowerChange>,
}

impl LaserSignal {
    /// The signal of a laser that has full power at S = `most`.
    pub fn new(most: f64) -> LaserSignal {
        LaserSignal { most, power: 0.0, changes: VecDeque::new() }
    }

    /// Adds a glide along a move with these laser settings.
    pub fn follow(&mut self, glide: &Glide, along: LaserMove) {
        let [from, to] = glide.times;
        if glide.is_rest() || !along.is_on() {
            return self.change(from, 0.0, true);
        }
        let turn = glide.turn().unwrap_or(to);
        let most = self.most;
        let power = |time| (along.s(glide.speed(time)) / most).min(1.0);
        let (a, b, c) = (power(from), power(turn), power(to));
        self.part(&power, [from, turn], [a, b]);
        self.part(&power, [turn, to], [b, c]);
    }

    /// Adds a time in which the power only rises or only falls between two values.
    fn part(&mut self, power: &impl Fn(f64) -> f64, times: [f64; 2], ends: [f64; 2]) {
        let ([from, to], [a, b]) = (times, ends);
        if to <= from {
            return;
        }
        if (a - b).abs() > WITHIN && to - from > SHORTEST {
            let middle = from + (to - from) / 2.0;
            let half = power(middle);
            self.part(power, [from, middle], [a, half]);
            self.part(power, [middle, to], [half, b]);
        } else {
            self.change(from, (a + b) / 2.0, a == b);
        }
    }

    /// Adds a change of power. While the power changes, leaves out changes too small to matter.
    fn change(&mut self, time: f64, power: f64, exact: bool) {
        let off = (power - self.power).abs();
        let stays = if exact { off == 0.0 } else { off < WITHIN / 2.0 && self.power > 0.0 };
        if !stays {
            self.power = power;
            self.changes.push_back(PowerChange { time, power });
        }
    }
}
