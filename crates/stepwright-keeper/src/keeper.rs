//! Keeps the conversation with a board, from the first contact to the last.
//!
//! ```text
//!   begin ─► turn: a job, changes by others, lost hands, homing, looks ─► turn …
//!               │ LinkError                     │ leave
//!               ▼                               ▼
//!             lose ─► the board is back: begin  everything brakes, and rests
//! ```
//!
//! The caller waits between two turns: for a job, or until the next look is due.

use std::sync::Arc;
use std::time::Duration;

use stepwright_host::motion::POLL;
use stepwright_host::{Conversation, LinkError};
use stepwright_protocol::{AxisId, Command, LeaseMillis, Selection, Setting};

use crate::jobs::Job;
use crate::pulses::PlannedPins;
use crate::report::{BoardSheet, LiveAxis, LiveState, MachineSheet, PlannedCurve, Trouble};
use crate::sight::Watched;
use crate::waits::WaitingJob;
use crate::{Declined, Hand, homing, sheet};

/// The time between two looks at axes that move, and at axes that rest, in s.
const LOOK: f64 = 0.02;
const IDLE: f64 = 0.1;

/// The time between two looks at everything, in s.
const ALL: f64 = 0.5;

/// Anything that is due within this time, in s, counts as due: a clock may stand still between two turns.
const MOMENT: f64 = 1e-6;

/// The link between a keeper and its callers.
pub trait KeeperDesk {
    /// Seconds since the desk was made.
    fn time(&self) -> f64;

    /// Whether a stop or a kill waits. Looks are cut short for it.
    fn is_urgent(&self) -> bool;

    /// Whether this hand has control, and was heard from recently or waits for an answer.
    fn is_there(&self, hand: Hand) -> bool;

    /// Whether this hand has control, and was heard from recently.
    fn is_live(&self, hand: Hand) -> bool;

    /// Reports the board's description.
    fn describe(&self, sheet: BoardSheet);

    /// Reports the board's state.
    fn publish(&self, state: LiveState);

    /// Reports a note for users.
    fn note(&self, text: String);

    /// Reports the planned course of an axis.
    fn plan(&self, curve: PlannedCurve);

    /// Reports that the plan of this axis is no longer valid.
    fn unplan(&self, axis: u8);
}

