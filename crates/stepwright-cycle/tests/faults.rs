//! The known faults of stepper_h's public implementation, each with a test that would show it here.

use crate::rig::{PULSE, Rig, What};
use stepwright_cycle::{
    AtHardEnd, AtSmallDelay, AtSoftEnd, Calibration, Clock, Faults, Leg, Motor, Program, Refusal,
    Status, Strategies,
};

const FIXED: Clock = Clock::Tick { period: 200 };
const BOTH: [Clock; 2] = [FIXED, Clock::Deadlines];
const PLAIN: Calibration = Calibration::None;
const M: Motor = Motor::new(1, 600);

fn steps<'a>(count: i32, delay: u32) -> Program<'a> {
    Program::Steps { count, delay }
}

fn stop_motors() -> Strategies {
    Strategies {
        hard_end: AtHardEnd::StopMotor,
        soft_end: AtSoftEnd::StopMotor,
        small_delay: AtSmallDelay::StopMotor,
        ..Strategies::default()
    }
}

/// "A start on a fresh slot fails for buffered and dynamic."
#[test]
fn the_first_program_may_be_any() {
    const LEGS: [Leg; 1] = [Leg::Steps { count: 2, delay: 700 }];
    for clock in BOTH {
        let mut next = |_: u32| 700;
        let mut rig = Rig::new([M; 3], clock);
        let list = Program::List { delays: &[700, 800], each: 1, forward: true };
        rig.cycle.prepare(0, list, PLAIN).unwrap();
        rig.cycle.prepare(1, Program::Series(&LEGS), PLAIN).unwrap();
        rig.cycle.prepare(2, Program::Dynamic { count: 2, next: &mut next }, PLAIN).unwrap();
        rig.start();
        rig.run_out();
        assert_eq!([0, 1, 2].map(|axis| rig.steps_of(axis)), [2; 3]);
    }
}

/// "One delay too many is fetched at the end, out of bounds."
#[test]
fn a_delay_is_fetched_for_each_step_and_no_more() {
    for clock in BOTH {
        for count in [0, 1, 7, -7] {
            let mut calls = 0;
            let mut next = |step: u32| {
                assert_eq!(step, calls);
                calls += 1;
                600
            };
            let mut rig = Rig::new([M], clock);
            rig.cycle.prepare(0, Program::Dynamic { count, next: &mut next }, PLAIN).unwrap();
            rig.start();
            rig.run_out();
            assert_eq!(rig.steps_of(0), i64::from(count));
            drop(rig);
            assert_eq!(calls, count.unsigned_abs());
        }
    }
}

/// "An endless flag survives into the next series."
#[test]
fn a_series_after_a_whirl_ends() {
    const LEGS: [Leg; 2] =
        [Leg::Steps { count: 3, delay: 700 }, Leg::Steps { count: -1, delay: 700 }];
    for clock in BOTH {
        let mut rig = Rig::new([M], clock);
        rig.cycle.prepare(0, Program::Whirl { forward: true, delay: 600 }, PLAIN).unwrap();
        rig.start();
        rig.until(50_000);
        rig.cycle.finish();
        let whirled = rig.position(0);
        assert!(whirled > 80);
        rig.cycle.prepare(0, Program::Series(&LEGS), PLAIN).unwrap();
        rig.start();
        rig.until(100_000);
        assert!(!rig.cycle.is_running());
        assert_eq!(rig.position(0), whirled + 2);
        assert_eq!(rig.steps_of(0), whirled + 2);
    }
}

/// "An aborted series leaks into the next."
#[test]
fn nothing_of_an_aborted_series_is_left() {
    const LONG: [Leg; 3] = [
        Leg::Wait { count: 1, delay: 9_000 },
        Leg::Steps { count: -40, delay: 5_000 },
        Leg::Steps { count: 40, delay: 9_999 },
    ];
    for clock in BOTH {
        for abort in [100, 9_000, 20_000, 23_950, 230_000] {
            let mut rig = Rig::new([M], clock);
            rig.cycle.prepare(0, Program::Series(&LONG), PLAIN).unwrap();
            rig.start();
            rig.until(abort);
            rig.cycle.finish();
            let at = rig.position(0);
            rig.cycle.prepare(0, steps(5, 1_111), PLAIN).unwrap();
            rig.start();
            rig.run_out();
            assert_eq!((rig.position(0), rig.steps_of(0)), (at + 5, at + 5));
            let mut fresh = Rig::new([M], clock);
            if at < 0 {
                // It has to turn as well.
                fresh.cycle.prepare(0, steps(-1, 600), PLAIN).unwrap();
                fresh.start();
                fresh.run_out();
            }
            fresh.cycle.prepare(0, steps(5, 1_111), PLAIN).unwrap();
            fresh.start();
            fresh.run_out();
            assert_eq!(rig.rises(0), fresh.rises(0), "{clock:?}, aborted at {abort}");
        }
    }
}

