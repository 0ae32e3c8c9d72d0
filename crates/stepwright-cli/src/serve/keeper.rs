//! Keeps the conversation with the board, from the first word to the last.
//!
//! ```text
//!   begin ─► attend: jobs, looks, lost hands ──► lost ─► meet again ─► attend …
//!                │ Ctrl-C                          │ Ctrl-C
//!                ▼                                 ▼
//!              brake everything, rest ──────────► end
//! ```

use std::sync::Arc;
use std::time::{Duration, Instant};

use stepwright_protocol::{AxisId, Command, LeaseMillis, Selection, Setting};
use stepwright_serve::report::{BoardSheet, LiveAxis, LiveState, MachineSheet, Trouble};
use stepwright_serve::{Declined, Hand, ServeDesk};
use stepwright_sim::{AxisDrive, Description, Switch};

use super::pulses::PlannedPins;
use super::sight::Watched;
use super::tap::Tap;
use super::waits::Waiting;
use super::{homing, sheet};
use crate::board::bench::{Bench, Width};
use crate::board::edge_files::EdgePaths;
use crate::board::edges::EdgeStore;
use crate::board::recording::Recording;
use crate::failure::Failure;
use crate::interrupt;
use crate::order::target::{self, PortArgs};
use stepwright_host::link::Link;
use stepwright_host::link::serial::Share;
use stepwright_host::link::simulated::VirtualLink;
use stepwright_host::motion::POLL;
use stepwright_host::{LinkError, Session};

/// Between two looks at axes that move, and that rest.
const LOOK: Duration = Duration::from_millis(20);
const IDLE: Duration = Duration::from_millis(100);

/// Between two looks at everything.
const ALL: Duration = Duration::from_millis(500);

/// Between two attempts to meet a board that is gone.
const AGAIN: Duration = Duration::from_millis(500);

/// Which board is served.
pub struct ServedBoard {
    /// Its port, or a virtual board's absence of one.
    pub port: PortArgs,
    /// The unit of its positions, and the steps of one.
    pub unit: (&'static str, f64),
    /// The limit switches of a virtual machine.
    pub switches: Vec<Switch>,
    /// What its motors are on that have coils.
    pub drives: Vec<AxisDrive>,
    /// How far the limit switches of axes may be, in steps, by the machine file.
    pub home_within: Vec<(AxisId, u32)>,
    /// What stands in the machine file.
    pub machine: Option<MachineSheet>,
}

/// Keeps a board.
pub struct Keeper {
    pub(super) board: ServedBoard,
    pub(super) desk: Arc<ServeDesk>,
    pub(super) session: Session,
    /// What the scope shows of a board whose edges are not seen.
    pub(super) pulses: Arc<PlannedPins>,
    pub(super) axes: Vec<Watched>,
    /// The requests whose answer waits for the end of their order.
    pub(super) waiting: Vec<Waiting>,
    /// Whether the board brakes by itself when we fall silent.
    pub(super) leased: bool,
    /// What is told but for the axes and the time.
    pub(super) told: LiveState,
}

/// Opens the way to the board and meets it.
fn open(board: &ServedBoard, desk: &Arc<ServeDesk>) -> Result<Session, Failure> {
    let port = &board.port;
    let link: Box<dyn Link> = match &port.port {
        Some(path) => Box::new(target::serial(path, port.baud, Share::Host)?),
        None => {
            let description = Description::uno().with_drives(&board.drives);
            let edges = EdgeStore::new(&description);
            desk.probe(Arc::new(edges.clone()));
            let recording = Recording::begin(&description, EdgePaths::default(), None)?.keep(edges);
            let bench = Bench::new(description, Width::Narrow, recording);
            Box::new(VirtualLink::new(bench.with_switches(&board.switches), false))
        }
    };
    let mut session = target::conversation(Box::new(Tap::new(link, desk.clone())));
    if let Some(path) = &port.port {
        target::let_in(&mut session, path);
    }
    target::met(&mut session)?;
    Ok(session)
}

impl Keeper {
    /// Meets the board.
    pub fn begin(board: ServedBoard, desk: Arc<ServeDesk>) -> Result<Keeper, Failure> {
        let session = open(&board, &desk)?;
        let (axes, waiting, told) = (Vec::new(), Vec::new(), LiveState::default());
        let pulses = Arc::new(PlannedPins::default());
        if board.port.port.is_some() {
            desk.probe(pulses.clone());
        }
        let mut keeper =
            Keeper { board, desk, session, pulses, axes, waiting, leased: false, told };
        let begun = keeper.learn().and_then(|()| keeper.look_at_all());
        begun.map_err(|trouble| target::lost(&keeper.session.name(), &trouble))?;
        keeper.publish();
        Ok(keeper)
    }

