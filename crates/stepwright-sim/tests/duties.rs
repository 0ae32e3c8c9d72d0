//! The duties of a board besides stepping: drivers, switches, a silent host, and settings that survive a loss
//! of power.

use crate::conversation::{Board, MS, board, say, wait};
use crate::edges::{check_timing, steps_of};
use stepwright_sim::{Description, EMPTY, Edge, Eeprom, Pin, Queues, VirtualBoard};

fn last(board: &mut Board<'_>) -> String {
    let info = say(board, "?");
    info.split(' ').find_map(|word| word.strip_prefix("last=")).unwrap().to_owned()
}

fn steps(board: &mut Board<'_>, axis: u8) -> usize {
    steps_of(board.recorder(), axis).len()
}

// ---- Drivers ----

#[test]
fn the_drivers_are_on_before_the_first_step() {
    for (ms, lead) in [(0, 0), (1, 1), (250, 250)] {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        assert_eq!(say(&mut board, &format!("$enable-ms={ms}")), "Y");
        wait(&mut board, 5);
        assert!(board.enable_level(), "off at power-up: a low level enables");
        let on = board.now();
        assert_eq!(say(&mut board, "PO G+50 E"), "Y Y Y");
        assert!(!board.enable_level());
        board.run_to_rest();
        let first = steps_of(board.recorder(), 0)[0].0 - on;
        // Added to the first step: the planner's lead of 4,000 ticks, and one millisecond because the present
        // one has already begun.
        let slack = if ms == 0 { 4_400 } else { MS + 4_400 };
        assert!((lead * MS..=lead * MS + slack).contains(&first), "{ms} ms: {first} ticks");
        // At the second travel the drivers are on, once the motor has rested for a start interval.
        wait(&mut board, 23);
        let again = board.now();
        say(&mut board, "PO G-50 E");
        board.run_to_rest();
        let first = steps_of(board.recorder(), 0)[50].0 - again;
        assert!(first <= 4_400, "{ms} ms: {first} ticks");
    }
}

#[test]
fn an_axis_that_starts_during_the_delay_waits_for_the_rest_of_it() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "$enable-ms=100");
    let on = board.now();
    say(&mut board, "PO G+5 E");
    wait(&mut board, 60);
    assert_eq!(say(&mut board, "A2 PO A2 G+5 E"), "Y Y Y Y Y");
    board.run_to_rest();
    for axis in [0, 1] {
        let first = steps_of(board.recorder(), axis)[0].0 - on;
        assert!((100 * MS..=102 * MS).contains(&first), "axis {axis}: {first} ticks");
    }
}

/// The millisecond in which the drivers are switched on has already begun, and does not count.
#[test]
fn the_delay_is_never_shorter_than_it_is_set() {
    for phase in (0..MS).step_by(1_000) {
        for wait in [0, 500, 9_000, 12_345, 2 * MS, 4 * MS + 700] {
            let mut queues = Queues::default();
            let mut board = board(&mut queues);
            say(&mut board, "$enable-ms=5");
            board.run_until(20 * MS + phase);
            let on = board.now();
            say(&mut board, "PO G+5 E");
            board.run_until(on + wait);
            say(&mut board, "A2 PO A2 G+5 E");
            board.run_to_rest();
            for axis in [0, 1] {
                let first = steps_of(board.recorder(), axis)[0].0 - on;
                assert!(first >= 5 * MS, "phase {phase}, {wait}: axis {axis} after {first}");
            }
        }
    }
}

/// Nor is the rest after which the drivers are switched off shorter.
#[test]
fn the_rest_is_never_shorter_than_it_is_set() {
    for phase in (0..MS).step_by(700) {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        say(&mut board, "$idle-ms=5");
        board.run_until(20 * MS + phase);
        say(&mut board, "PO S999 T999 G+3 E");
        board.run_to_rest();
        let last = steps_of(board.recorder(), 0)[2].0;
        while !board.enable_level() {
            board.run_until(board.now() + 500);
        }
        let rest = board.now() - last;
        assert!((5 * MS..7 * MS + 1_500).contains(&rest), "phase {phase}: {rest}");
    }
}

