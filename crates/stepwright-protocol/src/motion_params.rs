//! The motion parameters of an order, as S, T, R, s, t, a and d set them.

use stepwright::{Accel, Change, Jerk, OutOfRange, Speed};

use crate::grammar::MILLI;
use crate::number::{Whole, WholeAccel, WholeJerk};
use crate::order::{Order, Ramp, Travel};
use crate::raw_line::RawLine;
use crate::{Refusal, Setting, Settings};

/// All parameters of an order except the travel, in the units of the line. Each is inside the range
/// of its line: [`RawLine`](crate::raw_line::RawLine) has checked it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MotionParams {
    /// Start/stop speed, in steps/s.
    pub(crate) start: u32,
    /// Top speed, in 0.001 steps/s.
    pub(crate) top: u32,
    /// The ramp up as an acceleration, in steps/s²; 0: `ramp` applies.
    pub(crate) accel: u32,
    /// The ramp down, in the same way.
    pub(crate) decel: u32,
    /// The jerk limit, in steps/s³; 0: the acceleration changes at once.
    pub(crate) jerk: KeptJerk,
    /// The length of both ramps in steps. An acceleration that is not 0 takes precedence.
    pub(crate) ramp: u16,
}

/// The stored form of a jerk: none without S-curves, where its line is refused.
#[cfg(feature = "jerk")]
type KeptJerk = u32;
#[cfg(not(feature = "jerk"))]
type KeptJerk = ();

/// No jerk limit.
#[cfg(feature = "jerk")]
pub(crate) const NO_JERK: KeptJerk = 0;
#[cfg(not(feature = "jerk"))]
pub(crate) const NO_JERK: KeptJerk = ();

#[cfg(feature = "jerk")]
fn kept(jerk: u32) -> KeptJerk {
    jerk
}

#[cfg(not(feature = "jerk"))]
fn kept(_: u32) -> KeptJerk {}

impl MotionParams {
    /// S5 T100 R200: the parameters of an axis at power-up.
    pub(crate) const INITIAL: MotionParams =
        MotionParams { start: 50, top: 1_000_000, ramp: 200, ..MotionParams::BLANK };

    /// Sets [blank](MotionParams::BLANK) parameters to [`INITIAL`](MotionParams::INITIAL). Fields
    /// that are 0 need no code, and a constant of all fields would take RAM.
    pub(crate) fn begin(&mut self) {
        (self.start, self.top) = (MotionParams::INITIAL.start, MotionParams::INITIAL.top);
        self.ramp = MotionParams::INITIAL.ramp;
    }

    /// All 0, which is no valid motion.
    pub(crate) const BLANK: MotionParams =
        MotionParams { start: 0, top: 0, accel: 0, decel: 0, jerk: NO_JERK, ramp: 0 };

    /// Applies a line with this letter, after [`RawLine::unify`].
    pub(crate) fn set(&mut self, letter: u8, number: u32) {
        let place = match letter {
            b's' => &mut self.start,
            MILLI => &mut self.top,
            b'a' => &mut self.accel,
            b'd' => &mut self.decel,
            b'j' => {
                self.jerk = kept(number);
                return;
            }
            _ => {
                // R replaces the accelerations of a and d.
                (self.accel, self.decel) = (0, 0);
                self.ramp = number as u16;
                return;
            }
        };
        *place = number;
    }

    /// The jerk limit, if there is one.
    pub(crate) fn jerk(&self) -> Option<Jerk> {
        #[cfg(feature = "jerk")]
        return (self.jerk != 0).then(|| Jerk::clamped(self.jerk));
        #[cfg(not(feature = "jerk"))]
        None
    }

    /// The change that a line makes to a travel in progress: @, t, a or d.
    pub(crate) fn change(raw: &RawLine) -> Change {
        let number = raw.number;
        match raw.letter {
            b'@' => Change::Target(raw.steps()),
            MILLI => Change::Top(top(number)),
            b'a' => Change::Accel(Accel::clamped(number)),
            _ => Change::Decel(Accel::clamped(number)),
        }
    }

