//! Braking at a switch: its distance, its speed, and that every step is counted.

use crate::rig::{HZ, Rig};
use stepwright::run::Run;
use stepwright_cycle::{
    AtHardEnd, Calibration, Clock, CycleError, End, Faults, Leg, Motor, Program, Refusal, Status,
    Strategies,
};

const BOTH: [Clock; 2] = [Clock::Tick { period: 20 }, Clock::Deadlines];
const PLAIN: Calibration = Calibration::None;

/// At most 10,000 steps/s; 500 steps to rest from there.
const M: Motor = Motor::new(3, 100).braking(100_000);

const LATER: Leg = Leg::Wait { count: 1, delay: 500_000 };

fn rig<const N: usize>(motors: [Motor; N], clock: Clock, hard_end: AtHardEnd) -> Rig<'static, N> {
    let mut rig = Rig::new(motors, clock);
    rig.cycle.set_strategies(Strategies { hard_end, ..Strategies::default() });
    rig
}

fn whirl(delay: u32) -> Program<'static> {
    Program::Whirl { forward: true, delay }
}

/// The braking distance from 10,000 steps/s is v²/2a, and the speed falls by a, as the edges show.
#[test]
fn a_motor_brakes_by_its_deceleration() {
    for (clock, others) in BOTH.into_iter().flat_map(|clock| [(clock, 3_000), (clock, 0)]) {
        let mut rig = rig([M, M], clock, AtHardEnd::BrakeMotor);
        rig.cycle.prepare(0, whirl(100), PLAIN).unwrap();
        rig.cycle.prepare(1, Program::Steps { count: others, delay: 200 }, PLAIN).unwrap();
        rig.start();
        rig.until(20_050);
        rig.close(0, 1);
        rig.cycle.look();
        let closed = rig.cycle.trigger(0, End::Max).unwrap();
        let before = closed / 3;
        assert!((199..=200).contains(&before), "{clock:?}: {before}");
        assert!(rig.cycle.is_running() && rig.cycle.status(0) == Status::Running);
        rig.run_out();
        let made = rig.steps_of(0);
        // The step in progress, and v²/2a: 10^8 / (2·10^5).
        assert!((500..=502).contains(&(made - before)), "{clock:?}: {}", made - before);
        assert_eq!(rig.position(0), made * 3);
        assert_eq!((rig.cycle.faults(0), rig.cycle.error()), (Faults::HARD_END_MAX, None));
        assert_eq!((rig.steps_of(1), rig.cycle.faults(1)), (others.into(), Faults::NONE));
        if others != 0 {
            // Its pulses meet those of the other motor: edges wait for them.
            continue;
        }
        // Mean speeds between edges, and their decrease.
        let times: Vec<f64> = rig.rises(0).iter().map(|t| *t as f64 / f64::from(HZ)).collect();
        let tick = if clock == Clock::Deadlines { 1.0 / f64::from(HZ) } else { 20e-6 };
        for three in times[before as usize..].windows(3) {
            let (a, b) = (three[1] - three[0], three[2] - three[1]);
            let fall = 2.0 * (1.0 / a - 1.0 / b) / (a + b);
            let slack = 4.0 * tick / (a * a * (a + b));
            assert!(fall <= 100_000.0 * 1.05 + slack, "{fall} at {} {clock:?}", three[0]);
            assert!(fall >= -slack, "{fall} at {} {clock:?}", three[0]);
        }
        // v = a·t: 0.1 s to rest, without the last step.
        let took = times.last().unwrap() - times[before as usize];
        assert!((0.095..=0.1005).contains(&took), "{clock:?}: {took}");
    }
}

/// Each motor brakes at its own deceleration, then the cycle is cancelled; a motor that is slow, or
/// waits, stops at once.
#[test]
fn all_motors_brake_and_the_cycle_is_cancelled() {
    for clock in BOTH {
        let motors = [M, M.braking(50_000), M.braking(2_000_000), M];
        let mut rig = rig(motors, clock, AtHardEnd::BrakeAll);
        rig.cycle.prepare(0, whirl(100), PLAIN).unwrap();
        let back = Program::Whirl { forward: false, delay: 200 };
        rig.cycle.prepare(1, back, PLAIN).unwrap();
        rig.cycle.prepare(2, whirl(1_000), PLAIN).unwrap();
        rig.cycle.prepare(3, Program::Series(&[LATER]), PLAIN).unwrap();
        rig.start();
        rig.until(20_050);
        rig.close(0, 1);
        rig.cycle.look();
        let at = [0, 1, 2].map(|motor| rig.position(motor) / 3);
        assert_eq!(rig.cycle.error(), None);
        rig.run_out();
        assert_eq!(rig.cycle.error(), Some(CycleError::MotorError { motor: 0 }));
        let made = [0, 1, 2].map(|motor| rig.steps_of(motor) - at[usize::from(motor)]);
        // 10^8/2·10^5; (5·10^3)²/10^5; 10^6 is less than 4·10^6.
        assert!((499..=502).contains(&made[0]), "{clock:?}: {made:?}");
        assert!((-252..=-249).contains(&made[1]), "{clock:?}: {made:?}");
        assert_eq!((made[2], rig.steps_of(3)), (0, 0), "{clock:?}");
        for motor in 0..4 {
            assert_eq!(rig.position(motor), rig.steps_of(motor) * 3);
            assert_eq!(rig.cycle.status(motor), Status::Finished);
        }
        let faults = [1, 2, 3].map(|motor| rig.cycle.faults(motor));
        assert_eq!(faults, [Faults::NONE; 3]);
    }
}

