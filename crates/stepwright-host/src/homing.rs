//! Homing by a limit switch, as a state machine: it is given events, and returns the next act.
//!
//! ```text
//!   Seek ──► 0, BackOff ──► Approach slowly ──► 0, Leave ──► done
//!     switch closes: kill     switch closes: kill, 0 is here
//! ```
//!
//! The machine says no line and waits for nothing; the caller does. The kill at the speed of the seek may lose
//! steps, so only the position of the slow approach counts.
//!
//! A leg to the switch is a travel that ends where the switch must have closed. A board that may refuse such a
//! travel, because of a soft limit or an unknown position, gets an endless run, which is braked in time.

use std::fmt;
use std::time::Duration;

use stepwright_protocol::{
    AxisId, Command, Direction, Distance, Listed, Order, Setting, Stop, Travel,
};

use crate::course::Course;

/// The board refuses orders towards a switch until the switch stops bouncing: 250 ms at most.
const OPENS: Duration = Duration::from_millis(300);

/// Why an axis is not homed. The position of the last leg was not made 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HomingFailure {
    /// No switch was found within this many steps.
    NotFound {
        /// The axis.
        axis: AxisId,
        /// The number of steps that were allowed.
        within: u32,
    },
    /// The switch is still closed, this many steps away from it.
    StillClosed {
        /// The axis.
        axis: AxisId,
        /// The number of steps that it backed off.
        steps: u32,
    },
    /// Something else stopped the axis.
    Stopped(Stop),
    /// The axis rests, and nothing stopped it.
    Unstopped,
    /// The axis did not get away from its switch.
    NotAway,
    /// The board refused to make the position 0.
    NotZeroed,
    /// This event can't come in this state.
    OutOfTurn(HomingEvent),
}

impl fmt::Display for HomingFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            HomingFailure::NotFound { axis, within } => {
                write!(f, "no switch of axis {} within {within} steps", axis.number())
            }
            HomingFailure::StillClosed { axis, steps } => {
                let axis = axis.number();
                write!(f, "the switch of axis {axis} is closed still, {steps} steps away from it")
            }
            HomingFailure::Stopped(stop) => write!(f, "stopped by {}", stop.words()),
            HomingFailure::Unstopped => {
                f.write_str("the axis rests, and its switch has not stopped it")
            }
            HomingFailure::NotAway => f.write_str("the axis did not get away from its switch"),
            HomingFailure::NotZeroed => f.write_str("the board refused to zero the axis"),
            HomingFailure::OutOfTurn(event) => write!(f, "homing can't go on after {event:?}"),
        }
    }
}

impl std::error::Error for HomingFailure {}

/// The limit switch of an axis, from the settings of its board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SwitchSide {
    /// The axis.
    pub axis: AxisId,
    /// The direction towards the switch.
    pub towards: Direction,
    /// Whether a stop has to be acknowledged before the next order.
    pub safe_start: bool,
    /// Whether the axis has soft limits: a travel by a distance may be refused.
    pub soft_limits: bool,
    /// Whether a travel by a distance is refused while the position is lost.
    pub home_first: bool,
}

impl SwitchSide {
    /// The side of the switch of this axis.
    ///
    /// # Errors
    /// The board has no switch for the axis: returns the number that the setting `switches` would have with it.
    pub fn of(axis: AxisId, listed: &Listed) -> Result<SwitchSide, u32> {
        let number = |setting| listed.get(setting).map_or(0, |value| value.number());
        let bit = 1u32.checked_shl(axis.index() as u32).unwrap_or(0);
        if number(Setting::Switches) & bit == 0 {
            return Err(number(Setting::Switches) | bit);
        }
        let forward = number(Setting::SwitchForward) & bit != 0;
        let towards = if forward { Direction::Forward } else { Direction::Backward };
        Ok(SwitchSide {
            axis,
            towards,
            safe_start: number(Setting::SafeStart) != 0,
            soft_limits: number(Setting::SoftLimits) & bit != 0,
            home_first: number(Setting::HomeFirst) != 0,
        })
    }

    /// Steps away from the switch, signed as positions are.
    pub fn away(&self, steps: i32) -> i32 {
        match self.towards {
            Direction::Forward => -steps,
            Direction::Backward => steps,
        }
    }
}

