//! A cycle file, as serde reads it.
//!
//! Each value that can be wrong is a [`Spanned`], so that the error points at its line.

use std::collections::BTreeMap;

use serde::Deserialize;
use stepwright_cycle::{
    AtHardEnd, AtSmallDelay, AtSoftEnd, AtTiming, Calibration, DelayRamp, Strategies,
};
use toml::Spanned;

/// The whole file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(crate) struct File {
    /// The unit of positions.
    #[serde(default = "nanometres")]
    pub(crate) unit: Spanned<String>,
    #[serde(default)]
    pub(crate) clock: Clock,
    #[serde(default)]
    pub(crate) strategies: Handling,
    #[serde(rename = "motor")]
    pub(crate) motors: Vec<Spanned<Motor>>,
    #[serde(rename = "cycle")]
    pub(crate) cycles: Vec<Spanned<Cycle>>,
}

fn nanometres() -> Spanned<String> {
    Spanned::new(0..0, "nm".to_owned())
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(crate) struct Clock {
    /// The fixed tick; without it every step has its own deadline.
    pub(crate) tick_us: Option<Spanned<u32>>,
    pub(crate) timer_hz: Option<Spanned<u32>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(crate) struct Handling {
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
    pub(crate) fn strategies(&self) -> Strategies {
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
pub(crate) struct Motor {
    pub(crate) name: Spanned<String>,
    /// The length of a step, in the unit.
    pub(crate) step: Spanned<u32>,
    pub(crate) smallest_delay_us: Spanned<u32>,
    /// The deceleration at a switch, in units/s².
    pub(crate) decel: Option<Spanned<f64>>,
    #[serde(default)]
    pub(crate) inverted: bool,
    pub(crate) min: Option<i64>,
    pub(crate) max: Option<Spanned<i64>>,
    /// The position at power-on; by default 0, or on a board the position that the board reports.
    pub(crate) position: Option<i64>,
    /// The pins of a board.
    pub(crate) pins: Option<Spanned<Pins>>,
    /// The positions of the virtual switches: from there on they are closed.
    pub(crate) switch_min: Option<i64>,
    pub(crate) switch_max: Option<i64>,
}

/// Pins of a board, by the names that are printed on it.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Pins {
    pub(crate) step: Option<Spanned<String>>,
    pub(crate) dir: Option<Spanned<String>>,
    pub(crate) enable: Option<Spanned<String>>,
    pub(crate) min: Option<Spanned<String>>,
    pub(crate) max: Option<Spanned<String>>,
}

/// One cycle: the moves of the motors.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(crate) struct Cycle {
    #[serde(default, rename = "move")]
    pub(crate) moves: BTreeMap<Spanned<String>, Spanned<Move>>,
    pub(crate) line: Option<Spanned<Line>>,
    pub(crate) arc: Option<Spanned<Arc>>,
    pub(crate) path: Option<Spanned<Joined>>,
    pub(crate) home: Option<Spanned<Home>>,
    /// The time after the start of the cycle, in s.
    pub(crate) pause_s: Option<Spanned<f64>>,
    pub(crate) resume_s: Option<Spanned<f64>>,
    pub(crate) finish_s: Option<Spanned<f64>>,
    /// The changes on the way.
    #[serde(default)]
    pub(crate) feed: Vec<Spanned<Feed>>,
    #[serde(default)]
    pub(crate) retarget: Vec<Spanned<Retarget>>,
    /// The rest after the cycle, in s.
    pub(crate) rest_s: Option<Spanned<f64>>,
}

/// Motors, and the positions to which they move.
pub(crate) type Targets = BTreeMap<Spanned<String>, i64>;

/// A new speed along the path, from a time on.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(crate) struct Feed {
    pub(crate) at_s: Spanned<f64>,
    /// The per cent of the ordered speed.
    pub(crate) percent: Spanned<f64>,
}

/// A new end of the path, from a time on.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(crate) struct Retarget {
    pub(crate) at_s: Spanned<f64>,
    pub(crate) to: Spanned<Targets>,
}

