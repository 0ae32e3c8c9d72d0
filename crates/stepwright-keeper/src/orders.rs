//! Carries out requests.

use stepwright_host::line::{NEAR, NOTABLE, NoLine, apart, furthest, off, shares};
use stepwright_host::motion::{NotBegun, Start};
use stepwright_host::settings::NoCurves;
use stepwright_host::{Conversation, LinkError};
use stepwright_protocol::{
    Ability, AxisId, Command, Distance, Order, Reply, Script, Selection, Travel,
};

use crate::jobs::Job;
use crate::keeper::{Keeper, KeeperDesk};
use crate::request::line::still;
use crate::request::{Limits, TravelChange, Way};
use crate::sight::Watched;
use crate::{Declined, Hand, Wish, forecast, homing};

/// Why a wish is not carried out.
pub enum Undone {
    /// The caller gets the reason.
    Declined(Declined),
    /// The caller gets the reason, and the conversation can't go on.
    Lost(LinkError),
}

impl From<LinkError> for Undone {
    fn from(trouble: LinkError) -> Undone {
        Undone::Lost(trouble)
    }
}

impl From<Declined> for Undone {
    fn from(declined: Declined) -> Undone {
        Undone::Declined(declined)
    }
}

impl From<NoLine> for Undone {
    fn from(why: NoLine) -> Undone {
        let declined = Declined::refused(why.to_string());
        Undone::Declined(match why {
            NoLine::Whole(_) => declined,
            NoLine::Share { why, least, .. } => {
                declined.remedy(format!("give {least} or more for the {}", why.what))
            }
        })
    }
}

/// The steps from a position.
fn distance(way: Way, from: i64) -> Result<Distance, Declined> {
    let to = match way {
        Way::By(by) => return Ok(by),
        Way::To(to) => to,
    };
    i32::try_from(to.saturating_sub(from)).map(Distance::new).map_err(|_| {
        Declined::range(format!("from {from} to {to} is too far for one travel")).allowed(format!(
            "{} to {} steps",
            i32::MIN,
            i32::MAX
        ))
    })
}

/// An axis and the travel that it is to begin.
pub struct Begins {
    pub axis: AxisId,
    /// The position at rest, if it is known.
    pub from: Option<i64>,
    pub order: Order,
}

/// The lines that the board accepted.
pub type SaidLines = Result<Vec<Command>, Undone>;

impl<D: KeeperDesk> Keeper<D> {
    /// Carries out a job, and answers it.
    pub(crate) async fn carry_out(
        &mut self,
        talk: &mut Conversation,
        job: Job,
    ) -> Result<(), LinkError> {
        let done = match job.wish.clone() {
            Wish::Travel(axis, way, limits) => self.travel(talk, axis, way, &limits).await,
            Wish::Line(ways, limits) => self.line(talk, &ways, &limits).await,
            Wish::Run(axis, direction, limits, hand) => {
                self.run(talk, axis, Travel::Endless(direction), &limits, hand).await
            }
            Wish::Home(axis, limits, hand) => self.home(talk, axis, limits, hand).await,
            Wish::Retarget(axis, change) => self.retarget(talk, axis, change).await,
            Wish::Stop(axes) => self.stop(talk, axes).await,
            Wish::Kill => self.kill_all(talk).await,
            Wish::Zero(axis) => self.zero(talk, axis).await,
            Wish::Set(value) => self.set(talk, Command::Set(value)).await,
            Wish::Acknowledge => self.say(talk, Command::Clear).await,
        };
        match done {
            Ok(lines) => {
                // The next request sees the result of this one.
                self.publish();
                let lines = lines.iter().map(ToString::to_string).collect();
                self.answer(job, lines);
                Ok(())
            }
            Err(Undone::Declined(declined)) => {
                job.answer(Err(declined));
                Ok(())
            }
            Err(Undone::Lost(trouble)) => {
                let may = job.wish.is_urgent() || job.wish.starts();
                let remedy = if may { "a motor may be moving: look at it" } else { "try again" };
                let what = format!("{}: {trouble}", self.board.name);
                job.answer(Err(Declined::away(what).remedy(remedy)));
                Err(trouble)
            }
        }
    }

    /// The axis of a wish.
    pub(crate) fn axis(&mut self, axis: AxisId) -> Result<&mut Watched, Undone> {
        let count = self.axes.len();
        let number = axis.number();
        self.axes.get_mut(axis.index()).ok_or_else(|| {
            Declined::range(format!("the board has no axis {number}"))
                .allowed(format!("1 to {count}"))
                .into()
        })
    }

    async fn travel(
        &mut self,
        talk: &mut Conversation,
        axis: AxisId,
        way: Way,
        limits: &Limits,
    ) -> SaidLines {
        let from = self.stands_at(talk, axis).await?;
        let order = limits.order(Travel::By(distance(way, from)?))?;
        self.start(talk, &[Begins { axis, from: Some(from), order }], None).await
    }