/// How an axis is homed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HomeOrder {
    /// The switch of the axis.
    pub side: SwitchSide,
    /// How to seek the switch and back off. The travel is ignored.
    pub fast: Order,
    /// How to approach the switch the second time. The travel is ignored.
    pub slow: Order,
    /// How far to back off, in steps.
    pub back_off: u32,
    /// How far the switch may be, in steps.
    pub within: u32,
}

/// A travel of a homing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HomeLeg {
    /// To the switch, fast.
    Seek,
    /// Away from it.
    BackOff,
    /// To the switch, slowly.
    Approach,
    /// Away from it, at the end.
    Leave,
}

impl HomeLeg {
    /// Whether the leg goes towards the switch.
    pub fn is_towards(self) -> bool {
        matches!(self, HomeLeg::Seek | HomeLeg::Approach)
    }
}

/// The next act of the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HomingAct {
    /// Begin this leg, and report how it ends.
    Travel(HomeLeg),
    /// Say this line, and report its answer.
    Say(Command),
    /// Wait a moment.
    Wait,
    /// Nothing: the axis is homed, and stands here.
    Done(i64),
}

/// An event for the state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HomingEvent {
    /// The leg has ended at this position, if it is known.
    Rests {
        /// In steps.
        position: Option<i64>,
        /// What stopped the axis before its end. Also a soft stop that was requested too late.
        stop: Option<Stop>,
        /// Whether it was braked because the time [`BegunLeg::brakes`] was over.
        braked: bool,
    },
    /// The leg was refused: the switch is closed.
    Closed,
    /// The line was answered: true for Y.
    Said(bool),
    /// A moment has passed.
    Waited,
}

/// The state of a homing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Going(HomeLeg),
    /// The stop is being acknowledged, before the position is made 0.
    Clearing(HomeLeg),
    /// The position is being made 0, before this leg.
    Zeroing(HomeLeg),
    /// The switch bounces.
    Waiting,
}

/// The order of a leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BegunLeg {
    /// The order.
    pub order: Order,
    /// If set, brake the leg after this time, if it has not ended by itself.
    pub brakes: Option<Duration>,
}

/// The homing of an axis.
#[derive(Clone, Debug)]
pub struct SwitchHoming {
    order: HomeOrder,
    state: State,
    /// Where the leg ends if nothing stops it, if that is known.
    end: Option<i64>,
    /// By this time the switch has to be open.
    open_by: Option<Duration>,
    note: Option<String>,
}

impl SwitchHoming {
    /// A homing that begins with the leg [`HomeLeg::Seek`].
    pub fn new(order: HomeOrder) -> SwitchHoming {
        let state = State::Going(HomeLeg::Seek);
        SwitchHoming { order, state, end: None, open_by: None, note: None }
    }

    /// The present leg, or the next one between two legs.
    pub fn leg(&self) -> HomeLeg {
        match self.state {
            State::Going(leg) | State::Zeroing(leg) | State::Clearing(leg) => leg,
            State::Waiting => HomeLeg::Approach,
        }
    }

    /// The steps back from the switch, signed.
    fn back_off(&self) -> i32 {
        self.order.side.away(i32::try_from(self.order.back_off).unwrap_or(i32::MAX))
    }

    /// The order of the present leg, for an axis at position `from`, if that is known.
    pub fn begin(&mut self, from: Option<i64>) -> BegunLeg {
        let HomeOrder { side, fast, slow, within, .. } = self.order;
        let leg = self.leg();
        let within = i32::try_from(within).unwrap_or(i32::MAX);
        let steps = if leg.is_towards() { side.away(-within) } else { self.back_off() };
        let order = Order {
            travel: Travel::By(Distance::new(steps)),
            ..if leg == HomeLeg::Approach { slow } else { fast }
        };
        self.end = from.map(|from| from.saturating_add(steps.into()));
        if leg.is_towards() && (side.soft_limits || side.home_first && from.is_none()) {
            let endless = Order { travel: Travel::Endless(side.towards), ..order };
            return BegunLeg { order: endless, brakes: Some(until_braked(&order)) };
        }
        BegunLeg { order, brakes: None }
    }

