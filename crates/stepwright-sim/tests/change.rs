//! Random changes of mind on the way: every pulse within a tick of an
//! independent curve from the state at which the change was taken, which keeps
//! the limits; no target that can be reached is overshot; every one is met.
//!
//! `STEPWRIGHT_CASES` sets the number of stories in each test.

#[path = "common/edges.rs"]
mod edges;
#[path = "common/legs.rs"]
mod legs;

use std::cell::Cell;
use std::panic::AssertUnwindSafe;

use edges::{check_timing, steps_of};
use legs::{Follower, Gap, HAIRS, Limits, Said};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use stepwright::profile::{Fit, Ramp};
use stepwright::timer::Count;
use stepwright::{Accel, Change, Order, Rate, Refusal, Speed, Travel};
use stepwright_protocol::{AxisId, Machine};
use stepwright_sim::{Description, Edge, Queues, VirtualBoard};

/// A change of mind, so many µs after the one before.
#[derive(Clone, Debug)]
struct Whim {
    after: u32,
    what: What,
}

#[derive(Clone, Copy, Debug)]
enum What {
    /// So far from where it is planned to, or from the origin.
    Near(i32),
    Absolute(i32),
    /// The target that it has.
    Again,
    /// In thousandths.
    Top(u32),
    Accel(u32),
    Decel(u32),
    Stop,
}

#[derive(Clone, Debug)]
struct Story {
    axis: u8,
    order: Order,
    whims: Vec<Whim>,
}

fn spread(low: u32, high: u32) -> impl Strategy<Value = u32> {
    (0.0f64..1.0).prop_map(move |x| {
        let (l, h) = (f64::from(low).ln(), f64::from(high).ln());
        ((l + x * (h - l)).exp().round() as u32).clamp(low, high)
    })
}

fn signed(low: u32, high: u32) -> impl Strategy<Value = i32> {
    (spread(low, high), any::<bool>()).prop_map(|(n, up)| if up { n as i32 } else { -(n as i32) })
}

fn top() -> impl Strategy<Value = u32> {
    spread(20_000, 30_000_000)
}

fn accel() -> impl Strategy<Value = u32> {
    spread(200_000, 1_000_000_000)
}

fn whim() -> impl Strategy<Value = Whim> {
    let what = prop_oneof![
        3 => signed(1, 1_500).prop_map(What::Near),
        2 => signed(1, 3_000).prop_map(What::Absolute),
        1 => Just(What::Near(0)),
        1 => Just(What::Again),
        2 => top().prop_map(What::Top),
        1 => accel().prop_map(What::Accel),
        1 => accel().prop_map(What::Decel),
        1 => Just(What::Stop),
    ];
    (prop_oneof![Just(0), spread(10, 400_000)], what).prop_map(|(after, what)| Whim { after, what })
}

fn story() -> impl Strategy<Value = Story> {
    let ramp = || accel().prop_map(|a| Ramp::Accel(Accel::from_millisteps(a.into()).unwrap()));
    let travel = prop_oneof![
        4 => signed(1, 4_000).prop_map(Travel::By),
        1 => any::<bool>().prop_map(Travel::Endless),
    ];
    let start = prop_oneof![2 => Just(0u32), 1 => spread(1_000, 1_000_000)];
    (0u8..3, start, top(), ramp(), ramp(), travel, prop::collection::vec(whim(), 1..14)).prop_map(
        |(axis, start, top, up, down, travel, whims)| {
            let v = |m| Speed::from_millisteps(m).unwrap();
            Story {
                axis,
                order: Order { start: v(start), top: v(top), up, down, jerk: None, travel },
                whims,
            }
        },
    )
}

fn limits(order: &Order, hair: f64) -> Limits {
    let slope = |ramp: Ramp| match ramp {
        Ramp::Accel(a) => a.millisteps() as f64 / 1e3,
        Ramp::Steps(_) => unreachable!(),
    };
    let v = |v: Speed| f64::from(v.millisteps()) / 1e3;
    let (a, d) = (slope(order.up), slope(order.down));
    Limits { start: v(order.start), top: v(order.top), a, d, hair }
}