#[test]
fn the_drivers_are_off_after_a_rest() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "$idle-ms=300 $enable-high=1");
    assert!(!board.enable_level(), "off at power-up: a high level enables now");
    say(&mut board, "PO G+2000 E");
    assert!(board.enable_level());
    wait(&mut board, 1000);
    assert!(board.is_busy() && board.enable_level(), "a travel is no rest");
    board.run_to_rest();
    wait(&mut board, 298);
    assert!(board.enable_level());
    wait(&mut board, 4);
    assert!(!board.enable_level());
    assert_eq!(say(&mut board, "V1"), "2000");
    // A travel of a few steps also switches them on for this time.
    say(&mut board, "PO S999 T999 G+1 E");
    assert!(board.enable_level());
    wait(&mut board, 290);
    assert!(board.enable_level() && !board.is_busy());
    wait(&mut board, 20);
    assert!(!board.enable_level());
}

#[test]
fn by_default_the_drivers_stay_on_after_the_first_travel() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    wait(&mut board, 100);
    assert!(board.enable_level());
    say(&mut board, "PO G+5 E");
    board.run_to_rest();
    wait(&mut board, 3_600_000 / 100);
    assert!(!board.enable_level());
}

// ---- Switches ----

/// The switch of Y is at its forward end; it is open while its pin is high.
const SWITCHED: &str = "$switches=2 $switch-forward=2";

/// The time after which a switch that has opened counts as open, in ms.
const DEBOUNCED: u64 = 27;

#[test]
fn a_switch_stops_its_axis_and_no_other() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, SWITCHED);
    assert_eq!(say(&mut board, "A0 PO A0 t4000 G+20000 E"), "Y Y Y Y Y Y");
    wait(&mut board, 1500);
    board.set_switch(1, false);
    let seen = board.now();
    wait(&mut board, 1);
    let made = steps_of(board.recorder(), 1);
    let late = made.last().unwrap().0.saturating_sub(seen);
    assert!(late <= 50 * 16, "a step {late} ticks after the switch");
    let (count, at) = (made.len(), board.position(1));
    assert_eq!(at, Some(count as i64), "the position is latched");
    assert_eq!(say(&mut board, "A2 F A1 F"), "Y R Y B");
    board.run_to_rest();
    assert_eq!((board.position(0), board.position(1)), (Some(20_000), at));
    assert_eq!(
        say(&mut board, "?").split(' ').find(|word| word.starts_with("uncertain")),
        Some("uncertain=0")
    );
}

/// The reasons why the axes have stopped, one letter each.
fn stops(board: &mut Board<'_>) -> String {
    let info = say(board, "?");
    info.split(' ').find_map(|word| word.strip_prefix("stop=")).unwrap().to_owned()
}

#[test]
fn what_stops_an_axis_is_said_until_it_sets_off_again() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "$switches=1 $timeout-ms=200 A0 T50 g+");
    wait(&mut board, 50);
    assert_eq!(stops(&mut board), "---");
    board.set_switch(0, false);
    wait(&mut board, 50);
    assert_eq!(stops(&mut board), "---", "it lies behind");
    say(&mut board, "A3 Z");
    wait(&mut board, 500);
    assert_eq!(stops(&mut board), "TTZ", "the host was silent, and it says so first");
    board.run_to_rest();
    assert_eq!(say(&mut board, "F"), "R");
    board.set_switch(0, true);
    wait(&mut board, DEBOUNCED);
    assert_eq!(say(&mut board, "A1 g-"), "Y Y");
    wait(&mut board, 50);
    assert_eq!(stops(&mut board), "-TZ");
    board.set_switch(0, false);
    wait(&mut board, 2);
    assert_eq!(say(&mut board, "F"), "R");
    assert_eq!(stops(&mut board), "STZ");
    assert_eq!(say(&mut board, "PO G-5 E"), "Y Y E", "refused: it says why still");
    assert_eq!(stops(&mut board), "STZ");
    assert_eq!(say(&mut board, "PO A2 g+ E"), "Y Y Y Y");
    wait(&mut board, 50);
    assert_eq!(say(&mut board, "K"), "Y");
    assert_eq!(stops(&mut board), "SKZ");
    assert_eq!(say(&mut board, "A3 PO A3 G+5 E"), "Y Y Y Y Y");
    board.run_to_rest();
    assert_eq!(stops(&mut board), "SK-");
    assert_eq!(say(&mut board, "!"), "Y");
    assert_eq!(stops(&mut board), "---");
}

