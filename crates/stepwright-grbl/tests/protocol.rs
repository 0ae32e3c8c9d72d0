//! Conversations as grbl 1.1h has them by its documents: answers, reports, orders.

use crate::common::Sender;
use stepwright_grbl::{Grbl, KEPT, QUIET, VirtualMill};

#[test]
fn a_first_conversation() {
    let mut sender = Sender::new();
    let zero = "0.000,0.000,0.000";
    // Offsets come first, then overrides, then neither for a while.
    assert_eq!(sender.status(), format!("<Idle|MPos:{zero}|FS:0,0|WCO:{zero}>"));
    assert_eq!(sender.status(), format!("<Idle|MPos:{zero}|FS:0,0|Ov:100,100,100>"));
    for _ in 0..7 {
        assert_eq!(sender.status(), format!("<Idle|MPos:{zero}|FS:0,0>"));
    }
    // CR LF are two ends of a line, and an empty line is answered.
    sender.send(b"G21\r\n");
    assert_eq!(sender.read(), "ok\r\nok\r\n");
    sender.says("$G", "[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]\r\nok");
    sender.says("$I", "[VER:1.1h.20190830:Stepwright]\r\n[OPT:V,128,128]\r\nok");
    sender
        .says("$", "[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]\r\nok");
    sender.says("$N", "$N0=\r\n$N1=\r\nok");
    let parameters = sender.ask("$#");
    assert!(parameters.starts_with(&format!("[G54:{zero}]\r\n[G55:{zero}]")), "{parameters}");
    assert!(parameters.ends_with(&format!("[TLO:0.000]\r\n[PRB:{zero}:0]\r\nok")), "{parameters}");
    let settings = sender.ask("$$");
    assert!(settings.starts_with("$0=10\r\n$1=25\r\n"), "{settings}");
    assert!(settings.contains("\r\n$110=3000.000\r\n"), "{settings}");
}

#[test]
fn what_is_wrong_has_grbls_number() {
    let mut sender = Sender::new();
    for (line, number) in [
        ("$ABC", 3),
        ("$7=1", 3),
        ("$100=", 2),
        ("$100=inf", 2),
        ("$100=-1", 4),
        ("$0=2", 6),
        ("$20=1", 10),
        ("$H", 5),
        ("$J", 3),
        ("$J=X1", 22),
        ("$J=G2X1F100", 16),
        ("$J=M3X1F100", 16),
        ("$N0=G1X1", 22),
        ("G1X1", 22),
        ("X", 2),
        ("1", 1),
        ("G123", 20),
        ("G1G0X1F1", 21),
        (&"X1".repeat(41), 11),
    ] {
        sender.says(line, &format!("error:{number}"));
        sender.pass(2.0 * QUIET);
    }
    assert_eq!(sender.at(), [0; 3]);
}

/// What was sent ahead of the answer would be executed without the line that was wrong.
#[test]
fn an_error_ends_what_was_sent_ahead() {
    let mut sender = Sender::new();
    sender.send(b"G1F600X1\nG1X2 Y\nX3\nX4\n");
    assert_eq!(sender.read(), "ok\r\nerror:2\r\nerror:9\r\nerror:9\r\n");
    // A sender that does not look goes on, and is refused.
    for _ in 0..10 {
        sender.pass(QUIET / 2.0);
        sender.says("G1X5", "error:9");
    }
    // Orders are obeyed all the same, and whoever waits is heard.
    assert!(sender.ask("$G").ends_with("ok"));
    sender.pass(QUIET);
    assert_eq!(sender.does("G1X6"), "ok");
    assert_eq!(sender.at(), [600, 0, 0]);
    sender.says("X", "error:2");
    sender.says("$X", "ok");
    assert_eq!(sender.does("G1X7"), "ok");
    // grbl's way, if it is asked for.
    let grbl = Grbl::new(VirtualMill::default()).with_errors_passed();
    let mut sender = Sender { grbl, now: 0.0 };
    sender.read();
    sender.send(b"G1F600X1\nG1X2 Y\nX3\n");
    assert_eq!(sender.read(), "ok\r\nerror:2\r\nok\r\n");
}

#[test]
fn settings_and_offsets_are_kept() {
    let mut sender = Sender::new();
    for line in ["$N0=G55", "$I=my mill", "$22=1", "$20=1", "G10L2P2X-12.5Y0.0001", "G28.1"] {
        assert!(sender.ask(line).ends_with("ok"), "{line}");
    }
    let kept = sender.grbl.kept();
    let mut again = Sender { grbl: Grbl::new(VirtualMill::default()), now: 0.0 };
    again.grbl.restore(&kept).unwrap();
    // With homing it is locked, and start-up lines wait.
    let banner = "\r\nGrbl 1.1h ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\n";
    assert_eq!(again.read(), banner);
    again.says("G0X1", "error:9");
    assert_eq!(again.grbl.kept(), kept);
    let parameters = again.ask("$#");
    assert!(parameters.contains("[G55:-12.500,0.000,0.000]"), "{parameters}");
    again.says("$X", "[MSG:Caution: Unlocked]\r\nok");
    // A reset executes start-up lines.
    again.send(b"\x18");
    assert_eq!(again.read(), "\r\nGrbl 1.1h ['$' for help]\r\n>G55:ok\r\n");
    assert!(again.ask("$G").contains("G55"));
    for wrong in ["$100", "$100=x", "$7=1", "G60=0,0,0", "G54=0,0", "G54=0,0,0,0", "words"] {
        let text = format!("$0=10\n{wrong}\n");
        assert_eq!(again.grbl.restore(&text).unwrap_err().line, 2, "{wrong}");
        assert_eq!(again.grbl.kept(), kept);
    }
}

