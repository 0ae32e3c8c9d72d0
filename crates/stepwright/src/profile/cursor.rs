//! Makes runs of a path: a cursor that walks the closed form.
//!
//! Between pulses n and n + N the true time is nearly a parabola. The run
//! takes its growth from the intervals c = f/v at both ends and its first
//! interval from the exact time Δt between them:
//!
//! ```text
//!   add = (c₂ − c₁)/N        interval = (Δt − add·N(N−1)/2)/N
//! ```
//!
//! So a run ends where the closed form says, and errors never accumulate: the rest of the rounding
//! is added to the next run. Between its ends the run is off by about t‴·N³/125, and the *defect of
//! the trapezoid rule* measures just that without another root or division:
//!
//! ```text
//!   N·(c₁ + c₂)/2 − Δt = t‴·N³/12        error ≤ defect / 4
//! ```
//!
//! (The error is about a tenth of the defect while t‴ hardly changes. A quarter is the bound for
//! any t‴ ≥ 0: if t‴ is concentrated at one place x of the run, the largest error is (1 − x/N)/4 or
//! (x/N)/4 of the defect, and every t‴ is a sum of such cases. While c changes by less than a
//! sixteenth, t‴ ∝ c⁵ changes by less than a factor of 1.38; then at least 1/1.38 of the defect has
//! an error of a tenth, and the rest a quarter: 0.139 in all.)
//!
//! Every run is checked with this bound; a run that exceeds it is halved. Lengths are powers of
//! two, so that a division by N is a shift. A whole ramp is a few dozen runs.

use super::Runs;
use super::path::Path;
use crate::fixed::{ONE, Q32, portion, root, shl, shr, slope, zeros};
use crate::run::Run;
use crate::units::{Rate, Ticks};

/// How closely runs follow their profile, and how long they may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fit {
    /// The largest error of a step's time, in 2⁻³² ticks.
    pub(crate) error: Q32,
    /// The longest run, in ticks; a single step may always take longer.
    pub(crate) longest: Ticks,
    /// The longest ramp run and the longest level run, as powers of two.
    pub(crate) ramp_size: u8,
    pub(crate) level_size: u8,
}

impl Fit {
    /// For the single steps of a profile: runs within 0.375 ticks, their growth rounded to 0.063,
    /// deadlines rounded to 0.5; together within one tick of the ideal.
    pub const EXACT: Fit = Fit { error: 3 << 29, ..Fit::new(1 << 30, 1 << 24) };

    /// The default for a board: within 1 µs or a tick, whichever is longer, and runs of at most 8
    /// ms, so that a change takes effect soon.
    pub const fn board(rate: Rate) -> Fit {
        let micro = rate.hz() / 1_000_000;
        Fit::within(if micro == 0 { 1 } else { micro }, rate.hz() / 125)
    }

    /// Steps within `error` ticks (at least 1) of their time, in runs of at
    /// most `longest` ticks.
    pub const fn within(error: Ticks, longest: Ticks) -> Fit {
        Fit::new((if error == 0 { 1 } else { error } as u64) << 32, longest)
    }

    /// The same error, in runs of at most `longest` ticks.
    pub const fn lasting(self, longest: Ticks) -> Fit {
        Fit { longest, ..self }
    }

    /// `size`, or the largest value below it for which a run with intervals `c` is not too long.
    pub(super) fn shorter(&self, c: Q32, mut size: u8) -> u8 {
        while size > 0 && (c >> 32) > u64::from(self.longest) >> size {
            size -= 1;
        }
        size
    }

    const fn new(error: Q32, longest: Ticks) -> Fit {
        // `add` is rounded to 2⁻¹⁷ ticks. In the middle of N steps this makes an error of N²/8 ·
        // 2⁻¹⁷, which may be a quarter of `error` at most: N² ≤ error · 2¹⁸. A level interval is
        // rounded to 2⁻¹⁶, N of them to N · 2⁻¹⁶.
        let bits = (64 - error.leading_zeros() - 1) as u8; // error ≥ 2^bits
        let ramp = (bits + 18 - 32) / 2;
        let level = bits + 16 - 32 - 2;
        Fit {
            error: error - error / 3,
            longest,
            ramp_size: if ramp > 14 { 14 } else { ramp },
            level_size: if level > 15 { 15 } else { level },
        }
    }
}

