//! Drivers, switches, inputs, silence and marks, on a board of a few cells.

use crate::common::{Panel, Rig};
use stepwright::queue::Queue;
use stepwright_device::{Mark, Reset};

macro_rules! rig {
    ($rig:ident) => {
        rig!($rig, Panel::new())
    };
    ($rig:ident, $panel:expr) => {
        let mut queues = [const { Queue::new() }; 2];
        let mut $rig = Rig::new(&mut queues, $panel);
    };
}

// ----- drivers

#[test]
fn drivers_go_on_with_an_order_and_off_after_the_idle_time() {
    rig!(rig);
    assert_eq!(rig.panel.enable, Some(true), "off: the pin is high");
    rig.say("$idle-ms=5 PO G+3 E");
    assert_eq!(rig.panel.enable, Some(false));
    rig.pass(20);
    assert!(rig.moving() && rig.panel.enable == Some(false));
    rig.play_out();
    assert!(!rig.moving());
    // The millisecond in which it came to rest had already begun.
    rig.pass(5);
    assert_eq!(rig.panel.enable, Some(false));
    rig.pass(2);
    assert_eq!(rig.panel.enable, Some(true));
}

#[test]
fn drivers_stay_on_without_an_idle_time() {
    rig!(rig);
    rig.say("PO G+3 E");
    rig.play_out();
    rig.pass(3000);
    assert_eq!(rig.panel.enable, Some(false));
}

/// The first step waits until the drivers are ready: for `enable-ms` and the rest of the present
/// millisecond, or for the remainder of that if they were switched on before.
#[test]
fn the_first_step_waits_for_the_drivers() {
    rig!(rig);
    const MILLI: u64 = 16_000;
    let more = |wait: u64, millis: u64| (millis * MILLI..millis * MILLI + 8_000).contains(&wait);
    rig.say("$enable-ms=0 g+");
    let wait = rig.wait(0);
    assert!(more(wait, 0), "{wait}");
    rig.say("K $kill-off=1 K $enable-ms=20");
    // Time that passed without a poll is not part of the wait.
    rig.panel.millis += 9;
    rig.say("g+");
    let wait = rig.wait(0);
    assert!(more(wait, 21), "{wait}");
    rig.pass(15);
    rig.say("A2 g+");
    let wait = rig.wait(1);
    assert!(more(wait, 6), "{wait}");
}

/// The rest between two travels ends once its time has passed.
#[test]
fn a_rest_passes_with_the_time() {
    rig!(rig);
    rig.say("PO S5 G+1 E");
    rig.play_out();
    rig.say("PO G+1 E");
    let wait = rig.wait(0);
    assert!(wait > 19 * 16_000, "an interval of 50 steps/s: {wait}");
    rig.play_out();
    rig.pass(15);
    rig.say("PO G+1 E");
    let wait = rig.wait(0);
    assert!((5 * 16_000..8 * 16_000).contains(&wait), "{wait}");
    rig.play_out();
    rig.pass(30);
    rig.say("PO G+1 E");
    let wait = rig.wait(0);
    assert!(wait < 8_000, "{wait}");
}

/// Changing a setting counts as use, too.
#[test]
fn a_setting_begins_the_idle_time_again() {
    rig!(rig);
    rig.say("$idle-ms=10 PO G+1 E");
    rig.play_out();
    rig.pass(9);
    rig.say("$hold-us=2");
    rig.pass(9);
    assert_eq!(rig.panel.enable, Some(false));
    rig.pass(3);
    assert_eq!(rig.panel.enable, Some(true));
}

#[test]
fn the_line_knows_the_axes_that_there_are_and_the_highest_speed() {
    let mut queues = [const { Queue::new() }; 2];
    let mut rig = Rig::with_axes(1, &mut queues, Panel::new());
    assert_eq!((rig.told("axes"), rig.ask("A2")), ("1".into(), "E".into()));
    rig.say("$max-speed=123");
    assert_eq!(rig.told("max"), "123");
}

#[test]
fn another_level_switches_the_drivers_the_other_way_round() {
    rig!(rig);
    rig.say("$enable-high=1");
    assert_eq!(rig.panel.enable, Some(false));
    rig.say("g+");
    assert_eq!(rig.panel.enable, Some(true));
}

#[test]
fn settings_reach_pins_and_engine() {
    rig!(rig);
    rig.say("$pulse-us=7 $setup-us=30 $hold-us=40 $reverse=2");
    let timing = rig.device.motors_mut().engine().timing.unwrap();
    assert_eq!((timing.pulse, timing.setup, timing.hold), (112, 480, 640));
    assert_eq!(rig.panel.reverse, 2);
}

// ----- marks

#[test]
fn the_mark_tells_whether_a_motor_moves() {
    rig!(rig);
    assert_eq!(rig.panel.mark, Mark::NONE);
    rig.pass(5);
    assert_eq!(rig.panel.mark, Mark::NONE);
    rig.say("g+");
    assert_eq!(rig.panel.mark, Mark::MOVING);
    rig.pass(5);
    assert_eq!(rig.panel.mark, Mark::MOVING);
    rig.say("Z");
    rig.play_out();
    rig.pass(1);
    assert_eq!(rig.panel.mark, Mark::MOVED);
}