    /// The latest note for the user; returned once.
    pub fn take_note(&mut self) -> Option<String> {
        self.note.take()
    }

    /// The next act after this event, at time `now` of any clock.
    ///
    /// # Errors
    /// The reason why the axis can't be homed. The position is not made 0 then.
    pub fn next(&mut self, event: HomingEvent, now: Duration) -> Result<HomingAct, HomingFailure> {
        match (self.state, event) {
            (State::Going(leg), HomingEvent::Closed) if leg.is_towards() => self.closed(leg, now),
            (State::Going(leg), HomingEvent::Rests { position, stop, braked }) => {
                if leg.is_towards() {
                    self.at_switch(leg, position, stop, braked)
                } else {
                    self.away(leg, position, stop)
                }
            }
            (State::Clearing(leg), HomingEvent::Said(_)) => Ok(self.zero(leg)),
            (State::Zeroing(leg), HomingEvent::Said(true)) => Ok(self.go(leg)),
            (State::Zeroing(_), HomingEvent::Said(false)) => Err(HomingFailure::NotZeroed),
            (State::Waiting, HomingEvent::Waited) => Ok(self.go(HomeLeg::Approach)),
            (_, event) => Err(HomingFailure::OutOfTurn(event)),
        }
    }

    fn go(&mut self, leg: HomeLeg) -> HomingAct {
        self.state = State::Going(leg);
        HomingAct::Travel(leg)
    }

    fn zero(&mut self, before: HomeLeg) -> HomingAct {
        self.state = State::Zeroing(before);
        HomingAct::Say(Command::Zero(self.order.side.axis))
    }

    /// Handles a leg that was refused because the switch is closed.
    fn closed(&mut self, leg: HomeLeg, now: Duration) -> Result<HomingAct, HomingFailure> {
        if leg == HomeLeg::Seek {
            self.note = Some("the switch is closed already".to_owned());
            return Ok(self.zero(HomeLeg::BackOff));
        }
        let open_by = *self.open_by.get_or_insert(now + OPENS);
        if now < open_by {
            self.state = State::Waiting;
            return Ok(HomingAct::Wait);
        }
        let (axis, steps) = (self.order.side.axis, self.order.back_off);
        Err(HomingFailure::StillClosed { axis, steps })
    }

    /// Handles the end of a leg to the switch.
    fn at_switch(
        &mut self,
        leg: HomeLeg,
        position: Option<i64>,
        stop: Option<Stop>,
        braked: bool,
    ) -> Result<HomingAct, HomingFailure> {
        let HomeOrder { side: SwitchSide { axis, .. }, within, .. } = self.order;
        match stop {
            Some(Stop::Switch) => {}
            _ if braked => return Err(HomingFailure::NotFound { axis, within }),
            Some(stop) => return Err(HomingFailure::Stopped(stop)),
            None if position == self.end => return Err(HomingFailure::NotFound { axis, within }),
            None => return Err(HomingFailure::Unstopped),
        }
        let (note, next) = match (leg, position) {
            (HomeLeg::Approach, _) => {
                ("switch closed slowly: that is 0".to_owned(), HomeLeg::Leave)
            }
            (_, Some(at)) => (format!("switch closed at {at}"), HomeLeg::BackOff),
            (_, None) => ("switch closed".to_owned(), HomeLeg::BackOff),
        };
        self.note = Some(note);
        if self.order.side.safe_start {
            self.state = State::Clearing(next);
            return Ok(HomingAct::Say(Command::Clear));
        }
        Ok(self.zero(next))
    }

    /// Handles the end of a leg away from the switch. A stop during its last steps does not change the
    /// position, but no leg follows it.
    fn away(
        &mut self,
        leg: HomeLeg,
        position: Option<i64>,
        stop: Option<Stop>,
    ) -> Result<HomingAct, HomingFailure> {
        match (position.filter(|at| *at == i64::from(self.back_off())), stop) {
            (None, _) => Err(HomingFailure::NotAway),
            (Some(at), _) if leg == HomeLeg::Leave => Ok(HomingAct::Done(at)),
            (Some(_), Some(stop)) => Err(HomingFailure::Stopped(stop)),
            (Some(_), None) => Ok(self.go(HomeLeg::Approach)),
        }
    }
}

