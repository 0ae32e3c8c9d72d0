//! Carries out what pages ask for.

use stepwright_protocol::{
    Ability, AxisId, Command, Distance, LeaseMillis, Order, Reply, Script, Selection, Travel,
};
use stepwright_serve::report::Done;
use stepwright_serve::request::{Limits, TravelChange, Way};
use stepwright_serve::{Declined, Hand, Job, Wish};

use super::keeper::Keeper;
use super::sight::Watched;
use super::{forecast, homing};
use crate::failure::Failure;
use crate::order::able;
use crate::order::drive;
use stepwright_host::LinkError;
use stepwright_host::motion::NotBegun;

/// The board brakes by itself when it hears nothing from here for this time, while an axis
/// runs without end.
const LEASE: LeaseMillis = LeaseMillis::clamped(1000);

/// Why a wish is not carried out.
pub enum Undone {
    /// The page is told.
    Declined(Declined),
    /// The page is told, and the conversation can't go on.
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

impl From<Failure> for Undone {
    fn from(failure: Failure) -> Undone {
        let declined = Declined::refused(failure.message());
        Undone::Declined(match failure.hinted() {
            Some(hint) => declined.remedy(hint),
            None => declined,
        })
    }
}

/// The lines that were taken.
pub type Taken = Result<Vec<Command>, Undone>;

impl Keeper {
    /// Does what was asked for, and answers.
    pub(super) fn carry_out(&mut self, job: Job) -> Result<(), LinkError> {
        let done = match job.wish.clone() {
            Wish::Travel(axis, way, limits) => self.travel(axis, way, &limits),
            Wish::Run(axis, direction, limits, hand) => {
                self.run(axis, Travel::Endless(direction), &limits, hand)
            }
            Wish::Home(axis, limits, hand) => self.home(axis, limits, hand),
            Wish::Retarget(axis, change) => self.retarget(axis, change),
            Wish::Stop(axes) => self.stop(axes),
            Wish::Kill => self.kill_all(),
            Wish::Zero(axis) => self.zero(axis),
            Wish::Set(value) => self.say_at_rest(Command::Set(value)),
            Wish::Acknowledge => self.say(Command::Clear),
        };
        match done {
            Ok(lines) => {
                // What the page asks next it asks knowing what has come of this.
                self.publish();
                let lines = lines.iter().map(ToString::to_string).collect();
                job.answer(Ok(Done { lines }));
                Ok(())
            }
            Err(Undone::Declined(declined)) => {
                job.answer(Err(declined));
                Ok(())
            }
            Err(Undone::Lost(trouble)) => {
                let starts = matches!(job.wish, Wish::Run(..) | Wish::Travel(..) | Wish::Home(..));
                let may = job.wish.is_urgent() || starts;
                let remedy = if may { "a motor may be moving: look at it" } else { "try again" };
                let what = format!("{}: {trouble}", self.session.name());
                job.answer(Err(Declined::away(what).remedy(remedy)));
                Err(trouble)
            }
        }
    }

    /// The axis that a wish is about.
    pub(super) fn axis(&mut self, axis: AxisId) -> Result<&mut Watched, Undone> {
        let count = self.axes.len();
        let number = axis.number();
        self.axes.get_mut(axis.index()).ok_or_else(|| {
            Declined::range(format!("the board has no axis {number}"))
                .allowed(format!("1 to {count}"))
                .into()
        })
    }

    fn travel(&mut self, axis: AxisId, way: Way, limits: &Limits) -> Taken {
        let from = self.stands_at(axis)?;
        let by = match way {
            Way::By(by) => by,
            Way::To(to) => {
                let steps = i32::try_from(to.saturating_sub(from)).map_err(|_| {
                    Declined::range(format!("from {from} to {to} is too far for one travel"))
                        .allowed(format!("{} to {} steps", i32::MIN, i32::MAX))
                })?;
                Distance::new(steps)
            }
        };
        self.start(axis, from, Travel::By(by), limits, None)
    }

    fn run(&mut self, axis: AxisId, travel: Travel, limits: &Limits, hand: Hand) -> Taken {
        let from = self.stands_at(axis)?;
        self.start(axis, from, travel, limits, Some(hand))
    }

    /// Where an axis stands that is to move.
    fn stands_at(&mut self, axis: AxisId) -> Result<i64, Undone> {
        self.not_homed(axis)?;
        let number = axis.number();
        if self.session.is_busy(Selection::One(axis))? {
            return Err(Declined::refused(format!("axis {number} is on its way"))
                .remedy("wait, stop it, or retarget it")
                .into());
        }
        self.session.rest_position(axis)?.ok_or_else(|| {
            Declined::refused(format!("the position of axis {number} is uncertain"))
                .remedy("if it stands at a known place, or to go and find one, call it 0")
                .into()
        })
    }

    fn start(
        &mut self,
        axis: AxisId,
        from: i64,
        travel: Travel,
        limits: &Limits,
        hand: Option<Hand>,
    ) -> Taken {
        let order = limits.order(travel)?;
        let begun = self.set_off(axis, Some(from), &order, hand)?;
        // A homing that has failed is past.
        let watched = self.axis(axis)?;
        watched.home = watched.home.take().filter(|home| home.stage == "done");
        begun.map_err(|not| drive::not_begun(&mut self.session, not).into())
    }

