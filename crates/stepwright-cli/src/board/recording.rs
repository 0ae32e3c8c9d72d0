//! What a virtual board leaves behind: its edges as a Value Change Dump, and
//! the speed of its motors as a picture.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use stepwright_sim::vcd::VcdWriter;
use stepwright_sim::{Description, Edge, Recorder};

use crate::failure::Failure;

/// Takes down what was asked for.
#[derive(Default)]
pub struct Recording {
    vcd: Option<(PathBuf, VcdWriter<BufWriter<File>>)>,
}

impl Recording {
    /// Opens the files, so that what can't be written is known before anything
    /// moves.
    pub fn begin(
        description: &Description,
        vcd: Option<&Path>,
        _plot: Option<&Path>,
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
        Ok(Recording { vcd })
    }

    /// Finishes the files at `time` ticks.
    pub fn finish(&mut self, time: u64) -> Result<(), Failure> {
        if let Some((path, writer)) = self.vcd.take() {
            writer.finish(time).map_err(|error| Failure::file("write", &path, &error))?;
        }
        Ok(())
    }
}

impl Recorder for Recording {
    fn edge(&mut self, edge: Edge) {
        if let Some((_, writer)) = &mut self.vcd {
            writer.edge(edge);
        }
    }
}
