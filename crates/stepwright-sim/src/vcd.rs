//! Edges as a Value Change Dump (VCD), for GTKWave and PulseView.
//!
//! The unit of time is the longest of 1 s, 100 ms … 1 ps that holds a tick exactly: 100 ps for a timer at 16
//! MHz. If none does, times are rounded down to 1 ps, about a thousandth of a tick or less up to 200 MHz.

use std::fmt;
use std::io::{self, Write};

use stepwright::Rate;

use crate::edge::{Edge, Pin, Recorder};

/// Writes edges as they come.
///
/// An error of the writer is kept until [`finish`](VcdWriter::finish), and later edges are dropped.
#[derive(Debug)]
pub struct VcdWriter<W> {
    out: W,
    hz: u64,
    /// Units of time per second.
    units: u128,
    time: Option<u64>,
    error: Option<io::Error>,
}

/// Picoseconds in a second.
const PICO: u128 = 1_000_000_000_000;

/// The longest unit of a dump that holds a tick of `hz` exactly, or else a picosecond: the units per second,
/// and its name, `100 ps` at 16 MHz.
pub fn unit(hz: u64) -> (u128, String) {
    let names = ["s", "ms", "us", "ns", "ps"];
    let mut units = 1;
    while units < PICO && !u128::is_multiple_of(units, hz.into()) {
        units *= 10;
    }
    let power = units.ilog10();
    let name = names.get(power.div_ceil(3) as usize).copied().unwrap_or("ps");
    (units, format!("{} {name}", 10u32.pow((3 - power % 3) % 3)))
}

/// The identifier of a pin in the dump: a letter, from a on for STEP and DIR, from A on for the others; three
/// characters for coils.
struct Sign(u8, Pin);

impl fmt::Display for Sign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Sign(axis, pin) = *self;
        let letter = match pin {
            Pin::Step => b'a' + 2 * axis,
            Pin::Direction => b'b' + 2 * axis,
            Pin::Coil(line) => return write!(f, "w{axis}{line}"),
            Pin::Enable => b'A' + 3 * axis,
            Pin::Min => b'B' + 3 * axis,
            Pin::Max => b'C' + 3 * axis,
        };
        write!(f, "{}", char::from(letter))
    }
}

/// The identifier of the laser's power.
const LASER: char = '!';

/// The most axes of a dump.
const MOST: u8 = 8;

/// The pins of a board without switches.
const MOTION: &[Pin] = &[Pin::Step, Pin::Direction];

impl<W: Write> VcdWriter<W> {
    /// Begins a dump of the pins of `axes` axes, of a board whose timer runs at `rate`. Pins are unknown until
    /// their first edge, except STEP, which is low.
    pub fn new(out: W, rate: Rate, axes: u8) -> VcdWriter<W> {
        VcdWriter::of(out, rate, axes, MOTION)
    }

    /// The same with these pins of each axis, for at most 8 axes.
    pub fn of(out: W, rate: Rate, axes: u8, pins: &[Pin]) -> VcdWriter<W> {
        let level = |pin| (!matches!(pin, Pin::Direction | Pin::Enable)).then_some(false);
        let of = |axis| pins.iter().map(move |pin| (axis, *pin, level(*pin)));
        let pins: Vec<_> = (0..axes.min(MOST)).flat_map(of).collect();
        VcdWriter::levels(out, rate, &pins)
    }

    /// The same with single pins: the axis, the pin, and the level before the first edge, if it is known, as of
    /// a [board](crate::Description::pins).
    pub fn levels(out: W, rate: Rate, pins: &[(u8, Pin, Option<bool>)]) -> VcdWriter<W> {
        VcdWriter::begun(out, rate, pins, false)
    }

    /// The same with the power of a [laser](VcdWriter::laser) as a real number, 0 at first.
    pub fn with_laser(out: W, rate: Rate, pins: &[(u8, Pin, Option<bool>)]) -> VcdWriter<W> {
        VcdWriter::begun(out, rate, pins, true)
    }

    fn begun(out: W, rate: Rate, pins: &[(u8, Pin, Option<bool>)], laser: bool) -> VcdWriter<W> {
        let hz = rate.hz().into();
        let (units, name) = unit(hz);
        let mut vcd = VcdWriter { out, hz, units, time: None, error: None };
        vcd.error = vcd.header(&name, pins, laser).err();
        vcd
    }

