//! An order for one axis: how to travel, and where to.

use stepwright::{Accel, OutOfRange, Speed};

use crate::command::Command;
use crate::number::{Direction, Distance, RampSteps, StartSpeed, TopSpeed, Whole, WholeAccel};
use crate::{Refusal, Setting, Settings};

/// A complete order, as a machine gets it and as a master sends it.
///
/// The travel jumps to the start speed, follows the ramp up to the top speed,
/// cruises, follows the ramp down to the start speed and ends there. With
/// `top` not above `start` it is all at `top`, without ramps. A travel too
/// short for both ramps turns round in time: it never overshoots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order {
    /// Start/stop speed: 0 … 1,000,000 steps/s.
    pub start: Speed,
    /// Top speed: 1 … 1,000,000 steps/s.
    pub top: Speed,
    /// From the start speed up to the top speed.
    pub up: Ramp,
    /// From the top speed down to the start speed.
    pub down: Ramp,
    /// How far.
    pub travel: Travel,
}

/// One ramp, up or down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ramp {
    /// So many steps between start and top speed, at constant acceleration
    /// (vt² − vs²)/2R: document 004.
    Steps(RampSteps),
    /// This acceleration: 1 … 100,000,000 steps/s².
    Accel(Accel),
}

/// How far an order goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Travel {
    /// Exactly so many steps from the last end position; 0 is done at once.
    By(Distance),
    /// Until it is stopped.
    Endless(Direction),
}

impl From<Order> for stepwright::Order {
    fn from(order: Order) -> stepwright::Order {
        use stepwright::profile::Ramp as Core;
        let ramp = |ramp| match ramp {
            Ramp::Steps(steps) => Core::Steps(steps.get() as u16),
            Ramp::Accel(a) => Core::Accel(a),
        };
        stepwright::Order {
            start: order.start,
            top: order.top,
            up: ramp(order.up),
            down: ramp(order.down),
            travel: match order.travel {
                Travel::By(distance) => stepwright::Travel::By(distance.get()),
                Travel::Endless(direction) => {
                    stepwright::Travel::Endless(direction == crate::Direction::Forward)
                }
            },
        }
    }
}

impl Order {
    /// The order as the line carries it: speeds and accelerations rounded to
    /// whole steps. Show this to the user, for it is what the slave does.
    ///
    /// # Errors
    /// [`OutOfRange`] if a speed or an acceleration rounds to less than 1
    /// step/s or 1 step/s² (the start speed may be 0), or if both ramps are
    /// counted in steps and differ: R sets both.
    pub fn sendable(&self) -> Result<Order, OutOfRange> {
        Ok(Manner::of(self)?.order(self.travel))
    }
}

/// How to travel: what S, T, R, s, t, a and d have said of an order, which is
/// all but where to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Manner {
    pub(crate) start: StartSpeed,
    pub(crate) top: TopSpeed,
    /// Both ramps, except where an acceleration stands in their place.
    pub(crate) ramp: RampSteps,
    pub(crate) accel: Option<WholeAccel>,
    pub(crate) decel: Option<WholeAccel>,
}

impl Manner {
    /// S5 T100 R200, which an axis begins with.
    pub(crate) const INITIAL: Manner = Manner {
        start: StartSpeed::clamped(50),
        top: TopSpeed::clamped(1000),
        ramp: RampSteps::clamped(200),
        accel: None,
        decel: None,
    };

    /// Does what a line says that sets one of them; another does nothing.
    pub(crate) fn apply(&mut self, command: Command) {
        match command {
            // At most 9,990.
            Command::StartTens(n) => self.start = StartSpeed::clamped(n.get().wrapping_mul(10)),
            Command::TopTens(n) => self.top = TopSpeed::clamped(n.get().wrapping_mul(10)),
            Command::Ramp(n) => {
                // R takes both ramps back from a and d.
                self.ramp = n;
                self.accel = None;
                self.decel = None;
            }
            Command::Start(n) => self.start = n,
            Command::Top(n) => self.top = n,
            Command::Accel(n) => self.accel = Some(n),
            Command::Decel(n) => self.decel = Some(n),
            _ => {}
        }
    }

