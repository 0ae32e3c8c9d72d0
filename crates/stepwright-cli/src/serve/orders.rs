//! Carries out what pages ask for.

use stepwright_protocol::{
    Ability, AxisId, Command, Distance, LeaseMillis, Order, Reply, Script, Selection, Travel,
};
use stepwright_serve::line::still;
use stepwright_serve::request::{Limits, TravelChange, Way};
use stepwright_serve::{Declined, Hand, Job, Wish};

use super::keeper::Keeper;
use super::sight::Watched;
use super::{forecast, homing};
use crate::failure::Failure;
use crate::order::able;
use crate::order::{drive, line};
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

/// The steps to go from a position.
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

/// An axis that is to begin a travel.
pub struct Begins {
    pub axis: AxisId,
    /// Where it stands, if that is known.
    pub from: Option<i64>,
    pub order: Order,
}

/// The lines that were taken.
pub type Taken = Result<Vec<Command>, Undone>;

impl Keeper {
    /// Does what was asked for, and answers.
    pub(super) fn carry_out(&mut self, job: Job) -> Result<(), LinkError> {
        let done = match job.wish.clone() {
            Wish::Travel(axis, way, limits) => self.travel(axis, way, &limits),
            Wish::Line(ways, limits) => self.line(&ways, &limits),
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
        let order = limits.order(Travel::By(distance(way, from)?))?;
        self.start(&[Begins { axis, from: Some(from), order }], None)
    }

    fn line(&mut self, ways: &[(AxisId, Way)], limits: &Limits) -> Taken {
        let (mut from, mut steps) = (Vec::new(), vec![Distance::new(0); self.axes.len()]);
        for (axis, way) in ways {
            self.axis(*axis)?;
            let at = self.stands_at(*axis)?;
            from.push((*axis, at));
            steps[axis.index()] = distance(*way, at)?;
        }
        let furthest = line::furthest(&steps).filter(|(_, by)| by.get() != 0);
        let (lead, by) = furthest.ok_or_else(still)?;
        let orders = line::shares((lead, limits.order(Travel::By(by))?), &steps)?;
        let apart = line::apart(&orders);
        let place = |axis| from.iter().find(|(one, _)| *one == axis).map(|(_, at)| *at);
        let begins = |(axis, order)| Begins { axis, from: place(axis), order };
        let begun = self.start(&orders.into_iter().map(begins).collect::<Vec<_>>(), None)?;
        // Also of one that stands at its target.
        for (axis, at) in from {
            self.axis(axis)?.target = Some(at.saturating_add(steps[axis.index()].get().into()));
        }
        if apart > 0.000_5 {
            self.desk.note(format!("the axes of the line end up to {apart:.3} s apart"));
        }
        Ok(begun)
    }

    fn run(&mut self, axis: AxisId, travel: Travel, limits: &Limits, hand: Hand) -> Taken {
        let from = self.stands_at(axis)?;
        self.start(&[Begins { axis, from: Some(from), order: limits.order(travel)? }], Some(hand))
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
        self.ended(axis)?;
        self.session.rest_position(axis)?.ok_or_else(|| {
            Declined::refused(format!("the position of axis {number} is uncertain"))
                .remedy("if it stands at a known place, or to go and find one, call it 0")
                .into()
        })
    }

    /// Starts axes that stand still, together.
    fn start(&mut self, begins: &[Begins], hand: Option<Hand>) -> Taken {
        let begun = self.set_off(begins, hand)?;
        for one in begins {
            // A homing that has failed is past.
            let watched = self.axis(one.axis)?;
            watched.home = watched.home.take().filter(|home| home.stage == "done");
        }
        begun.map_err(|not| drive::not_begun(&mut self.session, not).into())
    }

    /// Starts axes that stand still, together; the lines, or why none did start.
    pub(super) fn set_off(
        &mut self,
        begins: &[Begins],
        hand: Option<Hand>,
    ) -> Result<Result<Vec<Command>, NotBegun>, Undone> {
        for one in begins {
            able::to_bend(&mut self.session, &one.order)?;
        }
        let orders: Vec<_> = begins.iter().map(|one| (one.axis, one.order)).collect();
        let mut lines: Vec<Command> = Script::new(&orders).map_err(Failure::from)?.collect();
        let grants = |can: stepwright_protocol::Abilities| can.has(Ability::Safety);
        if hand.is_some() && self.session.info().and_then(|info| info.can).is_some_and(grants) {
            lines.insert(0, Command::Lease(LEASE));
            self.leased = true;
        }
        let began = self.desk.time();
        let begun = match begins {
            [one] => self.session.begin(one.axis, &one.order, &lines, one.from),
            _ => {
                begins.iter().for_each(|one| self.session.begins(one.axis, one.from));
                self.session.begin_together(&lines)
            }
        };
        match begun {
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
                Some(distance(Way::To(to), from)?)
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
            if let (Command::Retarget(by), Some(from)) = (line, from) {
                self.axis(axis)?.target = Some(from.saturating_add(by.get().into()));
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
        self.session.stop(axes)?;
        self.give_up_homing(axes, &homing::stopped());
        for axis in self.axes.iter_mut().filter(|axis| axes.contains(axis.id) && axis.moving) {
            // From here on it needs nobody: it ends by itself.
            axis.hand = None;
            self.desk.unplan(axis.id.number());
        }
        Ok(vec![Command::Stop])
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
