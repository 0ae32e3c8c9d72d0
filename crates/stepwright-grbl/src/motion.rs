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

use stepwright_gcode::{Length, Move, Spindle};
use stepwright_path::{ArcFit, AxisPace, LaserMove, Lead, Planned, Route, RouteStep};
use stepwright_path::{Unplannable, millimetres};

use crate::settings::GrblSettings;

/// Moves that are planned ahead: with short chords a way to brake.
pub(crate) const BLOCKS: usize = 128;

/// Seconds that a route which is fed rests at its end, at least.
const TAIL: f64 = 0.15;

/// Seconds from the first move to its start.
const BREATH: f64 = 0.02;

/// The length of n millimetres, as near as picometres are, and as a length can be.
pub(crate) fn length(mm: f64) -> Length {
    clamped((mm * Length::PER_MM as f64).round() as i64)
}

/// The length of n picometres, as near as a length can be.
pub(crate) fn clamped(picometres: i64) -> Length {
    let most = if picometres < 0 { -Length::MAX } else { Length::MAX };
    Length::from_picometres(picometres).unwrap_or(most)
}

/// A move that is on its way.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// Units along the route to its end.
    end: f64,
    /// The number of its line, if it has one.
    line: Option<u32>,
    laser: LaserMove,
}

/// A move as it was read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Travel {
    pub part: Move,
    /// The number of its line, if it has one.
    pub line: Option<u32>,
    pub spindle: Spindle,
    /// How far the path may be off it, in mm.
    pub tolerance: f64,
}

/// A route with the time at which it began.
#[derive(Clone, Debug)]
struct Live {
    /// Lines that wait, each with its number and what a laser does.
    fit: ArcFit<(Option<u32>, LaserMove), 3>,
    route: Route<3>,
    epoch: f64,
    /// The next step, before it is due.
    ahead: Option<RouteStep>,
    blocks: VecDeque<Block>,
    /// It is to stand.
    holds: bool,
    /// What came of the last move.
    added: Result<(), Unplannable>,
}

/// What changes the way on which it is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    Hold,
    Resume,
    Cancel,
    Scale(Scales),
}

/// What a route is told.
#[derive(Clone, Debug)]
enum Order {
    Travel(Travel),
    /// By what is known, as nothing else comes.
    GoOn,
    /// It rests until this time.
    Rest(f64),
    Change(f64, Change),
}

/// The route of a machine that makes steps when they are asked for, or of one that is fed before.
#[derive(Clone, Debug)]
enum Track {
    Now(Box<Live>),
    Fed(Box<Fed>),
}

#[derive(Clone, Debug)]
struct Fed {
    lead: Lead<Live>,
    /// Seconds of the path up to which it was said that nothing comes.
    known: f64,
    /// What is asked for, and has no time yet; and what has got one that may not be kept.
    wanted: Vec<Change>,
    open: Vec<Change>,
}

impl Track {
    /// Where the machine is.
    fn here(&self) -> &Live {
        match self {
            Track::Now(live) => live,
            Track::Fed(fed) => fed.lead.behind(),
        }
    }
}

/// Three axes and the path they follow.
#[derive(Clone, Debug, Default)]
pub(crate) struct Motion {
    /// Each axis' steps from machine zero.
    pub at: [i64; 3],
    track: Option<Track>,
    /// The machine is fed before it moves; and routes so far.
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
    /// Whether nothing is on its way.
    pub fn is_over(&self) -> bool {
        self.track.is_none()
    }

    /// Whether it stands because it is held.
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

    /// Moves that may be added.
    pub fn room(&self) -> usize {
        let blocks = match &self.track {
            None => 0,
            Some(Track::Now(live)) => live.moves(),
            Some(Track::Fed(fed)) => fed.lead.ahead().moves(),
        };
        BLOCKS.saturating_sub(blocks)
    }

    /// mm/s along the path.
    pub fn speed(&self, now: f64) -> f64 {
        let begun = self.here().filter(|live| now > live.epoch);
        let speed = |live: &Live| live.route.along(now - live.epoch).1;
        if self.is_held(now) { 0.0 } else { begun.map_or(0.0, speed) }
    }

    /// The number of the line that is on its way.
    pub fn line(&self) -> Option<u32> {
        self.here()?.blocks.front()?.line
    }

    /// What a laser does now; `None` if nothing is on its way.
    pub fn laser(&self) -> Option<LaserMove> {
        Some(self.here()?.blocks.front()?.laser)
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

    /// Brakes, and stands until it is resumed.
    pub fn hold(&mut self, now: f64) {
        self.change(now, Change::Hold);
    }

    /// Goes on.
    pub fn resume(&mut self, now: f64) {
        self.change(now, Change::Resume);
    }

    /// Brakes, and drops what is left.
    pub fn cancel(&mut self, now: f64) {
        self.change(now, Change::Cancel);
    }

    /// Other parts of the ordered speeds from now on.
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

    /// What comes next of a route that is fed: `late` goes on by what is known, and `rest` is the time
    /// of the path up to which it may rest.
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

    /// Whether a route that is fed is to change; and if so, whether it brakes.
    pub fn wants_change(&self) -> Option<bool> {
        let Some(Track::Fed(fed)) = &self.track else { return None };
        let brakes = |change: &Change| matches!(change, Change::Hold | Change::Cancel);
        if fed.wanted.is_empty() { None } else { Some(fed.wanted.iter().all(brakes)) }
    }

    /// It changes from this time of the path on, behind this many steps.
    pub fn change_from(&mut self, time: f64, steps: u64) {
        let Some(Track::Fed(fed)) = &mut self.track else { return };
        fed.open = std::mem::take(&mut fed.wanted);
        let orders: Vec<Order> =
            fed.open.iter().map(|change| Order::Change(time, *change)).collect();
        fed.lead.cut(steps, &orders);
        fed.known = time;
    }

    /// Whether the change from that time on was made.
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

    /// Nothing of it is left, and the axes are there.
    pub fn drop_at(&mut self, at: [i64; 3]) {
        (self.track, self.at) = (None, at);
    }
}

/// What comes next of a route.
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
    /// Whether nothing of it is left.
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
    /// Moves that are on their way, or wait.
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

    /// By all that is known.
    fn go_on(&mut self) -> bool {
        // Lines that were checked.
        _ = self.fit.settle(&mut self.route);
        self.settled();
        self.route.go_on()
    }

    /// Takes down where moves end that the route has got.
    fn settled(&mut self) {
        while let Some((end, (line, laser))) = self.fit.settled() {
            self.blocks.push_back(Block { end, line, laser });
        }
    }

    /// From this time of the path on.
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
                self.holds = false;
                self.fit.clear();
                self.route.cancel(at);
            }
            Change::Scale(scales) => {
                // Numbers within the range, always.
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

    /// Leaves the moves behind that are over at this time of the path.
    fn forget(&mut self, time: f64) {
        let (here, _) = self.route.along(time);
        while self.blocks.front().is_some_and(|block| block.end <= here) {
            self.blocks.pop_front();
        }
    }
}

/// Overrides: parts of what is ordered.
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