    /// Keeps the board until Ctrl-C, or another signal.
    pub fn keep(mut self) -> Result<(), Failure> {
        loop {
            let trouble = match self.attend() {
                Ok(()) => return target::finish(&mut self.session),
                Err(trouble) => trouble,
            };
            if matches!(trouble, LinkError::Killed) {
                return self.kill();
            }
            let moving = self.axes.iter().any(|axis| axis.moving);
            self.lose(&trouble);
            if !self.meet_again() {
                let name = self.session.name();
                let failure = target::lost(&name, &trouble);
                return Err(if moving {
                    failure.hint("a motor may still be moving: look at it")
                } else {
                    failure
                });
            }
        }
    }

    /// Does what there is to do until the end is asked for.
    fn attend(&mut self) -> Result<(), LinkError> {
        let mut all = Instant::now();
        self.look_at_all()?;
        self.publish();
        let mut looked = Instant::now();
        loop {
            if interrupt::asked() {
                return self.leave();
            }
            let moving = self.axes.iter().any(|axis| axis.moving || axis.homing.is_some());
            let pause = if moving { LOOK } else { IDLE };
            if let Some(job) = self.desk.next(pause.saturating_sub(looked.elapsed())) {
                self.carry_out(job)?;
            }
            // What other stepwrights ask through us.
            self.session.pause(Duration::ZERO)?;
            while let Some(change) = self.session.next_change() {
                self.desk.note(format!("another terminal: {change}"));
                if matches!(change.command, Command::Stop | Command::Kill) {
                    for axis in self.give_up_homing(Selection::All, &homing::stopped()) {
                        self.session.stop(Selection::One(axis))?;
                    }
                }
                for axis in self.axes.iter_mut().filter(|axis| change.axes.contains(axis.id)) {
                    axis.target = change.target.or(axis.target);
                }
                self.desk.unplan(AxisId::FIRST.number());
            }
            self.brake_lost_hands()?;
            self.go_on_homing()?;
            if looked.elapsed() < pause || self.desk.is_urgent() {
                continue;
            }
            looked = Instant::now();
            if all.elapsed() >= ALL || !moving && self.session.is_busy(Selection::All)? {
                all = Instant::now();
                self.look_at_all()?;
            } else {
                self.look()?;
            }
            if !self.desk.is_urgent() {
                self.settle()?;
            }
            self.publish();
        }
    }

    /// Brakes everything, and waits until it rests.
    fn leave(&mut self) -> Result<(), LinkError> {
        self.desk.close(Declined::away("the server is ending"));
        if self.session.is_busy(Selection::All)? {
            crate::say::note(interrupt::braking());
            self.session.stop(Selection::All)?;
        }
        while self.session.is_busy(Selection::All)? {
            self.session.pause(POLL)?;
        }
        self.look_at_all()?;
        self.settle()?;
        self.end_lease()
    }

    fn kill(&mut self) -> Result<(), Failure> {
        match self.session.kill() {
            Ok(true) => Err(Failure::interrupted("killed: a motor that moved may have lost steps")),
            _ => Err(Failure::interrupted("the board did not confirm K")
                .hint("a motor may still be moving: switch off its power")),
        }
    }

