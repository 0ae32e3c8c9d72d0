//! stepper_h's numbers: on its fixed tick exactly, tick for tick, and by deadlines.

use crate::rig::{self, PULSE, Rig, What};
use stepwright_cycle::{
    AtSmallDelay, AtSoftEnd, Calibration, Clock, CycleError, End, Faults, Leg, Motor, Program,
    Refusal, Status, Strategies,
};

/// Ticks of the timer in a µs, and in a fixed tick of 200 µs.
const US: u64 = 16;
const TICK: u64 = 200 * US;

const FIXED: Clock = Clock::Tick { period: 200 };
const BOTH: [Clock; 2] = [FIXED, Clock::Deadlines];
const PLAIN: Calibration = Calibration::None;

/// Smallest delay 1000, distance 7500.
const M: Motor = Motor::new(7_500, 1_000);

fn steps<'a>(count: i32, delay: u32) -> Program<'a> {
    Program::Steps { count, delay }
}

fn one<'a>(motor: Motor, clock: Clock, program: Program<'a>) -> Rig<'a, 1> {
    let mut rig = Rig::new([motor], clock);
    rig.cycle.prepare(0, program, PLAIN).unwrap();
    rig.start();
    rig
}

#[test]
fn three_steps_on_the_fixed_tick() {
    let mut rig = one(M, FIXED, steps(3, 0));
    for (tick, position) in [(4, 0), (5, 7_500), (9, 7_500), (10, 15_000), (14, 15_000)] {
        rig.until(200 * tick);
        assert_eq!(rig.position(0), position, "at tick {tick}");
    }
    rig.until(200 * 15);
    assert_eq!((rig.position(0), rig.cycle.is_running()), (22_500, true));
    rig.until(200 * 16);
    assert!(!rig.cycle.is_running());
    assert_eq!(rig.cycle.status(0), Status::Finished);
    let edges = rig.edges(0);
    let wanted = [5, 10, 15].map(|n| [((n - 1) * TICK, What::Rise), (n * TICK, What::Fall)]);
    assert_eq!(edges, wanted.concat());
}

#[test]
fn a_leftover_is_carried() {
    let mut rig = one(M, FIXED, steps(5, 1_105));
    rig.run_out();
    let falls: Vec<u64> =
        rig.edges(0).iter().filter(|e| e.1 == What::Fall).map(|e| e.0 / TICK).collect();
    assert_eq!(falls, [5, 11, 16, 22, 27]);
    // By deadlines every step is at its requested time.
    let mut rig = one(M, Clock::Deadlines, steps(5, 1_105));
    rig.run_out();
    assert_eq!(rig.rises(0), [1, 2, 3, 4, 5].map(|n| n * 1_105 * US));
}

#[test]
fn a_triangle() {
    for clock in BOTH {
        let mut rig = Rig::new([M; 3], clock);
        let mut go = |programs: &[(u8, i32, u32)], wanted: [Option<i64>; 3]| {
            for &(motor, count, delay) in programs {
                rig.cycle.prepare(motor, steps(count, delay), PLAIN).unwrap();
            }
            rig.start();
            rig.run_out();
            for (motor, wanted) in (0..).zip(wanted) {
                if let Some(wanted) = wanted {
                    assert_eq!(rig.position(motor), wanted, "{motor} {clock:?}");
                }
            }
        };
        go(
            &[(0, 20_000, 1_000), (1, 6_666, 3_000), (2, 2_666, 7_500)],
            [Some(150_000_000), Some(49_995_000), Some(19_995_000)],
        );
        go(
            &[(0, -13_333, 1_000), (1, 13_334, 1_000)],
            [Some(50_002_500), Some(150_000_000), Some(19_995_000)],
        );
        go(&[(0, -6_667, 3_000), (1, -20_000, 1_000), (2, -2_666, 7_500)], [Some(0); 3]);
        assert_eq!([0, 1, 2].map(|axis| rig.steps_of(axis)), [0; 3]);
    }
}

