//! What the settings forbid an order.

use stepwright_protocol::{Order, Ramp, Refusal, Setting, Settings};

/// Whether an order keeps to the highest speed and the steepest ramp.
///
/// The top speed is judged, whether or not a short travel reaches it: so a
/// limit does not depend on how far an order goes.
pub(crate) fn check(settings: &Settings, order: &Order) -> Result<(), Refusal> {
    // At most 10⁹: it fits.
    let max = settings.get(Setting::MaxSpeed).wrapping_mul(1000);
    if order.top.millisteps() > max {
        return Err(Refusal::TooFast);
    }
    let max = settings.get(Setting::MaxAccel);
    if is_steeper(order, order.up, max) || is_steeper(order, order.down, max) {
        return Err(Refusal::Ramp);
    }
    Ok(())
}

/// Whether a ramp is steeper than `max` steps/s².
fn is_steeper(order: &Order, ramp: Ramp, max: u32) -> bool {
    let (top, start) = (order.top.millisteps(), order.start.millisteps());
    match ramp {
        Ramp::Accel(accel) => accel.millisteps() > u64::from(max).wrapping_mul(1000),
        // Then there is no ramp.
        Ramp::Steps(_) if top <= start => false,
        // (vt² − vs²) / 2R, multiplied out; speeds are in thousandths, and no
        // product exceeds 2·10¹⁸.
        Ramp::Steps(steps) => {
            let sum = u64::from(top.wrapping_add(start));
            let squares = sum.wrapping_mul(top.wrapping_sub(start).into());
            let steps = u64::from(steps.get().wrapping_mul(2_000_000));
            squares > steps.wrapping_mul(max.into())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stepwright::{Accel, Speed};
    use stepwright_protocol::{Direction, RampSteps, Travel, Value};

    fn order(start: u32, top: u32, steps: u32) -> Order {
        let ramp = Ramp::Steps(RampSteps::new(steps).unwrap());
        Order {
            start: Speed::from_steps(start).unwrap(),
            top: Speed::from_steps(top).unwrap(),
            up: ramp,
            down: ramp,
            travel: Travel::Endless(Direction::Forward),
        }
    }

    fn with(setting: Setting, number: u32) -> Settings {
        let mut settings = Settings::new();
        settings.set(Value::new(setting, number).unwrap());
        settings
    }

    #[test]
    fn the_defaults_forbid_nothing_that_a_line_can_say_but_a_leap() {
        let settings = Settings::new();
        assert_eq!(check(&settings, &order(0, 1_000_000, 999)), Err(Refusal::Ramp));
        assert_eq!(check(&settings, &order(0, 440_000, 999)), Ok(()));
        assert_eq!(check(&settings, &order(1_000_000, 1_000_000, 1)), Ok(()));
    }

    #[test]
    fn limits_hold_to_the_step() {
        let settings = with(Setting::MaxSpeed, 4000);
        assert_eq!(check(&settings, &order(50, 4000, 200)), Ok(()));
        assert_eq!(check(&settings, &order(50, 4001, 200)), Err(Refusal::TooFast));
        // (1000² − 50²) / 400 = 2493.75
        let ramp = order(50, 1000, 200);
        assert_eq!(check(&with(Setting::MaxAccel, 2494), &ramp), Ok(()));
        assert_eq!(check(&with(Setting::MaxAccel, 2493), &ramp), Err(Refusal::Ramp));
        let accel = |a| Ramp::Accel(Accel::from_steps(a).unwrap());
        let settings = with(Setting::MaxAccel, 5000);
        assert_eq!(check(&settings, &Order { down: accel(5000), ..ramp }), Ok(()));
        assert_eq!(check(&settings, &Order { down: accel(5001), ..ramp }), Err(Refusal::Ramp));
        assert_eq!(check(&settings, &Order { up: accel(5001), ..ramp }), Err(Refusal::Ramp));
    }
}
