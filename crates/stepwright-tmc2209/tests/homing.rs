//! Homing against a stop that the motor can't pass, and alarms during work.

use std::cell::RefCell;
use std::rc::Rc;

use crate::bench::{self, Bench, Moved};
use crate::model::{self, Chip, DRV_STATUS, Delay, Diag, Wire};
use embassy_futures::select::{Either, select};
use proptest::prelude::*;
use stepwright::profile::Unfit;
use stepwright::{Accel, Axis, AxisLimits, MoveError, Speed};
use stepwright_embassy::Outcome;
use stepwright_sim::HardStop;
use stepwright_tmc2209::{
    DriverAddress, DriverError, DriverFault, DriverSetup, NotHomed, StallHoming, Tmc2209,
    brake_on_alarm,
};

/// Microsteps per full step, and steps per electrical period.
const FULL: u32 = 16;
const PERIOD: u32 = 4 * FULL;

const SETUP: DriverSetup = DriverSetup::new(110, 800).stall(60, Speed::of::<1_000>());

const HOMING: StallHoming = StallHoming {
    forward: false,
    speed: Speed::of::<4_000>(),
    second: Speed::of::<2_500>(),
    accel: Accel::of::<20_000>(),
    milliamps: 500,
    dwell: 100,
    least: 600,
    back_off: 1_000,
    most: 20_000,
    position: 50,
};

/// Plays a scenario on a board whose X runs against a stop, with its driver chip, the driver, and
/// DIAG.
fn with(
    stop: HardStop,
    play: impl AsyncFnOnce(
        &Bench<'_>,
        &Moved<'_>,
        Rc<RefCell<Chip>>,
        &mut Tmc2209<Wire, Delay>,
        &mut Diag,
    ),
) {
    bench::with(|bench, motors| {
        let chip = Rc::new(RefCell::new(Chip::new(0)));
        bench.shafts.borrow_mut().stops[0] = Some(stop);
        let mut driver = Tmc2209::new(
            Wire(Rc::clone(&chip), Rc::clone(&bench.around)),
            Delay(Rc::clone(&bench.around)),
            DriverAddress::A0,
        );
        let mut diag = Diag(Rc::clone(&chip), Rc::clone(&bench.around));
        let task = Box::pin(async move {
            driver.set_up(&SETUP).await.unwrap();
            play(bench, motors, chip, &mut driver, &mut diag).await;
        });
        bench.run(motors, [task as _]);
        assert_eq!(motors.late(), 0);
    });
}

/// The position of the rotor of X.
fn rotor(bench: &Bench<'_>) -> i64 {
    bench.shafts.borrow().stops[0].unwrap().rotor()
}

/// Homes, and returns the error of the position: the rotor's distance to the stop minus the nominal
/// one.
fn homed(stop: HardStop, homing: StallHoming) -> i64 {
    let mut off = i64::MAX;
    with(stop, async |bench, motors, chip, driver, diag| {
        let mut x = motors.axis(Axis::X);
        let limits = x.limits();
        homing.home(&mut x, driver, diag).await.unwrap();
        assert_eq!(x.limits(), limits);
        let back_off = i64::from(homing.back_off);
        let back = if homing.forward { -back_off } else { back_off };
        assert_eq!(x.position(), Some(homing.position + back));
        off = rotor(bench) - back;
        // 800 mA, 500 during homing, 800 again; no step within the dwell after a change.
        let currents = chip.borrow().currents.clone();
        assert_eq!(currents.iter().map(|(_, steps)| *steps).collect::<Vec<_>>(), [25, 15, 25]);
        let steps = &bench.shafts.borrow().steps[0];
        for (changed, _) in &currents[1..] {
            let dwell = changed + 1..changed + 100_000;
            assert!(!steps.iter().any(|step| dwell.contains(step)), "a step in the dwell");
        }
    });
    off
}

/// From any start, on both sides: within two full steps of the stop.
#[test]
fn it_homes_within_two_full_steps() {
    for start in [1_000, 1_001, 1_777, 5_000, 12_345, 19_000] {
        for forward in [false, true] {
            let stop = if forward {
                HardStop::above(0, -start, PERIOD)
            } else {
                HardStop::below(0, start, PERIOD)
            };
            let off = homed(stop, StallHoming { forward, ..HOMING });
            println!("{start} steps away, forward {forward}: {off} steps off");
            assert!(off.abs() <= 2 * i64::from(FULL), "{start}: {off}");
        }
    }
}

/// At the stop, or so near that the motor does not reach its speed: it backs off and tries again.
#[test]
fn it_homes_from_the_stop() {
    for start in [0, 3, 100, 590] {
        let off = homed(HardStop::below(0, start, PERIOD), HOMING);
        assert!(off.abs() <= 2 * i64::from(FULL), "{start}: {off}");
    }
}

