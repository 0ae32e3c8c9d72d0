//! Looks at the axes, and notes their state.

use std::collections::VecDeque;

use stepwright_host::{Conversation, LinkError};
use stepwright_protocol::{AxisId, BoardError, Selection, Stop};

use crate::Hand;
use crate::homing::AxisHoming;
use crate::keeper::{Keeper, KeeperDesk};
use crate::report::{LiveAxis, Reason};
use crate::request::home::HomeReport;

/// The time over which a speed is measured, in s.
const WINDOW: f64 = 0.1;

/// The known state of an axis.
pub struct Watched {
    pub id: AxisId,
    pub position: Option<i64>,
    /// Whether it moves, by the last look.
    pub moving: bool,
    pub stop: Option<Stop>,
    /// The hand of its endless run.
    pub hand: Option<Hand>,
    /// Where its travel began.
    pub from: Option<i64>,
    /// The target of its travel.
    pub target: Option<i64>,
    /// Its homing in progress.
    pub homing: Option<AxisHoming>,
    /// The report of its present or last homing.
    pub home: Option<HomeReport>,
    /// How often another place was made 0.
    origin: u32,
    /// The last times in s, and the positions at these times.
    seen: VecDeque<(f64, i64)>,
}

impl Watched {
    /// An axis of which nothing is known yet.
    pub fn new(id: AxisId) -> Watched {
        Watched {
            id,
            position: None,
            moving: false,
            stop: None,
            hand: None,
            from: None,
            target: None,
            homing: None,
            home: None,
            origin: 0,
            seen: VecDeque::new(),
        }
    }

    /// Notes its position at a time in s.
    pub fn see(&mut self, time: f64, position: Option<i64>) {
        self.position = position;
        match position {
            Some(at) => self.seen.push_back((time, at)),
            None => self.seen.clear(),
        }
        while self.seen.get(1).is_some_and(|(then, _)| time - then >= WINDOW) {
            self.seen.pop_front();
        }
    }

    /// Notes that another place is 0: earlier positions no longer count.
    pub fn shift_origin(&mut self) {
        self.seen.clear();
        self.origin = self.origin.wrapping_add(1);
    }

    /// The speed in steps/s: the slope of the line through its last positions.
    fn speed(&self) -> f64 {
        let Some((first, from)) = self.seen.front().copied().filter(|_| self.moving) else {
            return 0.0;
        };
        let count = self.seen.len() as f64;
        let places = || self.seen.iter().map(|(time, at)| (time - first, (at - from) as f64));
        let (times, ways) = places().fold((0.0, 0.0), |(t, s), (time, way)| (t + time, s + way));
        let (time, way) = (times / count, ways / count);
        let (mut above, mut below) = (0.0, 0.0);
        for (t, s) in places() {
            above += (t - time) * (s - way);
            below += (t - time) * (t - time);
        }
        if below > 0.0 { above / below } else { 0.0 }
    }

    /// The state for pages. `now` is the time if the axis was not seen yet.
    pub fn state(&self, now: f64) -> LiveAxis {
        // Between two legs of a homing the axis counts as moving.
        let moving = self.moving || self.homing.is_some();
        LiveAxis {
            axis: self.id.number(),
            position: self.position,
            time: self.seen.back().map_or(now, |(time, _)| *time),
            speed: self.speed(),
            moving,
            state: match (self.position, moving) {
                (None, _) => "uncertain",
                (_, true) => "busy",
                (_, false) => "ready",
            },
            stop: self.stop.map(reason),
            home: self.home.clone(),
            origin: self.origin,
        }
    }
}

/// The reason of a stop, for pages.
pub fn reason(stop: Stop) -> Reason {
    Reason { name: stop.name().to_owned(), words: stop.words() }
}

impl<D: KeeperDesk> Keeper<D> {
    /// Looks at the axes that move.
    pub(crate) async fn look(&mut self, talk: &mut Conversation) -> Result<(), LinkError> {
        let mut ended = false;
        for place in 0..self.axes.len() {
            if self.axes.get(place).is_some_and(|axis| axis.moving) {
                // A stop that waits goes first.
                if self.desk.is_urgent() {
                    return Ok(());
                }
                ended |= self.look_at(talk, place).await?;
            }
        }
        if ended {
            self.ask_why(talk).await?;
            self.end_lease(talk).await?;
        }
        Ok(())
    }

    /// Looks at all axes, and at the board's errors.
    pub(crate) async fn look_at_all(&mut self, talk: &mut Conversation) -> Result<(), LinkError> {
        for place in 0..self.axes.len() {
            if self.desk.is_urgent() {
                return Ok(());
            }
            self.look_at(talk, place).await?;
        }
        self.ask_why(talk).await?;
        self.end_lease(talk).await
    }

    /// Looks at one axis. Returns whether it has come to rest since the last look.
    async fn look_at(&mut self, talk: &mut Conversation, place: usize) -> Result<bool, LinkError> {
        let Some(axis) = self.axes.get_mut(place) else { return Ok(false) };
        let id = axis.id;
        // First whether it rests, then the position: in the other order it might move on in between.
        let busy = talk.is_busy(Selection::One(id)).await?;
        let position = talk.position(id).await?;
        axis.see(self.desk.time(), position);
        let ended = axis.moving && !busy;
        axis.moving = busy;
        if !busy {
            axis.hand = None;
        }
        Ok(ended)
    }

    /// Asks why axes have stopped, and for the board's errors.
    pub(crate) async fn ask_why(&mut self, talk: &mut Conversation) -> Result<(), LinkError> {
        let Some(info) = talk.ask_info().await? else { return Ok(()) };
        for axis in &mut self.axes {
            axis.stop = info.stops.and_then(|stops| stops.of(axis.id)).filter(|_| !axis.moving);
        }
        let reason =
            |error: BoardError| Reason { name: error.name().to_owned(), words: error.words() };
        self.told.late = info.late;
        self.told.refused = info.refused;
        self.told.errors = info.errors.into_iter().flat_map(|e| e.iter()).map(reason).collect();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speed_is_that_of_the_last_tenth_of_a_second() {
        let mut axis = Watched::new(AxisId::FIRST);
        axis.moving = true;
        assert_eq!(axis.speed(), 0.0);
        // 200 steps/s, then −1000 steps/s for longer than the window.
        let mut at = 0;
        for look in 0..40 {
            at += if look < 20 { 4 } else { -20 };
            axis.see(f64::from(look) * 0.02, Some(at));
            let right = match look {
                3..20 => 200.0,
                26.. => -1000.0,
                _ => continue,
            };
            assert!((axis.speed() - right).abs() < 1e-6, "{look}: {}", axis.speed());
        }
        axis.moving = false;
        assert_eq!(axis.speed(), 0.0);
        axis.moving = true;
        axis.see(1.0, None);
        assert_eq!((axis.speed(), axis.state(0.0).state), (0.0, "uncertain"));
    }
}
