//! What goes beyond the Nano slave's lines, as tables: see `talk` in `common/mod.rs`.

mod common;

use common::{Bench, say, talk};
use stepwright_protocol::Slave;

// ---- Faster boards ----

#[test]
fn speeds_and_accelerations_beyond_the_document() {
    talk(
        "s0        Y
         t1000000  Y
         a100000000 Y
         g+        Y  -> start 1 0-1000000 100000000/s2 R200 forward
         K         Y  -> kill
         d1        Y
         g+        Y  -> start 1 0-1000000 100000000/s2 1/s2 forward
         K         Y  -> kill
         R9        Y
         g+        Y  -> start 1 0-1000000 R9 R9 forward
         K         Y  -> kill
         d7        Y
         T3        Y
         S2        Y
         g+        Y  -> start 1 20-30 R9 7/s2 forward
         K         Y  -> kill
         t0        E
         s1000001  E
         a0        E
         d100000001 E",
    );
}

// ---- More axes ----

#[test]
fn several_axes_start_together() {
    talk(
        "PO      Y
         T10     Y
         G+5     Y
         A3      Y
         T30     Y
         G-6     Y
         E       Y  -> start 1 50-100 R200 R200 +5; start 3 50-300 R200 R200 -6
         F       B
         A1      Y
         F       B
         A2      Y
         F       R
         A0      Y
         F       B
         *arrive 1
         F       B
         *arrive 3
         F       R
         V1      5
         V2      0
         V3      -6",
    );
}

#[test]
fn all_or_nothing() {
    talk(
        "PO      Y
         G+5     Y
         A2      Y
         G+6     Y
         *refuse ramp
         E       E
         A0      Y
         F       R",
    );
}

#[test]
fn an_axis_starts_while_another_runs() {
    talk(
        "g+      Y  -> start 1 50-1000 R200 R200 forward
         PO      E
         A2      Y
         PO      Y
         A2      Y
         T20     Y
         G+7     Y
         E       Y  -> start 2 50-200 R200 R200 +7
         F       B
         *arrive 2
         F       R
         A1      Y
         F       B
         Z       Y  -> brake 1",
    );
}

#[test]
fn a_busy_axis_in_an_order_spoils_it() {
    talk(
        "g+      Y  -> start 1 50-1000 R200 R200 forward
         A2      Y
         PO      Y
         A1      Y
         T20     E
         A2      Y
         G+7     Y
         E       E",
    );
}

#[test]
fn a0_addresses_all_axes() {
    talk(
        "A0      Y
         T20     Y
         g-      Y  -> start 1 50-200 R200 R200 backward; start 2 50-200 R200 R200 backward; start 3 50-200 R200 R200 backward
         PO      E
         T30     E
         g+      E
         Z       Y  -> brake 1; brake 2; brake 3
         *arrive 2
         Z       Y  -> brake 1; brake 3
         I2      Y  -> zero 2
         I1      E
         K       Y  -> kill
         V1      E
         V2      0
         V3      E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=6 last=uncertain uncertain=5
         PO      Y
         A0      Y
         G+1     Y
         A2      Y
         G+2     Y
         T1      Y
         E       Y  -> start 1 50-200 R200 R200 +1; start 2 50-10 R200 R200 +2; start 3 50-200 R200 R200 +1",
    );
}

/// A master that says A2 before PO means axis 2, and one that knows no A, on a line
/// where another has said it, means axis 1: neither motor may move.
#[test]
fn an_order_whose_axis_is_not_clear_moves_nothing() {
    talk(
        "A2      Y
         PO      Y
         S5      E
         T100    E
         R200    E
         G+40    E
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=5 last=no-axis uncertain=0
         A2      Y
         PO      Y
         A2      Y
         G+40    Y
         E       Y  -> start 2 50-1000 R200 R200 +40
         A1      Y
         PO      Y
         G+41    Y
         E       Y  -> start 1 50-1000 R200 R200 +41",
    );
    for line in ["S1", "T1", "R1", "s1", "t1", "a1", "d1", "j1", "j0", "G-1", "g+", "@+1"] {
        for axis in ["A0", "A3"] {
            talk(&format!(
                "{axis} Y\nPO Y\n{line} E\nA1 Y\nG+1 Y\nE E\nPO Y\nG+1 Y\nE Y -> start 1 50-1000 R200 R200 +1"
            ));
        }
    }
}

