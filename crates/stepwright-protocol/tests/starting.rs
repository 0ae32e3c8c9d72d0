//! An order is started piece by piece. A stop, a line or noise may come between the pieces.

use crate::common::{Bench, say, text};
use stepwright_protocol::{Refusal, Slave, Stop};

/// Three axes. The first runs; the second and third are ordered, E has come, and the machine is
/// starting them.
fn starting() -> (Slave<3>, Bench) {
    let (mut slave, mut bench) = (Slave::new(), Bench::new(3));
    for line in ["PO", "A2", "G+50", "A3", "G-70"] {
        assert_eq!(say(&mut slave, &mut bench, line.as_bytes()), "Y");
    }
    bench.press(0);
    (bench.pieces, bench.log) = (5, String::new());
    receive(&mut slave, &mut bench, "E\r");
    for _ in 0..9 {
        assert!(slave.work(&mut bench), "the order is in work");
        assert!(slave.listens() && !slave.is_answering() && bench.asked.is_empty());
    }
    (slave, bench)
}

fn receive(slave: &mut Slave<3>, bench: &mut Bench, bytes: &str) {
    bytes.bytes().for_each(|byte| slave.receive(byte, bench));
}

/// The next answer.
fn answer(slave: &mut Slave<3>, bench: &mut Bench) -> String {
    while slave.work(bench) {}
    text(slave, bench)
}

/// The words of the answer to `?` that matter here.
fn info(slave: &mut Slave<3>, bench: &mut Bench) -> String {
    let info = say(slave, bench, b"?");
    let words = info.split(' ').filter(|word| {
        ["refused=", "last=", "uncertain=", "stop="].iter().any(|name| word.starts_with(name))
    });
    words.collect::<Vec<_>>().join(" ")
}

const STARTED: &str = "start 2 50-1000 R200 R200 +50; start 3 50-1000 R200 R200 -70";

#[test]
fn an_order_is_answered_when_it_has_started() {
    let (mut slave, mut bench) = starting();
    assert_eq!(answer(&mut slave, &mut bench), "Y");
    assert_eq!(bench.log, STARTED);
    assert_eq!(say(&mut slave, &mut bench, b"G+1"), "E"); // the order is closed
}

#[test]
fn a_refused_order_starts_nothing_and_the_next_one_does() {
    let (mut slave, mut bench) = starting();
    bench.refuse = Some(Refusal::TooFast);
    assert_eq!(answer(&mut slave, &mut bench), "E");
    assert_eq!(bench.log, "");
    assert_eq!(info(&mut slave, &mut bench), "refused=1 last=too-fast uncertain=0 stop=---");
    // Spoiled until PO.
    assert_eq!(say(&mut slave, &mut bench, b"E"), "E");
    bench.arrive(0);
    for line in ["PO", "A2", "G+50", "A3", "G-70", "E"] {
        assert_eq!(say(&mut slave, &mut bench, line.as_bytes()), "Y");
    }
    assert_eq!(bench.log, STARTED);
}

#[test]
fn a_line_waits_for_the_order_and_is_answered_after_it() {
    for (line, said) in [("F", "B"), ("V2", "0"), ("G+1", "E"), ("what", "E"), ("", "E")] {
        let (mut slave, mut bench) = starting();
        receive(&mut slave, &mut bench, line);
        assert!(slave.work(&mut bench) && slave.listens());
        receive(&mut slave, &mut bench, "\r");
        assert!(!slave.listens() && slave.work(&mut bench), "{line:?}");
        assert_eq!(answer(&mut slave, &mut bench), "Y", "of E, before {line:?}");
        assert!(!slave.listens());
        assert_eq!(answer(&mut slave, &mut bench), said, "of {line:?}");
        assert!(slave.listens() && bench.log.starts_with(STARTED));
    }
}

/// K stops moving axes at once, and no axis of the order moves.
#[test]
fn a_kill_stops_at_once_and_refuses_the_order() {
    for line in ["K", "\nK"] {
        let (mut slave, mut bench) = starting();
        receive(&mut slave, &mut bench, line);
        assert_eq!(bench.log, "");
        receive(&mut slave, &mut bench, "\r");
        assert_eq!(bench.log, "kill");
        assert_eq!(answer(&mut slave, &mut bench), "E", "of the order");
        assert_eq!(answer(&mut slave, &mut bench), "Y", "of K");
        assert_eq!(bench.log, "kill; kill");
        assert_eq!(info(&mut slave, &mut bench), "refused=1 last=killed uncertain=1 stop=K--");
        assert_eq!(say(&mut slave, &mut bench, b"E"), "E");
        for line in ["PO", "A2", "G+50", "A3", "G-70", "E"] {
            assert_eq!(say(&mut slave, &mut bench, line.as_bytes()), "Y", "{line}");
        }
    }
}