    fn header(
        &mut self,
        unit: &str,
        pins: &[(u8, Pin, Option<bool>)],
        laser: bool,
    ) -> io::Result<()> {
        let out = &mut self.out;
        writeln!(out, "$version stepwright {} $end", env!("CARGO_PKG_VERSION"))?;
        writeln!(out, "$timescale {unit} $end")?;
        writeln!(out, "$scope module board $end")?;
        for &(axis, pin, _) in pins {
            writeln!(out, "$var wire 1 {} {} $end", Sign(axis, pin), pin.of(axis))?;
        }
        if laser {
            writeln!(out, "$var real 64 {LASER} laser $end")?;
        }
        writeln!(out, "$upscope $end\n$enddefinitions $end\n$dumpvars")?;
        for &(axis, pin, level) in pins {
            let level = level.map_or('x', |high| if high { '1' } else { '0' });
            writeln!(out, "{level}{}", Sign(axis, pin))?;
        }
        if laser {
            writeln!(out, "r0 {LASER}")?;
        }
        writeln!(out, "$end")
    }

    /// Sets the laser's power, 0 to 1, from `time` ticks on. All earlier edges must have been written, and no
    /// later ones.
    pub fn laser(&mut self, time: u64, power: f64) {
        if self.error.is_none() {
            let written = self.at(time).and_then(|()| writeln!(self.out, "r{power} {LASER}"));
            self.error = written.err();
        }
    }

    fn units_at(&self, time: u64) -> u128 {
        u128::from(time) * self.units / u128::from(self.hz)
    }

    fn at(&mut self, time: u64) -> io::Result<()> {
        if self.time == Some(time) {
            return Ok(());
        }
        self.time = Some(time);
        let time = self.units_at(time);
        writeln!(self.out, "#{time}")
    }

    fn line(&mut self, edge: Edge) -> io::Result<()> {
        self.at(edge.time)?;
        if edge.axis >= MOST {
            return Ok(());
        }
        writeln!(self.out, "{}{}", u8::from(edge.level), Sign(edge.axis, edge.pin))
    }

    /// Ends the dump at `time` ticks.
    ///
    /// # Errors
    /// The first error of the writer.
    pub fn finish(mut self, time: u64) -> io::Result<W> {
        if let Some(error) = self.error {
            return Err(error);
        }
        let time = self.units_at(time);
        writeln!(self.out, "#{time}")?;
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
        assert_eq!(body, "#0\n1b\n#625\n1c\n1a\n#10625\n0a\n#20000\n");
        assert!(text.contains("$var wire 1 c step2 $end"));
        assert!(text.contains("$timescale 100 ps $end"));
    }

    #[test]
    fn a_laser_is_a_real_number() {
        let pins = [(0, Pin::Step, Some(false))];
        let mut vcd = VcdWriter::with_laser(Vec::new(), Rate::MHZ, &pins);
        vcd.laser(2, 0.25);
        vcd.edge(Edge { time: 2, axis: 0, pin: Pin::Step, level: true });
        vcd.laser(5, 0.0);
        let text = String::from_utf8(vcd.finish(9).unwrap()).unwrap();
        assert!(text.contains("$var real 64 ! laser $end"), "{text}");
        assert!(
            text.contains("$dumpvars\n0a\nr0 !\n$end\n#2\nr0.25 !\n1a\n#5\nr0 !\n#9\n"),
            "{text}"
        );
    }

    /// 62.5 ns are 625 · 100 ps; a third of a microsecond has no exact unit.
    #[test]
    fn the_unit_is_the_longest_that_holds_a_tick() {
        for (hz, units, name) in [
            (16_000_000, 10_000_000_000, "100 ps"),
            (1_000_000, 1_000_000, "1 us"),
            (100_000, 100_000, "10 us"),
            (200_000_000, 1_000_000_000, "1 ns"),
            (20_000_000, 100_000_000, "10 ns"),
            (3_000_000, PICO, "1 ps"),
        ] {
            assert_eq!(unit(hz), (units, name.to_owned()), "{hz}");
        }
    }
}