/// A master that knows no A is refused at most one order, and none after a whole one
/// of another master.
#[test]
fn a_master_without_a_goes_on_after_one_with_it() {
    talk(
        "PO      Y
         A2      Y
         G+1     Y
         E       Y  -> start 2 50-1000 R200 R200 +1
         *arrive 2
         PO      Y
         G+2     Y
         E       Y  -> start 1 50-1000 R200 R200 +2
         *arrive 1
         A2      Y
         g+      Y  -> start 2 50-1000 R200 R200 forward
         Z       Y  -> brake 2
         *arrive 2
         PO      Y
         G+3     E
         E       E
         PO      Y
         G+4     Y
         E       Y  -> start 1 50-1000 R200 R200 +4",
    );
}

/// A stop may go to either of the axes that may be meant, so it goes to both.
#[test]
fn a_stop_reaches_the_axes_of_a_and_of_po() {
    talk(
        "A0      Y
         g+      Y  -> start 1 50-1000 R200 R200 forward; start 2 50-1000 R200 R200 forward; start 3 50-1000 R200 R200 forward
         *arrive 2
         A2      Y
         PO      Y
         F       B
         Z       Y  -> brake 1
         *arrive 1
         F       R
         A2      Y
         g+      Y
         A1      Y
         F       R",
    );
}

#[test]
fn a_selection_stays_until_the_next_one() {
    talk(
        "PO      Y
         G+1     Y
         A2      Y
         E       Y  -> start 1 50-1000 R200 R200 +1
         F       R
         PO      Y
         A3      Y
         T5      Y
         G+2     Y
         E       Y  -> start 3 50-50 R200 R200 +2
         F       B",
    );
}

// ---- Stops ----

#[test]
fn a_stop_has_its_reason_until_the_next_start() {
    talk(
        "?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 stop=---
         A0      Y
         Z       Y
         K       Y  -> kill
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 stop=---
         g+      Y  -> start 1 50-1000 R200 R200 forward; start 2 50-1000 R200 R200 forward; start 3 50-1000 R200 R200 forward
         A2      Y
         Z       Y  -> brake 2
         *arrive 2
         A3      Y
         Z       Y  -> brake 3
         *arrive 1
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 stop=-ZZ
         K       Y  -> kill
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=4 stop=-ZK
         g+      Y  -> start 3 50-1000 R200 R200 forward
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=4 stop=-Z-
         Z       Y  -> brake 3
         @+7     Y  -> change 3: @+7
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=4 stop=-Z-
         !       Y  -> clear
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=4 stop=---",
    );
}

#[test]
fn the_machine_tells_its_own_stops() {
    talk(
        "g+      Y  -> start 1 50-1000 R200 R200 forward
         *silent 1
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 stop=T--
         Z       Y  -> brake 1
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 stop=T--
         *switch 1
         *arrive 1
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 stop=S--
         PO      Y
         G+5     Y
         *refuse fault
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=fault uncertain=0 stop=S--
         PO      Y
         G+5     Y
         E       Y  -> start 1 50-1000 R200 R200 +5
         *arrive 1
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=fault uncertain=0 stop=---",
    );
}

#[test]
fn an_axis_that_is_not_there() {
    talk(
        "A4      E
         V4      E
         I4      E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=3 last=axis uncertain=0
         A9      E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=4 last=range uncertain=0
         g+      Y  -> start 1 50-1000 R200 R200 forward",
    );
}

// ---- On the way ----

#[test]
fn a_travel_in_progress_gets_another_target() {
    talk(
        "@+5     E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=no-travel uncertain=0
         PO      Y
         G+400   Y
         @+5     E
         E       E
         PO      Y
         G+400   Y
         E       Y  -> start 1 50-1000 R200 R200 +400
         @+300   Y  -> change 1: @+300
         @-0     Y  -> change 1: @+0
         *refuse too-fast
         @+9     E
         A2      Y
         @+9     E
         A1      Y
         Z       Y  -> brake 1
         @-7     Y  -> change 1: @-7
         *arrive 1
         V1      -7
         @+1     E",
    );
}

#[test]
fn speed_and_ramps_change_on_the_way_and_for_later() {
    talk(
        "g+      Y  -> start 1 50-1000 R200 R200 forward
         t500    Y  -> change 1: t500
         a900    Y  -> change 1: a900
         d800    Y  -> change 1: d800
         *refuse too-fast
         t70000  E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=too-fast uncertain=0
         S5      E
         T70     E
         R9      E
         s0      E
         t0      E
         *arrive 1
         g-      Y  -> start 1 50-500 900/s2 800/s2 backward",
    );
}

