//! The fixed tick in one pass per step against that in three, the grid after a pause, and the ends
//! of the range of positions.

use crate::rig::{PULSE, Rig, What};
use proptest::prelude::*;
use stepwright_cycle::{
    AtHardEnd, AtSoftEnd, Calibration, Clock, Faults, Leg, Motor, Program, Refusal, Strategies,
};

/// The result of playing these legs on two motors with a clock, each within bounds: the rises of
/// STEP, the changes of DIR, the faults and positions, and the end; and whether the first motor
/// was on its way to a switch when it closed.
type Played = (Vec<(u64, u8, i64)>, Vec<(u64, u8, bool)>, [(Faults, i64); 2], u64, bool);

fn played(clock: Clock, legs: &[Vec<Leg>; 2], brake: Option<u64>) -> Played {
    let motor = Motor::new(10, 700).between(-700, 2_000).braking(9_000);
    let mut rig = Rig::new([motor, motor.inverted()], clock);
    let hard_end = AtHardEnd::BrakeAll;
    let soft_end = AtSoftEnd::StopMotor;
    rig.cycle.set_strategies(Strategies { hard_end, soft_end, ..Strategies::CANCEL });
    for (motor, legs) in (0..).zip(legs) {
        rig.cycle.prepare(motor, Program::Series(legs), Calibration::None).unwrap();
    }
    rig.start();
    if let Some(at) = brake {
        rig.until(at);
        rig.close(1, 1);
        rig.cycle.look();
    }
    let met = !rig.cycle.faults(0).is_none();
    rig.run_out();
    let (mut steps, mut turns, mut facing) = (Vec::new(), Vec::new(), [true, false]);
    for &(time, axis, what) in rig.log.borrow().iter().filter(|edge| edge.1 < 2) {
        match what {
            What::Rise => steps.push((time, axis, i64::from(facing[usize::from(axis)]))),
            What::Dir(forward) => {
                facing[usize::from(axis)] = forward;
                turns.push((time, axis, forward));
            }
            _ => {}
        }
    }
    steps.sort();
    let ends = [0, 1].map(|motor| (rig.cycle.faults(motor), rig.position(motor)));
    (steps, turns, ends, rig.time.now.get(), met)
}

