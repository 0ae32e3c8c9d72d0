//! The board of an order.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::thread;
use std::time::Duration;

use clap::ValueEnum;
use stepwright_protocol::AxisId;
#[cfg(unix)]
use stepwright_protocol::LeaseMillis;

use super::motion::RampArgs;
use crate::board::edge_files::EdgePaths;
use crate::board::recording::{Heading, Recording};
use stepwright_play::PlayError;

use crate::failure::Failure;
use crate::interrupt::{self, Ends};
use crate::programs;
use crate::quantity::whole_in;
#[cfg(unix)]
use crate::say;
use stepwright_host::link::bench::{Bench, TimerWidth};
#[cfg(unix)]
use stepwright_host::link::guest::{self, GuestLink};
#[cfg(unix)]
use stepwright_host::link::host::Host;
#[cfg(unix)]
use stepwright_host::link::lease;
use stepwright_host::link::serial::{LeaseWait, SerialLink, Share};
use stepwright_host::link::simulated::VirtualLink;
use stepwright_host::link::{Link, OpenError};
use stepwright_host::{LinkError, Session};
use stepwright_machine::BAUD;
use stepwright_plot::PlotFile;
use stepwright_sim::Description;
use stepwright_sim::Switch;

/// How often to connect to the holder of a port, which may be about to end.
#[cfg(unix)]
const MEETINGS: u32 = 5;
/// The socket of a program that ends is closed within this time.
#[cfg(unix)]
const ENDING: Duration = Duration::from_millis(50);

/// The rate of the boards' serial ports in bits/s.
pub const RATE: u32 = 115_200;

/// How to have a virtual board that stays.
pub const STAYS: &str = if cfg!(unix) {
    "A virtual board that stays: run `stepwright board --pty` in another terminal and give the path \
     it says"
} else {
    "A virtual board that stays: `stepwright serve`, for a browser and over HTTP"
};

/// How results are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people.
    Text,
    /// For programs: one line of JSON on standard output.
    Json,
}

/// The options that name a serial port.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Board")]
pub struct PortArgs {
    /// Serial port of the board: /dev/ttyUSB0, COM3; or the path that `stepwright board --pty` says
    #[arg(long, value_name = "PATH")]
    pub port: Option<PathBuf>,
    /// Speed of the serial port in bits/s (8 data bits, no parity, 1 stop bit)
    #[arg(long, value_name = "N", default_value_t = RATE, requires = "port")]
    #[arg(value_parser = whole_in::<u32>(BAUD))]
    pub baud: u32,
}

impl PortArgs {
    /// This port, at the usual speed.
    pub fn at(path: PathBuf) -> PortArgs {
        PortArgs { port: Some(path), baud: RATE }
    }
}

/// The options of a virtual board that lives as long as its order.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Virtual board (without --port)")]
pub struct VirtualArgs {
    /// Use a virtual board even if the machine file names a port
    #[arg(id = "virtual", long = "virtual", conflicts_with = "port")]
    _virtual_board: bool,
    /// Simulate as fast as this computer can, instead of in real time
    #[arg(long, conflicts_with = "port")]
    pub fast: bool,
    /// Record every edge of its pins, for GTKWave or PulseView
    #[arg(long, value_name = "FILE", conflicts_with = "port")]
    vcd: Option<PathBuf>,
    /// Record the edges as MCAP, for Foxglove or PlotJuggler
    #[arg(long, value_name = "FILE", conflicts_with = "port")]
    mcap: Option<PathBuf>,
    /// Plot position, speed and acceleration of its motors over time: .svg, .png or .html
    #[arg(long, value_name = "FILE", conflicts_with = "port")]
    pub plot: Option<PlotFile>,
}

/// The option that names an axis.
#[derive(clap::Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Board")]
pub struct AxisArgs {
    /// Which axis of the board: 1 to 8, or X, Y, Z
    #[arg(long, value_name = "N", default_value = "1", value_parser = axis)]
    pub axis: AxisId,
}