    /// The order for the core.
    pub(crate) fn order(&self, travel: stepwright::Travel) -> stepwright::Order {
        use stepwright::profile::Ramp;
        let steps = Ramp::Steps(self.ramp);
        let (start, top) = (speed(self.start), top(self.top));
        let jerk = self.jerk();
        let mut order = stepwright::Order { start, top, up: steps, down: steps, jerk, travel };
        if self.accel != 0 {
            order.up = Ramp::Accel(Accel::clamped(self.accel));
        }
        if self.decel != 0 {
            order.down = Ramp::Accel(Accel::clamped(self.decel));
        }
        order
    }

    /// The order as a master holds it.
    pub(crate) fn sent(&self, travel: Travel) -> Order {
        let ramp = |accel| match accel {
            0 => Ramp::Steps(Whole::clamped(self.ramp.into())),
            _ => Ramp::Accel(Accel::clamped(accel)),
        };
        Order {
            start: speed(self.start),
            top: top(self.top),
            up: ramp(self.accel),
            down: ramp(self.decel),
            jerk: self.jerk(),
            travel,
        }
    }

    /// Whether the settings of the board allow t, a or d during motion.
    #[inline(always)]
    pub(crate) fn check_change(raw: &RawLine, settings: &Settings) -> Result<(), Refusal> {
        let (number, limit, refusal) = match raw.letter {
            MILLI => (whole_speed(raw.number), Setting::MaxSpeed, Refusal::TooFast),
            _ => (raw.number, Setting::MaxAccel, Refusal::Ramp),
        };
        if number > settings.get(limit) { Err(refusal) } else { Ok(()) }
    }

    /// Whether the settings of the board allow these parameters.
    ///
    /// The top speed is checked even if a short travel does not reach it, so that a limit does not
    /// depend on the length of the travel.
    #[inline(never)]
    pub(crate) fn check(&self, settings: &Settings) -> Result<(), Refusal> {
        // A fraction of a step/s counts as a whole one, because a limit is a whole number.
        let (start, top) = (self.start, whole_speed(self.top));
        if top > settings.get(Setting::MaxSpeed) {
            return Err(Refusal::TooFast);
        }
        if self.jerk().is_some() && settings.byte(Setting::Law) == 0 {
            return Err(Refusal::NoJerk);
        }
        let max = settings.get(Setting::MaxAccel);
        if self.accel > max || self.decel > max {
            return Err(Refusal::Ramp);
        }
        // A ramp of so few steps that no acceleration in range expresses it is allowed only without
        // a limit.
        let limited = max < WholeAccel::LARGEST.get();
        if limited && top > start && (self.accel == 0 || self.decel == 0) {
            // (vt² − vs²) / 2R, multiplied out.
            let squares = product(top.wrapping_sub(start), top.wrapping_add(start));
            if squares > product(u32::from(self.ramp).wrapping_mul(2), max) {
                return Err(Refusal::Ramp);
            }
        }
        Ok(())
    }

