//! Moves under a sender's hand: holds, overrides, jogs, resets, switches. The machine's own count
//! of steps is to be the controller's, always.

use crate::common::Sender;
use stepwright_grbl::{Grbl, GrblMachine, Inputs, Outputs};

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
fn dwells_and_spindles_wait_for_the_way() {
    let mut sender = Sender::new();
    sender.send(b"M3S500\nG1X1F600\nM5\nG4P0.5\nM0\nG1X2\n");
    assert_eq!(sender.grbl.machine().outputs.power, 500.0);
    assert_eq!(sender.read(), "ok\r\nok\r\n");
    sender.pass(0.4);
    // The spindle stops at the end, then comes the dwell.
    assert_eq!(sender.read(), "ok\r\n");
    assert_eq!((sender.at()[0], sender.grbl.machine().outputs.power), (100, 0.0));
    sender.pass(0.5);
    assert_eq!((sender.read().as_str(), sender.state().as_str()), ("ok\r\n", "Hold:0"));
    sender.send(b"~");
    sender.rest();
    assert_eq!((sender.read().as_str(), sender.at()[0]), ("ok\r\nok\r\n", 200));
}

#[test]
fn a_lasers_power_goes_with_its_speed() {
    let mut sender = Sender::new();
    sender.says("$32=1", "ok");
    sender.send(b"M4S1000\nG1X10F3000\nG0X20\nG1X30S500\n");
    let mut seen = Vec::new();
    while sender.grbl.is_moving() {
        sender.pass(0.002);
        let (at, power) = (sender.at()[0], sender.grbl.machine().outputs.power);
        seen.push((at, power));
    }
    let most = |from: i64, to: i64| {
        let near = seen.iter().filter(|(at, _)| (from..to).contains(at));
        near.map(|(_, power)| *power).fold(0.0, f64::max)
    };
    // 10 mm/s after 10 mm/s / 500 mm/s² and 0.1 mm: a fifth of 50.
    let early = most(5, 12);
    assert!((150.0..350.0).contains(&early), "{early}");
    assert!((999.0..=1_000.0).contains(&most(400, 900)), "{}", most(400, 900));
    assert_eq!(most(1_005, 1_990), 0.0);
    assert!((499.0..=500.0).contains(&most(2_400, 2_700)));
    assert_eq!(sender.grbl.machine().outputs.power, 0.0);
}

