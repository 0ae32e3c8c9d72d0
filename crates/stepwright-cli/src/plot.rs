//! Plots: speed and acceleration as .svg, .png or .html.
//!
//! A [`Figure`] is arranged once into a [`picture`] of simple shapes, which
//! every format then writes; so all three look the same, and none of them
//! needs a library or a font of the system.
//!
//! | module | what |
//! | --- | --- |
//! | [`figure`] | panels, axes, curves, shaded stretches |
//! | [`clip`] | the part of a line that is in view |
//! | [`scale`] | from values to pixels, round numbers |
//! | [`picture`] | the shapes |
//! | `svg`, `png`, `html` | the formats |

mod clip;
mod figure;
mod html;
mod picture;
mod png;
mod scale;
mod svg;

use std::fs;
use std::path::PathBuf;
use std::str::FromStr;

use crate::failure::Failure;
use crate::say;

pub use figure::{Band, Curve, Figure, PALETTE, Panel, View};
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

/// Speed over time of one or more axes.
#[derive(Clone, Debug)]
pub struct SpeedPlot {
    /// The heading.
    pub title: String,
    /// Smaller lines below it.
    pub notes: Vec<String>,
    /// The axes.
    pub series: Vec<Series>,
}

/// The speed of one axis.
#[derive(Clone, Debug)]
pub struct Series {
    /// `axis 1`
    pub name: String,
    /// Seconds and steps/s, in the order of time; a speed backwards is
    /// negative.
    pub points: Vec<(f64, f64)>,
}

impl SpeedPlot {
    /// Draws into the file.
    pub fn save(&self, file: &PlotFile) -> Result<(), Failure> {
        file.save(&self.figure())
    }

    fn figure(&self) -> Figure {
        let last = |series: &Series| series.points.last().map_or(0.0, |(t, _)| *t);
        let (unit, per_second) = time_unit(self.series.iter().map(last).fold(0.0, f64::max));
        let curves = self.series.iter().zip(PALETTE.iter().cycle()).map(|(series, colour)| Curve {
            name: series.name.clone(),
            colour: *colour,
            points: series.points.iter().map(|(t, v)| (t * per_second, *v)).collect(),
            filled: self.series.len() == 1,
            ..Curve::default()
        });
        let panel = Panel {
            y: ("Speed".into(), "steps/s".into()),
            x: ("time".into(), unit.into()),
            curves: curves.collect(),
            ..Panel::default()
        };
        Figure {
            title: self.title.clone(),
            notes: self.notes.clone(),
            rows: vec![(460.0, vec![panel])],
        }
    }
}

#[cfg(test)]
mod tests;
