//! The recordings of a virtual board: its edges as files, and the motion of its motors as a plot.

use std::io;

use stepwright_host::link::bench::BenchRecorder;
use stepwright_sim::{AXES, Description, Edge, Pin, Recorder, Shaft};

use super::edge_files::{EdgeFiles, EdgePaths};
use crate::failure::Failure;
use crate::plot;
use crate::quantity::MachineUnit;
use crate::say;
use stepwright_plot::{MotionPlot, PlotFile, Traces};

/// The heading of a plot.
#[derive(Clone, Debug, Default)]
pub struct Heading {
    /// The title.
    pub title: String,
    /// Smaller lines below it.
    pub notes: Vec<String>,
    /// The unit of the scales; steps by default.
    pub unit: Option<MachineUnit>,
    /// Whether the jerk is plotted too.
    pub jerk: bool,
}

/// Writes the requested recordings, and follows the shafts.
#[derive(Default)]
pub struct Recording {
    shafts: [Shaft; AXES],
    files: EdgeFiles,
    plot: Option<(PlotFile, Heading, Traces)>,
}

impl Recording {
    /// Begins the requested recordings, the plot under this heading. A file that can't be written
    /// is reported here, before anything moves.
    pub fn begin(
        description: &Description,
        paths: EdgePaths,
        plot: Option<(&PlotFile, Heading)>,
    ) -> Result<Recording, Failure> {
        let rate = description.board.rate;
        let files = EdgeFiles::begin(paths, rate, &description.pins().collect::<Vec<_>>())?;
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
        Ok(Recording { files, plot, shafts })
    }

    /// Finishes the files at `time` ticks.
    fn write(&mut self, time: u64) -> Result<(), Failure> {
        self.files.finish(time)?;
        if let Some((file, heading, traces)) = self.plot.take() {
            let series = traces.series(traces.first());
            if series.is_empty() {
                say::note("nothing has moved: there is nothing to plot");
            } else {
                let Heading { title, notes, unit, jerk } = heading;
                // A minus sign before a number, instead of a hyphen.
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
    }

    fn laser(&mut self, time: u64, power: u8) {
        self.files.laser(time, f64::from(power) / 255.0);
    }
}

impl BenchRecorder for Recording {
    fn finish(&mut self, now: u64) -> io::Result<()> {
        self.write(now).map_err(io::Error::other)
    }
}
