//! The requests, as JSON; and the same requests, checked, as the board's thread gets them.
//!
//! Unknown fields, missing fields and values outside their range are declined here. Only the board can refuse a
//! [`Wish`].

use std::fmt::Display;
use std::ops::RangeInclusive;

use serde::Deserialize;
use stepwright::{Accel, Jerk, Speed};
use stepwright_protocol::{
    AxisId, Direction, Distance, Order, Ramp, Selection, Setting, Travel, Value, WholeAccel,
};

use crate::Declined;

pub mod home;
pub mod line;

pub use home::HomeLimits;

/// The number of a client that gives orders; no two clients have the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hand(pub u64);

/// What the board is to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Wish {
    /// Travel by a distance, or to a position.
    Travel(AxisId, Way, Limits),
    /// Several axes together along a straight line; each axis once, the lowest first.
    Line(Vec<(AxisId, Way)>, Limits),
    /// Run endlessly, as long as this hand is heard from.
    Run(AxisId, Direction, Limits, Hand),
    /// Find 0 by the limit switch, as long as this hand is heard from.
    Home(AxisId, HomeLimits, Hand),
    /// Change the travel on its way.
    Retarget(AxisId, TravelChange),
    /// Brake; the position is kept.
    Stop(Selection),
    /// Stop at once; the position of an axis that moves is lost.
    Kill,
    /// Make the present position of this axis 0.
    Zero(AxisId),
    /// Change a setting of the board.
    Set(Value),
    /// Forget all errors.
    Acknowledge,
}

impl Wish {
    /// Whether the wish ends a motion, and so goes before all others.
    pub fn is_urgent(&self) -> bool {
        matches!(self, Wish::Stop(_) | Wish::Kill)
    }

    /// Whether the wish starts a motor that rests.
    pub fn starts(&self) -> bool {
        matches!(self, Wish::Travel(..) | Wish::Line(..) | Wish::Run(..) | Wish::Home(..))
    }
}

/// A distance or a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// From the present position, in steps.
    By(Distance),
    /// To this position, in steps.
    To(i64),
}

/// The speeds and ramps of a travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    start: Speed,
    top: Speed,
    up: Accel,
    down: Accel,
    jerk: Option<Jerk>,
}

impl Limits {
    /// The speed between the ramps.
    pub fn top(&self) -> Speed {
        self.top
    }

    /// The order of a travel, as the serial line can send it.
    ///
    /// # Errors
    /// The line can't send it: an acceleration is below 1 step/s².
    pub fn order(&self, travel: Travel) -> Result<Order, Declined> {
        let Limits { start, top, jerk, .. } = *self;
        let (up, down) = (Ramp::Accel(self.up), Ramp::Accel(self.down));
        let order = Order { start, top, up, down, jerk, travel };
        order.sendable().map_err(|error| Declined::range(error.to_string()))
    }
}

/// Other limits, or another target, for a travel on its way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TravelChange {
    /// The new end.
    pub way: Option<Way>,
    /// Speed between the ramps.
    pub top: Option<Speed>,
    /// Acceleration.
    pub up: Option<WholeAccel>,
    /// Deceleration.
    pub down: Option<WholeAccel>,
}

/// `POST /api/move`: by a distance, or to a position.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct MoveRequest {
    /// The axis, from 1.
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 8, example = 1))]
    axis: u8,
    /// The distance from the present position, in steps; negative is backward.
    #[cfg_attr(feature = "http", schema(minimum = -2147483648i64, maximum = 2147483647, example = 4000))]
    by: Option<i64>,
    /// The target position, in steps. Either this or `by`.
    to: Option<i64>,
    /// Speed between the ramps, in steps/s: 0.001 to 1000000 [default: 1000].
    #[cfg_attr(feature = "http", schema(minimum = 0.001, maximum = 1_000_000))]
    top_speed: Option<f64>,
    /// Speed that the motor reaches from rest in one step, and stops from, in steps/s [default: 50].
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

/// `POST /api/run`: runs endlessly, as long as the client is heard from.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct RunRequest {
    /// The axis, from 1.
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 8, example = 1))]
    axis: u8,
    /// The speed, in steps/s; negative is backward. Not 0.
    #[cfg_attr(feature = "http", schema(minimum = -1_000_000, maximum = 1_000_000, example = 400))]
    speed: f64,
    /// As in a move.
    #[cfg_attr(feature = "http", schema(minimum = 0, maximum = 1_000_000))]
    start_speed: Option<f64>,
    /// As in a move.
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 100_000_000))]
    accel: Option<f64>,
    /// As in a move.
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 100_000_000))]
    decel: Option<f64>,
    /// As in a move.
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 4_000_000_000i64))]
    jerk: Option<f64>,
}