#[test]
fn towards_a_closed_switch_nothing_moves_and_away_from_it_everything_does() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, SWITCHED);
    say(&mut board, "A2 PO A2 G+500 E");
    wait(&mut board, 100);
    board.set_switch(1, false);
    wait(&mut board, 1);
    let stopped = board.position(1).unwrap();
    assert!(stopped > 0 && !board.is_busy());
    assert_eq!(say(&mut board, "A2 g+"), "Y E");
    for order in ["A2 PO A2 G+5 E", "A2 PO A2 G+5 A1 G+5 E"] {
        assert!(say(&mut board, order).ends_with('E'));
        assert_eq!(last(&mut board), "fault");
    }
    wait(&mut board, 100);
    assert_eq!((board.position(1), steps(&mut board, 0)), (Some(stopped), 0));
    // A travel of 0 steps is allowed. The way back is free, though the switch is still closed and DIR has yet
    // to turn.
    assert_eq!(say(&mut board, "A2 PO A2 G+0 E"), "Y Y Y Y Y");
    assert_eq!(say(&mut board, "PO A2 G-20 E"), "Y Y Y Y");
    board.run_to_rest();
    assert_eq!(board.position(1), Some(stopped - 20));
    board.set_switch(1, true);
    wait(&mut board, DEBOUNCED);
    assert_eq!(say(&mut board, "A2 PO A2 G+5 E"), "Y Y Y Y Y");
    board.run_to_rest();
    assert_eq!(board.position(1), Some(stopped - 15));
}

/// During a travel too, a target towards a closed switch is refused, and a travel that turns towards a switch
/// ends where the switch closes.
#[test]
fn a_change_of_mind_obeys_the_switches() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, SWITCHED);
    board.set_switch(1, false);
    assert_eq!(say(&mut board, "A2 PO A2 G-900 E"), "Y Y Y Y Y");
    wait(&mut board, 500);
    assert_eq!(say(&mut board, "A2 @+50"), "Y E");
    assert_eq!(last(&mut board), "fault");
    assert_eq!(say(&mut board, "@-1000"), "Y");
    // While it brakes it moves away from the switch, which may close again.
    board.set_switch(1, true);
    wait(&mut board, DEBOUNCED);
    assert_eq!(say(&mut board, "@+50"), "Y");
    board.set_switch(1, false);
    let before = board.position(1).unwrap();
    board.run_to_rest();
    let rested = board.position(1).unwrap();
    assert!(before - 250 < rested && rested < before - 20, "{before} {rested}");
    let turned = steps(&mut board, 1) as i64;
    assert!(turned <= -rested + 2, "{turned} steps to {rested}");
}

#[test]
fn a_switch_may_lie_at_the_other_end_and_read_high() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    board.set_switch(0, false);
    say(&mut board, "$switches=1 $switch-high=1");
    say(&mut board, "PO G+50 E");
    board.set_switch(0, true);
    board.run_to_rest();
    assert_eq!(board.position(0), Some(50), "it lies behind");
    assert_eq!(say(&mut board, "PO G-5 E"), "Y Y E");
    board.set_switch(0, false);
    wait(&mut board, DEBOUNCED);
    assert_eq!(say(&mut board, "PO G-5 E"), "Y Y Y");
}

#[test]
fn an_axis_without_a_switch_ignores_its_pin() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    (0..3).for_each(|axis| board.set_switch(axis, false));
    say(&mut board, "A0 PO A0 G+50 E");
    board.run_to_rest();
    say(&mut board, "PO A0 G-50 E");
    board.run_to_rest();
    assert_eq!([0, 1, 2].map(|axis| steps(&mut board, axis)), [100; 3]);
}

// ---- A silent host ----

