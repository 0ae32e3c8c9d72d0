//! Finding 0 by a limit switch, as a machine: told what has happened, it says what is next.
//!
//! ```text
//!   Seek ──► 0, BackOff ──► Approach slowly ──► 0, Leave ──► done
//!     switch closes: kill     switch closes: kill, 0 is here
//! ```
//!
//! It says no line and waits for nothing: whoever has the conversation does. The kill from the speed of the seek may lose steps, so the place that
//! counts is that of the slow approach.

use std::fmt;
use std::time::Duration;

use stepwright::Speed;
use stepwright_protocol::{AxisId, Command, Direction, Listed, Setting, Stop};

/// The board takes no order towards a switch until it has stopped bouncing: 250 ms at most.
const OPENS: Duration = Duration::from_millis(300);

/// Why an axis is not homed. Nothing was called 0 at the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HomingFailure {
    /// No switch was found within this many steps.
    NotFound {
        /// Of this axis.
        axis: AxisId,
        /// As many as were allowed.
        within: u32,
    },
    /// The switch is closed, this many steps away from it.
    StillClosed {
        /// Of this axis.
        axis: AxisId,
        /// As far as it backed off.
        steps: u32,
    },
    /// Something else has stopped the axis.
    Stopped(Stop),
    /// The axis rests, and nothing has stopped it.
    Unstopped,
    /// The axis did not get away from its switch.
    NotAway,
    /// The board refused to call the place 0.
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

/// The switch of an axis, by the settings of its board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SwitchSide {
    /// Which axis.
    pub axis: AxisId,
    /// The way towards its switch.
    pub towards: Direction,
    /// Whether a stop has to be acknowledged before the next order.
    pub safe_start: bool,
}

impl SwitchSide {
    /// The side of the switch of this axis.
    ///
    /// # Errors
    /// The board knows of none: the number that `switches` would have with it.
    pub fn of(axis: AxisId, listed: &Listed) -> Result<SwitchSide, u32> {
        let number = |setting| listed.get(setting).map_or(0, |value| value.number());
        let bit = 1u32.checked_shl(axis.index() as u32).unwrap_or(0);
        if number(Setting::Switches) & bit == 0 {
            return Err(number(Setting::Switches) | bit);
        }
        let forward = number(Setting::SwitchForward) & bit != 0;
        let towards = if forward { Direction::Forward } else { Direction::Backward };
        Ok(SwitchSide { axis, towards, safe_start: number(Setting::SafeStart) != 0 })
    }

    /// Steps away from the switch, signed as positions are.
    pub fn away(&self, steps: i32) -> i32 {
        match self.towards {
            Direction::Forward => -steps,
            Direction::Backward => steps,
        }
    }
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
    /// Whether it goes to the switch, and not away from it.
    pub fn is_towards(self) -> bool {
        matches!(self, HomeLeg::Seek | HomeLeg::Approach)
    }
}

/// What is to be done next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HomingAct {
    /// Begin this travel, and say how it ends.
    Travel(HomeLeg),
    /// Say this line, and how it was answered.
    Say(Command),
    /// Wait a moment.
    Wait,
    /// Nothing: the axis is homed, and stands here.
    Done(i64),
}

/// What has happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HomingEvent {
    /// The travel has ended here, if that is known.
    Rests {
        /// In steps.
        position: Option<i64>,
        /// What has stopped it before its end.
        stop: Option<Stop>,
        /// Whether it was braked because it has gone far enough.
        braked: bool,
    },
    /// The travel was refused: the switch is closed.
    Closed,
    /// The line was answered: Y, or not.
    Said(bool),
    /// A moment has passed.
    Waited,
}

/// Where a homing is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Going(HomeLeg),
    /// The stop is being acknowledged, before the place is called 0.
    Clearing(HomeLeg),
    /// The place is being called 0, before this leg.
    Zeroing(HomeLeg),
    /// The switch bounces.
    Waiting,
}

/// The homing of an axis.
#[derive(Clone, Debug)]
pub struct SwitchHoming {
    side: SwitchSide,
    /// How far to go from the closed switch, in steps, signed.
    back_off: i32,
    /// How far the switch may be, in steps.
    within: u32,
    state: State,
    /// The switch has to be open then.
    open_by: Option<Duration>,
    note: Option<String>,
}

impl SwitchHoming {
    /// A homing that begins with the leg [`HomeLeg::Seek`].
    pub fn new(side: SwitchSide, back_off: u32, within: u32) -> SwitchHoming {
        let back_off = side.away(i32::try_from(back_off).unwrap_or(i32::MAX));
        let state = State::Going(HomeLeg::Seek);
        SwitchHoming { side, back_off, within, state, open_by: None, note: None }
    }

    /// The travel that it is on, or that comes next.
    pub fn leg(&self) -> HomeLeg {
        match self.state {
            State::Going(leg) | State::Zeroing(leg) | State::Clearing(leg) => leg,
            State::Waiting => HomeLeg::Approach,
        }
    }

    /// The way back from the switch, in steps, signed.
    pub fn back_off(&self) -> i32 {
        self.back_off
    }

