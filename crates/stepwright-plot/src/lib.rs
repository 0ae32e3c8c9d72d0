//! Plots: position, speed and acceleration as .svg, .png or .html.
//!
//! ```
//! # use stepwright_plot::{MotionPlot, AxisSeries};
//! let speed = vec![(0.0, 0.0), (0.5, 1000.0), (1.5, 1000.0), (2.0, 0.0)];
//! let series = vec![AxisSeries { name: "axis 1".into(), speed, ..AxisSeries::default() }];
//! let plot = MotionPlot { title: "A move".into(), series, ..MotionPlot::default() };
//! let svg = plot.figure().svg();
//! assert!(svg.starts_with("<svg"));
//! ```
//!
//! A [`Figure`] is arranged once into a [`Picture`] of simple shapes, which every format writes. So
//! all three look the same, and none needs a library or a font of the system.
//!
//! | module | what |
//! | --- | --- |
//! | `figure` | panels, axes, curves, shaded ranges |
//! | `font` | glyphs and text widths |
//! | `clip` | clips a line to the view |
//! | [`Traces`], `slopes`, `jerk` | position, speed, acceleration and jerk from steps |
//! | [`WayPlot`] | the path of two motors, both axes to the same scale |
//! | `scale` | converts values to pixels, and chooses round numbers |
//! | `picture` | the shapes |
//! | `palette` | reduces the colours, for small files |
//! | `svg`, `png`, `html` | the formats |

#![warn(missing_docs)]
#![forbid(unsafe_code)]

mod clip;
mod figure;
mod font;
mod html;
mod jerk;
mod palette;
mod picture;
mod png;
mod scale;
mod slopes;
mod speed_way;
mod svg;
mod traces;
mod way;

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use stepwright_units::MachineUnit;

pub use clip::clip;
pub use figure::{Band, Curve, Figure, GAP, PALETTE, Panel, View};
pub use font::width;
pub use picture::{Anchor, Colour, Frame, Picture, Probe, ProbeCurve, Shape, Style};
pub use scale::{Scale, number, time_unit};
pub use speed_way::SpeedWay;
pub use traces::Traces;
pub use way::WayPlot;

/// The error of a plot that could not be written.
#[derive(Debug)]
pub enum PlotError {
    /// The picture can't be encoded.
    Draw(PathBuf, String),
    /// The file can't be written.
    Write(PathBuf, io::Error),
}

impl fmt::Display for PlotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PlotError::Draw(path, why) => write!(f, "can't draw {}: {why}", path.display()),
            PlotError::Write(path, why) => write!(f, "can't write {}: {why}", path.display()),
        }
    }
}

impl std::error::Error for PlotError {}

/// A file for a plot. Its name determines the format: `move.svg`, `.png` or `.html`.
#[derive(Clone, Debug)]
pub struct PlotFile {
    path: PathBuf,
    format: Format,
}

#[derive(Clone, Copy, Debug)]
enum Format {
    Svg,
    Png,
    Html,
}

impl FromStr for PlotFile {
    type Err = String;

    fn from_str(name: &str) -> Result<PlotFile, String> {
        let path = PathBuf::from(name);
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
        let format = match ending.as_str() {
            "svg" => Format::Svg,
            "png" => Format::Png,
            "html" | "htm" => Format::Html,
            _ => return Err("its name must end in .svg, .png or .html".into()),
        };
        Ok(PlotFile { path, format })
    }
}

impl PlotFile {
    /// The path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Checks that the file can be written, before a long motion.
    ///
    /// # Errors
    /// [`PlotError::Write`]
    pub fn check(&self) -> Result<(), PlotError> {
        let about = fs::metadata(&self.path);
        if about.as_ref().is_ok_and(|about| !about.is_file() && !about.is_dir()) {
            // A pipe is not opened: closing it would end its reader.
            return Ok(());
        }
        fs::OpenOptions::new()
            .append(true)
            .create(true)
            .open(&self.path)
            .map_err(|error| PlotError::Write(self.path.clone(), error))?;
        if about.is_err() {
            // Removes the new file again, since there may be nothing to draw. A link to it stays.
            let made = fs::canonicalize(&self.path).unwrap_or_else(|_| self.path.clone());
            let _ = fs::remove_file(made);
        }
        Ok(())
    }

    /// The file with a suffix before its extension: `a-2.png` for `a.png`.
    pub fn numbered(&self, what: &str) -> PlotFile {
        let part = |part: Option<&std::ffi::OsStr>| {
            part.map_or(String::new(), |part| part.to_string_lossy().into_owned())
        };
        let (stem, ending) = (part(self.path.file_stem()), part(self.path.extension()));
        let path = self.path.with_file_name(format!("{stem}-{what}.{ending}"));
        PlotFile { path, format: self.format }
    }

    /// Draws into the file.
    ///
    /// # Errors
    /// [`PlotError`]
    pub fn save(&self, figure: &Figure) -> Result<(), PlotError> {
        self.save_picture(&figure.title, &figure.picture())
    }

