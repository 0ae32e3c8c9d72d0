//! A board in QEMU, with its line and its pins.

use std::env;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::ops::Range;
use std::os::fd::{AsFd, OwnedFd};
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSymbol};

use crate::boards::Simulated;
use crate::edges::{Edge, Reader};

/// The time of an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// 16 ns: the remaining distance between edges and their deadlines is the engine's own.
    Quick,
    /// 128 ns: 7.8 million a second, like a Cortex-M0 of 16 MHz that takes two cycles for each
    /// instruction.
    Chip,
}

impl Pace {
    /// QEMU's value: 2^shift ns.
    const fn shift(self) -> u32 {
        match self {
            Pace::Quick => 4,
            Pace::Chip => 7,
        }
    }

    /// The microseconds of an instruction.
    pub fn micros(self) -> f64 {
        f64::from(1u32 << self.shift()) / 1e3
    }
}

/// The longest time for anything, on a busy machine.
const LIMIT: Duration = Duration::from_secs(120);

/// The reader of a log. Its thread never panics.
fn lock(reader: &Mutex<Box<dyn Reader>>) -> MutexGuard<'_, Box<dyn Reader>> {
    reader.lock().unwrap_or_else(PoisonError::into_inner)
}

/// QEMU with a firmware.
pub struct Machine {
    child: Child,
    input: ChildStdin,
    output: Receiver<u8>,
    /// The board's output, before it is read.
    from: OwnedFd,
    /// Reads QEMU's log as it is written, because it is long.
    log: Option<JoinHandle<Result<()>>>,
    reader: Arc<Mutex<Box<dyn Reader>>>,
    /// The instructions at which it stops at its gate.
    stops: Receiver<u64>,
}

/// A path from the environment, which `cargo xtask` sets.
fn path(variable: &str) -> Result<PathBuf> {
    let path = env::var_os(variable).with_context(|| format!("{variable} is not set"))?;
    Ok(path.into())
}

/// QEMU for a board: `STEPWRIGHT_QEMU` is the folder where it was unpacked, if it is not installed.
///
/// # Errors
/// The board's manifest has no arguments for it.
pub fn qemu(board: &Simulated) -> Result<Command> {
    let words = board.words()?;
    let mut command = match env::var_os("STEPWRIGHT_QEMU").map(PathBuf::from) {
        Some(root) => {
            let mut command = Command::new(root.join("usr/bin").join(&words[0]));
            let libraries = ["usr/lib", "lib"].map(|folder| root.join(folder));
            let machine = format!("{}-linux-gnu", env::consts::ARCH);
            let libraries = libraries.map(|folder| folder.join(&machine).into_os_string());
            command.env("LD_LIBRARY_PATH", libraries.join(":".as_ref()));
            command
        }
        None => Command::new(&words[0]),
    };
    command.args(&words[1..]).args(["-display", "none", "-monitor", "none"]);
    Ok(command)
}

/// The path of a board's program: `STEPWRIGHT_FIRMWARE` is the folder of all.
pub fn firmware(board: &Simulated, program: &str) -> Result<PathBuf> {
    let name = board.name;
    let file = path("STEPWRIGHT_FIRMWARE")?.join(format!("{name}-{program}.elf"));
    ensure!(file.is_file(), "no {}: `cargo xtask firmware {name}` builds it", file.display());
    Ok(file)
}

/// The addresses of a symbol of a program: its first, and the one after its last.
///
/// # Errors
/// There is no such symbol.
pub fn symbol(board: &Simulated, program: &str, name: &str) -> Result<Range<u64>> {
    let data = fs::read(firmware(board, program)?)?;
    let file = object::File::parse(&*data)?;
    let symbol = file.symbols().find(|symbol| symbol.name() == Ok(name));
    let symbol = symbol.with_context(|| format!("{program} has no symbol {name}"))?;
    Ok(symbol.address()..symbol.address() + symbol.size())
}

/// The plugin.
pub fn plugin() -> Result<PathBuf> {
    path("STEPWRIGHT_PLUGIN")
}

impl Machine {
    /// Switches a board on.
    ///
    /// # Errors
    /// A required file is missing.
    pub fn start(board: &Simulated, program: &str, pace: Pace) -> Result<Machine> {
        let (task, words) = board.view.words();
        Machine::watched(board, program, pace, &task, words)
    }

