//! Paths as runs for the memory of a board. Every step is at its time in the path, and a board that plays the
//! runs makes the edges of the path.

use std::cell::Cell;
use std::f64::consts::TAU;

use proptest::prelude::*;
use stepwright::Rate;
use stepwright_cycle::{self as cycle, Calibration, Clock, Leg, Motor, Program};
use stepwright_oracle::IdealTrapezoid;
use stepwright_path::{Arc, Line, Pace, Steps, legs};
use stepwright_sim::{CycleBoard, Edge, Pin, Stand};

const HZ: u32 = 16_000_000;
/// The largest error of a step in ticks, 2 µs.
const ERROR: u32 = 32;
/// The ticks of a pulse: an edge may wait for the end of another motor's pulse.
const PULSE: u64 = 32;
/// The smallest delay, in µs.
const SMALLEST: u32 = 50;

fn rate() -> Rate {
    Rate::from_hz(HZ).unwrap()
}

/// A line or an arc, whose steps can be made any number of times.
#[derive(Clone, Copy, Debug)]
enum Way {
    Line([i32; 2]),
    /// The radius in steps, the angle at the beginning, and the sweep.
    Arc(f64, f64, f64),
}

impl Way {
    /// The steps, in µm, 12.5 each; with a pause on the way.
    fn steps(self, pace: Pace, pause: Option<(f64, f64)>) -> [Steps; 2] {
        let step = [12.5; 2];
        let steps = match self {
            Way::Line(steps) => Steps::line(&Line { steps, step }, pace, rate(), 1_600).unwrap(),
            Way::Arc(radius, begin, sweep) => {
                let centre = [-12.5 * radius * begin.cos(), -12.5 * radius * begin.sin()];
                Steps::arc(&Arc { centre, sweep, step }, pace, rate(), 1_600).unwrap()
            }
        };
        if let Some((at, resumed)) = pause {
            steps[0].law().pause(at);
            steps[0].law().resume(at + resumed);
        }
        steps
    }
}

fn way() -> impl Strategy<Value = Way> {
    prop_oneof![
        prop::array::uniform2(-3_000i32..3_000)
            .prop_filter("it leads somewhere", |way| *way != [0, 0])
            .prop_map(Way::Line),
        (20.0f64..1_500.0, 0.0f64..6.0, prop_oneof![-7.0f64..-0.5, 0.5f64..7.0])
            .prop_map(|(radius, begin, sweep)| Way::Arc(radius, begin, sweep)),
    ]
}

fn pace() -> impl Strategy<Value = Pace> {
    let bend = prop::option::of(0.01f64..0.2);
    (1_000.0f64..60_000.0, 10_000.0f64..500_000.0, bend).prop_map(|(speed, accel, bend)| {
        let pace = Pace::new(speed, accel);
        bend.map_or(pace, |bend| pace.with_jerk(accel / bend))
    })
}

/// The ticks from the start to each step with its direction, and to the end.
fn times(steps: impl Iterator<Item = cycle::Pace>) -> (Vec<(u64, bool)>, u64) {
    let (mut at, mut made) = (0, Vec::new());
    for pace in steps {
        match pace {
            cycle::Pace::Wait { ticks } => at += u64::from(ticks),
            cycle::Pace::Step { ticks, forward } => {
                at += u64::from(ticks);
                made.push((at, forward));
            }
        }
    }
    (made, at)
}