/// The README's example: three motors at once, 20 s.
#[test]
fn the_example_of_the_readme() {
    for clock in BOTH {
        let motors = [
            M.between(0, 300_000_000),
            M.inverted().between(0, 216_000_000),
            M.inverted().between(0, 100_000_000),
        ];
        let mut rig = Rig::new(motors, clock);
        for (motor, count, delay) in [(0, 20_000, 1_000), (1, 10_000, 2_000), (2, 1_000, 20_000)] {
            rig.cycle.prepare(motor, steps(count, delay), PLAIN).unwrap();
        }
        rig.start();
        let mut last = 0;
        for second in 1..20 {
            rig.until(second * 1_000_000);
            let x = rig.position(0) / 7_500;
            assert!((999..=1_001).contains(&(x - last)), "{x} after {second} s");
            last = x;
        }
        rig.until(19_999_000 - 1);
        assert_eq!((rig.position(0), rig.cycle.is_running()), (19_998 * 7_500, true));
        rig.until(20_000_200);
        assert_eq!([0, 1, 2].map(|m| rig.position(m)), [150_000_000, 75_000_000, 7_500_000]);
        assert!(!rig.cycle.is_running());
        assert_eq!((rig.cycle.late(), rig.cycle.error()), (0, None));
    }
}

#[test]
fn a_series_with_turns() {
    const LEGS: [Leg; 3] = [
        Leg::Steps { count: 4, delay: 1_000 },
        Leg::Steps { count: -2, delay: 10_000 },
        Leg::Steps { count: 4, delay: 2_000 },
    ];
    for clock in BOTH {
        let mut rig = one(M, clock, Program::Series(&LEGS));
        for (tick, position) in [(20, 30_000), (69, 30_000), (120, 15_000), (160, 45_000)] {
            // A pulse of another length may begin at the same time.
            rig.until(200 * tick + u64::from(clock == Clock::Deadlines));
            assert_eq!(rig.position(0), position, "tick {tick} {clock:?}");
        }
        rig.run_out();
        let turns: Vec<_> =
            rig.edges(0).into_iter().filter(|e| matches!(e.1, What::Dir(_))).collect();
        // The direction is set one whole delay before the first step; by deadlines in the middle of
        // the delay, at most 2 ms after the previous step.
        let after = if clock == FIXED { [0, 0] } else { [1 << 15, 5 * TICK] };
        assert_eq!(
            turns,
            [(20 * TICK + after[0], What::Dir(false)), (120 * TICK + after[1], What::Dir(true))]
        );
        assert_eq!(rig.steps_of(0), 6);
    }
}

/// One turn of 40 mm in 1/16 steps.
#[test]
fn a_turn_of_a_belt() {
    let mut rig = one(Motor::new(12_500, 80), Clock::Tick { period: 20 }, steps(3_200, 80));
    rig.until(12_800 * 20 - 1);
    assert_eq!(rig.position(0), 40_000_000 - 12_500);
    rig.until(12_800 * 20);
    assert_eq!(rig.position(0), 40_000_000);
}

#[test]
fn a_bound_stops_before_any_pulse() {
    let mut rig = one(M.between(0, 300_000_000), FIXED, steps(-300, 0));
    rig.until(200 * 3 - 1);
    assert!(rig.cycle.is_running());
    rig.until(200 * 3);
    assert!(!rig.cycle.is_running());
    assert_eq!(rig.cycle.faults(0), Faults::SOFT_END_MIN);
    assert_eq!(rig.cycle.error(), Some(CycleError::MotorError { motor: 0 }));
    assert_eq!((rig.position(0), rig.rises(0).len()), (0, 0));
    // By deadlines the check comes when the step would be due.
    let mut rig = one(M.between(0, 300_000_000), Clock::Deadlines, steps(-300, 0));
    rig.until(999);
    assert!(rig.cycle.is_running());
    rig.until(1_000);
    assert!(!rig.cycle.is_running());
    assert_eq!((rig.position(0), rig.rises(0).len()), (0, 0));
}

