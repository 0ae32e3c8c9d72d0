//! What the server tells, as JSON.

use serde::Serialize;

use crate::request::home::HomeReport;

/// What the board is: `GET /api/board`.
#[derive(Clone, Debug, Default, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct BoardSheet {
    /// What to call it: its port, or `the virtual board`.
    pub name: String,
    /// The version of its protocol.
    pub protocol: Option<String>,
    /// What it can do: `jerk`, `safety`, `sum`, …
    pub can: Vec<&'static str>,
    /// The fastest it steps one axis, in steps/s.
    pub max_speed: Option<u32>,
    /// Its axes.
    pub axes: Vec<AxisSheet>,
    /// Its settings; none of a board that has none.
    pub settings: Vec<SettingSheet>,
    /// The machine file that was read when the server started.
    pub machine: Option<MachineSheet>,
}

/// A machine file: how a machine's axes are built.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct MachineSheet {
    /// Its path.
    pub file: String,
    /// What stands in it.
    pub values: Vec<MachineValue>,
}

/// A value of a machine file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct MachineValue {
    /// The axis that it is of; none for the board's own.
    pub axis: Option<u8>,
    /// Its name there.
    pub name: &'static str,
    /// What stands there, with its unit.
    pub value: String,
}

/// What an axis is.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct AxisSheet {
    /// Its number, from 1.
    pub axis: u8,
    /// The unit that its position is shown in: `steps`, `mm` or `deg`.
    pub unit: &'static str,
    /// Steps of one such unit.
    pub steps_per_unit: f64,
    /// Whether the board looks at a limit switch of this axis.
    pub switch: bool,
    /// How far that switch may be, in steps: `home-within` of the machine file. Without it a
    /// homing has to say `within`.
    pub home_within: Option<u32>,
}

/// A setting of the board.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct SettingSheet {
    /// Its name, the same everywhere.
    pub name: &'static str,
    /// Its number.
    pub value: u32,
    /// What a board has that nobody has set up.
    pub default: u32,
    /// The smallest number.
    pub min: u32,
    /// The largest number.
    pub max: u32,
    /// The unit of its number; empty for a switch or a set of axes.
    pub unit: &'static str,
    /// What it does.
    pub help: &'static str,
}

/// What the board does: `GET /api/state`, and frames of `/api/live`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct LiveState {
    /// Seconds since the server began.
    pub time: f64,
    /// Whether the board answers.
    pub connected: bool,
    /// Why it does not, and what can be done.
    pub trouble: Option<Trouble>,
    /// Its axes.
    pub axes: Vec<LiveAxis>,
    /// Steps that came late since the last acknowledgement.
    pub late: u32,
    /// Lines that the board has refused since then.
    pub refused: u32,
    /// What has gone wrong since then.
    pub errors: Vec<Reason>,
    /// Who controls, if anyone.
    pub control: Option<Controller>,
    /// Counts the times that the board was met, or a setting changed: `GET /api/board` again.
    pub sheet: u64,
}

/// What an axis does.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct LiveAxis {
    /// Its number, from 1.
    pub axis: u8,
    /// Where it is, in steps; nothing if that is not known.
    pub position: Option<i64>,
    /// When that was, in seconds since the server began.
    pub time: f64,
    /// Its speed over the last tenth of a second, in steps/s.
    pub speed: f64,
    /// Whether it moves, or is being homed.
    pub moving: bool,
    /// `ready`, `busy` or `uncertain`.
    pub state: &'static str,
    /// What has stopped it before the end of its order.
    pub stop: Option<Reason>,
    /// Its homing, if it is being homed, or was.
    pub home: Option<HomeReport>,
    /// Counts the times that another place was called 0: positions from before it are not
    /// to be compared with those after.
    pub origin: u32,
}

/// A reason, for programs and for people.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct Reason {
    /// For programs: `switch`.
    pub name: String,
    /// For people: `its limit switch`.
    pub words: &'static str,
}