/// The options of every order that moves a motor: how it starts and stops, on which board,
/// and how the result is written.
#[derive(clap::Args, Clone, Debug)]
pub struct MotionArgs {
    /// How to write the result
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub format: Format,
    #[command(flatten)]
    pub ramps: RampArgs,
    #[command(flatten)]
    pub port: PortArgs,
    #[command(flatten)]
    pub virt: VirtualArgs,
}

/// Reads an axis: 1 … 8, or X, Y or Z for the first three.
pub fn axis(text: &str) -> Result<AxisId, String> {
    let number = match text {
        "x" | "X" => Some(1),
        "y" | "Y" => Some(2),
        "z" | "Z" => Some(3),
        _ => text.parse().ok(),
    };
    let axis = number.and_then(AxisId::numbered);
    axis.ok_or_else(|| "axes are numbered 1 to 8, or X, Y, Z for the first three".to_owned())
}

impl PortArgs {
    /// Opens the port and connects to its board. `order` is the subcommand.
    pub fn meet(&self, order: &str, share: Share) -> Result<Session, Failure> {
        #[cfg(unix)]
        if let (Share::Guest, Some(path)) = (share, &self.port)
            && let Some(session) = through_holder(path)?
        {
            return Ok(session);
        }
        let mut session = self.open(order, share)?;
        met(&mut session)?;
        Ok(session)
    }

    /// Opens the port without sending anything.
    pub fn open(&self, order: &str, share: Share) -> Result<Session, Failure> {
        let Some(path) = &self.port else {
            return Err(Failure::usage(format!("`stepwright {order}` needs a board: --port PATH"))
                .hint(format!("`stepwright ports` lists the serial ports. {STAYS}")));
        };
        let mut session = conversation(Box::new(serial(path, self.baud, share)?));
        if share == Share::Host {
            let_in(&mut session, path);
        }
        Ok(session)
    }

    /// The board through the stepwright that holds the port, for a stop; `None` if no holder lets
    /// others in.
    pub fn guest(&self) -> Option<Session> {
        #[cfg(unix)]
        let guest = self.port.as_deref().and_then(|port| GuestLink::open(port, guest::SOON));
        #[cfg(unix)]
        return guest.map(|guest| conversation(Box::new(guest)));
        #[cfg(not(unix))]
        None
    }

    /// Checks that the board continues after this program has ended.
    pub fn stays(&self) -> Result<(), Failure> {
        match self.port {
            Some(_) => Ok(()),
            None => Err(Failure::usage("--detach needs a board that stays: --port PATH")
                .hint(format!("a virtual board without --port ends with this program. {STAYS}"))),
        }
    }

    /// The board at the port if one is given, otherwise a new virtual board, whose plot has this
    /// heading.
    pub fn or_virtual(
        &self,
        virt: &VirtualArgs,
        order: &str,
        heading: Heading,
    ) -> Result<Session, Failure> {
        if self.port.is_some() {
            return self.meet(order, Share::Host);
        }
        virt.board(heading, &[])
    }
}

impl VirtualArgs {
    /// The files for the edges of its pins.
    pub fn edges(&self) -> EdgePaths<'_> {
        EdgePaths { vcd: self.vcd.as_deref(), mcap: self.mcap.as_deref(), laser: false }
    }

    /// A new virtual board with these switches.
    pub fn board(&self, heading: Heading, switches: &[Switch]) -> Result<Session, Failure> {
        let virt = self;
        let description = Description::uno();
        let plot = virt.plot.as_ref().map(|file| (file, heading));
        let recording = Recording::begin(&description, virt.edges(), plot)?;
        let bench = Bench::new(description, TimerWidth::Narrow, recording).with_switches(switches);
        let mut session = conversation(Box::new(VirtualLink::new(bench, virt.fast)));
        met(&mut session)?;
        Ok(session)
    }
}

