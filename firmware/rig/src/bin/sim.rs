//! The simulated board in real time, on a pseudo-terminal.
//!
//! `cargo xtask sim uno` builds the firmware and calls this.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use clap::Parser;
use stepwright_protocol::AxisId;
use stepwright_rig::board::{AXES, HZ, Pin as ChipPin};
use stepwright_rig::dump::PinDump;
use stepwright_rig::edges::steps_of;
use stepwright_rig::pty::Pty;
use stepwright_rig::{Board, Chip, Image, firmware};
use stepwright_sim::{Edge, Pin, Switch};

/// How often the line is polled: a byte takes 85 µs.
const SLICE: Duration = Duration::from_millis(1);
/// If it is behind by more than this, the clock is set again.
const LAG: Duration = Duration::from_millis(250);
/// How often the summary processes the edges, so that they need no memory.
const TALLY: u64 = HZ;
/// How often a machine with switches is examined, in cycles: a step takes longer.
const GLANCE: u64 = HZ / 40_000;

/// Run the firmware on a simulated chip, in real time, on a pseudo-terminal.
///
/// Lines on standard input act on the machine: `press 1`, `release 1` (the limit switch of an
/// axis), `reset` (the button), `power` (the plug is pulled and put back), `end` (as Ctrl-C).
/// `where` prints the chip's time, and each axis by the edges of its pins.
#[derive(Parser)]
struct Args {
    /// uno, nano or mega
    board: Board,
    /// The firmware, if it is not the built one
    #[arg(long, value_name = "FILE")]
    elf: Option<PathBuf>,
    /// The bytes of its flash instead
    #[arg(long, value_name = "FILE", conflicts_with = "elf")]
    flash: Option<PathBuf>,
    /// A boot loader instead, in Intel HEX: the chip has nothing else in it
    #[arg(long, value_name = "FILE", conflicts_with_all = ["elf", "flash"])]
    boot_loader: Option<PathBuf>,
    /// Also make the pseudo-terminal known by this name
    #[arg(long, value_name = "PATH")]
    pty_link: Option<PathBuf>,
    /// Give an axis a limit switch to ground at a place, in steps from where its shaft is at
    /// the start: 1:-300. On another pin than the shield's: 1:500@D12
    #[arg(long, value_name = "AXIS:STEPS", allow_hyphen_values = true)]
    switch: Vec<Contact>,
    /// Write down every change of the board's pins, for GTKWave or PulseView
    #[arg(long, value_name = "FILE")]
    vcd: Option<PathBuf>,
    /// The subcommand of `stepwright` that speaks with its program, to be said
    #[arg(long, value_name = "ORDER")]
    tried_with: Option<String>,
    /// Let its time pass as fast as this machine can, instead of in real time
    #[arg(long)]
    fast: bool,
    /// Keep its time in this file, in ns and 8 bytes: for programs that are to live in it
    #[arg(long, value_name = "FILE")]
    clock: Option<PathBuf>,
}

/// A limit switch and its pin, if that is not the shield's.
#[derive(Clone)]
struct Contact {
    switch: Switch,
    pin: Option<String>,
}

impl FromStr for Contact {
    type Err = String;

    fn from_str(text: &str) -> Result<Contact, String> {
        let (switch, pin) = text.split_once('@').map_or((text, None), |(s, pin)| (s, Some(pin)));
        Ok(Contact { switch: switch.parse()?, pin: pin.map(str::to_owned) })
    }
}

impl Contact {
    /// The pin to which it is wired.
    fn pin(&self, board: Board) -> Result<ChipPin> {
        let Some(name) = &self.pin else { return Ok(board.switch()[self.switch.axis.index()]) };
        let pins = board.pins();
        let found = pins.iter().find(|(known, _)| known.to_string() == *name);
        found.map(|(_, pin)| *pin).with_context(|| format!("a {board} has no pin {name}"))
    }
}