/// "Delay 0 in a later series is an error."
#[test]
fn a_delay_of_0_is_the_smallest_everywhere() {
    const LEGS: [Leg; 3] = [
        Leg::Steps { count: 1, delay: 1_000 },
        Leg::Wait { count: 4, delay: 0 },
        Leg::Steps { count: 2, delay: 0 },
    ];
    for clock in BOTH {
        let mut rig = Rig::new([M], clock);
        rig.cycle.prepare(0, Program::Series(&LEGS), PLAIN).unwrap();
        rig.start();
        rig.run_out();
        assert_eq!((rig.cycle.faults(0), rig.steps_of(0)), (Faults::NONE, 3));
        let rises = rig.rises(0);
        let apart = [rises[1] - rises[0], rises[2] - rises[1]];
        assert_eq!(apart, [5 * 600 * 16, 600 * 16], "{clock:?}");
    }
}

/// "Waiting on a bound trips it."
#[test]
fn a_bound_may_be_reached_and_waited_on() {
    const LEGS: [Leg; 3] = [
        Leg::Steps { count: 10, delay: 600 },
        Leg::Wait { count: 3, delay: 2_000 },
        Leg::Steps { count: -10, delay: 600 },
    ];
    for clock in BOTH {
        let mut rig = Rig::new([M.between(0, 10)], clock);
        rig.cycle.prepare(0, Program::Series(&LEGS), PLAIN).unwrap();
        rig.start();
        rig.until(7_000);
        // A switch has no effect there either, while the motor waits and leaves.
        rig.close(0, 1);
        rig.cycle.look();
        assert_eq!((rig.position(0), rig.cycle.is_running()), (10, true));
        rig.run_out();
        assert_eq!((rig.cycle.faults(0), rig.position(0)), (Faults::NONE, 0));
        // To the bound and no further is no fault.
        rig.close(0, 0);
        rig.cycle.prepare(0, steps(10, 0), PLAIN).unwrap();
        rig.start();
        rig.run_out();
        assert_eq!(
            (rig.cycle.faults(0), rig.cycle.error(), rig.position(0)),
            (Faults::NONE, None, 10)
        );
    }
}

/// "One motor's cancel costs the later motors their step of that tick."
#[test]
fn a_cancel_costs_nobody_a_step_that_is_due() {
    // Motor 1 runs into its bound when motors 0 and 2 have a step due.
    let mut rig = Rig::new([M, M.between(0, 10), M], Clock::Deadlines);
    for motor in 0..3 {
        rig.cycle.prepare(motor, steps(100, 700), PLAIN).unwrap();
    }
    rig.start();
    rig.run_out();
    assert_eq!([0, 1, 2].map(|axis| rig.steps_of(axis)), [11, 10, 11]);
    // On the fixed tick a bound is checked two ticks before the step.
    let mut rig = Rig::new([M, M.between(0, 10), M], FIXED);
    rig.cycle.prepare(0, steps(100, 800), PLAIN).unwrap();
    rig.cycle.prepare(1, steps(100, 1_000), PLAIN).unwrap();
    rig.cycle.prepare(2, steps(100, 600), PLAIN).unwrap();
    rig.start();
    rig.run_out();
    // Tick 53: motor 0 has made 13 steps of 4 ticks; motor 2 has made 17 of 3, and its STEP rises
    // for the next one at this very tick.
    let ended = rig.log.borrow().iter().map(|e| e.0).max().unwrap() / 3_200;
    assert_eq!(ended, 53);
    assert_eq!([0, 1, 2].map(|axis| rig.steps_of(axis)), [13, 10, 18]);
    assert_eq!(rig.position(2), 18);
    // With a switch as well.
    let mut rig = Rig::new([M; 3], Clock::Deadlines);
    for motor in 0..3 {
        rig.cycle.prepare(motor, steps(100, 700), PLAIN).unwrap();
    }
    rig.start();
    rig.until(7_000);
    rig.close(0, 0b010);
    rig.run_out();
    assert_eq!([0, 1, 2].map(|axis| rig.steps_of(axis)), [11, 10, 11]);
}

/// A motor that stops moves no edge of the others.
#[test]
fn a_stop_moves_nobody_elses_edges() {
    for clock in BOTH {
        let run = |bound: i64| {
            let mut rig = Rig::new([M, M.between(-bound, bound), M], clock);
            rig.cycle.set_strategies(stop_motors());
            rig.cycle.prepare(0, steps(100, 700), PLAIN).unwrap();
            rig.cycle.prepare(1, steps(-100, 801), PLAIN).unwrap();
            rig.cycle.prepare(2, steps(100, 603), PLAIN).unwrap();
            rig.start();
            rig.run_out();
            let edges = [rig.edges(0), rig.edges(2)];
            (rig.steps_of(1), edges)
        };
        let ((free, whole), (stopped, edges)) = (run(1_000), run(17));
        assert_eq!((free, stopped), (-100, -17));
        for (whole, edges) in whole.iter().zip(&edges) {
            assert_eq!(whole.len(), edges.len());
            let off = whole.iter().zip(edges).map(|(a, b)| a.0.abs_diff(b.0)).max().unwrap();
            // By deadlines an edge may wait for the end of another motor's pulse.
            assert!(off <= if clock == FIXED { 0 } else { PULSE }, "{clock:?}: {off}");
        }
    }
}