/// When to brake an endless run under the limits of this travel, so that it ends where the travel does.
fn until_braked(order: &Order) -> Duration {
    // An order that no timer can hold is refused by the board.
    let brakes = Course::of(&(*order).into()).map_or(0.0, |course| course.brakes());
    Duration::try_from_secs_f64(brakes).unwrap_or(Duration::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use stepwright::{Accel, Speed};
    use stepwright_protocol::Ramp;

    const SIDE: SwitchSide = SwitchSide {
        axis: AxisId::FIRST,
        towards: Direction::Forward,
        safe_start: false,
        soft_limits: false,
        home_first: false,
    };
    const ZERO: HomingAct = HomingAct::Say(Command::Zero(AxisId::FIRST));
    const YES: HomingEvent = HomingEvent::Said(true);

    /// From rest, with 100 steps/s² up and half of that down.
    fn motion(top: u32) -> Order {
        let ramp = |accel| Ramp::Accel(Accel::from_steps(accel).unwrap());
        Order {
            start: Speed::ZERO,
            top: Speed::from_steps(top).unwrap(),
            up: ramp(100),
            down: ramp(50),
            jerk: None,
            travel: Travel::By(Distance::new(0)),
        }
    }

    fn on(side: SwitchSide, top: u32) -> SwitchHoming {
        let (fast, slow) = (motion(top), motion(10));
        SwitchHoming::new(HomeOrder { side, fast, slow, back_off: 50, within: 300 })
    }

    fn homing(safe_start: bool) -> SwitchHoming {
        on(SwitchSide { safe_start, ..SIDE }, 100)
    }

    fn rests(position: i64, stop: Option<Stop>) -> HomingEvent {
        HomingEvent::Rests { position: Some(position), stop, braked: false }
    }

    /// Sends these events at these times in ms, and returns the last act.
    fn after(
        homing: &mut SwitchHoming,
        events: &[(u64, HomingEvent)],
    ) -> Result<HomingAct, String> {
        let mut last = Ok(HomingAct::Travel(HomeLeg::Seek));
        for (ms, event) in events {
            last = homing.next(*event, Duration::from_millis(*ms));
        }
        last.map_err(|failure| failure.to_string())
    }

    #[test]
    fn the_slow_approach_counts() {
        let (mut homing, switch) = (homing(false), Some(Stop::Switch));
        for (event, act, note) in [
            (rests(-700, switch), ZERO, Some("switch closed at -700")),
            (YES, HomingAct::Travel(HomeLeg::BackOff), None),
            (rests(-50, None), HomingAct::Travel(HomeLeg::Approach), None),
            (rests(-2, switch), ZERO, Some("switch closed slowly: that is 0")),
            (YES, HomingAct::Travel(HomeLeg::Leave), None),
            (rests(-50, None), HomingAct::Done(-50), None),
        ] {
            assert_eq!(homing.next(event, Duration::ZERO).ok(), Some(act));
            assert_eq!(homing.take_note().as_deref(), note);
        }
    }

    #[test]
    fn a_stop_is_acknowledged_where_that_is_asked_for() {
        let mut homing = homing(true);
        let stopped = (0, rests(9, Some(Stop::Switch)));
        assert_eq!(after(&mut homing, &[stopped]), Ok(HomingAct::Say(Command::Clear)));
        assert_eq!(after(&mut homing, &[(0, HomingEvent::Said(true))]), Ok(ZERO));
        assert_eq!(homing.leg(), HomeLeg::BackOff);
    }

    #[test]
    fn a_switch_may_bounce_for_a_while() {
        let begin = [(0, HomingEvent::Closed), (0, YES), (1000, rests(-50, None))];
        let mut homing = homing(false);
        assert_eq!(after(&mut homing, &begin), Ok(HomingAct::Travel(HomeLeg::Approach)));
        for ms in [1000, 1150, 1299] {
            assert_eq!(after(&mut homing, &[(ms, HomingEvent::Closed)]), Ok(HomingAct::Wait));
            let again = after(&mut homing, &[(ms, HomingEvent::Waited)]);
            assert_eq!(again, Ok(HomingAct::Travel(HomeLeg::Approach)));
        }
        let closed = after(&mut homing, &[(1300, HomingEvent::Closed)]).unwrap_err();
        assert_eq!(closed, "the switch of axis 1 is closed still, 50 steps away from it");
    }

    #[test]
    fn nothing_else_is_called_0() {
        let ends = |position, stop, braked| HomingEvent::Rests { position, stop, braked };
        for (events, why) in [
            (vec![(0, rests(307, None))], "no switch of axis 1 within 300 steps"),
            (vec![(0, ends(Some(290), Some(Stop::Soft), true))], "within 300 steps"),
            (vec![(0, rests(4, Some(Stop::Soft)))], "stopped by"),
            (vec![(0, rests(4, None))], "its switch has not stopped it"),
            (vec![(0, HomingEvent::Closed), (0, HomingEvent::Said(false))], "refused to zero"),
            (vec![(0, HomingEvent::Closed), (0, YES), (0, rests(-49, None))], "did not get away"),
            (vec![(0, YES)], "can't go on"),
        ] {
            let mut homing = homing(false);
            homing.begin(Some(7));
            let said = after(&mut homing, &events).unwrap_err();
            assert!(said.contains(why), "{said}");
        }
        // An axis that began, and ended, at an unknown position.
        let mut homing = homing(false);
        homing.begin(None);
        let said = after(&mut homing, &[(0, ends(None, None, false))]).unwrap_err();
        assert!(said.contains("within 300 steps"), "{said}");
    }

    /// A switch that closes while the axis is braked counts as found.
    #[test]
    fn a_switch_counts_more_than_the_brake() {
        let stop = Some(Stop::Switch);
        let found = HomingEvent::Rests { position: Some(299), stop, braked: true };
        assert_eq!(after(&mut homing(false), &[(0, found)]), Ok(ZERO));
    }

    /// A stop during the last steps does not show in the position.
    #[test]
    fn no_leg_follows_a_stop() {
        let ends = |stop| (0, rests(-50, stop));
        let soft = Some(Stop::Soft);
        let said = after(&mut homing(false), &[(0, HomingEvent::Closed), (0, YES), ends(soft)]);
        assert_eq!(said, Err("stopped by a soft stop (Z)".to_owned()));
        // After the last leg there is none to follow: the axis is homed.
        let found = [(0, HomingEvent::Closed), (0, YES), ends(None)];
        let last = [(0, rests(-2, Some(Stop::Switch))), (0, YES), ends(soft)];
        let done = after(&mut homing(false), &[found, last].concat());
        assert_eq!(done, Ok(HomingAct::Done(-50)));
    }

    #[test]
    fn a_leg_to_the_switch_ends_where_the_switch_has_to_be() {
        let mut homing = homing(false);
        let by = |steps| Travel::By(Distance::new(steps));
        let seek = homing.begin(Some(7));
        assert_eq!((seek.order.travel, seek.brakes), (by(300), None));
        after(&mut homing, &[(0, HomingEvent::Closed), (0, YES)]).unwrap();
        assert_eq!(homing.begin(Some(0)).order.travel, by(-50));
        after(&mut homing, &[(0, rests(-50, None))]).unwrap();
        let approach = BegunLeg { order: Order { travel: by(300), ..motion(10) }, brakes: None };
        assert_eq!(homing.begin(Some(-50)), approach);
    }

    /// 300 steps take 2 s to 2·100 steps/s and 4 s from there. The tops are below and above this peak.
    #[test]
    fn an_endless_leg_is_braked_to_end_there() {
        let endless = Travel::Endless(Direction::Forward);
        let lost = SwitchSide { home_first: true, ..SIDE };
        let limited = SwitchSide { soft_limits: true, ..SIDE };
        for (side, from) in [(lost, None), (limited, Some(7)), (limited, None)] {
            // 1 s up over 50 steps, 2 s down over 100, and 1.5 s between.
            for (top, seconds) in [(100, 2.5), (1000, 1.414)] {
                let BegunLeg { order, brakes } = on(side, top).begin(from);
                assert_eq!(order.travel, endless);
                let brakes = brakes.unwrap().as_secs_f64();
                assert!((seconds - 0.15..=seconds).contains(&brakes), "{top}: {brakes}");
            }
        }
        assert_eq!(on(lost, 100).begin(Some(7)).brakes, None);
    }
}