/// What is kept is all there is: a file without a line has the default, and no move goes on.
#[test]
fn what_was_before_is_not_kept() {
    let mut sender = Sender::new();
    for line in ["$N0=G55", "$I=my mill", "G10L2P1X5", "G91G1X10F600", "G1X10"] {
        sender.says(line, "ok");
    }
    sender.pass(0.5);
    sender.send(b"\x18$J=X1");
    sender.grbl.restore("$100=100\n").unwrap();
    assert_eq!(sender.read(), "\r\nGrbl 1.1h ['$' for help]\r\n");
    let at = sender.at();
    assert_eq!((at, sender.state().as_str()), (sender.grbl.position(), "Idle"));
    sender.pass(1.0);
    assert_eq!((sender.at(), sender.read().as_str()), (at, ""));
    sender.says("$N", "$N0=\r\n$N1=\r\nok");
    assert_eq!(sender.does("G91G1X1F600"), "ok");
    assert_eq!(sender.at()[0], at[0] + 100);
}

/// A start-up line is no way round what is refused.
#[test]
fn a_board_that_is_fed_has_no_probe_and_no_laser() {
    let mut sender = Sender { grbl: Grbl::new(VirtualMill::default()).fed(false), now: 0.0 };
    sender.read();
    sender.says("$32=1", "error:3");
    let probe = "G38.2Z-1F600";
    sender.says(probe, "error:20");
    sender.says("$X", "ok");
    sender.says(&format!("$N0={probe}"), "error:20");
    sender.says("$N", "$N0=\r\n$N1=\r\nok");
    // One that was kept, of another machine.
    sender.grbl.restore(&format!("$N0={probe}\n$N1=G55\n")).unwrap();
    sender.pass(0.01);
    assert!(sender.read().ends_with(&format!(">{probe}:error:20\r\n>G55:ok\r\n")));
    assert!(!sender.grbl.has_run());
    assert!(sender.ask("$G").starts_with("[GC:G0 G55"));
}

/// Beyond what a length is there is the most of it, to the side where it is.
#[test]
fn a_place_beyond_a_kilometre_has_its_sign() {
    for (way, sign) in [("X11", ""), ("X-11", "-")] {
        let mut sender = Sender::new();
        sender.does(&format!("G1F3000{way}"));
        // 1,100 steps are 1,100 m.
        sender.says("$100=0.001", "ok");
        let status = sender.status();
        assert!(status.contains(&format!("|MPos:{sign}1000000.000,0.000")), "{status}");
        let offset = format!("{sign}600000000000000,0,0");
        sender.grbl.restore(&format!("$10=0\nG54={offset}\n")).unwrap();
        sender.read();
        sender.says(&format!("G92X{}600000", if sign.is_empty() { "-" } else { "" }), "ok");
        let status = sender.status();
        assert!(status.contains(&format!("|WCO:{sign}")), "{status}");
    }
}

#[test]
fn defaults_are_restored() {
    let mut sender = Sender::new();
    sender.says("G10L2P1X1", "ok");
    let banner = "Grbl 1.1h ['$' for help]";
    let restored = format!("[MSG:Restoring defaults]\r\nok\r\n\r\n{banner}");
    sender.says("G92X5", "ok");
    sender.says("$RST=$", &restored);
    assert!(sender.ask("$#").contains("[G92:0.000,"));
    assert!(sender.ask("$$").contains("$100=250.000"));
    assert!(sender.ask("$#").contains("[G54:1.000,"));
    sender.says("$RST=#", &restored);
    assert!(sender.ask("$#").contains("[G54:0.000,"));
    sender.says("$RST=A", "error:3");
}

#[test]
fn inches_are_reported_if_asked_for() {
    let mut sender = Sender::new();
    sender.says("$13=1", "ok");
    sender.does("G20G1X0.5F60");
    assert!(sender.status().starts_with("<Idle|MPos:0.5000,0.0000,0.0000|FS:0.0,0"));
    sender.says("$G", "[GC:G1 G54 G17 G20 G90 G94 M5 M9 T0 F60.0 S0]\r\nok");
}

