//! Homes an axis while the keeper goes on with its other work: [`SwitchHoming`] returns the next act, and this
//! module carries it out.

use std::time::Duration;

use stepwright_host::homing::{
    BegunLeg, HomeLeg, HomeOrder, HomingAct, HomingEvent, HomingFailure, SwitchHoming, SwitchSide,
};
use stepwright_host::motion::{NotBegun, POLL};
use stepwright_host::{Conversation, LinkError};
use stepwright_protocol::{
    AxisId, BoardError, Command, Distance, Info, Refusal, Reply, Selection, Stop, Travel,
};

use crate::keeper::{Keeper, KeeperDesk};
use crate::orders::{Begins, SaidLines, Undone};
use crate::request::home::{HomeLimits, HomeReport, needs_within};
use crate::{Declined, Hand};

/// The homing of an axis.
pub struct AxisHoming {
    course: SwitchHoming,
    /// The hand that has asked for it, and that must stay present.
    pub hand: Hand,
    /// When the leg is to be braked, by the clock of the line.
    until: Option<Duration>,
    braked: bool,
    /// When the next attempt is due, by the clock of the desk.
    again: Option<f64>,
    /// Whether the board had no errors before the homing.
    clean: bool,
}

impl AxisHoming {
    fn report(&self) -> HomeReport {
        let (stage, words) = match self.course.leg() {
            HomeLeg::Seek => ("seek", "seeks its switch"),
            HomeLeg::BackOff => ("back-off", "backs off from its switch"),
            HomeLeg::Approach => ("approach", "approaches its switch slowly"),
            HomeLeg::Leave => ("leave", "leaves its switch: 0 is there"),
        };
        HomeReport { stage, words: words.to_owned(), remedy: None }
    }
}

/// The report of a homing that has failed.
fn failed(declined: &Declined) -> HomeReport {
    let remedy = declined.remedy.clone();
    HomeReport { stage: "failed", words: declined.what.clone(), remedy }
}

impl<D: KeeperDesk> Keeper<D> {
    /// Begins to home an axis.
    pub(crate) async fn home(
        &mut self,
        talk: &mut Conversation,
        axis: AxisId,
        limits: HomeLimits,
        hand: Hand,
    ) -> SaidLines {
        self.axis(axis)?;
        let number = axis.number();
        let known = self.board.home_within.iter().find(|(one, _)| *one == axis);
        let within = limits.within.or(known.map(|(_, within)| *within));
        let within = within.ok_or_else(|| needs_within(number))?;
        self.rests(talk, axis, "wait, or stop it").await?;
        let name = &self.board.name;
        let Reply::Settings(listed) = talk.ask(Command::Settings).await? else {
            return Err(Declined::refused(format!("{name} has no settings, and no switch")).into());
        };
        let side = SwitchSide::of(axis, &listed).map_err(|switches| {
            let what = format!("{name} knows of no limit switch of axis {number}");
            Declined::refused(what).remedy(format!(
                "if there is one, the setting `switches` says so: {switches} (1 X, 2 Y, 4 Z, \
                 added up)"
            ))
        })?;
        let any = Travel::By(Distance::new(0));
        let (fast, slow) = (limits.seek.order(any)?, limits.approach.order(any)?);
        let back_off = limits.back_off;
        let course = SwitchHoming::new(HomeOrder { side, fast, slow, back_off, within });
        let info = talk.ask_info().await?;
        let clean = info.is_none_or(|info| info.late == 0 && errors(&info).next().is_none());
        let homing = AxisHoming { course, hand, until: None, braked: false, again: None, clean };
        self.axis(axis)?.homing = Some(homing);
        let begun = self.act(talk, axis, HomingAct::Travel(HomeLeg::Seek)).await;
        if begun.is_err() {
            let watched = self.axis(axis)?;
            (watched.homing, watched.home) = (None, None);
        }
        begun
    }

    /// Refuses other orders while an axis is being homed.
    pub(crate) fn not_homed(&mut self, axis: AxisId) -> Result<(), Undone> {
        if self.axis(axis)?.homing.is_none() {
            return Ok(());
        }
        Err(Declined::refused(format!("axis {} is being homed", axis.number()))
            .remedy("wait, or stop it")
            .into())
    }

