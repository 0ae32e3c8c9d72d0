//! The pulses of one law: curves to draw, and figures.
//!
//! Every pulse is visited. The curves keep few of them: a point is kept if it is so far in time after the point
//! before that both can be told apart in a picture. If there are too many points, every second one is dropped,
//! and the distance is doubled.

use stepwright::Ticks;

use stepwright_oracle::IdealTrapezoid;

use crate::ideal::{self, steps_per_second};
use crate::order::{PlanLaw, PlanOrder, PlanRefusal};

/// The most points of a curve.
pub const MOST_POINTS: usize = 2048;

/// The points of a curve with the duration of constant acceleration.
const POINTS: f64 = 1400.0;

/// The curves, one column each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanColumn {
    /// Seconds after the first pulse.
    Time,
    /// Steps from the first pulse.
    Position,
    /// Steps/s.
    Speed,
    /// Steps/s².
    Accel,
    /// The interval between pulses, in µs; NaN at the first pulse.
    Interval,
    /// How far delays are above those of constant acceleration, in percent; NaN at the first pulse.
    Deviation,
}

impl PlanColumn {
    /// All columns, in the order of their numbers.
    pub const ALL: [PlanColumn; 6] = [
        PlanColumn::Time,
        PlanColumn::Position,
        PlanColumn::Speed,
        PlanColumn::Accel,
        PlanColumn::Interval,
        PlanColumn::Deviation,
    ];
}

/// The figures of a plan. A page reads them as numbers in this order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Figures {
    /// The number of pulses.
    pub pulses: f64,
    /// The time from the first pulse to the last, in ticks.
    pub ticks: f64,
    /// The same in seconds.
    pub seconds: f64,
    /// The highest speed, in steps/s.
    pub peak: f64,
    /// The braking distance in steps.
    pub braking_steps: f64,
    /// The braking time, in s.
    pub braking_seconds: f64,
    /// The largest distance of a pulse from its time by the law, in ticks.
    pub error: f64,
    /// The number of that pulse, counted from 1; 0 if there is none.
    pub error_step: f64,
    /// The largest difference of a delay from that of constant acceleration, in percent of the latter.
    pub deviation: f64,
    /// The number of the pulse after that delay, counted from 1; 0 if there is none.
    pub deviation_step: f64,
    /// The root mean square of these differences, in percent.
    pub deviation_rms: f64,
    /// Seconds lost against constant acceleration.
    pub lost: f64,
    /// The first delay, in ticks.
    pub first: f64,
    /// The shortest delay, in ticks.
    pub shortest: f64,
    /// The number of points of the curves.
    pub points: f64,
}

impl Figures {
    /// The number of figures.
    pub const COUNT: usize = size_of::<Figures>() / size_of::<f64>();
}

/// A pulse that is shown in the curves.
#[derive(Clone, Copy, Debug)]
struct Shown {
    n: f64,
    /// Its time by the law, and by constant acceleration, in seconds.
    time: f64,
    constant: f64,
}

/// Plans travels one after the other, in the same memory.
#[derive(Clone, Debug)]
pub struct Planner {
    shown: [Shown; MOST_POINTS],
    count: usize,
    columns: [[f64; MOST_POINTS]; PlanColumn::ALL.len()],
    figures: Figures,
    hash: u64,
}

impl Default for Planner {
    fn default() -> Planner {
        Planner::new()
    }
}

impl Planner {
    /// A planner that has planned nothing.
    pub const fn new() -> Planner {
        const FIGURES: Figures = Figures {
            pulses: 0.0,
            ticks: 0.0,
            seconds: 0.0,
            peak: 0.0,
            braking_steps: 0.0,
            braking_seconds: 0.0,
            error: 0.0,
            error_step: 0.0,
            deviation: 0.0,
            deviation_step: 0.0,
            deviation_rms: 0.0,
            lost: 0.0,
            first: 0.0,
            shortest: 0.0,
            points: 0.0,
        };
        Planner {
            shown: [Shown { n: 0.0, time: 0.0, constant: 0.0 }; MOST_POINTS],
            count: 0,
            columns: [[0.0; MOST_POINTS]; PlanColumn::ALL.len()],
            figures: FIGURES,
            hash: 0,
        }
    }

    /// Plans a travel by a law.
    ///
    /// # Errors
    /// The law or the timer can't hold the travel. There is no plan then.
    pub fn plan(&mut self, law: PlanLaw, order: &PlanOrder) -> Result<(), PlanRefusal> {
        self.count = 0;
        self.figures = Figures::default();
        self.hash = SEED;
        law.walk(order, self)
    }

    /// The figures of the last plan.
    pub fn figures(&self) -> &Figures {
        &self.figures
    }

    /// A hash of all delays: FNV-1a over words of 32 bits.
    pub fn hash(&self) -> u64 {
        self.hash
    }