/// Lets a story happen, and follows it by the edges. How many changes were
/// taken.
fn tell<C: Count>(description: Description, story: &Story, slack: f64) -> usize {
    let mut queues = Queues::default();
    let mut board: VirtualBoard<C, Vec<Edge>> =
        VirtualBoard::new(&mut queues, description, Vec::new());
    let (rate, timing) = (description.board.rate, description.board.timing);
    let controller = board.controller();
    if controller.group.start(controller.engine, [(story.axis, story.order)]).is_err() {
        return 0;
    }
    let axis = AxisId::numbered(story.axis + 1).unwrap();
    let mut said: Vec<Said> = Vec::new();
    let mut whims = story.whims.clone();
    let mut target = match story.order.travel {
        Travel::By(steps) => steps,
        Travel::Endless(_) => 50,
    };
    if board.is_endless() {
        // What never ends by itself must be ended.
        whims.push(Whim { after: 300_000, what: What::Absolute(100) });
    }
    for whim in whims {
        board.run_until(board.now() + u64::from(rate.micros(whim.after)));
        let controller = board.controller();
        let planned = controller.group.planned(story.axis).unwrap();
        let forward = controller.group.is_forward(story.axis);
        let speed = |m| Speed::from_millisteps(m).unwrap();
        let accel = |m: u32| Accel::from_millisteps(m.into()).unwrap();
        let change = match whim.what {
            What::Near(steps) => Some(Change::Target(planned + steps)),
            What::Absolute(steps) => Some(Change::Target(steps)),
            What::Again => Some(Change::Target(target)),
            What::Top(top) => Some(Change::Top(speed(top))),
            What::Accel(a) => Some(Change::Accel(accel(a))),
            What::Decel(d) => Some(Change::Decel(accel(d))),
            What::Stop => None,
        };
        if !controller.busy(axis) {
            let here = Change::Target(planned);
            let none = controller.group.change(controller.engine, 1 << story.axis, here);
            assert_eq!(none, Err(Refusal::Resting));
            break;
        }
        let taken = match change {
            Some(change) => {
                controller.group.change(controller.engine, 1 << story.axis, change).is_ok()
            }
            None => {
                let mut controller = controller;
                controller.brake(axis);
                true
            }
        };
        if let (true, Some(Change::Target(steps))) = (taken, change) {
            target = steps;
        }
        if taken {
            said.push(Said { planned, forward, change });
        }
    }
    assert!(!board.is_endless());
    board.run_to_rest();
    assert_eq!(board.late(), 0);
    let min = u64::from(timing.min_interval) - 1;
    let t = |ticks: u32| u64::from(ticks);
    check_timing(board.recorder(), t(timing.pulse), t(timing.setup), t(timing.hold), min);
    let pulses = steps_of(board.recorder(), story.axis);
    assert_eq!(board.position(story.axis), Some(pulses.last().map_or(0, |last| last.1)));
    let (target, forward) = match story.order.travel {
        Travel::By(steps) => (Some(steps.into()), steps > 0),
        Travel::Endless(forward) => (None, forward),
    };
    let hz = f64::from(rate.hz());
    // From the last pulse of a leg to the first of the next: the foreground
    // comes by every 50 µs, and then hold, set-up and lead count.
    let least = f64::from(timing.hold + timing.setup + description.board.lead) - 1.0;
    let gap = Gap { least, most: least + f64::from(rate.micros(200)) };
    let follow = |hair| {
        let limits = limits(&story.order, hair);
        let mut follower = Follower::new(&pulses, hz, limits, target, forward, slack);
        for said in &said {
            follower.hear(said, &gap);
        }
        follower.finish(&gap);
    };
    if std::panic::catch_unwind(AssertUnwindSafe(|| follow(HAIRS[0]))).is_err() {
        follow(HAIRS[1]);
    }
    said.len()
}

