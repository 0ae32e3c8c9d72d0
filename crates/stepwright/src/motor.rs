//! One axis in the foreground: plans runs ahead of the interrupt.

use crate::clamp;
use crate::engine::Playing;
use crate::order::{Change, Order, Travel};
use crate::planner::{Clock, Layout, Load, Planned, Planner, Work};
use crate::profile::Unfit;
use crate::queue::Producer;
use crate::run::Run;
use crate::units::Ticks;

/// Plans one axis: sets up a travel and keeps its queue filled.
///
/// Plans until the queue is full, or until the queued steps last for the board's horizon. So a
/// change takes effect after that time and one run (at most 8 ms by default), or after the present
/// step if that takes longer.
///
/// A travel that has to turn has two *legs*, each from rest to rest in one direction. The second is
/// set up once the first has been stepped to its end.
#[derive(Clone, Copy)]
#[repr(C)] // in this order, as `Planner` is
pub(crate) struct Motor<const Q: usize> {
    /// How far the planning is.
    leg: Leg,
    /// The direction of the last queued step.
    forward: bool,
    /// Whether the travel is too long for `left` to be counted.
    beyond: bool,
    /// The ticks left of the rest after the last travel.
    rest: Ticks,
    /// The target of the travel, in steps from where it began. For an endless travel this is its
    /// first pulse.
    target: i32,
    /// Steps from the last pulse handed out to the target, positive in the direction of the last
    /// queued step.
    left: i32,
    /// When the last 2·Q places of the queue end, indexed by its counter, in units of [`Horizon`]
    /// modulo 256: the queue lasts at most 255 units, or counts as that. There are more than Q,
    /// because entries being played have left their places.
    ends: [[u8; 2]; Q],
    /// Places of the queue taken since the beginning, modulo 256, as far as `ends` is up to date.
    pushed: u8,
    planner: Planner,
}

/// How far the planning of a travel is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Leg {
    /// Planned to its end.
    Done,
    /// Ordered, and being set up: nothing moves before all axes of the order are set up.
    Ordered(Layout),
    /// A leg is set up, and not yet planned to its end.
    Open,
    /// As `Open`, but the rest is to be set up again for a change.
    Changed,
    /// As `Open`, but with an order to stop, wherever that leads.
    Braking,
    /// Another leg follows once the axis rests.
    Next,
}

/// How far ahead to plan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Horizon {
    /// Ticks in a unit, as a power of two.
    unit: u8,
    /// 32 … 63 units; fewer for a horizon of fewer ticks.
    units: u8,
}

/// The most units that an entry counts: more than the horizon. The present entry, those queued
/// after it (less than the horizon when the next run is planned) and that run together fit in a
/// byte.
const LONGEST: u8 = u8::MAX / 3;

impl Horizon {
    pub(crate) const fn new(ticks: Ticks) -> Horizon {
        let unit = 26u32.saturating_sub(ticks.leading_zeros()) as u8;
        Horizon { unit, units: (ticks >> unit) as u8 }
    }

    /// The units that last longer than these ticks, by at most one unit; at most [`LONGEST`]. So
    /// the queued steps never last longer than they count, if they count less than the horizon.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn span(&self, ticks: Ticks) -> u8 {
        // A small chip shifts bit by bit, except by whole bytes.
        let (bytes, bits) = if self.unit < 8 {
            (ticks, self.unit)
        } else {
            (ticks >> 8, self.unit.wrapping_sub(8))
        };
        u8::try_from(bytes >> bits).unwrap_or(u8::MAX).min(LONGEST - 1) + 1
    }
}

impl<const Q: usize> Motor<Q> {
    pub(crate) const IDLE: Self = Motor {
        planner: Planner::IDLE,
        leg: Leg::Done,
        forward: true,
        target: 0,
        left: 0,
        beyond: false,
        ends: [[0; 2]; Q],
        pushed: 0,
        rest: 0,
    };

    /// Initialises a motor of zeros as [`IDLE`](Motor::IDLE).
    pub(crate) fn power_up(&mut self) {
        (self.leg, self.forward) = (Leg::Done, true);
    }

    /// Takes an order, which [`lay`](Motor::lay) then sets up and [`begin`](Motor::begin) starts;
    /// the motor must be idle.
    ///
    /// # Errors
    /// [`Unfit`] if the order is no motion.
    pub(crate) fn prepare(&mut self, order: &Order) -> Result<(), Unfit> {
        self.planner.accept(order)?;
        self.leg = Leg::Ordered(Layout::Speeds);
        self.beyond = false;
        self.target = match order.travel {
            Travel::By(steps) => steps,
            Travel::Endless(true) => 1,
            Travel::Endless(false) => -1,
        };
        self.left = self.along(self.target);
        Ok(())
    }