    /// The points of a curve.
    pub fn column(&self, column: PlanColumn) -> &[f64] {
        let all = self.columns.get(column as usize).map_or(&[][..], |all| all);
        all.get(..self.count).unwrap_or(&[])
    }

    /// All curves in memory, [`MOST_POINTS`] numbers each.
    pub(crate) fn columns(&self) -> *const f64 {
        self.columns.as_ptr().cast()
    }

    /// Makes the curves of the shown pulses. `start` is the speed at both ends, `edge` the acceleration there,
    /// if the law gives it.
    fn draw(&mut self, pulses: u32, start: f64, edge: Option<f64>) {
        let shown = self.shown.get(..self.count).unwrap_or(&[]);
        let [times, places, speeds, accels, intervals, deviations] = &mut self.columns;
        let last = f64::from(pulses.saturating_sub(1));
        let slope = |a: &Shown, b: &Shown| (b.n - a.n) / (b.time - a.time);
        for (i, here) in shown.iter().enumerate() {
            let before = i.checked_sub(1).and_then(|at| shown.get(at));
            let behind = shown.get(i + 1);
            let (speed, accel) = match (before, behind) {
                (Some(a), Some(b)) => {
                    // The slope and the curvature of the parabola through three points.
                    let (v1, v2) = (slope(a, here), slope(here, b));
                    let (t1, t2) = (here.time - a.time, b.time - here.time);
                    ((v1 * t2 + v2 * t1) / (t1 + t2), 2.0 * (v2 - v1) / (t1 + t2))
                }
                (None, None) => (start, 0.0),
                // The ends of the travel, or of the window.
                _ if here.n == 0.0 || here.n == last => (start, f64::NAN),
                (Some(a), None) => (slope(a, here), f64::NAN),
                (None, Some(b)) => (slope(here, b), f64::NAN),
            };
            let (mut interval, mut deviation) = (f64::NAN, f64::NAN);
            if let Some(a) = before {
                interval = 1e6 / slope(a, here);
                deviation = ((here.time - a.time) / (here.constant - a.constant) - 1.0) * 100.0;
            }
            let row = [here.time, here.n, speed, accel, interval, deviation];
            let columns = [&mut *times, places, speeds, accels, intervals, deviations];
            for (column, value) in columns.into_iter().zip(row) {
                if let Some(place) = column.get_mut(i) {
                    *place = value;
                }
            }
        }
        // Otherwise the acceleration of the point beside the end.
        if let ([first, second, .., before, end], [begin, .., stop]) =
            (accels.get_mut(..shown.len()).unwrap_or(&mut []), shown)
        {
            *first = edge.filter(|_| begin.n == 0.0).unwrap_or(*second);
            *end = edge.filter(|_| stop.n == last).unwrap_or(*before);
        }
    }
}

const SEED: u64 = 0xcbf2_9ce4_8422_2325;

/// A walk over the pulses of a law.
pub(crate) struct Walk<'a> {
    planner: &'a mut Planner,
    order: PlanOrder,
    constant: IdealTrapezoid<f64>,
    /// Whether the law itself is constant acceleration.
    is_constant: bool,
    /// The duration of the same pulses with constant acceleration, in s.
    least: f64,
    start: f64,
    /// The last pulse, counted from 0; its time in ticks; and its time with constant acceleration.
    n: u32,
    ticks: u64,
    before: f64,
    /// Seconds between points.
    gap: f64,
    /// The sum of the squares of all differences from constant acceleration.
    squares: f64,
    /// The shortest delay by the law.
    fastest: f64,
    /// When the deceleration begins, in ticks.
    down: Option<u64>,
    down_steps: u32,
}