#[test]
fn a_silent_host_has_everything_brake() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "$timeout-ms=500");
    say(&mut board, "A0 T100 g+");
    for _ in 0..20 {
        wait(&mut board, 400);
        assert_eq!(say(&mut board, "F"), "B");
    }
    wait(&mut board, 499);
    // Half a line does not count.
    board.receive(b'F');
    assert!(board.is_endless());
    wait(&mut board, 30);
    assert!(!board.is_endless() && board.is_busy(), "it brakes along its ramp");
    board.run_to_rest();
    let position = board.position(0).unwrap();
    assert_eq!((position, position as usize), (steps(&mut board, 1) as i64, steps(&mut board, 0)));
    assert_eq!(say(&mut board, "F F"), "E R");
}

/// A host that speaks again is watched again: each silence is separate.
#[test]
fn a_host_may_fall_silent_more_than_once() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "$timeout-ms=300 T100");
    for round in 0..3 {
        assert_eq!(say(&mut board, "g+"), "Y", "{round}");
        wait(&mut board, 298);
        assert!(board.is_endless(), "{round}: it is not silent yet");
        wait(&mut board, 10);
        assert!(!board.is_endless(), "{round}: it runs on");
        board.run_to_rest();
    }
    // A host that speaks while the axes brake has not been silent for the next order.
    say(&mut board, "g+");
    wait(&mut board, 305);
    assert!(!board.is_endless() && board.is_busy());
    say(&mut board, "t900");
    board.run_to_rest();
    assert_eq!(say(&mut board, "F"), "R");
    say(&mut board, "g+");
    wait(&mut board, 250);
    assert!(board.is_endless());
}

#[test]
fn by_default_a_host_may_be_silent() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "g+");
    wait(&mut board, 100_000);
    assert!(board.is_endless());
}

// ---- Settings ----

#[test]
fn drivers_times_follow_their_settings_at_once() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "$pulse-us=20 $setup-us=300 $hold-us=200");
    for order in ["PO S999 T999 G+40 E", "PO G-40 E", "PO G+1 E"] {
        say(&mut board, order);
        board.run_to_rest();
    }
    // A pause is as long as the pulse.
    check_timing(board.recorder(), 20 * 16, 300 * 16, 200 * 16, 2 * 20 * 16);
    // And the cost of a step with such a pulse.
    let info = say(&mut board, "?");
    let max = info.split(' ').find_map(|word| word.strip_prefix("max=")).unwrap();
    let max: u32 = max.parse().unwrap();
    assert!((1_000..25_000).contains(&max), "{max}");
    assert_eq!(say(&mut board, &format!("PO t{max} s{max} G+10 E")), "Y Y Y Y Y");
    board.run_to_rest();
    let above = max + 1;
    assert_eq!(say(&mut board, &format!("PO t{above} s{above} G+10 E")), "Y Y Y Y E");
}

#[test]
fn an_order_that_is_refused_as_a_whole_leaves_its_axes_idle() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    // Each axis alone is slow enough; all together are not.
    say(&mut board, "PO A0 s60000 t60000 a100000000 d100000000 G+5");
    assert_eq!(say(&mut board, "E"), "E");
    assert_eq!(last(&mut board), "too-fast");
    assert_eq!(say(&mut board, "F PO A0 T100 R200 G+5 E"), "R Y Y Y Y Y Y");
    board.run_to_rest();
    assert_eq!(say(&mut board, "V1 V3"), "5 5");
}

#[test]
fn limits_are_the_settings() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "$max-speed=2000 $max-accel=3000");
    assert!(say(&mut board, "?").contains(" max=2000 "));
    assert_eq!(say(&mut board, "PO t2001 G+1 E"), "Y Y Y E");
    assert_eq!(last(&mut board), "too-fast");
    assert_eq!(say(&mut board, "PO t2000 G+1 E"), "Y Y Y E");
    assert_eq!(last(&mut board), "ramp");
    assert_eq!(say(&mut board, "PO a3000 d3000 G+1 E"), "Y Y Y Y Y");
}