/// The fixed tick needs a smallest delay of at least three ticks, without remainder; deadlines need
/// neither.
#[test]
fn what_a_clock_needs() {
    let refusal = |clock, smallest| {
        let mut rig = Rig::<1>::new([Motor::new(1, smallest)], clock);
        rig.cycle.prepare(0, steps(1, 0), PLAIN).unwrap();
        let refusal = rig.cycle.start().err();
        assert!(refusal.is_none() || (!rig.cycle.is_running() && rig.log.borrow().is_empty()));
        refusal
    };
    assert_eq!(refusal(FIXED, 400), Some(Refusal::PeriodTooLong { motor: 0, needs: 600 }));
    assert_eq!(refusal(FIXED, 650), Some(Refusal::PeriodAliquant { motor: 0, needs: 800 }));
    assert_eq!(refusal(FIXED, 600), None);
    for smallest in [400, 650, 1_105, 20] {
        assert_eq!(refusal(Clock::Deadlines, smallest), None);
    }
    // 133 ticks of 16 MHz.
    assert_eq!(refusal(Clock::Deadlines, 8), Some(Refusal::TooFast { motor: 0, needs: 9 }));
}

/// The delays that fit a period, for a motor that wants 1500 … 40 µs.
#[test]
fn delays_that_fit_a_period() {
    let fits = |period: u32, smallest: u32| {
        let mut delay = smallest;
        loop {
            let mut rig = Rig::<1>::new([Motor::new(1, delay)], Clock::Tick { period });
            rig.cycle.prepare(0, steps(1, 0), PLAIN).unwrap();
            match rig.cycle.start() {
                Ok(()) => return delay,
                Err(
                    Refusal::PeriodTooLong { needs, .. } | Refusal::PeriodAliquant { needs, .. },
                ) => delay = needs,
                Err(other) => panic!("{other}"),
            }
        }
    };
    let wanted = [1_500, 650, 330, 180, 80, 40];
    assert_eq!(wanted.map(|us| fits(20, us)), [1_500, 660, 340, 180, 80, 60]);
    assert_eq!(wanted.map(|us| fits(200, us)), [1_600, 800, 600, 600, 600, 600]);
}

#[test]
fn motors_share_what_a_board_can_do() {
    let mut rig = Rig::new([Motor::new(1, 20); 3], Clock::Deadlines);
    for motor in 0..3 {
        rig.cycle.prepare(motor, steps(10, 20), PLAIN).unwrap();
    }
    // 133 of 320 ticks each: three motors need more than all the time.
    assert_eq!(rig.cycle.start(), Err(Refusal::TooFast { motor: 2, needs: 50 }));
    rig.cycle.prepare(2, steps(10, 50), PLAIN).unwrap();
    rig.start();
    rig.run_out();
    assert_eq!([0, 1, 2].map(|axis| rig.steps_of(axis)), [10; 3]);
}

#[test]
fn small_delays_by_strategy() {
    for clock in BOTH {
        let run = |small_delay, motors: [Motor; 2]| {
            let mut rig = Rig::new(motors, clock);
            rig.cycle.set_strategies(Strategies { small_delay, ..Strategies::default() });
            rig.cycle.prepare(0, steps(5, 999), PLAIN).unwrap();
            rig.cycle.prepare(1, steps(5, 1_000), PLAIN).unwrap();
            let started = rig.cycle.start();
            rig.run_out();
            let faults = rig.cycle.faults(0);
            (started, faults, [rig.steps_of(0), rig.steps_of(1)], rig.rises(0).first().copied())
        };
        let (started, faults, steps, _) = run(AtSmallDelay::Cancel, [M; 2]);
        assert_eq!(started, Err(Refusal::SmallDelay { motor: 0, needs: 1_000 }));
        assert_eq!((faults, steps), (Faults::STEP_DELAY_SMALL, [0, 0]));
        let (started, faults, steps, _) = run(AtSmallDelay::StopMotor, [M; 2]);
        assert_eq!((started, faults, steps), (Ok(()), Faults::STEP_DELAY_SMALL, [0, 5]));
        let (started, faults, steps, first) = run(AtSmallDelay::Fix, [M; 2]);
        assert_eq!((started, faults, steps), (Ok(()), Faults::NONE, [5, 5]));
        let first = first.unwrap();
        assert!(first == 800 * US || first == 1_000 * US, "{first}");
    }
}