impl<'a> Walk<'a> {
    /// A walk after the first pulse. `start` is the speed at both ends. A law that `holds` omits its last
    /// delay, and is compared with a travel that is one step longer.
    pub fn new(planner: &'a mut Planner, order: &PlanOrder, holds: bool) -> Walk<'a> {
        let PlanOrder { steps, top, accel, decel, .. } = *order;
        let start = if holds { stepwright::Speed::ZERO } else { order.start };
        let of = |steps| ideal::constant(start, top, (accel, decel), steps);
        let (constant, least) = (of(steps.saturating_add(holds.into())), of(steps).total());
        let (from, to) = order.window;
        let mut walk = Walk {
            planner,
            order: *order,
            constant,
            is_constant: false,
            least,
            start: steps_per_second(start.min(top)),
            n: 0,
            ticks: 0,
            before: 0.0,
            gap: (to.min(least) - from).max(0.0) / POINTS,
            squares: 0.0,
            fastest: f64::INFINITY,
            down: None,
            down_steps: 0,
        };
        if steps > 0 {
            walk.mix(0);
            walk.show(0.0, || 0.0);
        }
        walk
    }

    /// A walk over constant acceleration itself.
    pub fn constant(planner: &'a mut Planner, order: &PlanOrder) -> Walk<'a> {
        Walk { is_constant: true, ..Walk::new(planner, order, false) }
    }

    /// Adds a delay and the pulse after it: the delay in whole ticks and by the law, whether it belongs to the
    /// deceleration, and the law's time of pulse `n`, in ticks.
    #[inline]
    pub fn pulse(&mut self, delay: Ticks, exact: f64, down: bool, due: impl Fn(u32) -> f64) {
        let hz = self.order.hz();
        if down {
            self.down.get_or_insert(self.ticks);
            self.down_steps += 1;
        }
        self.n += 1;
        self.ticks += u64::from(delay);
        self.mix(delay);
        self.fastest = self.fastest.min(exact);
        let figures = &mut self.planner.figures;
        let whole = f64::from(delay);
        if self.n == 1 {
            (figures.first, figures.shortest) = (whole, whole);
        }
        figures.shortest = figures.shortest.min(whole);
        if self.is_constant {
            let n = self.n;
            return self.show(self.ticks as f64 / hz, || due(n) / hz);
        }
        let constant = self.constant.time(self.n.into());
        let deviation = exact / ((constant - self.before) * hz) - 1.0;
        self.before = constant;
        self.squares += deviation * deviation;
        if deviation.abs() > figures.deviation.abs() {
            (figures.deviation, figures.deviation_step) = (deviation, f64::from(self.n) + 1.0);
        }
        let n = self.n;
        self.show(self.ticks as f64 / hz, || due(n) / hz);
    }

    /// Compares the last pulse with its time by the law, in ticks.
    #[inline]
    pub fn measure(&mut self, due: f64) {
        let off = (self.ticks as f64 - due).abs();
        let figures = &mut self.planner.figures;
        if off > figures.error || figures.error_step == 0.0 {
            (figures.error, figures.error_step) = (off, f64::from(self.n) + 1.0);
        }
    }

    /// Ends the walk after the last pulse. `peak` is the highest speed, and `edge` the acceleration at both
    /// ends, if the law gives them.
    pub fn end(self, peak: Option<f64>, edge: Option<f64>) {
        let hz = self.order.hz();
        let planner = self.planner;
        let figures = &mut planner.figures;
        let delays = f64::from(self.n).max(1.0);
        figures.pulses = f64::from(self.order.steps);
        figures.ticks = self.ticks as f64;
        figures.seconds = figures.ticks / hz;
        figures.peak = match peak {
            _ if self.n == 0 => 0.0,
            Some(peak) => peak,
            None => hz / self.fastest,
        };
        figures.braking_steps = self.down_steps.into();
        figures.braking_seconds = self.down.map_or(0.0, |at| (self.ticks - at) as f64 / hz);
        figures.deviation *= 100.0;
        figures.deviation_rms = libm::sqrt(self.squares / delays) * 100.0;
        figures.lost = figures.seconds - self.least;
        figures.points = planner.count as f64;
        planner.draw(self.order.steps, self.start, edge);
    }

    #[inline]
    fn mix(&mut self, delay: Ticks) {
        let hash = &mut self.planner.hash;
        *hash = (*hash ^ u64::from(delay)).wrapping_mul(0x0100_0000_01b3);
    }

    /// Keeps the last pulse for the curves, if it is in the window and far enough after the one before. `exact`
    /// returns its time by the law.
    #[inline]
    fn show(&mut self, time: f64, exact: impl FnOnce() -> f64) {
        let planner = &mut *self.planner;
        let (from, to) = self.order.window;
        let last = planner.count.checked_sub(1).and_then(|at| planner.shown.get(at).copied());
        let end = self.n.saturating_add(1) >= self.order.steps;
        let Some(last) = last else {
            return self.keep(exact());
        };
        if time <= from && planner.count == 1 {
            // The last pulse before the window begins the curves.
            planner.count = 0;
            return self.keep(if from > 0.0 { time } else { exact() });
        }
        if last.time > to || (time - last.time < self.gap && !end) {
            return;
        }
        if planner.count == MOST_POINTS {
            let mut kept = 0;
            for from in (0..MOST_POINTS).step_by(2) {
                if let Some(&shown) = planner.shown.get(from)
                    && let Some(place) = planner.shown.get_mut(kept)
                {
                    *place = shown;
                    kept += 1;
                }
            }
            planner.count = kept;
            self.gap *= 2.0;
        }
        self.keep(exact());
    }

    fn keep(&mut self, time: f64) {
        let constant = match self.n {
            0 => 0.0,
            _ if self.is_constant => time,
            n => self.constant.time(n.into()),
        };
        let shown = Shown { n: self.n.into(), time, constant };
        if let Some(place) = self.planner.shown.get_mut(self.planner.count) {
            *place = shown;
            self.planner.count += 1;
        }
    }
}
