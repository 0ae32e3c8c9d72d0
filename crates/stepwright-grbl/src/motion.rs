//! The path: takes moves, and gives steps with their times.
//!
//! ```text
//!   Move ──► Route: look-ahead, one clock from its start on ──► steps that are due
//! ```
//!
//! A route begins a little after its first move, so that moves that a sender sends together are
//! planned together. While the sender is late, the route continues with the moves that are known,
//! and can always stop at the end of the last one.

use std::collections::VecDeque;

use stepwright_gcode::{Length, Move, Spindle};
use stepwright_path::{ArcFit, AxisPace, LaserMove, Lead, Planned, Route, RouteStep};
use stepwright_path::{Unplannable, millimetres};

use crate::settings::GrblSettings;

/// The number of moves that are planned ahead. With short chords they must suffice for braking.
pub(crate) const BLOCKS: usize = 128;

/// The least time in s that a fed route rests at its end.
const TAIL: f64 = 0.15;

/// Seconds from the first move to the start of the route.
const BREATH: f64 = 0.02;

/// A length of `mm` millimetres, rounded to picometres and clamped to the range of lengths.
pub(crate) fn length(mm: f64) -> Length {
    clamped((mm * Length::PER_MM as f64).round() as i64)
}

/// A length in picometres, clamped to the range of lengths.
pub(crate) fn clamped(picometres: i64) -> Length {
    let most = if picometres < 0 { -Length::MAX } else { Length::MAX };
    Length::from_picometres(picometres).unwrap_or(most)
}

/// A move in the route.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// The distance along the route to its end.
    end: f64,
    /// The number of its line, if it has one.
    line: Option<u32>,
    laser: LaserMove,
}

/// A move from the reader.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Travel {
    pub part: Move,
    /// The number of its line, if it has one.
    pub line: Option<u32>,
    pub spindle: Spindle,
    /// How far the path may deviate from the move, in mm.
    pub tolerance: f64,
}

/// A route with the time at which it began.
#[derive(Clone, Debug)]
struct Live {
    /// Lines that wait to be fitted, each with its number and its laser data.
    fit: ArcFit<(Option<u32>, LaserMove), 3>,
    route: Route<3>,
    epoch: f64,
    /// The next step, before it is due.
    ahead: Option<RouteStep>,
    blocks: VecDeque<Block>,
    /// Whether it is on hold.
    holds: bool,
    /// Whether it was cancelled: what was told to the plan ahead is dropped.
    cancelled: bool,
    /// The result of the last move.
    added: Result<(), Unplannable>,
}

/// A change of a route in progress.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    Hold,
    Resume,
    Cancel,
    Scale(Scales),
}

/// An order to a route.
#[derive(Clone, Debug)]
enum Order {
    Travel(Travel),
    /// Continues with the moves that are known, since no more come.
    GoOn,
    /// Rests until this time.
    Rest(f64),
    Change(f64, Change),
}

/// A route of a machine that makes steps at once, or of one that is fed ahead.
#[derive(Clone, Debug)]
enum Track {
    Now(Box<Live>),
    Fed(Box<Fed>),
}

#[derive(Clone, Debug)]
struct Fed {
    lead: Lead<Live>,
    /// The time of the path, in s, up to which the board was told that there are no steps.
    known: f64,
    /// Requested changes without a time. `open` has those with a time, which may still be undone.
    wanted: Vec<Change>,
    open: Vec<Change>,
}

impl Track {
    /// The route's state at the machine's present time.
    fn here(&self) -> &Live {
        match self {
            Track::Now(live) => live,
            Track::Fed(fed) => fed.lead.behind(),
        }
    }
}

/// Three axes and their path.
#[derive(Clone, Debug, Default)]
pub(crate) struct Motion {
    /// Each axis' steps from machine zero.
    pub at: [i64; 3],
    track: Option<Track>,
    /// Whether the machine is fed ahead; and the number of routes so far.
    pub fed: bool,
    pub runs: u64,
}

/// A step that is due.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Due {
    pub time: f64,
    pub axis: usize,
    pub forward: bool,
}

impl Motion {
    /// Whether no route is in progress.
    pub fn is_over(&self) -> bool {
        self.track.is_none()
    }