#[test]
fn ends_by_strategy() {
    for clock in BOTH {
        for (soft_end, others) in [(AtSoftEnd::StopMotor, 100), (AtSoftEnd::Cancel, 10)] {
            let mut rig = Rig::new([M.between(0, 75_000), M], clock);
            rig.cycle.set_strategies(Strategies { soft_end, ..Strategies::default() });
            rig.cycle.prepare(0, Program::Whirl { forward: true, delay: 0 }, PLAIN).unwrap();
            rig.cycle.prepare(1, steps(100, 1_000), PLAIN).unwrap();
            rig.start();
            rig.run_out();
            assert_eq!(rig.cycle.faults(0), Faults::SOFT_END_MAX);
            assert_eq!((rig.position(0), rig.steps_of(0)), (75_000, 10));
            // By deadlines the eleventh step of the other motor is due at the same time as the
            // bound.
            let due = i64::from(clock == Clock::Deadlines && soft_end == AtSoftEnd::Cancel);
            assert_eq!(rig.steps_of(1), others + due, "{clock:?}");
        }
    }
}

#[test]
fn a_switch_is_latched_and_left() {
    for clock in BOTH {
        let mut rig = one(M, clock, Program::Whirl { forward: false, delay: 0 });
        rig.until(10_500);
        rig.close(1, 0);
        rig.cycle.look();
        assert!(!rig.cycle.is_running());
        assert_eq!(rig.cycle.faults(0), Faults::HARD_END_MIN);
        assert_eq!(rig.cycle.trigger(0, End::Min), Some(-75_000));
        assert_eq!((rig.position(0), rig.cycle.trigger(0, End::Max)), (-75_000, None));
        // It can't continue in this direction …
        rig.cycle.prepare(0, steps(-1, 0), PLAIN).unwrap();
        rig.start();
        rig.run_out();
        assert_eq!((rig.cycle.faults(0), rig.position(0)), (Faults::HARD_END_MIN, -75_000));
        // … but it can move away.
        rig.cycle.prepare(0, steps(4, 0), PLAIN).unwrap();
        rig.start();
        rig.run_out();
        assert_eq!((rig.cycle.faults(0), rig.position(0)), (Faults::NONE, -45_000));
        assert_eq!(rig.steps_of(0), -6);
    }
}

/// The ticks of the steps of a program, and the sum of its steps.
fn times_of(clock: Clock, program: Program) -> (Vec<u64>, i64) {
    let mut rig = one(Motor::new(1, 600), clock, program);
    rig.until(100_000);
    let rise = if clock == FIXED { TICK } else { 0 };
    rig.cycle.finish();
    (rig.rises(0).iter().map(|t| (t + rise) / TICK).collect(), rig.steps_of(0))
}