fn leg() -> impl Strategy<Value = Leg> {
    prop_oneof![
        4 => (-40i32..60, 700u32..3_000).prop_map(|(count, delay)| Leg::Steps { count, delay }),
        2 => (-40i32..60, 7u32..20).prop_map(|(count, n)| Leg::Steps { count, delay: n * 100 }),
        1 => (0u32..3, 0u32..2_000).prop_map(|(count, delay)| Leg::Wait { count, delay }),
        // Longer than a piece of a wait.
        1 => (-2i32..2, 134_217_000u32..500_000_000)
            .prop_map(|(count, delay)| Leg::Steps { count, delay }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// One pass per step makes the steps of three passes: each at its tick, to the bounds, through
    /// waits and turns, and while braking; and ends with them. DIR changes later by its hold time
    /// or by a pulse. A motor that sets out for a closed switch is stopped before its step, by the
    /// next event of any motor. The two clocks have other events there, so that the other motor
    /// may brake a step later.
    #[test]
    fn one_pass_steps_as_three(
        legs in prop::array::uniform2(prop::collection::vec(leg(), 0..8)),
        period in prop::sample::select(vec![100u32, 140, 175, 50, 7]),
        brake in prop::option::of(0u64..60_000),
    ) {
        // In one pass the next step is in progress a tick earlier, when STEP rises.
        let freely = played(Clock::Tick { period }, &legs, None).0;
        let rises = |at: u64| freely.iter().any(|step| step.0 / 16 / u64::from(period) == at);
        let brake = brake.map(|us| us / u64::from(period));
        let brake = brake.and_then(|tick| (tick..).find(|tick| !rises(*tick)));
        let brake = brake.map(|tick| tick * u64::from(period) + 3);
        let (steps, turns, ends, over, met) = played(Clock::Tick { period }, &legs, brake);
        let (one, dirs, known, at, meets) = played(Clock::Grid { period }, &legs, brake);
        prop_assert_eq!(meets, met);
        if brake.is_some() && !met {
            let first = |steps: &[(u64, u8, i64)]| steps.iter().filter(|step| step.1 == 0).count();
            prop_assert_eq!(first(&one), first(&steps));
            prop_assert_eq!(known.map(|end| end.0), ends.map(|end| end.0));
            return Ok(());
        }
        prop_assert_eq!(one, steps);
        prop_assert_eq!(dirs.len(), turns.len());
        for (dir, turn) in dirs.iter().zip(&turns) {
            prop_assert_eq!((dir.1, dir.2), (turn.1, turn.2));
            prop_assert!(dir.0 - turn.0 <= 16 + PULSE);
        }
        prop_assert_eq!(known, ends);
        // A closed switch is seen when STEP would rise, not when the bounds are checked.
        let later = if brake.is_some() { 16 * u64::from(period) } else { 0 };
        prop_assert!(at.abs_diff(over) <= 16 + PULSE + later, "{} {}", at, over);
    }
}

/// For any length of a pause, and of the tick: every edge is on the grid of the start again,
/// delayed by the pause and less than a tick.
#[test]
fn a_pause_on_the_fixed_tick_resumes_on_the_grid() {
    let ticks = [(200, 1_000u64), (5_000, 15_000), (70_000, 210_000)];
    for ((tick, delay), passes) in ticks.into_iter().flat_map(|tick| [(tick, 3), (tick, 1)]) {
        let period = tick as u32;
        let clock = if passes == 1 { Clock::Grid { period } } else { Clock::Tick { period } };
        let motor = Motor::new(7_500, delay as u32);
        for pause in [1, tick - 1, tick, tick + 1, 7 * tick + 13, 12_345_678] {
            let mut rig = Rig::new([motor], clock);
            rig.cycle.prepare(0, Program::Steps { count: 6, delay: 0 }, Calibration::None).unwrap();
            rig.start();
            let at = 2 * delay + tick / 3;
            rig.until(at);
            rig.cycle.pause().unwrap();
            rig.until(at + pause);
            assert!(rig.cycle.is_paused());
            rig.cycle.resume().unwrap();
            assert!(!rig.cycle.is_paused() && rig.cycle.is_running());
            if pause % tick != 0 && tick - pause % tick > 2_000 {
                // The motors wait for the grid: another pause before that continues this one.
                rig.until(at + pause + 1);
                rig.cycle.pause().unwrap();
                rig.until(at + pause + 900);
                rig.cycle.resume().unwrap();
                assert_eq!(rig.cycle.resume(), Err(Refusal::NotRunning));
            }
            rig.run_out();
            let shift = pause.div_ceil(tick) * tick;
            // A pulse that the pause ends, or a pulse of one pass, falls early.
            let edge = if passes == 1 { What::Rise } else { What::Fall };
            let before = if passes == 1 { tick } else { 0 };
            let falls: Vec<u64> = (rig.edges(0).iter())
                .filter(|(_, what)| *what == edge)
                .map(|(time, _)| *time)
                .collect();
            let wanted: Vec<u64> = (1..=6)
                .map(|n| (n * delay - before + if n > 2 { shift } else { 0 }) * 16)
                .collect();
            let off = falls.iter().zip(&wanted).map(|(a, b)| a.abs_diff(*b)).max();
            assert!(off <= Some(PULSE) && falls.len() == 6, "{tick} {pause}: {falls:?} {wanted:?}");
            assert_eq!(rig.position(0), 45_000);
        }
    }
}

/// A position is never wrong: the end of the 64 bits is an end, with or without a bound.
#[test]
fn positions_end_where_their_numbers_do() {
    for clock in [Clock::Tick { period: 200 }, Clock::Deadlines] {
        for (start, count, fault, made) in [
            (i64::MAX - 15_000, 5, Faults::SOFT_END_MAX, 2),
            (i64::MIN + 15_001, -5, Faults::SOFT_END_MIN, 2),
            (i64::MAX - 14_999, 5, Faults::SOFT_END_MAX, 1),
        ] {
            for calibration in [Calibration::None, Calibration::BoundsMax] {
                let mut rig = Rig::new([Motor::new(7_500, 1_000)], clock);
                rig.cycle.set_position(0, start).unwrap();
                rig.cycle.prepare(0, Program::Steps { count, delay: 0 }, calibration).unwrap();
                rig.start();
                rig.run_out();
                let way = 7_500 * made * i64::from(count.signum());
                assert_eq!(rig.position(0), start + way, "{clock:?} {start}");
                assert!(rig.cycle.faults(0).has(fault));
                assert_eq!(rig.steps_of(0), made * i64::from(count.signum()));
                // And all the way back.
                let back = Program::Steps { count: -count.signum() * made as i32, delay: 0 };
                rig.cycle.prepare(0, back, calibration).unwrap();
                rig.start();
                rig.run_out();
                assert_eq!(rig.position(0), start);
            }
        }
    }
}
