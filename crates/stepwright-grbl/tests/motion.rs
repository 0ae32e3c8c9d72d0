//! Moves under a sender's hand: holds, overrides, jogs, resets, switches. The machine's own count
//! of steps is to be the controller's, always.

use crate::common::Sender;

#[test]
fn a_job_ends_where_it_says() {
    let mut sender = Sender::new();
    sender.send(b"G1F2000X10\nG2X20I5\nG1Y5Z-1\nG0X0Y0Z0\nM2\n");
    sender.rest();
    assert_eq!(sender.read(), "ok\r\nok\r\nok\r\nok\r\n[MSG:Pgm End]\r\nok\r\n");
    assert_eq!((sender.at(), sender.state().as_str()), ([0; 3], "Idle"));
}

#[test]
fn a_hold_stands_and_goes_on_to_the_exact_end() {
    let mut sender = Sender::new();
    sender.says("G1F3000X50Y25", "ok");
    sender.pass(0.5);
    assert_eq!(sender.state(), "Run");
    sender.send(b"!");
    assert_eq!(sender.state(), "Hold:1");
    sender.pass(0.3);
    let at = sender.at();
    assert_eq!(sender.state(), "Hold:0");
    assert!(at[0] > 1_000 && at[0] < 4_000 && (at[0] - 2 * at[1]).abs() <= 2, "{at:?}");
    // Lines wait, and are not answered.
    sender.says("G1X0Y0", "");
    sender.pass(1.0);
    assert_eq!((sender.at(), sender.state().as_str()), (at, "Hold:0"));
    sender.send(b"~");
    sender.rest();
    assert_eq!((sender.at(), sender.read().as_str()), ([0; 3], "ok\r\n"));
}

/// 50 mm/s at 500 mm/s²: 0.1 s and 2.5 mm.
#[test]
fn a_reset_brakes_and_keeps_the_place() {
    let mut sender = Sender::new();
    sender.says("G1F3000X100", "ok");
    sender.pass(0.5);
    let at = sender.at()[0];
    sender.send(b"\x18");
    assert_eq!(sender.read(), "");
    sender.rest();
    let way = sender.at()[0] - at;
    assert!((230..=260).contains(&way), "{way}");
    assert_eq!(sender.read(), "\r\nGrbl 1.1h ['$' for help]\r\n");
    assert_eq!(sender.grbl.position(), sender.at());
    let place = format!("<Idle|MPos:{:.3},0.000,0.000|", sender.at()[0] as f64 / 100.0);
    assert!(sender.status().starts_with(&place));
    // And what follows ends exactly.
    sender.does("G1F3000X0");
    assert_eq!(sender.at(), [0; 3]);
}

#[test]
fn overrides_change_the_speed() {
    let mut sender = Sender::new();
    sender.says("G1F1200X100", "ok");
    sender.pass(0.5);
    let speed = |sender: &mut Sender| {
        let before = sender.at()[0];
        sender.pass(0.5);
        (sender.at()[0] - before) as f64 / 50.0
    };
    assert!((speed(&mut sender) - 20.0).abs() < 0.1);
    assert!(sender.status().contains("|FS:1200,0"));
    sender.send(&[0x91; 5]);
    sender.pass(0.2);
    assert!((speed(&mut sender) - 30.0).abs() < 0.1);
    // Never faster than the axis can.
    sender.send(&[0x91; 15]);
    sender.pass(0.2);
    assert!((speed(&mut sender) - 40.0).abs() < 0.1);
    sender.send(&[0x90]);
    sender.send(&[0x92; 20]);
    sender.pass(0.2);
    assert!((speed(&mut sender) - 2.0).abs() < 0.1);
    sender.send(&[0x90]);
    sender.rest();
    assert_eq!(sender.at(), [10_000, 0, 0]);
}

/// A rapid is slowed by its own override, also on its way, and by that of the feed rate never.
#[test]
fn rapids_have_an_override_of_their_own() {
    let mut sender = Sender::new();
    sender.says("G0X100", "ok");
    sender.send(&[0x92; 5]);
    sender.pass(0.5);
    let speed = |sender: &mut Sender| {
        let before = sender.at()[0];
        sender.pass(0.2);
        (sender.at()[0] - before) as f64 / 20.0
    };
    assert!((speed(&mut sender) - 50.0).abs() < 0.1);
    sender.send(&[0x96]);
    let told = [sender.status(), sender.status()];
    assert!(told.iter().any(|status| status.contains("|Ov:50,50,100")), "{told:?}");
    sender.pass(0.2);
    assert!((speed(&mut sender) - 25.0).abs() < 0.1);
    sender.send(&[0x97]);
    sender.pass(0.2);
    assert!((speed(&mut sender) - 12.5).abs() < 0.1);
    sender.send(&[0x95]);
    sender.rest();
    // And no move at a feed rate.
    sender.send(&[0x90, 0x97]);
    sender.says("G1X0F1200", "ok");
    sender.pass(0.5);
    assert!((speed(&mut sender) + 20.0).abs() < 0.1);
    sender.rest();
    assert_eq!(sender.at(), [0; 3]);
}