fn main() -> Result<()> {
    let args = Args::parse();
    let image = match (&args.elf, &args.flash, &args.boot_loader) {
        (Some(file), ..) => Image::read(file)?,
        (None, Some(file), _) => Image::flash(file)?,
        (None, None, Some(file)) => Image::boot_loader(file, args.board.flash())?,
        (None, None, None) => firmware::load(args.board.name())?,
    };
    let ended = Arc::new(AtomicBool::new(false));
    let end = Arc::clone(&ended);
    ctrlc::set_handler(move || end.store(true, Ordering::Relaxed))?;

    let mut pty = Pty::open().context("no pseudo-terminal")?;
    let _link = args.pty_link.map(|path| Link::new(path, &pty)).transpose()?;
    println!("pty {}", pty.path().display());
    let hint = match &args.tried_with {
        Some(order) => {
            let pty = pty.path().display();
            format!("try it from another terminal: stepwright {order} --port {pty}")
        }
        None => "`where` and Enter say where its axes are".to_owned(),
    };
    eprintln!("{} as {}; {hint}; Ctrl-C ends it", args.board.chip(), args.board);

    let mut chip = Chip::new(args.board, &image);
    let mut dump = args.vcd.as_deref().map(|path| dump(&mut chip, path)).transpose()?;
    let clock = args.clock.map(|path| OpenOptions::new().write(true).open(path)).transpose()?;
    let mut contacts = Vec::new();
    for contact in &args.switch {
        contacts.push((contact.switch, contact.pin(args.board)?, false));
    }
    if args.boot_loader.is_some() {
        // It listens only after a press of the button.
        chip.reset();
    }
    let mut tally = Tally::default();
    let acts = acts();
    let (mut begun, mut behind) = (Instant::now(), Duration::ZERO);
    while !ended.load(Ordering::Relaxed) {
        if !args.fast {
            let time = Duration::from_micros(chip.now() * 1_000_000 / HZ);
            let wall = begun.elapsed();
            let (late, early) = (wall.saturating_sub(time), time.saturating_sub(wall));
            if late > LAG {
                // This machine is too slow, or was asleep: the time slips.
                behind += late;
                begun += late;
            } else if !early.is_zero() {
                thread::sleep(early.max(SLICE));
            }
        }
        let bytes = pty.read()?;
        chip.send(&bytes);
        let until = chip.now() + HZ / 1000;
        while chip.now() < until {
            if contacts.is_empty() {
                chip.run_until(until);
                break;
            }
            chip.run_for(GLANCE);
            tally.take(&mut chip);
            for (switch, pin, closed) in &mut contacts {
                let is = switch.is_closed(tally.positions[switch.axis.index()]);
                if std::mem::replace(closed, is) != is {
                    chip.pull(*pin, is);
                }
            }
        }
        if let Some(clock) = &clock {
            clock.write_all_at(&(chip.now() * 1_000_000_000 / HZ).to_ne_bytes(), 0)?;
        }
        pty.write(&chip.take_said());
        if chip.now() - tally.taken > TALLY {
            tally.take(&mut chip);
        }
        if let Some(dump) = &mut dump {
            dump.changes(&chip.take_watched_changes())?;
        }
        match acts.try_recv() {
            Ok(Act::Switch { axis, closed }) => chip.press(axis.index(), closed),
            Ok(Act::Reset) => chip.reset(),
            Ok(Act::Power) => chip.power_loss(0xFF),
            Ok(Act::Where) => {
                tally.take(&mut chip);
                tally.print_axes(&chip);
            }
            Ok(Act::End) => break,
            Err(_) => {}
        }
    }
    if let Some(dump) = dump {
        dump.finish(chip.now())?;
    }
    tally.take(&mut chip);
    tally.print(&mut chip, behind);
    Ok(())
}

/// A dump of every pin of the board.
fn dump(chip: &mut Chip, path: &Path) -> Result<PinDump<BufWriter<File>>> {
    let (names, pins): (Vec<_>, Vec<_>) =
        chip.board().pins().into_iter().map(|(name, pin)| (name.to_string(), pin)).unzip();
    chip.watch_pins(&pins);
    let file = File::create(path).with_context(|| format!("writing {}", path.display()))?;
    Ok(PinDump::begin(BufWriter::new(file), &names)?)
}

