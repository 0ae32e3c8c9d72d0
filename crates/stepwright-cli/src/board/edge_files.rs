//! Writes every edge of a virtual board's pins to files: VCD, and MCAP, which also has the motions.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use stepwright::Rate;
use stepwright_keeper::mcap::McapWriter;
use stepwright_sim::vcd::VcdWriter;
use stepwright_sim::{Edge, Pin, Recorder};

use crate::failure::Failure;

/// Paths of the edge files to write.
#[derive(Clone, Copy, Default)]
pub struct EdgePaths<'a> {
    /// A Value Change Dump.
    pub vcd: Option<&'a Path>,
    /// An MCAP file.
    pub mcap: Option<&'a Path>,
    /// Whether a dump has the power of a laser.
    pub laser: bool,
}

/// A pin of an axis, and its level before the first edge, if it is known.
pub type StartLevel = (u8, Pin, Option<bool>);

type Out = BufWriter<File>;

/// The edge files that are being written.
#[derive(Default)]
pub struct EdgeFiles {
    vcd: Option<(PathBuf, VcdWriter<Out>)>,
    mcap: Option<(PathBuf, McapEdges<Out>)>,
}

fn create(path: &Path) -> Result<Out, Failure> {
    let file = File::create(path).map_err(|error| Failure::file("write", path, &error))?;
    Ok(BufWriter::new(file))
}

impl EdgeFiles {
    /// Creates the files for these pins of a board whose timer runs at `rate`.
    pub fn begin(paths: EdgePaths, rate: Rate, pins: &[StartLevel]) -> Result<EdgeFiles, Failure> {
        let mut files = EdgeFiles::default();
        if let Some(path) = paths.vcd {
            let begin = if paths.laser { VcdWriter::with_laser } else { VcdWriter::levels };
            let writer = begin(create(path)?, rate, pins);
            files.vcd = Some((path.to_owned(), writer));
        }
        if let Some(path) = paths.mcap {
            let writer = McapEdges::new(create(path)?, rate, pins);
            let writer = writer.map_err(|error| Failure::file("write", path, &error))?;
            files.mcap = Some((path.to_owned(), writer));
        }
        Ok(files)
    }

    /// Finishes the files at `time` ticks. Returns their paths.
    pub fn finish(&mut self, time: u64) -> Result<Vec<PathBuf>, Failure> {
        let mut written = Vec::new();
        if let Some((path, writer)) = self.vcd.take() {
            writer.finish(time).map_err(|error| Failure::file("write", &path, &error))?;
            written.push(path);
        }
        if let Some((path, writer)) = self.mcap.take() {
            writer.finish().map_err(|error| Failure::file("write", &path, &error))?;
            written.push(path);
        }
        Ok(written)
    }

    /// Records a change of the laser's power.
    pub fn laser(&mut self, time: u64, power: f64) {
        if let Some((_, writer)) = &mut self.vcd {
            writer.laser(time, power);
        }
        if let Some((_, writer)) = &mut self.mcap {
            writer.laser(time, power);
        }
    }

    /// Records a step of an axis. Its edges are recorded separately.
    pub fn step(&mut self, axis: u8, time: u64, forward: bool) {
        if let Some((_, writer)) = &mut self.mcap {
            writer.step(axis, time, forward);
        }
    }
}

impl Recorder for EdgeFiles {
    fn edge(&mut self, edge: Edge) {
        if let Some((_, writer)) = &mut self.vcd {
            writer.edge(edge);
        }
        if let Some((_, writer)) = &mut self.mcap {
            writer.edge(edge);
        }
    }
}

/// Writes edges as MCAP, in ns since the board was switched on, rounded down. After an error,
/// further edges are dropped; the error is reported at the end.
struct McapEdges<W: Write> {
    writer: McapWriter<W>,
    hz: u128,
    pins: Vec<(u8, Pin)>,
    error: Option<io::Error>,
}

impl<W: Write> McapEdges<W> {
    fn new(out: W, rate: Rate, pins: &[StartLevel]) -> io::Result<McapEdges<W>> {
        let names: Vec<String> = pins.iter().map(|(axis, pin, _)| pin.of(*axis)).collect();
        let words = "the edges of the virtual board's pins";
        let moves = |(_, pin, _): &&StartLevel| matches!(pin, Pin::Step | Pin::Coil(0));
        let axes = pins.iter().filter(moves).map(|(axis, ..)| axis + 1);
        let mut writer = McapWriter::new(out, names.iter().map(String::as_str), axes, words)?;
        for (place, (_, _, level)) in pins.iter().enumerate() {
            if let Some(level) = level {
                writer.level(place, 0, *level)?;
            }
        }
        let pins = pins.iter().map(|(axis, pin, _)| (*axis, *pin)).collect();
        Ok(McapEdges { writer, hz: rate.hz().into(), pins, error: None })
    }

    fn nanos(&self, time: u64) -> u64 {
        (u128::from(time) * 1_000_000_000 / self.hz) as u64
    }

    fn step(&mut self, axis: u8, time: u64, forward: bool) {
        if self.error.is_none() {
            self.error = self.writer.step(axis + 1, self.nanos(time), forward).err();
        }
    }

    fn laser(&mut self, time: u64, power: f64) {
        if self.error.is_none() {
            self.error = self.writer.laser(self.nanos(time), power).err();
        }
    }

    fn finish(self) -> io::Result<W> {
        self.error.map_or_else(|| self.writer.finish(), Err)
    }
}

impl<W: Write> Recorder for McapEdges<W> {
    fn edge(&mut self, edge: Edge) {
        let pin = self.pins.iter().position(|pin| *pin == (edge.axis, edge.pin));
        if let (Some(pin), None) = (pin, &self.error) {
            self.error = self.writer.level(pin, self.nanos(edge.time), edge.level).err();
        }
    }
}