/// Lists, callbacks and waits, step by step.
#[test]
fn every_way_of_preparing() {
    for clock in BOTH {
        let times = |program| times_of(clock, program);
        let list = Program::List { delays: &[1_000, 2_000, 600], each: 2, forward: false };
        assert_eq!(times(list), (vec![5, 10, 20, 30, 33, 36], -6));
        let legs = [
            Leg::Wait { count: 2, delay: 1_000 },
            Leg::Steps { count: 2, delay: 0 },
            Leg::Steps { count: 0, delay: 1 },
            Leg::Wait { count: 1, delay: 10_000 },
            Leg::Steps { count: -1, delay: 600 },
            Leg::Wait { count: 1, delay: 800 },
        ];
        assert_eq!(times(Program::Series(&legs)), (vec![13, 16, 69], 1));
        let mut asked = Vec::new();
        let mut next = |step: u32| {
            asked.push(step);
            1_000 + 200 * step
        };
        let program = Program::Dynamic { count: 4, next: &mut next };
        assert_eq!(times_of(clock, program), (vec![5, 11, 18, 26], 4));
        assert_eq!(asked, [0, 1, 2, 3]);
        let mut next = |_: u32| 20_000;
        let program = Program::DynamicWhirl { forward: false, next: &mut next };
        assert_eq!(times_of(clock, program), (vec![100, 200, 300, 400, 500], -5));
    }
}

/// Delays up to 71 minutes, and a pause longer than the counter.
#[test]
fn long_delays_and_long_pauses() {
    for clock in BOTH {
        let mut rig = one(M, clock, steps(2, 4_000_000_000));
        rig.until(1_000_000_000);
        rig.cycle.pause().unwrap();
        assert!(rig.cycle.is_paused() && rig.cycle.is_running());
        rig.until(1_777_777_777);
        rig.cycle.resume().unwrap();
        rig.run_out();
        let rise = if clock == FIXED { TICK } else { 0 };
        // On the fixed tick in whole ticks.
        let pause = if clock == FIXED { 777_777_800 } else { 777_777_777 };
        assert_eq!(
            rig.rises(0),
            [4_000_000_000u64 + pause, 8_000_000_000 + pause].map(|us| us * US - rise)
        );
    }
}

#[test]
fn pause_and_resume_shift_every_step() {
    for clock in BOTH {
        for at in [2_950u64, 3_000, 3_050] {
            let mut rig = Rig::new([M, Motor::new(1, 600)], clock);
            rig.cycle.prepare(0, steps(10, 0), PLAIN).unwrap();
            rig.cycle.prepare(1, steps(-7, 777), PLAIN).unwrap();
            rig.start();
            rig.until(at);
            let before = [rig.position(0), rig.position(1)];
            rig.cycle.pause().unwrap();
            assert_eq!(rig.cycle.pause(), Err(Refusal::NotRunning));
            rig.until(at + 1_234_567);
            assert!([0, 1].map(|axis| rig.steps_of(axis)).iter().all(|steps| *steps != 0));
            assert!(
                [rig.position(0) - before[0], rig.position(1) - before[1]]
                    .iter()
                    .all(|moved| [0, 7_500, -1].contains(moved))
            );
            rig.cycle.resume().unwrap();
            rig.run_out();
            assert_eq!([rig.position(0), rig.position(1)], [75_000, -7]);
            let mut alone = one(Motor::new(1, 600), clock, steps(-7, 777));
            alone.run_out();
            // On the fixed tick a pause lasts whole ticks.
            let pause = if clock == Clock::Deadlines { 1_234_567 } else { 1_234_600 };
            let moved = |t: &u64| if *t <= at * US { *t } else { t + pause * US };
            let wanted: Vec<u64> = alone.rises(0).iter().map(moved).collect();
            let off = rig.rises(1).iter().zip(&wanted).map(|(a, b)| a.abs_diff(*b)).max();
            assert!(off <= Some(PULSE), "{clock:?} {at}: {off:?}");
        }
    }
}

#[test]
fn drivers_are_on_while_a_cycle_runs() {
    let mut rig = Rig::new([M; 3], Clock::Deadlines);
    rig.cycle.prepare(0, steps(2, 0), PLAIN).unwrap();
    rig.cycle.prepare(2, steps(4, 0), PLAIN).unwrap();
    rig.start();
    rig.run_out();
    let log = rig.log.borrow();
    let enables: Vec<_> = log.iter().filter(|e| matches!(e.2, What::Enable(_))).collect();
    assert_eq!(enables.len(), 2);
    assert_eq!(enables[0], &(0, 255, What::Enable(0b101)));
    assert_eq!(enables[1].2, What::Enable(0));
    assert!(enables[1].0 >= 4_000 * US);
}

