//! A motion under Austin's law that can be changed at any step.
//!
//! ```text
//!   w₁ = w₀ ± 2a                     speed², a step on: v² = v₀² ± 2as
//!   c₁ = c₀ − 2·c₀ / (4n + 1)        Eq 13, n + ½ = ± w₁ / 2a
//!      = c₀ · (3w₀ + w₁) / (w₀ + 3w₁)
//! ```
//!
//! (n + ½)·a, which Eq 18 keeps where the acceleration changes, is half of w. So the motion is
//! described by w, and for any acceleration that leads from w₀ to w₁, Eq 13 is the second line: up,
//! down, and for a step with only a part of a.
//!
//! Each step takes the largest w₁ within the limits:
//!
//! ```text
//!   room(left) = (2·left + 1)·d       `left` steps before the end, at most
//!   w₀ + 2a, or a where w₀ < a        below the top speed
//!   w₀ − 2d                           above it
//! ```
//!
//! The way down follows the room: n = −left (Eq 14), so the last delay is the first one of a ramp,
//! and the step at which it begins takes the remainder. A motion slower than the first step of a
//! ramp begins a ramp, with 0.676·c₀ (Eq 15), like one from rest: Eq 18 makes n negative there, and
//! Eq 13 would take several times as long. At the top speed c is exactly c_min.
//!
//! **A change** continues from the present delay, and w stays (Eq 18). The error of Eq 13 near |n|
//! = 1 (Table 1) would accumulate from change to change. So if w is more than 1/32 off f²/c², it is
//! set to that (Eq 16), unless the target would be out of reach then.
//!
//! **Error**: each delay, and the time of each pulse, is within one tick of these formulas in f64
//! (0.55 ticks measured over 750,000 changes). The speed f/c against v² = v₀² ± 2as: 4.4 % too fast
//! in a ramp's first step, by Eq 15, and 1/64n² from the second; after changes within a ramp's
//! first steps up to 6.4 %. The acceleration by Eq 3 keeps its limit, except in a fall right after
//! a first step, which may be 9.4 % too steep. **Cost**: a step takes one division, a change one or
//! two more; in 128 bits, for hosts.

use crate::share::{mul_div, share};
use core::cmp::Ordering;
use stepwright::fixed::{self, ONE, Q32, root_fine};
use stepwright::profile::Unfit;
use stepwright::profile::{Bounds, slope_of};
use stepwright::units::{Accel, Rate, Speed, Ticks};

/// Speed² in 2⁻³² · 10⁻⁶ (steps/s)².
type Square = u128;

/// A motion along one axis, from rest at 0: one delay at a time, with a new target, top speed,
/// acceleration or deceleration at any of them.
///
/// As an iterator it returns the delay before each pulse, the very first 0, and ends at the target;
/// after a [`retarget`](Self::retarget) there it continues. Before the delay has passed,
/// [`is_forward`](Self::is_forward) is the direction of its pulse.
///
/// A delay is computed when it is asked for, from all changes until then: a change takes effect
/// with the next delay, one step after the delay that is being waited for.
///
/// ```
/// use stepwright_austin::Motion;
/// use stepwright::{Accel, Rate, Speed};
/// let (slow, fast) = (Speed::from_steps(200)?, Speed::from_steps(400)?);
/// let mut motion = Motion::new(Rate::MHZ, slow, Accel::from_steps(400)?)?;
/// motion.retarget(1000);
/// let up: Vec<u32> = motion.by_ref().take(100).collect();
/// assert_eq!((up[1], up[2], up[99]), (47_800, 28_681, 5_000));
/// motion.set_top_speed(fast)?; // faster, from the speed that there is
/// assert_eq!(motion.by_ref().nth(200), Some(2_500));
/// motion.retarget(20); // behind: to rest, and back
/// let back = motion.by_ref().inspect(|delay| assert!(*delay <= 50_000)).count();
/// assert_eq!((back, motion.position()), (200 + 481, 20));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Motion {
    bounds: Bounds,
    /// The top speed: c_min, and its square.
    shortest: Q32,
    top: Square,
    /// The last pulse handed out, and whether there has been one.
    position: i64,
    begun: bool,
    target: i64,
    /// Where the motion comes to rest: the target, or beyond it.
    end: i64,
    forward: bool,
    /// Speed² in the middle of the last delay, and that delay; 0 at rest.
    w: Square,
    count: Q32,
    /// The fraction of a tick that is carried, half a tick ahead.
    part: u32,
}

