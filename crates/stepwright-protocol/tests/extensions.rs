//! The lines beyond the Nano slave's, as tables: see `talk` in `common/mod.rs`.

use crate::common::{Bench, say, talk};
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
         Z       Y  -> stop 2
         *arrive 2
         A3      Y
         Z       Y  -> stop 3
         *arrive 1
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 stop=-ZZ
         K       Y  -> kill
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=4 stop=-ZK
         g+      Y  -> start 3 50-1000 R200 R200 forward
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=4 stop=-Z-
         Z       Y  -> stop 3
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
         Z       Y  -> stop 1
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
fn a_board_says_which_switches_are_closed_now() {
    let rest = "stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0";
    talk(&format!(
        "? {rest} closed=0
         *closed 5
         ? {rest} closed=5
         *closed 255
         ? {rest} can=jerk,safety,sum closed=255",
    ));
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
         Z              Y  -> stop 1
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
fn a_slave_is_small() {
    let size = size_of::<Slave<1>>();
    let axis = size_of::<Slave<2>>() - size;
    // 4 of the bytes per axis are the start of its travel, for the soft limits.
    assert!(size <= 116 && axis <= 36, "{size} bytes, {axis} an axis");
}
