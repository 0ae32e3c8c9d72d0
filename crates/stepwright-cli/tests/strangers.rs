//! Boards that are not quite ours: the Nano slave, slow ones, forgetful
//! ones. The test plays the board on a pseudo-terminal.
#![cfg(unix)]

use std::fs::File;
use std::io::{Read, Write};

use crate::common::{Ended, pty, stepwright};

/// A slave that knows the Nano slave's lines and nothing else, which moves a little whenever it
/// is asked.
#[derive(Default)]
struct Slave {
    position: i64,
    target: i64,
    ordered: i64,
}

impl Slave {
    fn answer(&mut self, line: &str) -> String {
        let way = self.target - self.position;
        let (letter, rest) = line.split_at(line.len().min(1));
        let number = rest.trim_start_matches('+').parse::<i64>();
        match (letter, number) {
            ("F", _) => {
                self.position += way.clamp(-10, 10);
                if way == 0 { "R" } else { "B" }.to_owned()
            }
            ("V", Ok(1)) => self.position.to_string(),
            ("P" | "S" | "T" | "R", _) if way != 0 => "E".to_owned(),
            ("S" | "T" | "R", Ok(1..=999)) => "Y".to_owned(),
            ("G", Ok(steps)) => {
                self.ordered = steps;
                "Y".to_owned()
            }
            ("E", _) => {
                self.target = self.position + self.ordered;
                "Y".to_owned()
            }
            _ if line == "PO" || line == "Z" || line == "I1" => "Y".to_owned(),
            _ => "E".to_owned(),
        }
    }
}

/// Has `answer` answer each line, until nobody holds the other end.
fn play(mut answer: impl FnMut(&str) -> Option<String> + Send + 'static) -> String {
    let (mut master, path) = pty();
    // Held open here, so that a command that leaves does not end the play.
    let held = File::options().read(true).write(true).open(&path).unwrap();
    let mut settings = rustix::termios::tcgetattr(&held).unwrap();
    settings.make_raw();
    rustix::termios::tcsetattr(&held, rustix::termios::OptionalActions::Now, &settings).unwrap();
    std::thread::spawn(move || {
        let _held = held;
        let (mut line, mut byte) = (String::new(), [0]);
        while master.read_exact(&mut byte).is_ok() {
            if byte[0] != b'\r' {
                line.push(char::from(byte[0]));
                continue;
            }
            if let Some(answer) = answer(&line) {
                master.write_all(format!("{answer}\r").as_bytes()).unwrap();
            }
            line.clear();
        }
    });
    path
}

#[track_caller]
fn order(path: &str, order: &[&str]) -> Ended {
    stepwright(&[order, &["--port", path]].concat())
}

