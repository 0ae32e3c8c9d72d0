//! `POST /api/line`: the request for a straight line of several axes.

use serde::Deserialize;
use stepwright_protocol::{AxisId, MAX_AXES};

use crate::Declined;
use crate::request::{self, Limits, Way, Wish};

/// `POST /api/line`: several axes together, straight from their positions to their targets.
///
/// The speeds and ramps are those of the axis with the most steps; the others have their share.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct LineRequest {
    /// The distance of each axis, in steps: the first number is for axis 1. `null` or 0 leaves an axis where it
    /// is.
    #[cfg_attr(feature = "http", schema(min_items = 1, max_items = 8, example = json!([2000, -500])))]
    by: Option<Vec<Option<i64>>>,
    /// The target of each axis, in steps; `null` leaves the axis where it is. Either this or `by`.
    #[cfg_attr(feature = "http", schema(min_items = 1, max_items = 8))]
    to: Option<Vec<Option<i64>>>,
    /// Speed between the ramps, in steps/s: 0.001 to 1000000 [default: 1000].
    #[cfg_attr(feature = "http", schema(minimum = 0.001, maximum = 1_000_000))]
    top_speed: Option<f64>,
    /// Speed that the motors reach from rest in one step, and stop from, in steps/s [default: 50].
    #[cfg_attr(feature = "http", schema(minimum = 0, maximum = 1_000_000))]
    start_speed: Option<f64>,
    /// Acceleration in steps/s²: 1 to 100000000 [default: up to the top speed in 0.4 s].
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 100_000_000))]
    accel: Option<f64>,
    /// Deceleration, if it differs from the acceleration.
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 100_000_000))]
    decel: Option<f64>,
    /// The jerk limit, in steps/s³ [default: none].
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 4_000_000_000i64))]
    jerk: Option<f64>,
}

impl LineRequest {
    /// The wish for the line.
    ///
    /// # Errors
    /// A value outside its range, neither or both of `by` and `to`, or no axis that moves.
    pub fn wish(self) -> Result<Wish, Declined> {
        let (name, numbers) = match (&self.by, &self.to) {
            (Some(by), None) => ("by", by),
            (None, Some(to)) => ("to", to),
            (None, None) => return Err(request::neither()),
            (Some(_), Some(_)) => return Err(request::both()),
        };
        if !(1..=usize::from(MAX_AXES)).contains(&numbers.len()) {
            return Err(Declined::range(format!("{name} has {} numbers", numbers.len()))
                .allowed(format!("1 to {MAX_AXES}: the first is for axis 1")));
        }
        let mut ways = Vec::new();
        for (axis, number) in AxisId::first(MAX_AXES).zip(numbers) {
            let (by, to) = if name == "by" { (*number, None) } else { (None, *number) };
            match request::way(by, to)? {
                Some(Way::By(by)) if by.get() == 0 => {}
                Some(way) => ways.push((axis, way)),
                None => {}
            }
        }
        if ways.is_empty() {
            return Err(still());
        }
        let top = self.top_speed.unwrap_or(1000.0);
        let (start, up, down) = (self.start_speed, self.accel, self.decel);
        let limits: Limits = request::limits(top, "top_speed", start, up, down, self.jerk)?;
        Ok(Wish::Line(ways, limits))
    }
}

/// Declines a line along which no axis moves.
pub fn still() -> Declined {
    Declined::range("no axis moves")
        .allowed("a line that one axis or more moves along")
        .remedy("give an axis a distance, or a target where it does not stand")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn asked(body: Value) -> Result<Wish, Declined> {
        serde_json::from_value::<LineRequest>(body).unwrap().wish()
    }

    #[test]
    fn a_line_has_the_axes_that_move() {
        let wish = asked(json!({"by": [0, -4000, null, 7], "top_speed": 500.5})).unwrap();
        let Wish::Line(ways, limits) = wish else { panic!("{wish:?}") };
        let ways: Vec<_> = ways.iter().map(|(axis, way)| (axis.number(), *way)).collect();
        let by = |steps| Way::By(stepwright_protocol::Distance::new(steps));
        assert_eq!(ways, [(2, by(-4000)), (4, by(7))]);
        assert_eq!(limits.top().millisteps(), 500_500);
        // 0 is a target like any other.
        let Ok(Wish::Line(ways, _)) = asked(json!({"to": [0, null, -5]})) else { panic!() };
        assert_eq!(ways.iter().map(|(_, way)| *way).collect::<Vec<_>>(), [Way::To(0), Way::To(-5)]);
    }

    #[test]
    fn what_leads_nowhere_is_no_line() {
        for body in [
            json!({}),
            json!({"by": null}),
            json!({"by": []}),
            json!({"by": [null, null]}),
            json!({"by": [0, 0]}),
            json!({"to": [null]}),
            json!({"by": [1], "to": [1]}),
            json!({"by": [1, 2, 3, 4, 5, 6, 7, 8, 9]}),
            json!({"by": [2_147_483_648_i64]}),
            json!({"by": [1], "jerk": 0}),
        ] {
            let declined = asked(body.clone()).unwrap_err();
            assert_eq!(declined.status(), 422, "{body}");
            assert!(declined.allowed.is_some(), "{body}: {declined:?}");
        }
    }
}
