//! What a pause leaves of the grid of the fixed tick, and where positions end.

#[path = "common/rig.rs"]
mod rig;

use rig::{PULSE, Rig, What};
use stepwright_cycle::{Calibration, Clock, Faults, Motor, Program, Refusal};

/// However long a pause is, and the tick: every edge is on the grid of the start again, as late
/// as the pause and less than a tick more.
#[test]
fn a_pause_on_the_fixed_tick_resumes_on_the_grid() {
    for (tick, delay) in [(200, 1_000u64), (5_000, 15_000), (70_000, 210_000)] {
        let clock = Clock::Tick { period: tick as u32 };
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
                // It waits for the grid: another pause meanwhile goes on with this one.
                rig.until(at + pause + 1);
                rig.cycle.pause().unwrap();
                rig.until(at + pause + 900);
                rig.cycle.resume().unwrap();
                assert_eq!(rig.cycle.resume(), Err(Refusal::NotRunning));
            }
            rig.run_out();
            let shift = pause.div_ceil(tick) * tick;
            let falls: Vec<u64> = (rig.edges(0).iter())
                .filter(|(_, what)| *what == What::Fall)
                .map(|(time, _)| *time)
                .collect();
            let wanted: Vec<u64> =
                (1..=6).map(|n| (n * delay + if n > 2 { shift } else { 0 }) * 16).collect();
            let off = falls.iter().zip(&wanted).map(|(a, b)| a.abs_diff(*b)).max();
            assert!(off <= Some(PULSE) && falls.len() == 6, "{tick} {pause}: {falls:?} {wanted:?}");
            assert_eq!(rig.position(0), 45_000);
        }
    }
}

/// A position never lies: where 64 bits end is an end, bound or no bound.
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