/// Connects to the board through the stepwright that holds its port; `None` if no holder lets
/// others in.
#[cfg(unix)]
fn through_holder(port: &Path) -> Result<Option<Session>, Failure> {
    for _ in 0..MEETINGS {
        let Some(guest) = GuestLink::open(port, guest::PATIENCE) else { break };
        let mut session = conversation(Box::new(guest));
        match session.meet() {
            Ok(()) => return Ok(Some(session)),
            // The holder is ending: its socket closes after its conversations.
            Err(LinkError::Gone(_)) => thread::sleep(ENDING),
            Err(LinkError::Silent) => {
                let what = format!("no answer from the stepwright that holds {}", port.display());
                return Err(Failure::new(what).hint(
                    "is it suspended, or the board silent? `stepwright stop` and `stepwright \
                     kill` get through all the same",
                ));
            }
            Err(trouble) => return Err(not_met(&mut session, trouble)),
        }
    }
    Ok(None)
}

/// Connects to the board of a session.
pub fn met(session: &mut Session) -> Result<(), Failure> {
    session.meet().map_err(|trouble| not_met(session, trouble))
}

fn not_met(session: &mut Session, trouble: LinkError) -> Failure {
    let name = session.link().name();
    if matches!(trouble, LinkError::Silent)
        && let Some(Err(another)) = greeting(session).map(|answer| {
            programs::is_wanted(&name, &answer, programs::CONTROLLER, |_| programs::SLAVE)
        })
    {
        return another;
    }
    if let LinkError::Program(answer) = &trouble
        && let Err(another) =
            programs::is_wanted(&name, answer, programs::CONTROLLER, |_| programs::SLAVE)
    {
        return another;
    }
    match trouble {
        LinkError::Silent => Failure::new(format!("no answer from {name}")).hint(
            "is it the board's port (`stepwright ports`), at its rate (--baud), with \
             Stepwright's or the Nano slave's program on it?",
        ),
        other => lost(&name, &other),
    }
}

/// Connects to a board whose program greets with `wanted`. Returns its answer to `?`. For another
/// answer, `program` names the program to flash.
pub fn met_program(
    session: &mut Session,
    wanted: &str,
    program: impl Fn(&str) -> &'static str,
) -> Result<String, Failure> {
    let name = session.name();
    let about = match session.meet_program() {
        Ok(about) => about,
        Err(LinkError::Silent) => match greeting(session) {
            Some(old) => {
                programs::is_wanted(&name, &old, wanted, &program)?;
                return Err(Failure::new(format!(
                    "{name} runs a program from before this version of the command"
                ))
                .hint(programs::flash(&old, program(&old))));
            }
            None => {
                return Err(Failure::new(format!("{name} does not answer"))
                    .hint(programs::flash("", program(""))));
            }
        },
        Err(trouble) => return Err(lost(&name, &trouble)),
    };
    programs::is_wanted(&name, &about, wanted, &program)?;
    Ok(about)
}

/// The answer to `?` of a board that does not know the controller's protocol.
fn greeting(session: &mut Session) -> Option<String> {
    let link = session.link();
    link.write(b"\r?\r").ok()?;
    let (end, mut heard) = (link.now() + Duration::from_millis(300), Vec::new());
    while link.now() < end {
        let mut bytes = [0; 64];
        let count = link.read(&mut bytes, end.saturating_sub(link.now())).ok()?;
        heard.extend_from_slice(bytes.get(..count)?);
    }
    let lines = String::from_utf8_lossy(&heard).into_owned();
    lines.split('\r').find(|line| line.starts_with("stepwright-")).map(str::to_owned)
}

/// The failure of a session in which nothing was moving.
pub fn lost(name: &str, trouble: &LinkError) -> Failure {
    PlayError::lost(name, trouble).into()
}

/// Checks that the board has this axis.
pub fn has_axis(session: &Session, axis: AxisId) -> Result<(), Failure> {
    match session.info() {
        Some(info) if axis.number() > info.axes => {
            Err(Failure::new(format!("the board has no axis {}", axis.number()))
                .hint(format!("give --axis 1 to {}", info.axes)))
        }
        None if axis != AxisId::FIRST => {
            Err(Failure::new("this board knows only one axis (it answers `?` with E)")
                .hint("leave --axis out"))
        }
        _ => Ok(()),
    }
}

/// Makes the failure for a link error, with the name of the session's board.
pub fn trouble(session: &mut Session) -> impl FnOnce(LinkError) -> Failure + use<> {
    let name = session.link().name();
    move |trouble| lost(&name, &trouble)
}

