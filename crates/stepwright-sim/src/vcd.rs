//! Edges as a Value Change Dump, for GTKWave and PulseView.
//!
//! Times are in picoseconds, which hold every timer up to 200 MHz to a
//! thousandth of a tick or so.

use std::io::{self, Write};

use stepwright::Rate;

use crate::AXES;
use crate::edge::{Edge, Pin, Recorder};

/// Writes edges as they come.
///
/// An error of the writer is kept until [`finish`](VcdWriter::finish); what
/// comes after it is dropped.
#[derive(Debug)]
pub struct VcdWriter<W> {
    out: W,
    hz: u64,
    time: Option<u64>,
    error: Option<io::Error>,
}

/// Picoseconds in a second.
const PICO: u128 = 1_000_000_000_000;

const NAMES: [[char; 2]; AXES] = [['a', 'b'], ['c', 'd'], ['e', 'f']];

impl<W: Write> VcdWriter<W> {
    /// Begins a dump of the pins of `axes` axes of a board whose timer runs at
    /// `rate`; all pins are unknown until their first edge, STEP low.
    pub fn new(out: W, rate: Rate, axes: u8) -> VcdWriter<W> {
        let mut vcd = VcdWriter { out, hz: rate.hz().into(), time: None, error: None };
        vcd.error = vcd.header(axes).err();
        vcd
    }

    fn header(&mut self, axes: u8) -> io::Result<()> {
        let out = &mut self.out;
        writeln!(out, "$version stepwright {} $end", env!("CARGO_PKG_VERSION"))?;
        writeln!(out, "$timescale 1 ps $end")?;
        writeln!(out, "$scope module board $end")?;
        for (axis, [step, direction]) in NAMES.iter().enumerate().take(axes.into()) {
            writeln!(out, "$var wire 1 {step} step{} $end", axis + 1)?;
            writeln!(out, "$var wire 1 {direction} dir{} $end", axis + 1)?;
        }
        writeln!(out, "$upscope $end\n$enddefinitions $end\n$dumpvars")?;
        for [step, direction] in NAMES.iter().take(axes.into()) {
            writeln!(out, "0{step}\nx{direction}")?;
        }
        writeln!(out, "$end")
    }

    fn line(&mut self, edge: Edge) -> io::Result<()> {
        if self.time != Some(edge.time) {
            self.time = Some(edge.time);
            let ps = u128::from(edge.time) * PICO / u128::from(self.hz);
            writeln!(self.out, "#{ps}")?;
        }
        let Some([step, direction]) = NAMES.get(usize::from(edge.axis)) else { return Ok(()) };
        let name = if edge.pin == Pin::Step { step } else { direction };
        writeln!(self.out, "{}{name}", u8::from(edge.level))
    }

    /// Ends the dump at `time` ticks.
    ///
    /// # Errors
    /// The first error of the writer.
    pub fn finish(mut self, time: u64) -> io::Result<W> {
        if let Some(error) = self.error {
            return Err(error);
        }
        let ps = u128::from(time) * PICO / u128::from(self.hz);
        writeln!(self.out, "#{ps}")?;
        self.out.flush()?;
        Ok(self.out)
    }
}

impl<W: Write> Recorder for VcdWriter<W> {
    fn edge(&mut self, edge: Edge) {
        if self.error.is_none() {
            self.error = self.line(edge).err();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dump_reads_back() {
        let rate = Rate::from_hz(16_000_000).unwrap();
        let mut vcd = VcdWriter::new(Vec::new(), rate, 2);
        vcd.edge(Edge { time: 0, axis: 0, pin: Pin::Direction, level: true });
        vcd.edge(Edge { time: 1, axis: 1, pin: Pin::Step, level: true });
        vcd.edge(Edge { time: 1, axis: 0, pin: Pin::Step, level: true });
        vcd.edge(Edge { time: 17, axis: 0, pin: Pin::Step, level: false });
        let text = String::from_utf8(vcd.finish(32).unwrap()).unwrap();
        let body = text.split("$end\n").last().unwrap();
        assert_eq!(body, "#0\n1b\n#62500\n1c\n1a\n#1062500\n0a\n#2000000\n");
        assert!(text.contains("$var wire 1 c step2 $end"));
    }
}
