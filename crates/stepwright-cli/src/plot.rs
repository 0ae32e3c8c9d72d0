//! Plots: position, speed and acceleration as .svg, .png or .html.
//!
//! A [`Figure`] is arranged once into a [`picture`] of simple shapes, which
//! every format then writes; so all three look the same, and none of them
//! needs a library or a font of the system.
//!
//! | module | what |
//! | --- | --- |
//! | [`figure`] | panels, axes, curves, shaded stretches |
//! | [`font`] | glyphs, and how wide a text is |
//! | [`clip`] | the part of a line that is in view |
//! | [`scale`] | from values to pixels, round numbers |
//! | [`picture`] | the shapes |
//! | [`palette`] | few colours, for small files |
//! | `svg`, `png`, `html` | the formats |

mod clip;
mod figure;
mod font;
mod html;
mod palette;
mod picture;
mod png;
mod scale;
mod svg;

use std::fs;
use std::path::PathBuf;
use std::str::FromStr;

use crate::failure::Failure;
use crate::say;

pub use clip::clip;
pub use figure::{Band, Curve, Figure, GAP, PALETTE, Panel, View};
pub use font::width;
pub use picture::{Frame, Picture, Shape, Style};
pub use scale::{Scale, number, time_unit};

/// A file for a plot, whose name says the format: for clap's `#[arg]`.
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
    /// That it can be written: before a long motion, not after it.
    pub fn check(&self) -> Result<(), Failure> {
        let is_new = !self.path.exists();
        fs::OpenOptions::new()
            .append(true)
            .create(true)
            .open(&self.path)
            .map_err(|error| Failure::file("write", &self.path, &error))?;
        if is_new {
            // There may never be anything to draw.
            let _ = fs::remove_file(&self.path);
        }
        Ok(())
    }

    /// The same file with something before its ending: `a-2.png` for `a.png`.
    pub fn numbered(&self, what: &str) -> PlotFile {
        let part = |part: Option<&std::ffi::OsStr>| {
            part.map_or(String::new(), |part| part.to_string_lossy().into_owned())
        };
        let (stem, ending) = (part(self.path.file_stem()), part(self.path.extension()));
        let path = self.path.with_file_name(format!("{stem}-{what}.{ending}"));
        PlotFile { path, format: self.format }
    }

    /// Draws into the file, and says so on standard error.
    pub fn save(&self, figure: &Figure) -> Result<(), Failure> {
        self.save_picture(&figure.title, &figure.picture())
    }

    /// The same for a picture that is no figure.
    pub fn save_picture(&self, title: &str, picture: &Picture) -> Result<(), Failure> {
        let bytes = match self.format {
            Format::Svg => svg::render(picture).into_bytes(),
            Format::Html => html::page(title, picture).into_bytes(),
            Format::Png => {
                png::render(picture).map_err(|error| Failure::file("draw", &self.path, &error))?
            }
        };
        fs::write(&self.path, bytes).map_err(|error| Failure::file("write", &self.path, &error))?;
        say::note(format_args!("plot written to {}", self.path.display()));
        Ok(())
    }
}

/// What one or more axes did over time: position, speed and acceleration.
#[derive(Clone, Debug)]
pub struct MotionPlot {
    /// The heading.
    pub title: String,
    /// Smaller lines below it.
    pub notes: Vec<String>,
    /// The axes.
    pub series: Vec<Series>,
}

/// What one axis did: points in the order of time, each of seconds and a value, which is
/// negative backwards.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// `axis 1`
    pub name: String,
    /// Steps.
    pub position: Vec<(f64, f64)>,
    /// Steps/s.
    pub speed: Vec<(f64, f64)>,
    /// Steps/s².
    pub accel: Vec<(f64, f64)>,
    /// Seconds over which speeds were compared, at most.
    pub window: f64,
}

impl MotionPlot {
    /// Draws into the file.
    pub fn save(&self, file: &PlotFile) -> Result<(), Failure> {
        file.save(&self.figure())
    }

    fn figure(&self) -> Figure {
        let end = |series: &Series| series.speed.last().map_or(0.0, |(t, _)| *t);
        let end = self.series.iter().map(end).fold(0.0, f64::max);
        let (unit, per_second) = time_unit(end);
        let panel = |y: (&str, &str), x: &str, points: fn(&Series) -> &Vec<(f64, f64)>| {
            let curves = self.series.iter().zip(PALETTE.iter().cycle());
            let curves = curves.map(|(series, colour)| Curve {
                name: series.name.clone(),
                colour: *colour,
                points: points(series).iter().map(|(t, v)| (t * per_second, *v)).collect(),
                filled: self.series.len() == 1 && y.0 != "Position",
                ..Curve::default()
            });
            Panel {
                y: (y.0.into(), y.1.into()),
                x: (x.into(), unit.into()),
                curves: curves.collect(),
                // The same time in all three.
                view: View { x: Some((0.0, end * per_second)), y: None },
                ..Panel::default()
            }
        };
        let position = panel(("Position", "steps from the start"), "", |s| &s.position);
        let speed = panel(("Speed", "steps/s"), "", |s| &s.speed);
        let window = self.series.iter().map(|series| series.window).fold(0.0, f64::max);
        // What is shorter has no height of its own.
        let means =
            if window >= 0.1 { format!(", mean of up to {window:.1} s") } else { String::new() };
        let unit_of_accel = format!("steps/s²{means}");
        let accel = panel(("Acceleration", &unit_of_accel), "time", |s| &s.accel);
        Figure {
            title: self.title.clone(),
            notes: self.notes.clone(),
            rows: vec![(280.0, vec![position]), (300.0, vec![speed]), (270.0, vec![accel])],
        }
    }
}

#[cfg(test)]
mod tests;
