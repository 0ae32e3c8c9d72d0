//! Series that turn, in the program `cycles` with its default strategies: a late step would cancel
//! the cycle.

use crate::common::{self, board, cycles};
use stepwright_cycle::line::{CycleFault, CycleLine, CycleReport};
use stepwright_cycle::{Leg, Motor, Refusal};
use stepwright_protocol::Fault;
use stepwright_rig::Chip;

/// The cycles of a µs.
const MICRO: u64 = 16;

const fn steps(count: i32, delay: u32) -> Leg {
    Leg::Steps { count, delay }
}

/// The example of the source, with directions as signs.
const SOURCE: &[Leg] = &[steps(4, 1_000), steps(-2, 10_000), steps(4, 2_000)];

/// The time of each step of a series, in cycles after the first, and its direction.
fn planned(legs: &[Leg]) -> Vec<(u64, bool)> {
    let (mut at, mut all) = (0, Vec::new());
    for leg in legs {
        let Leg::Steps { count, delay } = *leg else { panic!("{leg:?}") };
        for _ in 0..count.unsigned_abs() {
            at += u64::from(delay) * MICRO;
            all.push((at, count > 0));
        }
    }
    let first = all[0].0;
    all.iter().map(|(time, forward)| (time - first, *forward)).collect()
}

/// Plays series, each on a motor of its own. Returns the lateness of the latest step of each, in
/// cycles.
#[track_caller]
fn play(all: &[&[Leg]], smallest: u32) -> (CycleReport, Vec<i64>) {
    let mut chip: Chip = common::program("cycles");
    let wires: Vec<_> = (0..all.len()).map(|n| cycles::wires(board(), n)).collect();
    chip.watch_pins(&wires.concat());
    for motor in 0..all.len() as u8 {
        cycles::wire(&mut chip, motor, Motor::new(7_500, smallest));
    }
    cycles::prepare(&mut chip, all);
    chip.take_watched_changes();
    cycles::say(&mut chip, CycleLine::Start(1));
    let report = cycles::rest(&mut chip, 10_000);
    let changes = chip.take_watched_changes();
    let rise = |change: &&(u64, u8, bool)| change.1.is_multiple_of(3) && change.2;
    let begun = changes.iter().find(rise).map_or(0, |change| change.0);
    let shortest = all.iter().map(|legs| delay_of(legs)).min().unwrap();
    let worst = all.iter().zip(0u8..).map(|(legs, motor)| {
        let (mut forward, mut made) = (true, Vec::new());
        for (time, which, level) in changes.iter().filter(|change| change.1 / 3 == motor) {
            match which % 3 {
                0 if *level => made.push((*time, forward)),
                1 => forward = *level,
                _ => {}
            }
        }
        let planned = planned(legs);
        assert_eq!(made.len(), planned.len(), "{report:?}");
        let ahead = (delay_of(legs) - shortest) * MICRO;
        let off = made.iter().zip(&planned).map(|(made, planned)| {
            assert_eq!(made.1, planned.1);
            (made.0 - begun) as i64 - (planned.0 + ahead) as i64
        });
        off.max().unwrap()
    });
    let worst = worst.collect();
    println!("{worst:?} cycles");
    (report, worst)
}

/// The first delay of a series, in µs.
fn delay_of(legs: &[Leg]) -> u64 {
    match legs[0] {
        Leg::Steps { delay, .. } => delay.into(),
        _ => panic!("{legs:?}"),
    }
}

#[test]
fn the_example_of_the_source_plays() {
    let (report, _) = play(&[SOURCE], 1_000);
    assert_eq!((report.error, report.late, report.motors[0].position), (None, 0, 45_000));
}

/// All at once, each during the others' steps, at delays that are long enough for that.
#[test]
fn several_motors_turn_under_the_defaults() {
    let turns = |first: i32, delay| -> Vec<_> {
        let legs = 0..7i32;
        legs.map(|n| steps(if n % 2 == 0 { first } else { -first - n.signum() }, delay)).collect()
    };
    for all in [
        [SOURCE, SOURCE, SOURCE],
        [&turns(5, 2_100), &turns(5, 2_100), &turns(5, 2_100)],
        [&turns(5, 2_100), &turns(-3, 2_210), SOURCE],
        [SOURCE, &turns(4, 2_490), &turns(2, 2_007)],
        [&turns(1, 2_100), &turns(-1, 2_101), &turns(2, 2_102)],
    ] {
        let (report, worst) = play(&all, 1_000);
        assert_eq!((report.error, report.late), (None, 0), "{worst:?}");
        assert!(worst.iter().all(|off| *off <= LATEST), "{worst:?}");
    }
}

/// A delay that leaves no time to turn is refused, and the refusal names one that does: for one to
/// three motors.
#[test]
fn turns_too_close_are_refused_with_what_would_do() {
    let legs = |delay| -> Vec<_> {
        (0..7).map(|n| steps(if n % 2 == 0 { 3 } else { -2 }, delay)).collect()
    };
    for motors in 1..=3 {
        let mut chip: Chip = common::program("cycles");
        let close = legs(300 + 75 * u32::from(motors == 3));
        for motor in 0..motors {
            cycles::wire(&mut chip, motor, Motor::new(7_500, 300));
        }
        cycles::prepare(&mut chip, &vec![&*close; motors.into()]);
        let answer = chip.ask(&CycleLine::Start(1).to_string()).unwrap();
        let fault = Fault::read(answer.as_bytes());
        let Some(Fault::Own(CycleFault::Refused(Refusal::TooFast { needs, .. }))) = fault else {
            panic!("{motors} motors: {answer}")
        };
        println!("{motors} motors: {needs} µs");
        let (report, _) = play(&vec![&*legs(needs); motors.into()], needs);
        assert_eq!((report.error, report.late), (None, 0));
    }
}

/// The largest lateness of steps beside turning ones in docs/cycles.md, in cycles.
const LATEST: i64 = 6_400;