/// Whatever time a look covers, its steps and what they switch are in the order of their times.
#[test]
fn a_long_look_has_the_times_of_its_steps() {
    #[derive(Debug, Default)]
    struct Times {
        at: i64,
        seen: Vec<(f64, i64)>,
        lit: Vec<(f64, f64)>,
    }
    impl GrblMachine for Times {
        fn step(&mut self, time: f64, _: usize, forward: bool) {
            self.at += if forward { 1 } else { -1 };
            self.seen.push((time, self.at));
        }
        fn inputs(&mut self) -> Inputs {
            Inputs { limit: [self.at >= 500, false, false], ..Inputs::default() }
        }
        fn switch(&mut self, time: f64, outputs: Outputs) {
            let last = self.seen.last().map_or(0.0, |(time, _)| *time);
            assert!(time >= last, "{time} s behind {last} s");
            self.seen.push((time, self.at));
            self.lit.push((time, outputs.power));
        }
    }
    let mut grbl = Grbl::new(Times::default());
    grbl.receive(0.0, b"$32=1\n$21=1\n$100=100\n$110=3000\n$120=500\nM4S500\nG1X10F1200\n");
    grbl.advance(2.0);
    let said = String::from_utf8(grbl.take_answers()).unwrap();
    let Times { at, seen, lit } = grbl.machine();
    assert!(seen.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    // It is lit on its way, from some ms behind the beginning, and brakes from where the switch is.
    let first = lit.iter().find(|(_, power)| *power > 0.0).unwrap();
    assert!(first.0 < 0.1, "{first:?}");
    assert!(said.contains("ALARM:1") && (535..=545).contains(at), "{at} {said}");
}

/// A mm takes as much at any speed: above its feed rate M4 is above S, up to $30.
#[test]
fn an_override_has_its_power() {
    let mut sender = Sender::new();
    sender.says("$32=1", "ok");
    sender.send(b"M4S400\nG1X40F1500\n");
    sender.pass(0.4);
    for (override_to, expected) in [(&b"\x91\x91\x91\x91\x91"[..], 600.0), (&[0x92; 10], 200.0)] {
        sender.send(override_to);
        sender.pass(0.3);
        let power = sender.grbl.machine().outputs.power;
        assert!((power - expected).abs() < 1.0, "{power}, not {expected}");
    }
    sender.send(b"\x90");
    sender.rest();
    sender.send(b"M4S900\nG1X0\n\x91\x91\x91\x91\x91");
    sender.pass(0.6);
    assert_eq!(sender.grbl.machine().outputs.power, 1_000.0);
}

/// Neither M3 nor M4 burns a hole where it is held, or on the way of a probe.
#[test]
fn a_held_laser_is_dark() {
    for mode in ["M3", "M4"] {
        let mut sender = Sender::new();
        sender.says("$32=1", "ok");
        sender.send(format!("{mode}S500\nG1X20F1500\n").as_bytes());
        sender.pass(0.4);
        assert_eq!(sender.grbl.machine().outputs.power, 500.0);
        sender.send(b"!");
        sender.pass(0.3);
        sender.read();
        assert_eq!((sender.state().as_str(), sender.grbl.machine().outputs.power), ("Hold:0", 0.0));
        sender.send(b"~");
        sender.pass(0.3);
        assert_eq!(sender.grbl.machine().outputs.power, 500.0);
        sender.rest();
        sender.send(format!("{mode}S500\nG38.3X40F1500\n").as_bytes());
        sender.pass(0.3);
        sender.read();
        assert_eq!((sender.state().as_str(), sender.grbl.machine().outputs.power), ("Run", 0.0));
    }
}

/// As of `gcode --laser`: M3 burns while the axes move along a line or an arc, and nowhere else, whatever
/// stands or comes behind it.
#[test]
fn a_laser_that_stands_is_dark() {
    for before in ["G1F600", "G0", "G80", "G38.3Z5F600"] {
        for stands in ["", "!", "M0\n", "G4P1\n", "G99\n", "G99\n?", "$H\n", "G0X0.01\n!"] {
            let mut sender = Sender::new();
            for line in ["$32=1", "$22=1"] {
                sender.says(line, "ok");
            }
            sender.does(before);
            sender.says("M3S500", "ok");
            sender.send(stands.as_bytes());
            for _ in 0..200 {
                sender.pass(0.002);
                let power = sender.grbl.machine().outputs.power;
                assert_eq!(power, 0.0, "{before} {stands}");
                sender.send(b"?");
            }
        }
    }
    // Before the first step, behind the last one, and in a dwell in between.
    let mut sender = Sender::new();
    sender.says("$32=1", "ok");
    sender.send(b"M3S500\nG1X10F1500\nG4P0.2\nX20\n");
    let mut dark = [0; 3];
    while sender.grbl.is_moving() {
        sender.pass(0.002);
        let (at, power) = (sender.at()[0], sender.grbl.machine().outputs.power);
        match at {
            0 | 1_000 | 2_000 => dark[at as usize / 1_000] += u32::from(power == 0.0),
            _ => assert_eq!(power, 500.0, "{at}"),
        }
    }
    assert!(dark[0] > 3 && dark[1] > 90 && dark[2] > 0, "{dark:?}");
    assert_eq!(sender.grbl.machine().outputs.power, 0.0);
}

/// It is another job: it is lit by its own M3 or M4, and not by that of one which had an error.
#[test]
fn a_laser_is_off_behind_an_error() {
    for mode in ["M3S500", "M4S500"] {
        let mut sender = Sender::new();
        sender.says("$32=1", "ok");
        sender.says(mode, "ok");
        sender.says("G99", "error:20");
        sender.says("$X", "ok");
        let lit = |sender: &mut Sender, line: &str| {
            sender.says(line, "ok");
            sender.pass(0.2);
            let lit = sender.grbl.machine().outputs.power > 0.0;
            sender.rest();
            lit
        };
        assert!(!lit(&mut sender, "G91G1X10F1500"), "{mode}");
        sender.says(mode, "ok");
        assert!(lit(&mut sender, "X10"), "{mode}");
    }
}

/// What the reader takes for on is on, and what it takes for off is off: a word switches it all the same.
#[test]
fn a_toggle_and_an_alarm_leave_no_word_without_effect() {
    let mut sender = Sender::new();
    let coolant = |sender: &Sender| {
        let on = sender.grbl.machine().outputs;
        (on.flood, on.mist)
    };
    let mut steps = |bytes: &[u8], on: (bool, bool), mode: &str| {
        sender.send(bytes);
        assert_eq!(coolant(&sender), on, "{bytes:?}");
        assert!(sender.ask("$G").contains(mode), "{bytes:?}");
    };
    steps(b"\xA0", (true, false), " M8 ");
    steps(b"M9\n", (false, false), " M9 ");
    steps(b"M8\n", (true, false), " M8 ");
    steps(b"\xA0", (false, false), " M9 ");
    steps(b"M8\n", (true, false), " M8 ");
    steps(b"\xA1", (true, true), " M7 M8 ");
    steps(b"\xA0M9\n", (false, false), " M9 ");
    // A word that waits for the end of a move comes behind the toggles.
    sender.says("G91G1X1F600", "ok");
    sender.says("M8", "");
    sender.send(b"\xA0\xA0");
    sender.rest();
    assert_eq!(coolant(&sender), (true, false));
    sender.does("M9");
    assert_eq!(coolant(&sender), (false, false));
    // An alarm switches all off.
    sender.does("M3S500M8");
    assert!(sender.does("G38.2Z-1F600").starts_with("ALARM:5"));
    assert_eq!((coolant(&sender), sender.grbl.machine().outputs.power), ((false, false), 0.0));
    assert!(sender.ask("$G").contains(" M5 M9 "));
    sender.says("$X", "[MSG:Caution: Unlocked]\r\nok");
    sender.does("M3M8");
    assert_eq!((coolant(&sender), sender.grbl.machine().outputs.power), ((true, false), 500.0));
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