    /// The motion parameters of an order. All but the top speed are rounded to whole steps.
    pub(crate) fn of(order: &Order) -> Result<MotionParams, OutOfRange> {
        let (mut steps, mut accel, mut decel) = (None, 0, 0);
        for (ramp, own) in [(order.up, &mut accel), (order.down, &mut decel)] {
            match ramp {
                Ramp::Accel(a) => {
                    *own = whole(a.millisteps(), (1, 100_000_000), "acceleration", "steps/s²")?;
                }
                Ramp::Steps(n) if steps.is_none_or(|other| other == n) => steps = Some(n),
                Ramp::Steps(n) => {
                    return Err(OutOfRange {
                        what: "ramp down, as long as the ramp up",
                        min: steps.unwrap_or(n).get().into(),
                        max: steps.unwrap_or(n).get().into(),
                        unit: "steps",
                    });
                }
            }
        }
        let (start, top) = (order.start.millisteps().into(), order.top.millisteps());
        if top == 0 {
            let (what, unit) = ("top speed", "thousandths of a step/s");
            return Err(OutOfRange { what, min: 1, max: 1_000_000_000, unit });
        }
        Ok(MotionParams {
            start: whole(start, (0, 1_000_000), "start speed", "steps/s")?,
            top,
            // With accelerations on both sides no ramp in steps is used.
            ramp: steps.map_or(MotionParams::INITIAL.ramp, |steps| steps.get() as u16),
            accel,
            decel,
            jerk: match order.jerk {
                Some(jerk) => {
                    let largest = WholeJerk::LARGEST.get();
                    kept(whole(jerk.millisteps(), (1, largest), "jerk", "steps/s³")?)
                }
                None => NO_JERK,
            },
        })
    }
}

/// A start speed of a motion, in steps/s.
fn speed(steps: u32) -> Speed {
    top(steps.wrapping_mul(1000))
}

/// A top speed of a motion. It is inside the core's range, so MAX never occurs.
#[inline(never)]
fn top(millisteps: u32) -> Speed {
    Speed::from_millisteps(millisteps).unwrap_or(Speed::MAX)
}

/// A top speed of up to 1,000,000,000 thousandths in whole steps/s, rounded up. (A division of any
/// two numbers would cost an 8-bit chip 1,300 bytes.)
#[inline(never)]
pub(crate) fn whole_speed(millisteps: u32) -> u32 {
    let (mut rest, mut whole) = (millisteps.wrapping_add(999), 0u32);
    let mut part = 1000u32 << 19;
    for _ in 0..20u8 {
        whole <<= 1;
        if rest >= part {
            rest = rest.wrapping_sub(part);
            whole |= 1;
        }
        part >>= 1;
    }
    whole
}

/// a · b in a form to compare: the quotient by 2048, and the remainder. Neither a times a 2048th of
/// b nor 2047 · a may reach 2³²: 1,000,000 times 2,000,000 and 1998 times 100,000,000 don't. (64
/// bits would cost an 8-bit chip 500 bytes.)
#[inline(never)]
fn product(a: u32, b: u32) -> (u32, u16) {
    let rest = a.wrapping_mul(b & 2047);
    let whole = a.wrapping_mul(b >> 11).wrapping_add(rest >> 11);
    (whole, rest as u16 & 2047)
}