/// "Finishing during the high pass leaves STEP high."
#[test]
fn an_end_leaves_no_step_high() {
    for end in 0..4 {
        let mut rig = Rig::new([M, M.between(0, 5)], FIXED);
        rig.cycle.prepare(0, steps(100, 600), PLAIN).unwrap();
        rig.cycle.prepare(1, steps(100, 1_200), PLAIN).unwrap();
        rig.start();
        rig.until(550);
        assert_eq!(rig.edges(0), [(400 * 16, What::Rise)]);
        assert_eq!(rig.position(0), 0, "the step counts when STEP falls");
        match end {
            0 => rig.cycle.finish(),
            1 => rig.cycle.pause().unwrap(),
            2 => {
                rig.cycle.pause().unwrap();
                rig.cycle.finish();
            }
            // Motor 1 cancels while motor 0 is high.
            _ => rig.run_out(),
        }
        let made = rig.steps_of(0);
        assert_eq!(rig.position(0), made);
        if end < 3 {
            assert_eq!((made, rig.edges(0).last()), (1, Some(&(550 * 16, What::Fall))));
        }
    }
}

/// "'Started' is returned for a refused start."
#[test]
fn a_refused_start_says_so_and_leaves_everything() {
    let mut rig = Rig::new([Motor::new(1, 650)], FIXED);
    assert_eq!(rig.cycle.start(), Err(Refusal::Nothing));
    rig.cycle.prepare(0, steps(3, 0), PLAIN).unwrap();
    assert!(rig.cycle.start().is_err());
    assert!(!rig.cycle.is_running());
    rig.run_to(1_000_000);
    assert!(rig.log.borrow().is_empty(), "a refused cycle moved a pin");
    assert_eq!(rig.cycle.status(0), Status::Idle);
    // While a cycle runs, another can't start, and this one continues.
    let mut rig = Rig::new([M], Clock::Deadlines);
    rig.cycle.prepare(0, steps(3, 0), PLAIN).unwrap();
    rig.start();
    assert_eq!(rig.cycle.start(), Err(Refusal::Running));
    rig.run_out();
    assert_eq!(rig.steps_of(0), 3);
}

/// "Preparing while running goes live half filled."
#[test]
fn nothing_can_be_prepared_while_a_cycle_runs() {
    for clock in BOTH {
        let mut rig = Rig::new([M, M], clock);
        rig.cycle.prepare(0, steps(5, 0), PLAIN).unwrap();
        rig.start();
        rig.until(1_000);
        for motor in 0..2 {
            assert_eq!(rig.cycle.prepare(motor, steps(-9, 0), PLAIN), Err(Refusal::Running));
        }
        assert_eq!(rig.cycle.set_position(0, 7), Err(Refusal::Running));
        rig.cycle.pause().unwrap();
        assert_eq!(rig.cycle.prepare(1, steps(-9, 0), PLAIN), Err(Refusal::Running));
        rig.cycle.resume().unwrap();
        rig.run_out();
        assert_eq!([rig.steps_of(0), rig.steps_of(1)], [5, 0]);
    }
}

/// "The count of motors is unchecked."
#[test]
fn there_are_as_many_motors_as_there_are() {
    let mut rig = Rig::new([M; 2], Clock::Deadlines);
    assert_eq!(rig.cycle.prepare(2, steps(1, 0), PLAIN), Err(Refusal::NoMotor));
    assert_eq!(rig.cycle.prepare(255, steps(1, 0), PLAIN), Err(Refusal::NoMotor));
    assert_eq!((rig.cycle.position(2), rig.cycle.motor(200)), (None, None));
    assert_eq!(rig.cycle.status(9), Status::Idle);
    let mut rig = Rig::new([M; 8], Clock::Deadlines);
    for motor in 0..8 {
        rig.cycle.prepare(motor, steps(3, 5_000), PLAIN).unwrap();
    }
    rig.start();
    rig.run_out();
    assert_eq!([0, 1, 2, 3, 4, 5, 6, 7].map(|axis| rig.steps_of(axis)), [3; 8]);
}

/// Two cycles one after another: the second inherits no fault and no program.
#[test]
fn a_cycle_forgets_the_one_before() {
    for clock in BOTH {
        let mut rig = Rig::new([M.between(0, 5), M], clock);
        rig.cycle.prepare(0, steps(6, 0), PLAIN).unwrap();
        rig.cycle.prepare(1, steps(50, 0), PLAIN).unwrap();
        rig.start();
        rig.run_out();
        assert_eq!(rig.cycle.faults(0), Faults::SOFT_END_MAX);
        let at = rig.position(1);
        rig.cycle.prepare(0, steps(-5, 0), PLAIN).unwrap();
        rig.start();
        rig.run_out();
        assert_eq!((rig.cycle.faults(0), rig.cycle.error()), (Faults::NONE, None));
        assert_eq!([rig.position(0), rig.position(1)], [0, at]);
        assert_eq!(rig.cycle.status(1), Status::Idle);
    }
}
