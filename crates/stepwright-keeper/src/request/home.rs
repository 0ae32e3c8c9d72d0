//! `POST /api/home`: the request for a homing, and its report.

use serde::{Deserialize, Serialize};
use stepwright_protocol::AxisId;

use crate::Declined;
use crate::request::{self, Hand, Limits, Wish};

/// The largest distance of a homing, in steps.
const FAR: i64 = i32::MAX as i64;

/// `POST /api/home`: finds 0 by the limit switch of an axis. Of the machine file only `home-within` is used.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct HomeRequest {
    /// The axis, from 1.
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 8, example = 1))]
    axis: u8,
    /// Speed towards the switch the first time, in steps/s [default: 500].
    #[cfg_attr(feature = "http", schema(minimum = 0.001, maximum = 1_000_000))]
    speed: Option<f64>,
    /// Speed towards the switch the second time, in steps/s [default: 50].
    #[cfg_attr(feature = "http", schema(minimum = 0.001, maximum = 1_000_000))]
    slow: Option<f64>,
    /// The distance to back off from the closed switch, in steps [default: 50].
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 2147483647))]
    back_off: Option<i64>,
    /// How far the switch may be, in steps: the axis stops there [default: `home-within` of the machine file;
    /// required without it].
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 2147483647))]
    within: Option<i64>,
    /// Speed that the motor reaches from rest in one step, and stops from, in steps/s [default: 50].
    #[cfg_attr(feature = "http", schema(minimum = 0, maximum = 1_000_000))]
    start_speed: Option<f64>,
    /// Acceleration in steps/s²: 1 to 100000000 [default: up to the top speed in 0.4 s].
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 100_000_000))]
    accel: Option<f64>,
}

/// A homing, checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HomeLimits {
    /// Towards the switch the first time, and away from it.
    pub seek: Limits,
    /// Towards the switch the second time.
    pub approach: Limits,
    /// The distance to back off from the closed switch, in steps.
    pub back_off: u32,
    /// How far the switch may be, in steps; `None` if the machine file is to tell it.
    pub within: Option<u32>,
}

impl HomeRequest {
    /// The wish for the homing, for this hand.
    ///
    /// # Errors
    /// A value outside its range.
    pub fn wish(self, hand: Hand) -> Result<Wish, Declined> {
        let axis: AxisId = request::axis(self.axis)?;
        let limits = |speed: f64, name| {
            request::limits(speed, name, self.start_speed, self.accel, None, None)
        };
        let way = |steps: Option<i64>, name| {
            let right = |steps: i64| {
                let way = u32::try_from(steps).ok().filter(|_| (1..=FAR).contains(&steps));
                way.ok_or_else(|| request::outside(steps, name, 1, FAR, "steps"))
            };
            steps.map(right).transpose()
        };
        let home = HomeLimits {
            seek: limits(self.speed.unwrap_or(500.0), "speed")?,
            approach: limits(self.slow.unwrap_or(50.0), "slow")?,
            back_off: way(self.back_off, "back_off")?.unwrap_or(50),
            within: way(self.within, "within")?,
        };
        Ok(Wish::Home(axis, home, hand))
    }
}

/// Declines a homing for which neither the request nor the machine file tells how far the switch may be.
pub fn needs_within(axis: u8) -> Declined {
    Declined::range(format!("`within` is missing: how far the switch of axis {axis} may be"))
        .allowed(format!("1 to {FAR} steps"))
        .remedy(format!(
            "give a little more than the axis can travel, or write home-within = \"300mm\" into \
             the machine file, under [axis.{axis}], and start the server again"
        ))
}

/// The state of the present homing of an axis, or how the last one ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct HomeReport {
    /// `seek`, `back-off`, `approach` and `leave` on the way, then `done` or `failed`.
    pub stage: &'static str,
    /// The stage in words, with the reason if the homing has failed.
    pub words: String,
    /// The remedy for a failure.
    #[serde(rename = "do")]
    pub remedy: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn asked(body: Value) -> Result<Wish, Declined> {
        serde_json::from_value::<HomeRequest>(body).unwrap().wish(Hand(7))
    }

    #[test]
    fn a_homing_has_the_defaults_of_the_command() {
        let Ok(Wish::Home(axis, home, hand)) = asked(json!({"axis": 2})) else { panic!() };
        assert_eq!((axis.number(), hand), (2, Hand(7)));
        assert_eq!((home.back_off, home.within), (50, None));
        assert_eq!((home.seek.top().steps(), home.approach.top().steps()), (500, 50));
        let own = json!({"axis": 1, "speed": 2000, "slow": 100.5, "back_off": 7, "within": 900});
        let Ok(Wish::Home(_, home, _)) = asked(own) else { panic!() };
        assert_eq!((home.back_off, home.within), (7, Some(900)));
        assert_eq!(home.approach.top().millisteps(), 100_500);
    }

    #[test]
    fn what_is_outside_its_range_is_no_homing() {
        for (name, wrong) in [
            ("axis", json!(0)),
            ("axis", json!(9)),
            ("speed", json!(0)),
            ("speed", json!(-500)),
            ("slow", json!(1e7)),
            ("back_off", json!(0)),
            ("back_off", json!(-1)),
            ("within", json!(0)),
            ("within", json!(2_147_483_648_i64)),
            ("accel", json!(0.5)),
        ] {
            let mut body = json!({"axis": 1});
            body[name] = wrong.clone();
            let declined = asked(body).unwrap_err();
            assert_eq!(declined.status(), 422, "{name} {wrong}");
            assert!(declined.what.starts_with(name), "{declined:?}");
        }
    }
}