#[test]
fn a_change_is_for_all_that_are_selected_or_for_none() {
    talk(
        "A0      Y
         g+      Y  -> start 1 50-1000 R200 R200 forward; start 2 50-1000 R200 R200 forward; start 3 50-1000 R200 R200 forward
         t300    Y  -> change 1 2 3: t300
         @+70    Y  -> change 1 2 3: @+70
         *arrive 2
         @+80    E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=no-travel uncertain=0
         *refuse ramp
         t310    E
         t320    Y  -> change 1 3: t320
         A2      Y
         g+      Y  -> start 2 50-320 R200 R200 forward
         t999999 Y  -> change 2: t999999",
    );
}

/// Its lines speak of axes at rest: one that goes astray must not touch a motor.
#[test]
fn an_open_order_changes_nothing_on_the_way_but_by_name() {
    talk(
        "g+      Y  -> start 1 50-1000 R200 R200 forward
         A2      Y
         PO      Y
         A1      Y
         t20     E
         E       E
         @+5000  Y  -> change 1: @+5000",
    );
}

#[test]
fn settings_limit_a_travel_in_progress_too() {
    talk(
        "$max-speed=2000 Y  -> max-speed=2000
         $max-accel=9000 Y  -> max-accel=9000
         a9000   Y
         d9000   Y
         g+      Y  -> start 1 50-1000 9000/s2 9000/s2 forward
         t2001   E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=too-fast uncertain=0
         t2000   Y  -> change 1: t2000
         a9001   E
         d9001   E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=3 last=ramp uncertain=0
         d8000   Y  -> change 1: d8000",
    );
}

// ---- Health ----

#[test]
fn a_question_clears_nothing_and_a_bang_does() {
    talk(
        "*late   7
         x       E
         g+      Y  -> start 1 50-1000 R200 R200 forward
         K       Y  -> kill
         ?       stepwright 0.1 axes=3 max=120000 late=7 refused=1 last=line uncertain=1
         ?       stepwright 0.1 axes=3 max=120000 late=7 refused=1 last=line uncertain=1
         !       Y  -> clear
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=1",
    );
}

#[test]
fn a_board_says_what_it_can_do() {
    talk(
        "? stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 can=jerk,safety,sum",
    );
}

#[test]
fn an_empty_line_is_answered_but_no_news() {
    talk(
        "\"\"    E
         \"\"    E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0",
    );
}

// ---- Jerk ----

#[test]
fn a_jerk_bends_the_ramps_of_its_order() {
    talk(
        "j400000        Y
         g+             Y  -> start 1 50-1000 R200 R200 400000/s3 forward
         j1             E
         Z              Y  -> brake 1
         *arrive 1
         PO             Y
         G+5            Y
         E              Y  -> start 1 50-1000 R200 R200 +5
         *arrive 1
         j4000000001    E
         j4000000000    Y
         $law=0         Y  -> law=0
         g-             E
         ?              stepwright 0.1 axes=3 max=120000 late=0 refused=3 last=no-jerk uncertain=0
         j0             Y
         g-             Y  -> start 1 50-1000 R200 R200 backward",
    );
}

// ---- Lease ----

#[test]
fn a_lease_is_granted_at_any_time_and_disturbs_no_order() {
    talk(
        "L500    Y  -> lease 500
         PO      Y
         L60000  Y  -> lease 60000
         G+5     Y
         E       Y  -> start 1 50-1000 R200 R200 +5
         L0      Y  -> lease 0
         L60001  E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=range uncertain=0
         L       E
         L-1     E
         l5      E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=4 last=line uncertain=0",
    );
}

// ---- Emergency stop ----

#[test]
fn an_emergency_stop_spoils_the_order_that_is_open() {
    talk(
        "PO      Y
         G+5     Y
         *emergency 0
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=fault uncertain=0 stop=---
         PO      Y
         g+      Y
         E       Y  -> start 1 50-1000 R200 R200 forward
         *emergency 1
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=fault uncertain=0 stop=E--
         *arrive 1
         PO      Y
         G+5     Y
         *switch 2
         E       Y  -> start 1 50-1000 R200 R200 +5",
    );
}

// ---- Settings ----

