//! Random travels, random changes, and then a soft stop: at any time a motor ends within the
//! braking distance of the deceleration in force, and no interval differs from the previous one by
//! more than the limits allow.
//!
//! Checked by the entries alone, with f64 and the physics of constant acceleration.
//!
//! `STEPWRIGHT_CASES` sets the number of sequences in each test.

use std::cell::Cell;

use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use stepwright::engine::WIRING;
use stepwright::entry::Entry;
use stepwright::profile::{Fit, Ramp};
use stepwright::queue::{Next, Queue};
use stepwright::units::Jerk;
use stepwright::{
    Accel, Axis, Board, Change, Control, Cost, Order, OrderedMotors, Playing, Rate, Report, Speed,
    Timing, Travel,
};

const STORIES: u32 = 3_000;

/// Fillings that are checked after a stop; longer stops are checked at their beginning.
const LOOKED_AT: usize = 2_000;

/// An engine that plays nothing and returns preset values.
struct Player {
    idle: bool,
}

type Motors<'q> = OrderedMotors<'q, Player, 1>;

impl Control for Player {
    fn playing(&mut self, _: u8) -> Playing {
        Playing::Unknown
    }
    fn start(&mut self, _: u8) {
        self.idle = false;
    }
    fn kill(&mut self, _: u8) {
        self.idle = true;
    }
    fn report(&self, _: u8) -> Report {
        Report { position: 0, idle: self.idle, forward: true }
    }
    fn set_position(&mut self, _: u8, _: i64) {}
    fn set_timing(&mut self, _: Timing) {}
    fn late(&self) -> u32 {
        0
    }
    fn clear_late(&mut self) {}
}

/// Limits in steps/s, steps/s² and steps/s³; without a jerk limit the jerk is infinite.
#[derive(Clone, Copy, Debug)]
struct Limits {
    start: f64,
    top: f64,
    a: f64,
    d: f64,
    jerk: f64,
}

impl Limits {
    fn of(order: &Order) -> Limits {
        let v = |v: Speed| f64::from(v.millisteps()) / 1e3;
        let (start, top) = (v(order.start), v(order.top));
        let slope = |ramp: Ramp| match ramp {
            Ramp::Accel(a) => a.millisteps() as f64 / 1e3,
            // To 10⁻⁶ of v² per step, like the law: in whole numbers, because a half rounds up.
            Ramp::Steps(n) => {
                let w = |v: Speed| u64::from(v.millisteps()).pow(2);
                let (gain, n) = (w(order.top).saturating_sub(w(order.start)), u64::from(n));
                (((2 * gain + n) / (2 * n)) as f64 / 2e6).max(0.001)
            }
        };
        let jerk = order.jerk.map_or(f64::INFINITY, |jerk| jerk.millisteps() as f64 / 1e3);
        Limits { start: start.min(top), top, a: slope(order.up), d: slope(order.down), jerk }
    }

    /// Steps and seconds of the fall from a level at this speed.
    fn fall(&self, v: f64) -> f64 {
        let loss = (v - self.start).max(0.0);
        let bend = self.d / self.jerk;
        let time = if loss >= self.d * bend {
            loss / self.d + bend
        } else {
            2.0 * (loss / self.jerk).sqrt()
        };
        (v + self.start.min(v)) / 2.0 * time
    }
}

/// An interval between two pulses of a leg.
#[derive(Clone, Copy, Debug)]
struct Interval {
    /// Seconds, and their largest error.
    time: f64,
    off: f64,
    /// The number of limits that had been in force by then.
    phase: usize,
}

/// All steps handed out, by legs.
#[derive(Debug)]
struct Judge {
    hz: f64,
    /// The limits in force, in their order.
    phases: Vec<Limits>,
    leg: Vec<Interval>,
    /// The time waited since the last pulse of the leg, in 2⁻¹⁶ ticks.
    open: Option<u64>,
    /// The first phase of the leg.
    first: usize,
    /// Pulses since the travel began, forward minus backward.
    made: i64,
    /// All pulses handed out, and the number of planned ones before each change.
    pulses: u64,
    planned: Vec<u64>,
    /// Pulses that were planned before the stop and are still to be handed out; the interval before
    /// the last of them; and pulses since.
    ahead: Option<u64>,
    last: Option<Interval>,
    beyond: u64,
}

