//! Effects of lines through the device: late steps, positions, refused orders.

use crate::common::{Panel, Rig};
use stepwright::Axis;
use stepwright::queue::Queue;

#[test]
fn late_steps_are_told_until_they_are_forgotten() {
    let mut queues = [const { Queue::new() }; 2];
    let mut rig = Rig::new(&mut queues, Panel::new());
    rig.device.motors_mut().engine().late = 3;
    assert_eq!(rig.told("late"), "3");
    rig.say("!");
    assert_eq!(rig.told("late"), "0");
}

#[test]
fn a_position_is_known_again_once_it_is_said() {
    let mut queues = [const { Queue::new() }; 2];
    let mut rig = Rig::new(&mut queues, Panel::new());
    rig.say("g+ K");
    assert_eq!(rig.ask("V1"), "E");
    rig.say("I1");
    assert_eq!(rig.ask("V1"), "0");
}

/// An order starts as a whole or not at all, and leaves nothing behind for the next order.
#[test]
fn of_a_refused_order_nothing_is_left() {
    let mut queues = [const { Queue::new() }; 2];
    let mut rig = Rig::new(&mut queues, Panel::new());
    // Two axes reach only 5,000 steps/s each.
    rig.say("PO A0 s50 t6000 a9000 d9000 G+90000");
    assert_eq!((rig.ask("E"), rig.told("last")), ("E".into(), "too-fast".into()));
    assert!(!rig.moving());
    rig.say("PO A2 t1000 G+3 E");
    assert_eq!(rig.device.motors_mut().engine().moving, 0b10);
}

#[test]
fn a_line_of_which_a_byte_was_lost_is_refused() {
    let mut queues = [const { Queue::new() }; 2];
    let mut rig = Rig::new(&mut queues, Panel::new());
    rig.say("PO");
    b"G+".iter().for_each(|&byte| rig.device.receive(byte, &mut rig.panel));
    rig.device.garbled();
    assert_eq!(rig.ask("4"), "E");
    assert!(rig.told("errors").contains('g'));
}

/// A target for both axes turns axis 1 back and lets axis 2 go on, away from the closed switch
/// behind it.
#[test]
fn each_axis_is_judged_by_its_own_way_to_a_target() {
    let mut queues = [const { Queue::new() }; 2];
    let mut rig = Rig::new(&mut queues, Panel::new());
    rig.say("$switches=2 $debounce-ms=0 g+");
    rig.panel.switches = 0b01;
    while rig.device.motors().is_ahead(Axis::X, 100) {
        rig.plan();
        rig.device.motors_mut().engine().play();
    }
    rig.say("A2 g+ A0 @+100");
}

#[test]
fn a_switch_that_is_disconnected_holds_nothing() {
    let mut queues = [const { Queue::new() }; 2];
    let mut rig = Rig::new(&mut queues, Panel::new());
    rig.say("$switches=1 $switch-forward=1 $debounce-ms=25");
    rig.panel.switches = 0;
    rig.pass(1);
    rig.panel.switches = 0xFF;
    rig.pass(1);
    assert_eq!(rig.ask("g+"), "E");
    rig.say("$switches=0 g+");
}