#[test]
fn a_jog_ends_when_it_is_cancelled() {
    let mut sender = Sender::new();
    sender.says("$J=G91X100F3000", "ok");
    sender.says("$J=G91Y100F3000", "ok");
    sender.pass(0.3);
    assert_eq!(sender.state(), "Jog");
    sender.says("G1X1F100", "error:9");
    // Jogs that wait go with the one that is cancelled; other lines do not.
    sender.send(&b"$J=G91Y1F3000\n".repeat(200));
    sender.send(b"$G\n\x85");
    sender.rest();
    let said = sender.read();
    assert!(said.ends_with("S0]\r\nok\r\n") && said.matches("ok\r\n").count() == 201);
    let at = sender.at();
    assert!(at[0] > 500 && at[0] < 1_500 && at[1] == 0, "{at:?}");
    assert_eq!(sender.state(), "Idle");
    // A jog changes no mode.
    assert!(sender.ask("$G").contains("G0 G54 G17 G21 G90 G94"));
    assert_eq!(sender.does("$J=G90X0F3000"), "ok");
    assert_eq!(sender.at(), [0; 3]);
    sender.says("G1X10F600", "ok");
    sender.says("$J=X1F100", "error:8");
}

/// What is cancelled with a jog is what waited then, and nothing that a reset or a sender's end has
/// cleared.
#[test]
fn a_jog_behind_a_reset_is_no_cancelled_one() {
    for ends in ["reset", "hang up"] {
        let mut sender = Sender::new();
        sender.says("$J=G91X100F3000", "ok");
        sender.pass(0.3);
        // Comments of a line that has no end yet wait behind the jogs that fill the planner.
        sender.send(&b"$J=G91Y1F3000\n".repeat(150));
        sender.send(&[b"(", &b"x".repeat(300)[..]].concat());
        sender.send(b"\x85");
        match ends {
            "reset" => sender.send(b"\x18"),
            _ => sender.grbl.hang_up(),
        }
        sender.rest();
        let at = sender.at();
        sender.read();
        assert_eq!(sender.does("$J=G91Z1F600"), "ok", "{ends}");
        assert_eq!(sender.at(), [at[0], at[1], 100], "{ends}");
    }
}

#[test]
fn soft_limits_end_a_job_and_refuse_a_jog() {
    let mut sender = Sender::new();
    sender.says("$22=1", "ok");
    sender.says("$20=1", "ok");
    sender.says("$J=X1F100", "error:15");
    sender.says("$J=X-201F100", "error:15");
    sender.send(b"G1X-20F3000\nG1X5\nG1X-1\n");
    sender.rest();
    assert_eq!(sender.read(), "ok\r\nALARM:2\r\n[MSG:Reset to continue]\r\n");
    // Nothing but a reset is heard.
    sender.says("$X", "");
    sender.send(b"\x18");
    assert_eq!(sender.read(), "\r\nGrbl 1.1h ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\n");
    sender.says("$X", "[MSG:Caution: Unlocked]\r\nok");
    assert_eq!(sender.grbl.position(), sender.at());
}

/// An arc whose ends are within the travel may leave it in between: that is refused as its end would be, and
/// one that touches the limit is made.
#[test]
fn soft_limits_hold_for_the_bulge_of_an_arc() {
    for (start, arc, good) in [
        ("X-10Y-10", "G3X-20R-30", false),
        ("X-10Y-190", "G2X-20R-30", false),
        ("X-3.5Y-3.5", "G3X-10.5I-3.5", true),
        ("X-3.5Y-3.4", "G3X-10.5I-3.5", false),
        ("X-3.5Y-3.4", "G2X-10.5I-3.5", true),
        // Half a step is 5 µm: by 0, 2.4 and 6 µm.
        ("X-8Y-9", "G2X-8I3J4", true),
        ("X-8.004Y-9", "G2X-8.004I3.004J4", true),
        ("X-8.01Y-9", "G2X-8.01I3.01J4", false),
        ("X-3Z-4", "G18G2X-3I3K4", false),
    ] {
        let mut sender = Sender::new();
        sender.says("$22=1", "ok");
        sender.says("$20=1", "ok");
        assert_eq!(sender.does(&format!("G1{start}F3000")), "ok");
        let at = sender.at();
        let expected = if good { "ok" } else { "ALARM:2\r\n[MSG:Reset to continue]" };
        assert_eq!(sender.does(arc), expected, "{start} {arc}");
        assert!(good || sender.at() == at, "{start} {arc}");
    }
}