/// The same with a checksum; a K with a wrong checksum is not obeyed.
#[test]
fn a_kill_with_a_checksum_stops_at_once() {
    let (mut slave, mut bench) = starting();
    receive(&mut slave, &mut bench, "K*00\r");
    assert_eq!(bench.log, "");
    assert_eq!(answer(&mut slave, &mut bench), "Y", "of the order");
    assert!(answer(&mut slave, &mut bench).starts_with("E*"));
    let sum = "*".to_owned() + &hex(b"K");
    let (mut slave, mut bench) = starting();
    receive(&mut slave, &mut bench, &format!("K{sum}\r"));
    assert_eq!(bench.log, "kill");
    assert_eq!(answer(&mut slave, &mut bench), "E", "of the order, which had no sum");
    assert!(answer(&mut slave, &mut bench).starts_with("Y*"));
}

/// CRC-8, polynomial 07: the remainder of the line and a zero byte.
fn hex(line: &[u8]) -> String {
    let mut sum = 0u8;
    for byte in line {
        sum ^= byte;
        for _ in 0..8 {
            sum = if sum & 0x80 != 0 { sum << 1 ^ 7 } else { sum << 1 };
        }
    }
    format!("{sum:02X}")
}

/// Z brakes moving axes at once. In its turn it brakes the axes that the order has started.
#[test]
fn a_soft_stop_brakes_at_once_and_again_in_its_turn() {
    let (mut slave, mut bench) = starting();
    // Axis 3 is selected. Of all axes, only the first moves.
    assert_eq!(answer(&mut slave, &mut bench), "Y");
    (0..3).for_each(|axis| bench.arrive(axis));
    for line in ["PO", "G+50", "A2", "G-70", "A0"] {
        assert_eq!(say(&mut slave, &mut bench, line.as_bytes()), "Y");
    }
    bench.press(2);
    (bench.pieces, bench.log) = (5, String::new());
    receive(&mut slave, &mut bench, "E\r");
    assert!(slave.work(&mut bench) && slave.work(&mut bench));
    receive(&mut slave, &mut bench, "Z\r");
    assert_eq!(bench.log, "stop 3");
    assert_eq!(answer(&mut slave, &mut bench), "Y");
    assert_eq!(answer(&mut slave, &mut bench), "Y");
    let started = "start 1 50-1000 R200 R200 +50; start 2 50-1000 R200 R200 -70";
    assert_eq!(bench.log, format!("stop 3; {started}; stop 1; stop 2; stop 3"));
    assert_eq!(info(&mut slave, &mut bench), "refused=0 last=none uncertain=0 stop=ZZZ");
}

#[test]
fn an_emergency_refuses_the_order() {
    let (mut slave, mut bench) = starting();
    slave.stopped(0, Stop::Emergency);
    assert_eq!(answer(&mut slave, &mut bench), "E");
    assert_eq!(bench.log, "");
    assert_eq!(info(&mut slave, &mut bench), "refused=1 last=fault uncertain=0 stop=---");
}

/// A limit switch that stops a moving axis does not affect the order.
#[test]
fn a_switch_of_another_axis_lets_the_order_go_on() {
    let (mut slave, mut bench) = starting();
    slave.stopped(1, Stop::Switch);
    assert_eq!(answer(&mut slave, &mut bench), "Y");
    assert_eq!(bench.log, STARTED);
}

/// More than one line at a time is more than the slave takes: the waiting line is spoiled.
#[test]
fn what_comes_while_nobody_listens_spoils_the_line_that_waits() {
    let (mut slave, mut bench) = starting();
    receive(&mut slave, &mut bench, "F\rF");
    assert_eq!(answer(&mut slave, &mut bench), "Y");
    assert_eq!(answer(&mut slave, &mut bench), "E");
    assert_eq!(say(&mut slave, &mut bench, b"F"), "B");
}
