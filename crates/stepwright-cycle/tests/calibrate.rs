//! The two calibrations: the effect of a program's steps on the position and on the maximum.

use crate::rig::Rig;
use stepwright_cycle::{Calibration, Clock, Faults, Leg, Motor, Program};

const CLOCKS: [Clock; 3] =
    [Clock::Tick { period: 200 }, Clock::Grid { period: 200 }, Clock::Deadlines];

/// Smallest delay 1000, distance 7500.
const M: Motor = Motor::new(7_500, 1_000);

fn steps<'a>(count: i32) -> Program<'a> {
    Program::Steps { count, delay: 0 }
}

#[test]
fn the_two_calibrations() {
    for clock in CLOCKS {
        let mut rig = Rig::new([M.between(-3_000, 9_000)], clock);
        rig.cycle.set_position(0, 5_000).unwrap();
        // No soft ends; every step leaves it at the minimum.
        rig.cycle.prepare(0, steps(-20), Calibration::StartMin).unwrap();
        rig.start();
        assert_eq!(rig.position(0), 5_000);
        rig.until(1_100);
        assert_eq!(rig.position(0), -3_000);
        rig.run_out();
        assert_eq!((rig.position(0), rig.cycle.faults(0)), (-3_000, Faults::NONE));
        // Every step sets the maximum.
        rig.cycle.prepare(0, steps(10), Calibration::BoundsMax).unwrap();
        rig.start();
        rig.until(5_100);
        assert_eq!(rig.cycle.motor(0).unwrap().max, Some(34_500));
        rig.run_out();
        assert_eq!((rig.position(0), rig.cycle.motor(0).unwrap().max), (72_000, Some(72_000)));
        // Now the maximum is a bound.
        rig.cycle.prepare(0, steps(1), Calibration::None).unwrap();
        rig.start();
        rig.run_out();
        assert_eq!((rig.position(0), rig.cycle.faults(0)), (72_000, Faults::SOFT_END_MAX));
    }
}

/// Every step calibrates, also where the steps of a program cancel each other.
#[test]
fn a_calibration_may_end_where_it_began() {
    const fn go(count: i32) -> Leg {
        Leg::Steps { count, delay: 0 }
    }
    const LEGS: [Leg; 4] = [go(-3), go(3), Leg::Wait { count: 1, delay: 5_000 }, go(0)];
    for clock in CLOCKS {
        let rig = |calibration, legs| {
            let mut rig = Rig::new([M.between(-3_000, 9_000)], clock);
            rig.cycle.set_position(0, 5_000).unwrap();
            rig.cycle.prepare(0, Program::Series(legs), calibration).unwrap();
            rig.start();
            rig
        };
        let mut start = rig(Calibration::StartMin, &LEGS);
        start.until(9_000);
        assert_eq!((start.position(0), start.steps_of(0)), (-3_000, 0), "{clock:?}");
        start.run_out();
        assert_eq!((start.position(0), start.steps_of(0)), (-3_000, 0), "{clock:?}");
        let mut bounds = rig(Calibration::BoundsMax, &LEGS);
        bounds.until(9_000);
        assert_eq!(bounds.cycle.motor(0).unwrap().max, Some(5_000), "{clock:?}");
        bounds.run_out();
        assert_eq!(bounds.cycle.motor(0).unwrap().max, Some(5_000), "{clock:?}");
        // A program without a step calibrates nothing.
        for calibration in [Calibration::StartMin, Calibration::BoundsMax] {
            let mut none = rig(calibration, &LEGS[2..]);
            none.run_out();
            assert_eq!((none.position(0), none.cycle.motor(0).unwrap().max), (5_000, Some(9_000)));
        }
    }
}