    /// Whether the axes are at rest because of a hold.
    pub fn is_held(&self, now: f64) -> bool {
        let still = |live: &Live| {
            live.holds
                && live.ahead.is_none()
                && live.route.is_held()
                && now >= live.epoch + live.route.time()
        };
        self.here().is_some_and(still)
    }

    fn here(&self) -> Option<&Live> {
        self.track.as_ref().map(Track::here)
    }

    /// The number of moves that may be added.
    pub fn room(&self) -> usize {
        let blocks = match &self.track {
            None => 0,
            Some(Track::Now(live)) => live.moves(),
            Some(Track::Fed(fed)) => fed.lead.ahead().moves(),
        };
        BLOCKS.saturating_sub(blocks)
    }

    /// The speed along the path in mm/s.
    pub fn speed(&self, now: f64) -> f64 {
        let begun = self.here().filter(|live| now > live.epoch);
        let speed = |live: &Live| live.route.along(now - live.epoch).1;
        if self.is_held(now) { 0.0 } else { begun.map_or(0.0, speed) }
    }

    /// The number of the line of the present move.
    pub fn line(&self) -> Option<u32> {
        self.here()?.blocks.front()?.line
    }

    /// The laser data of the present move; `None` without a move.
    pub fn laser(&self) -> Option<LaserMove> {
        Some(self.here()?.blocks.front()?.laser)
    }

    /// The laser data of the move to which a fed route is planned, and the speed along the path there,
    /// at `time` of the path, in mm/s.
    pub fn planned_laser(&self, time: f64) -> Option<(LaserMove, f64)> {
        let Some(Track::Fed(fed)) = &self.track else { return None };
        let live = fed.lead.ahead();
        Some((live.blocks.front()?.laser, live.route.along(time).1))
    }

    /// Adds a move. [`room`](Motion::room) must not be 0.
    ///
    /// # Errors
    /// [`Unplannable`]: a setting or a feed rate is beyond what can be planned.
    pub fn add(
        &mut self,
        now: f64,
        settings: &GrblSettings,
        scales: Scales,
        travel: &Travel,
    ) -> Result<(), Unplannable> {
        let mut track = match self.track.take() {
            Some(track) => track,
            None => self.begin(now, settings, scales, travel)?,
        };
        let order = Order::Travel(*travel);
        let (added, empty) = match &mut track {
            Track::Now(live) => {
                live.obey(&order);
                (live.added, live.moves() == 0)
            }
            Track::Fed(fed) => {
                let live = fed.lead.ahead();
                if live.is_over() && live.route.time() < fed.known {
                    fed.lead.obey(Order::Rest(fed.known));
                }
                fed.lead.obey(order);
                let live = fed.lead.ahead();
                (live.added, live.moves() == 0 && fed.lead.made() == 0)
            }
        };
        if !empty {
            self.track = Some(track);
        }
        added
    }

    fn begin(
        &mut self,
        now: f64,
        settings: &GrblSettings,
        scales: Scales,
        travel: &Travel,
    ) -> Result<Track, Unplannable> {
        let mut route =
            Route::at(axes(settings), millimetres(travel.part.from))?.standing_at(self.at);
        if settings.get(11) > 0.0 {
            route = route.with_deviation(settings.get(11))?;
        }
        route.scale(0.0, scales.feed)?;
        route.scale_rapids(0.0, scales.rapid)?;
        let breath = if self.fed { 0.0 } else { BREATH };
        let live = Live {
            fit: ArcFit::new(travel.tolerance)?,
            route,
            epoch: now + breath,
            ahead: None,
            blocks: VecDeque::new(),
            holds: false,
            cancelled: false,
            added: Ok(()),
        };
        self.runs += 1;
        Ok(if self.fed {
            let lead = Lead::new(live);
            Track::Fed(Box::new(Fed { lead, known: 0.0, wanted: Vec::new(), open: Vec::new() }))
        } else {
            Track::Now(Box::new(live))
        })
    }

    /// Brakes, and waits for [`resume`](Motion::resume).
    pub fn hold(&mut self, now: f64) {
        self.change(now, Change::Hold);
    }

    /// Resumes after a hold.
    pub fn resume(&mut self, now: f64) {
        self.change(now, Change::Resume);
    }

    /// Brakes, and drops the rest of the route.
    pub fn cancel(&mut self, now: f64) {
        self.change(now, Change::Cancel);
    }

    /// Changes the scales of the ordered speeds from now on.
    pub fn scale(&mut self, now: f64, scales: Scales) {
        self.change(now, Change::Scale(scales));
    }

