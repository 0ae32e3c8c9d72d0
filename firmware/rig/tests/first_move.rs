//! The README's first example on the chip: a motor reaches its position while the main loop does
//! other work.

use stepwright::{Accel, Axis, AxisLimits, Speed};
use stepwright_rig::board::{Board, HZ};
use stepwright_rig::edges::{Needs, Step, check, steps_of};
use stepwright_rig::{Chip, firmware};
use stepwright_sim::{Description, Edge, Queues, virtual_steppers};

use crate::common::board;

/// The edges of the same calls on the virtual board.
fn ideal() -> Vec<Edge> {
    let mut queues = Queues::default();
    let mut motors = virtual_steppers(&mut queues, Description::uno(), Vec::new());
    let speed = Speed::from_steps(4_000).unwrap();
    let limits = AxisLimits::new(speed, Accel::from_steps(10_000).unwrap());
    motors.set_limits(Axis::X, limits);
    motors.move_to(Axis::X, 8_000).unwrap();
    while motors.is_moving(Axis::X) {
        motors.poll();
        motors.engine().pass(1_000);
    }
    std::mem::take(motors.engine().recorder())
}

#[test]
fn a_motor_reaches_its_position_while_the_main_loop_works() {
    reaches_its_position("first-move");
}

/// The same program, which depends on `stepwright-avr` from another folder.
#[test]
fn a_firmware_outside_the_repository_moves_its_motor() {
    if board() != Board::Uno {
        return;
    }
    reaches_its_position("outside");
}

#[track_caller]
fn reaches_its_position(program: &str) {
    let image = firmware::load(&format!("{}-{program}", board().name()))
        .unwrap_or_else(|error| panic!("{error:#}"));
    let mut chip = Chip::new(board(), &image);
    chip.run_for(HZ);
    let on_the_way = steps_of(chip.edges(), 0).len();
    assert!((2_000..4_000).contains(&on_the_way), "{on_the_way} steps after 1 s");
    assert!(chip.run_to_silence(HZ / 2, 4 * HZ), "it does not come to rest");

    assert_eq!(check(chip.edges(), Needs::DEFAULT), Ok(()));
    let (real, ideal) = (steps_of(chip.edges(), 0), ideal());
    let ideal = steps_of(&ideal, 0);
    assert_eq!(real.last().map(|step| step.position), Some(8_000));
    assert!(steps_of(chip.edges(), 1).is_empty() && steps_of(chip.edges(), 2).is_empty());
    // From the first step on they are the virtual board's, except for the interrupt's entry and for
    // joined runs, within two ticks a step.
    assert_eq!(real.len(), ideal.len());
    let off = |(real_step, ideal_step): (&Step, &Step)| {
        (real_step.time - real[0].time).abs_diff(ideal_step.time - ideal[0].time)
    };
    let worst: u64 = real.iter().zip(&ideal).map(off).max().unwrap_or(0);
    assert!(worst <= 100, "{worst} cycles off the virtual board");

    // The main loop has toggled the lamp all the time, and its program ends then.
    let span = real[0].time..real[real.len() - 1].time;
    let toggled: Vec<u64> = chip.led_changes().iter().map(|(time, _)| *time).collect();
    let (within, gap) = (
        toggled.iter().filter(|time| span.contains(*time)).count(),
        toggled.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0),
    );
    assert!(within > 20_000, "{within} rounds of the main loop");
    assert!(gap < HZ / 1_000, "the main loop waits for {gap} cycles");
    assert!(toggled.iter().all(|time| *time < span.end + HZ / 1_000));
    // The drivers are on at the first step, and stay on.
    let levels = chip.enable_changes();
    let at_first = levels.iter().rev().find(|(time, _)| *time < real[0].time);
    assert_eq!(at_first.map(|(_, high)| *high), Some(false), "{levels:?}");
    assert!(levels.iter().all(|(time, _)| *time < real[0].time));
}