/// Nothing is left to brake: at rest before a closed switch, at the end of the program, where the
/// program turns or waits.
#[test]
fn a_program_that_ends_is_not_led_on() {
    let step = |count| Leg::Steps { count, delay: 100 };
    let wait = Leg::Wait { count: 1, delay: 100 };
    for clock in BOTH {
        let mut rig = rig([M], clock, AtHardEnd::BrakeMotor);
        rig.close(0, 1);
        rig.cycle.prepare(0, whirl(100), PLAIN).unwrap();
        rig.start();
        rig.run_out();
        assert_eq!((rig.steps_of(0), rig.cycle.faults(0)), (0, Faults::HARD_END_MAX));
        for legs in [vec![step(230)], vec![step(230), step(-50)], vec![step(230), wait, step(9)]] {
            let legs = legs.leak();
            rig.close(0, 0);
            let before = rig.steps_of(0);
            rig.cycle.prepare(0, Program::Series(legs), PLAIN).unwrap();
            rig.start();
            rig.until(20_050);
            rig.close(0, 1);
            rig.run_out();
            assert_eq!(rig.steps_of(0) - before, 230, "{clock:?}: {legs:?}");
            assert_eq!(rig.position(0), rig.steps_of(0) * 3);
            assert_eq!(rig.cycle.faults(0), Faults::HARD_END_MAX);
        }
    }
}

/// Delays of a callback that are already longer are kept.
#[test]
fn a_program_that_slows_down_by_itself_does_so() {
    for clock in BOTH {
        let mut next = |step: u32| 100 + 40 * step.saturating_sub(200);
        let mut rig = Rig::new([M], clock);
        let strategies = Strategies { hard_end: AtHardEnd::BrakeMotor, ..Strategies::default() };
        rig.cycle.set_strategies(strategies);
        let program = Program::Dynamic { count: 300, next: &mut next };
        rig.cycle.prepare(0, program, PLAIN).unwrap();
        rig.start();
        rig.until(20_150);
        rig.close(0, 1);
        rig.run_out();
        // Its own v² falls by more than 2a a step up to 737 µs, 16 steps further; from there
        // 1.84·10^6 / 2·10^5 are 9 steps.
        let made = rig.steps_of(0);
        assert!((223..=229).contains(&made), "{clock:?}: {made}");
        assert_eq!(rig.position(0), made * 3);
    }
}

#[test]
fn who_is_to_brake_needs_a_deceleration() {
    let mut rig = rig([M, M.braking(0)], Clock::Deadlines, AtHardEnd::BrakeMotor);
    rig.cycle.prepare(0, whirl(100), PLAIN).unwrap();
    rig.cycle.prepare(1, whirl(100), PLAIN).unwrap();
    let refusal = Refusal::NeedsDecel { motor: 1 };
    assert_eq!(rig.cycle.start(), Err(refusal));
    let said = refusal.named("Y").to_string();
    assert!(said.starts_with("Y is to brake at its switch and has no deceleration"), "{said}");
    rig.run_to(1_000_000);
    assert_eq!((rig.steps_of(0), rig.steps_of(1)), (0, 0));
}

/// A planned run whose intervals grow is braked like even steps: the part that was handed out and
/// not made is counted, so the distance is the same.
#[test]
fn a_planned_run_brakes_like_even_steps() {
    // Some 10,000 steps/s: the interval grows by a tenth of a tick per step.
    let run = Run::new((u64::from(HZ) / 10_000) << 16, 6_554, 2_000);
    let mut rig = rig([M], Clock::Deadlines, AtHardEnd::BrakeMotor);
    let leg: &'static [Leg] = Box::leak(Box::new([Leg::Run { run, forward: true }]));
    rig.cycle.prepare(0, Program::Series(leg), PLAIN).unwrap();
    rig.start();
    rig.until(20_050);
    rig.close(0, 1);
    rig.cycle.look();
    let before = rig.cycle.trigger(0, End::Max).unwrap() / 3;
    rig.run_out();
    let made = rig.steps_of(0);
    assert!((190..=200).contains(&before), "{before}");
    // A little slower than 10,000 steps/s there: v²/2a is a little less than 500.
    assert!((480..=500).contains(&(made - before)), "{}", made - before);
    assert_eq!(rig.position(0), made * 3);
}
