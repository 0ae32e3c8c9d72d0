//! The Nano slave's master on a second board: two chips on one cable.

use crate::common::{board, chip, say};
use stepwright_rig::edges::{Needs, check, position_of, steps_of};
use stepwright_rig::{Chip, Pair, firmware};

fn master() -> Chip {
    let image = firmware::load(&format!("{}-master", board()));
    Chip::new(board(), &image.unwrap_or_else(|error| panic!("{error:#}")))
}

const SECOND: u64 = 16_000_000;

#[test]
fn the_master_has_the_slave_travel() {
    let mut pair = Pair::new(master(), chip());
    // There: 4000 steps take 4.4 s. And back, twice as far: 8.4 s.
    pair.run_for(6 * SECOND);
    let turned = steps_of(pair.slave.edges(), 0);
    let furthest = turned.iter().map(|step| step.position).max();
    assert_eq!(furthest, Some(4000), "{}", String::from_utf8_lossy(&pair.orders));
    pair.run_for(8 * SECOND);
    let steps = steps_of(pair.slave.edges(), 0);
    assert_eq!(steps.iter().map(|step| step.position).min(), Some(-4000));
    check(pair.slave.edges(), Needs::DEFAULT).unwrap();
    // The lines are those of the Nano slave, and all orders are accepted.
    let orders = String::from_utf8_lossy(&pair.orders).into_owned();
    assert!(orders.contains("PO\rS5\rT100\rR200\rG+4000\rE\r"), "{orders}");
    let answers = String::from_utf8_lossy(&pair.answers).into_owned();
    assert!(answers.contains("Y\rY\rY\rY\rY\rY\rB\r"), "{answers}");
    assert_eq!(pair.master.lost() + pair.slave.lost(), 0);
    // Back to 0, and the same once more; then the lamp stays on.
    assert!(pair.master.led_changes().is_empty());
    pair.run_for(23 * SECOND);
    let lamp: Vec<_> = pair.master.led_changes().iter().map(|change| change.1).collect();
    assert_eq!((lamp, position_of(pair.slave.edges(), 0)), (vec![true], 0));
}

#[test]
fn a_slave_that_loses_its_power_is_noticed_and_the_way_made_up() {
    let mut pair = Pair::new(master(), chip());
    pair.run_for(2 * SECOND);
    let before = position_of(pair.slave.edges(), 0);
    assert!(before > 500, "{before}");
    pair.slave.power_loss(0xFF);
    pair.run_for(4 * SECOND);
    // It begins at 0 again: the master sees that it is not where it should be.
    assert!(position_of(pair.slave.edges(), 0) > before);
}

#[test]
fn a_slave_that_refuses_is_told_by_a_fast_lamp() {
    let mut slave = chip();
    say(&mut slave, "$max-speed=100");
    let mut pair = Pair::new(master(), slave);
    pair.run_for(4 * SECOND);
    assert!(position_of(pair.slave.edges(), 0) == 0);
    let late = pair.master.led_changes().iter().filter(|change| change.0 > 2 * SECOND);
    let blinks = late.count();
    // Five times a second: on and off.
    assert!((17..=23).contains(&blinks), "{blinks} changes in 2 s");
}

#[test]
fn a_master_without_a_slave_says_so_with_its_lamp() {
    let mut master = master();
    master.run_for(8 * SECOND);
    let late = master.led_changes().iter().filter(|change| change.0 > 4 * SECOND);
    let blinks = late.count();
    // Once a second: on and off.
    assert!((6..=10).contains(&blinks), "{blinks} changes in 4 s");
}