#[test]
fn a_reversed_axis_has_its_pin_turned_round() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "$reverse=2");
    let turned: Vec<_> = board.recorder().iter().filter(|e| e.pin == Pin::Direction).collect();
    assert_eq!((turned.last().unwrap().axis, turned.last().unwrap().level), (1, false));
    say(&mut board, "A2 PO A2 G+5 E");
    board.run_to_rest();
    let rises = |edge: &&Edge| edge.pin == Pin::Direction && edge.axis == 1;
    assert_eq!(board.recorder().iter().rfind(rises).map(|edge| edge.level), Some(false));
    assert_eq!(board.position(1), Some(5));
    say(&mut board, "PO A2 G-5 E");
    board.run_to_rest();
    assert_eq!(board.recorder().iter().rfind(rises).map(|edge| edge.level), Some(true));
}

#[test]
fn a_pin_is_turned_round_no_sooner_than_after_the_last_step() {
    for stop in ["", "K"] {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        assert_eq!(say(&mut board, "$hold-us=1000 PO t9000 a40000 G+900 E"), "Y Y Y Y Y Y");
        match stop {
            "" => board.run_to_rest(),
            _ => wait(&mut board, 50),
        }
        say(&mut board, stop);
        let last = steps_of(board.recorder(), 0).last().unwrap().0;
        assert!(board.now() - last < 2000, "{stop}");
        assert_eq!(say(&mut board, "$reverse=1"), "Y");
        wait(&mut board, 5);
        let turned = board.recorder().iter().rfind(|edge| edge.pin == Pin::Direction).unwrap();
        assert!(!turned.level && turned.time >= last + MS, "{stop}: {turned:?}, {last}");
    }
}

#[test]
fn a_killed_curve_leaves_nothing_to_the_next_travel() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    assert_eq!(say(&mut board, "j64000000 g+"), "Y Y");
    wait(&mut board, 5);
    assert_eq!(say(&mut board, "t100000 K I1"), "Y Y Y");
    // Three steps do not nearly reach the top speed, which the board can't do for two axes.
    assert_eq!(say(&mut board, "PO G+3 A2 G-59 E"), "Y Y Y Y Y");
}

#[test]
fn nothing_is_set_while_anything_moves() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "A3 g+ A1");
    assert_eq!(say(&mut board, "$pulse-us=3"), "E");
    assert_eq!(last(&mut board), "busy");
    assert_eq!(say(&mut board, "$reset $pulse-us"), "E pulse-us=2");
}

/// The EEPROM of a board whose power was lost this many ms after its last line.
fn after(eeprom: Eeprom, lines: &str, ms: u64) -> Eeprom {
    let mut queues = Queues::default();
    let mut board: Board<'_> =
        VirtualBoard::with_eeprom(&mut queues, Description::uno(), Vec::new(), eeprom);
    say(&mut board, lines);
    wait(&mut board, ms);
    board.eeprom()
}

fn found(eeprom: Eeprom, line: &str) -> String {
    let mut queues = Queues::default();
    let mut board: Board<'_> =
        VirtualBoard::with_eeprom(&mut queues, Description::uno(), Vec::new(), eeprom);
    say(&mut board, line)
}

#[test]
fn settings_outlast_a_loss_of_power() {
    let eeprom = after(EMPTY, "$pulse-us=9 $idle-ms=3600000", 400);
    assert_eq!(found(eeprom, "$pulse-us $idle-ms"), "pulse-us=9 idle-ms=3600000");
    for ms in 0..400 {
        let pulse = found(after(eeprom, "$pulse-us=5", ms), "$pulse-us $idle-ms");
        assert!(
            ["pulse-us=9 idle-ms=3600000", "pulse-us=5 idle-ms=3600000"].contains(&pulse.as_str()),
            "{ms} ms: {pulse}"
        );
    }
    let eeprom = after(eeprom, "$reset", 400);
    assert_eq!(found(eeprom, "$pulse-us $idle-ms"), "pulse-us=2 idle-ms=0");
    assert_eq!(after(eeprom, "$pulse-us=2 $reset", 400), eeprom, "nothing changed");
}

/// Settings are written while a motor moves.
#[test]
fn a_travel_does_not_wait_for_the_eeprom() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "$pulse-us=3 PO t9000 s0 a40000 d40000 G+20000 E");
    assert!(board.is_saving() && board.is_busy());
    board.run_to_rest();
    assert!(!board.is_saving() && board.late() == 0);
    check_timing(board.recorder(), 48, 16, 16, 133);
}