/// Walks a [`Path`] and yields its [runs](Run).
///
/// Each run starts from the exact time of the step before it, so any mixture of runs adds up to the
/// path's own time. A ramp run takes a root, two divisions and a 64-bit product. This is for hosts:
/// linked for an ATmega328P it takes 20 KB; boards plan with 32-bit numbers instead.
#[derive(Clone, Debug)]
pub struct Cursor {
    path: Path,
    fit: Fit,
    /// The last pulse handed out, its speed² and its speed.
    n: u32,
    w: u64,
    v: u64,
    /// The interval at v; `u64::MAX` at rest.
    c: Q32,
    /// How far the runs handed out are behind the path, in 2⁻³² ticks.
    lag: i64,
    /// The run length to try next, as a power of two.
    size: u8,
}

/// Half a tick ahead, so that deadlines rounded down are rounded to nearest.
pub(super) const HALF_TICK: i64 = 1 << 31;

impl Cursor {
    /// A cursor at the path's first pulse.
    pub fn new(path: Path, fit: Fit) -> Cursor {
        let mut cursor = Cursor { path, fit, n: 0, w: 0, v: 0, c: 0, lag: HALF_TICK, size: 0 };
        cursor.stand(0);
        cursor
    }

    /// A cursor at pulse `n`: the next run begins there.
    pub fn at(path: Path, fit: Fit, n: u32) -> Cursor {
        let mut cursor = Cursor::new(path, fit);
        cursor.stand(if path.is_endless() { n } else { n.min(path.length()) });
        cursor
    }

    fn stand(&mut self, n: u32) {
        self.n = n;
        self.w = self.path.w_at(n);
        self.v = root(self.w);
        self.c = slope(self.path.rate, self.v);
    }

    /// The path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A ramp run of at most `room` steps, with w changing by ±`slope2` per step.
    fn ramp(&mut self, room: u32, slope2: u64, up: bool) -> Run {
        let scale = if self.n_is_rising() { self.path.rise } else { self.path.fall };
        let mut size = self.size.min(self.fit.ramp_size).min(floor_log2(room));
        loop {
            // Runs longer than the longest are not tried.
            size = self.fit.shorter(self.c, size);
            let change = shl(slope2, size);
            let w = if up { self.w.wrapping_add(change) } else { self.w.saturating_sub(change) };
            let v = root(w);
            let time = scale.time(v.abs_diff(self.v));
            let c = slope(self.path.rate, v);
            let defect = defect(self.c, c, time, size);
            let error = if c.abs_diff(self.c) < self.c >> 4 {
                (defect >> 3) + (defect >> 6)
            } else {
                defect >> 2
            };
            let fits = size == 0 || error <= self.fit.error;
            let Some((run, lag)) = fitted(time, self.lag, self.c, c, size).filter(|_| fits) else {
                size -= 1; // a single step always fits
                continue;
            };
            self.size = if error.saturating_mul(8) <= self.fit.error {
                size + 1
            } else if !up && error.saturating_mul(2) > self.fit.error {
                size.saturating_sub(1)
            } else {
                size
            };
            self.n = self.n.wrapping_add(1 << size);
            (self.w, self.v, self.c, self.lag) = (w, v, c, lag);
            return run;
        }
    }

    fn n_is_rising(&self) -> bool {
        u64::from(self.n) << 32 < self.path.accel_end
    }

    /// A level run of at most `room` steps.
    fn level(&mut self, room: u32) -> Run {
        let c = self.path.level;
        let mut size = self.fit.level_size.min(floor_log2(room));
        while size > 0 && (c >> (63 - size) != 0 || (c << size) >> 32 > u64::from(self.fit.longest))
        {
            size -= 1;
        }
        let time = shl(c, size).wrapping_add_signed(self.lag);
        let run = Run::new(shr(time >> 16, size), 0, 1 << size);
        self.lag = time.wrapping_sub(run.duration() << 16) as i64;
        if self.path.is_endless() {
            self.n = self.n.max(floor(self.path.accel_end).saturating_add(1));
        } else {
            self.n = self.n.wrapping_add(1 << size);
        }
        (self.w, self.v, self.c) = (self.path.w_peak, self.path.v_peak, c);
        run
    }