/// `POST /api/retarget`: changes a travel on its way.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct RetargetRequest {
    /// The axis, from 1.
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 8, example = 1))]
    axis: u8,
    /// The new end, in steps from where the travel began.
    #[cfg_attr(feature = "http", schema(minimum = -2147483647, maximum = 2147483647))]
    by: Option<i64>,
    /// The new end, as a position. Either this or `by`, or neither.
    to: Option<i64>,
    /// Speed between the ramps, in steps/s.
    #[cfg_attr(feature = "http", schema(minimum = 0.001, maximum = 1_000_000))]
    top_speed: Option<f64>,
    /// Acceleration in steps/s².
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 100_000_000))]
    accel: Option<f64>,
    /// Deceleration in steps/s².
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 100_000_000))]
    decel: Option<f64>,
}

/// `POST /api/stop`: brakes, and keeps the position.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct StopRequest {
    /// Only this axis; all axes without it.
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 8))]
    axis: Option<u8>,
}

/// `POST /api/zero`: makes the present position of an axis 0.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct ZeroRequest {
    /// The axis, from 1.
    #[cfg_attr(feature = "http", schema(minimum = 1, maximum = 8, example = 1))]
    axis: u8,
}

/// `POST /api/set`: a setting of the board.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct SetRequest {
    /// The name of the setting: `GET /api/board` lists the settings with their ranges.
    #[cfg_attr(feature = "http", schema(example = "idle-ms"))]
    name: String,
    /// The value, a whole number.
    #[cfg_attr(feature = "http", schema(value_type = u32, example = 60000))]
    value: f64,
}

/// A request without fields: `{}`.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct EmptyRequest {}

/// `POST /api/control`: asks for control of the motors.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct ControlRequest {
    /// The name that others see, at most 40 characters.
    #[serde(default)]
    pub name: String,
    /// Whether to take control from another client that is still heard from.
    #[serde(default)]
    pub take_over: bool,
}

impl MoveRequest {
    /// The wish for the travel.
    ///
    /// # Errors
    /// A value outside its range, or neither or both of `by` and `to`.
    pub fn wish(self) -> Result<Wish, Declined> {
        let axis = axis(self.axis)?;
        let Some(way) = way(self.by, self.to)? else {
            return Err(neither());
        };
        let top = self.top_speed.unwrap_or(1000.0);
        let limits = limits(top, "top_speed", self.start_speed, self.accel, self.decel, self.jerk)?;
        Ok(Wish::Travel(axis, way, limits))
    }
}

impl RunRequest {
    /// The wish for the run of this hand.
    ///
    /// # Errors
    /// A value outside its range.
    pub fn wish(self, hand: Hand) -> Result<Wish, Declined> {
        let way = if self.speed < 0.0 { Direction::Backward } else { Direction::Forward };
        let size = self.speed.abs();
        let limits = limits(size, "speed", self.start_speed, self.accel, self.decel, self.jerk)?;
        Ok(Wish::Run(axis(self.axis)?, way, limits, hand))
    }
}

impl RetargetRequest {
    /// The wish for the change.
    ///
    /// # Errors
    /// A value outside its range, or nothing to change.
    pub fn wish(self) -> Result<Wish, Declined> {
        let axis = axis(self.axis)?;
        let slope = |number: Option<f64>, name| -> Result<Option<WholeAccel>, Declined> {
            let Some(number) = number else { return Ok(None) };
            let whole = thousandths(number, name, ACCEL, "steps/s²")?.saturating_add(500) / 1000;
            Ok(u32::try_from(whole).ok().and_then(WholeAccel::new))
        };
        let change = TravelChange {
            way: way(self.by, self.to)?,
            top: self.top_speed.map(|top| speed(top, "top_speed", TOP)).transpose()?,
            up: slope(self.accel, "accel")?,
            down: slope(self.decel, "decel")?,
        };
        if change == TravelChange::default() {
            return Err(Declined::range("nothing to change")
                .allowed("one or more of by, to, top_speed, accel, decel"));
        }
        Ok(Wish::Retarget(axis, change))
    }
}

impl StopRequest {
    /// The wish for the stop.
    ///
    /// # Errors
    /// There is no such axis.
    pub fn wish(self) -> Result<Wish, Declined> {
        Ok(Wish::Stop(match self.axis {
            Some(number) => Selection::One(axis(number)?),
            None => Selection::All,
        }))
    }
}

impl ZeroRequest {
    /// The wish for the new 0.
    ///
    /// # Errors
    /// There is no such axis.
    pub fn wish(self) -> Result<Wish, Declined> {
        Ok(Wish::Zero(axis(self.axis)?))
    }
}