/// A false stall on the ramp, where StallGuard can't detect anything, does not count.
#[test]
fn a_stall_within_the_least_distance_is_none() {
    with(HardStop::below(0, 5_000, PERIOD), async |bench, motors, chip, driver, diag| {
        chip.borrow_mut().false_stall = Some(300);
        let mut x = motors.axis(Axis::X);
        assert_eq!(HOMING.home(&mut x, driver, diag).await, Ok(()));
        let off = rotor(bench) - i64::from(HOMING.back_off);
        assert!(off.abs() <= 2 * i64::from(FULL), "{off}");
        // Without a least distance, the false stall is taken for the stop.
        let hasty = StallHoming { least: 0, ..HOMING };
        assert!(matches!(x.move_by(3_000).await.unwrap(), Outcome::Reached { .. }));
        chip.borrow_mut().false_stall = Some(bench.shafts.borrow().steps[0].len() + 300);
        assert_eq!(hasty.home(&mut x, driver, diag).await, Err(NotHomed::NoStall));
    });
}

#[test]
fn no_stall_and_one_that_comes_too_soon_are_told() {
    let judge = |start, homing: StallHoming, setup: DriverSetup, expected| {
        with(HardStop::below(0, start, PERIOD), async |_, motors, chip, driver, diag| {
            let mut x = motors.axis(Axis::X);
            driver.set_up(&setup).await.unwrap();
            let limits = x.limits();
            let before = chip.borrow().registers[model::IHOLD_IRUN];
            assert_eq!(homing.home(&mut x, driver, diag).await, Err(expected));
            assert_eq!((x.position(), x.is_moving(), x.limits()), (None, false, limits));
            assert_eq!(chip.borrow().registers[model::IHOLD_IRUN], before);
        });
    };
    // The stop is beyond the search; the speed is below that of stall detection; any load counts as
    // a stall.
    judge(25_000, HOMING, SETUP, NotHomed::NoStall);
    judge(5_000, HOMING, SETUP.stall(60, Speed::of::<5_000>()), NotHomed::NoStall);
    judge(5_000, HOMING, SETUP.stall(200, Speed::of::<1_000>()), NotHomed::TooSoon);
}

/// More steps than a travel may have are refused before anything moves.
#[test]
fn too_long_a_way_is_refused() {
    for homing in [
        StallHoming { most: 1 << 31, ..HOMING },
        StallHoming { least: 1 << 30, ..HOMING },
        StallHoming { back_off: u32::MAX, ..HOMING },
    ] {
        with(HardStop::below(0, 5_000, PERIOD), async |bench, motors, _, driver, diag| {
            let mut x = motors.axis(Axis::X);
            let refused = homing.home(&mut x, driver, diag).await;
            assert_eq!(refused, Err(NotHomed::Move(Unfit::TooLong.into())));
            assert_eq!((x.position(), bench.shafts.borrow().steps[0].len()), (None, 0));
        });
    }
}

/// A driver that switches itself off is not taken for a stall.
#[test]
fn a_fault_is_no_stall() {
    with(HardStop::below(0, 9_000, PERIOD), async |bench, motors, chip, driver, diag| {
        let mut x = motors.axis(Axis::X);
        let fault = async {
            bench.after(1_000).await;
            chip.borrow_mut().registers[DRV_STATUS] |= 1 << 1;
            std::future::pending::<()>().await;
        };
        let Either::First(Err(NotHomed::Faulty(faults))) =
            select(HOMING.home(&mut x, driver, diag), fault).await
        else {
            panic!("no fault")
        };
        assert!(faults.has(DriverFault::Overheated));
        assert_eq!(x.position(), None);
    });
}

/// A driver that has lost its settings detects no stall: it is not driven against the stop.
#[test]
fn a_driver_that_was_reset_is_not_homed() {
    with(HardStop::below(0, 5_000, PERIOD), async |bench, motors, chip, driver, diag| {
        chip.borrow_mut().registers = Chip::at_power_up();
        let mut x = motors.axis(Axis::X);
        let Err(NotHomed::Faulty(faults)) = HOMING.home(&mut x, driver, diag).await else {
            panic!("homed")
        };
        assert!(faults.has(DriverFault::Reset));
        assert_eq!((x.position(), bench.shafts.borrow().steps[0].len()), (None, 0));
        assert_eq!(chip.borrow().registers, Chip::at_power_up());
    });
}

