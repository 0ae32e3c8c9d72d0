//! Random changes of travels on the way: every pulse is within a tick of an independent curve that keeps the
//! limits, from the state in which the change was accepted. No target that can be reached is overshot, and
//! every target is met.
//!
//! `STEPWRIGHT_CASES` sets the number of stories in each test.

use std::panic::AssertUnwindSafe;

use crate::legs::{Follower, HAIRS, Limits};
use crate::story::{Story, What, Whim, exact, play, spread, story, tell_all};
use stepwright::profile::Ramp;
use stepwright::timer::Count;
use stepwright::{Accel, Order, Rate, Speed, Travel};
use stepwright_sim::Description;

/// In each test: 5,000 changes. 4,000 stories (`STEPWRIGHT_CASES=4000`) were run once without a miss.
const STORIES: u32 = 1_000;

fn limits(order: &Order, hair: f64) -> Limits {
    let slope = |ramp: Ramp| match ramp {
        Ramp::Accel(a) => a.millisteps() as f64 / 1e3,
        Ramp::Steps(_) => unreachable!(),
    };
    let v = |v: Speed| f64::from(v.millisteps()) / 1e3;
    let (a, d) = (slope(order.up), slope(order.down));
    Limits { start: v(order.start), top: v(order.top), a, d, hair }
}

/// Plays a story, and follows it by the edges. Returns the number of accepted changes.
fn tell<C: Count>(description: Description, story: &Story, slack: f64) -> usize {
    let Some(told) = play::<C>(description, story) else { return 0 };
    let (target, forward) = story.target();
    let follow = |hair| {
        let limits = limits(&story.order, hair);
        let mut follower = Follower::new(&told.pulses, told.hz, limits, target, forward, slack);
        for said in &told.said {
            follower.hear(said, &told.gap);
        }
        follower.finish(&told.gap);
    };
    if std::panic::catch_unwind(AssertUnwindSafe(|| follow(HAIRS[0]))).is_err() {
        follow(HAIRS[1]);
    }
    told.said.len()
}

#[test]
fn pulses_keep_the_curve_on_an_uno() {
    tell_all(STORIES, story(), |story| tell::<u16>(exact(Description::uno()), &story, 1.0));
}

#[test]
fn pulses_keep_the_stated_error() {
    // 1 µs at 16 MHz, and the rounding to a tick.
    tell_all(STORIES, story(), |story| tell::<u16>(Description::uno(), &story, 17.0));
}

#[test]
fn pulses_keep_the_curve_on_32_bits() {
    tell_all(STORIES, (spread(100_000, 200_000_000), story()), |(hz, story)| {
        let rate = Rate::from_hz(hz).unwrap();
        let cost = [(hz / 200_000).max(1); 3];
        tell::<u32>(exact(Description::quick(rate, cost)), &story, 1.0)
    });
}

/// A story that failed once, at a timer rate on 32 bits.
fn known(hz: u32, up: u64, down: u64, top: u32, travel: i32, whims: &[(u32, What)]) {
    let ramp = |a| Ramp::Accel(Accel::from_millisteps(a).unwrap());
    let order = Order {
        start: Speed::ZERO,
        top: Speed::from_millisteps(top).unwrap(),
        up: ramp(up),
        down: ramp(down),
        jerk: None,
        travel: Travel::By(travel),
    };
    let whims = whims.iter().map(|&(after, what)| Whim { after, what }).collect();
    let story = Story { axis: 0, order, whims };
    let description = Description::quick(Rate::from_hz(hz).unwrap(), [hz / 200_000; 3]);
    assert!(tell::<u32>(exact(description), &story, 1.0) >= 4);
}

/// Slows down to a hundredth of the speed and less. At the end of such a ramp a millionth of a step takes more
/// than a tick, and v² alone was too coarse.
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

/// Five minutes at the constant speed of a slow timer, in runs of one or two steps: the parts of each run below
/// 2⁻¹⁶ ticks must not add up.
#[test]
fn short_level_runs_do_not_add_up() {
    let ramp = |a| Ramp::Accel(Accel::from_millisteps(a).unwrap());
    let order = Order {
        start: Speed::ZERO,
        top: Speed::from_millisteps(144_255).unwrap(),
        up: ramp(337_429_007),
        down: ramp(200_000),
        jerk: None,
        travel: Travel::By(60_000),
    };
    let story = Story { axis: 0, order, whims: Vec::new() };
    tell::<u32>(exact(Description::quick(Rate::from_hz(100_000).unwrap(), [1; 3])), &story, 1.0);
}