/// Finishes the link of a session.
pub fn finish(session: &mut Session) -> Result<(), Failure> {
    session.link().finish().map_err(Failure::recording)
}

/// A session in which the first Ctrl-C brakes.
pub fn conversation(link: Box<dyn Link>) -> Session {
    let mut session = Session::new(link);
    session.set_guard(interrupt::guard(Ends::ByBraking));
    session
}

/// Lets other stepwrights use the board on this port through this session.
pub fn let_in(session: &mut Session, port: &Path) {
    #[cfg(unix)]
    if let Some(host) = Host::open(port) {
        session.serve(Box::new(host));
    }
    #[cfg(not(unix))]
    let _ = (session, port);
}

/// Opens a serial port, after a lease of a dead holder has expired.
pub fn serial(path: &Path, baud: u32, share: Share) -> Result<SerialLink, Failure> {
    SerialLink::open(path, baud, share, let_run_out).map_err(|error| match error {
        OpenError::Io(error) => refused(path, baud, &error),
        OpenError::Ended => {
            let name = path.display();
            Failure::interrupted(format!("{name}: interrupted before a line was said"))
        }
        OpenError::InUse if cfg!(windows) => Failure::new(format!("{} is in use", path.display()))
            .hint(
                "on Windows one program at a time has a port: a move is braked by Ctrl-C in its own \
                 window. `stepwright serve` lets several programs and pages use a board",
            ),
        OpenError::InUse => Failure::new(format!("{} is in use", path.display())).hint(
            "another program is talking to this board; wait for it, or end it. \
             `stepwright stop` and `stepwright kill` get through all the same; `status`, \
             `position`, `retarget` and `watch` do where it is a stepwright that moves or serves",
        ),
    })
}

#[cfg(unix)]
fn let_run_out(path: &Path) -> LeaseWait {
    let tell = |lease: LeaseMillis| {
        let (name, millis) = (path.display(), lease.get());
        say::note(format_args!(
            "{name}: whoever had it left a lease of {millis} ms; silent until it has run out"
        ));
    };
    lease::let_run_out(path, tell, interrupt::asked)
}

#[cfg(not(unix))]
fn let_run_out(_: &Path) -> LeaseWait {
    LeaseWait::Over
}

/// The failure for a port that can't be opened, with a hint.
fn refused(path: &Path, baud: u32, error: &io::Error) -> Failure {
    let shown = path.display();
    match error.kind() {
        ErrorKind::NotFound => Failure::new(format!("there is no port {shown}"))
            .hint("is the board plugged in? `stepwright ports` lists the ports there are"),
        ErrorKind::PermissionDenied => Failure::new(format!("no permission to open {shown}")).hint(
            "on Linux, join the group that owns it: `sudo usermod -aG dialout $USER`, \
                 then log in again",
        ),
        ErrorKind::ResourceBusy => Failure::new(format!("{shown} is in use"))
            .hint("another program has it open: a terminal, an IDE's monitor, a print server"),
        ErrorKind::InvalidInput => Failure::new(format!("{shown} can't do {baud} baud"))
            .hint("give the board's own rate with --baud; Stepwright's boards speak 115200"),
        _ => Failure::new(format!("can't open {shown} as a serial port: {error}"))
            .hint("`stepwright ports` lists the ports there are"),
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::io;

    use super::*;

    /// A silent line whose clock advances at every read.
    struct Quick(Cell<Duration>);

    impl Link for Quick {
        fn write(&mut self, _: &[u8]) -> io::Result<()> {
            Ok(())
        }

        fn read(&mut self, _: &mut [u8], _: Duration) -> io::Result<usize> {
            Ok(0)
        }

        fn now(&self) -> Duration {
            self.0.set(self.0.get() + Duration::from_millis(160));
            self.0.get()
        }

        fn name(&self) -> String {
            "the quick board".to_owned()
        }
    }

    #[test]
    fn a_greeting_is_waited_for_until_its_deadline_has_passed() {
        let mut session = Session::new(Box::new(Quick(Cell::default())));
        assert_eq!(greeting(&mut session), None);
    }
}
