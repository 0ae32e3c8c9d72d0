//! `POST /api/home`: what may be asked of a homing, and what is told of it.

use serde::{Deserialize, Serialize};
use stepwright_protocol::AxisId;

use crate::Declined;
use crate::request::{self, Hand, Limits, Wish};

/// The longest way of a homing, in steps.
const FAR: i64 = i32::MAX as i64;

/// `POST /api/home`: find 0 by the limit switch of an axis. Of the machine file `home-within` alone
/// counts here.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct HomeRequest {
    /// Which axis, from 1.
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 8, example = 1))]
    axis: u8,
    /// Speed towards the switch the first time, in steps/s [default: 500].
    #[cfg_attr(feature = "http", schema(minimum = 0.001, maximum = 1_000_000))]
    speed: Option<f64>,
    /// Speed towards the switch the second time, in steps/s [default: 50].
    #[cfg_attr(feature = "http", schema(minimum = 0.001, maximum = 1_000_000))]
    slow: Option<f64>,
    /// How far to go from the closed switch, in steps [default: 50].
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 2147483647))]
    back_off: Option<i64>,
    /// How far the switch may be, in steps: the axis ends there [default: `home-within` of the
    /// machine file; needed where that has none].
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 2147483647))]
    within: Option<i64>,
    /// Speed that the motor jumps to from rest, and stops from, in steps/s [default: 50].
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
    /// How far to go from the closed switch, in steps.
    pub back_off: u32,
    /// How far the switch may be, in steps; nothing where the machine file is to say it.
    pub within: Option<u32>,
}

impl HomeRequest {
    /// The homing, for this hand.
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

/// Why an axis is not homed of which nobody says how far its switch may be.
pub fn needs_within(axis: u8) -> Declined {
    Declined::range(format!("`within` is missing: how far the switch of axis {axis} may be"))
        .allowed(format!("1 to {FAR} steps"))
        .remedy(format!(
            "give a little more than the axis can travel, or write home-within = \"300mm\" into \
             the machine file, under [axis.{axis}], and start the server again"
        ))
}

/// Where the last homing of an axis is, or how it has ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct HomeReport {
    /// `seek`, `back-off`, `approach` and `leave` on the way, then `done` or `failed`.
    pub stage: &'static str,
    /// The same for people; of one that has failed, the reason.
    pub words: String,
    /// What can be done about a failure.
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