    /// A travel to the switch at this speed is braked after this time.
    pub fn longest(&self, speed: Speed) -> Duration {
        let speed = f64::from(speed.millisteps()) / 1000.0;
        Duration::try_from_secs_f64(f64::from(self.within) / speed).unwrap_or(Duration::MAX)
    }

    /// Something that a user would like to know, once.
    pub fn take_note(&mut self) -> Option<String> {
        self.note.take()
    }

    /// What is next after this, which happened at `now` of any clock.
    ///
    /// # Errors
    /// The axis can't be homed: why, and the remedy. Nothing is called 0 then.
    pub fn next(&mut self, event: HomingEvent, now: Duration) -> Result<HomingAct, HomingFailure> {
        match (self.state, event) {
            (State::Going(leg), HomingEvent::Closed) if leg.is_towards() => self.closed(leg, now),
            (State::Going(leg), HomingEvent::Rests { position, stop, braked }) => {
                if leg.is_towards() {
                    self.at_switch(leg, position, stop, braked)
                } else {
                    let stop = stop.or(braked.then_some(Stop::Soft));
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
        HomingAct::Say(Command::Zero(self.side.axis))
    }

    /// The switch was closed before the leg to it.
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
        let (axis, steps) = (self.side.axis, self.back_off.unsigned_abs());
        Err(HomingFailure::StillClosed { axis, steps })
    }

    /// A leg to the switch has ended.
    fn at_switch(
        &mut self,
        leg: HomeLeg,
        position: Option<i64>,
        stop: Option<Stop>,
        braked: bool,
    ) -> Result<HomingAct, HomingFailure> {
        if braked {
            return Err(HomingFailure::NotFound { axis: self.side.axis, within: self.within });
        }
        match stop {
            Some(Stop::Switch) => {}
            Some(stop) => return Err(HomingFailure::Stopped(stop)),
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
        if self.side.safe_start {
            self.state = State::Clearing(next);
            return Ok(HomingAct::Say(Command::Clear));
        }
        Ok(self.zero(next))
    }

    /// A leg from the switch has ended. A stop that comes with its last steps leaves the place as
    /// it is; no leg follows it all the same.
    fn away(
        &mut self,
        leg: HomeLeg,
        position: Option<i64>,
        stop: Option<Stop>,
    ) -> Result<HomingAct, HomingFailure> {
        match (position.filter(|at| *at == i64::from(self.back_off)), stop) {
            (None, _) => Err(HomingFailure::NotAway),
            (Some(at), _) if leg == HomeLeg::Leave => Ok(HomingAct::Done(at)),
            (Some(_), Some(stop)) => Err(HomingFailure::Stopped(stop)),
            (Some(_), None) => Ok(self.go(HomeLeg::Approach)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: SwitchSide =
        SwitchSide { axis: AxisId::FIRST, towards: Direction::Forward, safe_start: false };
    const ZERO: HomingAct = HomingAct::Say(Command::Zero(AxisId::FIRST));
    const YES: HomingEvent = HomingEvent::Said(true);

    fn homing(safe_start: bool) -> SwitchHoming {
        SwitchHoming::new(SwitchSide { safe_start, ..SIDE }, 50, 300)
    }

    fn rests(position: i64, stop: Option<Stop>) -> HomingEvent {
        HomingEvent::Rests { position: Some(position), stop, braked: false }
    }

    /// Goes on by these events, at these ms; the last act.
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
        let braked = HomingEvent::Rests { position: Some(-300), stop: None, braked: true };
        for (events, why) in [
            (vec![(0, braked)], "no switch of axis 1 within 300 steps"),
            (vec![(0, rests(4, Some(Stop::Soft)))], "stopped by"),
            (vec![(0, rests(4, None))], "its switch has not stopped it"),
            (vec![(0, HomingEvent::Closed), (0, HomingEvent::Said(false))], "refused to zero"),
            (vec![(0, HomingEvent::Closed), (0, YES), (0, rests(-49, None))], "did not get away"),
            (vec![(0, YES)], "can't go on"),
        ] {
            let said = after(&mut homing(false), &events).unwrap_err();
            assert!(said.contains(why), "{said}");
        }
    }

    /// A stop that comes with the last steps is not seen in the position.
    #[test]
    fn no_leg_follows_a_stop() {
        let ends = |stop, braked| HomingEvent::Rests { position: Some(-50), stop, braked };
        let soft = Some(Stop::Soft);
        for end in [ends(soft, false), ends(None, true), ends(soft, true)] {
            let said = after(&mut homing(false), &[(0, HomingEvent::Closed), (0, YES), (0, end)]);
            assert_eq!(said, Err("stopped by a soft stop (Z)".to_owned()));
        }
        // None would follow the last leg: 0 is found.
        let found = [(0, HomingEvent::Closed), (0, YES), (0, ends(None, false))];
        let last = [(0, rests(-2, Some(Stop::Switch))), (0, YES), (0, ends(soft, true))];
        let done = after(&mut homing(false), &[found, last].concat());
        assert_eq!(done, Ok(HomingAct::Done(-50)));
    }

    #[test]
    fn far_enough_is_a_time() {
        let longest = |speed| homing(false).longest(Speed::from_steps(speed).unwrap());
        assert_eq!(longest(100), Duration::from_secs(3));
        assert_eq!(homing(false).longest(Speed::ZERO), Duration::MAX);
    }
}