    /// The one step that contains a corner of the path.
    fn corner(&mut self) -> Run {
        let path = &self.path;
        let from = u64::from(self.n) << 32;
        let to = from.saturating_add(ONE);
        let mut time = 0u64;
        if from < path.accel_end {
            time = path.rise.time(path.v_peak.abs_diff(self.v));
        }
        let level = to.min(path.decel_start).saturating_sub(from.max(path.accel_end));
        time = time.saturating_add(match level {
            ONE => path.level,
            part => portion(path.level, part as u32),
        });
        let w = path.w_at(self.n + 1);
        let v = root(w);
        if to > path.decel_start {
            time = time.saturating_add(path.fall.time(path.v_peak.abs_diff(v)));
        }
        let (run, lag) = single(time, self.lag);
        self.n += 1;
        (self.w, self.v, self.c, self.lag) = (w, v, slope(path.rate, v), lag);
        self.size = 0;
        run
    }
}

impl Runs for Cursor {
    fn steps_left(&self) -> u32 {
        if self.path.is_endless() { u32::MAX } else { self.path.length().saturating_sub(self.n) }
    }
}

impl Iterator for Cursor {
    type Item = Run;

    fn next(&mut self) -> Option<Run> {
        let length = self.path.length();
        if self.n >= length && !self.path.is_endless() {
            return None;
        }
        let at = u64::from(self.n) << 32;
        let (accel_end, decel_start) = (self.path.accel_end, self.path.decel_start);
        let run = if at < accel_end {
            match floor(accel_end) - self.n {
                0 => self.corner(),
                room => self.ramp(room, self.path.a2, !self.path.sinks),
            }
        } else if at < decel_start {
            match floor(decel_start).saturating_sub(self.n) {
                0 => self.corner(),
                room => self.level(room),
            }
        } else {
            if self.n == floor(decel_start) {
                // Rounding has moved a peak between two steps onto a step: the fall begins exactly
                // there.
                self.stand(self.n);
            }
            self.ramp(length - self.n, self.path.d2, false)
        };
        Some(run)
    }
}

/// 2^size steps in `time` and the `lag` before it, while the interval changes from `c1` to `c2`;
/// and the lag that remains. `None` if a run can't represent them.
pub(super) fn fitted(time: Q32, lag: i64, c1: Q32, c2: Q32, size: u8) -> Option<(Run, i64)> {
    if size == 0 {
        return Some(single(time, lag));
    }
    let growth = c2.wrapping_sub(c1) as i64;
    let add = (growth >> (size + 15)).wrapping_add(1) >> 1;
    let add = i32::try_from(add).ok()?;
    let steps = 1i64 << size;
    let triangle = i64::from(add) * (steps * (steps - 1) / 2);
    let time = time.checked_add_signed(lag)?;
    let interval = u64::try_from(((time >> 16) as i64).checked_sub(triangle)? >> size).ok()?;
    let run = Run::new(interval, add, steps as u16);
    if interval >> 48 != 0 || run.last_interval() >> 48 != 0 {
        return None;
    }
    Some((run, time.wrapping_sub(run.duration() << 16) as i64))
}

/// One step after `time`, in whole 2⁻¹⁶ ticks; and the lag that remains.
pub(super) fn single(time: Q32, lag: i64) -> (Run, i64) {
    let total = time.saturating_add_signed(lag);
    (Run::new(total >> 16, 0, 1), (total & 0xFFFF) as i64)
}

/// N·(c₁ + c₂)/2 − Δt, never negative, saturated.
fn defect(c1: Q32, c2: Q32, time: Q32, size: u8) -> u64 {
    let mean = (c1 >> 1).saturating_add(c2 >> 1);
    if zeros(mean) <= size {
        return u64::MAX;
    }
    shl(mean, size).saturating_sub(time)
}

fn floor(at: Q32) -> u32 {
    (at >> 32) as u32
}

/// floor(log₂ n); 0 for 0.
pub(super) fn floor_log2(n: u32) -> u8 {
    n.checked_ilog2().unwrap_or(0) as u8
}