    /// Continues the homings in progress.
    pub(crate) async fn go_on_homing(&mut self, talk: &mut Conversation) -> Result<(), LinkError> {
        for place in 0..self.axes.len() {
            // A stop that waits goes first.
            if self.desk.is_urgent() {
                return Ok(());
            }
            let Some(id) = self.axes.get(place).map(|axis| axis.id) else { continue };
            match self.go_on(talk, id).await {
                Ok(()) => {}
                Err(Undone::Lost(trouble)) => return Err(trouble),
                Err(Undone::Declined(declined)) => self.end_homing(id, &declined),
            }
        }
        Ok(())
    }

    async fn go_on(&mut self, talk: &mut Conversation, axis: AxisId) -> Result<(), Undone> {
        let watched = self.axis(axis)?;
        let moving = watched.moving;
        let Some(AxisHoming { again, until, braked, .. }) = watched.homing else { return Ok(()) };
        let event = match again {
            Some(again) if self.desk.time() < again => return Ok(()),
            Some(_) => HomingEvent::Waited,
            None if moving => {
                if !braked && until.is_some_and(|until| talk.now() >= until) {
                    talk.stop(Selection::One(axis)).await?;
                    self.desk.unplan(axis.number());
                    if let Some(homing) = &mut self.axis(axis)?.homing {
                        homing.braked = true;
                    }
                }
                return Ok(());
            }
            None => {
                let position = talk.rest_position(axis).await?;
                let stop = talk.stop_of(axis).await?;
                self.desk.unplan(axis.number());
                HomingEvent::Rests { position, stop, braked }
            }
        };
        let act = self.next_act(axis, event, talk.now())?;
        self.act(talk, axis, act).await.map(drop)
    }

    fn next_act(
        &mut self,
        axis: AxisId,
        event: HomingEvent,
        now: Duration,
    ) -> Result<HomingAct, Undone> {
        let Some(homing) = &mut self.axis(axis)?.homing else {
            return Err(Declined::refused("the homing has ended").into());
        };
        (homing.again, homing.until) = (None, None);
        let act = homing.course.next(event, now).map_err(failure)?;
        if let Some(note) = homing.course.take_note() {
            self.desk.note(format!("axis {}: {note}", axis.number()));
        }
        Ok(act)
    }

    /// Carries out acts until one takes time, and returns the lines that were said.
    async fn act(
        &mut self,
        talk: &mut Conversation,
        axis: AxisId,
        mut act: HomingAct,
    ) -> SaidLines {
        let mut lines = Vec::new();
        loop {
            let event = match act {
                HomingAct::Travel(leg) => match self.begin_leg(talk, axis, leg).await? {
                    Some(said) => {
                        lines.extend(said);
                        return Ok(lines);
                    }
                    None => HomingEvent::Closed,
                },
                HomingAct::Say(line) => {
                    let taken = talk.ask(line).await? == Reply::Yes;
                    if taken && line == Command::Zero(axis) {
                        self.axis(axis)?.shift_origin();
                    }
                    lines.push(line);
                    HomingEvent::Said(taken)
                }
                HomingAct::Wait => {
                    let again = self.desk.time() + POLL.as_secs_f64();
                    if let Some(homing) = &mut self.axis(axis)?.homing {
                        homing.again = Some(again);
                    }
                    return Ok(lines);
                }
                HomingAct::Done(at) => {
                    self.forget_switch(talk, axis).await?;
                    let watched = self.axis(axis)?;
                    watched.homing = None;
                    let words = "homed: 0 is where its switch closes".to_owned();
                    watched.home = Some(HomeReport { stage: "done", words, remedy: None });
                    self.desk.note(format!("axis {} is homed, and stands at {at}", axis.number()));
                    return Ok(lines);
                }
            };
            act = self.next_act(axis, event, talk.now())?;
        }
    }

