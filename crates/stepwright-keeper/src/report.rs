//! Reports of the server, as JSON.

use serde::Serialize;

use crate::request::home::HomeReport;

/// The board's description: `GET /api/board`.
#[derive(Clone, Debug, Default, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct BoardSheet {
    /// The name of the board: its port, or `the virtual board`.
    pub name: String,
    /// The version of its protocol.
    pub protocol: Option<String>,
    /// What it can do: `jerk`, `safety`, `sum`, …
    pub can: Vec<&'static str>,
    /// The highest speed of one axis, in steps/s.
    pub max_speed: Option<u32>,
    /// Its axes.
    pub axes: Vec<AxisSheet>,
    /// Its settings; empty if the board has none.
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
    /// Its values.
    pub values: Vec<MachineValue>,
}

/// A value of a machine file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct MachineValue {
    /// The axis; none for a value of the board itself.
    pub axis: Option<u8>,
    /// The name in the file.
    pub name: &'static str,
    /// The value with its unit.
    pub value: String,
}

/// The description of an axis.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct AxisSheet {
    /// Its number, from 1.
    pub axis: u8,
    /// The unit of its position: `steps`, `mm` or `deg`.
    pub unit: &'static str,
    /// Steps per unit.
    pub steps_per_unit: f64,
    /// Whether the board watches a limit switch of this axis.
    pub switch: bool,
    /// How far that switch may be, in steps: `home-within` of the machine file. Without it a homing needs
    /// `within`.
    pub home_within: Option<u32>,
}

/// A setting of the board.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct SettingSheet {
    /// Its name, the same everywhere.
    pub name: &'static str,
    /// Its value.
    pub value: u32,
    /// The default of a board that was never set up.
    pub default: u32,
    /// The smallest value.
    pub min: u32,
    /// The largest value.
    pub max: u32,
    /// The unit of the value; empty for a switch or a set of axes.
    pub unit: &'static str,
    /// What it does.
    pub help: &'static str,
}

/// The state of the board: `GET /api/state`, and frames of `/api/live`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct LiveState {
    /// Seconds since the server began.
    pub time: f64,
    /// Whether the board answers.
    pub connected: bool,
    /// Why it does not answer, and the remedy.
    pub trouble: Option<Trouble>,
    /// Its axes.
    pub axes: Vec<LiveAxis>,
    /// The number of late steps since the last acknowledgement.
    pub late: u32,
    /// The number of lines that the board has refused since the last acknowledgement.
    pub refused: u32,
    /// The errors since the last acknowledgement.
    pub errors: Vec<Reason>,
    /// Who has control, if anyone.
    pub control: Option<Controller>,
    /// Counts how often the board was met or a setting changed: ask `GET /api/board` again.
    pub sheet: u64,
}

/// The state of an axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct LiveAxis {
    /// Its number, from 1.
    pub axis: u8,
    /// Its position, in steps; nothing if that is unknown.
    pub position: Option<i64>,
    /// The time of the position, in seconds since the server began.
    pub time: f64,
    /// Its speed over the last tenth of a second, in steps/s.
    pub speed: f64,
    /// Whether it moves, or is being homed.
    pub moving: bool,
    /// `ready`, `busy` or `uncertain`.
    pub state: &'static str,
    /// What stopped it before the end of its order.
    pub stop: Option<Reason>,
    /// Its present or last homing.
    pub home: Option<HomeReport>,
    /// Counts how often another place was made 0: positions from before and after can't be compared.
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
    /// The remedy.
    #[serde(rename = "do")]
    pub remedy: Option<String>,
}

/// Who has control.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct Controller {
    /// The number of the hand: control that is given again has another number.
    pub hand: u64,
    /// Its name.
    pub name: String,
    /// Whether it was heard from recently.
    pub live: bool,
}

/// Control that was given: the answer to `POST /api/control`.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct ControlGiven {
    /// The number of this hand.
    pub hand: u64,
    /// The key that orders need, in the header `Stepwright-Control`.
    pub key: String,
    /// An endless run brakes after this much silence, in ms. A beat over `/api/live`, an order or `POST
    /// /api/control/beat` ends a silence.
    pub lease_ms: u32,
}

/// The result of an order.
#[derive(Clone, Debug, Default, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct Done {
    /// The lines that the board has accepted.
    pub lines: Vec<String>,
    /// How the order has ended, if the request has waited for the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ended: Option<OrderEnd>,
}

/// How an order has ended: for a request with `?wait=true`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct OrderEnd {
    /// `reached`: every axis rests at its target, or is homed. `stopped`: an axis rests elsewhere. `uncertain`:
    /// the position of an axis is unknown.
    pub outcome: &'static str,
    /// The outcome in words, with the reason.
    pub words: String,
    /// The remedy.
    #[serde(rename = "do", skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
    /// The axes of the order.
    pub axes: Vec<AxisEnd>,
}

/// The end of an axis.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct AxisEnd {
    /// Its number, from 1.
    pub axis: u8,
    /// Its position at rest, in steps; nothing if that is unknown.
    pub position: Option<i64>,
    /// Its target, from the last retarget; nothing for a homing.
    pub target: Option<i64>,
    /// What stopped it before the end of its order.
    pub stop: Option<Reason>,
}

/// A line of the conversation with the board, and its answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct Exchange {
    /// Seconds since the server began.
    pub time: f64,
    /// The line.
    pub line: String,
    /// The meaning of the line.
    pub means: String,
    /// The answer, if one came.
    pub answer: Option<String>,
    /// The meaning of the answer.
    pub answer_means: String,
    /// Whether the line only asks, and changes nothing.
    pub question: bool,
}

/// The expected course of an axis under an order, from its law.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct PlannedCurve {
    /// The axis.
    pub axis: u8,
    /// When the order was accepted, in seconds since the server began.
    pub begin: f64,
    /// The times of the points, in seconds from `begin`.
    pub seconds: Vec<f64>,
    /// The positions at these times, in steps.
    pub position: Vec<f64>,
    /// The speeds at these times, in steps/s, positive forward.
    pub speed: Vec<f64>,
}

/// The progress of a run: `GET /api/path`, and frames of `/api/live`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct PathReport {
    /// The name of the file in messages.
    pub name: String,
    /// An identifier of the file's text, the same as that of its drawing.
    pub id: String,
    /// `running`, `held` after a hold, `braking` after a stop, then `done`, `stopped`, `killed` or `failed`.
    pub state: &'static str,
    /// The time that was played, in s.
    pub seconds: f64,
    /// The positions of the motors at that time.
    pub places: Vec<i64>,
    /// Why it has failed, and the remedy.
    pub trouble: Option<Trouble>,
}

/// A message of the WebSocket `/api/live`.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum LiveMessage {
    /// The state of the board: up to 50 a second while an axis moves.
    State(LiveState),
    /// A line to the board, and its answer.
    Line(Exchange),
    /// The expected course of an axis.
    Plan(PlannedCurve),
    /// The progress of a path's run: some 50 a second.
    Path(PathReport),
    /// A note for users.
    Note {
        /// The time, in seconds since the server began.
        time: f64,
        /// The note.
        text: String,
    },
    /// The travel of this axis was changed: its plan is no longer valid.
    Unplanned {
        /// The axis.
        axis: u8,
        /// The time, in seconds since the server began.
        time: f64,
    },
}