    /// Like [`save`](PlotFile::save), for a picture that is not a [`Figure`]. `title` is that of an
    /// HTML page.
    ///
    /// # Errors
    /// [`PlotError`]
    pub fn save_picture(&self, title: &str, picture: &Picture) -> Result<(), PlotError> {
        let bytes = match self.format {
            Format::Svg => svg::render(picture).into_bytes(),
            Format::Html => html::page(title, picture).into_bytes(),
            Format::Png => {
                png::render(picture).map_err(|why| PlotError::Draw(self.path.clone(), why))?
            }
        };
        fs::write(&self.path, bytes).map_err(|error| PlotError::Write(self.path.clone(), error))
    }
}

/// The motion of one or more axes over time: position, speed and acceleration.
#[derive(Clone, Debug, Default)]
pub struct MotionPlot {
    /// The heading.
    pub title: String,
    /// Smaller lines below it.
    pub notes: Vec<String>,
    /// The axes.
    pub series: Vec<AxisSeries>,
    /// The unit of the scales; steps by default.
    pub unit: Option<MachineUnit>,
    /// Whether the jerk is drawn too.
    pub jerk: bool,
    /// Whether each axis has separate panels, one below the other.
    pub stacked: bool,
}

/// The motion of one axis: points in the order of time, each of seconds and a value, which is
/// negative backward.
#[derive(Clone, Debug, Default)]
pub struct AxisSeries {
    /// `axis 1`
    pub name: String,
    /// Steps.
    pub position: Vec<(f64, f64)>,
    /// Steps/s.
    pub speed: Vec<(f64, f64)>,
    /// Steps/s².
    pub accel: Vec<(f64, f64)>,
    /// Steps/s³.
    pub jerk: Vec<(f64, f64)>,
    /// The longest time in s over which speeds were compared.
    pub window: f64,
}

/// The time of a point.
fn time(point: Option<&(f64, f64)>) -> f64 {
    point.map_or(0.0, |(time, _)| *time)
}

impl MotionPlot {
    /// The figure with its panels.
    pub fn figure(&self) -> Figure {
        let ends = |series: &AxisSeries| [series.speed.last(), series.position.last()].map(time);
        let end = self.series.iter().flat_map(ends).fold(0.0, f64::max);
        let unit = self.unit.map_or("steps", |unit| unit.name);
        let window = self.series.iter().map(|series| series.window).fold(0.0, f64::max);
        // A change that is shorter than the window does not show its true height.
        let means =
            if window >= 0.1 { format!(", mean of up to {window:.1} s") } else { String::new() };
        let mut shown = vec![
            Quantity::new("Position", 280.0, format!("{unit} from the start"), |s| &s.position),
            Quantity::new("Speed", 300.0, format!("{unit}/s"), |s| &s.speed),
            Quantity::new("Acceleration", 270.0, format!("{unit}/s²{means}"), |s| &s.accel),
        ];
        if self.jerk {
            shown.push(Quantity::new("Jerk", 250.0, format!("{unit}/s³{means}"), |s| &s.jerk));
        }
        let mut rows: Vec<_> = shown.iter().flat_map(|shown| self.rows(shown, end)).collect();
        if let Some(last) = rows.last_mut().and_then(|(_, panels)| panels.last_mut()) {
            last.x.0 = "time".into();
        }
        let notes = self.notes.iter().cloned().chain(self.unit.map(MachineUnit::note)).collect();
        Figure { title: self.title.clone(), notes, rows }
    }

    /// The rows of a quantity: one for all axes, or one for each.
    fn rows(&self, shown: &Quantity, end: f64) -> Vec<(f64, Vec<Panel>)> {
        let (unit, per_second) = time_unit(end);
        let steps = self.unit.map_or(1.0, |unit| unit.steps);
        let curve = |(series, colour): (&AxisSeries, &_)| Curve {
            name: series.name.clone(),
            colour: *colour,
            points: (shown.points)(series)
                .iter()
                .map(|(t, v)| (t * per_second, v / steps))
                .collect(),
            filled: (self.series.len() == 1 || self.stacked) && shown.name != "Position",
            ..Curve::default()
        };
        let panel = |name: String, curves: Vec<Curve>| Panel {
            y: (name, shown.unit.clone()),
            x: (String::new(), unit.into()),
            curves,
            // All panels show the same time.
            view: View { x: Some((0.0, end * per_second)), y: None },
            ..Panel::default()
        };
        let curves = self.series.iter().zip(PALETTE.iter().cycle()).map(curve);
        if !self.stacked || self.series.len() < 2 {
            return vec![(shown.height, vec![panel(shown.name.to_owned(), curves.collect())])];
        }
        let own = |curve: Curve| {
            let name = format!("{} of {}", shown.name, curve.name);
            (STACKED, vec![panel(name, vec![curve])])
        };
        curves.map(own).collect()
    }
}

/// The height of a panel if the axes are stacked.
const STACKED: f64 = 200.0;

/// A quantity that is drawn for each axis.
struct Quantity {
    name: &'static str,
    unit: String,
    /// The height of a panel with all axes.
    height: f64,
    points: fn(&AxisSeries) -> &Vec<(f64, f64)>,
}

impl Quantity {
    fn new(
        name: &'static str,
        height: f64,
        unit: String,
        points: fn(&AxisSeries) -> &Vec<(f64, f64)>,
    ) -> Quantity {
        Quantity { name, unit, height, points }
    }
}

#[cfg(test)]
mod tests;