/// The same for legs, in fractions of a tick.
fn played(legs: &[Leg]) -> (Vec<(f64, bool)>, f64) {
    let (mut at, mut made) = (0f64, Vec::new());
    for leg in legs {
        let Leg::Run { run, forward } = *leg else { panic!("{leg:?}") };
        let mut interval = run.interval() as f64 / 65_536.0;
        if run.count() == 0 {
            at += interval;
        }
        for _ in 0..run.count() {
            at += interval;
            interval += f64::from(run.add()) / 65_536.0;
            made.push((at, forward));
        }
    }
    (made, at)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn every_step_comes_within_the_error(
        way in way(),
        pace in pace(),
        pause in prop::option::of((0.01f64..0.5, prop_oneof![Just(0.3), Just(200.0)])),
    ) {
        for axis in 0..2 {
            let (steps, end) = times(way.steps(pace, pause).into_iter().nth(axis).unwrap());
            let smallest = steps.windows(2).map(|two| two[1].0 - two[0].0).min().unwrap_or(1);
            let (least, axis) = (smallest as u32, way.steps(pace, pause).into_iter().nth(axis));
            let legs = legs(axis.unwrap(), ERROR, least);
            let (made, ended) = played(&legs);
            prop_assert_eq!(made.len(), steps.len());
            for (made, step) in made.iter().zip(&steps) {
                prop_assert_eq!(made.1, step.1);
                let off = (made.0.floor() - step.0 as f64).abs();
                prop_assert!(off <= f64::from(ERROR), "{off} ticks at {}", step.0);
            }
            prop_assert!((ended.floor() - end as f64).abs() <= f64::from(ERROR));
            // No two steps are nearer than in the path itself.
            for two in made.windows(2) {
                prop_assert!(two[1].0 - two[0].0 >= f64::from(least) - 0.01, "{two:?}");
            }
            // The serial line can carry every leg.
            for leg in &legs {
                let Leg::Run { run, .. } = leg else { panic!() };
                prop_assert!(run.interval() >> 47 == 0);
            }
        }
    }

    #[test]
    fn a_board_plays_from_its_memory_what_the_path_is(way in way(), pace in pace()) {
        let play = |stored: bool| {
            let motors = [Motor::new(1, SMALLEST); 2];
            let mut steps = way.steps(pace, None);
            let mut board: CycleBoard<Vec<Edge>, 2> = CycleBoard::new(
                motors, [Stand::default(); 2], Clock::Deadlines, rate(), Vec::new(),
            );
            let kept: Vec<Vec<Cell<Leg>>> = if stored {
                let least = rate().micros(SMALLEST);
                let of = |axis: &mut Steps| legs(axis, ERROR, least);
                steps.iter_mut().map(|axis| of(axis).into_iter().map(Cell::new).collect()).collect()
            } else {
                vec![Vec::new(); 2]
            };
            for ((axis, kept), motor) in steps.iter_mut().zip(&kept).zip(0..) {
                let program =
                    if stored { Program::Stored(kept) } else { Program::Paced(axis) };
                board.cycle().prepare(motor, program, Calibration::None).unwrap();
            }
            let started = board.cycle().start();
            board.run_to_rest();
            let late = board.cycle().late();
            (started, board.now(), late, board.with_recorder(std::mem::take))
        };
        let (stored, paced) = (play(true), play(false));
        prop_assert_eq!((stored.0, stored.2), (paced.0, paced.2));
        if stored.0.is_err() {
            return Ok(());
        }
        prop_assert!(stored.1.abs_diff(paced.1) <= u64::from(ERROR) + PULSE);
        for axis in 0..2 {
            let (stored, paced) = (made(&stored.3, axis), made(&paced.3, axis));
            prop_assert_eq!(stored.len(), paced.len());
            for (a, b) in stored.iter().zip(&paced) {
                prop_assert_eq!(a.1, b.1);
                prop_assert!(a.0.abs_diff(b.0) <= u64::from(ERROR) + PULSE, "{a:?}, not {b:?}");
            }
        }
    }
}

/// The steps of an axis by its edges: their times and directions.
fn made(edges: &[Edge], axis: u8) -> Vec<(u64, bool)> {
    let (mut forward, mut made) = (true, Vec::new());
    for edge in edges.iter().filter(|edge| edge.axis == axis) {
        match edge.pin {
            Pin::Direction => forward = edge.level,
            Pin::Step if edge.level => made.push((edge.time, forward)),
            _ => {}
        }
    }
    made
}

/// The steps of a line come at the times of s = v²/2a or s = vt, by the formula and not by the path.
#[test]
fn a_line_of_one_axis_is_its_trapezoid() {
    let way = Way::Line([2_400, 0]);
    let [x, y] = way.steps(Pace::new(60_000.0, 400_000.0), None);
    let lead = 1_600.0;
    let x = legs(x, ERROR, 0);
    assert!(x.len() < 90, "{} legs", x.len());
    let (made, _) = played(&x);
    let (length, v, a) = (2_400.0 * 12.5, 60_000.0, 400_000.0);
    let ideal = IdealTrapezoid::new((0.0, 0.0), v, (2.0 * a, 2.0 * a), length);
    for (n, (ticks, forward)) in made.iter().enumerate() {
        let time = ideal.time((n + 1) as f64 * 12.5);
        let ideal = time * f64::from(HZ) + lead;
        // The path rounds by a tick, the run by half a tick.
        assert!((ticks - ideal).abs() <= f64::from(ERROR) + 2.0, "step {n}: {ticks}, not {ideal}");
        assert!(forward);
    }
    assert!(
        legs(y, ERROR, 0).iter().all(|leg| matches!(leg, Leg::Run { run, .. } if run.count() == 0))
    );
}

/// A circle of 15 mm at 60 mm/s, as in `drawing.toml`, fits the memory of a Mega.
#[test]
fn a_circle_fits_400_legs() {
    let way = Way::Arc(1_200.0, -TAU / 4.0, -TAU);
    let steps = way.steps(Pace::new(60_000.0, 400_000.0), Some((0.8, 0.4)));
    let all: usize = steps.into_iter().map(|axis| legs(axis, ERROR, 800).len()).sum();
    assert!((200..=400).contains(&all), "{all}");
}

/// Steps of opposite directions are legs of their own, even if they are evenly spaced.
#[test]
fn a_turn_ends_a_run() {
    let step = |n| cycle::Pace::Step { ticks: 5_000, forward: n < 7 };
    let legs = legs((0..12).map(step), ERROR, 0);
    let of = |leg: &Leg| match leg {
        Leg::Run { run, forward } => (run.count(), *forward),
        leg => panic!("{leg:?}"),
    };
    assert_eq!(legs.iter().map(of).collect::<Vec<_>>(), [(7, true), (5, false)]);
}
