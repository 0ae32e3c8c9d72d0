//! Lines with a checksum, as tables: see `talk` in `common/mod.rs`.

use crate::common::{Bench, say, talk};
use stepwright_protocol::Slave;

#[test]
fn a_line_with_a_checksum_is_answered_in_kind() {
    talk(
        "PO*E6   Y*88
         G+4000*0B Y*88
         G+4001*0B E*DC
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=sum uncertain=0
         E*DC    E*DC
         PO      Y
         G+4000*0B Y*88
         E       Y  -> start 1 50-1000 R200 R200 +4000
         F*D5    B*C9
         F       B
         *arrive 1
         V1*E5   4000*79
         V1*e5   4000*79
         V1      4000",
    );
}

/// A missing or partial checksum spoils any line.
#[test]
fn half_a_checksum_is_none() {
    for line in ["E*", "E*1", "E*DC0", "*00", "*0", "E**DC", "e*DC"] {
        talk(&format!("PO Y\nG+1 Y\n{line} E*DC\nE E\nF R"));
    }
    // The room for the checksum is not usable by a longer line.
    talk("PO Y\nG+0000000000000000000000400 E");
    talk("PO Y\nG+0000000000000000000005*E7 Y*88");
}

/// A flipped bit never turns an order with a checksum into another order, or into another target.
/// Where the checksum is digits, the line without its `*` would be another order.
#[test]
fn a_flipped_bit_is_never_an_order() {
    for right in ["G+4000*0B", "G+4*25", "G-6*55", "@+4*33", "@-1000*D1"] {
        let play = |line: &[u8]| play(if right.starts_with('@') { b"g+" } else { b"PO" }, line);
        let (went, nothing) = (play(right.as_bytes()), play(b"x"));
        assert_ne!(went, nothing, "{right}");
        for bit in 0..8 * right.len() {
            let mut wrong = right.as_bytes().to_vec();
            wrong[bit / 8] ^= 1 << (bit % 8);
            // A capital letter of the checksum may become a small one.
            let digits = right.len() - 2;
            let small = bit / 8 >= digits && wrong.eq_ignore_ascii_case(right.as_bytes());
            let expected = if small { &went } else { &nothing };
            assert_eq!(play(&wrong), *expected, "{}", wrong.escape_ascii());
        }
    }
}

/// The calls that this line causes between another line and an E.
fn play(before: &[u8], line: &[u8]) -> (Vec<String>, Vec<String>) {
    let (mut slave, mut bench) = (Slave::<1>::new(), Bench::new(1));
    assert_eq!(say(&mut slave, &mut bench, before), "Y");
    for byte in line.iter().chain(b"\r") {
        slave.push(*byte, &mut bench);
    }
    say(&mut slave, &mut bench, b"E*DC");
    let asked = bench.asked.iter().flatten().map(|(_, order)| format!("{order:?}"));
    (asked.collect(), bench.changes)
}