impl Motion {
    /// A motion at rest at 0, which is its target. `accel` is the deceleration too.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn new(rate: Rate, top: Speed, accel: Accel) -> Result<Motion, Unfit> {
        let slope = slope_of(accel);
        let bounds = Bounds { rate, start: Speed::ZERO, top, a2: slope, d2: slope };
        let mut motion = Motion {
            bounds,
            shortest: 0,
            top: 0,
            position: 0,
            begun: false,
            target: 0,
            end: 0,
            forward: true,
            w: 0,
            count: 0,
            part: 1 << 31,
        };
        motion.bind(bounds)?;
        Ok(motion)
    }

    /// Sets another target, counted from where the motion began. If it is behind, or if braking
    /// would pass it, the motion comes back to it.
    pub fn retarget(&mut self, target: i32) {
        self.target = target.into();
        self.settle();
    }

    /// Sets another top speed. Above it the speed falls at the deceleration.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it; the motion continues unchanged.
    pub fn set_top_speed(&mut self, top: Speed) -> Result<(), Unfit> {
        self.bind(Bounds { top, ..self.bounds })
    }

    /// Sets another acceleration.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it; the motion continues unchanged.
    pub fn set_accel(&mut self, accel: Accel) -> Result<(), Unfit> {
        self.bind(Bounds { a2: slope_of(accel), ..self.bounds })
    }

    /// Sets another deceleration. With a lower one the motion may pass the target and come back.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it; the motion continues unchanged.
    pub fn set_decel(&mut self, decel: Accel) -> Result<(), Unfit> {
        self.bind(Bounds { d2: slope_of(decel), ..self.bounds })
    }

    /// Makes a soft stop: the target is the next whole step at which the deceleration allows it.
    pub fn stop(&mut self) {
        let left = self.left();
        self.correct(|steps| steps <= left);
        self.end = self.ahead(self.braking(self.w));
        self.target = self.end;
    }

    /// The place of the last pulse, counted from where the motion began.
    pub fn position(&self) -> i64 {
        self.position
    }

    /// The target.
    pub fn target(&self) -> i64 {
        self.target
    }

    /// Whether the last pulse goes forward.
    pub fn is_forward(&self) -> bool {
        self.forward
    }

    /// The speed of the last delay, rounded to nearest (Eq 2).
    pub fn speed(&self) -> Speed {
        let v = if self.w == 0 { 0 } else { (reciprocal(self.bounds.rate, self.count) >> 32) + 1 };
        let v = u32::try_from(v >> 1).unwrap_or(u32::MAX);
        Speed::from_millisteps(v).unwrap_or(Speed::MAX)
    }

    /// Sets other limits, all or none.
    fn bind(&mut self, bounds: Bounds) -> Result<(), Unfit> {
        bounds.check()?;
        self.bounds = bounds;
        self.settle(); // with the old top speed: it may be the present speed
        self.shortest = fixed::interval(bounds.rate, bounds.top);
        self.top = Square::from(bounds.top.squared()) << 32;
        if self.shortest < ONE {
            // A timer can't be faster than its ticks.
            self.shortest = ONE;
            self.top = square(reciprocal(bounds.rate, ONE));
        }
        Ok(())
    }

    /// Finds where the motion comes to rest, from the present delay.
    fn settle(&mut self) {
        if self.w == 0 {
            self.end = self.position; // the next step chooses the direction
            return;
        }
        let way = match self.forward {
            true => self.target.saturating_sub(self.position),
            false => self.position.saturating_sub(self.target),
        };
        let within = |steps: u64| i64::try_from(steps).is_ok_and(|steps| steps <= way);
        self.correct(within);
        let steps = self.braking(self.w);
        self.end = if within(steps) { self.target } else { self.ahead(steps) };
    }

    /// Sets w from the present delay if Eq 13 has drifted from it, or if the target is `within`
    /// reach only then.
    fn correct(&mut self, within: impl Fn(u64) -> bool) {
        let seen = match self.w {
            0 => return,
            _ if self.count == self.shortest => self.top, // exact
            _ => square(reciprocal(self.bounds.rate, self.count)),
        };
        let (by_delay, by_w) = (within(self.braking(seen)), within(self.braking(self.w)));
        let slack = if by_w && !by_delay { self.w + 4 * self.d2() } else { self.w };
        if by_delay && !by_w || seen.abs_diff(self.w) > slack / 32 {
            self.w = seen;
        }
    }

    /// The least number of steps to rest: Eq 18, rounded to a whole step.
    fn braking(&self, w: Square) -> u64 {
        let d2 = self.d2();
        u64::try_from((2 * w + d2 - 1) / (2 * d2)).unwrap_or(u64::MAX)
    }

    /// The steps to where the motion comes to rest.
    fn left(&self) -> u64 {
        self.position.abs_diff(self.end)
    }

    /// The place this many steps ahead.
    fn ahead(&self, steps: u64) -> i64 {
        match self.forward {
            true => self.position.saturating_add_unsigned(steps),
            false => self.position.saturating_sub_unsigned(steps),
        }
    }

    /// 2a and 2d: the change of speed² in a step up and in a step down.
    fn a2(&self) -> Square {
        Square::from(self.bounds.a2.max(1)) << 32
    }

    fn d2(&self) -> Square {
        Square::from(self.bounds.d2.max(1)) << 32
    }

    /// Moves to the next delay, with `left` steps after it.
    fn advance(&mut self, left: u64) {
        let (w, a2) = (self.w, self.a2());
        let room = (self.d2() / 2).saturating_mul(2 * Square::from(left) + 1);
        // At rest the count has no meaning.
        let side = if w == 0 { Ordering::Greater } else { self.count.cmp(&self.shortest) };
        let next = match side {
            Ordering::Greater if 2 * w < a2 => (a2 / 2).min(room),
            Ordering::Greater => (w + a2).min(room),
            Ordering::Equal => w.min(room),
            Ordering::Less if room < self.top => w.min(room),
            Ordering::Less => w.saturating_sub(self.d2()).max(self.top / 2).min(w),
        };
        let count = self.delay(next);
        let reached = match side {
            Ordering::Greater => count <= self.shortest,
            Ordering::Equal => false,
            Ordering::Less => count >= self.shortest && room >= self.top,
        };
        (self.count, self.w) =
            if reached { (self.shortest, self.top.min(room)) } else { (count, next) };
    }

    /// The delay at `next`, after the present one.
    fn delay(&self, next: Square) -> Q32 {
        let (w, rate) = (self.w, self.bounds.rate);
        if next > w && 2 * w < self.a2() {
            // 0.676·c₀, with c₀ = f·√(2/a) and a = w: n = 0.
            let first = share(reciprocal(rate, root(2 * next)), 2 * 676, 1000);
            return if w == 0 { first } else { first.min(self.count) };
        }
        if w > 3 * next {
            return reciprocal(rate, root(next));
        }
        let (n, d) = (3 * w + next, w + 3 * next);
        let by = (128 - n.max(d).leading_zeros()).saturating_sub(63);
        share(self.count, (n >> by) as u64, (d >> by) as u64)
    }
}

