//! Random stories of a travel that is changed on the way, played on the virtual board.

use std::cell::Cell;

use crate::edges::{check_timing, steps_of};
use crate::legs::{Gap, Said};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use stepwright::profile::{Fit, Ramp};
use stepwright::timer::Count;
use stepwright::{Accel, Axis, Change, Order, Refusal, Speed, Travel};
use stepwright_sim::{Description, Edge, Queues, VirtualBoard};

/// A change, this many µs after the one before.
#[derive(Clone, Debug)]
pub struct Whim {
    pub after: u32,
    pub what: What,
}

#[derive(Clone, Copy, Debug)]
pub enum What {
    /// A target this far from the planned position, or from the origin.
    Near(i32),
    Absolute(i32),
    /// The present target again.
    Again,
    /// In thousandths of the unit.
    Top(u32),
    Accel(u32),
    Decel(u32),
    Stop,
}

#[derive(Clone, Debug)]
pub struct Story {
    pub axis: u8,
    pub order: Order,
    pub whims: Vec<Whim>,
}

pub fn spread(low: u32, high: u32) -> impl Strategy<Value = u32> {
    (0.0f64..1.0).prop_map(move |x| {
        let (l, h) = (f64::from(low).ln(), f64::from(high).ln());
        ((l + x * (h - l)).exp().round() as u32).clamp(low, high)
    })
}

pub fn signed(low: u32, high: u32) -> impl Strategy<Value = i32> {
    (spread(low, high), any::<bool>()).prop_map(|(n, up)| if up { n as i32 } else { -(n as i32) })
}

pub fn top() -> impl Strategy<Value = u32> {
    spread(20_000, 30_000_000)
}

pub fn accel() -> impl Strategy<Value = u32> {
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

pub fn story() -> impl Strategy<Value = Story> {
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

/// The result of a story.
pub struct Told {
    /// The time and position of each pulse of the axis.
    pub pulses: Vec<(u64, i64)>,
    /// The accepted changes.
    pub said: Vec<Said>,
    /// The time from the last pulse of a leg to the first pulse of the next.
    pub gap: Gap,
    pub hz: f64,
}

impl Story {
    /// The first target, if there is one, and whether it is forward.
    pub fn target(&self) -> (Option<i64>, bool) {
        match self.order.travel {
            Travel::By(steps) => (Some(steps.into()), steps > 0),
            Travel::Endless(forward) => (None, forward),
        }
    }
}

/// Plays a story on the virtual board; `None` if its order is refused.
pub fn play<C: Count>(description: Description, story: &Story) -> Option<Told> {
    let mut queues = Queues::default();
    let mut board: VirtualBoard<C, Vec<Edge>> =
        VirtualBoard::new(&mut queues, description, Vec::new());
    let (rate, timing) = (description.board.rate, description.board.timing);
    let axis = Axis::new(story.axis.into()).unwrap();
    if board.motors().start([(axis, story.order)]).is_err() {
        return None;
    }
    let mut said: Vec<Said> = Vec::new();
    let mut whims = story.whims.clone();
    let mut target = match story.order.travel {
        Travel::By(steps) => steps,
        Travel::Endless(_) => 50,
    };
    if board.is_endless() {
        // An endless travel has to be ended.
        whims.push(Whim { after: 300_000, what: What::Absolute(100) });
    }
    for whim in whims {
        board.run_until(board.now() + u64::from(rate.micros(whim.after)));
        let motors = board.motors();
        let planned = motors.planned(axis).unwrap();
        let forward = motors.is_forward(axis);
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
        if !motors.is_moving(axis) {
            let here = Change::Target(planned);
            let none = motors.change(axis, here);
            assert_eq!(none, Err(Refusal::Resting));
            break;
        }
        let taken = match change {
            Some(change) => motors.change(axis, change).is_ok(),
            None => {
                motors.stop(axis);
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
    let hz = f64::from(rate.hz());
    // From the last pulse of a leg to the first of the next: the foreground runs every 50 µs, and then hold,
    // set-up and lead are added.
    let least = f64::from(timing.hold + timing.setup + description.board.lead) - 1.0;
    let gap = Gap { least, most: least + f64::from(rate.micros(200)) };
    Some(Told { pulses, said, gap, hz })
}

/// Plays this many stories, of five changes each, or as many as `STEPWRIGHT_CASES` says.
pub fn tell_all<S: Strategy>(cases: u32, stories: S, tell: impl Fn(S::Value) -> usize) {
    let asked = std::env::var("STEPWRIGHT_CASES").ok().and_then(|n| n.parse().ok());
    let cases = asked.unwrap_or(cases);
    let config = ProptestConfig::with_cases(cases);
    let config = ProptestConfig { failure_persistence: None, ..config };
    let mut runner = TestRunner::new(config);
    let taken = Cell::new(0);
    let told = runner.run(&stories, |story| {
        taken.set(taken.get() + tell(story));
        Ok(())
    });
    if let Err(failure) = told {
        panic!("{failure}");
    }
    println!("{} changes in {cases} stories", taken.get());
    // Stories without changes would prove nothing.
    assert!(taken.get() >= 3 * cases as usize, "only {} changes", taken.get());
}

/// Fitted to a quarter of a tick and played exactly: within a tick of the curve.
pub fn exact(mut description: Description) -> Description {
    let rate = description.board.rate;
    description.board.fit = Fit::EXACT.lasting(rate.micros(8_000));
    (description.grid, description.assembly) = ([1; 3], false);
    description
}