/// Tells many stories: with the default some 35,000 changes in each test.
fn tell_all<S: Strategy>(stories: S, tell: impl Fn(S::Value) -> usize) {
    let cases = std::env::var("STEPWRIGHT_CASES").ok().and_then(|n| n.parse().ok());
    let config = ProptestConfig::with_cases(cases.unwrap_or(7_000));
    let config = ProptestConfig { failure_persistence: None, ..config };
    let mut runner = TestRunner::new(config);
    let (cases, taken) = (cases.unwrap_or(7_000), Cell::new(0));
    let told = runner.run(&stories, |story| {
        taken.set(taken.get() + tell(story));
        Ok(())
    });
    if let Err(failure) = told {
        panic!("{failure}");
    }
    println!("{} changes in {cases} stories", taken.get());
    // Stories in which nobody changes his mind would prove nothing.
    assert!(taken.get() >= 3 * cases as usize, "only {} changes", taken.get());
}

/// Fitted to a quarter of a tick: on the curve to a tick.
fn exact(mut description: Description) -> Description {
    let rate = description.board.rate;
    description.board.fit = Fit::EXACT.lasting(rate.micros(8_000));
    description
}

#[test]
fn pulses_keep_the_curve_on_an_uno() {
    tell_all(story(), |story| tell::<u16>(exact(Description::uno()), &story, 1.0));
}

#[test]
fn pulses_keep_the_stated_error() {
    // 1 µs at 16 MHz, and the rounding to a tick.
    tell_all(story(), |story| tell::<u16>(Description::uno(), &story, 17.0));
}

#[test]
fn pulses_keep_the_curve_on_32_bits() {
    tell_all((spread(100_000, 200_000_000), story()), |(hz, story)| {
        let rate = Rate::from_hz(hz).unwrap();
        let cost = [(hz / 200_000).max(1); 3];
        tell::<u32>(exact(Description::at(rate, cost)), &story, 1.0)
    });
}

/// A story that once failed, at a rate on 32 bits.
fn known(hz: u32, up: u64, down: u64, top: u32, travel: i32, whims: &[(u32, What)]) {
    let ramp = |a| Ramp::Accel(Accel::from_millisteps(a).unwrap());
    let order = Order {
        start: Speed::ZERO,
        top: Speed::from_millisteps(top).unwrap(),
        up: ramp(up),
        down: ramp(down),
        travel: Travel::By(travel),
    };
    let whims = whims.iter().map(|&(after, what)| Whim { after, what }).collect();
    let story = Story { axis: 0, order, whims };
    let description = Description::at(Rate::from_hz(hz).unwrap(), [hz / 200_000; 3]);
    assert!(tell::<u32>(exact(description), &story, 1.0) >= 4);
}

/// Eases to a hundredth of the speed and less: where they end, a millionth of a
/// step takes more than a tick, and v² alone did not say it so well.
#[test]
fn eases_end_where_they_should() {
    let whims = [
        (0, What::Top(9_545_256)),
        (0, What::Absolute(2_087)),
        (185_058, What::Decel(129_307_506)),
        (4_047, What::Top(20_000)),
        (0, What::Decel(11_325_489)),
    ];
    known(133_688_614, 31_008_783, 1_347_692, 20_000, -1, &whims);
    let whims = [
        (0, What::Accel(376_197_189)),
        (10, What::Near(-919)),
        (0, What::Top(24_710_135)),
        (0, What::Decel(177_834_113)),
        (69_303, What::Again),
        (0, What::Top(20_000)),
        (394_421, What::Near(-1)),
    ];
    known(134_345_528, 28_716_739, 2_622_466, 2_212_352, -11, &whims);
}

/// Five minutes at a slow timer's constant speed, in runs of a step or two: what
/// each lacks below 2⁻¹⁶ ticks adds up.
#[test]
fn short_level_runs_do_not_add_up() {
    let ramp = |a| Ramp::Accel(Accel::from_millisteps(a).unwrap());
    let order = Order {
        start: Speed::ZERO,
        top: Speed::from_millisteps(144_255).unwrap(),
        up: ramp(337_429_007),
        down: ramp(200_000),
        travel: Travel::By(60_000),
    };
    let story = Story { axis: 0, order, whims: Vec::new() };
    tell::<u32>(exact(Description::at(Rate::from_hz(100_000).unwrap(), [1; 3])), &story, 1.0);
}
