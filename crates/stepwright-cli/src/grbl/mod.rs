//! `stepwright grbl`: a machine that any G-code sender can drive.

mod fed;
mod wire;

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use stepwright_grbl::{Grbl, VirtualMill};

use crate::failure::Failure;
use crate::interrupt::{self, While};
use crate::order::target::PortArgs;
use crate::{files, say};
use fed::Fed;
use stepwright_play::stream::spelt;
use wire::{Heard, Wire};

/// The time between two reads, while an axis moves and while none does.
const LOOKS: (Duration, Duration) = (Duration::from_millis(2), Duration::from_millis(10));

/// With more bytes of waiting lines no more are read from standard input, a kilobyte at a time.
const ENOUGH: usize = stepwright_grbl::KEPT - 1024;

/// The most bytes of answers that wait for a reader; the rest is lost.
const UNHEARD: usize = 256 * 1024;

/// The largest size of the file of kept values, in bytes.
const KEPT: usize = 64 * 1024;

/// Run a machine for any G-code sender, with the protocol of grbl 1.1
///
/// Its motors are virtual, or those of a board with the program `stream`.
/// It plans ahead over 128 moves, and passes corners at the speed at which the motors
/// can start. A hold, a reset and a limit brake along the path; no position is lost.
#[derive(clap::Args)]
#[command(after_help = "\
--pty     The first line on standard output is `pty PATH`: give a sender that port.
--tcp     The first line is `tcp ADDRESS`: a sender that connects over a network.
--stdio   Lines on standard input are answered on standard output; at the end of
          the input the machine runs to rest, and its position is printed.
--port    The motors of an Uno, a Nano, a Mega, a Pico or a micro:bit with the program `stream`
          (`stepwright flash uno --program stream`), or of
          `stepwright board --pty --program stream`. Without homing and probe;
          $21=1 watches the board's switches, $32=1 needs a board with an output
          for a laser: a Mega or a Pico.
Ctrl-C brakes and ends it.

Settings are grbl's ($$ lists them), and Stepwright's own: $140 to $142, the start speed of the
motor of each axis in mm/min, and $150 to $152, its jerk limit in mm/s³. After an error, lines
are refused with error:9 until none has come for a quarter of a second: the lines that a sender
has sent ahead would be a job with a part missing. --after-error go-on is grbl's behaviour.

Examples:
  stepwright grbl --pty
  stepwright grbl --pty --keep mill.txt --limit X:0 --limit Y:0 --limit Z:0
  stepwright grbl --pty --port /dev/ttyACM0
  stepwright grbl --tcp 127.0.0.1:2323
  printf 'G21 G91 G1 X10 F600\\nY10\\n' | stepwright grbl --stdio --fast")]
pub struct Args {
    #[command(flatten)]
    way: Way,
    #[command(flatten)]
    port: PortArgs,
    /// Simulate as fast as this computer can while something moves
    #[arg(long, conflicts_with = "port")]
    fast: bool,
    /// Keep settings, work offsets and start-up lines in this file
    #[arg(long, value_name = "FILE")]
    keep: Option<PathBuf>,
    /// What happens after an error in G-code
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = AfterError::Stop)]
    after_error: AfterError,
    /// Limit switch that the axis closes at this position and beyond, in steps from where the
    /// machine was switched on: X:2000 upwards from 2000, Z:-300 downwards from -300
    #[arg(long, value_name = "AXIS:PLACE", value_parser = limit, help_heading = "The machine")]
    #[arg(allow_hyphen_values = true, conflicts_with = "port")]
    limit: Vec<(usize, i64)>,
    /// Probe that has contact when Z is at this position or below, in steps
    #[arg(long, value_name = "PLACE", value_parser = probe, help_heading = "The machine")]
    #[arg(allow_hyphen_values = true, conflicts_with = "port")]
    probe: Option<i64>,
}

/// Where the sender is.
#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct Way {
    /// On a pseudo-terminal, which any serial program can open
    #[arg(long)]
    pty: bool,
    /// On a TCP port; 0 is a free one
    #[arg(long, value_name = "ADDRESS", value_parser = address)]
    tcp: Option<SocketAddr>,
    /// On standard input and output
    #[arg(long)]
    stdio: bool,
}

/// What follows an error in G-code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum AfterError {
    /// Lines are refused until the sender has paused
    Stop,
    /// The next line is executed, as grbl does
    GoOn,
}

fn limit(text: &str) -> Result<(usize, i64), String> {
    let wrong = || format!("{text} is no switch: write X:2000 or Z:-300");
    let (axis, place) = text.split_once(':').ok_or_else(wrong)?;
    let axis = ["X", "Y", "Z"].iter().position(|name| name.eq_ignore_ascii_case(axis));
    Ok((axis.ok_or_else(wrong)?, place.parse().map_err(|_| wrong())?))
}

