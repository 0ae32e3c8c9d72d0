//! A cycle file, as serde reads it.
//!
//! Whatever can be wrong with one value is a [`Spanned`], so that the error
//! points at its line.

use std::collections::BTreeMap;

use serde::Deserialize;
use stepwright_cycle::{
    AtHardEnd, AtSmallDelay, AtSoftEnd, AtTiming, Calibration, DelayRamp, Strategies,
};
use toml::Spanned;

/// The whole file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct File {
    /// What positions are counted in.
    #[serde(default = "nanometres")]
    pub unit: Spanned<String>,
    #[serde(default)]
    pub clock: Clock,
    #[serde(default)]
    pub strategies: Handling,
    #[serde(rename = "motor")]
    pub motors: Vec<Spanned<Motor>>,
    #[serde(rename = "cycle")]
    pub cycles: Vec<Spanned<Cycle>>,
}

fn nanometres() -> Spanned<String> {
    Spanned::new(0..0, "nm".to_owned())
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Clock {
    /// The fixed tick; without it every step has its own deadline.
    pub tick_us: Option<Spanned<u32>>,
    pub timer_hz: Option<Spanned<u32>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Handling {
    #[serde(default)]
    hard_end: HardEnd,
    #[serde(default)]
    soft_end: SoftEnd,
    #[serde(default)]
    small_delay: Small,
    #[serde(default)]
    timing: Timing,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum HardEnd {
    StopMotor,
    BrakeMotor,
    #[default]
    Cancel,
    BrakeAll,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum SoftEnd {
    StopMotor,
    #[default]
    Cancel,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Small {
    Fix,
    StopMotor,
    #[default]
    Cancel,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Timing {
    Ignore,
    #[default]
    Cancel,
}

impl Handling {
    pub fn strategies(&self) -> Strategies {
        Strategies {
            hard_end: match self.hard_end {
                HardEnd::StopMotor => AtHardEnd::StopMotor,
                HardEnd::BrakeMotor => AtHardEnd::BrakeMotor,
                HardEnd::Cancel => AtHardEnd::Cancel,
                HardEnd::BrakeAll => AtHardEnd::BrakeAll,
            },
            soft_end: match self.soft_end {
                SoftEnd::StopMotor => AtSoftEnd::StopMotor,
                SoftEnd::Cancel => AtSoftEnd::Cancel,
            },
            small_delay: match self.small_delay {
                Small::Fix => AtSmallDelay::Fix,
                Small::StopMotor => AtSmallDelay::StopMotor,
                Small::Cancel => AtSmallDelay::Cancel,
            },
            timing: match self.timing {
                Timing::Ignore => AtTiming::Ignore,
                Timing::Cancel => AtTiming::Cancel,
            },
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Motor {
    pub name: Spanned<String>,
    /// Distance of a step in the unit.
    pub step: Spanned<u32>,
    pub smallest_delay_us: Spanned<u32>,
    /// Units a second, each second, by which it brakes at a switch.
    pub decel: Option<Spanned<f64>>,
    #[serde(default)]
    pub inverted: bool,
    pub min: Option<i64>,
    pub max: Option<Spanned<i64>>,
    /// Where it is when it is switched on; 0, or on a board where that says it is.
    pub position: Option<i64>,
    /// The pins of a board.
    pub pins: Option<Spanned<Pins>>,
    /// Where the virtual switches stand: from here on they are closed.
    pub switch_min: Option<i64>,
    pub switch_max: Option<i64>,
}

/// Pins of a board, by the names that are printed on it.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pins {
    pub step: Option<Spanned<String>>,
    pub dir: Option<Spanned<String>>,
    pub enable: Option<Spanned<String>>,
    pub min: Option<Spanned<String>>,
    pub max: Option<Spanned<String>>,
}

/// One cycle: what each motor does.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Cycle {
    #[serde(default, rename = "move")]
    pub moves: BTreeMap<Spanned<String>, Spanned<Move>>,
    pub line: Option<Spanned<Line>>,
    pub arc: Option<Spanned<Arc>>,
    pub home: Option<Spanned<Home>>,
    /// Seconds after its start.
    pub pause_s: Option<Spanned<f64>>,
    pub resume_s: Option<Spanned<f64>>,
    pub finish_s: Option<Spanned<f64>>,
    /// What changes on the way.
    #[serde(default)]
    pub feed: Vec<Spanned<Feed>>,
    #[serde(default)]
    pub retarget: Vec<Spanned<Retarget>>,
    /// Seconds to stand still after it.
    pub rest_s: Option<Spanned<f64>>,
}

/// Where motors are to go.
pub type Targets = BTreeMap<Spanned<String>, i64>;

/// Another speed along the path, from some time on.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Feed {
    pub at_s: Spanned<f64>,
    /// Of the ordered speed.
    pub percent: Spanned<f64>,
}

/// Another end of the path, from some time on.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Retarget {
    pub at_s: Spanned<f64>,
    pub to: Spanned<Targets>,
}

/// Straight to a position.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Line {
    pub to: Targets,
    /// Units a second along the path.
    pub speed: Spanned<f64>,
    /// Units a second, each second.
    pub accel: Spanned<f64>,
    pub decel: Option<Spanned<f64>>,
    /// By how much that may change in a second: an S-curve.
    pub jerk: Option<Spanned<f64>>,
}

/// MotorIo a centre, which is a position.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Arc {
    pub motors: [Spanned<String>; 2],
    pub centre: [i64; 2],
    pub degrees: f64,
    /// Units a second along the path.
    pub speed: Spanned<f64>,
    /// Units a second, each second.
    pub accel: Spanned<f64>,
    pub decel: Option<Spanned<f64>>,
    /// By how much that may change in a second: an S-curve.
    pub jerk: Option<Spanned<f64>>,
}

/// To a switch.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Home {
    pub motor: Spanned<String>,
    pub end: Side,
    pub reach: u32,
    pub back_off: u32,
    #[serde(default)]
    pub fast_us: u32,
    #[serde(default)]
    pub slow_us: u32,
}

#[derive(Clone, Copy, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    Min,
    Max,
}

/// What a motor does.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Move {
    pub steps: Option<i32>,
    pub whirl: Option<Way>,
    pub series: Option<Vec<Leg>>,
    pub delays_us: Option<Vec<u32>>,
    pub each: Option<u32>,
    pub direction: Option<Way>,
    pub delay_us: Option<u32>,
    /// The delays of a callback.
    pub ramp_us: Option<Ramp>,
    #[serde(default)]
    calibrate: Calibrate,
}

impl Move {
    pub fn calibration(&self) -> Calibration {
        match self.calibrate {
            Calibrate::None => Calibration::None,
            Calibrate::StartMin => Calibration::StartMin,
            Calibrate::BoundsMax => Calibration::BoundsMax,
        }
    }
}

#[derive(Clone, Copy, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Way {
    Forward,
    Backward,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Calibrate {
    #[default]
    None,
    StartMin,
    BoundsMax,
}

/// A leg of a series: steps, or a wait.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Leg {
    pub steps: Option<i32>,
    /// This many delays without a step.
    pub wait: Option<Spanned<u32>>,
    #[serde(default)]
    pub delay_us: u32,
}

/// Delays that go from one value to another and stay there.
#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Ramp {
    pub from: u32,
    pub to: u32,
    /// The change from step to step.
    pub by: u32,
}

impl From<Ramp> for DelayRamp {
    fn from(Ramp { from, to, by }: Ramp) -> DelayRamp {
        DelayRamp { from, to, by }
    }
}
