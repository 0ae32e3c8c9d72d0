//! The levels of a chip's pins as a Value Change Dump, for GTKWave and PulseView.

use std::io::{self, Write};

use stepwright_sim::vcd::unit;

use crate::board::HZ;

/// Writes changes as they come, in the order of their times.
pub struct PinDump<W> {
    out: W,
    /// The units of time in a second.
    units: u128,
    time: Option<u64>,
}

/// The character that represents a pin; a Mega has 68 pins.
fn letter(which: u8) -> char {
    char::from(b'!' + which)
}

impl<W: Write> PinDump<W> {
    /// Begins a dump of pins with these names, all low; 94 at most.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn begin(mut out: W, names: &[String]) -> io::Result<PinDump<W>> {
        let (units, unit) = unit(HZ);
        writeln!(out, "$version stepwright {} $end", env!("CARGO_PKG_VERSION"))?;
        writeln!(out, "$timescale {unit} $end\n$scope module chip $end")?;
        for (which, name) in (0..).zip(names) {
            writeln!(out, "$var wire 1 {} {name} $end", letter(which))?;
        }
        writeln!(out, "$upscope $end\n$enddefinitions $end\n$dumpvars")?;
        for which in 0..names.len() as u8 {
            writeln!(out, "0{}", letter(which))?;
        }
        writeln!(out, "$end")?;
        Ok(PinDump { out, units, time: None })
    }

    /// Writes changes of pins: cycle, index, level.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn changes(&mut self, changes: &[(u64, u8, bool)]) -> io::Result<()> {
        for &(time, which, level) in changes {
            self.at(time)?;
            writeln!(self.out, "{}{}", u8::from(level), letter(which))?;
        }
        Ok(())
    }

    fn at(&mut self, time: u64) -> io::Result<()> {
        if self.time.replace(time) == Some(time) {
            return Ok(());
        }
        writeln!(self.out, "#{}", u128::from(time) * self.units / u128::from(HZ))
    }

    /// Ends the dump at this cycle.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn finish(mut self, time: u64) -> io::Result<W> {
        self.at(time)?;
        self.out.flush()?;
        Ok(self.out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cycle_is_625_units_of_100_ps() {
        let names = ["D2".to_owned(), "A0".to_owned()];
        let mut dump = PinDump::begin(Vec::new(), &names).unwrap();
        dump.changes(&[(1, 0, true), (1, 1, true), (33, 0, false)]).unwrap();
        let text = String::from_utf8(dump.finish(64).unwrap()).unwrap();
        assert!(text.contains("$timescale 100 ps $end"), "{text}");
        assert!(text.contains("$var wire 1 \" A0 $end"), "{text}");
        assert!(text.ends_with("$end\n#625\n1!\n1\"\n#20625\n0!\n#40000\n"), "{text}");
    }
}
