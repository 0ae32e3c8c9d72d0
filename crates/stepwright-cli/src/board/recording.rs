//! What a virtual board leaves behind: its edges as a Value Change Dump, and
//! what its motors did as a picture.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use stepwright_sim::vcd::VcdWriter;
use stepwright_sim::{AXES, Description, Edge, Pin, Recorder};

use super::edges::EdgeStore;
use super::traces::Traces;
use crate::failure::Failure;
use crate::plot::{MotionPlot, PlotFile};
use crate::say;

/// What a motor's shaft has done.
#[derive(Clone, Copy, Default)]
struct Shaft {
    position: i64,
    forward: bool,
}

/// What stands above a plot.
#[derive(Clone, Debug)]
pub struct Heading {
    /// What it shows.
    pub title: String,
    /// Smaller lines below it.
    pub notes: Vec<String>,
}

/// Takes down what was asked for, and where the shafts are.
#[derive(Default)]
pub struct Recording {
    shafts: [Shaft; AXES],
    vcd: Option<(PathBuf, VcdWriter<BufWriter<File>>)>,
    plot: Option<(PlotFile, Heading, Traces)>,
    edges: Option<EdgeStore>,
}

impl Recording {
    /// Begins the recordings that are wanted, the plot under this heading. What
    /// can't be written is known before anything moves.
    pub fn begin(
        description: &Description,
        vcd: Option<&Path>,
        plot: Option<(&PlotFile, Heading)>,
    ) -> Result<Recording, Failure> {
        let vcd = match vcd {
            Some(path) => {
                let file = File::create(path).map_err(|e| Failure::file("write", path, &e))?;
                let out = BufWriter::new(file);
                let writer = VcdWriter::new(out, description.board.rate, description.axes);
                Some((path.to_owned(), writer))
            }
            None => None,
        };
        let plot = match plot {
            Some((file, heading)) => {
                file.check()?;
                Some((file.clone(), heading, Traces::new(description.board.rate)))
            }
            None => None,
        };
        Ok(Recording { vcd, plot, edges: None, shafts: Default::default() })
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
        self.shafts.get(usize::from(axis)).map_or(0, |shaft| shaft.position)
    }

    /// Finishes the files at `time` ticks.
    pub fn finish(&mut self, time: u64) -> Result<(), Failure> {
        if let Some((path, writer)) = self.vcd.take() {
            writer.finish(time).map_err(|error| Failure::file("write", &path, &error))?;
        }
        if let Some((file, heading, traces)) = self.plot.take() {
            let series = traces.series(traces.first());
            if series.is_empty() {
                say::note("nothing has moved: there is nothing to plot");
            } else {
                let Heading { title, notes } = heading;
                // The minus of a number, not the hyphen of a word.
                let title = title.replace(" -", " −");
                MotionPlot { title, notes, series }.save(&file)?;
            }
        }
        Ok(())
    }
}

impl Recorder for Recording {
    fn edge(&mut self, edge: Edge) {
        if let Some(shaft) = self.shafts.get_mut(usize::from(edge.axis)) {
            match edge.pin {
                Pin::Direction => shaft.forward = edge.level,
                Pin::Step if edge.level => shaft.position += if shaft.forward { 1 } else { -1 },
                _ => {}
            }
        }
        if let Some((_, writer)) = &mut self.vcd {
            writer.edge(edge);
        }
        if let Some((_, _, traces)) = &mut self.plot {
            traces.edge(edge);
        }
        self.edges.edge(edge);
    }
}
