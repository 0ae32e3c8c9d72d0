//! Homing: each axis finds its limit switch twice, and its position is set.
//!
//! ```text
//!  (Free: away from a switch that is closed at the beginning)
//!   Seek ──edge──► brake ──► Back: $27 off the edge ──► Locate ──edge──► brake ──► Off: $27 off it
//!    $25                      $25                        $24                        $25
//! ```
//!
//! The position comes from the second edge, however long the braking distance is.

use stepwright_gcode::{FeedRate, Length, Move, MoveKind, Spindle};

use crate::machine::{GrblMachine, Inputs};
use crate::motion::{Scales, Travel, length};
use crate::session::Grbl;
use crate::state::{After, State};

/// The order of the axes: Z first, away from the work.
const ORDER: [usize; 3] = [2, 0, 1];

/// The search for a switch ends after this many times the travel.
const REACH: f64 = 1.5;

/// The second search ends after this many times the back-off distance.
const LOCATE: f64 = 5.0;

/// Alarms, by grbl's numbers.
const STILL_CLOSED: u8 = 8;
const NOT_FOUND: u8 = 9;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Begin,
    /// Away from a switch that is closed.
    Free,
    Seek,
    Back,
    Locate,
    Off,
}

/// A homing in progress.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homing {
    /// The number of axes that are done.
    done: usize,
    phase: Phase,
    /// The position in steps at which the switch closed, or in `Free` opened, in this phase.
    edge: Option<i64>,
}

impl Homing {
    pub const fn new() -> Homing {
        Homing { done: 0, phase: Phase::Begin, edge: None }
    }
}

impl<M: GrblMachine> Grbl<M> {
    /// Checks the switches, and begins the next phase at the end of one.
    pub(crate) fn go_on_homing(&mut self, inputs: Inputs) {
        let Some(mut homing) = self.homing else { return };
        let Some(&axis) = ORDER.get(homing.done) else { return self.end_homing() };
        let closed = inputs.limit[axis];
        let meets = match homing.phase {
            Phase::Seek | Phase::Locate => closed,
            Phase::Free => !closed,
            _ => false,
        };
        if meets && homing.edge.is_none() {
            homing.edge = Some(self.motion.at[axis]);
            self.homing = Some(homing);
            self.motion.cancel(self.now);
        }
        if !self.motion.is_over() || self.after.is_some() {
            return;
        }
        let sign = if self.settings.has(23, axis) { -1.0 } else { 1.0 };
        let (pull, steps) = (self.settings.get(27), self.settings.axes(100)[axis]);
        let off = |edge: i64| (edge as f64 - sign * pull * steps).round() as i64;
        match (homing.phase, homing.edge) {
            (Phase::Seek | Phase::Locate, None) => return self.brake(After::Alarm(NOT_FOUND)),
            (Phase::Free | Phase::Back | Phase::Off, _) if closed => {
                return self.brake(After::Alarm(STILL_CLOSED));
            }
            _ => {}
        }
        let here = self.motion.at[axis] as f64;
        let reach = sign * REACH * self.settings.axes(130)[axis].max(pull) * steps;
        let to = match (homing.phase, homing.edge) {
            (Phase::Begin, _) if closed => {
                homing.phase = Phase::Free;
                // At most as far as braking from full speed leads beyond a switch, and the back-off.
                let (speed, accel) =
                    (self.settings.axes(110)[axis] / 60.0, self.settings.axes(120)[axis]);
                here - sign * (LOCATE * pull + speed * speed / (2.0 * accel)) * steps
            }
            (Phase::Begin | Phase::Free, _) => {
                homing.phase = Phase::Seek;
                here + reach
            }
            (Phase::Seek, Some(edge)) => {
                homing.phase = Phase::Back;
                off(edge) as f64
            }
            (Phase::Back, _) => {
                homing.phase = Phase::Locate;
                here + sign * LOCATE * pull * steps
            }
            (Phase::Locate, Some(edge)) => {
                homing.phase = Phase::Off;
                off(edge) as f64
            }
            _ => {
                let travel = self.settings.axes(130)[axis];
                let place = if sign < 0.0 { pull - travel } else { -pull };
                self.motion.at[axis] = (place * steps).round() as i64;
                self.homing = Some(Homing { done: homing.done + 1, ..Homing::new() });
                return;
            }
        };
        homing.edge = None;
        self.homing = Some(homing);
        let slow = homing.phase == Phase::Locate;
        self.home_to(axis, to / steps, self.settings.get(if slow { 24 } else { 25 }));
    }

    /// Moves one axis to a position in mm, at `speed` in mm/min.
    fn home_to(&mut self, axis: usize, to: f64, speed: f64) {
        let from = self.place();
        let mut end = from;
        end.0[axis] = length(to);
        let feed = Length::from_picometres((speed * Length::PER_MM as f64) as i64);
        let kind = MoveKind::Feed(FeedRate::PerMinute(feed.unwrap_or(Length::MAX)));
        let part = Move { from, to: end, kind };
        let scales = Scales { feed: 1.0, rapid: 1.0 };
        let travel = Travel { part, line: None, spindle: Spindle::default(), tolerance: 0.0 };
        if !self.is_playable(&part)
            || self.motion.add(self.now, &self.settings, scales, &travel).is_err()
        {
            self.brake(After::Alarm(NOT_FOUND));
        }
    }

    fn end_homing(&mut self) {
        self.homing = None;
        self.find_place();
        self.state = State::Idle;
    }
}