#[test]
fn the_nano_slave_is_enough() {
    let mut slave = Slave::default();
    let path = play(move |line| Some(slave.answer(line)));
    let ended = order(&path, &["move", "40"]);
    ended.assert(0, "position 40 ready");
    assert!(ended.stdout.contains("lines       PO S5 T100 R200 G+40 E"), "{ended:?}");
    order(&path, &["move", "-50"]).assert(0, "position -10 ready");
    let status = order(&path, &["status"]);
    assert!(status.stdout.contains("knows the Nano slave's lines only"), "{status:?}");
    assert!(status.stdout.contains("position -10 ready"), "{status:?}");
    let ended = order(&path, &["move", "5", "--axis", "2"]);
    ended.assert_error("only one axis");
    let ended = order(&path, &["move", "5", "--start-speed", "55"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("refused s55");
    order(&path, &["position"]).assert(0, "position -10 ready");
    order(&path, &["stop"]).assert(0, "position -10 ready");
}

#[test]
fn one_that_is_silent_where_it_has_no_answer() {
    let mut slave = Slave::default();
    let path = play(move |line| Some(slave.answer(line)).filter(|answer| answer != "E"));
    order(&path, &["move", "40"]).assert(0, "position 40 ready");
}

/// As an Arduino that its port's opening has reset.
#[test]
fn one_that_takes_its_time_to_wake_up() {
    let (mut slave, mut lines) = (Slave::default(), 0);
    let path = play(move |line| {
        lines += 1;
        match lines {
            1..=6 => None,
            7 => Some("\nhello, this is a stepper controller\r\nR".to_owned()),
            _ => Some(slave.answer(line)),
        }
    });
    order(&path, &["move", "40"]).assert(0, "position 40 ready");
}

#[test]
fn one_whose_answer_to_e_is_lost() {
    let (mut slave, mut lost) = (Slave::default(), false);
    let path = play(move |line| {
        let answer = slave.answer(line);
        let lose = line == "E" && !std::mem::replace(&mut lost, line == "E");
        (!lose).then_some(answer)
    });
    order(&path, &["move", "40"]).assert(0, "position 40 ready");
}

#[test]
fn one_that_never_hears_an_e_is_not_moved_by_force() {
    let mut slave = Slave::default();
    let path = play(move |line| if line == "E" { None } else { Some(slave.answer(line)) });
    let ended = order(&path, &["move", "40"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("every attempt to give the order was spoiled");
    order(&path, &["position"]).assert(0, "position 0 ready");
}

#[test]
fn one_that_is_reset_on_the_way() {
    let (mut slave, mut asked) = (Slave::default(), 0);
    let path = play(move |line| {
        asked += usize::from(slave.target != 0);
        if asked == 5 {
            slave = Slave::default();
        }
        Some(slave.answer(line))
    });
    let ended = order(&path, &["move", "400"]);
    ended.assert(1, "position 0 stopped");
    ended.assert_error("the axis rests at 0, not at 400 as ordered");
}

#[test]
fn one_that_falls_silent_on_the_way() {
    let mut slave = Slave::default();
    let path = play(move |line| {
        let answer = slave.answer(line);
        (slave.position < 30).then_some(answer)
    });
    let ended = order(&path, &["move", "400"]);
    ended.assert(1, "position uncertain");
    ended.assert_error("lost the board on its way: the board does not answer");
}

#[test]
fn one_that_only_talks_nonsense() {
    let path = play(|_| Some("what?".to_owned()));
    let ended = order(&path, &["move", "400"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("no answer from");
}

/// A board that answers everything as an Uno's controller does: without S-curves, or one
/// with them whose `law` is 0, or one that is too old to say. The lines that it was told.
fn told(
    can: &'static str,
    law: &'static str,
) -> (String, std::sync::Arc<std::sync::Mutex<Vec<String>>>) {
    let lines = std::sync::Arc::new(std::sync::Mutex::new(Vec::new()));
    let kept = lines.clone();
    let path = play(move |line| {
        kept.lock().unwrap().push(line.to_owned());
        Some(match line {
            "?" => format!(
                "stepwright 0.1 axes=3 max=128000 late=0 refused=0 last=none uncertain=0{can}"
            ),
            "F" => "R".to_owned(),
            "V1" | "V2" | "V3" => "0".to_owned(),
            "$law" => law.to_owned(),
            _ if line.starts_with('j') && !can.contains("jerk") => "E".to_owned(),
            _ => "Y".to_owned(),
        })
    });
    (path, lines)
}

/// A jerk that would not be kept is refused before the order is given, with one hint.
#[test]
fn a_jerk_is_asked_only_of_a_board_that_bends_by_it() {
    let orders: [&[&str]; 3] = [&["move", "400"], &["run", "300"], &["line", "400", "-50"]];
    for words in orders {
        for (can, law, error, hint) in [
            (
                " can=none",
                "E",
                "has no S-curves, which --jerk asks for",
                "an Uno and a Nano have none",
            ),
            (
                " can=safety",
                "law=0",
                "has no S-curves, which --jerk asks for",
                "an Uno and a Nano have none",
            ),
            (" can=jerk", "law=0", "is 0: it would ignore --jerk", "settings set law=1 --port"),
        ] {
            let (path, lines) = told(can, law);
            let ended = order(&path, &[words, &["--jerk", "40000"]].concat());
            assert_eq!(ended.code(), Some(1), "{ended:?}");
            ended.assert_error(error);
            assert_eq!(ended.stderr.matches("hint: ").count(), 1, "{ended:?}");
            assert!(ended.stderr.contains(hint), "{ended:?}");
            // Neither a plan that would not be kept, nor a line of an order.
            assert_eq!(ended.stdout, "", "{ended:?}");
            let order_lines = ["PO", "E", "g+"];
            let said = lines.lock().unwrap().clone();
            assert!(!said.iter().any(|line| order_lines.contains(&line.as_str())), "{said:?}");
        }
    }
    // One that bends is told: with the setting, or without any settings.
    for law in ["law=1", "E"] {
        let (path, lines) = told(" can=jerk", law);
        order(&path, &["move", "0", "--jerk", "40000"]).assert(0, "position 0 ready");
        assert!(lines.lock().unwrap().iter().any(|line| line == "j40000"));
    }
    // And without a jerk nobody is asked for it.
    let (path, lines) = told(" can=none", "E");
    order(&path, &["move", "0"]).assert(0, "position 0 ready");
    assert!(!lines.lock().unwrap().iter().any(|line| line.starts_with('$')));
}

/// An Uno grants no lease, nor does a board that is too old to say: refused before the order
/// is given, with one hint.
#[test]
fn a_lease_is_asked_only_of_a_board_that_grants_it() {
    for can in [" can=none", " can=jerk", ""] {
        for words in [&["move", "400"][..], &["run", "300"]] {
            let (path, lines) = told(can, "E");
            let ended = order(&path, &[words, &["--lease", "700ms"]].concat());
            assert_eq!((ended.code(), ended.stdout.as_str()), (Some(1), ""), "{ended:?}");
            ended.assert_error("grants no lease, which --lease asks for");
            assert_eq!(ended.stderr.matches("hint: ").count(), 1, "{ended:?}");
            assert!(ended.stderr.contains("set timeout-ms=700 --port"), "{ended:?}");
            let said = lines.lock().unwrap().clone();
            assert!(!said.iter().any(|line| line.starts_with('L') || line == "PO"), "{said:?}");
        }
    }
    let (path, lines) = told(" can=safety", "E");
    order(&path, &["move", "0", "--lease", "700ms"]).assert(0, "position 0 ready");
    let said = lines.lock().unwrap().clone();
    let leases = said.iter().filter(|line| line.starts_with('L')).collect::<Vec<_>>();
    assert_eq!(leases, ["L700", "L0"]);
}

/// A board whose switch stops the axis on its way: the reason is in the last line, in the
/// error, in `status` and for programs.
#[test]
fn the_reason_of_a_stop_is_said() {
    let board = |position: &'static str, stops: &'static str| {
        play(move |line| {
            Some(match line {
                "?" => format!(
                    "stepwright 0.1 axes=3 max=128000 late=0 refused=0 last=none uncertain=0 \
                     stop={stops} can=none"
                ),
                "F" => "R".to_owned(),
                "V1" => position.to_owned(),
                "V2" | "V3" => "0".to_owned(),
                _ => "Y".to_owned(),
            })
        })
    };
    let ended = order(&board("70", "S-T"), &["status"]);
    assert!(ended.stdout.contains("position 70 ready, stopped by its limit switch\n"), "{ended:?}");
    assert!(ended.stdout.contains("axis 2      position 0 ready\n"), "{ended:?}");
    assert!(ended.stdout.contains("stopped by the silence of the host\n"), "{ended:?}");
    let ended = order(&board("70", "S-T"), &["status", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    let stops = [0, 1, 2].map(|n| json["axes"][n]["stop"].clone());
    assert_eq!(stops, ["switch".into(), serde_json::Value::Null, "timeout".into()]);

    // Of a board that keeps its errors, those are told too.
    let ended = order(&board("70", "S-T errors=STl"), &["status"]);
    let row = "faults      a limit switch, the silence of the host, late steps since the last !\n";
    assert!(ended.stdout.contains(row), "{ended:?}");
    let ended = order(&board("70", "--- errors=c"), &["status", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(json["board"]["errors"], serde_json::json!(["sum"]));
    let ended = order(&board("70", "---"), &["status", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert!(json["board"]["errors"].is_null(), "{ended:?}");

    // It was ordered to 470 and rests where it was.
    let ended = order(&board("70", "S--"), &["move", "400"]);
    ended.assert(1, "position 70 stopped by its limit switch");
    ended.assert_error("stopped at 70, 400 steps before 470, by its limit switch");
    let ended = order(&board("70", "S--"), &["move", "400", "--format", "json"]);
    assert!(ended.stdout.contains(r#""stop":"switch""#), "{ended:?}");
    let ended = order(&board("70", "T--"), &["run", "400"]);
    ended.assert(1, "position 70 stopped by the silence of the host");
    ended.assert_error("the axis was stopped by the silence of the host");
    let ended = order(&board("0", "-S-"), &["line", "400", "50"]);
    ended.assert_error("axis 2 was stopped by its limit switch");
    // One that does not say is asked no more than that.
    order(&board("70", "---"), &["move", "400"]).assert(1, "position 70 stopped");
}