    async fn line(
        &mut self,
        talk: &mut Conversation,
        ways: &[(AxisId, Way)],
        limits: &Limits,
    ) -> SaidLines {
        let mut steps = vec![Distance::new(0); self.axes.len()];
        let mut goes = Vec::new();
        for (axis, way) in ways {
            self.axis(*axis)?;
            let from = self.stands_at(talk, *axis).await?;
            let by = distance(*way, from)?;
            if let Some(steps) = steps.get_mut(axis.index()) {
                *steps = by;
            }
            goes.push((*axis, from, from.saturating_add(by.get().into())));
        }
        let longest = furthest(&steps).filter(|(_, by)| by.get() != 0);
        let (lead, by) = longest.ok_or_else(still)?;
        let orders = shares((lead, limits.order(Travel::By(by))?), &steps)?;
        let (apart, off) = (apart(&orders), off(&orders));
        let place = |axis| goes.iter().find(|(one, ..)| *one == axis).map(|(_, from, _)| *from);
        let begins = |(axis, order)| Begins { axis, from: place(axis), order };
        let begins: Vec<_> = orders.into_iter().map(begins).collect();
        let begun = self.start(talk, &begins, None).await?;
        // Also for an axis that is already at its target.
        for (axis, _, target) in goes {
            self.axis(axis)?.target = Some(target);
        }
        if apart > NOTABLE {
            self.desk.note(format!("the axes of the line end within {apart:.3} s of each other"));
        }
        if off > NEAR {
            self.desk.note(format!("the axes leave the line by up to {off:.0} steps"));
        }
        Ok(begun)
    }

    async fn run(
        &mut self,
        talk: &mut Conversation,
        axis: AxisId,
        travel: Travel,
        limits: &Limits,
        hand: Hand,
    ) -> SaidLines {
        let from = self.stands_at(talk, axis).await?;
        let order = limits.order(travel)?;
        self.start(talk, &[Begins { axis, from: Some(from), order }], Some(hand)).await
    }

    /// Checks that an axis which is to move rests.
    pub(crate) async fn rests(
        &mut self,
        talk: &mut Conversation,
        axis: AxisId,
        remedy: &str,
    ) -> Result<(), Undone> {
        self.not_homed(axis)?;
        if talk.is_busy(Selection::One(axis)).await? {
            let what = format!("axis {} is on its way", axis.number());
            return Err(Declined::refused(what).remedy(remedy).into());
        }
        Ok(self.ended(talk, axis).await?)
    }

    /// The position of an axis that is to move.
    async fn stands_at(&mut self, talk: &mut Conversation, axis: AxisId) -> Result<i64, Undone> {
        self.rests(talk, axis, "wait, stop it, or retarget it").await?;
        talk.rest_position(axis).await?.ok_or_else(|| {
            Declined::refused(format!("the position of axis {} is uncertain", axis.number()))
                .remedy("if it stands at a known place, or to go and find one, call it 0")
                .into()
        })
    }

    /// Starts axes that rest, together.
    async fn start(
        &mut self,
        talk: &mut Conversation,
        begins: &[Begins],
        hand: Option<Hand>,
    ) -> SaidLines {
        let begun = self.set_off(talk, begins, hand).await?;
        for one in begins {
            // A homing that has failed is no longer reported.
            let watched = self.axis(one.axis)?;
            watched.home = watched.home.take().filter(|home| home.stage == "done");
        }
        match begun {
            Ok(lines) => Ok(lines),
            Err(not) => Err(self.not_begun(talk, not).await),
        }
    }

    /// Starts axes that rest, together. Returns the lines, or why none has started.
    pub(crate) async fn set_off(
        &mut self,
        talk: &mut Conversation,
        begins: &[Begins],
        hand: Option<Hand>,
    ) -> Result<Result<Vec<Command>, NotBegun>, Undone> {
        for one in begins {
            self.can_bend(talk, &one.order).await?;
        }
        let orders: Vec<_> = begins.iter().map(|one| (one.axis, one.order)).collect();
        let script = Script::new(&orders).map_err(|why| Declined::range(why.to_string()))?;
        let mut lines: Vec<Command> = script.collect();
        let grants = |can: stepwright_protocol::Abilities| can.has(Ability::Safety);
        let leases = hand.is_some() || self.board.leases_travels;
        if leases && talk.info().and_then(|info| info.can).is_some_and(grants) {
            lines.insert(0, Command::Lease(self.board.lease));
            self.leased = true;
        }
        let starts: Vec<_> = begins
            .iter()
            .map(|one| Start { axis: one.axis, from: one.from, order: one.order })
            .collect();
        match talk.begin_together(&starts, &lines).await {
            Ok(()) => {}
            Err(NotBegun::Trouble { trouble, moving }) => {
                for one in begins {
                    let watched = self.axis(one.axis)?;
                    watched.moving = moving;
                    watched.hand = hand.filter(|_| moving);
                }
                return Err(trouble.into());
            }
            Err(not) => return Ok(Err(not)),
        }
        // E was answered just now; the lines before it took some time.
        let began = self.desk.time();
        for Begins { axis, from, order } in begins {
            let watched = self.axis(*axis)?;
            (watched.moving, watched.hand, watched.stop) = (true, hand, None);
            watched.from = *from;
            watched.target = match order.travel {
                Travel::By(by) => from.map(|from| from.saturating_add(by.get().into())),
                Travel::Endless(_) => None,
            };
            watched.see(began, *from);
            self.pulses.begin(axis.number(), order, began);
            let curve = from.and_then(|from| forecast::of(axis.number(), from, order, began));
            if let Some(curve) = curve {
                self.desk.plan(curve);
            }
        }
        Ok(Ok(lines))
    }

