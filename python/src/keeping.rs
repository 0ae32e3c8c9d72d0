//! The board's thread: it holds the line and runs a [`Keeper`].

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use stepwright_host::link::Link;
use stepwright_host::link::OpenError;
use stepwright_host::link::bench::{Bench, TimerWidth};
#[cfg(unix)]
use stepwright_host::link::lease;
use stepwright_host::link::serial::{SerialLink, Share};
use stepwright_host::link::simulated::VirtualLink;
use stepwright_host::link::tcp::TcpLink;
use stepwright_host::{LinkError, Session};
use stepwright_keeper::{Declined, Keeper, KeptBoard};
use stepwright_play::edges::EdgeStore;
use stepwright_protocol::LeaseMillis;
use stepwright_sim::{Description, Switch};

use crate::desk::{Desk, Met, Next, Probe};

/// The most edges of a recording: 48 MB, or 100 s of an axis at 10,000 steps/s. The oldest are dropped.
const KEPT: usize = 2_000_000;

/// The way to a board.
pub enum Way {
    /// A serial port with this rate in bits/s.
    Port(PathBuf, u32),
    /// `HOST:PORT`.
    Tcp(String),
    /// A virtual board in this process.
    Virtual { fast: bool, switches: Vec<Switch> },
}

/// The remedy for a lost board.
pub const LOST: &str = "look at its cable and its power, and open it again";

/// Keeps a board until the end is requested or the board is lost.
pub fn keep(way: &Way, lease: LeaseMillis, desk: Arc<Desk>) {
    let _end = End(desk.clone());
    let mut session = match open(way, &desk) {
        Ok(session) => session,
        Err(why) => return ended(&desk, Some(why)),
    };
    let board = KeptBoard {
        name: session.name(),
        units: Vec::new(),
        home_within: Vec::new(),
        machine: None,
        lease,
        leases_travels: true,
    };
    let mut keeper = Keeper::new(desk.clone(), board);
    if !matches!(way, Way::Virtual { .. }) {
        desk.probe(Probe::Plans(keeper.pulses()));
    }
    let attended = attend(&mut session, &mut keeper, &desk);
    // A server meets a lost board again. This thread does not.
    let lost = |trouble| keeper.lose(&trouble).remedy(LOST);
    let why = attended.err().map(lost);
    // A program that learns of the end may open the port again.
    drop(session);
    ended(&desk, why);
}

/// Reports a thread that ends in any other way.
struct End(Arc<Desk>);

impl Drop for End {
    fn drop(&mut self) {
        if !matches!(self.0.met(), Met::Ended(_)) {
            ended(&self.0, Some(Declined::away("the thread of the board has failed")));
        }
    }
}

/// Takes no more jobs, and tells those who wait.
fn ended(desk: &Desk, why: Option<Declined>) {
    desk.close(why.clone().unwrap_or_else(closed));
    desk.meets(Met::Ended(why));
}

fn closed() -> Declined {
    Declined::away("the board is closed").remedy("open it again")
}

/// Opens the way to the board and meets the board.
fn open(way: &Way, desk: &Arc<Desk>) -> Result<Session, Declined> {
    let (link, name): (Box<dyn Link>, String) = match way {
        Way::Port(path, baud) => (Box::new(serial(path, *baud, desk)?), path.display().to_string()),
        Way::Tcp(address) => {
            let name = format!("tcp://{address}");
            let link = TcpLink::open(address).map_err(|error| cant(&name, OpenError::Io(error)))?;
            (Box::new(link), name)
        }
        Way::Virtual { fast, switches } => {
            let description = Description::uno();
            let edges = EdgeStore::new(description.board.rate.hz(), KEPT, description.pins());
            edges.end();
            desk.probe(Probe::Pins(edges.clone()));
            let bench = Bench::new(description, TimerWidth::Narrow, edges).with_switches(switches);
            (Box::new(VirtualLink::new(bench, *fast)), "the virtual board".to_owned())
        }
    };
    let mut session = Session::new(Box::new(Clocked { link, desk: desk.clone() }));
    #[cfg(unix)]
    if let Way::Port(path, _) = way
        && let Some(host) = stepwright_host::link::host::Host::open(path)
    {
        session.serve(Box::new(host));
    }
    let watch = desk.clone();
    session.set_guard(Some(Box::new(move |_| watch.leaves().then_some(LinkError::Ended))));
    session.meet().map_err(|trouble| {
        let declined = Declined::away(format!("{name}: {trouble}"));
        match trouble {
            LinkError::Silent => declined.remedy(
                "is it the board's port, at its rate (baud), with Stepwright's program on it?",
            ),
            LinkError::Program(_) => declined.remedy("flash the controller: `stepwright flash`"),
            _ => declined,
        }
    })?;
    session.set_guard(None);
    Ok(session)
}

fn serial(path: &Path, baud: u32, desk: &Arc<Desk>) -> Result<SerialLink, Declined> {
    let name = path.display().to_string();
    #[cfg(unix)]
    let free = |path: &Path| lease::let_run_out(path, |_| (), || desk.leaves());
    #[cfg(not(unix))]
    let free = |_: &Path| {
        let _ = desk;
        stepwright_host::link::serial::LeaseWait::Over
    };
    SerialLink::open(path, baud, Share::Host, free).map_err(|error| cant(&name, error))
}

fn cant(name: &str, error: OpenError) -> Declined {
    let declined = Declined::away(format!("{name}: {error}"));
    match error {
        OpenError::InUse => declined.remedy("another program has it: end that, or ask through it"),
        OpenError::Io(_) if name.starts_with("tcp://") => {
            declined.remedy("is this its HOST:PORT, and does its program listen there?")
        }
        OpenError::Io(_) => declined.remedy("is it plugged in? `stepwright ports` lists them"),
        OpenError::Ended => declined,
    }
}

/// Works until the end is requested. Then brakes, and waits until all motors rest.
fn attend(session: &mut Session, keeper: &mut Keeper<Desk>, desk: &Desk) -> Result<(), LinkError> {
    session.wait(async |talk| keeper.begin(talk).await)??;
    desk.meets(Met::Kept);
    let mut pause = Duration::ZERO;
    loop {
        let job = match desk.next(pause) {
            Next::Turn(job) => job,
            Next::Pass(time) => {
                session.wait(async |talk| talk.pause(time).await)??;
                None
            }
            Next::Leave => break,
        };
        pause = session.wait(async |talk| keeper.turn(talk, job).await)??;
    }
    desk.close(closed());
    session.wait(async |talk| keeper.let_go(talk).await)??;
    session.wait(async |talk| keeper.rest(talk).await)??;
    // No recording of this program is on this line.
    let _ = session.link().finish();
    Ok(())
}

/// A line that reports its clock to the desk.
struct Clocked {
    link: Box<dyn Link>,
    desk: Arc<Desk>,
}

impl Link for Clocked {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.link.write(bytes)
    }

    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        self.link.read(buffer, limit)
    }

    fn now(&self) -> Duration {
        let now = self.link.now();
        self.desk.pass(now);
        now
    }

    fn name(&self) -> String {
        self.link.name()
    }

    fn is_alone(&mut self) -> bool {
        self.link.is_alone()
    }

    fn rest(&mut self, time: Duration) {
        self.link.rest(time);
    }

    fn finish(&mut self) -> io::Result<()> {
        self.link.finish()
    }
}