#[test]
fn hard_limits_brake() {
    let mut sender = Sender::new();
    sender.says("$21=1", "ok");
    sender.grbl.machine_mut().limits[0][1] = Some(2_000);
    sender.send(b"G1X50F3000\n");
    sender.rest();
    assert_eq!(sender.read(), "ok\r\nALARM:1\r\n[MSG:Reset to continue]\r\n");
    let at = sender.at()[0];
    assert!((2_200..=2_260).contains(&at), "{at}");
    assert!(sender.status().contains("|Pn:X"));
    sender.send(b"\x18");
    let said = sender.read();
    assert!(said.ends_with("[MSG:Check Limits]\r\n[MSG:'$H'|'$X' to unlock]\r\n"), "{said}");
    // It can be left, and left alone.
    sender.says("$X", "[MSG:Caution: Unlocked]\r\nok");
    assert_eq!(sender.does("$J=G91X-10F3000"), "ok");
    assert_eq!(sender.does("G91G1X15F3000"), "ok\r\nALARM:1\r\n[MSG:Reset to continue]");
}

/// Whatever else ends the move: only a reset is more than the alarm of a switch.
#[test]
fn a_switch_that_closes_is_an_alarm_whatever_brakes() {
    for line in ["$J=X50F3000", "G1X50F3000"] {
        for (before, behind) in
            [("", "!"), ("", "\u{84}"), ("", "\u{85}"), ("!", ""), ("\u{84}", ""), ("\u{85}", "")]
        {
            let mut sender = Sender::new();
            sender.says("$21=1", "ok");
            sender.says(line, "ok");
            sender.pass(0.5);
            let byte = |text: &str| text.chars().map(|byte| byte as u8).collect::<Vec<u8>>();
            sender.send(&byte(before));
            let at = sender.at()[0];
            sender.grbl.machine_mut().limits[0][1] = Some(at + 20);
            sender.pass(0.02);
            sender.send(&byte(behind));
            sender.rest();
            let said = sender.read();
            let braked = format!("{line} {before:?} {behind:?}: {said}");
            assert_eq!(said.matches("ALARM:1").count(), 1, "{braked}");
            assert_eq!(sender.state(), "Alarm", "{braked}");
            assert_eq!(sender.grbl.position(), sender.at());
        }
    }
}

#[test]
fn a_probe_tells_where_it_had_contact() {
    let mut sender = Sender::new();
    sender.grbl.machine_mut().probe = Some(-500);
    let said = sender.does("G38.2Z-10F600");
    assert_eq!(said, "[PRB:0.000,0.000,-5.000:1]\r\nok");
    let at = sender.at()[2];
    assert!((-520..-500).contains(&at), "{at}");
    // It is where it came to rest, exactly.
    sender.does("G1Z-5F600");
    assert_eq!(sender.at(), [0, 0, -500]);
    // Closed from the beginning.
    assert_eq!(sender.does("G38.2Z-10F600"), "ALARM:4\r\nok");
    sender.says("$X", "[MSG:Caution: Unlocked]\r\nok");
    sender.does("G0Z0");
    assert_eq!(sender.does("G38.3Z-4"), "[PRB:0.000,0.000,-4.000:0]\r\nok");
    assert_eq!(sender.does("G38.2Z-4.5"), "ALARM:5\r\n[PRB:0.000,0.000,-4.500:0]\r\nok");
    assert_eq!((sender.at(), sender.state().as_str()), ([0, 0, -450], "Alarm"));
}

/// Switches at -5 mm, 4 mm and -2 mm, pull-off 1 mm: the place is where the edge is, whatever the
/// way of the brake.
#[test]
fn homing_finds_the_switches() {
    let mut sender = Sender::new();
    for line in ["$22=1", "$25=1500", "$23=4"] {
        sender.says(line, "ok");
    }
    sender.says("$N0=G55", "ok");
    // X stands on its switch.
    let limits = &mut sender.grbl.machine_mut().limits;
    (limits[0][1], limits[1][1], limits[2][0]) = (Some(-500), Some(400), Some(-200));
    sender.send(b"$H\n");
    sender.pass(0.1);
    assert_eq!((sender.read().as_str(), sender.state().as_str()), ("", "Home"));
    sender.rest();
    assert_eq!(sender.read(), ">G55:ok\r\nok\r\n");
    assert_eq!(sender.at(), [-600, 300, -100]);
    // Z homes downwards: -200 + 1.
    assert_eq!(sender.grbl.position(), [-100, -100, -19_900]);
    sender.does("G53G0X-2");
    assert_eq!(sender.at(), [-700, 300, -100]);
}

