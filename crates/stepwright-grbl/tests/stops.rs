//! What ends a motion, and what is executed after it.

use crate::common::Sender;
use stepwright_gcode::SpindleMode;
use stepwright_grbl::QUIET;

/// X at 50 mm/s, braking for 0.1 s after the byte.
fn at_speed(sender: &mut Sender) {
    sender.says("G91", "ok");
    sender.says("G1X100F3000", "ok");
    sender.pass(0.5);
}

/// A sender that streams has sent lines when ^X comes, and its thread sends a few more.
#[test]
fn lines_before_the_banner_are_dropped() {
    let mut sender = Sender::new();
    at_speed(&mut sender);
    sender.send(b"G1Y1\n\x18G1Y2\n");
    sender.pass(0.05);
    sender.send(b"G91G1Y5F1000\nG1Y");
    sender.pass(1.0);
    assert_eq!(sender.read(), "\r\nGrbl 1.1h ['$' for help]\r\n");
    assert_eq!((sender.at()[1], sender.state().as_str()), (0, "Idle"));
    // Half a line is no part of the next one.
    assert_eq!(sender.does("G91G1Z1F600"), "ok");
    assert_eq!(sender.at()[1..], [0, 100]);
}

/// Also behind a ^X that brakes already, and during a homing.
#[test]
fn the_end_executes_no_start_up_line() {
    for (before, then) in [
        (&b""[..], &b""[..]),
        (b"G91G1X50F3000\n", b""),
        (b"G1X50F3000\n", b"\x18"),
        (b"G1X50F3000\n", b"!"),
        (b"$H\n", b""),
        (b"G4P9\n", b""),
    ] {
        let mut sender = Sender::new();
        sender.says("$22=1", "ok");
        sender.says("$N0=G91G1Y10F600M8", "ok");
        sender.send(before);
        sender.pass(0.3);
        sender.read();
        sender.send(then);
        sender.grbl.end(sender.now);
        sender.send(b"G1Y3\n");
        sender.rest();
        let at = sender.at();
        sender.pass(3.0);
        assert_eq!((sender.at(), at[1]), (at, 0), "{before:?}");
        assert_eq!((sender.read().as_str(), sender.state().as_str()), ("", "Sleep"), "{before:?}");
        assert!(!sender.grbl.machine().outputs.flood);
        assert!(sender.grbl.kept().contains("$N0=G91"));
    }
}

/// 50 mm/s at 20 mm/s²: 2.5 s, in which nothing is burnt.
#[test]
fn what_is_on_goes_off_before_it_brakes() {
    for (laser, ends) in [(1, "reset"), (0, "reset"), (1, "limit"), (0, "limit"), (1, "end")] {
        let mut sender = Sender::new();
        for line in [&format!("$32={laser}"), "$120=20", "$21=1"] {
            sender.says(line, "ok");
        }
        sender.send(b"M3S500M8\nG1X500F3000\n");
        sender.pass(4.0);
        let on = sender.grbl.machine().outputs;
        assert_eq!((on.power, on.flood), (500.0, true), "{ends}");
        match ends {
            "reset" => sender.send(b"\x18"),
            "end" => sender.grbl.end(sender.now),
            _ => {
                let at = sender.at()[0];
                sender.grbl.machine_mut().limits[0][1] = Some(at);
            }
        }
        for _ in 0..200 {
            sender.pass(0.002);
            let on = sender.grbl.machine().outputs;
            assert_eq!((on.power, on.spindle, on.flood), (0.0, SpindleMode::Off, false), "{ends}");
            sender.send(b"?");
        }
        assert!(sender.grbl.is_moving());
    }
}

/// Both in one read: the jog has not begun when the byte is obeyed.
#[test]
fn a_jog_is_cancelled_by_the_byte_behind_it() {
    let mut sender = Sender::new();
    sender.send(b"$J=G91X10F3000\n\x85");
    sender.rest();
    assert_eq!((sender.read().as_str(), sender.at()), ("ok\r\n", [0; 3]));
    // And no other line, and no later one.
    sender.send(b"$G\n\x85$J=G91X1F3000\n");
    sender.rest();
    let said = sender.read();
    assert!(said.starts_with("[GC:") && sender.at() == [100, 0, 0], "{said}");
}

/// A job sent ahead waits for a motion longer than the lock waits for silence.
#[test]
fn the_lock_stays_closed_while_lines_wait() {
    let mut sender = Sender::new();
    sender.send(b"M3S100\nG91\nG1X10F600\nG1X5Q\nM5\nG1X-7\n");
    sender.pass(0.6);
    assert_eq!(sender.read(), "ok\r\nok\r\nok\r\nerror:2\r\n");
    sender.send(b"$G\n");
    sender.rest();
    let said = sender.read();
    assert!(said.starts_with("ok\r\nerror:9\r\n[GC:"), "{said}");
    assert_eq!(sender.at(), [1_000, 0, 0]);
    sender.pass(QUIET);
    assert_eq!(sender.does("G1X1"), "ok");
}