impl Iterator for Motion {
    type Item = Ticks;

    fn next(&mut self) -> Option<Ticks> {
        let first = !self.begun;
        if self.position == self.end {
            if self.position == self.target {
                return None;
            }
            (self.forward, self.end) = (self.target > self.position, self.target);
            self.begun = true;
        }
        let left = self.left().saturating_sub(1);
        self.position = self.ahead(1);
        if first {
            return Some(0);
        }
        self.advance(left);
        if left == 0 {
            self.w = 0;
        }
        let due = self.count.saturating_add(self.part.into());
        self.part = due as u32;
        Some((due >> 32) as Ticks)
    }
}

/// f / v in 2⁻³² ticks, for a speed in 2⁻³³ · 0.001 steps/s; and the inverse. Saturates.
fn reciprocal(rate: Rate, x: u64) -> u64 {
    // 1000·f < 2³⁸, times 2³³ · 2³²
    mul_div((1000 * u64::from(rate.hz())) << 25, 1 << 40, x).0
}

/// v² for a speed in 2⁻³³ · 0.001 steps/s.
fn square(v: u64) -> Square {
    (Square::from(v) * Square::from(v)) >> 34
}

/// √w in 2⁻³³ · 0.001 steps/s.
fn root(w: Square) -> u64 {
    root_fine(u64::try_from(w >> 32).unwrap_or(u64::MAX), w as u32)
}
