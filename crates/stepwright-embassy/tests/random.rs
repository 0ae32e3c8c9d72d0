//! Random programs: up to four tasks move, drop, change, stop and fault three axes. Positions match
//! the pins, and nothing is late or stuck.

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

/// The count of steps at position 0, by axis. Setting a position shifts it.
type Origins = std::cell::RefCell<[i64; AXES]>;

/// Checks that the reported end of a move is the position at the pins.
fn judge(bench: &Bench<'_>, origin: i64, axis: usize, end: Result<Outcome, MoveError>) {
    if let Ok(Outcome::Reached { at } | Outcome::Stopped { at }) = end {
        assert_eq!(at, bench.shafts.borrow().at[axis] - origin, "{end:?}");
    }
}

async fn act(bench: &Bench<'_>, motors: &Moved<'_>, origins: &Origins, story: &Story) {
    let (index, deeds) = story;
    let mut axis = motors.axis(Axis::new(*index).unwrap());
    let origin = || origins.borrow()[*index];
    for deed in deeds {
        match *deed {
            Deed::MoveTo(to) => {
                let end = axis.move_to(to).await;
                judge(bench, origin(), *index, end);
            }
            Deed::MoveBy(by) => {
                let end = axis.move_by(by).await;
                judge(bench, origin(), *index, end);
            }
            Deed::Run(speed) => _ = select(axis.run(speed), bench.after(PATIENCE)).await,
            Deed::Dropped(to, ms) => _ = select(axis.move_to(to), bench.after(ms)).await,
            Deed::Retarget(to) => drop(axis.retarget(to)),
            Deed::Top(top) => drop(axis.set_top_speed(Speed::from_steps(top).unwrap())),
            Deed::Stop => {
                let at = axis.stop().await;
                let pins = bench.shafts.borrow().at[*index] - origin();
                assert!(at.is_none_or(|at| at == pins), "{at:?}, {pins}");
            }
            Deed::Rest => drop(axis.rest().await),
            Deed::Pause(ms) => bench.after(ms).await,
            Deed::Fault => motors.fault(Axis::new(*index).unwrap()),
            Deed::Kill => motors.kill(Axis::new(*index).unwrap()),
            Deed::SetPosition(to) => {
                if axis.set_position(to).is_ok() {
                    origins.borrow_mut()[*index] = bench.shafts.borrow().at[*index] - to;
                }
            }
        }
    }
}

fn check(stories: &[Story]) {
    with(|bench, motors| {
        let origins = Origins::default();
        let tasks = stories.iter().map(|story| {
            Box::pin(act(bench, motors, &origins, story)) as Pin<Box<dyn Future<Output = ()>>>
        });
        bench.run(motors, tasks);
        let at = bench.shafts.borrow().at;
        for axis in Axis::all() {
            let (own, pins) = (motors.axis(axis), at[axis.index()]);
            assert!(!own.is_moving());
            let origin = origins.borrow()[axis.index()];
            assert!(own.position().is_none_or(|own| own == pins - origin), "{:?}", own.position());
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
