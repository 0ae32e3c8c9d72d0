//! Several axes, as tables: which axis a line addresses, and which start together. See `talk` in
//! `common/mod.rs`.

use crate::common::{Bench, say, talk, text};
use stepwright_protocol::Slave;

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
         Z       Y  -> stop 1",
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
         Z       Y  -> stop 1; stop 2; stop 3
         *arrive 2
         Z       Y  -> stop 1; stop 3
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

/// A master that sends A2 before PO means axis 2. A master that knows no A, on a line where another
/// has sent A2, means axis 1. Neither motor may move.
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

/// A master that knows no A is refused at most one order, and none after a complete order of
/// another master.
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
         Z       Y  -> stop 2
         *arrive 2
         PO      Y
         G+3     E
         E       E
         PO      Y
         G+4     Y
         E       Y  -> start 1 50-1000 R200 R200 +4",
    );
}

/// A stop goes to both axes that may be meant.
#[test]
fn a_stop_reaches_the_axes_of_a_and_of_po() {
    talk(
        "A0      Y
         g+      Y  -> start 1 50-1000 R200 R200 forward; start 2 50-1000 R200 R200 forward; start 3 50-1000 R200 R200 forward
         *arrive 2
         A2      Y
         PO      Y
         F       B
         Z       Y  -> stop 1
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

#[test]
fn a_slave_has_room_for_fewer_axes_than_the_machine_has() {
    let (mut slave, mut bench) = (Slave::<2>::new(), Bench::new(3));
    assert_eq!(say(&mut slave, &mut bench, b"A3"), "E");
    assert_eq!(say(&mut slave, &mut bench, b"A0"), "Y");
    assert_eq!(say(&mut slave, &mut bench, b"g+"), "Y");
    assert_eq!(bench.asked[0].len(), 2);
    // Axes without room have no uncertain position and no stop letter either.
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

/// A position that becomes unknown between its request and its answer.
#[test]
fn a_position_that_is_lost_while_it_is_asked_for_is_not_told() {
    let (mut slave, mut bench) = (Slave::<2>::new(), Bench::new(2));
    for byte in b"V2\r" {
        slave.receive(*byte, &mut bench);
    }
    while slave.work(&mut bench) {}
    bench.axes[1].uncertain = true;
    assert_eq!(text(&mut slave, &mut bench), "E");
    assert_eq!(say(&mut slave, &mut bench, b"V2"), "E");
}