/// Why the board can't be reached.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct Trouble {
    /// What happened.
    pub what: String,
    /// What can be done about it.
    #[serde(rename = "do")]
    pub remedy: Option<String>,
}

/// Who controls.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct Controller {
    /// Its number: control that is given again has another one.
    pub hand: u64,
    /// Its name.
    pub name: String,
    /// Whether it was heard of a moment ago.
    pub live: bool,
}

/// Control that was given: the answer to `POST /api/control`.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct ControlGiven {
    /// The number of this hand.
    pub hand: u64,
    /// The word that orders need, in the header `Stepwright-Control`.
    pub key: String,
    /// A run without end brakes after this much silence, in ms. A beat over `/api/live`,
    /// an order or `POST /api/control/beat` ends a silence.
    pub lease_ms: u32,
}

/// What has become of an order.
#[derive(Clone, Debug, Default, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct Done {
    /// The lines that the board has taken.
    pub lines: Vec<String>,
    /// How the order has ended, in an answer that has waited for that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ended: Option<OrderEnd>,
}

/// How an order has ended: of a request with `?wait=true`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct OrderEnd {
    /// `reached`: every axis rests where it was ordered to, or is homed. `stopped`: one rests
    /// elsewhere. `uncertain`: it is not known where one is.
    pub outcome: &'static str,
    /// The same for people, with the reason.
    pub words: String,
    /// What can be done about it.
    #[serde(rename = "do", skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
    /// The axes of the order.
    pub axes: Vec<AxisEnd>,
}

/// Where an axis has ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct AxisEnd {
    /// Its number, from 1.
    pub axis: u8,
    /// Where it rests, in steps; nothing if that is not known.
    pub position: Option<i64>,
    /// Where it was ordered to, by the last retarget; nothing of a homing.
    pub target: Option<i64>,
    /// What has stopped it before the end of its order.
    pub stop: Option<Reason>,
}

/// A line of the conversation with the board, and its answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct Exchange {
    /// Seconds since the server began.
    pub time: f64,
    /// What was said.
    pub line: String,
    /// What that means.
    pub means: String,
    /// The answer, if one came.
    pub answer: Option<String>,
    /// What that means.
    pub answer_means: String,
    /// Whether the line asks something, and changes nothing.
    pub question: bool,
}

/// Where an axis is to be, from an order on: what its law says.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct PlannedCurve {
    /// Which axis.
    pub axis: u8,
    /// When the order was taken, in seconds since the server began.
    pub begin: f64,
    /// Seconds from there.
    pub seconds: Vec<f64>,
    /// Where the axis is then, in steps.
    pub position: Vec<f64>,
    /// Its speed then, in steps/s, + forward.
    pub speed: Vec<f64>,
}

/// How a run goes on: `GET /api/path`, and frames of `/api/live`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct PathReport {
    /// What messages call the file.
    pub name: String,
    /// The same for the same text: that of its drawing.
    pub id: String,
    /// `running`, `held` from a hold on, `braking` after a stop, then `done`, `stopped`, `killed` or `failed`.
    pub state: &'static str,
    /// The time that was played, in s.
    pub seconds: f64,
    /// Where each motor is then.
    pub places: Vec<i64>,
    /// Why it has failed, and what can be done.
    pub trouble: Option<Trouble>,
}

/// A message of the WebSocket `/api/live`.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum LiveMessage {
    /// What the board does: up to 50 a second while an axis moves.
    State(LiveState),
    /// What was said to the board.
    Line(Exchange),
    /// What an axis is going to do.
    Plan(PlannedCurve),
    /// How the run of a path goes on: some 50 a second.
    Path(PathReport),
    /// Something that people should know.
    Note {
        /// When, in seconds since the server began.
        time: f64,
        /// What.
        text: String,
    },
    /// The travel of this axis was changed: its plan holds no longer.
    Unplanned {
        /// Which axis.
        axis: u8,
        /// When, in seconds since the server began.
        time: f64,
    },
}