    pub(crate) fn order(&self, travel: Travel) -> Order {
        // Values of these types are inside the core's range, so that neither
        // MAX ever comes.
        let speed = |v: u32| Speed::from_steps(v).unwrap_or(Speed::MAX);
        Order {
            start: speed(self.start.get()),
            top: speed(self.top.get()),
            up: self.ramp(self.accel),
            down: self.ramp(self.decel),
            travel,
        }
    }

    fn ramp(&self, accel: Option<WholeAccel>) -> Ramp {
        match accel {
            None => Ramp::Steps(self.ramp),
            Some(a) => Ramp::Accel(Accel::from_steps(a.get()).unwrap_or(Accel::MAX)),
        }
    }

    /// Whether the settings of the board allow it.
    ///
    /// The top speed is judged, whether or not a short travel reaches it: so a
    /// limit does not depend on how far an order goes.
    #[inline(never)]
    pub(crate) fn check(&self, settings: &Settings) -> Result<(), Refusal> {
        let (start, top) = (self.start.get(), self.top.get());
        if top > settings.get(Setting::MaxSpeed) {
            return Err(Refusal::TooFast);
        }
        let max = settings.get(Setting::MaxAccel);
        let steepest = self.accel.max(self.decel).map_or(0, WholeAccel::get);
        if steepest > max {
            return Err(Refusal::Ramp);
        }
        // A ramp of so few steps that no acceleration says it is allowed only
        // where there is no limit.
        let limited = max < WholeAccel::LARGEST.get();
        if limited && top > start && (self.accel.is_none() || self.decel.is_none()) {
            // (vt² − vs²) / 2R, multiplied out: less than 2⁴¹.
            let squares = wide(top.wrapping_sub(start), top.wrapping_add(start));
            if squares > wide(max, self.ramp.get().wrapping_mul(2)) {
                return Err(Refusal::Ramp);
            }
        }
        Ok(())
    }