/// From a switch that never opens an axis goes no farther than a brake and the back-off: 2.5 and 5 mm.
#[test]
fn homing_leaves_a_closed_switch_by_little() {
    let mut sender = Sender::new();
    sender.says("$22=1", "ok");
    sender.says("$25=1500", "ok");
    sender.grbl.machine_mut().limits[2] = [None, Some(-60_000)];
    assert!(sender.does("$H").starts_with("ALARM:8\r\n"));
    assert_eq!(sender.at(), [0, 0, -750]);
}

#[test]
fn parameters_can_be_read_behind_a_probe() {
    let mut sender = Sender::new();
    sender.grbl.machine_mut().probe = Some(-50);
    sender.send(b"G38.2Z-1F600\n$#\n");
    sender.rest();
    let said = sender.read();
    assert!(said.starts_with("[PRB:0.000,0.000,-0.500:1]\r\nok\r\n[G54:"), "{said}");
}

#[test]
fn check_mode_changes_no_offset() {
    for ends in [&b"$C\n"[..], b"\x18"] {
        let mut sender = Sender::new();
        sender.says("G10L2P1X5", "ok");
        let (kept, was) = (sender.grbl.kept(), sender.ask("$#"));
        sender.send(b"$C\nG91G1X5F100\nG28.1\nG10L2P1X77\nG10L20P2X1\n");
        assert_eq!(sender.grbl.kept(), kept);
        sender.send(ends);
        sender.read();
        assert_eq!((sender.grbl.kept(), sender.ask("$#")), (kept, was));
    }
}

/// As in grbl: a spindle stops once its tool does not move any more, and the coolant with it.
#[test]
fn a_door_stops_the_coolant_too() {
    let mut sender = Sender::new();
    sender.says("M3S100M7", "ok");
    sender.says("M8", "ok");
    at_speed(&mut sender);
    sender.send(b"\x84");
    sender.pass(0.05);
    let on = |sender: &Sender| {
        let on = sender.grbl.machine().outputs;
        (on.power, on.flood, on.mist)
    };
    assert_eq!((sender.state().as_str(), on(&sender)), ("Door:2", (100.0, true, true)));
    sender.pass(0.1);
    assert_eq!((sender.state().as_str(), on(&sender)), ("Door:0", (0.0, false, false)));
    sender.pass(1.0);
    sender.send(b"~");
    sender.pass(0.1);
    sender.read();
    assert_eq!((sender.state().as_str(), on(&sender)), ("Run", (100.0, true, true)));
    // A reset ends it for good.
    sender.send(b"\x84");
    sender.pass(0.5);
    sender.send(b"\x18");
    sender.rest();
    assert_eq!(on(&sender), (0.0, false, false));
    assert!(sender.ask("$G").contains(" M5 M9 "));
}

/// What no machine can follow is refused before anything moves, and the session lives.
#[test]
fn a_step_rate_beyond_the_machine_is_refused() {
    let mut sender = Sender::new();
    for line in ["$100=1000000", "$110=1000000", "$120=1000000", "$22=1"] {
        sender.says(line, "ok");
    }
    let words = |axis: &str| {
        format!("[MSG:{axis} at 16666666667 steps/s: at most 1000000, lower $110 or $100]")
    };
    sender.says("$J=G91X500F1000000", &format!("{}\r\nerror:15", words("X")));
    let alarm = format!("{}\r\nALARM:2\r\n[MSG:Reset to continue]", words("X"));
    for line in ["G91G1X500F1000000", "G0X1", "G2X0Y0I1F1000000", "G93G1X1F600", "G38.2X9F1000000"]
    {
        sender.says(line, &alarm);
        assert!(!sender.grbl.is_moving());
        sender.send(b"\x18$X\nG94\n");
        sender.read();
    }
    // Slowly it can, and other axes can.
    assert_eq!(sender.does("G91G1X0.5F20"), "ok");
    assert_eq!(sender.does("G0Y5"), "ok");
    assert_eq!(sender.at(), [500_000, 500, 0]);
    // Homing: Z, then X.
    let limits = &mut sender.grbl.machine_mut().limits;
    (limits[2][1], limits[0][1]) = (Some(100), Some(600_000));
    sender.says("$25=1000000", "ok");
    let said = sender.does("$H");
    assert!(said.starts_with("[MSG:X at ") && said.contains("ALARM:9"), "{said}");
    assert_eq!(sender.at()[0], 500_000);
}

/// A board's judge has the rates of the move: both axes of a diagonal, at twice the feed rate at most.
#[test]
fn a_judge_has_the_rates_of_the_move() {
    let mut sender = Sender::new();
    let grbl = std::mem::replace(&mut sender.grbl, stepwright_grbl::Grbl::new(Default::default()));
    sender.grbl = grbl.judged_by(Box::new(|rates| Some(format!("{:?}", rates.map(f64::round)))));
    for (line, rates) in [
        ("G1X3Y4F600", [1_200.0, 1_600.0, 0.0]),
        ("G0X3Y-4", [3_750.0, 5_000.0, 0.0]),
        ("G2X2Y2I1J1F600", [2_000.0, 2_000.0, 0.0]),
        ("G2X2Y2Z1I1J1F6000", [5_000.0; 3]),
    ] {
        assert!(sender.ask(line).starts_with(&format!("[MSG:{rates:?}]\r\nALARM:2")), "{line}");
        sender.send(b"\x18$X\n");
        sender.read();
    }
}