fn probe(text: &str) -> Result<i64, String> {
    text.parse().map_err(|_| format!("{text} is no place: write steps, as in -500"))
}

fn address(text: &str) -> Result<SocketAddr, String> {
    text.parse().map_err(|_| format!("{text} is no address: write 127.0.0.1:2323"))
}

/// Runs the machine until its input ends or Ctrl-C is pressed.
pub fn run(args: Args) -> Result<(), Failure> {
    let mut grbl = Grbl::new(machine(&args));
    let mut fed = None;
    if args.port.port.is_some() {
        let board = Fed::open(&args.port)?;
        grbl = grbl.fed(board.lasers()).judged_by(board.judge());
        fed = Some(board);
    }
    if args.after_error == AfterError::GoOn {
        grbl = grbl.with_errors_passed();
    }
    if let Some(path) = args.keep.as_deref().filter(|path| path.exists()) {
        let kept = files::read(path, KEPT)?;
        let wrong = |error| {
            Failure::new(format!("can't use {}: {error}", path.display()))
                .hint("mend the line, or remove the file to begin with the defaults")
        };
        grbl.restore(&kept).map_err(wrong)?;
        let on = |number| grbl.settings().is_on(number);
        let beyond = match &fed {
            Some(_) if on(22) => Some((22, "with --port there is no homing")),
            Some(fed) if on(32) && !fed.lasers() => {
                Some((32, "this board has no output for a laser"))
            }
            _ => None,
        };
        if let Some((number, why)) = beyond {
            return Err(Failure::new(format!("{} has ${number}=1", path.display())).hint(why));
        }
    }
    if let Some(path) = args.keep.as_deref() {
        // A file that can't be written is reported before anything moves.
        files::replace(path, grbl.kept().as_bytes())?;
    }
    interrupt::listen(While::Holding)?;
    let wire = match &args.way {
        #[cfg(unix)]
        Way { pty: true, .. } => Wire::pty()?,
        Way { tcp: Some(address), .. } => Wire::tcp(*address)?,
        Way { stdio: true, .. } => Wire::stdio(),
        _ => return Err(Failure::new("this system has no pseudo-terminals").hint("use --tcp")),
    };
    let kept = Kept { path: args.keep, last: grbl.kept(), failed: false };
    let clock = Clock::new(args.fast);
    Served { grbl, wire, clock, fed, unheard: Vec::new(), failed: None, kept }.serve()
}

fn machine(args: &Args) -> VirtualMill {
    let mut machine = VirtualMill { probe: args.probe, ..VirtualMill::default() };
    for &(axis, place) in &args.limit {
        machine.limits[axis][usize::from(place >= 0)] = Some(place);
    }
    machine
}

/// The time since the machine was switched on, in seconds.
struct Clock {
    begun: Instant,
    /// The seconds that were skipped, in fast mode.
    skipped: Option<f64>,
}

impl Clock {
    fn new(fast: bool) -> Clock {
        Clock { begun: Instant::now(), skipped: fast.then_some(0.0) }
    }

    fn now(&self) -> f64 {
        self.begun.elapsed().as_secs_f64() + self.skipped.unwrap_or(0.0)
    }
}

struct Served {
    grbl: Grbl<VirtualMill>,
    wire: Wire,
    clock: Clock,
    fed: Option<Fed>,
    /// Answers that are not sent yet.
    unheard: Vec<u8>,
    /// Why the line to the sender has failed.
    failed: Option<Failure>,
    kept: Kept,
}

/// The values that outlast a loss of power.
struct Kept {
    path: Option<PathBuf>,
    last: String,
    /// Whether the file could not be written, and this was reported.
    failed: bool,
}

impl Kept {
    /// Writes the values if they have changed. The machine continues if the file can't be written.
    fn write(&mut self, now: String) {
        let Some(path) = &self.path else { return };
        if now == self.last {
            return;
        }
        match files::replace(path, now.as_bytes()) {
            Ok(()) => self.failed = false,
            Err(failure) if !self.failed => {
                say::note(format_args!("warning: {}: its changes are not kept", failure.message()));
                self.failed = true;
            }
            Err(_) => {}
        }
        self.last = now;
    }
}

impl Served {
    fn now(&self) -> f64 {
        self.fed.as_ref().map_or_else(|| self.clock.now(), Fed::now)
    }

    /// Whether an axis moves, or a board still has a run.
    fn is_moving(&self) -> bool {
        self.grbl.is_moving() || self.fed.as_ref().is_some_and(Fed::is_busy)
    }

    /// Whether the axes rest because of a hold. A board has a run all the time.
    fn is_held(&self) -> bool {
        self.grbl.has_run() && !self.grbl.is_moving()
    }