    /// Clears the board's note that the axis was stopped by its switch, as that was intended, unless there are
    /// other errors as well.
    async fn forget_switch(&mut self, talk: &mut Conversation, axis: AxisId) -> Result<(), Undone> {
        let clean = self.axis(axis)?.homing.as_ref().is_some_and(|homing| homing.clean);
        let Some(info) = talk.ask_info().await?.filter(|_| clean) else { return Ok(()) };
        let by_switch = |axis| info.stops.and_then(|stops| stops.of(axis)) == Some(Stop::Switch);
        let others = AxisId::first(info.axes).any(|other| other != axis && by_switch(other));
        if info.late == 0 && !others && errors(&info).eq([BoardError::Switch]) {
            talk.ask(Command::Clear).await?;
            self.ask_why(talk).await?;
        }
        Ok(())
    }

    /// Begins a leg; `None` if the board refuses it because of a closed switch.
    async fn begin_leg(
        &mut self,
        talk: &mut Conversation,
        axis: AxisId,
        leg: HomeLeg,
    ) -> Result<Option<Vec<Command>>, Undone> {
        let watched = self.axis(axis)?;
        let Some(homing) = &mut watched.homing else { return Ok(Some(Vec::new())) };
        let hand = homing.hand;
        watched.home = Some(homing.report());
        // The page may have gone since the last leg.
        if !self.desk.is_there(hand) {
            return Err(gone().into());
        }
        let from = talk.rest_position(axis).await?;
        let Some(homing) = &mut self.axis(axis)?.homing else { return Ok(Some(Vec::new())) };
        let BegunLeg { order, brakes } = homing.course.begin(from);
        let begins = [Begins { axis, from, order }];
        let lines = match self.set_off(talk, &begins, Some(hand)).await? {
            Ok(lines) => lines,
            Err(NotBegun::Refused(_, Some(Refusal::Fault))) if leg.is_towards() => return Ok(None),
            Err(not) => return Err(self.not_begun(talk, not).await),
        };
        let until = brakes.map(|brakes| talk.now().saturating_add(brakes));
        if let Some(homing) = &mut self.axis(axis)?.homing {
            (homing.until, homing.braked) = (until, false);
        }
        Ok(Some(lines))
    }

    /// Ends the homing of an axis as failed, for this reason.
    pub(crate) fn end_homing(&mut self, axis: AxisId, why: &Declined) {
        let Some(watched) = self.axes.get_mut(axis.index()) else { return };
        if watched.homing.take().is_some() {
            watched.home = Some(failed(why));
            self.desk.note(format!("axis {} is not homed: {}", axis.number(), why.what));
        }
    }

    /// Ends the homings of these axes as failed, for this reason. Returns the axes that were being homed.
    pub(crate) fn give_up_homing(&mut self, axes: Selection, why: &Declined) -> Vec<AxisId> {
        let homed = self.axes.iter().filter(|axis| axis.homing.is_some()).map(|axis| axis.id);
        let homed: Vec<_> = homed.filter(|axis| axes.contains(*axis)).collect();
        homed.iter().for_each(|axis| self.end_homing(*axis, why));
        homed
    }
}

/// Why an axis is not homed, and the remedy.
fn failure(why: HomingFailure) -> Declined {
    let declined = Declined::refused(why.to_string());
    match why {
        HomingFailure::NotFound { .. } => declined
            .remedy("is it wired, and on this side (switch-forward)? Else a larger `within`"),
        HomingFailure::StillClosed { .. } => {
            declined.remedy("back off further, or look at the switch, its wiring and switch-high")
        }
        HomingFailure::Unstopped => declined.remedy("did another master or a reset stop it?"),
        HomingFailure::NotAway => declined.remedy("look what has stopped it"),
        _ => declined,
    }
}

/// The errors of a board.
fn errors(info: &Info) -> impl Iterator<Item = BoardError> + use<> {
    info.errors.into_iter().flat_map(|errors| errors.iter())
}

/// The reason for a homing that was stopped.
pub fn stopped() -> Declined {
    Declined::refused("stopped before 0 was found")
}

/// The reason for a homing whose page is gone.
pub fn gone() -> Declined {
    Declined::refused("the page that homed it is gone, or gave control away")
}