/// A straight line to a position.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(crate) struct Line {
    pub(crate) to: Targets,
    /// The speed along the path, in units/s.
    pub(crate) speed: Spanned<f64>,
    /// The acceleration along the path, in units/s².
    pub(crate) accel: Spanned<f64>,
    pub(crate) decel: Option<Spanned<f64>>,
    /// The jerk along the path, in units/s³: an S-curve.
    pub(crate) jerk: Option<Spanned<f64>>,
}

/// An arc around a centre, which is a position.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(crate) struct Arc {
    pub(crate) motors: [Spanned<String>; 2],
    pub(crate) centre: [i64; 2],
    pub(crate) degrees: f64,
    /// The speed along the path, in units/s.
    pub(crate) speed: Spanned<f64>,
    /// The acceleration along the path, in units/s².
    pub(crate) accel: Spanned<f64>,
    pub(crate) decel: Option<Spanned<f64>>,
    /// The jerk along the path, in units/s³: an S-curve.
    pub(crate) jerk: Option<Spanned<f64>>,
}

/// Lines and arcs, one after the other without a stop.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(crate) struct Joined {
    /// The speed along the path, in units/s.
    pub(crate) speed: Spanned<f64>,
    /// The acceleration of each motor, in units/s².
    pub(crate) accel: Spanned<f64>,
    /// The change of the speed of a motor that is allowed at once, in units/s.
    pub(crate) start_speed: Option<Spanned<f64>>,
    pub(crate) jerk: Option<Spanned<f64>>,
    pub(crate) pieces: Vec<Spanned<Piece>>,
}

/// A line, or an arc.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Piece {
    #[serde(default)]
    pub(crate) to: Targets,
    pub(crate) motors: Option<[Spanned<String>; 2]>,
    pub(crate) centre: Option<[i64; 2]>,
    pub(crate) degrees: Option<f64>,
}

/// Homing to a switch.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(crate) struct Home {
    pub(crate) motor: Spanned<String>,
    pub(crate) end: Side,
    pub(crate) reach: u32,
    pub(crate) back_off: u32,
    #[serde(default)]
    pub(crate) fast_us: u32,
    #[serde(default)]
    pub(crate) slow_us: u32,
}

#[derive(Clone, Copy, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Side {
    Min,
    Max,
}

/// The move of a motor.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(crate) struct Move {
    pub(crate) steps: Option<i32>,
    pub(crate) whirl: Option<Way>,
    pub(crate) series: Option<Vec<Leg>>,
    pub(crate) delays_us: Option<Vec<u32>>,
    pub(crate) each: Option<u32>,
    pub(crate) direction: Option<Way>,
    pub(crate) delay_us: Option<u32>,
    /// The delays of a callback.
    pub(crate) ramp_us: Option<Ramp>,
    #[serde(default)]
    calibrate: Calibrate,
}

impl Move {
    pub(crate) fn calibration(&self) -> Calibration {
        match self.calibrate {
            Calibrate::None => Calibration::None,
            Calibrate::StartMin => Calibration::StartMin,
            Calibrate::BoundsMax => Calibration::BoundsMax,
        }
    }
}

#[derive(Clone, Copy, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Way {
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
pub(crate) struct Leg {
    pub(crate) steps: Option<i32>,
    /// This many delays without a step.
    pub(crate) wait: Option<Spanned<u32>>,
    #[serde(default)]
    pub(crate) delay_us: u32,
}

/// Delays that change from one value to another, and stay there.
#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(crate) struct Ramp {
    pub(crate) from: u32,
    pub(crate) to: u32,
    /// The change from step to step.
    pub(crate) by: u32,
}

impl From<Ramp> for DelayRamp {
    fn from(Ramp { from, to, by }: Ramp) -> DelayRamp {
        DelayRamp { from, to, by }
    }
}
