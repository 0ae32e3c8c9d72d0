//! An order for one axis: speeds, ramps and travel.

use stepwright::{Accel, Jerk, OutOfRange, Speed};

use crate::motion_params::MotionParams;
use crate::number::{Direction, Distance, RampSteps};

/// A complete order, as a machine receives it and as a master sends it.
///
/// The travel jumps to the start speed, follows the ramp up to the top speed, cruises, follows the
/// ramp down to the start speed and ends there. If `top` is not above `start`, the whole travel is
/// at `top`, without ramps. A travel too short for both ramps brakes earlier: it never overshoots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order {
    /// Start/stop speed: 0 … 1,000,000 steps/s.
    pub start: Speed,
    /// Top speed: 0.001 … 1,000,000 steps/s.
    pub top: Speed,
    /// The ramp from the start speed up to the top speed.
    pub up: Ramp,
    /// The ramp from the top speed down to the start speed.
    pub down: Ramp,
    /// The jerk limit: 1 … 4,000,000,000 steps/s³. `None`: the acceleration changes at once.
    pub jerk: Option<Jerk>,
    /// The distance.
    pub travel: Travel,
}

/// One ramp, up or down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ramp {
    /// This many steps between start and top speed, at the constant acceleration (vt² − vs²)/2R, as
    /// on the Nano slave.
    Steps(RampSteps),
    /// This acceleration: 1 … 100,000,000 steps/s².
    Accel(Accel),
}

/// The distance of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Travel {
    /// Exactly this many steps from the last end position; 0 ends at once.
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
            jerk: order.jerk,
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
    /// The order as the line carries it: start speed and accelerations rounded to whole steps, the
    /// top speed to thousandths. Show this order to the user: it is what the slave carries out.
    ///
    /// # Errors
    /// [`OutOfRange`] if the top speed is 0, if an acceleration rounds to less than 1
    /// step/s², or if both ramps are counted in steps and differ: R sets both.
    pub fn sendable(&self) -> Result<Order, OutOfRange> {
        Ok(MotionParams::of(self)?.sent(self.travel))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEAR: Travel = Travel::By(Distance::new(1));

    fn order() -> Order {
        MotionParams::INITIAL.sent(NEAR)
    }

    #[test]
    fn an_axis_begins_with_s5_t100_r200() {
        let order = order();
        assert_eq!((order.start.millisteps(), order.top.millisteps()), (50_000, 1_000_000));
        assert_eq!(order.up, Ramp::Steps(RampSteps::new(200).unwrap()));
        assert_eq!(order.down, order.up);
    }

    #[test]
    fn an_order_is_rounded_to_what_the_line_carries() {
        let mut order = order();
        assert_eq!(order.sendable(), Ok(order));
        order.top = Speed::from_millisteps(2_499_500).unwrap();
        order.start = Speed::from_millisteps(499).unwrap();
        order.up = Ramp::Accel(Accel::from_millisteps(1_499).unwrap());
        let sent = order.sendable().unwrap();
        assert_eq!((sent.top, sent.start), (order.top, Speed::ZERO));
        assert_eq!(sent.up, Ramp::Accel(Accel::from_steps(1).unwrap()));
        order.top = Speed::MAX;
        assert!(order.sendable().is_ok());
    }

    #[test]
    fn an_order_that_no_line_can_say_is_an_error() {
        let slow = Order { top: Speed::ZERO, ..order() };
        assert_eq!(slow.sendable().unwrap_err().what, "top speed");
        let weak = Order { down: Ramp::Accel(Accel::MIN), ..order() };
        assert_eq!(weak.sendable().unwrap_err().what, "acceleration");
        let lopsided = Order { down: Ramp::Steps(RampSteps::LARGEST), ..order() };
        assert_eq!(lopsided.sendable().unwrap_err().unit, "steps");
    }
}