#[test]
fn a_reset_in_motion_leaves_the_position_unknown() {
    rig!(rig, Panel { reset: Reset::Other, mark: Mark::MOVING, ..Panel::new() });
    assert_eq!(
        (rig.ask("V1"), rig.told("stop"), rig.panel.mark),
        ("E".into(), "RR".into(), Mark::MOVED)
    );
    rig!(rig, Panel { mark: Mark::MOVED, ..Panel::new() });
    assert_eq!((rig.ask("V1"), rig.panel.mark), ("0".into(), Mark::NONE));
}

// ----- stops at once

#[test]
fn a_kill_leaves_the_drivers_as_they_are_unless_it_is_to_switch_them_off() {
    rig!(rig);
    rig.say("g+ K");
    assert_eq!((rig.panel.enable, rig.moving()), (Some(false), false));
    rig.pass(2);
    rig.say("$kill-off=1 g+");
    assert_eq!((rig.panel.enable, rig.panel.mark), (Some(false), Mark::MOVING));
    rig.say("K");
    // Off, and at rest: without the drivers the mark is not set again.
    assert_eq!((rig.panel.enable, rig.panel.mark), (Some(true), Mark::MOVED));
    rig.say("g+");
    assert_eq!(rig.panel.enable, Some(false));
}

/// A kill before anything has moved does not set a mark: the position stays known after a reset.
#[test]
fn a_kill_with_the_drivers_off_leaves_no_mark() {
    rig!(rig);
    rig.say("$kill-off=1 K");
    assert_eq!((rig.panel.enable, rig.panel.mark), (Some(true), Mark::NONE));
    rig.pass(2);
    assert_eq!(rig.panel.mark, Mark::NONE);
}

#[test]
fn an_active_input_stops_everything_and_refuses_orders() {
    for (setting, letter, low) in
        [("estop=1", "E", true), ("estop=2", "E", false), ("driver-fault=1", "D", true)]
    {
        rig!(rig, Panel { emergency: low, driver_fault: low, ..Panel::new() });
        rig.say(&format!("$kill-off=1 ${setting} g+"));
        rig.pass(3);
        assert!(rig.moving());
        (rig.panel.emergency, rig.panel.driver_fault) = (!low, !low);
        rig.plan();
        assert!(!rig.moving(), "{setting}");
        assert_eq!(rig.panel.enable, Some(true), "{setting}");
        assert_eq!(rig.told("stop"), format!("{letter}-"), "{setting}");
        assert_eq!((rig.ask("V1"), rig.ask("V2")), ("E".into(), "0".into()));
        assert_eq!((rig.ask("g+"), rig.told("last")), ("E".into(), "fault".into()));
        (rig.panel.emergency, rig.panel.driver_fault) = (low, low);
        rig.say("g+");
    }
}

// ----- switches

#[test]
fn a_closed_switch_stops_what_moves_towards_it() {
    rig!(rig);
    rig.say("$switches=1 $switch-forward=1 $debounce-ms=0 A0 g+");
    rig.pass(3);
    assert_eq!(rig.device.motors_mut().engine().moving, 0b11);
    // The switch of axis 2 is not connected; the pin of axis 1 is low when its switch is closed.
    rig.panel.switches = 0b01;
    rig.pass(1);
    assert!(rig.moving());
    rig.panel.switches = 0b00;
    rig.plan();
    assert_eq!(rig.device.motors_mut().engine().moving, 0b10);
    assert_eq!((rig.told("stop"), rig.ask("V1")), ("S-".into(), "0".into()));
    assert_eq!(rig.told("closed"), "1");
    // Not towards the switch, but away from it.
    rig.say("A1");
    assert_eq!((rig.ask("g+"), rig.told("last")), ("E".into(), "fault".into()));
    rig.say("g-");
    rig.pass(3);
    assert_eq!(rig.device.motors_mut().engine().moving, 0b11);
    // A new target may not lead there either.
    assert_eq!((rig.ask("@+5000"), rig.told("last")), ("E".into(), "fault".into()));
    rig.say("@-5000");
    // The switch of one axis does not affect another.
    rig.say("A2 @+5000");
}

/// The switch does not stop an axis that rests at it, nor does it prevent an order of no steps.
#[test]
fn a_closed_switch_says_nothing_of_what_rests() {
    rig!(rig);
    rig.say("$switches=3 $switch-forward=3");
    rig.panel.switches = 0;
    rig.pass(3);
    assert_eq!((rig.told("stop"), rig.told("errors")), ("--".into(), "-".into()));
    rig.say("PO G+0 E");
}

#[test]
fn a_switch_that_opens_counts_as_closed_for_a_while() {
    rig!(rig);
    rig.say("$switches=3 $switch-high=2 $debounce-ms=5");
    // The switch of axis 1 is closed at a low level, that of axis 2 at a high one.
    rig.panel.switches = 0b00;
    rig.pass(1);
    rig.panel.switches = 0b01;
    rig.pass(5);
    assert_eq!(rig.ask("g-"), "E");
    rig.pass(2);
    rig.say("g-");
    rig.panel.switches = 0b11;
    rig.say("A2");
    assert_eq!(rig.ask("g-"), "E");
}

