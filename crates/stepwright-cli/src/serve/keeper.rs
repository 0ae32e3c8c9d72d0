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

use stepwright_protocol::{AxisId, Command, LeaseMillis, Selection};
use stepwright_serve::report::{LiveAxis, LiveState, Trouble};
use stepwright_serve::{Declined, Hand, ServeDesk};
use stepwright_sim::Description;

use super::sheet;
use super::sight::Watched;
use super::tap::Tap;
use crate::board::bench::{Bench, Width};
use crate::board::recording::Recording;
use crate::failure::Failure;
use crate::interrupt;
use crate::link::Link;
use crate::link::serial::{SerialLink, Share};
use crate::link::virtual_board::VirtualLink;
use crate::order::drive;
use crate::order::target::{self, PortArgs};
use crate::session::{LinkError, Session};

/// Between two looks at axes that move, and that rest.
const LOOK: Duration = Duration::from_millis(20);
const IDLE: Duration = Duration::from_millis(100);

/// Between two looks at everything.
const ALL: Duration = Duration::from_millis(500);

/// Between two attempts to meet a board that is gone.
const AGAIN: Duration = Duration::from_millis(500);

/// Keeps a board.
pub struct Keeper {
    port: PortArgs,
    unit: (&'static str, f64),
    pub(super) desk: Arc<ServeDesk>,
    pub(super) session: Session,
    pub(super) axes: Vec<Watched>,
    /// Whether the board brakes by itself when we fall silent.
    pub(super) leased: bool,
    /// What is told but for the axes and the time.
    pub(super) told: LiveState,
}

/// Opens the way to the board and meets it.
fn open(port: &PortArgs, desk: &Arc<ServeDesk>) -> Result<Session, Failure> {
    let link: Box<dyn Link> = match &port.port {
        Some(path) => Box::new(SerialLink::open(path, port.baud, Share::Host)?),
        None => {
            let description = Description::uno();
            let recording = Recording::begin(&description, None, None)?;
            Box::new(VirtualLink::new(Bench::new(description, Width::Narrow, recording), false))
        }
    };
    let mut session = Session::new(Box::new(Tap::new(link, desk.clone())));
    #[cfg(unix)]
    if let Some(path) = &port.port {
        session.serve(path);
    }
    target::met(&mut session)?;
    Ok(session)
}

impl Keeper {
    /// Meets the board.
    pub fn begin(
        port: PortArgs,
        unit: (&'static str, f64),
        desk: Arc<ServeDesk>,
    ) -> Result<Keeper, Failure> {
        let session = open(&port, &desk)?;
        let (axes, told) = (Vec::new(), LiveState::default());
        let mut keeper = Keeper { port, unit, desk, session, axes, leased: false, told };
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
            let moving = self.axes.iter().any(|axis| axis.moving);
            let pause = if moving { LOOK } else { IDLE };
            if let Some(job) = self.desk.next(pause.saturating_sub(looked.elapsed())) {
                self.carry_out(job)?;
            }
            // What other stepwrights ask through us.
            self.session.pause(Duration::ZERO)?;
            while let Some(line) = self.session.next_change() {
                self.desk.note(format!("another terminal says {line}"));
                self.desk.unplan(AxisId::FIRST.number());
            }
            self.brake_lost_hands()?;
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
            self.publish();
        }
    }

    /// Brakes everything, and waits until it rests.
    fn leave(&mut self) -> Result<(), LinkError> {
        self.desk.close(Declined::away("the server is ending"));
        if self.session.is_busy(Selection::All)? {
            crate::say::note(interrupt::braking());
            drive::brake(&mut self.session, Selection::All)?;
        }
        while self.session.is_busy(Selection::All)? {
            self.session.pause(drive::POLL)?;
        }
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
        let sheet = sheet::of(&mut self.session, self.unit)?;
        let count = sheet.axes.len() as u8;
        if self.axes.len() != sheet.axes.len() {
            self.axes = AxisId::first(count).map(Watched::new).collect();
        }
        self.told.sheet += 1;
        self.told.connected = true;
        self.told.trouble = None;
        self.desk.describe(sheet);
        Ok(())
    }

    /// Has the board brake by itself if we fall silent; and no longer.
    pub(super) fn end_lease(&mut self) -> Result<(), LinkError> {
        if self.leased && self.axes.iter().all(|axis| axis.hand.is_none()) {
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
            if hand.is_some_and(|hand: Hand| !self.desk.is_live(hand)) {
                drive::brake(&mut self.session, Selection::One(id))?;
                self.axes[place].hand = None;
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
        self.desk.close(Declined::away(what.clone()).remedy(remedy));
        self.desk.note(what.clone());
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
            if let Ok(session) = open(&self.port, &self.desk) {
                self.session = session;
                let ran: Vec<_> = self.axes.iter().filter(|axis| axis.hand.is_some()).collect();
                let ran: Vec<_> = ran.iter().map(|axis| axis.id).collect();
                self.axes.clear();
                let mut back = self.learn();
                // Nobody has held it meanwhile.
                for axis in ran {
                    let brake = |()| drive::brake(&mut self.session, Selection::One(axis));
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