#[test]
fn inverted_motors_turn_the_other_way_and_count_the_same() {
    for clock in BOTH {
        let mut rig = one(M.inverted(), clock, steps(-3, 0));
        rig.run_out();
        assert_eq!(rig.position(0), -22_500);
        assert!(rig.edges(0).iter().any(|e| e.1 == What::Dir(true)));
    }
}

#[test]
fn a_motor_is_described_anew_and_stays_where_it_is() {
    let other = Motor::new(100, 500).between(0, 30_000).inverted();
    for clock in BOTH {
        let mut rig = one(M, clock, steps(3, 0));
        assert_eq!(rig.cycle.set_motor(0, other), Err(Refusal::Running));
        rig.run_out();
        assert_eq!(rig.cycle.set_motor(1, other), Err(Refusal::NoMotor));
        rig.cycle.set_motor(0, other).unwrap();
        assert_eq!((rig.position(0), rig.cycle.motor(0)), (22_500, Some(other)));
        // Its pin changes at once, so that the set-up time has passed long before the first step.
        assert_eq!(rig.log.borrow().last().unwrap().2, What::Dir(false));
        rig.cycle.set_motor(0, other).unwrap();
        rig.cycle.prepare(0, steps(5, 0), Calibration::BoundsMax).unwrap();
        rig.cycle.set_motor(0, Motor { smallest_delay: 600, ..other }).unwrap();
        let now = rig.time.now.get();
        rig.run_to(now + 1);
        rig.start();
        rig.run_out();
        assert_eq!(rig.position(0), 23_000, "{clock:?}");
        assert_eq!(rig.rises(0)[1] - rig.rises(0)[0], 600 * US, "{clock:?}");
        // The prepared program is still a calibration.
        assert_eq!(rig.cycle.motor(0).unwrap().max, Some(23_000), "{clock:?}");
        assert!(rig.edges(0).iter().all(|edge| !matches!(edge.1, What::Dir(_))));
    }
}

thread_local! {
    /// The time for a callback, which has to be `Send`.
    static TIME: std::cell::OnceCell<rig::Time> = const { std::cell::OnceCell::new() };
}

/// A callback that takes longer than a step: it makes no first step late.
#[test]
fn what_the_start_takes_counts_for_nobody() {
    let mut rig = Rig::new([Motor::new(1, 100); 2], Clock::Deadlines);
    TIME.with(|time| time.set(rig.time.clone()).unwrap_or_default());
    let mut next = |step: u32| {
        let now = TIME.with(|time| time.get().unwrap().now.clone());
        now.set(now.get() + if step == 0 { 40_000 } else { 0 });
        100
    };
    rig.cycle.prepare(0, steps(3, 0), PLAIN).unwrap();
    rig.cycle.prepare(1, Program::Dynamic { count: 3, next: &mut next }, PLAIN).unwrap();
    rig.start();
    rig.run_out();
    let wanted = [1, 2, 3].map(|n| 40_000 + n * 100 * US);
    assert_eq!((rig.rises(0), rig.rises(1)), (wanted.to_vec(), wanted.to_vec()));
    assert_eq!((rig.cycle.late(), rig.cycle.error()), (0, None));
}