impl Judge {
    /// The highest acceleration that the limits allow from one interval of the leg to another.
    fn steepest(&self, from: &Interval, to: &Interval) -> f64 {
        // A bend that was begun under other limits continues.
        let from = if self.phases[to.phase].jerk.is_finite() { self.first } else { from.phase };
        // An interval may have been planned before the limits of the beginning of the leg came.
        let phases = &self.phases[from.min(to.phase)..=to.phase];
        phases.iter().map(|limits| limits.a.max(limits.d)).fold(0.0, f64::max)
    }

    /// The error of a time in seconds: rounding to a tick, and in a curve 2⁻²⁸ of its ramp.
    fn doubt(&self) -> f64 {
        let phases = &self.phases[self.first..];
        let most = |of: fn(&Limits) -> f64| phases.iter().map(of).fold(0.0, f64::max);
        let (slow, bend) = (most(|l| 1.0 / l.a.min(l.d)), most(|l| l.a.max(l.d) / l.jerk));
        let bends = most(|l| 1.0 / l.jerk).sqrt() * 2.0 * most(|l| l.top).sqrt();
        let curve = if bend > 0.0 { most(|l| l.top) * slow + bend.min(bends) } else { 0.0 };
        2.0 / self.hz + (curve + (2.0 * slow).sqrt()) * 2f64.powi(-28)
    }

    fn see(&mut self, entry: Entry, forward: bool) {
        for (pins, wait) in entry.play() {
            if pins & WIRING.step != 0 {
                self.step(forward);
                self.open = Some(0);
            }
            // Waits without a pin are the rest of a long interval.
            self.open = self.open.map(|open| open + u64::from(wait));
        }
    }

    fn step(&mut self, forward: bool) {
        if let Some(open) = self.open {
            let time = open as f64 / 65536.0 / self.hz;
            let off = self.doubt() + time * 2f64.powi(-26);
            let phase = self.planned.iter().filter(|planned| self.pulses >= **planned).count();
            self.leg.push(Interval { time, off, phase });
            self.look_back();
        }
        self.made += if forward { 1 } else { -1 };
        self.pulses += 1;
        match &mut self.ahead {
            None => {}
            Some(0) => self.beyond += 1,
            Some(ahead) => {
                *ahead -= 1;
                self.last = self.leg.last().copied();
            }
        }
    }

    /// Checks that the mean speeds of two consecutive intervals differ by the acceleration times
    /// the time between their middles.
    fn look_back(&self) {
        let [.., before, last] = self.leg.as_slice() else { return };
        let (v, w) = (1.0 / before.time, 1.0 / last.time);
        let most = self.steepest(before, last) * (before.time + last.time) / 2.0;
        let doubt = v * v * before.off + w * w * last.off;
        assert!(
            (v - w).abs() <= most * (1.0 + 1e-6) + doubt,
            "a leap from {v} to {w} steps/s, {most} allowed, {:?}: {:?}",
            self.leg,
            self.phases
        );
    }

    /// The highest possible speed at the last pulse before the stop.
    fn fastest(&self) -> f64 {
        let Some(last) = &self.last else { return self.phases[self.first].start };
        let phases = &self.phases[self.first..];
        let top = phases.iter().map(|limits| limits.top).fold(0.0, f64::max);
        let mean = 1.0 / (last.time - last.off).max(1e-9);
        top.min(mean + self.steepest(last, last) * last.time / 2.0)
    }

    fn ends(&mut self) {
        // The wait after the last step is no interval.
        (self.open, self.first) = (None, self.phases.len() - 1);
        self.leg.clear();
    }
}

/// A change, after this many fillings of the queue and this many pieces of planning.
#[derive(Clone, Debug)]
struct Whim {
    fillings: u8,
    pieces: u8,
    change: Change,
}

#[derive(Clone, Debug)]
struct Story {
    hz: u32,
    order: Order,
    whims: Vec<Whim>,
    /// Fillings before the stop.
    fillings: u8,
}

fn spread(low: u64, high: u64) -> impl Strategy<Value = u64> {
    (0.0f64..1.0).prop_map(move |x| {
        let (l, h) = ((low as f64).ln(), (high as f64).ln());
        ((l + x * (h - l)).exp().round() as u64).clamp(low, high)
    })
}

fn speed(low: u64) -> impl Strategy<Value = Speed> {
    let millis = prop_oneof![
        // Values that a line can carry, and others.
        3 => spread(low.div_ceil(1_000), 60_000).prop_map(|v| v * 1_000),
        1 => spread(low.max(1), 60_000_000),
    ];
    millis.prop_map(|v| Speed::from_millisteps(v as u32).unwrap())
}