    fn serve(mut self) -> Result<(), Failure> {
        let mut ended = false;
        let rests = |served: &Served| !served.is_moving() || served.is_held();
        while !(interrupt::asked() || self.failed.is_some() || ended && rests(&self)) {
            if !ended && self.pass(false)? {
                ended = true;
                // The last line may lack a line end.
                self.grbl.finish_line(self.now());
                self.answer(false);
            } else if ended {
                self.pass(true)?;
            }
            if !self.grbl.is_moving() {
                self.kept.write(self.grbl.kept());
            }
        }
        let left = ended && !self.grbl.is_idle();
        let asked = interrupt::asked();
        if asked || left || self.failed.is_some() {
            self.brake(asked)?;
        }
        if self.kept.failed {
            // Tries to write the file again.
            self.kept.last.clear();
        }
        self.kept.write(self.grbl.kept());
        let [x, y, z] = self.grbl.position();
        say::note(format_args!("position {x} {y} {z} steps"));
        if let Some(fed) = &mut self.fed {
            let (places, late) = fed.tells()?;
            say::note(format_args!("board {}, late steps {late}", spelt(places)));
        }
        if let Some(failure) = self.failed {
            return Err(failure);
        }
        if asked && matches!(self.wire, Wire::Stdio { .. }) {
            return Err(Failure::interrupted("interrupted: the motors stand"));
        }
        if left {
            return Err(Failure::new("the input ended in a hold: what was behind it was not done")
                .hint("a script that has M0 or ! needs a sender that says ~"));
        }
        match self.grbl.faults() {
            faults @ 1.. if ended => {
                Err(Failure::new(format!("lines that were refused, and alarms: {faults}")))
            }
            _ => Ok(()),
        }
    }

    /// Reads the line, and lets a slice of time pass. Returns whether the line has ended.
    fn pass(&mut self, ended: bool) -> Result<bool, Failure> {
        if let Some(fed) = &mut self.fed {
            fed.dead = interrupt::presses() >= 2;
            if let Err(failure) = fed.turn(&mut self.grbl) {
                self.answer(false);
                // Lets the sender receive the alarm before the port closes.
                std::thread::sleep(Duration::from_millis(300));
                return Err(failure);
            }
        }
        let moves = self.grbl.is_moving();
        let slice = if moves { LOOKS.0 } else { LOOKS.1 };
        let hurries = moves && self.clock.skipped.is_some();
        let wait = if hurries || self.fed.is_some() { Duration::ZERO } else { slice };
        // Standard input can wait; what a hold needs may be behind all that waits.
        let full = matches!(self.wire, Wire::Stdio { .. }) && moves && self.grbl.waiting() > ENOUGH;
        let heard = self.wire.hear(wait, ended || full).unwrap_or_else(|failure| {
            self.failed = Some(failure);
            Heard::default()
        });
        if let Some(skipped) = self.clock.skipped.as_mut().filter(|_| hurries) {
            *skipped += slice.as_secs_f64();
        }
        let now = self.now();
        if heard.came {
            // A new sender gets neither half a line nor answers of the sender before.
            self.grbl.hang_up();
            self.unheard.clear();
            _ = self.grbl.take_answers();
            // Opening a port resets an Arduino. A running job continues, however.
            if self.grbl.is_idle() {
                self.grbl.receive(now, b"\x18");
            }
        }
        self.grbl.receive(now, &heard.bytes);
        self.answer(heard.nobody);
        Ok(heard.ended)
    }

    /// Sends as many of the answers as the line takes.
    fn answer(&mut self, nobody: bool) {
        let new = self.grbl.take_answers();
        // Writes the values before the answer is sent. While a board is fed, nothing waits for a
        // disk: the values are written at rest.
        if !new.is_empty() && (self.fed.is_none() || !self.is_moving()) {
            self.kept.write(self.grbl.kept());
        }
        // Drops whole lines if nobody reads them.
        if self.unheard.len() + new.len() <= UNHEARD {
            self.unheard.extend(new);
        }
        if nobody || self.failed.is_some() {
            self.unheard.clear();
        }
        match self.wire.say(&self.unheard) {
            Ok(said) => _ = self.unheard.drain(..said),
            Err(failure) => self.failed = Some(failure),
        }
    }

    /// Brakes to rest, and drops everything. Start-up lines are not executed.
    fn brake(&mut self, asked: bool) -> Result<(), Failure> {
        if asked && self.is_moving() {
            say::note(interrupt::braking());
        }
        self.grbl.end(self.now());
        while self.is_moving() && interrupt::presses() < 2 {
            self.pass(true)?;
        }
        match &mut self.fed {
            Some(fed) if interrupt::presses() >= 2 => {
                fed.dead = true;
                fed.turn(&mut self.grbl)
            }
            _ => Ok(()),
        }
    }
}
