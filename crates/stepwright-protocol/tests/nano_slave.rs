//! The Nano slave's conversations, as tables: see `talk` in `common/mod.rs`.

use crate::common::talk;

// ---- The Nano slave's lines, as its master sends them ----

#[test]
fn the_travel_order_of_the_document() {
    talk(
        "F       R
         PO      Y
         S5      Y
         T100    Y
         R200    Y
         G+4000  Y
         E       Y  -> start 1 50-1000 R200 R200 +4000
         F       B
         V1      0
         *arrive 1
         F       R
         V1      4000
         P0      Y
         G-12345 Y
         E       Y  -> start 1 50-1000 R200 R200 -12345
         *arrive 1
         V1      -8345",
    );
}

#[test]
fn while_busy_no_line_of_an_order_is_taken() {
    talk(
        "g+      Y  -> start 1 50-1000 R200 R200 forward
         PO      E
         P0      E
         S5      E
         T5      E
         R5      E
         s5      E
         G+5     E
         g+      E
         g-      E
         E       E
         I1      E
         F       B
         V1      0
         A1      Y
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=11 last=busy uncertain=0
         !       Y  -> clear
         Z       Y  -> stop 1
         Z       Y  -> stop 1
         K       Y  -> kill
         F       R",
    );
}

#[test]
fn drive_until_stopped() {
    talk(
        "T50     Y
         g-      Y  -> start 1 50-500 R200 R200 backward
         Z       Y  -> stop 1
         F       B
         *arrive 1
         F       R
         V1      -1000
         Z       Y
         PO      Y
         g+      Y
         F       R
         E       Y  -> start 1 50-500 R200 R200 forward",
    );
}

#[test]
fn a_kill_loses_the_position() {
    talk(
        "K       Y  -> kill
         V1      0
         g+      Y  -> start 1 50-1000 R200 R200 forward
         K       Y  -> kill
         F       R
         V1      E
         V2      0
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=uncertain uncertain=1
         PO      Y
         G+5     Y
         E       Y  -> start 1 50-1000 R200 R200 +5
         *arrive 1
         V1      E
         I1      Y  -> zero 1
         V1      0
         K       Y  -> kill
         V1      0",
    );
}

#[test]
fn a_travel_of_nothing_is_ready_at_once() {
    talk(
        "PO      Y
         G+0     Y
         E       Y  -> start 1 50-1000 R200 R200 +0
         F       R
         PO      Y
         G-0     Y
         E       Y  -> start 1 50-1000 R200 R200 +0",
    );
}

// ---- An order, its lines and their mistakes ----

#[test]
fn settings_persist_and_may_come_before_po() {
    talk(
        "S1      Y
         T0999   Y
         R007    Y
         PO      Y
         G+2147483647 Y
         E       Y  -> start 1 10-9990 R7 R7 +2147483647
         *arrive 1
         PO      Y
         T2      Y
         K       Y  -> kill
         PO      Y
         G-2147483648 Y
         E       Y  -> start 1 10-20 R7 R7 -2147483648",
    );
}

#[test]
fn an_e_without_a_travel_spoils_the_order_too() {
    talk(
        "E       E
         G+5     E
         PO      Y
         T50     Y
         E       E
         G+5     Y
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=4 last=no-travel uncertain=0
         PO      Y
         G+5     Y
         E       Y  -> start 1 50-500 R200 R200 +5
         *arrive 1
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=5 last=no-po uncertain=0",
    );
}

#[test]
fn the_last_travel_counts() {
    talk(
        "PO      Y
         G+5     Y
         g-      Y
         G-7     Y
         E       Y  -> start 1 50-1000 R200 R200 -7",
    );
}

#[test]
fn a_refused_line_spoils_the_order() {
    talk(
        "PO      Y
         T1000   E
         G+4000  Y
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=2 last=range uncertain=0
         E       E
         g+      Y
         E       E
         PO      Y
         T100    Y
         G+4000  Y
         E       Y  -> start 1 50-1000 R200 R200 +4000",
    );
}

#[test]
fn noise_spoils_the_order() {
    for noise in ["x", "G5", "G+-5", "S", "\"\"", "po", "E\\0", "V9", "A4", "12345678901234567"] {
        talk(&format!(
            "PO Y\nG+5 Y\n{noise} E\nE E\nPO Y\nG+5 Y\nE Y -> start 1 50-1000 R200 R200 +5"
        ));
    }
}

#[test]
fn of_a_spoiled_order_the_first_reason_is_told() {
    talk(
        "PO      Y
         S0      E
         A9      E
         foo     E
         G+1     Y
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=4 last=range uncertain=0",
    );
}

#[test]
fn questions_do_not_spoil() {
    talk(
        "PO      Y
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0
         !       Y  -> clear
         F       R
         V1      0
         V3      0
         Z       Y
         G+5     Y
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0
         E       Y  -> start 1 50-1000 R200 R200 +5",
    );
}

#[test]
fn po_starts_afresh_and_k_abandons() {
    talk(
        "PO      Y
         G+5     Y
         PO      Y
         G+6     Y
         K       Y  -> kill
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=killed uncertain=0
         g+      Y
         E       E
         PO      Y
         G+5     Y
         PO      Y
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=3 last=no-travel uncertain=0
         PO      Y
         g+      Y
         E       Y  -> start 1 50-1000 R200 R200 forward",
    );
}

#[test]
fn an_order_that_the_machine_refuses_begins_again() {
    talk(
        "PO      Y
         t900000 Y
         G+5     Y
         *refuse too-fast
         E       E
         F       R
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=too-fast uncertain=0
         T100    Y
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=2 last=too-fast uncertain=0
         PO      Y
         G+5     Y
         E       Y  -> start 1 50-1000 R200 R200 +5
         *arrive 1
         *refuse fault
         g+      E
         F       R
         PO      Y
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=4 last=no-travel uncertain=0",
    );
}

#[test]
fn an_axis_that_set_off_by_itself_is_not_started() {
    talk(
        "PO      Y
         G+5     Y
         *press  1
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=busy uncertain=0
         *arrive 1
         E       E
         PO      Y
         G+5     Y
         E       Y  -> start 1 50-1000 R200 R200 +5",
    );
}