impl SetRequest {
    /// The wish for the setting.
    ///
    /// # Errors
    /// No setting has this name, or its number is outside its range.
    pub fn wish(self) -> Result<Wish, Declined> {
        let Some(setting) = Setting::named(self.name.as_bytes()) else {
            return Err(Declined::range(format!("no setting is called '{}'", self.name))
                .remedy("GET /api/board lists them"));
        };
        let range = setting.range();
        let whole = (self.value.fract() == 0.0).then_some(self.value as u32);
        let whole = whole.filter(|number| f64::from(*number) == self.value);
        let value = whole.and_then(|number| Value::new(setting, number)).ok_or_else(|| {
            outside(self.value, setting.name(), range.start(), range.end(), setting.unit())
        })?;
        Ok(Wish::Set(value))
    }
}

const TOP: RangeInclusive<f64> = 0.001..=1e6;
const START: RangeInclusive<f64> = 0.0..=1e6;
const ACCEL: RangeInclusive<f64> = 1.0..=1e8;
const JERK: RangeInclusive<f64> = 1.0..=4e9;

/// The time from the start speed to the top speed if no acceleration is given, in s.
const RISE: f64 = 0.4;

/// The most digits of a number in an answer; no valid number has more.
const LONGEST: usize = 24;

/// Declines a number that is outside its range.
pub fn outside(
    number: impl Display,
    name: &str,
    from: impl Display,
    to: impl Display,
    unit: &str,
) -> Declined {
    let allowed = format!("{from} to {to} {unit}");
    let mut said = number.to_string();
    // 1e300 has 301 digits.
    if said.len() > LONGEST {
        said.truncate(LONGEST);
        said.push('…');
    }
    Declined::range(format!("{name} is {said}")).allowed(allowed.trim_end())
}

pub(crate) fn axis(number: u8) -> Result<AxisId, Declined> {
    AxisId::numbered(number).ok_or_else(|| outside(number, "axis", 1, 8, ""))
}

pub(crate) fn neither() -> Declined {
    Declined::range("there is neither `by` nor `to`").allowed("one of them")
}

pub(crate) fn both() -> Declined {
    Declined::range("there are both `by` and `to`").allowed("one of them")
}

pub(crate) fn way(by: Option<i64>, to: Option<i64>) -> Result<Option<Way>, Declined> {
    match (by, to) {
        (Some(_), Some(_)) => Err(both()),
        (Some(by), None) => {
            let distance = i32::try_from(by).map(Distance::new);
            let distance = distance.map_err(|_| outside(by, "by", i32::MIN, i32::MAX, "steps"))?;
            Ok(Some(Way::By(distance)))
        }
        (None, to) => Ok(to.map(Way::To)),
    }
}

/// A number within this range in thousandths, rounded.
fn thousandths(
    number: f64,
    name: &str,
    range: RangeInclusive<f64>,
    unit: &str,
) -> Result<u64, Declined> {
    if !range.contains(&number) {
        return Err(outside(number, name, range.start(), range.end(), unit));
    }
    Ok((number * 1000.0).round() as u64)
}

fn speed(number: f64, name: &str, range: RangeInclusive<f64>) -> Result<Speed, Declined> {
    let millis = thousandths(number, name, range, "steps/s")?;
    let speed = u32::try_from(millis).ok().and_then(|millis| Speed::from_millisteps(millis).ok());
    speed.ok_or_else(|| outside(number, name, TOP.start(), TOP.end(), "steps/s"))
}