    fn change(&mut self, now: f64, change: Change) {
        match &mut self.track {
            Some(Track::Now(live)) => live.change(now - live.epoch, change),
            Some(Track::Fed(fed)) => fed.wanted.push(change),
            None => {}
        }
    }

    /// The next step that is due by now.
    pub fn next(&mut self, now: f64) -> Option<Due> {
        let due = match self.track.as_mut()? {
            Track::Now(live) => live.due(now),
            Track::Fed(fed) => {
                let epoch = fed.lead.behind().epoch;
                let due = fed.lead.pass(now - epoch);
                due.map(|step| Due { time: epoch + step.time, ..Due::from(step) })
            }
        };
        if let Some(due) = due {
            self.at[due.axis] += if due.forward { 1 } else { -1 };
        } else if self.track.as_ref().is_some_and(|track| track.is_over(now)) {
            self.track = None;
        }
        due
    }

    /// The next part of a fed route. If `late`, continues with the moves that are known. A rest is
    /// told up to `rest`, a time of the path.
    pub fn plan(&mut self, late: bool, rest: f64) -> Option<Coming> {
        let Some(Track::Fed(fed)) = &mut self.track else { return None };
        loop {
            if let Some(step) = fed.lead.plan() {
                return Some(Coming::Step(step));
            }
            let live = fed.lead.ahead();
            if live.is_over() || live.route.is_held() {
                fed.known = fed.known.max(rest).max(live.route.time() + TAIL);
                return Some(Coming::Rest(fed.known));
            }
            if !late {
                return None;
            }
            fed.lead.obey(Order::GoOn);
        }
    }

    /// Whether a fed route is to change: `Some(true)` if all changes brake; `None` if there are
    /// none.
    pub fn wants_change(&self) -> Option<bool> {
        let Some(Track::Fed(fed)) = &self.track else { return None };
        let brakes = |change: &Change| matches!(change, Change::Hold | Change::Cancel);
        if fed.wanted.is_empty() { None } else { Some(fed.wanted.iter().all(brakes)) }
    }

    /// Whether a fed route is to brake.
    pub fn wants_stop(&self) -> bool {
        let Some(Track::Fed(fed)) = &self.track else { return false };
        fed.wanted.iter().any(|change| matches!(change, Change::Hold | Change::Cancel))
    }

    /// Plans a fed route that has not begun once more, with the requested changes.
    pub fn start_over(&mut self) {
        let Some(Track::Fed(fed)) = &self.track else { return };
        let cancels = fed.wanted.contains(&Change::Cancel);
        self.change_from(0.0, 0);
        self.changed(true);
        if cancels {
            // Nothing is left, which the plan learns when it is asked.
            self.plan(true, 0.0);
        }
    }

    /// Makes the requested changes at this time of the path, after this many steps.
    pub fn change_from(&mut self, time: f64, steps: u64) {
        let Some(Track::Fed(fed)) = &mut self.track else { return };
        fed.open = std::mem::take(&mut fed.wanted);
        let orders: Vec<Order> =
            fed.open.iter().map(|change| Order::Change(time, *change)).collect();
        fed.lead.cut(steps, &orders);
        fed.known = time;
    }

    /// Keeps the changes if they were `made`; otherwise undoes them, and requests them again.
    pub fn changed(&mut self, made: bool) {
        let Some(Track::Fed(fed)) = &mut self.track else { return };
        if made {
            fed.lead.keep_cut();
            fed.open.clear();
        } else {
            fed.lead.undo_cut();
            let wanted = std::mem::take(&mut fed.wanted);
            fed.wanted = fed.open.drain(..).chain(wanted).collect();
        }
    }

    /// Drops the route, and sets the axes' positions.
    pub fn drop_at(&mut self, at: [i64; 3]) {
        (self.track, self.at) = (None, at);
    }
}

/// The next part of a fed route.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coming {
    /// A step, at its time in s after the start of the route.
    Step(RouteStep),
    /// No step before this time.
    Rest(f64),
}

impl From<RouteStep> for Due {
    fn from(step: RouteStep) -> Due {
        Due { time: step.time, axis: step.axis, forward: step.forward }
    }
}