#[test]
fn homing_without_a_switch_gives_up() {
    let mut sender = Sender::new();
    sender.says("$22=1", "ok");
    sender.says("$25=3000", "ok");
    let locked = "\r\n\r\nGrbl 1.1h ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]";
    assert_eq!(sender.does("$H"), format!("ALARM:9{locked}"));
    assert_eq!(sender.at(), [0, 0, 30_000]);
    // A switch that stays closed.
    sender.grbl.machine_mut().limits[2] = [None, Some(-60_000)];
    assert_eq!(sender.does("$H"), format!("ALARM:8{locked}"));
    // A reset on the way.
    sender.grbl.machine_mut().limits[2] = [None, None];
    sender.send(b"$H\n");
    sender.pass(0.5);
    sender.send(b"\x18");
    sender.rest();
    assert_eq!(sender.read().trim_end(), format!("ALARM:6{locked}"));
    assert_eq!(sender.grbl.machine().at[0], 0);
}

#[test]
fn the_door_ends_a_jog_and_a_homing() {
    let mut sender = Sender::new();
    sender.says("$J=X100F3000", "ok");
    sender.pass(0.3);
    sender.send(b"\x84");
    sender.rest();
    assert_eq!(sender.state(), "Door:0");
    sender.send(b"~");
    assert_eq!(sender.state(), "Idle");
    sender.says("$22=1", "ok");
    sender.send(b"$H\n");
    sender.pass(0.3);
    sender.send(b"\x84");
    sender.rest();
    assert!(sender.read().starts_with("ALARM:7\r\n\r\nGrbl"));
}

/// An open one ends a homing as the byte does.
#[test]
fn a_door_that_opens_ends_a_homing() {
    let mut sender = Sender::new();
    sender.says("$22=1", "ok");
    sender.send(b"$H\n");
    sender.pass(0.3);
    sender.grbl.machine_mut().door = true;
    sender.rest();
    let said = sender.read();
    assert!(
        said.starts_with("ALARM:7\r\n\r\nGrbl") && said.matches("ALARM").count() == 1,
        "{said}"
    );
    let at = sender.at()[2];
    assert!(at > 0 && at < 1_000, "{at}");
    assert_eq!(sender.state(), "Alarm");
}

/// As grbl's, they go at their own feed rate.
#[test]
fn a_feed_override_is_not_for_jogs_probes_and_homing() {
    let speed = |line: &str| {
        let mut sender = Sender::new();
        for setting in ["$22=1", "$25=600"] {
            sender.says(setting, "ok");
        }
        sender.send(&[0x92; 5]);
        sender.send(line.as_bytes());
        sender.send(b"\n");
        let mut speeds = [(); 2].map(|()| {
            sender.pass(0.2);
            let [x, _, z] = sender.at();
            sender.pass(0.2);
            let [then_x, _, then_z] = sender.at();
            sender.send(&[0x90, 0x91, 0x91]);
            (then_x - x).abs().max((then_z - z).abs()) as f64 / 20.0
        });
        // To a mm/s.
        speeds.iter_mut().for_each(|speed| *speed = speed.round());
        speeds
    };
    assert_eq!(speed("G1X100F600"), [5.0, 12.0]);
    for line in ["$J=X100F600", "G38.3Z-100F600", "$H"] {
        assert_eq!(speed(line), [10.0; 2], "{line}");
    }
}

#[test]
fn an_open_door_brakes() {
    let mut sender = Sender::new();
    sender.send(b"M3S100\nG1X50F3000\n");
    sender.pass(0.5);
    sender.grbl.machine_mut().door = true;
    sender.pass(0.01);
    assert_eq!(sender.read(), "ok\r\nok\r\n[MSG:Check Door]\r\n");
    assert_eq!(sender.state(), "Door:2");
    sender.pass(0.3);
    assert_eq!((sender.state().as_str(), sender.grbl.machine().outputs.power), ("Door:1", 0.0));
    sender.send(b"~");
    assert_eq!(sender.state(), "Door:1");
    sender.grbl.machine_mut().door = false;
    assert_eq!(sender.state(), "Door:0");
    sender.read();
    sender.send(b"~");
    assert_eq!(sender.read(), "[MSG:Restoring spindle]\r\n");
    sender.rest();
    assert_eq!((sender.at()[0], sender.grbl.machine().outputs.power), (5_000, 100.0));
}