fn accel() -> impl Strategy<Value = Accel> {
    let millis = prop_oneof![
        4 => spread(1_000, 1_000_000_000),
        1 => spread(1, 100_000_000_000),
    ];
    millis.prop_map(|a| Accel::from_millisteps(a).unwrap())
}

fn ramp() -> impl Strategy<Value = Ramp> {
    prop_oneof![
        2 => accel().prop_map(Ramp::Accel),
        1 => (1u16..1_000).prop_map(Ramp::Steps),
    ]
}

fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        2 => (-20_000i32..20_000).prop_map(Change::Target),
        1 => (i32::MIN..=i32::MAX).prop_map(Change::Target),
        3 => speed(0).prop_map(Change::Top),
        2 => accel().prop_map(Change::Accel),
        2 => accel().prop_map(Change::Decel),
    ]
}

fn story(jerk: impl Strategy<Value = Option<Jerk>>) -> impl Strategy<Value = Story> {
    let travel = prop_oneof![
        1 => (1i32..30_000).prop_map(Travel::By),
        1 => any::<bool>().prop_map(Travel::Endless),
    ];
    let start = prop_oneof![
        1 => Just(Speed::ZERO).boxed(),
        2 => spread(1_000, 2_000_000).prop_map(|v| Speed::from_millisteps(v as u32).unwrap()).boxed(),
    ];
    // Sometimes the top speed is the start speed: such an order has no ramp.
    let top = prop_oneof![3 => speed(1).prop_map(Some), 1 => Just(None)];
    let whim = (0u8..30, 0u8..4, change()).prop_map(|(fillings, pieces, change)| Whim {
        fillings,
        pieces,
        change,
    });
    let whims = prop::collection::vec(whim, 0..8);
    let hz = prop_oneof![2 => Just(16_000_000u32), 1 => spread(100_000, 200_000_000).prop_map(|hz| hz as u32)];
    (hz, start, top, ramp(), ramp(), jerk, travel, whims, 0u8..40).prop_map(
        |(hz, start, top, up, down, jerk, travel, whims, fillings)| {
            let top = top.unwrap_or(start).max(Speed::from_millisteps(1).unwrap());
            Story { hz, order: Order { start, top, up, down, jerk, travel }, whims, fillings }
        },
    )
}

/// The result of a sequence.
#[derive(Default)]
struct Told {
    taken: usize,
    no_stop: usize,
    stopped: usize,
}

/// Pulses that are planned and have not been handed out. The last of them waits for the entry that
/// follows it; where a travel is too long to count, it is the only one.
fn planned(motors: &Motors, judge: &Judge) -> u64 {
    motors.planned(Axis::X).map_or(1, |planned| i64::from(planned).abs_diff(judge.made))
}

