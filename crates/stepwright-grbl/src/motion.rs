//! The path: moves in, steps out at their times.
//!
//! ```text
//!   Move ──► Route: look-ahead, one clock from its start on ──► steps that are due
//! ```
//!
//! A route begins a little after its first move, so that what a sender says in one breath is
//! planned together. While the sender is late it goes on by what is known, always able to stop
//! where that ends.

use std::collections::VecDeque;

use stepwright_gcode::{Length, Move, MoveKind, Spindle};
use stepwright_path::{AxisPace, Route, RouteStep, Unplannable, millimetres};

use crate::settings::GrblSettings;

/// Moves that are planned ahead: with short chords a way to brake.
pub(crate) const BLOCKS: usize = 128;

/// Seconds from the first move to its start.
const BREATH: f64 = 0.02;

/// The length of n millimetres, as near as picometres are.
pub(crate) fn length(mm: f64) -> Length {
    let picometres = (mm * Length::PER_MM as f64).round();
    Length::from_picometres(picometres as i64).unwrap_or(Length::MAX)
}

/// A move that is on its way.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// Units along the route to its end.
    end: f64,
    /// The number of its line, if it has one.
    line: Option<u32>,
    tool: ToolState,
}

/// What a laser or a spindle does along a move.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ToolState {
    pub spindle: Spindle,
    /// A laser is off on its way.
    pub rapid: bool,
    /// The ordered speed in mm/s.
    pub feed: f64,
}

/// A route with the time at which it began.
#[derive(Clone, Debug)]
struct Live {
    route: Route<3>,
    epoch: f64,
    /// The next step, before it is due.
    ahead: Option<RouteStep>,
    blocks: VecDeque<Block>,
    /// It is to stand.
    holds: bool,
}

/// Three axes and the path they follow.
#[derive(Clone, Debug, Default)]
pub(crate) struct Motion {
    /// Each axis' steps from machine zero.
    pub at: [i64; 3],
    live: Option<Live>,
}

/// A step that is due.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Due {
    pub time: f64,
    pub axis: usize,
    pub forward: bool,
}

impl Motion {
    /// Whether nothing is on its way.
    pub fn is_over(&self) -> bool {
        self.live.is_none()
    }

    /// Whether it stands because it is held.
    pub fn is_held(&self, now: f64) -> bool {
        let still = |live: &Live| {
            live.holds
                && live.ahead.is_none()
                && live.route.is_held()
                && now >= live.epoch + live.route.time()
        };
        self.live.as_ref().is_some_and(still)
    }

    /// Moves that may be added.
    pub fn room(&self) -> usize {
        BLOCKS - self.live.as_ref().map_or(0, |live| live.blocks.len())
    }

    /// mm/s along the path.
    pub fn speed(&self, now: f64) -> f64 {
        let speed = |live: &Live| live.route.along(now - live.epoch).1;
        if self.is_held(now) { 0.0 } else { self.live.as_ref().map_or(0.0, speed) }
    }

    /// The number of the line that is on its way.
    pub fn line(&self) -> Option<u32> {
        self.live.as_ref()?.blocks.front()?.line
    }

    /// What a laser does now; `None` if nothing is on its way.
    pub fn tool(&self) -> Option<ToolState> {
        Some(self.live.as_ref()?.blocks.front()?.tool)
    }

    /// Adds a move, which [`room`](Motion::room) was there for.
    ///
    /// # Errors
    /// [`Unplannable`]: a setting or a feed rate is beyond what can be planned.
    pub fn add(
        &mut self,
        now: f64,
        settings: &GrblSettings,
        scales: Scales,
        part: &Move,
        line: Option<u32>,
        spindle: Spindle,
    ) -> Result<(), Unplannable> {
        let pace = axes(settings);
        let mut live = match self.live.take() {
            Some(live) => live,
            None => {
                let mut route = Route::at(pace, millimetres(part.from))?.standing_at(self.at);
                if settings.get(11) > 0.0 {
                    route = route.with_deviation(settings.get(11))?;
                }
                route.scale(0.0, scales.feed)?;
                route.scale_rapids(0.0, scales.rapid)?;
                Live {
                    route,
                    epoch: now + BREATH,
                    ahead: None,
                    blocks: VecDeque::new(),
                    holds: false,
                }
            }
        };
        let added = live.route.travel(part);
        let rapid = matches!(part.kind, MoveKind::Rapid);
        let end = live.route.length();
        let feed = *added.as_ref().unwrap_or(&0.0);
        let tool = ToolState { spindle, rapid, feed };
        if added.is_ok() {
            live.blocks.push_back(Block { end, line, tool });
        }
        if !live.blocks.is_empty() {
            self.live = Some(live);
        }
        added.map(|_| ())
    }

    /// Brakes, and stands until it is resumed.
    pub fn hold(&mut self, now: f64) {
        if let Some(live) = &mut self.live {
            live.holds = true;
            live.route.hold(now - live.epoch);
        }
    }

    /// Goes on.
    pub fn resume(&mut self, now: f64) {
        if let Some(live) = &mut self.live {
            live.holds = false;
            live.route.resume(now - live.epoch);
        }
    }

    /// Brakes, and drops what is left.
    pub fn cancel(&mut self, now: f64) {
        if let Some(live) = &mut self.live {
            live.holds = false;
            live.route.cancel(now - live.epoch);
        }
    }

    /// Other parts of the ordered speeds from now on.
    pub fn scale(&mut self, now: f64, scales: Scales) {
        if let Some(live) = &mut self.live {
            // Numbers within the range, always.
            _ = live.route.scale(now - live.epoch, scales.feed);
            _ = live.route.scale_rapids(now - live.epoch, scales.rapid);
        }
    }

    /// The next step that is due by now.
    pub fn next(&mut self, now: f64) -> Option<Due> {
        loop {
            let live = self.live.as_mut()?;
            if let Some(RouteStep { time, axis, forward }) = live.ahead {
                let time = live.epoch + time;
                if time > now {
                    live.forget(now);
                    return None;
                }
                live.ahead = None;
                self.at[axis] += if forward { 1 } else { -1 };
                return Some(Due { time, axis, forward });
            }
            live.ahead = live.route.next();
            if live.ahead.is_some() {
                continue;
            }
            let end = live.epoch + live.route.time();
            if live.route.is_over() {
                if now >= end {
                    self.live = None;
                }
                return None;
            }
            live.forget(now);
            if now < end || live.route.is_held() || !live.route.go_on() {
                return None;
            }
        }
    }
}

impl Live {
    /// Leaves the moves behind that are over.
    fn forget(&mut self, now: f64) {
        let (here, _) = self.route.along(now - self.epoch);
        while self.blocks.front().is_some_and(|block| block.end <= here) {
            self.blocks.pop_front();
        }
    }
}

/// Overrides: parts of what is ordered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scales {
    pub feed: f64,
    pub rapid: f64,
}

fn axes(settings: &GrblSettings) -> [AxisPace; 3] {
    let [steps, speed, accel, jump] = [100, 110, 120, 140].map(|number| settings.axes(number));
    std::array::from_fn(|axis| AxisPace {
        step: 1.0 / steps[axis],
        speed: speed[axis] / 60.0,
        accel: accel[axis],
        jump: jump[axis] / 60.0,
        jerk: f64::INFINITY,
    })
}