    /// Starts an axis that stands at `from`; the lines, or why it did not start.
    pub(super) fn set_off(
        &mut self,
        axis: AxisId,
        from: Option<i64>,
        order: &Order,
        hand: Option<Hand>,
    ) -> Result<Result<Vec<Command>, NotBegun>, Undone> {
        able::to_bend(&mut self.session, order)?;
        let orders = [(axis, *order)];
        let mut lines: Vec<Command> = Script::new(&orders).map_err(Failure::from)?.collect();
        let grants = |can: stepwright_protocol::Abilities| can.has(Ability::Safety);
        if hand.is_some() && self.session.info().and_then(|info| info.can).is_some_and(grants) {
            lines.insert(0, Command::Lease(LEASE));
            self.leased = true;
        }
        let began = self.desk.time();
        let begun = self.session.begin(axis, order, &lines, from);
        let watched = self.axis(axis)?;
        match begun {
            Ok(()) => {}
            Err(NotBegun::Trouble { trouble, moving }) => {
                watched.moving = moving;
                watched.hand = hand.filter(|_| moving);
                return Err(trouble.into());
            }
            Err(not) => return Ok(Err(not)),
        }
        (watched.moving, watched.hand, watched.stop) = (true, hand, None);
        watched.from = from;
        watched.see(began, from);
        self.pulses.begin(axis.number(), order, began);
        if let Some(curve) = from.and_then(|from| forecast::of(axis.number(), from, order, began)) {
            self.desk.plan(curve);
        }
        Ok(Ok(lines))
    }

    fn retarget(&mut self, axis: AxisId, change: TravelChange) -> Taken {
        let from = self.axis(axis)?.from;
        self.not_homed(axis)?;
        let number = axis.number();
        let one = Selection::One(axis);
        self.on_its_way(one, number)?;
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
                let by = i32::try_from(to.saturating_sub(from)).map_err(|_| {
                    Declined::range(format!("from {from} to {to} is too far for one travel"))
                })?;
                Some(Distance::new(by))
            }
        };
        // The ramps first: the speed and the target are to be reached by them.
        let top = change.top.and_then(Command::top);
        let slopes = [change.up.map(Command::Accel), change.down.map(Command::Decel)];
        let rest = [top, target.map(Command::Retarget)];
        let lines: Vec<_> = slopes.into_iter().chain(rest).flatten().collect();
        for &line in &lines {
            self.on_its_way(one, number)?;
            self.desk.unplan(number);
            if self.session.ask_of(one, line)? != Reply::Yes {
                return Err(self.refused(line)?);
            }
        }
        Ok(lines)
    }

    /// That an axis travels: at rest the board would keep a change for later.
    fn on_its_way(&mut self, one: Selection, number: u8) -> Result<(), Undone> {
        if self.session.is_busy(one)? {
            return Ok(());
        }
        Err(Declined::refused(format!("axis {number} is at rest"))
            .remedy("a move or a run begins a travel")
            .into())
    }

    fn stop(&mut self, axes: Selection) -> Taken {
        if let Selection::One(axis) = axes {
            self.axis(axis)?;
        }
        self.session.brake(axes)?;
        self.give_up_homing(axes, &homing::stopped());
        for axis in self.axes.iter_mut().filter(|axis| axes.contains(axis.id) && axis.moving) {
            // From here on it needs nobody: it ends by itself.
            axis.hand = None;
            self.desk.unplan(axis.id.number());
        }
        Ok(vec![Command::Brake])
    }

    fn kill_all(&mut self) -> Taken {
        if self.session.ask(Command::Kill)? != Reply::Yes {
            return Err(self.refused(Command::Kill)?);
        }
        for axis in self.axes.iter_mut().filter(|axis| axis.moving && axis.homing.is_none()) {
            axis.home = None;
        }
        self.give_up_homing(Selection::All, &homing::stopped());
        for axis in self.axes.iter_mut().filter(|axis| axis.moving) {
            axis.hand = None;
            self.desk.unplan(axis.id.number());
        }
        Ok(vec![Command::Kill])
    }

    fn zero(&mut self, axis: AxisId) -> Taken {
        self.not_homed(axis)?;
        let lines = self.say(Command::Zero(axis))?;
        let watched = self.axis(axis)?;
        watched.shift_origin();
        watched.home = None;
        self.look_at_all()?;
        Ok(lines)
    }

    fn say_at_rest(&mut self, line: Command) -> Taken {
        let lines = self.say(line)?;
        self.learn()?;
        Ok(lines)
    }

    /// Says a line that is harmless twice.
    fn say(&mut self, line: Command) -> Taken {
        if self.session.ask(line)? != Reply::Yes {
            return Err(self.refused(line)?);
        }
        self.look_at_all()?;
        Ok(vec![line])
    }

    /// The board's refusal of this line.
    fn refused(&mut self, line: Command) -> Result<Undone, LinkError> {
        let name = self.session.name();
        let declined = match self.session.why()? {
            Some(why) => Declined::refused(format!("{name} refused {line}: {why}")),
            None => Declined::refused(format!("{name} refused {line}")),
        };
        Ok(Undone::Declined(match line {
            Command::Set(_) => declined.remedy("settings change while every axis rests"),
            Command::Zero(_) => declined.remedy("is the axis still travelling?"),
            _ => declined,
        }))
    }
}
