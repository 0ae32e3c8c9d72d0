//! The edges of a board's pins, from QEMU's log.

mod stored;
mod traced;

use anyhow::{Context, Result};

use crate::machine::Pace;

/// A change of a pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The time in ticks of the step timer since the board was switched on.
    pub time: f64,
    /// The axis, 0 … 2.
    pub axis: u8,
    /// True for STEP, false for DIR.
    pub is_pulse: bool,
    /// High after the edge.
    pub level: bool,
}

impl Edge {
    /// Whether the motor steps.
    pub fn is_step(&self) -> bool {
        self.is_pulse && self.level
    }
}

/// How a board's pins are observed in QEMU's log. STEP and DIR of the first axis are these bits of
/// the port; those of the other axes follow.
#[derive(Clone, Copy, Debug)]
pub enum View {
    /// From QEMU's own trace of an nRF51's port and timer: see `edges/traced.rs`.
    Traced {
        /// STEP.
        step: u32,
        /// DIR.
        dir: u32,
    },
    /// From the addresses of stores, where word N of memory raises the pins whose bits N has, or
    /// lowers them: see `edges/stored.rs`.
    Stored {
        /// The address of the words that raise.
        set: u32,
        /// The address of the words that lower.
        clear: u32,
        /// The bytes of each.
        size: u32,
        /// STEP.
        step: u32,
        /// DIR.
        dir: u32,
    },
}

impl View {
    /// The bits of STEP and of DIR of the first axis.
    pub fn pins(self) -> (u32, u32) {
        match self {
            View::Traced { step, dir } | View::Stored { step, dir, .. } => (step, dir),
        }
    }

    /// The arguments for the plugin, and for QEMU.
    pub(crate) fn words(self) -> (String, &'static [&'static str]) {
        match self {
            View::Traced { .. } => (traced::watched(), &traced::TRACES),
            View::Stored { set, clear, size, .. } => {
                let range = |first: u32| format!("{first:#x}-{:#x}", first + size);
                (format!("watch={}+{}", range(set), range(clear)), &["-d", "plugin"])
            }
        }
    }

    /// A reader for the log of a board whose step timer counts `mhz` ticks in a microsecond.
    pub(crate) fn reader(self, pace: Pace, mhz: f64) -> Box<dyn Reader> {
        let ticks = pace.micros() * mhz;
        match self {
            View::Traced { step, dir } => Box::new(traced::Log::new(ticks, Port::of(step, dir))),
            View::Stored { set, clear, step, dir, .. } => {
                Box::new(stored::Log::new(ticks, [set, clear], Port::of(step, dir)))
            }
        }
    }
}

/// Reads a log, line by line.
pub(crate) trait Reader: Send {
    /// Takes a line.
    ///
    /// # Errors
    /// The line is not as expected.
    fn line(&mut self, line: &str) -> Result<()>;

    /// The edges whose time is known by now. Each is returned once.
    fn edges(&mut self) -> Vec<Edge>;
}

/// The levels of a port's pins.
struct Port {
    levels: u32,
    step: u32,
    dir: u32,
}

impl Port {
    fn of(step: u32, dir: u32) -> Port {
        Port { levels: 0, step, dir }
    }

    /// Raises or lowers pins. Returns the edges.
    fn change(&mut self, bits: u32, high: bool, time: f64) -> Vec<Edge> {
        let after = if high { self.levels | bits } else { self.levels & !bits };
        let changed = after ^ self.levels;
        self.levels = after;
        let pins = (0..3u8).flat_map(|axis| [(axis, self.step, true), (axis, self.dir, false)]);
        let edge = |(axis, first, is_pulse): (u8, u32, bool)| {
            let level = after >> (first + u32::from(axis)) & 1 != 0;
            (changed >> (first + u32::from(axis)) & 1 != 0).then_some(Edge {
                time,
                axis,
                is_pulse,
                level,
            })
        };
        pins.filter_map(edge).collect()
    }
}

/// A hexadecimal number.
fn hex(text: &str) -> Result<u32> {
    let digits = text.strip_prefix("0x").with_context(|| format!("0x in front of {text}"))?;
    Ok(u32::from_str_radix(digits, 16)?)
}

/// A line of the plugin: the instruction and the address.
fn store(text: &str) -> Result<(u64, u32)> {
    let (count, address) = text.split_once(' ').context("an address")?;
    Ok((count.parse()?, hex(address)?))
}
