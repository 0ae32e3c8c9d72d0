//! Pins from QEMU's trace of the devices, and times from the plugin.
//!
//! ```text
//!   nrf51_gpio_write offset 0x508 value 0x200000      QEMU's trace: STEP rises
//!   @1234567 0x50000508                               the plugin: at this instruction
//!   @1234571 0x4000804c                               the engine captures the counter
//!   nrf51_timer_read … addr 0x54c data 0xe3d458 …     and reads it
//! ```
//!
//! QEMU's timer counts a little faster than its instructions take, by some 30 in a million: it
//! drops half a nanosecond when an odd tick is read. So the time of an edge is the counter's next
//! value that the engine reads, less the instructions between.

use anyhow::{Context, Result, ensure};

use super::{Edge, Port, Reader, hex, store};

/// Offsets of the registers that set and clear.
const SET: u32 = 0x508;
const CLEAR: u32 = 0x50C;
/// The engine's capture of the counter.
const CAPTURE: u32 = 0x4000_804C;

/// The addresses that the plugin watches.
pub(super) fn watched() -> String {
    "watch=0x50000508-0x50000510+0x4000804c-0x40008050".to_owned()
}

/// The events that QEMU traces.
pub(super) const TRACES: [&str; 6] =
    ["-trace", "nrf51_gpio_write", "-trace", "nrf51_timer_read", "-d", "plugin"];

/// A log in progress.
pub(super) struct Log {
    /// The ticks of an instruction.
    ticks: f64,
    port: Port,
    edges: Vec<Edge>,
    /// The write to the port whose time is not known yet.
    write: Option<(bool, u32)>,
    /// From this edge on, the time is still an instruction.
    untimed: usize,
    /// The instruction at which the counter was captured.
    captured: Option<u64>,
    /// The time at the last read of the counter.
    time: u64,
}

impl Log {
    pub(super) fn new(ticks: f64, port: Port) -> Log {
        let (edges, write, captured) = (Vec::new(), None, None);
        Log { ticks, port, edges, write, untimed: 0, captured, time: 0 }
    }
}

impl Reader for Log {
    fn line(&mut self, line: &str) -> Result<()> {
        if let Some(text) = line.strip_prefix("nrf51_gpio_write offset ") {
            let (offset, value) = text.split_once(" value ").context("a value")?;
            let offset = hex(offset)?;
            if offset == SET || offset == CLEAR {
                ensure!(self.write.is_none(), "a write without a time: {line}");
                self.write = Some((offset == SET, hex(value.trim())?));
            }
        } else if let Some(text) = line.strip_prefix('@') {
            let (count, address) = store(text)?;
            if address == CAPTURE {
                self.captured = Some(count);
            } else {
                let (set, value) =
                    self.write.take().with_context(|| format!("no write before {line}"))?;
                ensure!((address & 0xFFF == SET) == set, "another write: {line}");
                self.edges.extend(self.port.change(value, set, count as f64));
            }
        } else if let Some((_, text)) = line.split_once(" addr 0x54c data ")
            && let Some(captured) = self.captured.take()
        {
            let counter = hex(text.split(' ').next().context("a counter")?)?;
            // It wraps, and is read at least every half turn.
            let ahead = counter.wrapping_sub(self.time as u32) as i32;
            self.time = self.time.saturating_add_signed(ahead.into());
            for edge in &mut self.edges[self.untimed..] {
                let before = captured as f64 - edge.time;
                edge.time = self.time as f64 - before * self.ticks;
            }
            self.untimed = self.edges.len();
        }
        Ok(())
    }

    fn edges(&mut self) -> Vec<Edge> {
        let untimed = self.edges.split_off(self.untimed);
        self.untimed = 0;
        std::mem::replace(&mut self.edges, untimed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edges::Edge;

    fn read(log: &str) -> Result<Vec<Edge>> {
        let mut reader = Log::new(0.256, Port::of(21, 1));
        log.lines().try_for_each(|line| reader.line(line))?;
        Ok(reader.edges())
    }

    #[test]
    fn a_log_is_edges() {
        let log = "nrf51_gpio_write offset 0x518 value 0xe0000e\n\
                   nrf51_gpio_write offset 0x508 value 0x2\n@250 0x50000508\n\
                   nrf51_gpio_write offset 0x508 value 0x600000\n@1000 0x50000508\n\
                   @1004 0x4000804c\n\
                   nrf51_timer_read timer 0 read addr 0x548 data 0x7 size 4\n\
                   nrf51_timer_read timer 0 read addr 0x54c data 0x1000 size 4\n\
                   nrf51_gpio_write offset 0x50c value 0x200000\n@1250 0x5000050c\n";
        let edge = |time, axis, is_pulse, level| Edge { time, axis, is_pulse, level };
        // An instruction takes 0.256 ticks.
        let close = |a: &Edge, b: &Edge| (a.time - b.time).abs() < 1e-6;
        let (real, ideal) = (
            read(log).unwrap(),
            [
                edge(4096.0 - 754.0 * 0.256, 0, false, true),
                edge(4096.0 - 4.0 * 0.256, 0, true, true),
                edge(4096.0 - 4.0 * 0.256, 1, true, true),
            ],
        );
        assert_eq!(real.len(), ideal.len(), "{real:?}");
        for (real, ideal) in real.iter().zip(&ideal) {
            assert!(close(real, ideal), "{real:?}, {ideal:?}");
            assert_eq!(Edge { time: 0.0, ..*real }, Edge { time: 0.0, ..*ideal });
        }
        assert!(read("@1 0x50000508\n").is_err());
    }
}
