//! What a virtual board leaves behind: its edges as files, and what its motors did as a picture.

use stepwright::Rate;
use stepwright_sim::{AXES, Description, Edge, Pin, Recorder, Shaft};

use super::edge_files::{EdgeFiles, EdgePaths, StartLevel};
use super::edges::EdgeStore;
use crate::failure::Failure;
use crate::plot;
use crate::quantity::MachineUnit;
use crate::say;
use stepwright_plot::{MotionPlot, PlotFile, Traces};

/// What stands above a plot.
#[derive(Clone, Debug, Default)]
pub struct Heading {
    /// What it shows.
    pub title: String,
    /// Smaller lines below it.
    pub notes: Vec<String>,
    /// The unit of its scales, where it is not steps.
    pub unit: Option<MachineUnit>,
    /// It shows the jerk, too.
    pub jerk: bool,
}

/// Takes down what was asked for, and where the shafts are.
#[derive(Default)]
pub struct Recording {
    shafts: [Shaft; AXES],
    files: EdgeFiles,
    plot: Option<(PlotFile, Heading, Traces)>,
    edges: Option<EdgeStore>,
}

impl Recording {
    /// Begins the recordings that are wanted, the plot under this heading. What
    /// can't be written is known before anything moves.
    pub fn begin(
        description: &Description,
        paths: EdgePaths,
        plot: Option<(&PlotFile, Heading)>,
    ) -> Result<Recording, Failure> {
        Recording::begin_with(description, paths, plot, EdgeFiles::begin)
    }

    /// Likewise, of a board with a laser.
    pub fn with_laser(
        description: &Description,
        paths: EdgePaths,
        plot: Option<(&PlotFile, Heading)>,
    ) -> Result<Recording, Failure> {
        Recording::begin_with(description, paths, plot, EdgeFiles::with_laser)
    }

    fn begin_with(
        description: &Description,
        paths: EdgePaths,
        plot: Option<(&PlotFile, Heading)>,
        begin: impl FnOnce(EdgePaths, Rate, &[StartLevel]) -> Result<EdgeFiles, Failure>,
    ) -> Result<Recording, Failure> {
        let rate = description.board.rate;
        let files = begin(paths, rate, &description.pins().collect::<Vec<_>>())?;
        let plot = match plot {
            Some((file, heading)) => {
                file.check()?;
                Some((file.clone(), heading, Traces::new(rate.hz())))
            }
            None => None,
        };
        let mut shafts = [Shaft::default(); AXES];
        for (axis, shaft) in (0..).zip(&mut shafts) {
            *shaft = Shaft::of(description, axis);
        }
        Ok(Recording { files, plot, edges: None, shafts })
    }

    /// Keeps the last edges here, too.
    pub fn keep(self, edges: EdgeStore) -> Recording {
        Recording { edges: Some(edges), ..self }
    }

    /// Where the last edges are kept.
    pub fn kept(&self) -> Option<&EdgeStore> {
        self.edges.as_ref()
    }

    /// Where the shaft of an axis is by its edges alone, whatever the board believes.
    pub fn shaft(&self, axis: u8) -> i64 {
        self.shafts.get(usize::from(axis)).map_or(0, Shaft::position)
    }

    /// Finishes the files at `time` ticks.
    pub fn finish(&mut self, time: u64) -> Result<(), Failure> {
        self.files.finish(time)?;
        if let Some((file, heading, traces)) = self.plot.take() {
            let series = traces.series(traces.first());
            if series.is_empty() {
                say::note("nothing has moved: there is nothing to plot");
            } else {
                let Heading { title, notes, unit, jerk } = heading;
                // The minus of a number, not the hyphen of a word.
                let title = title.replace(" -", " −");
                let plot = MotionPlot { title, notes, series, unit, jerk, stacked: false };
                plot::save(&file, &plot.figure())?;
            }
        }
        Ok(())
    }
}

impl Recorder for Recording {
    fn edge(&mut self, edge: Edge) {
        let shaft = self.shafts.get_mut(usize::from(edge.axis));
        let stepped = shaft.and_then(|shaft| shaft.follow(edge));
        self.files.edge(edge);
        if let Some(forward) = stepped {
            self.files.step(edge.axis, edge.time, forward);
        }
        if let Some((_, _, traces)) = &mut self.plot {
            match (edge.pin, stepped) {
                (Pin::Coil(_), Some(forward)) => traces.step(edge.axis, edge.time, forward),
                (Pin::Direction, _) => traces.direction(edge.axis, edge.level),
                (Pin::Step, _) if edge.level => traces.pulse(edge.axis, edge.time),
                _ => {}
            }
        }
        self.edges.edge(edge);
    }

    fn laser(&mut self, time: u64, power: u8) {
        self.files.laser(time, f64::from(power) / 255.0);
    }
}