    /// The manner of an order, rounded to whole steps.
    pub(crate) fn of(order: &Order) -> Result<Manner, OutOfRange> {
        let (mut steps, mut accel, mut decel) = (None, None, None);
        for (ramp, own) in [(order.up, &mut accel), (order.down, &mut decel)] {
            match ramp {
                Ramp::Accel(a) => {
                    *own = Some(whole(a.millisteps(), "acceleration", "steps/s²")?);
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
        Ok(Manner {
            start: whole(order.start.millisteps().into(), "start speed", "steps/s")?,
            top: whole(order.top.millisteps().into(), "top speed", "steps/s")?,
            // With accelerations on both sides no ramp in steps is asked for.
            ramp: steps.unwrap_or(Manner::INITIAL.ramp),
            accel,
            decel,
        })
    }
}

fn wide(a: u32, b: u32) -> u64 {
    u64::from(a).wrapping_mul(b.into())
}

/// Rounds thousandths to whole steps, half up.
fn whole<const MIN: u32, const MAX: u32>(
    millisteps: u64,
    what: &'static str,
    unit: &'static str,
) -> Result<Whole<MIN, MAX>, OutOfRange> {
    u32::try_from(millisteps.saturating_add(500) / 1000)
        .ok()
        .and_then(Whole::new)
        .ok_or(OutOfRange { what, min: MIN.into(), max: MAX.into(), unit })
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEAR: Travel = Travel::By(match Distance::new(1) {
        Some(d) => d,
        None => panic!(),
    });

    fn order() -> Order {
        Manner::INITIAL.order(NEAR)
    }

    #[test]
    fn an_axis_begins_with_s5_t100_r200() {
        let order = order();
        assert_eq!((order.start.millisteps(), order.top.millisteps()), (50_000, 1_000_000));
        assert_eq!(order.up, Ramp::Steps(RampSteps::new(200).unwrap()));
        assert_eq!(order.down, order.up);
    }

    #[test]
    fn a_and_d_replace_their_half_and_r_both() {
        let mut manner = Manner::INITIAL;
        manner.apply(Command::Accel(WholeAccel::new(7000).unwrap()));
        let fast = Ramp::Accel(Accel::from_steps(7000).unwrap());
        assert_eq!(manner.order(NEAR).up, fast);
        assert_eq!(manner.order(NEAR).down, order().down);
        manner.apply(Command::Decel(WholeAccel::new(7000).unwrap()));
        assert_eq!(manner.order(NEAR).down, fast);
        manner.apply(Command::Ramp(RampSteps::new(9).unwrap()));
        assert_eq!(manner.order(NEAR).up, Ramp::Steps(RampSteps::new(9).unwrap()));
        assert_eq!(manner.order(NEAR).down, manner.order(NEAR).up);
    }

    #[test]
    fn an_order_is_rounded_to_what_the_line_carries() {
        let mut order = order();
        assert_eq!(order.sendable(), Ok(order));
        order.top = Speed::from_millisteps(2_499_500).unwrap();
        order.start = Speed::from_millisteps(499).unwrap();
        order.up = Ramp::Accel(Accel::from_millisteps(1_499).unwrap());
        let sent = order.sendable().unwrap();
        assert_eq!((sent.top, sent.start), (Speed::from_steps(2500).unwrap(), Speed::ZERO));
        assert_eq!(sent.up, Ramp::Accel(Accel::from_steps(1).unwrap()));
        order.top = Speed::MAX;
        assert!(order.sendable().is_ok());
    }

    #[test]
    fn an_order_that_no_line_can_say_is_an_error() {
        let slow = Order { top: Speed::from_millisteps(499).unwrap(), ..order() };
        assert_eq!(slow.sendable().unwrap_err().what, "top speed");
        let weak = Order { down: Ramp::Accel(Accel::MIN), ..order() };
        assert_eq!(weak.sendable().unwrap_err().what, "acceleration");
        let lopsided = Order { down: Ramp::Steps(RampSteps::LARGEST), ..order() };
        assert_eq!(lopsided.sendable().unwrap_err().unit, "steps");
    }

    fn manner(start: u32, top: u32, steps: u32) -> Manner {
        let (start, top) = (StartSpeed::clamped(start), TopSpeed::clamped(top));
        Manner { start, top, ramp: RampSteps::clamped(steps), accel: None, decel: None }
    }

    fn with(setting: Setting, number: u32) -> Settings {
        let mut settings = Settings::new();
        settings.set(crate::Value::new(setting, number).unwrap());
        settings
    }

    #[test]
    fn the_defaults_forbid_nothing() {
        let settings = Settings::new();
        assert_eq!(manner(0, 1_000_000, 1).check(&settings), Ok(()));
        let settings = with(Setting::MaxAccel, 99_999_999);
        assert_eq!(manner(0, 1_000_000, 999).check(&settings), Err(Refusal::Ramp));
        assert_eq!(manner(0, 440_000, 999).check(&settings), Ok(()));
        assert_eq!(manner(1_000_000, 1_000_000, 1).check(&settings), Ok(()));
        assert_eq!(manner(1_000_000, 999_999, 1).check(&settings), Ok(()));
    }

    #[test]
    fn limits_hold_to_the_step() {
        let settings = with(Setting::MaxSpeed, 4000);
        assert_eq!(manner(50, 4000, 200).check(&settings), Ok(()));
        assert_eq!(manner(50, 4001, 200).check(&settings), Err(Refusal::TooFast));
        // (1000² − 50²) / 400 = 2493.75
        let ramp = manner(50, 1000, 200);
        assert_eq!(ramp.check(&with(Setting::MaxAccel, 2494)), Ok(()));
        assert_eq!(ramp.check(&with(Setting::MaxAccel, 2493)), Err(Refusal::Ramp));
        let settings = with(Setting::MaxAccel, 5000);
        for (accel, decel, fits) in
            [(5000, 5000, true), (5001, 5000, false), (5000, 5001, false), (1, 1, true)]
        {
            let (accel, decel) = (WholeAccel::new(accel), WholeAccel::new(decel));
            assert_eq!(Manner { accel, decel, ..ramp }.check(&settings).is_ok(), fits);
        }
        // Of a ramp that an acceleration stands in for nothing is asked.
        let short =
            Manner { accel: WholeAccel::new(1), decel: WholeAccel::new(1), ..manner(0, 1000, 1) };
        assert_eq!(short.check(&settings), Ok(()));
    }
}