    /// Asks the board what it is.
    pub(super) fn learn(&mut self) -> Result<(), LinkError> {
        let sheet = sheet::of(&mut self.session, self.board.unit)?;
        let mut sheet = BoardSheet { machine: self.board.machine.clone(), ..sheet };
        for (axis, within) in &self.board.home_within {
            if let Some(axis) = sheet.axes.get_mut(axis.index()) {
                axis.home_within = Some(*within);
            }
        }
        let count = sheet.axes.len() as u8;
        if self.axes.len() != sheet.axes.len() {
            self.axes = AxisId::first(count).map(Watched::new).collect();
        }
        let pulse = sheet.settings.iter().find(|one| one.name == Setting::Pulse.name());
        self.pulses.describe(count, pulse.map_or(Setting::Pulse.default(), |one| one.value));
        self.told.sheet += 1;
        self.told.connected = true;
        self.told.trouble = None;
        self.desk.describe(sheet);
        Ok(())
    }

    /// Has the board brake by itself if we fall silent; and no longer.
    pub(super) fn end_lease(&mut self) -> Result<(), LinkError> {
        let is_free = |axis: &Watched| axis.hand.is_none() && axis.homing.is_none();
        if self.leased && self.axes.iter().all(is_free) {
            self.session.ask(Command::Lease(LeaseMillis::SMALLEST))?;
            self.leased = false;
        }
        Ok(())
    }

    /// Brakes what runs for a hand that is not heard of any more.
    fn brake_lost_hands(&mut self) -> Result<(), LinkError> {
        for place in 0..self.axes.len() {
            let Some(axis) = self.axes.get(place) else { continue };
            let (id, hand) = (axis.id, axis.hand);
            // A homing ends by itself: for it, who waits for the answer is there.
            let homes = axis.homing.is_some();
            let is_gone = |hand: Hand| match homes {
                true => !self.desk.is_there(hand),
                false => !self.desk.is_live(hand),
            };
            if hand.is_some_and(is_gone) {
                self.session.stop(Selection::One(id))?;
                self.axes[place].hand = None;
                self.end_homing(id, &homing::gone());
                self.desk.unplan(id.number());
                self.desk.note(format!(
                    "axis {} brakes: the page that ran it is gone, or gave control away",
                    id.number()
                ));
            }
        }
        Ok(())
    }

    fn lose(&mut self, trouble: &LinkError) {
        let name = self.session.name();
        let what = format!("{name}: {trouble}");
        let remedy = "look at its cable and its power; it is met again when it is back";
        let why = Declined::away(what.clone()).remedy(remedy);
        self.desk.close(why.clone());
        self.desk.note(what.clone());
        self.give_up_homing(Selection::All, &why);
        self.give_up_waiting(&what);
        self.told.connected = false;
        self.told.trouble = Some(Trouble { what, remedy: Some(remedy.to_owned()) });
        self.leased = false;
        self.publish();
    }

    /// Waits until the board is back; false if the end is asked for before.
    fn meet_again(&mut self) -> bool {
        loop {
            let tried = Instant::now();
            while tried.elapsed() < AGAIN {
                if interrupt::asked() {
                    return false;
                }
                self.publish();
                std::thread::sleep(IDLE);
            }
            if let Ok(session) = open(&self.board, &self.desk) {
                self.session = session;
                let ran: Vec<_> = self.axes.iter().filter(|axis| axis.hand.is_some()).collect();
                let ran: Vec<_> = ran.iter().map(|axis| axis.id).collect();
                self.axes.clear();
                let mut back = self.learn();
                // Nobody has held it meanwhile.
                for axis in ran {
                    let brake = |()| self.session.stop(Selection::One(axis));
                    back = back.and_then(brake);
                }
                if back.is_ok() {
                    self.desk.note(format!("{} is back", self.session.name()));
                    self.desk.open();
                    return true;
                }
                self.told.connected = false;
            }
        }
    }

    /// Tells what is known.
    pub(super) fn publish(&self) {
        let connected = self.told.connected;
        let time = self.desk.time();
        let state = |axis: &Watched| match connected {
            true => axis.state(time),
            false => LiveAxis { position: None, moving: false, state: "lost", ..axis.state(time) },
        };
        let axes = self.axes.iter().map(state).collect();
        self.desk.publish(LiveState { axes, ..self.told.clone() });
    }
}
