//! The drawing of a file of lines, arcs and other moves of several motors.

use serde::Serialize;

/// What the motors do with a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct PathDrawing {
    /// An identifier of the text and the laser, the same as in a [`PathReport`](crate::report::PathReport).
    pub id: String,
    /// `cycles`, or `gcode`.
    pub kind: &'static str,
    /// The unit of positions; speeds are in this unit per second.
    pub unit: String,
    /// The motors.
    pub motors: Vec<PathMotor>,
    /// The duration, in s.
    pub seconds: f64,
    /// The highest speed along the path.
    pub peak: f64,
    /// Further facts in words: for a job its exact time, its extents, and the corners that cost most.
    pub facts: Vec<PathFact>,
    /// Why the board would refuse to run it; nothing if it would not.
    pub refused: Option<String>,
    /// Its parts, in order of time.
    pub legs: Vec<PathLeg>,
    /// The times of the points below, in s from the beginning.
    pub times: Vec<f64>,
    /// The speeds along the path at these times.
    pub speeds: Vec<f64>,
    /// For a job with a laser the powers at these times, from 0, off, to 1. A jump has two points at one time.
    pub powers: Option<Vec<f64>>,
    /// The positions of the motors at these times.
    pub places: Vec<Vec<f64>>,
}

/// A motor of a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct PathMotor {
    /// Its name in the file.
    pub name: String,
    /// The length of a step.
    pub step: f64,
}

/// A fact about a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct PathFact {
    /// Its name; for a corner its place, in mm.
    pub name: String,
    /// Its value; for a corner its cost, and the speed at which it is passed.
    pub value: String,
    /// The line of a corner.
    pub line: Option<usize>,
}

/// A part of a drawing.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct PathLeg {
    /// `line`, `arc`, `path` for several of them, `home`, `moves` of single motors, or `rest`; for a job also
    /// `rapid`, `probe`, and `lines` for several lines of a long one.
    pub kind: &'static str,
    /// Its line in the file.
    pub line: usize,
    /// The last of several lines; otherwise the same.
    pub to_line: usize,
    /// When it begins, in s from the beginning.
    pub begin: f64,
    /// When it ends.
    pub end: f64,
    /// Its highest speed along the path.
    pub peak: f64,
    /// The ordered speed of a line or an arc.
    pub ordered: Option<f64>,
    /// Its first point.
    pub first: usize,
    /// Its last point.
    pub last: usize,
}