    /// The next piece of its order; [`Layout::Nothing`] without an order.
    pub(crate) fn ordered(&self) -> Layout {
        if let Leg::Ordered(piece) = self.leg { piece } else { Layout::Nothing }
    }

    /// Sets up a piece of its order; the last pieces compute the load on the board.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub(crate) fn lay(
        &mut self,
        clock: &Clock,
        piece: Layout,
        load: &mut Load,
    ) -> Result<(), Unfit> {
        let mut next = Layout::Check;
        if piece == Layout::Load {
            load.peak = if self.left == 0 { 0 } else { self.planner.peak() };
            next = Layout::Runs;
        } else if piece == Layout::Runs {
            load.runs = self.planner.runs(load.peak, true);
            load.bends = self.planner.bends(load.peak);
        } else {
            next = self.planner.lay(clock, piece, self.left.unsigned_abs())?;
            // A piece of its own.
            if next == Layout::Check {
                next = Layout::Load;
            }
        }
        self.leg = Leg::Ordered(next);
        Ok(())
    }

    /// Called if the board can step its order, or also plan for it, as this piece asked.
    pub(crate) fn admit(&mut self, piece: Layout) {
        let next = if piece == Layout::Check { Layout::Plan } else { Layout::Wait };
        self.leg = Leg::Ordered(next);
    }

    /// Sets how long the next travel waits before it turns or begins. Returns false if the travel
    /// has 0 steps: then nothing waits, and the rest of the last travel continues.
    pub(crate) fn hold(&mut self, hold: Ticks) -> bool {
        let moves = self.left != 0;
        self.leg = Leg::Done;
        if moves {
            self.rest = hold;
            self.leg = Leg::Ordered(Layout::Begin);
        }
        moves
    }

    /// Changes the rest of a travel in progress: the next piece of planning sets it up again. First
    /// [`settle`](Motor::settle) the last change, and [`weigh`](Motor::weigh) this one on a copy.
    ///
    /// # Errors
    /// [`Unfit`] if the target is too far away to be counted.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn change(&mut self, change: &Change) -> Result<(), Unfit> {
        // A travel that is planned to its end rests there first.
        let open = self.is_open() && self.planner.steps_left() != 0;
        self.planner.limit(change);
        if let Change::Target(steps) = *change {
            let way = steps.checked_sub(self.led()).ok_or(Unfit::TooLong)?;
            (self.left, self.target) = (self.along(way), steps);
            if self.leg == Leg::Braking {
                self.leg = Leg::Open;
            }
        }
        if !self.is_open() {
            self.leg = self.next();
        } else if open {
            if self.leg == Leg::Braking {
                // A stop has no target to come back to, or to accelerate for.
                self.planner.stop();
                self.brake();
            } else {
                self.leg = Leg::Changed;
            }
        }
        Ok(())
    }

    /// The load on the board of a changed travel: of its top speed, or of the speed that it
    /// reaches, for which the rest is set up. So this motor is of no further use.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it, or if the target is too far away to be counted.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn weigh(
        &mut self,
        clock: &Clock,
        load: &mut Load,
        quick: bool,
    ) -> Result<(), Unfit> {
        self.planner.check(clock)?;
        *load = Load::QUEUED;
        let changed = self.leg == Leg::Changed;
        let endless = changed && self.planner.is_endless();
        let (mut left, mut beyond) = if endless { (0, false) } else { (self.left, self.beyond) };
        if quick {
            // Setting up the rest takes a chip a millisecond an axis, four if its ramps are bent.
            // A stop takes less than 2³⁰ steps: then the way back can be counted.
            if changed || left != 0 && self.leg != Leg::Braking {
                beyond |= left < -(1 << 30);
                self.planner.outline(left);
            }
            left = 0;
        } else {
            self.settle();
            self.planner.seek();
            // What this leg leaves can only be behind; or the fall of a curve has begun, and ends
            // before the target.
            let steps = self.planner.steps_left() as i32;
            if steps > 0 {
                left = left.wrapping_sub(steps);
                beyond |= left > 0 && self.planner.is_straight();
            }
        }
        if beyond {
            return Err(Unfit::TooLong);
        }
        self.planner.load(load);
        if left != 0 {
            self.planner.lay_out_again(left.unsigned_abs());
            self.planner.load(load);
        }
        Ok(())
    }

    /// Copies another motor: a function, because a chip copies byte by byte.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn set(&mut self, other: &Self) {
        *self = *other;
    }

    /// Whether a leg is set up, and not yet planned to its end.
    fn is_open(&self) -> bool {
        matches!(self.leg, Leg::Open | Leg::Changed | Leg::Braking)
    }

    /// Converts steps forward to steps in the direction of the last queued step.
    fn along(&self, steps: i32) -> i32 {
        if self.forward { steps } else { steps.wrapping_neg() }
    }

    /// Queues the beginning of the travel that is set up: the change of direction if there is one,
    /// then the first pulse, after the [hold](Motor::hold) and `lead` ticks. The queue must be
    /// empty.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn begin(&mut self, feed: &mut Producer<'_, Q>, mut lead: Ticks, horizon: &Horizon) {
        // −2³¹ steps, which have no opposite, go backward, whatever the direction.
        let forward = self.left != i32::MIN && self.forward == (self.left > 0);
        self.left = self.left.wrapping_abs().wrapping_sub(1);
        self.leg = Leg::Open;
        feed.set_open(true);
        let hold = self.rest;
        // A long wait is a turn too, possibly to the same side: so the first step is always near,
        // and costs a chip no more than the others.
        if forward != self.forward || hold > lead {
            self.push(feed, &Run::turn(hold, forward), horizon.span(hold));
        } else {
            lead = clamp::sum(lead, hold);
        }
        self.forward = forward;
        // Half a tick ahead from here on, so that deadlines rounded down are rounded to nearest.
        let first = Run { ticks: lead, part: 1 << 15, count: 1, add: 0 };
        self.push(feed, &first, horizon.span(lead));
    }

    /// Sets up the next leg, from rest; then call [`begin`](Motor::begin).
    pub(crate) fn turn(&mut self) {
        self.planner.lay_out_again(self.left.unsigned_abs());
    }

    /// Forgets an order that was not begun.
    pub(crate) fn forget(&mut self) {
        self.leg = Leg::Done;
    }

    /// Appends a run that lasts for this many units of the horizon.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn push(&mut self, feed: &mut Producer<'_, Q>, run: &Run, span: u8) {
        if feed.append(run) {
            // The last of its places lasts as long as the run. A run that waits for the next one is
            // added to the place before it.
            let (present, behind) = self.spans(feed);
            let span = span.min(!present.wrapping_add(behind));
            let last = self.pushed.wrapping_sub(1);
            self.set_end(last, self.end(last).wrapping_add(span));
        }
    }

    /// How long the whole present entry of the queue lasts, and how long the entries after it, in
    /// units.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn spans(&mut self, feed: &Producer<'_, Q>) -> (u8, u8) {
        let last = self.end(self.pushed.wrapping_sub(1));
        while self.pushed != feed.pushed() {
            self.set_end(self.pushed, last);
            self.pushed = self.pushed.wrapping_add(1);
        }
        let len = feed.len();
        if len == 0 {
            return (0, 0);
        }
        let played = self.pushed.wrapping_sub(len);
        let end = self.end(played);
        (end.wrapping_sub(self.end(played.wrapping_sub(1))), last.wrapping_sub(end))
    }

    /// When the place of a counter's value ends.
    fn end(&self, at: u8) -> u8 {
        self.ends.as_flattened().get(usize::from(at) & (2 * Q - 1)).copied().unwrap_or(0)
    }

    fn set_end(&mut self, at: u8, end: u8) {
        if let Some(slot) = self.ends.as_flattened_mut().get_mut(usize::from(at) & (2 * Q - 1)) {
            *slot = end;
        }
    }

    /// If a run should be planned: how long the queued steps last at least, in units of the
    /// horizon; else the highest number. Nothing is planned after a wait of the horizon, so a
    /// change takes effect there.
    #[inline(always)]
    pub(crate) fn wants(
        &mut self,
        feed: &mut Producer<'_, Q>,
        horizon: &Horizon,
        playing: impl FnOnce() -> Playing,
    ) -> u8 {
        if !self.is_open() || feed.is_full() {
            return u8::MAX;
        }
        let (least, most) = self.lasts(feed, horizon, playing);
        if most < horizon.units { least } else { u8::MAX }
    }

    /// How long planning may wait, in ticks; `None` if all is planned.
    pub(crate) fn may_wait(
        &mut self,
        feed: &Producer<'_, Q>,
        horizon: &Horizon,
        playing: impl FnOnce() -> Playing,
    ) -> Option<Ticks> {
        if self.leg == Leg::Done {
            return None;
        }
        let (mut least, _) = self.lasts(feed, horizon, playing);
        // Steps that have no entries yet get them at the next call: until then they last for no
        // time.
        let behind = feed.behind();
        if behind != 0 {
            least = least.saturating_sub(horizon.span(behind));
        }
        Some(Ticks::from(least / 2).max(1) << horizon.unit)
    }

    /// How long the queued steps last, in units, at least and at most: the present entry may be
    /// over at once if the rest of it is unknown.
    ///
    /// The rest of the present entry is asked for last. If the interrupt has moved on to the next
    /// entry meanwhile, that entry counts twice, and planning waits for the next call. In the other
    /// order it would not count at all, and more would be planned than a change may wait for.
    #[inline(always)]
    fn lasts(
        &mut self,
        feed: &Producer<'_, Q>,
        horizon: &Horizon,
        playing: impl FnOnce() -> Playing,
    ) -> (u8, u8) {
        let (present, behind) = self.spans(feed);
        let all = present.wrapping_add(behind);
        let (queued, left) = match playing() {
            Playing::Unknown => return (behind, all),
            Playing::Left(left) => (behind, left),
            Playing::Dry(left) => (all, left),
        };
        let lasts = queued.saturating_add(horizon.span(left));
        (lasts, lasts)
    }

    /// Whether another leg follows once the axis rests.
    pub(crate) fn is_to_turn(&self) -> bool {
        self.leg == Leg::Next
    }

    /// Does a piece of planning; the last piece of a run queues it.
    pub(crate) fn plan(
        &mut self,
        feed: &mut Producer<'_, Q>,
        clock: &Clock,
        work: &mut Work,
        horizon: &Horizon,
    ) {
        if let Some(run) = work.taken() {
            self.push(feed, run, work.span);
            return work.clear();
        }
        if self.leg == Leg::Changed {
            return self.settle();
        }
        match self.planner.next(clock, work) {
            Planned::Ready => {
                work.span = horizon.span(self.planner.take(work));
                self.left = self.left.wrapping_sub(work.steps().into());
                // Close to the end of the range of a number; an endless travel may continue.
                let [.., high] = self.left.to_le_bytes();
                self.beyond |= high == 0x80;
            }
            Planned::Again => {}
            // In two pieces.
            Planned::End if !work.is_begun() => {
                self.rest = self.planner.rest(clock);
                work.begin();
            }
            Planned::End => {
                work.clear();
                self.finish(feed);
            }
        }
    }

    /// Sets up the rest after a change, if that is still to be done.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn settle(&mut self) {
        if self.leg == Leg::Changed {
            self.leg = Leg::Open;
            self.planner.resume(self.left);
        }
    }

    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn finish(&mut self, feed: &mut Producer<'_, Q>) {
        self.leg = self.next();
        feed.set_open(false);
    }

    /// The ticks to rest before the next travel.
    pub(crate) fn rest(&self) -> Ticks {
        self.rest
    }

    /// Counts these ticks as rest.
    pub(crate) fn pass(&mut self, ticks: Ticks) {
        self.rest = clamp::less(self.rest, ticks);
    }

    /// The state after the end of a leg.
    fn next(&self) -> Leg {
        if self.left == 0 { Leg::Done } else { Leg::Next }
    }

    /// Brakes from the end of the queued steps, and stays there.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn brake(&mut self) {
        if self.ordered() != Layout::Nothing {
            return;
        }
        let mut left = 0;
        self.settle();
        if self.is_open() {
            if self.leg == Leg::Open {
                self.planner.brake();
            }
            self.leg = Leg::Braking;
            left = self.planner.steps_left() as i32;
        } else {
            self.leg = Leg::Done;
        }
        self.target = self.target.wrapping_add(self.along(left.wrapping_sub(self.left)));
        self.left = left;
    }

    /// Forgets the travel, which the engine has killed.
    pub(crate) fn abandon(&mut self, feed: &mut Producer<'_, Q>, clock: &Clock, forward: bool) {
        self.left = 0;
        self.rest = self.planner.rest(clock);
        self.finish(feed);
        self.forward = forward;
    }

    /// The place of the last pulse handed out, in steps from where the travel began; `None` if that
    /// is too far to be counted.
    pub(crate) fn planned(&self) -> Option<i32> {
        (!self.beyond).then_some(self.led())
    }

    /// [`planned`](Motor::planned) modulo 2³².
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn led(&self) -> i32 {
        self.target.wrapping_sub(self.along(self.left))
    }

    /// The target of the travel, in steps from where it began; `None` without an end, or if that is
    /// too far to be counted.
    pub(crate) fn target(&self) -> Option<i32> {
        (!self.beyond && !self.is_endless()).then_some(self.target)
    }

    /// Whether a target, in steps from where the travel began, is ahead of the planned part.
    pub(crate) fn is_ahead(&self, target: i32) -> bool {
        target > self.led()
    }

    /// Whether the travel goes forward.
    pub(crate) fn is_forward(&self) -> bool {
        self.forward
    }

    /// Whether the travel has no end.
    pub(crate) fn is_endless(&self) -> bool {
        matches!(self.leg, Leg::Open | Leg::Changed) && self.planner.is_endless()
    }

    /// Whether there is still something to plan.
    pub(crate) fn planning(&self) -> bool {
        !matches!(self.leg, Leg::Done | Leg::Ordered(_))
    }
}

#[cfg(test)]
mod tests;