/// The board to keep.
pub struct KeptBoard {
    /// The name of the board.
    pub name: String,
    /// The units of axes' positions: the name, and the steps per unit. Other axes are shown in steps.
    pub units: Vec<(AxisId, (&'static str, f64))>,
    /// How far the limit switches of axes may be, in steps, from the machine file.
    pub home_within: Vec<(AxisId, u32)>,
    /// The machine file.
    pub machine: Option<MachineSheet>,
    /// How long the board may hear nothing from here before it brakes by itself, while an axis runs endlessly
    /// or is homed.
    pub lease: LeaseMillis,
    /// Whether the lease also covers travels that end by themselves: for a program whose motors are to rest
    /// when it dies.
    pub leases_travels: bool,
}

/// The keeper of a board.
pub struct Keeper<D> {
    pub(crate) board: KeptBoard,
    pub(crate) desk: Arc<D>,
    /// The planned pulses.
    pub(crate) pulses: Arc<PlannedPins>,
    pub(crate) axes: Vec<Watched>,
    /// Axes that ran for a hand when the board was lost, and that were not braked yet.
    ran: Vec<AxisId>,
    /// Requests whose answer waits for the end of their order.
    pub(crate) waiting: Vec<WaitingJob>,
    /// Whether the board has a lease, and brakes by itself when it hears nothing.
    pub(crate) leased: bool,
    /// The reported state, without the axes and the time.
    pub(crate) told: LiveState,
    /// When the moving axes were last looked at, and when all of them were.
    looked: f64,
    looked_at_all: f64,
}

impl<D: KeeperDesk> Keeper<D> {
    /// A keeper of a board that was not met yet.
    pub fn new(desk: Arc<D>, board: KeptBoard) -> Keeper<D> {
        let (axes, ran, waiting) = (Vec::new(), Vec::new(), Vec::new());
        let told = LiveState::default();
        let pulses = Arc::new(PlannedPins::default());
        let (looked, looked_at_all) = (0.0, 0.0);
        let leased = false;
        Keeper { board, desk, pulses, axes, ran, waiting, leased, told, looked, looked_at_all }
    }

    /// The planned pulses: all that is known about the pins of a board at the end of a line.
    pub fn pulses(&self) -> Arc<PlannedPins> {
        self.pulses.clone()
    }

    /// Begins with a board that was met, or met again: looks at all of it. Axes that ran when the board was
    /// lost are braked, as nobody controlled them meanwhile.
    ///
    /// # Errors
    /// The board is silent, or its line is gone.
    pub async fn begin(&mut self, talk: &mut Conversation) -> Result<(), LinkError> {
        let ran = self.axes.drain(..).filter(|axis| axis.hand.is_some());
        self.ran.extend(ran.map(|axis| axis.id));
        let again = self.told.trouble.is_some();
        self.learn(talk).await?;
        // It may be another board, with fewer axes.
        self.ran.retain(|ran| self.axes.iter().any(|axis| axis.id == *ran));
        // The board may be lost again meanwhile.
        while let Some(&axis) = self.ran.last() {
            talk.stop(Selection::One(axis)).await?;
            self.ran.pop();
        }
        self.look_at_all(talk).await?;
        if again {
            self.desk.note(format!("{} is back", self.board.name));
        }
        self.told.connected = true;
        self.told.trouble = None;
        self.publish();
        Ok(())
    }

    /// Leaves the board: answers the requests that wait for it.
    pub fn leave(&mut self) {
        self.give_up_waiting("the board was left");
    }

    /// Keeps another board from now on.
    pub fn keep(&mut self, name: String) {
        self.axes.clear();
        self.ran.clear();
        (self.board.name, self.leased) = (name, false);
        (self.told.connected, self.told.trouble) = (false, None);
    }

    /// Does all work that is due: this job, and the looks. Returns how long the caller may wait for a job
    /// before the next turn.
    ///
    /// # Errors
    /// The conversation has ended: call [`lose`](Keeper::lose).
    pub async fn turn(
        &mut self,
        talk: &mut Conversation,
        job: Option<Job>,
    ) -> Result<Duration, LinkError> {
        if let Some(job) = job {
            self.carry_out(talk, job).await?;
        }
        self.take_changes(talk).await?;
        self.brake_lost_hands(talk).await?;
        self.go_on_homing(talk).await?;
        let moving = self.axes.iter().any(|axis| axis.moving || axis.homing.is_some());
        let pause = if moving { LOOK } else { IDLE };
        let left = pause - (self.desk.time() - self.looked);
        if left >= MOMENT || self.desk.is_urgent() {
            return Ok(Duration::try_from_secs_f64(left).unwrap_or_default());
        }
        self.looked = self.desk.time();
        let all = self.looked - self.looked_at_all >= ALL;
        if all || !moving && talk.is_busy(Selection::All).await? {
            self.looked_at_all = self.looked;
            self.look_at_all(talk).await?;
        } else {
            self.look(talk).await?;
        }
        if !self.desk.is_urgent() {
            self.settle(talk).await?;
        }
        self.publish();
        let left = pause - (self.desk.time() - self.looked);
        Ok(Duration::try_from_secs_f64(left).unwrap_or_default())
    }

    /// Handles the lines of other programs.
    async fn take_changes(&mut self, talk: &mut Conversation) -> Result<(), LinkError> {
        talk.pause(Duration::ZERO).await?;
        while let Some(change) = talk.next_change() {
            self.desk.note(format!("another terminal: {change}"));
            if matches!(change.command, Command::Stop | Command::Kill) {
                for axis in self.give_up_homing(Selection::All, &homing::stopped()) {
                    talk.stop(Selection::One(axis)).await?;
                }
            }
            for axis in self.axes.iter_mut().filter(|axis| change.axes.contains(axis.id)) {
                if let Command::Retarget(_) = change.command {
                    axis.target = talk.new_target(axis.id).or(axis.target);
                }
                self.desk.unplan(axis.id.number());
            }
        }
        Ok(())
    }

    /// Brakes all moving axes, and ends the lease. Returns whether anything moved.
    ///
    /// # Errors
    /// The board is silent, or its line is gone.
    pub async fn let_go(&mut self, talk: &mut Conversation) -> Result<bool, LinkError> {
        let moving = talk.is_busy(Selection::All).await?;
        if moving {
            talk.stop(Selection::All).await?;
        }
        self.give_up_homing(Selection::All, &homing::stopped());
        self.axes.iter_mut().for_each(|axis| axis.hand = None);
        self.end_lease(talk).await?;
        Ok(moving)
    }

    /// Waits until everything rests that was [let go](Keeper::let_go), and answers the requests that waited for
    /// it.
    ///
    /// # Errors
    /// The board is silent, or its line is gone.
    pub async fn rest(&mut self, talk: &mut Conversation) -> Result<(), LinkError> {
        while talk.is_busy(Selection::All).await? {
            talk.pause(POLL).await?;
        }
        self.look_at_all(talk).await?;
        self.settle(talk).await
    }

    /// Whether an axis moved at the last look.
    pub fn is_moving(&self) -> bool {
        self.axes.iter().any(|axis| axis.moving)
    }

    /// Asks the board for its description.
    pub(crate) async fn learn(&mut self, talk: &mut Conversation) -> Result<(), LinkError> {
        let sheet = sheet::of(talk, &self.board).await?;
        let count = sheet.axes.len() as u8;
        if self.axes.len() != sheet.axes.len() {
            self.axes = AxisId::first(count).map(Watched::new).collect();
        }
        let pulse = sheet.settings.iter().find(|one| one.name == Setting::Pulse.name());
        self.pulses.describe(count, pulse.map_or(Setting::Pulse.default(), |one| one.value));
        self.told.sheet += 1;
        self.desk.describe(sheet);
        Ok(())
    }

    /// Ends the lease, unless an axis still needs it.
    pub(crate) async fn end_lease(&mut self, talk: &mut Conversation) -> Result<(), LinkError> {
        let travels = self.board.leases_travels;
        let is_free = |axis: &Watched| {
            axis.hand.is_none() && axis.homing.is_none() && !(travels && axis.moving)
        };
        if self.leased && self.axes.iter().all(is_free) {
            talk.ask(Command::Lease(LeaseMillis::SMALLEST)).await?;
            self.leased = false;
        }
        Ok(())
    }

    /// Brakes the axes that run for a hand which is no longer heard from.
    async fn brake_lost_hands(&mut self, talk: &mut Conversation) -> Result<(), LinkError> {
        for place in 0..self.axes.len() {
            let Some(axis) = self.axes.get_mut(place) else { continue };
            let (id, hand) = (axis.id, axis.hand);
            // A homing ends by itself: for it, a hand that waits for an answer counts as present.
            let homes = axis.homing.is_some();
            let is_gone = |hand: Hand| match homes {
                true => !self.desk.is_there(hand),
                false => !self.desk.is_live(hand),
            };
            if hand.is_some_and(is_gone) {
                talk.stop(Selection::One(id)).await?;
                axis.hand = None;
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

    /// Handles the end of the conversation: answers all requests that wait, and returns the reason.
    pub fn lose(&mut self, trouble: &LinkError) -> Declined {
        let what = format!("{}: {trouble}", self.board.name);
        let remedy = "look at its cable and its power; it is met again when it is back";
        let why = Declined::away(what.clone()).remedy(remedy);
        if self.told.connected || self.told.trouble.is_none() {
            self.desk.note(what.clone());
        }
        self.give_up_homing(Selection::All, &why);
        self.give_up_waiting(&what);
        self.told.connected = false;
        self.told.trouble = Some(Trouble { what, remedy: Some(remedy.to_owned()) });
        self.leased = false;
        self.publish();
        why
    }

    /// Publishes the present state.
    pub fn publish(&self) {
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