/// Rounds thousandths to whole steps, half up.
fn whole(
    millisteps: u64,
    (min, max): (u32, u32),
    what: &'static str,
    unit: &'static str,
) -> Result<u32, OutOfRange> {
    let number = u32::try_from(millisteps.saturating_add(500) / 1000).ok();
    number.filter(|number| (min..=max).contains(number)).ok_or(OutOfRange {
        what,
        min: min.into(),
        max: max.into(),
        unit,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEAR: stepwright::Travel = stepwright::Travel::By(1);

    #[test]
    fn a_and_d_replace_their_half_and_r_both() {
        use stepwright::profile::Ramp;
        let mut params = MotionParams::INITIAL;
        let begin = params.order(NEAR);
        assert_eq!((begin.start.millisteps(), begin.top.millisteps()), (50_000, 1_000_000));
        let mut blank = MotionParams::BLANK;
        blank.begin();
        assert_eq!(blank, MotionParams::INITIAL);
        assert_eq!((begin.up, begin.down), (Ramp::Steps(200), Ramp::Steps(200)));
        params.set(b'a', 7000);
        let fast = Ramp::Accel(Accel::from_steps(7000).unwrap());
        assert_eq!((params.order(NEAR).up, params.order(NEAR).down), (fast, Ramp::Steps(200)));
        params.set(b'd', 100_000_000);
        assert_eq!(params.order(NEAR).down, Ramp::Accel(Accel::MAX));
        params.set(b'R', 9);
        assert_eq!(
            (params.order(NEAR).up, params.order(NEAR).down),
            (Ramp::Steps(9), Ramp::Steps(9))
        );
        params.set(b's', 1);
        params.set(b'm', 1_000_000_000);
        assert_eq!(
            (params.order(NEAR).start.millisteps(), params.order(NEAR).top),
            (1000, Speed::MAX)
        );
    }

    fn params(start: u32, top: u32, ramp: u16) -> MotionParams {
        MotionParams { start, top: top * 1000, ramp, ..MotionParams::BLANK }
    }

    fn with(setting: Setting, number: u32) -> Settings {
        let mut settings = Settings::new();
        settings.set(crate::Value::new(setting, number).unwrap());
        settings
    }

    #[test]
    fn the_defaults_forbid_nothing() {
        let settings = Settings::new();
        assert_eq!(params(0, 1_000_000, 1).check(&settings), Ok(()));
        let settings = with(Setting::MaxAccel, 99_999_999);
        assert_eq!(params(0, 1_000_000, 999).check(&settings), Err(Refusal::Ramp));
        assert_eq!(params(0, 440_000, 999).check(&settings), Ok(()));
        assert_eq!(params(1_000_000, 1_000_000, 1).check(&settings), Ok(()));
        assert_eq!(params(1_000_000, 999_999, 1).check(&settings), Ok(()));
    }

    #[test]
    fn limits_hold_to_the_step() {
        let settings = with(Setting::MaxSpeed, 4000);
        assert_eq!(params(50, 4000, 200).check(&settings), Ok(()));
        assert_eq!(params(50, 4001, 200).check(&settings), Err(Refusal::TooFast));
        // (1000² − 50²) / 400 = 2493.75
        let ramp = params(50, 1000, 200);
        assert_eq!(ramp.check(&with(Setting::MaxAccel, 2494)), Ok(()));
        assert_eq!(ramp.check(&with(Setting::MaxAccel, 2493)), Err(Refusal::Ramp));
        let settings = with(Setting::MaxAccel, 5000);
        for (accel, decel, fits) in
            [(5000, 5000, true), (5001, 5000, false), (5000, 5001, false), (1, 1, true)]
        {
            assert_eq!(MotionParams { accel, decel, ..ramp }.check(&settings).is_ok(), fits);
        }
        // The length of a ramp is not checked where an acceleration replaces it.
        let short = MotionParams { accel: 1, decel: 1, ..params(0, 1000, 1) };
        assert_eq!(short.check(&settings), Ok(()));
    }

    #[test]
    fn parts_of_a_step_count_as_one() {
        for whole in [0, 1, 2, 999, 1000, 4000, 65_535, 524_288, 999_999, 1_000_000] {
            let millis = whole * 1000;
            let near = [millis.max(1) - 1, millis, millis + 1, millis + 999];
            for millis in near.into_iter().filter(|n| *n <= 1_000_000_000) {
                assert_eq!(whole_speed(millis), millis.div_ceil(1000), "{millis}");
            }
        }
        let settings = with(Setting::MaxSpeed, 4000);
        let top = |top| MotionParams { top, ..params(50, 1, 200) }.check(&settings);
        assert_eq!((top(4_000_000), top(4_000_001)), (Ok(()), Err(Refusal::TooFast)));
        assert_eq!(top(4), Ok(()));
    }

    #[test]
    fn products_are_whole() {
        for (a, b) in [(1_000_000, 1_999_999), (999_999, 2_000_000), (1998, 100_000_000), (1, 0)] {
            let (whole, rest) = product(a, b);
            let exact = u64::from(a) * u64::from(b);
            assert_eq!(u64::from(whole) * 2048 + u64::from(rest), exact, "{a} · {b}");
            assert!(rest < 2048);
        }
    }
}