impl Track {
    /// Whether the route has ended.
    fn is_over(&self, now: f64) -> bool {
        let live = self.here();
        let fed = match self {
            Track::Now(_) => true,
            Track::Fed(fed) => {
                fed.lead.done() == fed.lead.made() && fed.wanted.is_empty() && fed.open.is_empty()
            }
        };
        fed && live.ahead.is_none() && live.is_over() && now >= live.epoch + live.route.time()
    }
}

impl Planned for Live {
    type Order = Order;

    fn step(&mut self) -> Option<RouteStep> {
        let step = self.route.next();
        if let Some(step) = step {
            self.forget(step.time);
        }
        step
    }

    fn obey(&mut self, order: &Order) {
        match order {
            Order::Travel(_) | Order::Rest(_) if self.cancelled => {}
            Order::Travel(travel) => self.added = self.travel(travel),
            Order::GoOn => _ = self.go_on(),
            Order::Rest(until) => _ = self.route.dwell(until - self.route.time()),
            Order::Change(at, change) => self.change(*at, *change),
        }
    }

    fn stays(order: &Order) -> bool {
        !matches!(order, Order::GoOn)
    }
}

impl Live {
    /// The number of moves in the route and waiting.
    fn moves(&self) -> usize {
        self.blocks.len() + self.fit.waiting()
    }

    fn is_over(&self) -> bool {
        self.route.is_over() && self.fit.waiting() == 0
    }

    fn travel(&mut self, travel: &Travel) -> Result<(), Unplannable> {
        let Travel { part, line, spindle, tolerance } = *travel;
        self.fit.set_tolerance(&mut self.route, tolerance)?;
        let tag = |feed| (line, LaserMove::new(&part, spindle, feed));
        let added = self.fit.travel(&mut self.route, &part, tag);
        self.settled();
        added
    }

    /// Continues with all moves that are known. Returns whether there were any.
    fn go_on(&mut self) -> bool {
        // These lines were checked before.
        _ = self.fit.settle(&mut self.route);
        self.settled();
        self.route.go_on()
    }

    /// Notes the ends of moves that were added to the route.
    fn settled(&mut self) {
        while let Some((end, (line, laser))) = self.fit.settled() {
            self.blocks.push_back(Block { end, line, laser });
        }
    }

    /// Makes a change at this time of the path.
    fn change(&mut self, at: f64, change: Change) {
        match change {
            Change::Hold => {
                self.holds = true;
                self.route.hold(at);
            }
            Change::Resume => {
                self.holds = false;
                self.route.resume(at);
            }
            Change::Cancel => {
                (self.holds, self.cancelled) = (false, true);
                self.fit.clear();
                self.route.cancel(at);
            }
            Change::Scale(scales) => {
                // Scales are always within the range.
                _ = self.route.scale(at, scales.feed);
                _ = self.route.scale_rapids(at, scales.rapid);
            }
        }
    }

    /// The next step that is due by now.
    fn due(&mut self, now: f64) -> Option<Due> {
        loop {
            if let Some(step) = self.ahead {
                let time = self.epoch + step.time;
                if time > now {
                    self.forget(now - self.epoch);
                    return None;
                }
                self.ahead = None;
                return Some(Due { time, ..Due::from(step) });
            }
            self.ahead = self.route.next();
            if self.ahead.is_some() {
                continue;
            }
            let end = self.epoch + self.route.time();
            if self.is_over() {
                return None;
            }
            self.forget(now - self.epoch);
            if now < end || self.route.is_held() || !self.go_on() {
                return None;
            }
        }
    }

    /// Drops the moves that have ended at this time of the path.
    fn forget(&mut self, time: f64) {
        let (here, _) = self.route.along(time);
        while self.blocks.front().is_some_and(|block| block.end <= here) {
            self.blocks.pop_front();
        }
    }
}

/// Overrides: factors for the ordered speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scales {
    pub feed: f64,
    pub rapid: f64,
}

fn axes(settings: &GrblSettings) -> [AxisPace; 3] {
    let [steps, speed, accel, jump, jerk] =
        [100, 110, 120, 140, 150].map(|number| settings.axes(number));
    std::array::from_fn(|axis| AxisPace {
        step: 1.0 / steps[axis],
        speed: speed[axis] / 60.0,
        accel: accel[axis],
        jump: jump[axis] / 60.0,
        jerk: if jerk[axis] > 0.0 { jerk[axis] } else { f64::INFINITY },
    })
}