/// A line at a time, each when the one before is answered, with a hold on the way; lines that wait for
/// others to become an arc too.
#[test]
fn a_slow_sender_gets_to_the_exact_end() {
    let each = [0.0, 0.001, 0.004, 0.01, 0.05];
    for (late, mode) in each.into_iter().flat_map(|late| [(late, "G61"), (late, "G64P0.02")]) {
        let mut sender = Sender::new();
        let mut job: Vec<String> = vec![format!("{mode}G1F3000")];
        for n in 1..=600 {
            let (radius, angle) = (f64::from(n) / 30.0, f64::from(n) / 40.0);
            job.push(format!("X{:.3}Y{:.3}", radius * angle.cos(), radius * angle.sin()));
        }
        job.extend(["G0Z1.5".to_owned(), "X12.34Y-5.67".to_owned()]);
        let held = 300;
        for (n, line) in job.iter().enumerate() {
            if n == held {
                sender.send(b"!");
                sender.pass(1.0);
                assert_eq!(sender.state(), "Hold:0");
                sender.send(b"~");
            }
            sender.send(format!("{line}\n").as_bytes());
            while !sender.read().contains("ok") {
                sender.pass(0.002);
            }
            sender.pass(late);
        }
        sender.rest();
        assert_eq!(sender.at(), [1_234, -567, 150], "{late} {mode}");
    }
}

/// A circle of 10 mm in chords of 0.1 mm, from places of two digits: with a tolerance at the speed of an arc.
#[test]
fn rounded_chords_within_a_tolerance_are_an_arc() {
    let chord = |n: u32| {
        let (y, x) = (std::f64::consts::TAU * f64::from(n) / 628.0).sin_cos();
        format!("X{:.2}Y{:.2}\n", 10.0 * x - 10.0, 10.0 * y)
    };
    let chords: String = (1..=628).map(chord).collect();
    let times = ["G61\n", "G64P0.01\n"].map(|mode| {
        let mut sender = Sender::new();
        sender.send(format!("{mode}G1F3000\n{chords}").as_bytes());
        sender.rest();
        assert_eq!(sender.at(), [0; 3]);
        sender.now
    });
    let mut sender = Sender::new();
    sender.send(b"G3X0Y0I-10F3000\n");
    sender.rest();
    assert!(times[1] < 1.03 * sender.now && times[0] > 2.0 * times[1], "{times:?} {}", sender.now);
    // Lines that wait are dropped by a reset: 2.5 mm of braking from 50 mm/s, and no more.
    let mut sender = Sender::new();
    sender.send(format!("G64P0.01G1F3000\n{chords}").as_bytes());
    sender.pass(0.4);
    let far = |sender: &Sender| {
        let [x, y, _] = sender.at().map(|at| at as f64 / 100.0);
        y.atan2(x + 10.0) * 10.0
    };
    let before = far(&sender);
    sender.send(b"\x18");
    sender.rest();
    sender.read();
    let way = far(&sender) - before;
    assert!((1.0..3.0).contains(&way), "{way}");
    assert_eq!((sender.grbl.position(), sender.state().as_str()), (sender.at(), "Idle"));
}

/// A hold before the first line has moved anything holds it, and a reset forgets the tolerance.
#[test]
fn a_line_that_waits_is_held_and_dropped() {
    let mut sender = Sender::new();
    sender.says("G64P0.02", "ok");
    sender.says("G1F3000X10", "ok");
    sender.send(b"!");
    sender.pass(1.0);
    assert_eq!((sender.at(), sender.state().as_str()), ([0; 3], "Hold:0"));
    sender.send(b"~");
    sender.rest();
    assert_eq!(sender.at(), [1_000, 0, 0]);
    sender.says("G1X20", "ok");
    sender.send(b"\x18");
    sender.rest();
    sender.read();
    assert_eq!((sender.at(), sender.state().as_str()), ([1_000, 0, 0], "Idle"));
    // Two lines with a corner that the tolerance would round, and does not.
    sender.send(b"G1F3000\nX10.02\nX10.03Y0.01\nX10.04Y0.03\nX10.04Y0.05\n");
    sender.rest();
    assert_eq!(sender.at(), [1_004, 5, 0]);
}
