//! A board whose time a test controls: it runs as far as it is told, and no farther.
//!
//! Times are in 2⁻⁴ µs since it was switched on, like those of an Uno's cycles, whatever its step
//! timer counts.

use std::io::{Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};
use std::{env, fs, process, thread};

use anyhow::{Context, Result, ensure};
use stepwright_sim::{Edge, Pin};

use crate::boards::Simulated;
use crate::machine::{Machine, Pace};

/// Units of time per µs.
const UNIT: f64 = 16.0;

/// QEMU takes a byte within this time, unless the board's receiver is full; then the board runs for
/// `LATER`.
const TAKEN: Duration = Duration::from_millis(3);
const LATER: u64 = 400;
/// QEMU starts within this time.
const AWAKE: Duration = Duration::from_secs(60);

/// A board with a gate.
pub struct Paced {
    machine: Machine,
    gate: UnixStream,
    /// QEMU's monitor. While the board is stopped QEMU sleeps, and a command to the monitor wakes
    /// it.
    monitor: UnixStream,
    /// The units of an instruction, and of a tick of the step timer.
    each: f64,
    tick: f64,
    /// The instructions so far.
    count: u64,
    edges: Vec<Edge>,
}

impl Paced {
    /// Switches a board on. It is stopped before its first instruction.
    ///
    /// # Errors
    /// A required file is missing.
    pub fn start(board: &Simulated, program: &str, pace: Pace) -> Result<Paced> {
        let (gate, monitor) = (Door::new()?, Door::new()?);
        let (task, words) = board.view.words();
        let task = format!("{task},gate={}", gate.path.display());
        let wakes = format!("socket,id=wakes,path={}", monitor.path.display());
        let wakes = ["-chardev", &wakes, "-mon", "chardev=wakes,mode=readline"];
        let words: Vec<&str> = words.iter().copied().chain(wakes).collect();
        let mut machine = Machine::watched(board, program, pace, &task, &words)?;
        let (gate, monitor) = (gate.open()?, monitor.open()?);
        monitor.set_nonblocking(true)?;
        let count = machine.stands()?;
        let (each, tick) = (pace.micros() * UNIT, UNIT / board.mhz());
        Ok(Paced { machine, gate, monitor, each, tick, count, edges: Vec::new() })
    }

    /// The present time.
    pub fn now(&self) -> u64 {
        (self.count as f64 * self.each) as u64
    }

    /// Lets it run until then, or some instructions longer.
    ///
    /// # Errors
    /// It does not run.
    pub fn run_until(&mut self, time: u64) -> Result<()> {
        let until = (time as f64 / self.each).ceil() as u64;
        if until > self.count {
            self.gate.write_all(&until.to_le_bytes())?;
            self.count = self.machine.stands()?;
        }
        Ok(())
    }

    /// Sends bytes to its line.
    ///
    /// # Errors
    /// It does not take them.
    pub fn send(&mut self, bytes: &[u8]) -> Result<()> {
        for byte in bytes {
            self.machine.put(&[*byte])?;
            // The monitor's answer is not needed, but has to be read.
            let mut answer = [0; 256];
            while matches!(self.monitor.read(&mut answer), Ok(1..)) {}
            self.monitor.write_all(b"\n")?;
            let begun = Instant::now();
            while !self.machine.takes(TAKEN)? {
                ensure!(begun.elapsed() < AWAKE, "it takes no bytes");
                // The receiver is full.
                self.run_until(self.now() + LATER)?;
            }
        }
        Ok(())
    }

    /// The output since the last call.
    ///
    /// # Errors
    /// The pipe is closed.
    pub fn said(&mut self) -> Result<Vec<u8>> {
        self.machine.said()
    }

    /// All edges so far.
    pub fn edges(&mut self) -> &[Edge] {
        let tick = self.tick;
        self.edges.extend(self.machine.edges().into_iter().map(|edge| Edge {
            time: (edge.time * tick).round() as u64,
            axis: edge.axis,
            pin: if edge.is_pulse { Pin::Step } else { Pin::Direction },
            level: edge.level,
        }));
        &self.edges
    }
}

/// A socket that QEMU connects to once, by its path.
struct Door {
    listener: UnixListener,
    path: PathBuf,
}

impl Door {
    fn new() -> Result<Door> {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = env::temp_dir().join(format!("stepwright-{}-{number}", process::id()));
        let listener = UnixListener::bind(&path).with_context(|| path.display().to_string())?;
        listener.set_nonblocking(true)?;
        Ok(Door { listener, path })
    }

    /// Waits for QEMU.
    fn open(&self) -> Result<UnixStream> {
        let begun = Instant::now();
        loop {
            match self.listener.accept() {
                Ok((stream, _)) => return Ok(stream),
                Err(why) if begun.elapsed() > AWAKE => return Err(why).context("QEMU begins"),
                Err(_) => thread::sleep(Duration::from_millis(5)),
            }
        }
    }
}

impl Drop for Door {
    fn drop(&mut self) {
        // The file is gone, or stays where such files do.
        let _ = fs::remove_file(&self.path);
    }
}
