//! Pins from the addresses of stores, and times from the plugin.
//!
//! ```text
//!   @1234567 0x80200004         word 1 of those that raise, at this instruction: STEP of axis 1 rises
//! ```
//!
//! The step timer of such a board is QEMU's clock itself, which is the number of instructions.

use anyhow::{Result, ensure};

use super::{Edge, Port, Reader, store};

/// A log in progress.
pub(super) struct Log {
    /// The ticks of an instruction.
    ticks: f64,
    /// The words that raise, and those that lower.
    words: [u32; 2],
    port: Port,
    edges: Vec<Edge>,
}

impl Log {
    pub(super) fn new(ticks: f64, words: [u32; 2], port: Port) -> Log {
        Log { ticks, words, port, edges: Vec::new() }
    }
}

impl Reader for Log {
    fn line(&mut self, line: &str) -> Result<()> {
        let Some(text) = line.strip_prefix('@') else { return Ok(()) };
        let (count, address) = store(text)?;
        let [set, clear] = self.words;
        let high = address < clear;
        let first = if high { set } else { clear };
        ensure!(address >= first && address % 4 == 0, "no word of the port: {line}");
        let time = count as f64 * self.ticks;
        self.edges.extend(self.port.change((address - first) / 4, high, time));
        Ok(())
    }

    fn edges(&mut self) -> Vec<Edge> {
        std::mem::take(&mut self.edges)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_the_levels() {
        let mut log = Log::new(0.16, [0x8020_0000, 0x8020_0200], Port::of(0, 3));
        for line in
            ["@25 0x80200080", "@100 0x8020000c", "@200 0x80200204", "traced", "@300 0x80200204"]
        {
            log.line(line).unwrap();
        }
        let edge = |time, axis, is_pulse, level| Edge { time, axis, is_pulse, level };
        // DIR of axis 3; STEP of two axes; the first of them falls, once.
        let edges = [
            edge(4.0, 2, false, true),
            edge(16.0, 0, true, true),
            edge(16.0, 1, true, true),
            edge(32.0, 0, true, false),
        ];
        assert_eq!(log.edges(), edges);
        assert!(log.line("@1 0x80200002").is_err() && log.line("@1 0x801ffffc").is_err());
    }
}