#[test]
fn work_positions_and_the_buffer_are_reported_if_asked_for() {
    let mut sender = Sender::new();
    sender.says("$10=2", "ok");
    sender.does("G92X10");
    assert!(
        sender.status().starts_with("<Idle|WPos:10.000,0.000,0.000|Bf:128,128|FS:0,0|WCO:-10.000,")
    );
    sender.send(b"N7G1X20F100\nG1X");
    assert_eq!(sender.read(), "ok\r\n");
    assert!(sender.status().starts_with("<Run|WPos:10.000,0.000,0.000|Bf:127,128|Ln:7|FS:0,0"));
}

#[test]
fn check_mode_reads_and_moves_nothing() {
    let mut sender = Sender::new();
    sender.says("$C", "[MSG:Enabled]\r\nok");
    assert_eq!(sender.state(), "Check");
    sender.says("G1X100F100M3S100", "ok");
    sender.says("G1X1Y", "error:2");
    sender.pass(QUIET);
    sender.says("$C", "[MSG:Disabled]\r\nok\r\n\r\nGrbl 1.1h ['$' for help]");
    assert_eq!((sender.state().as_str(), sender.at()), ("Idle", [0; 3]));
}

/// Bytes that are no part of a line may come anywhere in it, also as UTF-8.
#[test]
fn real_time_bytes_come_in_the_middle_of_a_line() {
    let mut sender = Sender::new();
    sender.send(b"G1X\xC2\x911?0F6\x930");
    let status = sender.read();
    assert!(status.starts_with("<Idle|") && status.contains("|WCO:"), "{status}");
    assert!(sender.status().contains("|Ov:111,100,100"));
    assert_eq!(sender.does("0"), "ok");
    assert_eq!(sender.at(), [1_000, 0, 0]);
}

#[test]
fn comments_blanks_and_small_letters() {
    let mut sender = Sender::new();
    assert_eq!(sender.does("g1 x 1 (to the right) f 600 ; there"), "ok");
    assert_eq!(sender.at(), [100, 0, 0]);
    assert_eq!(sender.does("%"), "ok");
}

#[test]
fn sleep_is_left_by_a_reset_alone() {
    let mut sender = Sender::new();
    sender.says("$SLP", "ok\r\n[MSG:Sleeping]");
    sender.send(b"G1X1F100\n~!");
    assert_eq!((sender.state().as_str(), sender.read().as_str()), ("Sleep", ""));
    sender.send(b"\x18");
    let locked = "\r\nGrbl 1.1h ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\n";
    assert_eq!((sender.read().as_str(), sender.state().as_str()), (locked, "Alarm"));
}

/// What switches off is obeyed, and a laser does not burn where it stands.
#[test]
fn an_error_leaves_no_laser_on() {
    let mut sender = Sender::new();
    sender.says("$32=1", "ok");
    sender.send(b"M3S500\nG91G1X2F1000\nG99\nX3\n");
    assert_eq!(sender.read(), "ok\r\nok\r\nerror:20\r\nerror:9\r\n");
    sender.rest();
    assert_eq!((sender.at()[0], sender.grbl.machine().outputs.power), (200, 0.0));
    sender.says("M5", "ok");
    sender.pass(QUIET);
    sender.says("M3S500", "ok");
    sender.says("G99", "error:20");
    sender.says("M9", "ok");
    assert!(sender.ask("$G").contains("M5"));
}

/// A flood without an answer is kept up to a bound; real-time bytes are heard behind it.
#[test]
fn a_flood_leaves_real_time_bytes_alone() {
    let mut sender = Sender::new();
    sender.send(b"M0\n");
    let flood = b"G1X1F600\n".repeat(20_000);
    sender.send(&flood);
    assert_eq!(sender.grbl.waiting(), KEPT + 1);
    assert!(sender.status().ends_with(">") && sender.state() == "Hold:0");
    sender.send(b"~");
    sender.rest();
    let said = sender.read();
    let (lines, refused) = (said.matches("ok\r\n").count(), said.matches("error:").count());
    // The line that was cut is refused, and none behind it was kept.
    assert_eq!((lines, refused), (KEPT / 9 + 1, 0), "{}", said.len());
    sender.says("", "error:11");
    sender.send(b"\x18");
    assert!(sender.read().contains("Grbl 1.1h"));
}

#[test]
fn check_mode_finds_all_errors() {
    let mut sender = Sender::new();
    sender.says("$C", "[MSG:Enabled]\r\nok");
    sender.send(b"G99\nG1F5X1\nG98\nG0X1\n");
    assert_eq!(sender.read(), "error:20\r\nok\r\nerror:20\r\nok\r\n");
    assert_eq!(sender.grbl.faults(), 2);
}

/// The next sender does not go on with a line of the last one.
#[test]
fn half_a_line_goes_with_its_sender() {
    let mut sender = Sender::new();
    sender.send(b"G1F600X1\nX7Y");
    sender.grbl.hang_up();
    assert_eq!(sender.does("G0Z1"), "ok\r\nok");
    assert_eq!(sender.at(), [100, 0, 100]);
}
