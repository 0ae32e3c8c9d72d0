//! Random changes of travels on the way, with a limited jerk: every pulse is within a tick (and 2⁻²⁶ of the
//! time) of an independent curve that keeps the limits. No target that can be reached is overshot, and every
//! target is met.
//!
//! `STEPWRIGHT_CASES` sets the number of stories in each test.

use crate::bends::{Follower, Limits};
use crate::story::{Story, What, Whim, exact, play, spread, story, tell_all};
use proptest::prelude::*;
use stepwright::profile::Ramp;
use stepwright::timer::Count;
use stepwright::units::Jerk;
use stepwright::{Accel, Order, Rate, Speed, Travel};
use stepwright_sim::Description;

/// In each test: 4,000 changes. 3,000 stories (`STEPWRIGHT_CASES=3000`) were run once without a miss.
const STORIES: u32 = 800;

fn limits(order: &Order) -> Limits {
    let slope = |ramp: Ramp| match ramp {
        Ramp::Accel(a) => a.millisteps() as f64 / 1e3,
        Ramp::Steps(_) => unreachable!(),
    };
    let v = |v: Speed| f64::from(v.millisteps()) / 1e3;
    let (a, d) = (slope(order.up), slope(order.down));
    let jerk = order.jerk.unwrap().millisteps() as f64 / 1e3;
    Limits { start: v(order.start), top: v(order.top), a, d, jerk }
}

/// Plays a story, and follows it by the edges. Returns the number of accepted changes.
fn tell<C: Count>(description: Description, story: &Story, slack: f64) -> usize {
    let Some(told) = play::<C>(description, story) else { return 0 };
    let (target, forward) = story.target();
    let limits = limits(&story.order);
    let mut ways = vec![Follower::new(&told.pulses, told.hz, limits, target, forward, slack)];
    let mut wrong = String::new();
    for said in &told.said {
        let mut next: Vec<Follower> = Vec::new();
        for way in ways {
            match way.hear(said, &told.gap) {
                Ok(more) => {
                    for way in more {
                        if !next.iter().any(|other| other.is_like(&way)) {
                            next.push(way);
                        }
                    }
                }
                Err(why) => wrong = why,
            }
        }
        ways = next;
        assert!(!ways.is_empty() && ways.len() < 1000, "{} ways: {wrong}", ways.len());
    }
    let ended = ways.into_iter().map(|way| way.finish(&told.gap));
    let (good, bad): (Vec<_>, Vec<_>) = ended.partition(Result::is_ok);
    assert!(!good.is_empty(), "{bad:?}");
    told.said.len()
}

/// Stories with a jerk of a hundredth to a hundred times the jerk that reaches the acceleration in a tenth of a
/// second.
fn bent() -> impl Strategy<Value = Story> {
    (story(), spread(1, 10_000)).prop_map(|(mut story, part)| {
        let Ramp::Accel(a) = story.order.up else { unreachable!() };
        let jerk = (a.millisteps() / 10 * u64::from(part)).max(1_000);
        story.order.jerk = Some(Jerk::from_millisteps(jerk).unwrap());
        story
    })
}

#[test]
fn pulses_keep_the_curve_on_an_uno() {
    tell_all(STORIES, bent(), |story| tell::<u16>(exact(Description::uno()), &story, 1.0));
}

#[test]
fn pulses_keep_the_stated_error() {
    tell_all(STORIES, bent(), |story| tell::<u16>(Description::uno(), &story, 18.0));
}

#[test]
fn pulses_keep_the_curve_on_32_bits() {
    tell_all(STORIES, (spread(100_000, 200_000_000), bent()), |(hz, story)| {
        let rate = Rate::from_hz(hz).unwrap();
        let cost = [(hz / 200_000).max(1); 3];
        tell::<u32>(exact(Description::quick(rate, cost)), &story, 1.0)
    });
}

/// A bend of just one step: the last bits decide whether the way to rest takes three steps or four.
#[test]
fn a_way_to_rest_in_doubt() {
    let a = |a| Ramp::Accel(Accel::from_millisteps(a).unwrap());
    let order = Order {
        start: Speed::from_millisteps(638_056).unwrap(),
        top: Speed::from_millisteps(295_443).unwrap(),
        up: a(278_483),
        down: a(200_000),
        jerk: Some(Jerk::from_millisteps(27_848).unwrap()),
        travel: Travel::By(-156),
    };
    let whims = [
        Whim { after: 10, what: What::Again },
        Whim { after: 0, what: What::Top(685_912) },
        Whim { after: 9608, what: What::Near(-1) },
        Whim { after: 0, what: What::Near(-1) },
    ];
    let story = Story { axis: 0, order, whims: whims.into() };
    tell::<u16>(exact(Description::uno()), &story, 1.0);
    tell::<u16>(Description::uno(), &story, 18.0);
}
