//! The numbers of an order, checked, and the lines that give it.

use stepwright::{Accel, Jerk, Speed};
use stepwright_protocol::{AxisId, Direction, Distance, Order, Ramp, Script, Travel};

/// A number of an order, and what is allowed of it.
#[derive(Clone, Copy, Debug)]
pub struct OrderRange {
    /// The smallest.
    pub low: f64,
    /// The largest.
    pub high: f64,
}

/// The numbers of an order, by their places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum OrderField {
    /// From 1.
    Axis,
    /// Steps, + forward; of a run without end its sign alone counts.
    Steps,
    /// 1: a run without end.
    Endless,
    /// Speed between the ramps, in steps/s.
    Top,
    /// Speed that the motor jumps to from rest, in steps/s.
    Start,
    /// Acceleration in steps/s².
    Accel,
    /// Deceleration in steps/s².
    Decel,
    /// Jerk in steps/s³; 0: none.
    Jerk,
}

impl OrderField {
    /// How many there are.
    pub const COUNT: usize = OrderField::RANGES.len();

    /// What is allowed of each: as in a request to `stepwright serve`.
    pub const RANGES: [OrderRange; 8] = [
        OrderRange { low: 1.0, high: 8.0 },
        OrderRange { low: i32::MIN as f64, high: i32::MAX as f64 },
        OrderRange { low: 0.0, high: 1.0 },
        OrderRange { low: 0.001, high: 1e6 },
        OrderRange { low: 0.0, high: 1e6 },
        OrderRange { low: 1.0, high: 1e8 },
        OrderRange { low: 1.0, high: 1e8 },
        OrderRange { low: 0.0, high: 4e9 },
    ];

    /// What is allowed of the number at a place.
    pub fn range(place: usize) -> Option<OrderRange> {
        OrderField::RANGES.get(place).copied()
    }
}

/// In thousandths, rounded.
fn thousandths(number: f64) -> u64 {
    (number * 1000.0 + 0.5) as u64
}

/// The order of these numbers.
///
/// # Errors
/// The place of the first number that is outside its range.
pub fn order(numbers: &[f64; OrderField::COUNT]) -> Result<(AxisId, Order), OrderField> {
    use OrderField::{Accel as A, Axis, Decel, Endless, Jerk as J, Start, Steps, Top};
    let places = [Axis, Steps, Endless, Top, Start, A, Decel, J];
    for (place, (number, range)) in places.into_iter().zip(numbers.iter().zip(OrderField::RANGES)) {
        if !(range.low..=range.high).contains(number) {
            return Err(place);
        }
    }
    let [axis, steps, endless, top, start, up, down, jerk] = *numbers;
    let speed = |number: f64, place| {
        let millis = u32::try_from(thousandths(number)).map_err(|_| place)?;
        Speed::from_millisteps(millis).map_err(|_| place)
    };
    let ramp = |number: f64, place| {
        Accel::from_millisteps(thousandths(number)).map(Ramp::Accel).map_err(|_| place)
    };
    let jerk = match jerk {
        none if none < 1.0 => None,
        some => Some(Jerk::from_millisteps(thousandths(some)).map_err(|_| J)?),
    };
    let forward = if steps < 0.0 { Direction::Backward } else { Direction::Forward };
    let travel = match endless {
        1.0 => Travel::Endless(forward),
        _ => Travel::By(Distance::new(steps as i32)),
    };
    let order = Order {
        start: speed(start, Start)?,
        top: speed(top, Top)?,
        up: ramp(up, A)?,
        down: ramp(down, Decel)?,
        jerk,
        travel,
    };
    let axis = AxisId::numbered(axis as u8).ok_or(Axis)?;
    Ok((axis, order.sendable().map_err(|_| A)?))
}

/// The lines of an order, each with its CR.
///
/// # Errors
/// The place of the first number that is outside its range.
pub fn write(
    numbers: &[f64; OrderField::COUNT],
    mut put: impl FnMut(u8),
) -> Result<(), OrderField> {
    let orders = [order(numbers)?];
    let lines = Script::new(&orders).map_err(|_| OrderField::Accel)?;
    lines.flat_map(|line| line.bytes()).for_each(&mut put);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXAMPLE: [f64; OrderField::COUNT] = [2., 4000., 0., 1000., 50., 2375., 2375., 0.];

    fn lines(numbers: [f64; OrderField::COUNT]) -> Result<String, OrderField> {
        let mut bytes = Vec::new();
        write(&numbers, |byte| bytes.push(byte))?;
        Ok(String::from_utf8(bytes).unwrap().trim_end().replace('\r', " "))
    }

    fn with(place: OrderField, number: f64) -> [f64; OrderField::COUNT] {
        let mut numbers = EXAMPLE;
        numbers[place as usize] = number;
        numbers
    }

    #[test]
    fn an_order_is_written_line_by_line() {
        assert_eq!(lines(EXAMPLE).unwrap(), "A2 PO A2 S5 T100 a2375 d2375 G+4000 E");
        let back = [1., -1., 1., 0.004, 0., 1., 2., 9.];
        assert_eq!(lines(back).unwrap(), "PO s0 m4 a1 d2 j9 g- E");
    }

    #[test]
    fn a_number_outside_its_range_is_named() {
        for (place, wrong) in [
            (OrderField::Axis, 0.0),
            (OrderField::Axis, f64::NAN),
            (OrderField::Steps, 2147483648.0),
            (OrderField::Top, 0.0009),
            (OrderField::Top, f64::INFINITY),
            (OrderField::Start, -1.0),
            (OrderField::Accel, 0.9),
            (OrderField::Decel, 1.1e8),
            (OrderField::Jerk, 4.1e9),
        ] {
            assert_eq!(lines(with(place, wrong)), Err(place), "{wrong}");
        }
        for (place, range) in OrderField::RANGES.iter().enumerate() {
            for end in [range.low, range.high] {
                let mut numbers = EXAMPLE;
                numbers[place] = end;
                assert!(lines(numbers).is_ok(), "{place}: {end}");
            }
        }
    }
}
