//! The board's thread: its line, and a [`Keeper`] that runs on it.
//!
//! ```text
//!   open ─► turn, wait for a job, turn … ──► lost ─► open again ─► turn …
//!               │ Ctrl-C                       │ Ctrl-C
//!               ▼                              ▼
//!             everything brakes, and rests ──► end
//! ```

use std::sync::Arc;
use std::time::{Duration, Instant};

use stepwright_host::link::Link;
use stepwright_host::link::bench::{Bench, TimerWidth};
use stepwright_host::link::serial::Share;
use stepwright_host::link::simulated::VirtualLink;
use stepwright_host::{LinkError, Session};
use stepwright_keeper::report::MachineSheet;
use stepwright_keeper::scope::LONGEST;
use stepwright_keeper::{Declined, Keeper, KeptBoard};
use stepwright_play::edges::EdgeStore;
use stepwright_protocol::{AxisId, LeaseMillis};
use stepwright_serve::ServeDesk;
use stepwright_sim::{AxisDrive, Description, Switch};

use super::tap::TappedLink;
use crate::failure::Failure;
use crate::interrupt;
use crate::order::target::{self, PortArgs};

/// The lease while an axis runs without end: the board brakes if it hears nothing from the server
/// for this time.
const LEASE: LeaseMillis = LeaseMillis::clamped(1000);

/// The number of edges of a virtual board that are kept: 10 s of one axis at 10,000 steps/s.
const KEPT: usize = 200_000;

/// The time between two attempts to connect to a lost board.
const AGAIN: Duration = Duration::from_millis(500);

/// The time between two checks for Ctrl-C meanwhile.
const IDLE: Duration = Duration::from_millis(100);

/// The board to serve.
pub struct ServedBoard {
    /// The port; none for a virtual board.
    pub port: PortArgs,
    /// For each axis, the unit of its positions and the steps of one unit.
    pub units: Vec<(AxisId, (&'static str, f64))>,
    /// The limit switches of a virtual machine.
    pub switches: Vec<Switch>,
    /// The drives of motors with coils.
    pub drives: Vec<AxisDrive>,
    /// The greatest distance to the limit switch of each axis, in steps, by the machine file.
    pub home_within: Vec<(AxisId, u32)>,
    /// The content of the machine file.
    pub machine: Option<MachineSheet>,
}

/// The state of the board's thread, without the session, which ends when the board is lost.
pub struct BoardThread {
    board: ServedBoard,
    desk: Arc<ServeDesk>,
    keeper: Keeper<ServeDesk>,
}

/// Opens the link to the board and connects to it.
fn open(board: &ServedBoard, desk: &Arc<ServeDesk>) -> Result<Session, Failure> {
    let port = &board.port;
    let link: Box<dyn Link> = match &port.port {
        Some(path) => Box::new(target::serial(path, port.baud, Share::Host)?),
        None => {
            let description = Description::uno().with_drives(&board.drives);
            let hz = description.board.rate.hz();
            let edges = EdgeStore::new(hz, KEPT, description.pins());
            let edges = edges.with_enable().for_seconds(LONGEST);
            desk.probe(Arc::new(edges.clone()));
            let bench = Bench::new(description, TimerWidth::Narrow, edges);
            Box::new(VirtualLink::new(bench.with_switches(&board.switches), false))
        }
    };
    let mut session = target::conversation(Box::new(TappedLink::new(link, desk.clone())));
    if let Some(path) = &port.port {
        target::let_in(&mut session, path);
    }
    target::met(&mut session)?;
    Ok(session)
}

impl BoardThread {
    /// Connects to the board.
    pub fn begin(
        board: ServedBoard,
        desk: Arc<ServeDesk>,
    ) -> Result<(BoardThread, Session), Failure> {
        let mut session = open(&board, &desk)?;
        let kept = KeptBoard {
            name: session.name(),
            units: board.units.clone(),
            home_within: board.home_within.clone(),
            machine: board.machine.clone(),
            lease: LEASE,
            leases_travels: false,
        };
        let mut keeper = Keeper::new(desk.clone(), kept);
        if board.port.port.is_some() {
            desk.probe(keeper.pulses());
        }
        let begun = session.wait(async |talk| keeper.begin(talk).await).and_then(|begun| begun);
        begun.map_err(|trouble| target::lost(&session.name(), &trouble))?;
        Ok((BoardThread { board, desk, keeper }, session))
    }

    /// Serves the board until Ctrl-C or another signal.
    pub fn keep(mut self, mut session: Session) -> Result<(), Failure> {
        loop {
            let trouble = match self.attend(&mut session) {
                Ok(()) => return target::finish(&mut session),
                Err(trouble) => trouble,
            };
            if matches!(trouble, LinkError::Killed) {
                return kill(&mut session);
            }
            let moving = self.keeper.is_moving();
            self.desk.close(self.keeper.lose(&trouble));
            let name = session.name();
            // Closes the port, which can't be opened again before. It is still there if the board
            // is only silent.
            drop(session);
            session = self.meet_again().ok_or_else(|| {
                let failure = target::lost(&name, &trouble);
                match moving {
                    true => failure.hint("a motor may still be moving: look at it"),
                    false => failure,
                }
            })?;
        }
    }

    /// Carries out jobs until the server is to end.
    fn attend(&mut self, session: &mut Session) -> Result<(), LinkError> {
        let mut pause = Duration::ZERO;
        while !interrupt::asked() {
            let job = self.desk.next(pause);
            let keeper = &mut self.keeper;
            pause = session.wait(async |talk| keeper.turn(talk, job).await)??;
        }
        self.desk.close(Declined::away("the server is ending"));
        let keeper = &mut self.keeper;
        if session.wait(async |talk| keeper.let_go(talk).await)?? {
            crate::say::note(interrupt::braking());
        }
        session.wait(async |talk| keeper.rest(talk).await)?
    }

    /// Waits until the board is back; `None` if the server is to end before.
    fn meet_again(&mut self) -> Option<Session> {
        loop {
            let tried = Instant::now();
            while tried.elapsed() < AGAIN {
                if interrupt::asked() {
                    return None;
                }
                self.keeper.publish();
                std::thread::sleep(IDLE);
            }
            let Ok(mut session) = open(&self.board, &self.desk) else { continue };
            let keeper = &mut self.keeper;
            let begun = session.wait(async |talk| keeper.begin(talk).await);
            if begun.and_then(|begun| begun).is_ok() {
                self.desk.open();
                return Some(session);
            }
        }
    }
}

fn kill(session: &mut Session) -> Result<(), Failure> {
    match session.kill() {
        Ok(true) => Err(Failure::interrupted("killed: a motor that moved may have lost steps")),
        _ => Err(Failure::interrupted("the board did not confirm K")
            .hint("a motor may still be moving: switch off its power")),
    }
}
