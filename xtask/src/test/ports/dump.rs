//! Parses a Value Change Dump: the changes of each wire.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};

/// The picoseconds of a cycle at 16 MHz.
const CYCLE: f64 = 62_500.0;

/// A change of a wire: its time in cycles, and the level from then on.
pub type Change = (f64, bool);

/// The wires of a dump by their names.
#[derive(Default)]
pub struct Dump {
    wires: HashMap<String, Vec<Change>>,
}

impl Dump {
    /// Reads the dump of a simulated chip or of the command.
    pub fn read(path: &Path) -> Result<Dump> {
        let text = fs::read_to_string(path).with_context(|| format!("no {}", path.display()))?;
        parse(&text).with_context(|| format!("reading {}", path.display()))
    }

    /// The changes of a wire.
    pub fn wire(&self, name: &str) -> Result<&[Change]> {
        let found = self.wires.get(name).with_context(|| format!("no wire {name} in the dump"))?;
        Ok(found)
    }
}

fn parse(text: &str) -> Result<Dump> {
    let (mut dump, mut names) = (Dump::default(), HashMap::new());
    let (mut unit, mut time, mut initial) = (0.0, 0.0, false);
    for line in text.lines() {
        let words: Vec<_> = line.split(' ').collect();
        match words[..] {
            ["$timescale", number, name, "$end"] => unit = unit_of(number, name)?,
            ["$var", "wire", "1", letter, name, "$end"] => {
                names.insert(letter, name);
                dump.wires.insert(name.to_owned(), Vec::new());
            }
            ["$dumpvars"] => initial = true,
            ["$end"] => initial = false,
            [word] if word.starts_with('#') => {
                let count: u64 = word[1..].parse().with_context(|| format!("a time: {line}"))?;
                time = count as f64 * unit / CYCLE;
            }
            [word] if word.starts_with(['0', '1']) => {
                let name = names.get(&word[1..]).with_context(|| format!("a wire: {line}"))?;
                let changes = dump.wires.get_mut(*name).context("a wire without a name")?;
                let level = word.starts_with('1');
                // A wire is low at first unless the dump gives its level; it may be unknown.
                if !initial && changes.last().map_or(level, |last| last.1 != level) {
                    changes.push((time, level));
                }
            }
            [word] if initial && word.starts_with('x') => {}
            [word, ..] if word.starts_with('$') => {}
            _ => bail!("a line that is no dump's: {line}"),
        }
    }
    ensure!(unit > 0.0, "no time scale");
    Ok(dump)
}

/// The picoseconds of a unit: `100 ps`.
fn unit_of(number: &str, name: &str) -> Result<f64> {
    let power = ["ps", "ns", "us", "ms", "s"].iter().position(|known| *known == name);
    let power = power.with_context(|| format!("a time scale in {name}"))?;
    Ok(number.parse::<f64>()? * 1000f64.powi(power as i32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dump_is_read_in_cycles() {
        let head = "$version x 1 $end\n$timescale 100 ps $end\n$scope module chip $end\n";
        let vars = "$var wire 1 ! D2 $end\n$var wire 1 \" D5 $end\n$upscope $end\n";
        let body = "$enddefinitions $end\n$dumpvars\n0!\nx\"\n$end\n#625\n1!\n#1250\n0!\n1\"\n#9\n";
        let dump = parse(&format!("{head}{vars}{body}")).unwrap();
        assert_eq!(dump.wire("D2").unwrap(), [(1.0, true), (2.0, false)]);
        assert_eq!(dump.wire("D5").unwrap(), [(2.0, true)]);
        assert!(dump.wire("D3").is_err());
        assert!(parse("#5\n").is_err() && parse("$timescale 1 us $end\n1?\n").is_err());
    }
}