    /// The same, with additional arguments for the plugin, and for QEMU.
    ///
    /// # Errors
    /// The same.
    pub fn watched(
        board: &Simulated,
        program: &str,
        pace: Pace,
        task: &str,
        words: &[&str],
    ) -> Result<Machine> {
        let elf = firmware(board, program)?;
        let mut command = qemu(board)?;
        let plugin = format!("{},{task}", plugin()?.display());
        command.args(["-serial", "stdio", "-icount", &format!("shift={}", pace.shift())]);
        command.args(words).args(["-plugin", &plugin]).arg("-kernel").arg(elf);
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .with_context(|| format!("starting {}", command.get_program().to_string_lossy()))?;
        let input = child.stdin.take().context("its input")?;
        let mut from = child.stdout.take().context("its output")?;
        let same = from.as_fd().try_clone_to_owned()?;
        let (to, output) = channel();
        thread::spawn(move || {
            let mut buffer = [0; 256];
            while let Ok(n @ 1..) = from.read(&mut buffer) {
                for byte in &buffer[..n] {
                    if to.send(*byte).is_err() {
                        return;
                    }
                }
            }
        });
        let log = BufReader::new(child.stderr.take().context("its log")?);
        let reader = Arc::new(Mutex::new(board.view.reader(pace, board.mhz())));
        let (told, stops) = channel();
        let reads = reader.clone();
        let log = thread::spawn(move || {
            let mut fault = Ok(());
            for line in log.lines().map_while(Result::ok) {
                if let Some(count) = line.strip_prefix('=').and_then(|count| count.parse().ok()) {
                    // Nothing receives this without a gate, or at the end.
                    let _ = told.send(count);
                    continue;
                }
                // The log is read to the end, because QEMU would wait otherwise.
                fault = fault.and_then(|()| lock(&reads).line(&line));
            }
            fault
        });
        Ok(Machine { child, input, output, from: same, log: Some(log), reader, stops })
    }

    /// The next line of the board.
    ///
    /// # Errors
    /// There is none.
    pub fn hear(&mut self) -> Result<String> {
        let (begun, mut line) = (Instant::now(), Vec::new());
        loop {
            let left = LIMIT.saturating_sub(begun.elapsed());
            match self.output.recv_timeout(left) {
                Ok(b'\r') => return Ok(String::from_utf8_lossy(&line).into_owned()),
                Ok(byte) => line.push(byte),
                Err(_) => bail!("silence after {:?}", String::from_utf8_lossy(&line)),
            }
        }
    }

    /// Sends a line, and returns the answer.
    ///
    /// # Errors
    /// There is none.
    pub fn ask(&mut self, line: &str) -> Result<String> {
        // QEMU passes bytes on as fast as the receiver's interrupt takes them, and a chip's ring
        // holds 64. So the line is sent in pieces, between which the main loop runs.
        for (n, piece) in format!("{line}\r").as_bytes().chunks(32).enumerate() {
            if n > 0 {
                thread::sleep(Duration::from_millis(10));
            }
            self.input.write_all(piece)?;
            self.input.flush()?;
        }
        self.hear().with_context(|| format!("asked {line:?}"))
    }

    /// Waits until no axis moves.
    ///
    /// # Errors
    /// An axis does not come to rest.
    pub fn rest(&mut self) -> Result<()> {
        ensure!(self.ask("A0")? == "Y", "A0");
        let begun = Instant::now();
        while self.ask("F")? != "R" {
            ensure!(begun.elapsed() < LIMIT, "it never comes to rest");
            thread::sleep(Duration::from_millis(2));
        }
        ensure!(self.ask("A1")? == "Y", "A1");
        Ok(())
    }

    /// Switches the board off, and returns all edges of its pins.
    ///
    /// # Errors
    /// The log is not as expected.
    pub fn end(mut self) -> Result<Vec<Edge>> {
        self.stop();
        let log = self.log.take().context("its log")?;
        log.join().unwrap_or_else(|panic| resume_unwind(panic))?;
        Ok(self.edges())
    }

    /// The edges whose time is known and that were not returned before.
    pub(crate) fn edges(&mut self) -> Vec<Edge> {
        lock(&self.reader).edges()
    }

    /// Writes bytes to its line, which QEMU reads when it polls.
    pub(crate) fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.input.write_all(bytes)?;
        Ok(self.input.flush()?)
    }

    /// Whether QEMU takes them, which it does within this time unless the board's receiver is full.
    pub(crate) fn takes(&self, within: Duration) -> Result<bool> {
        let begun = Instant::now();
        while rustix::io::ioctl_fionread(&self.input)? > 0 {
            if begun.elapsed() > within {
                return Ok(false);
            }
            thread::yield_now();
        }
        Ok(true)
    }

    /// The bytes of its output.
    pub(crate) fn said(&mut self) -> Result<Vec<u8>> {
        while rustix::io::ioctl_fionread(&self.from)? > 0 {
            thread::yield_now();
        }
        Ok(self.output.try_iter().collect())
    }

    /// Waits until it stops at its gate. Returns the instruction.
    pub(crate) fn stands(&mut self) -> Result<u64> {
        self.stops.recv_timeout(LIMIT).context("it does not come to its gate")
    }

    fn stop(&mut self) {
        // Both fail only if it has already ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        self.stop();
    }
}

/// The times of an axis's steps, in ticks.
pub fn steps(edges: &[Edge], axis: u8) -> Vec<f64> {
    edges.iter().filter(|edge| edge.axis == axis && edge.is_step()).map(|edge| edge.time).collect()
}
