//! The lines that make a slave carry out orders.

use stepwright::OutOfRange;

use crate::axis::{AxisId, Selection};
use crate::command::Command;
use crate::motion_params::MotionParams;
use crate::number::{Tens, Whole, WholeAccel};
use crate::order::{Order, Travel};

/// The commands of one order for one axis, or of several that start together: an iterator. Send
/// them one by one, each after the Y to the one before.
///
/// It uses the Nano slave's lines wherever they can express the value, so that a slave written for
/// that document understands a script for axis 1 whose speeds are multiples of 10 from 10 to 9,990
/// steps/s and whose ramps are counted in steps. Otherwise it uses the extensions. Every parameter
/// is sent, because another master may have set the one in the slave.
///
/// If a line is answered E, stop there: the slave will not start the order. Afterwards the last
/// axis of the script stays selected, and F and Z address it.
///
/// ```
/// # use stepwright_protocol::*;
/// # use stepwright::Speed;
/// let order = Order {
///     start: Speed::from_steps(50).unwrap(),
///     top: Speed::from_steps(1000).unwrap(),
///     up: Ramp::Steps(RampSteps::new(200).unwrap()),
///     down: Ramp::Steps(RampSteps::new(200).unwrap()),
///     jerk: None,
///     travel: Travel::By(Distance::new(4000)),
/// };
/// let lines = |axis| {
///     let orders = [(AxisId::numbered(axis).unwrap(), order)];
///     Script::new(&orders).unwrap().map(|c| c.to_string()).collect::<Vec<_>>().join(" ")
/// };
/// assert_eq!(lines(1), "PO S5 T100 R200 G+4000 E");
/// assert_eq!(lines(2), "A2 PO A2 S5 T100 R200 G+4000 E");
/// ```
#[derive(Clone, Debug)]
pub struct Script<'a> {
    /// The orders that are not yet sent, the present one first.
    orders: &'a [(AxisId, Order)],
    next: Next,
    selected: AxisId,
}

/// The next line. The variants are in the order of an axis's lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    Address,
    Program,
    Select,
    Start,
    Top,
    Ramp,
    Accel,
    Decel,
    Jerk,
    Travel,
    End,
}

impl<'a> Script<'a> {
    /// The script of these orders. An axis that is named twice travels by its last order. Without
    /// orders there are no lines.
    ///
    /// Start speeds and accelerations are rounded to whole steps, top speeds to thousandths:
    /// [`Order::sendable`] shows the order that the slave receives.
    ///
    /// # Errors
    /// [`OutOfRange`] if the line can't carry one of the orders.
    pub fn new(orders: &'a [(AxisId, Order)]) -> Result<Script<'a>, OutOfRange> {
        for (_, order) in orders {
            MotionParams::of(order)?;
        }
        let next = if orders.is_empty() { Next::End } else { Next::Address };
        Ok(Script { orders, next, selected: AxisId::FIRST })
    }
}

impl Iterator for Script<'_> {
    type Item = Command;

    fn next(&mut self) -> Option<Command> {
        loop {
            let Some((&(axis, order), rest)) = self.orders.split_first() else {
                // After the last axis only E is left.
                let left = self.next != Next::End;
                self.next = Next::End;
                return left.then_some(Command::Execute);
            };
            // `new` has checked it.
            let params = MotionParams::of(&order).ok()?;
            let by_steps = params.accel == 0 || params.decel == 0;
            let select = Command::Select(Selection::One(axis));
            let (line, next) = match self.next {
                // PO is refused while the selected axis is busy, whichever that is, so the axis
                // that is to start is selected first. Axis 1 goes without A, for a slave that knows
                // no A.
                Next::Address => ((axis != AxisId::FIRST).then_some(select), Next::Program),
                Next::Program => (Some(Command::Program), Next::Select),
                Next::Select => ((axis != self.selected).then_some(select), Next::Start),
                Next::Start => {
                    let exact = Command::Start(Whole::clamped(params.start));
                    (Some(tens(params.start).map_or(exact, Command::StartTens)), Next::Top)
                }
                Next::Top => {
                    let exact = Command::top(order.top);
                    let whole = params.top.is_multiple_of(1000).then_some(params.top / 1000);
                    (whole.and_then(tens).map(Command::TopTens).or(exact), Next::Ramp)
                }
                Next::Ramp => {
                    let line = Command::Ramp(Whole::clamped(params.ramp.into()));
                    (by_steps.then_some(line), Next::Accel)
                }
                Next::Accel => (slope(params.accel).map(Command::Accel), Next::Decel),
                Next::Decel => (slope(params.decel).map(Command::Decel), Next::Jerk),
                Next::Jerk => {
                    // PO has removed a jerk of another master.
                    let jerk = params.jerk().map(|jerk| (jerk.millisteps() / 1000) as u32);
                    let line = jerk.map(|jerk| Command::Jerk(Whole::clamped(jerk)));
                    (line, Next::Travel)
                }
                Next::Travel | Next::End => {
                    self.orders = rest;
                    self.selected = axis;
                    let line = match order.travel {
                        Travel::By(distance) => Command::Go(distance),
                        Travel::Endless(direction) => Command::Run(direction),
                    };
                    (Some(line), Next::Select)
                }
            };
            self.next = next;
            if line.is_some() {
                return line;
            }
        }
    }
}