/// The handler of a tick that takes longer than the tick.
#[test]
fn a_handler_that_takes_too_long() {
    use stepwright_cycle::AtTiming;
    for (timing, position, error) in [
        (AtTiming::Cancel, 5 * 7_500, Some(CycleError::TimingExceeded)),
        (AtTiming::Ignore, 20 * 7_500, None),
    ] {
        for clock in BOTH {
            let mut rig = Rig::new([M], clock);
            rig.cycle.set_strategies(Strategies { timing, ..Strategies::default() });
            rig.cycle.prepare(0, steps(20, 0), PLAIN).unwrap();
            rig.start();
            rig.until(4_500);
            // Interrupts are held off past the fifth step.
            rig.time.now.set(rig.begun + 5_700 * US);
            rig.cycle.on_compare();
            rig.run_out();
            assert_eq!(rig.cycle.error(), error, "{clock:?}");
            // On the fixed tick the missed pass is the one before the step.
            let missed = i64::from(clock == FIXED && timing == AtTiming::Cancel) * 7_500;
            assert_eq!(rig.position(0), position - missed, "{clock:?}");
            assert_eq!(rig.steps_of(0) * 7_500, position - missed);
        }
    }
}

/// Late steps and the handler's longest time are those of one cycle, not of all since the reset.
#[test]
fn a_cycle_is_not_blamed_for_the_one_before() {
    use stepwright_cycle::AtTiming;
    let mut rig = Rig::new([M], Clock::Deadlines);
    let ignore = Strategies { timing: AtTiming::Ignore, ..Strategies::default() };
    for (held, late) in [(true, 1), (false, 0)] {
        // Another late step would cancel the second cycle.
        rig.cycle.set_strategies(if held { ignore } else { Strategies::default() });
        rig.cycle.prepare(0, steps(20, 0), PLAIN).unwrap();
        rig.start();
        assert_eq!((rig.cycle.late(), rig.cycle.longest()), (0, 0));
        rig.until(4_500);
        if held {
            // Interrupts are held off past the fifth step.
            rig.time.now.set(rig.begun + 5_700 * US);
            rig.cycle.on_compare();
        }
        rig.run_out();
        assert_eq!((rig.cycle.late(), rig.cycle.error()), (late, None));
    }
}

/// A callback may take long; the time is reported.
#[test]
fn the_longest_time_is_known() {
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
    // The callback must be `Send`, so time passes through an atomic.
    static EXTRA: AtomicU64 = AtomicU64::new(0);
    static LAST: Mutex<u32> = Mutex::new(0);
    let mut next = |step: u32| {
        *LAST.lock().unwrap() = step;
        EXTRA.fetch_add(1, Relaxed);
        1_000
    };
    let mut rig = Rig::new([M], Clock::Deadlines);
    rig.cycle.prepare(0, Program::Dynamic { count: 3, next: &mut next }, PLAIN).unwrap();
    rig.start();
    rig.run_out();
    // The handler waits for a pulse of 32 ticks.
    assert_eq!(rig.cycle.longest(), 2);
    assert_eq!((EXTRA.load(Relaxed), *LAST.lock().unwrap()), (3, 2));
}

/// A step that had to wait for another motor's pulse is late by that time; the next event is not,
/// whether it is a step, a wait or a turn.
#[test]
fn a_step_that_waits_for_a_pulse_costs_the_next_ones_nothing() {
    let motor = Motor::new(1, 100);
    let step = |count| Leg::Steps { count, delay: 600 };
    let wait = Leg::Wait { count: 1, delay: 600 };
    for (legs, rest) in [
        ([step(1), wait, step(2)], [1_800, 2_400]),
        ([step(1), step(-1), step(1)], [1_200, 1_800]),
        ([step(1), step(1), step(1)], [1_200, 1_800]),
    ] {
        let mut rig = Rig::new([motor, motor], Clock::Deadlines);
        // Its pulse begins 1 µs before the first step of the other one.
        rig.cycle.prepare(0, Program::Steps { count: 1, delay: 599 }, PLAIN).unwrap();
        rig.cycle.prepare(1, Program::Series(&legs), PLAIN).unwrap();
        rig.start();
        rig.run_out();
        assert_eq!(rig.rises(0), [599 * US]);
        assert_eq!(rig.rises(1), [599 * US + PULSE, rest[0] * US, rest[1] * US]);
    }
}