pub(crate) fn limits(
    top: f64,
    name: &str,
    start: Option<f64>,
    up: Option<f64>,
    down: Option<f64>,
    jerk: Option<f64>,
) -> Result<Limits, Declined> {
    let accel = |number: f64, name| {
        let millis = thousandths(number, name, ACCEL, "steps/s²")?;
        Accel::from_millisteps(millis).map_err(|error| Declined::range(error.to_string()))
    };
    let (from, to) = (start.unwrap_or(50.0), top);
    let default = ((to - from) / RISE).clamp(*ACCEL.start(), *ACCEL.end());
    let up = accel(up.unwrap_or(default), "accel")?;
    let jerk = jerk.map(|jerk| {
        let millis = thousandths(jerk, "jerk", JERK, "steps/s³")?;
        Jerk::from_millisteps(millis).map_err(|error| Declined::range(error.to_string()))
    });
    Ok(Limits {
        start: speed(from, "start_speed", START)?,
        top: speed(top, name, TOP)?,
        up,
        down: down.map_or(Ok(up), |down| accel(down, "decel"))?,
        jerk: jerk.transpose()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::de::DeserializeOwned;
    use serde_json::{Value as Json, json};

    fn read<T: DeserializeOwned>(body: Json) -> Result<T, String> {
        serde_json::from_value(body).map_err(|error| error.to_string())
    }

    fn moved(body: Json) -> Result<Wish, String> {
        read::<MoveRequest>(body)?.wish().map_err(|declined| declined.what)
    }

    #[test]
    fn a_move_is_what_it_says() {
        let wish = moved(json!({"axis": 2, "by": -4000, "top_speed": 500.5, "accel": 1000}));
        let Ok(Wish::Travel(axis, way, limits)) = wish else { panic!("{wish:?}") };
        assert_eq!((axis.number(), way), (2, Way::By(Distance::new(-4000))));
        let order = limits.order(Travel::By(Distance::new(1))).unwrap();
        assert_eq!((order.start.millisteps(), order.top.millisteps()), (50_000, 500_500));
        assert_eq!(order.up, Ramp::Accel(Accel::from_steps(1000).unwrap()));
        assert_eq!(order.down, order.up);
        // (1000 − 50) / 0.4 s
        let Ok(Wish::Travel(_, _, limits)) = moved(json!({"axis": 1, "to": 9})) else { panic!() };
        assert_eq!(limits.up, Accel::from_steps(2375).unwrap());
    }

    #[test]
    fn what_is_outside_its_range_is_no_wish() {
        for body in [
            json!({}),
            json!({"axis": 1}),
            json!({"axis": 0, "by": 1}),
            json!({"axis": 9, "by": 1}),
            json!({"axis": -1, "by": 1}),
            json!({"axis": "1", "by": 1}),
            json!({"axis": 1, "by": 1, "to": 1}),
            json!({"axis": 1, "by": 2_147_483_648_i64}),
            json!({"axis": 1, "by": 1.5}),
            json!({"axis": 1, "by": 1, "speed": 5}),
            json!({"axis": 1, "by": 1, "top_speed": 0}),
            json!({"axis": 1, "by": 1, "top_speed": 1_000_001}),
            json!({"axis": 1, "by": 1, "top_speed": -5}),
            json!({"axis": 1, "by": 1, "start_speed": -1}),
            json!({"axis": 1, "by": 1, "accel": 0.4}),
            json!({"axis": 1, "by": 1, "decel": 1e9}),
            json!({"axis": 1, "by": 1, "jerk": 0}),
        ] {
            assert!(moved(body.clone()).is_err(), "{body}");
        }
    }

    #[test]
    fn a_run_has_a_speed_and_a_hand() {
        let run = |speed: f64| {
            let request = read::<RunRequest>(json!({"axis": 1, "speed": speed})).unwrap();
            request.wish(Hand(7)).map_err(|declined| declined.status())
        };
        let Ok(Wish::Run(_, way, limits, hand)) = run(-0.5) else { panic!() };
        assert_eq!((way, limits.top.millisteps(), hand), (Direction::Backward, 500, Hand(7)));
        assert!(matches!(run(400.0), Ok(Wish::Run(_, Direction::Forward, ..))));
        for wrong in [0.0, -0.0004, 1e6 + 1.0, -1e300] {
            assert_eq!(run(wrong), Err(422), "{wrong}");
        }
    }

    #[test]
    fn a_change_changes_something() {
        let change = |body| read::<RetargetRequest>(body).unwrap().wish();
        let wish = change(json!({"axis": 1, "to": -5, "top_speed": 20, "decel": 1000.4})).unwrap();
        let Wish::Retarget(_, change_of) = wish else { panic!("{wish:?}") };
        assert_eq!(change_of.way, Some(Way::To(-5)));
        assert_eq!(change_of.down.map(|down| down.get()), Some(1000));
        assert_eq!((change_of.top.map(|top| top.steps()), change_of.up), (Some(20), None));
        assert!(change(json!({"axis": 1})).is_err());
        assert!(change(json!({"axis": 1, "accel": 0})).is_err());
    }

    #[test]
    fn settings_have_names_and_ranges() {
        let set = |name: &str, value: f64| {
            read::<SetRequest>(json!({"name": name, "value": value})).unwrap().wish()
        };
        let right = Value::new(Setting::Pulse, 3).unwrap();
        assert_eq!(set("pulse-us", 3.0).unwrap(), Wish::Set(right));
        for wrong in [21.0, 0.0, -1.0, -0.4, 2.5, 4_294_967_298.0, 1e300] {
            let declined = set("pulse-us", wrong).unwrap_err();
            assert_eq!(declined.allowed.as_deref(), Some("1 to 20 µs"), "{wrong}");
        }
        assert_eq!(set("pulse", 3.0).unwrap_err().status(), 422);
        assert_eq!(set("reset", 0.0).unwrap_err().status(), 422);
    }
}