/// Nor is one that was never set up, and its current stays.
#[test]
fn a_driver_that_was_not_set_up_is_not_homed() {
    with(HardStop::below(0, 5_000, PERIOD), async |bench, motors, chip, _, diag| {
        let wire = Wire(Rc::clone(&chip), Rc::clone(&bench.around));
        let mut other = Tmc2209::new(wire, Delay(Rc::clone(&bench.around)), DriverAddress::A0);
        let before = chip.borrow().registers[model::IHOLD_IRUN];
        let homed = HOMING.home(&mut motors.axis(Axis::X), &mut other, diag).await;
        assert_eq!(homed, Err(NotHomed::Driver(DriverError::NotSetUp)));
        assert_eq!(chip.borrow().registers[model::IHOLD_IRUN], before);
    });
}

/// Stopping the axis stops its homing.
#[test]
fn homing_is_stopped_and_dropped() {
    with(HardStop::below(0, 9_000, PERIOD), async |bench, motors, _, driver, diag| {
        let mut x = motors.axis(Axis::X);
        let stop = async {
            bench.after(500).await;
            motors.axis(Axis::X).stop().await;
            std::future::pending::<()>().await;
        };
        let ended = select(HOMING.home(&mut x, driver, diag), stop).await;
        assert!(matches!(ended, Either::First(Err(NotHomed::Stopped))));
        assert!(rotor(bench) > 5_000);
        // A dropped homing brakes.
        x.set_position(0).unwrap();
        select(HOMING.home(&mut x, driver, diag), bench.after(700)).await;
        x.rest().await;
        assert!(rotor(bench) > 3_000, "{}", rotor(bench));
    });
}

/// During work a stall and a fault brake the axis along its ramp, and its position becomes unknown.
#[test]
fn an_alarm_brakes_and_forgets() {
    for by_stall in [true, false] {
        let far = if by_stall { 4_000 } else { 40_000 };
        with(HardStop::above(far, 0, PERIOD), async |bench, motors, chip, _, diag| {
            let mut x = motors.axis(Axis::X);
            x.set_limits(AxisLimits::new(Speed::of::<4_000>(), Accel::of::<20_000>()));
            let work = async {
                assert_eq!(x.move_to(30_000).await, Ok(Outcome::Uncertain));
                assert_eq!(x.move_to(0).await, Err(MoveError::PositionUnknown));
            };
            let fault = async {
                bench.after(1_500).await;
                if !by_stall {
                    chip.borrow_mut().registers[DRV_STATUS] |= 1 << 2;
                }
                std::future::pending::<()>().await;
            };
            let watch = select(brake_on_alarm(motors, Axis::X, diag), fault);
            assert!(matches!(select(work, watch).await, Either::First(())));
            let shafts = bench.shafts.borrow();
            let steps = &shafts.steps[0];
            let last = steps[steps.len() - 1] - steps[steps.len() - 2];
            assert!(last > 3_000, "{last} µs: it did not brake");
            // 400 steps of braking, and the steps that were already planned.
            assert!(steps.len() < 7_000, "{}", steps.len());
        });
    }
}

/// Also moves that begin while DIAG is high already.
#[test]
fn a_move_that_begins_during_an_alarm_brakes() {
    with(HardStop::above(90_000, 0, PERIOD), async |bench, motors, chip, _, diag| {
        chip.borrow_mut().registers[DRV_STATUS] |= 1 << 2;
        let mut x = motors.axis(Axis::X);
        let work = async {
            for round in 0..3 {
                bench.after(500).await;
                x.set_position(0).unwrap();
                assert_eq!(x.move_to(9_000).await, Ok(Outcome::Uncertain), "{round}");
                let made = bench.shafts.borrow().at[0];
                assert!(made < 300 * (round + 1), "{made} steps in {round}");
            }
            // The alarm has ended.
            chip.borrow_mut().registers[DRV_STATUS] = 0;
            bench.after(500).await;
            x.set_position(0).unwrap();
            assert_eq!(x.move_to(1_000).await, Ok(Outcome::Reached { at: 1_000 }));
        };
        let watch = brake_on_alarm(motors, Axis::X | Axis::Y, diag);
        assert!(matches!(select(work, watch).await, Either::First(())));
    });
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn it_homes_whatever_the_way(
        start in 0i64..15_000, speed in 2_000u32..6_000, second in 1_500u32..4_000,
        accel in 10_000u32..60_000, back_off in 900u32..3_000, least in 1_900u32..3_000,
    ) {
        let homing = StallHoming {
            speed: Speed::from_steps(speed).unwrap(),
            second: Speed::from_steps(second).unwrap(),
            accel: Accel::from_steps(accel).unwrap(),
            back_off,
            least,
            ..HOMING
        };
        let off = homed(HardStop::below(0, start, PERIOD), homing);
        prop_assert!(off.abs() <= 2 * i64::from(FULL), "{} steps", off);
    }
}