// ----- silence

#[test]
fn a_silent_host_stops_what_moves() {
    rig!(rig);
    rig.say("$timeout-ms=10 PO G+100000 E");
    rig.pass(10);
    assert_eq!(rig.told("stop"), "--");
    // A line is a sign of life.
    rig.pass(10);
    assert_eq!(rig.told("stop"), "--");
    rig.pass(11);
    assert_eq!(rig.told("stop"), "T-");
    rig.play_out();
    assert!(!rig.moving());
    // A second silence counts again.
    rig.say("! g+");
    rig.pass(11);
    assert_eq!(rig.told("stop"), "T-");
    rig.play_out();
    // It brakes moving axes only.
    rig.say("!");
    rig.pass(30);
    assert_eq!(rig.told("stop"), "--");
}

#[test]
fn a_lease_ends_with_the_first_silence_of_its_length() {
    rig!(rig);
    rig.say("L10 g+");
    rig.pass(10);
    assert_eq!(rig.told("stop"), "--");
    rig.pass(11);
    assert_eq!(rig.told("stop"), "T-");
    rig.play_out();
    // The next host may not know of the lease.
    rig.say("g+");
    rig.pass(50);
    assert_eq!(rig.told("stop"), "--");
    assert!(rig.moving());
}

/// The silence before the line that requests a lease does not count for it, even if the time is
/// checked between the line and its answer.
#[test]
fn a_lease_begins_with_its_line() {
    rig!(rig);
    rig.say("g+");
    rig.pass(100);
    b"L10\r".iter().for_each(|&byte| rig.device.receive(byte, &mut rig.panel));
    while rig.device.work(&mut rig.panel) {}
    rig.panel.millis += 1;
    rig.device.poll_io(&mut rig.panel);
    while rig.device.next_byte(&mut rig.panel).is_some() {}
    assert_eq!(rig.told("stop"), "--");
    rig.pass(11);
    assert_eq!(rig.told("stop"), "T-");
}

/// A board that is working on an answer has not been left in silence.
#[test]
fn a_long_line_is_no_silence() {
    rig!(rig);
    rig.say("$timeout-ms=5 A2 g+ A1 PO j100000 G+900");
    b"E\r".iter().for_each(|&byte| rig.device.receive(byte, &mut rig.panel));
    let mut pieces = 0;
    while rig.device.work(&mut rig.panel) {
        rig.panel.millis += 3;
        rig.device.poll_io(&mut rig.panel);
        pieces += 1;
    }
    assert!(pieces > 2, "{pieces}");
    while rig.device.next_byte(&mut rig.panel).is_some() {}
    assert_eq!(rig.told("stop"), "--");
}

/// A change takes the time of several runs: the next line waits until these are planned, or for a
/// limited time. A stop does not wait.
#[test]
fn a_line_waits_until_all_is_planned_once_and_a_stop_does_not() {
    // The number of calls until a line is obeyed.
    fn obeyed(rig: &mut Rig, line: &str, plans: bool) -> u32 {
        line.bytes().for_each(|byte| rig.device.receive(byte, &mut rig.panel));
        let mut calls = 1;
        while rig.device.work(&mut rig.panel) {
            assert!(!rig.device.is_answering(), "{line}");
            calls += 1;
            while plans && rig.device.plan() {}
        }
        assert_eq!(rig.device.next_byte(&mut rig.panel), Some(b'Y'), "{line}");
        while rig.device.next_byte(&mut rig.panel).is_some() {}
        calls
    }
    rig!(rig);
    rig.say("g+");
    assert_eq!(obeyed(&mut rig, "t800\r", false), 1);
    assert_eq!(obeyed(&mut rig, "t900\r", true), 2);
    assert_eq!(obeyed(&mut rig, "t700\r", false), 25);
    assert_eq!(obeyed(&mut rig, "Z\r", false), 1);
    rig.plan();
    assert_eq!(obeyed(&mut rig, "t600\r", false), 1);
}

#[test]
fn time_wraps() {
    rig!(rig, Panel { millis: u32::MAX - 3, ..Panel::new() });
    rig.say("$timeout-ms=10 $idle-ms=5 g+");
    rig.pass(10);
    assert_eq!(rig.told("stop"), "--");
    rig.pass(11);
    assert_eq!(rig.told("stop"), "T-");
    rig.play_out();
    rig.pass(7);
    assert_eq!(rig.panel.enable, Some(true));
}

// ----- settings

#[test]
fn settings_outlast_the_power() {
    rig!(rig);
    rig.say("$idle-ms=77 $reverse=1");
    assert!(rig.device.is_saving());
    rig.pass(500);
    assert!(!rig.device.is_saving());
    let bytes = rig.panel.bytes.clone();
    rig!(rig, Panel { bytes, ..Panel::new() });
    assert_eq!((rig.ask("$idle-ms"), rig.panel.reverse), ("idle-ms=77".into(), 1));
}