#[test]
fn settings_are_asked_and_set() {
    talk(
        "$pulse-us     pulse-us=2
         $pulse-us=15  Y  -> pulse-us=15
         $pulse-us=15  Y
         $pulse-us     pulse-us=15
         $idle-ms=0060000 Y -> idle-ms=60000
         $             max-speed=1000000 max-accel=100000000 idle-ms=60000 ahead-x=0 ahead-y=0 ahead-z=0 behind-x=0 behind-y=0 behind-z=0 timeout-ms=0 enable-ms=1 setup-us=1 hold-us=1 pulse-us=15 reverse=0 enable-high=0 switches=0 switch-forward=0 switch-high=0 debounce-ms=25 law=1 safe-start=0 home-first=0 estop=0 driver-fault=0 kill-off=0 soft-limits=0
         $reset        Y  -> idle-ms=0; pulse-us=2
         $reset        Y
         $idle-ms      idle-ms=0",
    );
}

#[test]
fn a_setting_is_refused_with_its_reason() {
    talk(
        "$pulse-us=21  E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=range uncertain=0
         $pulse=2      E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=2 last=setting uncertain=0
         $pulse-us=    E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=3 last=line uncertain=0
         A2      Y
         g+      Y  -> start 2 50-1000 R200 R200 forward
         A1      Y
         $pulse-us=3   E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=4 last=busy uncertain=0
         $reset        E
         $pulse-us     pulse-us=2
         *arrive 2
         $pulse-us=3   Y  -> pulse-us=3",
    );
}

/// As any other line: one that is refused spoils an order, one that is not
/// does not.
#[test]
fn settings_may_stand_inside_an_order() {
    talk(
        "PO      Y
         G+5     Y
         $hold-us=2    Y  -> hold-us=2
         $hold-us      hold-us=2
         E       Y  -> start 1 50-1000 R200 R200 +5
         *arrive 1
         PO      Y
         G+5     Y
         $hold-us=-1   E
         E       E",
    );
}

// ---- The line itself ----

#[test]
fn lf_around_a_line_is_nothing_and_long_lines_end_at_their_cr() {
    talk(
        "\\nPO\\n Y
         \\n\\nG+5\\n\\n Y
         G+\\n5  E
         \\nPO   Y
         G+00000000000000000000006 E
         \\nPO   Y
         G+0000000000000000000006   Y
         E\\n    Y  -> start 1 50-1000 R200 R200 +6",
    );
}

#[test]
fn a_lost_byte_makes_its_line_a_bad_one() {
    let (mut slave, mut bench) = (Slave::<1>::new(), Bench::new(1));
    assert_eq!(say(&mut slave, &mut bench, b"PO"), "Y");
    for byte in b"G+4" {
        slave.push(*byte, &mut bench);
    }
    slave.garbled();
    assert_eq!(say(&mut slave, &mut bench, b"00"), "E");
    assert_eq!(say(&mut slave, &mut bench, b"E"), "E");
    assert!(bench.asked.is_empty());
}

#[test]
fn a_slave_has_room_for_fewer_axes_than_the_machine_has() {
    let (mut slave, mut bench) = (Slave::<2>::new(), Bench::new(3));
    assert_eq!(say(&mut slave, &mut bench, b"A3"), "E");
    assert_eq!(say(&mut slave, &mut bench, b"A0"), "Y");
    assert_eq!(say(&mut slave, &mut bench, b"g+"), "Y");
    assert_eq!(bench.asked[0].len(), 2);
    // Nor are there positions of others to be uncertain of, or stops.
    for axis in &mut bench.axes {
        axis.uncertain = true;
    }
    let info = say(&mut slave, &mut bench, b"?");
    assert!(info.contains(" axes=2 ") && info.contains(" uncertain=3 stop=-- "), "{info}");
}

#[test]
fn a_slave_may_have_room_for_more_axes_than_the_machine_has() {
    let (mut slave, mut bench) = (Slave::<3>::new(), Bench::new(2));
    assert_eq!(say(&mut slave, &mut bench, b"A3"), "E");
    assert_eq!(say(&mut slave, &mut bench, b"A0"), "Y");
    assert_eq!(say(&mut slave, &mut bench, b"g+"), "Y");
    assert_eq!(bench.asked[0].len(), 2);
    let info = say(&mut slave, &mut bench, b"?");
    assert!(info.contains(" axes=2 ") && info.contains(" stop=-- "), "{info}");
}

#[test]
fn a_slave_is_small() {
    let size = size_of::<Slave<1>>();
    let axis = size_of::<Slave<2>>() - size;
    // Of these, 8 bytes an axis are where its travel began, for the soft limits.
    assert!(size <= 120 && axis <= 40, "{size} bytes, {axis} an axis");
}
