//! Random programs: up to four tasks move, drop, change, stop and fault three axes. Positions match
//! the pins, and nothing is late or stuck.

use std::cell::RefCell;
use std::future::Future;
use std::pin::Pin;

use crate::bench::{AXES, Bench, Moved, with};
use embassy_futures::select::select;
use proptest::prelude::*;
use stepwright::{Axis, MoveError, Speed};
use stepwright_embassy::Outcome;

#[derive(Clone, Copy, Debug)]
enum Deed {
    MoveTo(i64),
    MoveBy(i32),
    Run(i32),
    /// A move whose future is dropped after this many ms.
    Dropped(i64, u64),
    Retarget(i64),
    Top(u32),
    Stop,
    Rest,
    Pause(u64),
    Fault,
    Kill,
    SetPosition(i64),
}

fn deed() -> impl Strategy<Value = Deed> {
    prop_oneof![
        4 => (-3_000i64..3_000).prop_map(Deed::MoveTo),
        2 => (-900i32..900).prop_map(Deed::MoveBy),
        1 => (-1_500i32..1_500).prop_map(Deed::Run),
        3 => (-3_000i64..3_000, 0u64..900).prop_map(|(to, ms)| Deed::Dropped(to, ms)),
        3 => (-3_000i64..3_000).prop_map(Deed::Retarget),
        2 => (20u32..2_000).prop_map(Deed::Top),
        2 => Just(Deed::Stop),
        1 => Just(Deed::Rest),
        6 => (0u64..400).prop_map(Deed::Pause),
        1 => Just(Deed::Fault),
        1 => Just(Deed::Kill),
        2 => (-500i64..500).prop_map(Deed::SetPosition),
    ]
}

/// An axis, which tasks may share, and what a task does with it.
type Story = (usize, Vec<Deed>);

/// The time in ms after which a run is dropped that nothing else would stop.
const PATIENCE: u64 = 1_500;

/// The counts of the pins, by axis.
#[derive(Default)]
struct Counts {
    /// The count at position 0. Setting a position shifts it.
    origins: RefCell<[i64; AXES]>,
    /// When an axis rested that a task was about to move or to set, and its position.
    rests: RefCell<Vec<(u64, usize, i64)>>,
}

impl Counts {
    /// The position at the pins.
    fn at(&self, bench: &Bench<'_>, axis: usize) -> i64 {
        bench.shafts.borrow().at[axis] - self.origins.borrow()[axis]
    }

    /// Checks that the reported end of a move is the position at the pins, or was before another
    /// task changed it at this very time.
    fn judge(&self, bench: &Bench<'_>, axis: usize, end: Result<Outcome, MoveError>) {
        if let Ok(Outcome::Reached { at } | Outcome::Stopped { at }) = end {
            let before = (bench.time.now(), axis, at);
            let was = self.rests.borrow().contains(&before);
            assert!(was || at == self.at(bench, axis), "{end:?}, {}", self.at(bench, axis));
        }
    }
}

async fn act(bench: &Bench<'_>, motors: &Moved<'_>, counts: &Counts, story: &Story) {
    let (index, deeds) = story;
    let mut axis = motors.axis(Axis::new(*index).unwrap());
    for deed in deeds {
        if !axis.is_moving() {
            let rest = (bench.time.now(), *index, counts.at(bench, *index));
            counts.rests.borrow_mut().push(rest);
        }
        match *deed {
            Deed::MoveTo(to) => counts.judge(bench, *index, axis.move_to(to).await),
            Deed::MoveBy(by) => counts.judge(bench, *index, axis.move_by(by).await),
            Deed::Run(speed) => _ = select(axis.run(speed), bench.after(PATIENCE)).await,
            Deed::Dropped(to, ms) => _ = select(axis.move_to(to), bench.after(ms)).await,
            Deed::Retarget(to) => drop(axis.retarget(to)),
            Deed::Top(top) => drop(axis.set_top_speed(Speed::from_steps(top).unwrap())),
            Deed::Stop => {
                let at = axis.stop().await;
                let pins = counts.at(bench, *index);
                assert!(at.is_none_or(|at| at == pins), "{at:?}, {pins}");
            }
            Deed::Rest => drop(axis.rest().await),
            Deed::Pause(ms) => bench.after(ms).await,
            Deed::Fault => motors.fault(Axis::new(*index).unwrap()),
            Deed::Kill => motors.kill(Axis::new(*index).unwrap()),
            Deed::SetPosition(to) => {
                if axis.set_position(to).is_ok() {
                    counts.origins.borrow_mut()[*index] = bench.shafts.borrow().at[*index] - to;
                }
            }
        }
    }
}

fn check(stories: &[Story]) {
    with(|bench, motors| {
        let counts = Counts::default();
        let tasks = stories.iter().map(|story| {
            Box::pin(act(bench, motors, &counts, story)) as Pin<Box<dyn Future<Output = ()>>>
        });
        bench.run(motors, tasks);
        for axis in Axis::all() {
            let (own, pins) = (motors.axis(axis), counts.at(bench, axis.index()));
            assert!(!own.is_moving());
            assert!(own.position().is_none_or(|own| own == pins), "{:?}", own.position());
        }
        assert_eq!(motors.late(), 0);
        // No jumps: the step interval is never shorter than at the limit of 2,000 steps/s.
        for steps in &bench.shafts.borrow().steps {
            let least = steps.windows(2).map(|two| two[1] - two[0]).min().unwrap_or(u64::MAX);
            assert!(least >= 490, "{least} µs");
        }
    });
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn positions_are_those_of_the_pins(
        stories in prop::collection::vec((0..AXES, prop::collection::vec(deed(), 1..9)), 1..5)
    ) {
        check(&stories);
    }
}