/// An event from outside the machine.
#[derive(Clone, Copy)]
enum Act {
    Switch { axis: AxisId, closed: bool },
    Reset,
    Power,
    Where,
    End,
}

impl FromStr for Act {
    type Err = String;

    fn from_str(line: &str) -> Result<Act, String> {
        let words: Vec<_> = line.split_whitespace().collect();
        let axis = |text: &str| {
            let axis = text.parse().ok().and_then(AxisId::numbered);
            axis.filter(|axis| axis.index() < AXES).ok_or_else(|| format!("axes are 1 to {AXES}"))
        };
        match words[..] {
            ["press", number] => Ok(Act::Switch { axis: axis(number)?, closed: true }),
            ["release", number] => Ok(Act::Switch { axis: axis(number)?, closed: false }),
            ["reset"] => Ok(Act::Reset),
            ["power"] => Ok(Act::Power),
            ["where"] => Ok(Act::Where),
            ["end"] => Ok(Act::End),
            _ => {
                Err(format!("{line:?}: there are press N, release N, reset, power, where and end"))
            }
        }
    }
}

/// Reads the events on standard input.
fn acts() -> Receiver<Act> {
    let (send, acts) = mpsc::channel();
    thread::spawn(move || {
        for line in io::stdin().lines().map_while(|line| line.ok()) {
            match line.parse() {
                Ok(act) if send.send(act).is_err() => return,
                Ok(_) => {}
                Err(why) => eprintln!("{why}"),
            }
        }
    });
    acts
}

/// A second name of the pseudo-terminal, while this lives.
struct Link(PathBuf);

impl Link {
    fn new(path: PathBuf, pty: &Pty) -> Result<Link> {
        if path.is_symlink() {
            // A link that an earlier run left.
            std::fs::remove_file(&path)?;
        }
        std::os::unix::fs::symlink(pty.path(), &path)
            .with_context(|| format!("making {}", path.display()))?;
        Ok(Link(path))
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// A summary of the motion, without every edge.
#[derive(Default)]
struct Tally {
    taken: u64,
    steps: [u64; AXES],
    positions: [i64; AXES],
    /// Cycles of the first step, and of the last one.
    span: Option<(u64, u64)>,
    /// The last known level of each DIR.
    directions: [Option<Edge>; AXES],
}

impl Tally {
    fn take(&mut self, chip: &mut Chip) {
        self.taken = chip.now();
        let edges = chip.take_edges();
        for axis in 0..AXES {
            let known = self.directions[axis].into_iter();
            let edges: Vec<Edge> = known.chain(edges.iter().copied()).collect();
            let steps = steps_of(&edges, axis as u8);
            self.steps[axis] += steps.len() as u64;
            if let [first, .., last] | [first @ last] = &steps[..] {
                let (begun, ended) = self.span.unwrap_or((first.time, last.time));
                self.span = Some((begun.min(first.time), ended.max(last.time)));
            }
            self.positions[axis] += steps.last().map_or(0, |step| step.position);
            let is_direction = |edge: &&Edge| edge.axis == axis as u8 && edge.pin == Pin::Direction;
            self.directions[axis] = edges.iter().rfind(is_direction).copied();
        }
    }

    fn print_axes(&self, chip: &Chip) {
        println!("cycles {}, {:.3} s", chip.now(), chip.now() as f64 / HZ as f64);
        for axis in 0..AXES {
            println!(
                "axis {}: {} steps, from 0 to {}",
                axis + 1,
                self.steps[axis],
                self.positions[axis]
            );
        }
        if let Some((begun, ended)) = self.span {
            let [begun, ended] = [begun, ended].map(|cycles| cycles as f64 / HZ as f64);
            println!("steps from {begun:.6} s to {ended:.6} s");
        }
    }

    fn print(&self, chip: &mut Chip, behind: Duration) {
        self.print_axes(chip);
        // A program of a user's own need not have the line.
        if let Some(answer) = chip.ask("?") {
            println!("board: {answer}");
        }
        if !behind.is_zero() {
            println!("this machine was too slow by {:.1} s in all", behind.as_secs_f64());
        }
    }
}