    /// Checks that the board keeps the jerk limit, if the order has one.
    async fn can_bend(&self, talk: &mut Conversation, order: &Order) -> Result<(), Undone> {
        let name = &self.board.name;
        let (what, remedy) = match talk.no_curves(order).await? {
            None => return Ok(()),
            Some(NoCurves::Board) => (
                format!("{name} has no S-curves, which a limit of jerk asks for"),
                "leave the jerk out",
            ),
            Some(NoCurves::Law) => (
                format!("the setting law of {name} is 0: it would ignore the limit of jerk"),
                "set law to 1, or leave the jerk out",
            ),
        };
        Err(Declined::refused(what).remedy(remedy).into())
    }

    async fn retarget(
        &mut self,
        talk: &mut Conversation,
        axis: AxisId,
        change: TravelChange,
    ) -> SaidLines {
        let from = self.axis(axis)?.from;
        self.not_homed(axis)?;
        let number = axis.number();
        let one = Selection::One(axis);
        on_its_way(talk, axis).await?;
        let target = match change.way {
            None => None,
            Some(Way::By(by)) => Some(by),
            Some(Way::To(to)) => {
                let from = from.ok_or_else(|| {
                    Declined::refused(format!(
                        "where the travel of axis {number} began is not known"
                    ))
                    .remedy("give `by`, counted from there")
                })?;
                Some(distance(Way::To(to), from)?)
            }
        };
        // The ramps first: the new speed and target use them.
        let top = change.top.and_then(Command::top);
        let slopes = [change.up.map(Command::Accel), change.down.map(Command::Decel)];
        let rest = [top, target.map(Command::Retarget)];
        let lines: Vec<_> = slopes.into_iter().chain(rest).flatten().collect();
        for &line in &lines {
            on_its_way(talk, axis).await?;
            self.desk.unplan(number);
            if talk.ask_of(one, line).await? != Reply::Yes {
                return Err(self.refused(talk, line).await?);
            }
            if let (Command::Retarget(by), Some(from)) = (line, from) {
                self.axis(axis)?.target = Some(from.saturating_add(by.get().into()));
            }
        }
        Ok(lines)
    }

    async fn stop(&mut self, talk: &mut Conversation, axes: Selection) -> SaidLines {
        if let Selection::One(axis) = axes {
            self.axis(axis)?;
        }
        talk.stop(axes).await?;
        self.give_up_homing(axes, &homing::stopped());
        self.leave_alone(axes);
        Ok(vec![Command::Stop])
    }

    async fn kill_all(&mut self, talk: &mut Conversation) -> SaidLines {
        if talk.ask(Command::Kill).await? != Reply::Yes {
            return Err(self.refused(talk, Command::Kill).await?);
        }
        for axis in self.axes.iter_mut().filter(|axis| axis.moving && axis.homing.is_none()) {
            axis.home = None;
        }
        self.give_up_homing(Selection::All, &homing::stopped());
        self.leave_alone(Selection::All);
        Ok(vec![Command::Kill])
    }

    /// These axes end by themselves from here on, and need no hand.
    fn leave_alone(&mut self, axes: Selection) {
        for axis in self.axes.iter_mut().filter(|axis| axes.contains(axis.id) && axis.moving) {
            axis.hand = None;
            self.desk.unplan(axis.id.number());
        }
    }

    async fn zero(&mut self, talk: &mut Conversation, axis: AxisId) -> SaidLines {
        // An order's end is reported in the positions in which the order was given.
        self.rests(talk, axis, "wait, or stop it").await?;
        let lines = self.say(talk, Command::Zero(axis)).await?;
        let watched = self.axis(axis)?;
        watched.shift_origin();
        watched.home = None;
        self.look_at_all(talk).await?;
        Ok(lines)
    }

    async fn set(&mut self, talk: &mut Conversation, line: Command) -> SaidLines {
        let lines = self.say(talk, line).await?;
        self.learn(talk).await?;
        Ok(lines)
    }

    /// Says a line that is harmless twice.
    async fn say(&mut self, talk: &mut Conversation, line: Command) -> SaidLines {
        if talk.ask(line).await? != Reply::Yes {
            return Err(self.refused(talk, line).await?);
        }
        self.look_at_all(talk).await?;
        Ok(vec![line])
    }
}

/// Checks that an axis travels: at rest the board would keep a change for later.
async fn on_its_way(talk: &mut Conversation, axis: AxisId) -> Result<(), Undone> {
    if talk.is_busy(Selection::One(axis)).await? {
        return Ok(());
    }
    Err(Declined::refused(format!("axis {} is at rest", axis.number()))
        .remedy("a move or a run begins a travel")
        .into())
}