fn tell(story: &Story) -> Told {
    let rate = Rate::from_hz(story.hz).unwrap();
    let timing = Timing { pulse: 1, setup: 1, hold: 1, min_interval: 2 };
    let fit = Fit::EXACT.lasting(rate.micros(8_000));
    let horizon = rate.micros(16_000);
    let board = Board {
        rate,
        timing,
        cost: Cost::any_pulse([1]),
        runs: u16::MAX,
        fit,
        horizon,
        lead: rate.micros(250),
    };
    let mut queue = Queue::<8>::new();
    let (producer, mut entries) = queue.split();
    let mut motors = Motors::new(Player { idle: true }, [producer], board);
    let mut told = Told::default();
    if motors.start([(Axis::X, story.order)]).is_err() {
        return told;
    }
    let mut judge = Judge {
        hz: f64::from(story.hz),
        phases: vec![Limits::of(&story.order)],
        leg: Vec::new(),
        open: None,
        first: 0,
        made: 0,
        pulses: 0,
        planned: Vec::new(),
        ahead: None,
        last: None,
        beyond: 0,
    };
    // Fills the queue and takes its entries.
    let mut fill = |motors: &mut Motors, judge: &mut Judge, pieces| {
        for _ in 0..pieces {
            if !motors.plan() {
                break;
            }
        }
        loop {
            match entries.take() {
                Next::Entry(entry) => judge.see(entry, motors.is_forward(Axis::X)),
                Next::Late => return,
                Next::End => {
                    if !std::mem::replace(&mut motors.engine().idle, true) {
                        judge.ends();
                    }
                    return;
                }
            }
        }
    };
    for whim in &story.whims {
        for _ in 0..whim.fillings {
            fill(&mut motors, &mut judge, u32::MAX);
        }
        fill(&mut motors, &mut judge, whim.pieces.into());
        if !motors.is_moving(Axis::X) {
            return told;
        }
        let mut limits = *judge.phases.last().unwrap();
        match whim.change {
            Change::Target(_) => {}
            Change::Top(v) => limits.top = f64::from(v.millisteps()) / 1e3,
            Change::Accel(a) => limits.a = a.millisteps() as f64 / 1e3,
            Change::Decel(d) => limits.d = d.millisteps() as f64 / 1e3,
        }
        match motors.change(Axis::X, whim.change) {
            Ok(()) => {
                told.taken += 1;
                judge.phases.push(limits);
                // A run that has been taken is still queued unchanged.
                judge.planned.push(judge.pulses + planned(&motors, &judge));
            }
            Err(_) => told.no_stop += 1,
        }
    }
    for _ in 0..story.fillings {
        fill(&mut motors, &mut judge, u32::MAX);
    }
    if !motors.is_moving(Axis::X) {
        return told;
    }
    told.stopped = 1;
    motors.stop(Axis::X);
    // A run that has been taken is still queued: braking begins at its end.
    (judge.ahead, judge.last) = (Some(planned(&motors, &judge)), judge.leg.last().copied());
    let known = motors.planned(Axis::X).is_some();
    while judge.ahead != Some(0) {
        fill(&mut motors, &mut judge, 1);
        if !motors.is_moving(Axis::X) {
            // In a travel too long to count, the last pulse may have been handed out already.
            assert!(judge.ahead == Some(0) || !known, "{judge:?}");
            return told;
        }
    }
    // A fall that was begun under a jerk limit continues unchanged.
    let limits = *judge.phases.last().unwrap();
    let slowest = match story.order.jerk {
        Some(_) => judge.phases[judge.first..].iter().map(|l| l.d).fold(limits.d, f64::min),
        None => limits.d,
    };
    let limits = Limits { d: slowest, ..limits };
    let mut v = judge.fastest();
    let mut way = 0.0;
    if let Some(last) = &judge.last
        && limits.jerk.is_finite()
    {
        // The acceleration is removed first.
        let a = judge.steepest(last, last);
        v += a * a / 2.0 / limits.jerk;
        way = v * a / limits.jerk;
    }
    way += limits.fall(v);
    let steps = way * (1.0 + 1e-6) + 2.0;
    for _ in 0..LOOKED_AT {
        fill(&mut motors, &mut judge, u32::MAX);
        let pulses = judge.beyond;
        assert!(pulses as f64 <= steps, "{pulses} pulses of {steps}: {:?}", judge.phases);
        if !motors.is_moving(Axis::X) {
            return told;
        }
    }
    assert!(steps > LOOKED_AT as f64, "it never ends: {steps} steps, {:?}", judge.phases);
    told
}

fn tell_all(stories: impl Strategy<Value = Story>) {
    let asked = std::env::var("STEPWRIGHT_CASES").ok().and_then(|n| n.parse().ok());
    let cases = asked.unwrap_or(STORIES);
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(cases) };
    let (taken, no_stop, stopped) = (Cell::new(0), Cell::new(0), Cell::new(0));
    let told = TestRunner::new(config).run(&stories, |story| {
        let told = tell(&story);
        taken.set(taken.get() + told.taken);
        no_stop.set(no_stop.get() + told.no_stop);
        stopped.set(stopped.get() + told.stopped);
        Ok(())
    });
    if let Err(failure) = told {
        panic!("{failure}");
    }
    let (taken, no_stop, stopped) = (taken.get(), no_stop.get(), stopped.get());
    println!("{taken} changes, {no_stop} that could not stop, {stopped} stops in {cases} stories");
    assert!(taken >= cases as usize && stopped >= cases as usize / 4);
}

#[test]
fn a_soft_stop_ends_in_time() {
    tell_all(story(Just(None)));
}

#[test]
fn a_soft_stop_of_an_s_curve_ends_in_time() {
    tell_all(story(spread(100_000, 100_000_000_000).prop_map(|j| Jerk::from_millisteps(j).ok())));
}

#[test]
fn a_change_at_the_end_of_a_rise_goes_on_at_its_speed() {
    let order = Order {
        start: Speed::ZERO,
        top: Speed::from_millisteps(360).unwrap(),
        up: Ramp::Steps(65),
        down: Ramp::Steps(65),
        jerk: Jerk::from_millisteps(459_507_994).ok(),
        travel: Travel::By(10),
    };
    let whims = vec![Whim { fillings: 2, pieces: 0, change: Change::Target(9) }];
    let told = tell(&Story { hz: 16_000_000, order, whims, fillings: 1 });
    assert_eq!((told.taken, told.stopped), (1, 1));
}