/// The speed in tens of steps/s, if S and T can express it.
fn tens(speed: u32) -> Option<Tens> {
    if speed.is_multiple_of(10) { Tens::new(speed / 10) } else { None }
}

/// The acceleration, if the ramp is given as one.
fn slope(accel: u32) -> Option<WholeAccel> {
    WholeAccel::new(accel)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::number::{Direction, Distance, RampSteps};
    use proptest::prelude::*;
    use std::string::{String, ToString};
    use std::vec::Vec;

    const SLOW: MotionParams = MotionParams::INITIAL;

    fn order(params: MotionParams) -> Order {
        params.sent(Travel::Endless(Direction::Backward))
    }

    fn axis(n: u8) -> AxisId {
        AxisId::numbered(n).unwrap()
    }

    fn lines(orders: &[(AxisId, Order)]) -> String {
        let lines: Vec<_> = Script::new(orders).unwrap().map(|c| c.to_string()).collect();
        lines.join(" ")
    }

    #[test]
    fn extensions_are_sent_only_where_needed() {
        let one = |params| lines(&[(AxisId::FIRST, order(params))]);
        assert_eq!(one(SLOW), "PO S5 T100 R200 g- E");
        assert_eq!(one(MotionParams { start: 0, ..SLOW }), "PO s0 T100 R200 g- E");
        assert_eq!(one(MotionParams { top: 9_990_000, ..SLOW }), "PO S5 T999 R200 g- E");
        assert_eq!(one(MotionParams { top: 10_000_000, ..SLOW }), "PO S5 t10000 R200 g- E");
        assert_eq!(one(MotionParams { top: 1_005_000, ..SLOW }), "PO S5 t1005 R200 g- E");
        assert_eq!(one(MotionParams { top: 4, ..SLOW }), "PO S5 m4 R200 g- E");
        let (accel, decel) = (7, 8);
        assert_eq!(one(MotionParams { accel, ..SLOW }), "PO S5 T100 R200 a7 g- E");
        assert_eq!(one(MotionParams { decel, ..SLOW }), "PO S5 T100 R200 d8 g- E");
        assert_eq!(one(MotionParams { accel, decel, ..SLOW }), "PO S5 T100 a7 d8 g- E");
    }

    #[test]
    fn several_axes_share_one_order() {
        let order = order(SLOW);
        assert_eq!(
            lines(&[(axis(1), order), (axis(3), order)]),
            "PO S5 T100 R200 g- A3 S5 T100 R200 g- E"
        );
        assert_eq!(
            lines(&[(axis(3), order), (axis(1), order)]),
            "A3 PO A3 S5 T100 R200 g- A1 S5 T100 R200 g- E"
        );
        assert_eq!(lines(&[]), "");
    }

    #[test]
    fn what_can_not_be_said_is_an_error() {
        let mut wrong = order(SLOW);
        wrong.down = crate::Ramp::Steps(RampSteps::LARGEST);
        assert!(Script::new(&[(AxisId::FIRST, wrong)]).is_err());
    }

    proptest! {
        /// The lines set the parameters of the order.
        #[test]
        fn a_script_sets_the_whole_order(
            start in 0u32..=1_000_000, top in 1u32..=1_000_000_000, shift in 0u32..20,
            ramp in 1u16..=999, accel: Option<u32>, decel: Option<u32>,
            jerk in prop_oneof![Just(0), 0..=4_000_000_000u32], by: i32,
        ) {
            let order = MotionParams {
                start: start >> shift,
                top: (top >> shift).max(1),
                ramp,
                accel: accel.map_or(0, |a| WholeAccel::clamped(a).get()),
                decel: decel.map_or(0, |a| WholeAccel::clamped(a).get()),
                jerk,
            }
            .sent(Travel::By(Distance::new(by)));
            let orders = [(AxisId::FIRST, order)];
            let mut params = MotionParams::INITIAL;
            params.set(b'a', 1);
            let mut travel = None;
            for command in Script::new(&orders).unwrap() {
                match command {
                    Command::StartTens(n) => params.set(b's', n.get() * 10),
                    Command::TopTens(n) => params.set(b'm', n.get() * 10_000),
                    Command::Start(n) => params.set(b's', n.get()),
                    Command::Top(n) => params.set(b'm', n.get() * 1000),
                    Command::Milli(n) => params.set(b'm', n.get()),
                    Command::Ramp(n) => params.set(b'R', n.get()),
                    Command::Accel(n) => params.set(b'a', n.get()),
                    Command::Decel(n) => params.set(b'd', n.get()),
                    Command::Jerk(n) => params.set(b'j', n.get()),
                    _ => {}
                }
                if let Command::Go(distance) = command {
                    travel = Some(Travel::By(distance));
                }
            }
            prop_assert_eq!(params.sent(travel.unwrap()), order);
        }
    }
}
