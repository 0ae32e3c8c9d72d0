//! Spindles, lasers and the coolant: what is on, and when.

use crate::common::Sender;
use stepwright_grbl::{Grbl, GrblMachine, Inputs, Outputs};

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

/// A jog is a move at a feed rate, in G0 too, and burns as one while M3 or M4 is on.
#[test]
fn a_jog_burns_as_in_grbl() {
    for (before, power) in [("M3S500", 500.0), ("M4S500", 500.0), ("M3S0", 0.0), ("M5", 0.0)] {
        let mut sender = Sender::new();
        for line in ["$32=1", "G0", before] {
            sender.says(line, "ok");
        }
        sender.says("$J=G91X20F1500", "ok");
        sender.pass(0.4);
        assert_eq!(sender.state(), "Jog");
        let burnt = sender.grbl.machine().outputs.power;
        assert!((burnt - power).abs() < 1.0, "{before}: {burnt}");
        sender.send(b"\x85");
        sender.rest();
        assert_eq!(sender.grbl.machine().outputs.power, 0.0, "{before}");
    }
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
