//! The machine file: what it says holds where nothing is typed, and nowhere else.

use crate::common::{Ended, Running, Scratch, stepwright, stepwright_with};

const MILL: &str = "\
# The mill in the corner.
[axis.1]
steps-per-rev = 3200
mm-per-rev = 8
top-speed = \"40mm/s\"
accel = \"200mm/s2\" # as it was tried

[axis.2]
steps-per-rev = 400
";

fn file(name: &str, text: &str) -> Scratch {
    let file = Scratch::new(name);
    std::fs::write(&file.0, text).unwrap();
    file
}

fn on(file: &Scratch, args: &[&str]) -> Ended {
    stepwright(&[args, &["--machine", file.path()]].concat())
}

#[test]
fn what_is_not_typed_is_the_machines() {
    let mill = file("mill.toml", MILL);
    let ended = on(&mill, &["move", "10mm", "--fast"]);
    ended.assert(0, "position 4000 ready");
    assert!(ended.stdout.contains("t16000 a80000 d80000 G+4000 E"), "{ended:#?}");
    assert!(ended.stderr.contains("machine: "), "{ended:#?}");
    // Another axis is another motor.
    let ended = on(&mill, &["move", "1turns", "--axis", "2", "--fast"]);
    ended.assert(0, "position 400 ready");
    // One that the file does not know has the command's own defaults.
    on(&mill, &["move", "1turns", "--axis", "3", "--fast"]).assert(0, "position 200 ready");
}

/// Austin's laws have no start speed, no ramp in steps and no jerk.
#[test]
fn a_law_takes_from_the_file_what_it_has() {
    let text = "[axis.1]\nstart-speed = 20\nramp = 90\njerk = 5000\ntop-speed = 400\n";
    let mill = file("law.toml", text);
    let ended = on(&mill, &["move", "100", "--law", "austin", "--fast"]);
    ended.assert(0, "position 100 ready");
    assert!(ended.stdout.contains("  top speed   400 steps/s"), "{ended:#?}");
    let ended = on(&mill, &["move", "100", "--law", "s-curve", "--fast"]);
    assert!(ended.stdout.contains(" S2 T40 R90 j5000 G+100 "), "{ended:#?}");
}

#[test]
fn what_is_typed_wins() {
    let mill = file("typed.toml", MILL);
    let ended = on(&mill, &["move", "10mm", "--fast", "--mm-per-rev", "4"]);
    ended.assert(0, "position 8000 ready");
    // A ramp by its length replaces the file's acceleration.
    let ended = on(&mill, &["move", "10mm", "--fast", "--ramp", "100"]);
    assert!(ended.stdout.contains("  ramp up     100 steps"), "{ended:#?}");
    // And no file is none.
    let ended = stepwright(&["--machine", "none", "move", "10mm", "--fast"]);
    ended.assert_error("millimetres need");
}

#[test]
fn a_line_has_what_its_axes_have_in_common() {
    let same = file("same.toml", "[axis.1]\nmm-per-rev = 8\n[axis.2]\nmm-per-rev = 8.0\n");
    on(&same, &["line", "8mm", "16mm", "--fast"]).assert(0, "position 200 400 ready");
    let mill = file("differ.toml", MILL);
    on(&mill, &["line", "8mm", "16mm", "--fast"]).assert_error("millimetres need");
}

/// Two drivers with other microsteps.
const UNLIKE: &str = "\
[axis.1]
steps-per-rev = 3200
mm-per-rev = 8
[axis.2]
steps-per-rev = 1600
mm-per-rev = 8
";

#[test]
fn each_axis_of_a_line_is_built_as_the_file_says() {
    let unlike = file("unlike.toml", UNLIKE);
    let line = |words: &[&str]| on(&unlike, &[&["line"], words, &["--fast"]].concat());
    let ended = line(&["8mm", "8mm"]);
    ended.assert(0, "position 3200 1600 ready");
    assert!(ended.stderr.contains("machine: "), "{ended:#?}");
    line(&["90deg", "90deg"]).assert(0, "position 800 400 ready");
    line(&["--to", "8mm", "-4mm"]).assert(0, "position 3200 -800 ready");
    // What is typed holds for both.
    line(&["8mm", "8mm", "--mm-per-rev", "4"]).assert(0, "position 6400 3200 ready");
    line(&["90deg", "90deg", "--steps-per-rev", "400"]).assert(0, "position 100 100 ready");
    // The speed is that of the axis that goes furthest, which is not always the first.
    let slow = line(&["1mm", "8mm", "--top-speed", "4mm/s"]);
    assert!(slow.stdout.contains("4mm/s → 800 steps/s"), "{slow:#?}");
    let said = line(&["8mm", "-4mm", "--format", "json"]);
    let shown: serde_json::Value = serde_json::from_str(said.stdout.trim()).unwrap();
    let shown = &shown["in_unit"];
    assert_eq!((&shown["unit"], &shown["position"]), (&"mm".into(), &vec![8.0, -4.0].into()));
    assert_eq!(shown["distance"], serde_json::json!([8.0, -4.0]));
    // Millimetres of one, degrees of the other: what they count in is no number for both.
    let mill = file("both.toml", "[axis.1]\nmm-per-rev = 8\n[axis.2]\nsteps-per-rev = 400\n");
    let said = on(&mill, &["line", "8mm", "90deg", "--fast", "--format", "json"]);
    let shown: serde_json::Value = serde_json::from_str(said.stdout.trim()).unwrap();
    assert_eq!(shown["position"], serde_json::json!([200, 100]));
    assert!(shown.get("in_unit").is_none(), "{shown}");
}

/// A plan has no axis, and so no motor where they differ.
#[test]
fn a_plan_asks_which_motor_is_meant() {
    let unlike = file("unlike-plan.toml", UNLIKE);
    let plan =
        |words: &[&str]| on(&unlike, &[&["plan", "trapezoid", "--accel", "4000"], words].concat());
    for word in ["--top-speed=40mm/s", "--top-speed=120rpm"] {
        let ended = plan(&["--steps", "1000", word]);
        ended.assert_error("a turn of the axes in");
        assert!(ended.stderr.contains("--steps-per-rev"), "{ended:#?}");
        let ended = plan(&["--steps", "1000", word, "--mm-per-rev", "8"]);
        ended.assert_error("a turn of the axes in");
    }
    plan(&["--top-speed", "500", "--steps", "8", "mm"]).assert_error("8mm: a turn of the axes in");
    let own = ["--top-speed", "40mm/s", "--steps-per-rev", "3200", "--mm-per-rev", "8"];
    assert_eq!(plan(&[&["--steps", "1000"], &own[..]].concat()).code(), Some(0));
    assert_eq!(plan(&["--steps", "1000", "--top-speed", "500"]).code(), Some(0));
}

#[test]
fn the_port_is_the_machines_unless_a_virtual_board_is_asked_for() {
    let real = file("real.toml", "port = \"/nonexistent/board\"\n");
    on(&real, &["move", "10"]).assert_error("/nonexistent/board");
    on(&real, &["status"]).assert_error("/nonexistent/board");
    on(&real, &["move", "10", "--virtual"]).assert(0, "position 10 ready");
    on(&real, &["move", "10", "--fast"]).assert(0, "position 10 ready");
    let file = Scratch::new("virtual.mcap");
    on(&real, &["move", "10", "--mcap", file.path()]).assert(0, "position 10 ready");
    // What only a virtual machine has.
    for own in [["--switch", "1:-30"], ["--drive", "1:bridge"]] {
        let serve = ["serve", "--machine", real.path(), "--bind", "127.0.0.1:0"];
        let mut served = Running::start(&[&serve[..], &own].concat());
        served.wait_out("page ");
    }
}

#[test]
fn a_motor_that_is_left_alone_has_no_lease_of_the_machines() {
    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
    let leased = file("leased.toml", &format!("port = \"{port}\"\nlease = \"300ms\"\n"));
    for order in [&["run", "200"][..], &["move", "100000"]] {
        let ended = on(&leased, &[order, &["--detach"]].concat());
        assert!(ended.last_line().ends_with(" busy"), "{ended:#?}");
        std::thread::sleep(std::time::Duration::from_millis(1200));
        let ended = on(&leased, &["position"]);
        assert!(ended.last_line().ends_with(" busy"), "{ended:#?}");
        assert_eq!(on(&leased, &["stop"]).code(), Some(0));
    }
}

#[test]
fn a_mistake_is_said_with_its_line_and_nothing_moves() {
    let wrong = file("wrong.toml", "[axis.1]\ntop-speed = \"40mph\"\n");
    let ended = on(&wrong, &["move", "10", "--fast"]);
    ended.assert(1, "");
    ended.assert_error("wrong.toml:2: top-speed = '40mph': ");
    let gone = Scratch::new("no-such-machine.toml");
    on(&gone, &["move", "10", "--fast"]).assert_error("can't read");
    // What needs no machine doesn't read it.
    on(&wrong, &["calc", "belt", "--help"])
        .assert(0, on(&wrong, &["calc", "belt", "--help"]).last_line());
}

#[test]
fn init_asks_until_the_answer_is_right() {
    let new = Scratch::new("new.toml");
    let args = ["init", "--file", new.path()];
    let ended = stepwright_with(&args, b"\n3200\n8\n40mph\n40\n40mm/s\n\n");
    ended.assert(0, &format!("{} has axis 1", new.path()));
    assert!(ended.stderr.contains("40mph"), "{ended:#?}");
    assert!(ended.stderr.contains("write 40mm/s, or 40steps/s"), "{ended:#?}");
    let text = std::fs::read_to_string(&new.0).unwrap();
    assert_eq!(text, "[axis.1]\nsteps-per-rev = 3200\nmm-per-rev = 8\ntop-speed = \"40mm/s\"\n");
    on(&new, &["move", "10mm", "--fast"]).assert(0, "position 4000 ready");
    // An end in the middle leaves everything as it was.
    let ended = stepwright_with(&args, b"\n400\n");
    ended.assert(1, "");
    ended.assert_error("no more answers");
    assert_eq!(std::fs::read_to_string(&new.0).unwrap(), text);
}

#[test]
fn init_keeps_what_it_is_not_told_of() {
    let mill = file("kept.toml", MILL);
    let at = mill.path();
    stepwright(&["init", "--file", at, "--axis", "2", "--top-speed", "500"])
        .assert(0, &format!("{at} has axis 2"));
    assert_eq!(std::fs::read_to_string(&mill.0).unwrap(), format!("{MILL}top-speed = 500\n"));
    let ended = stepwright(&["init", "--file", at, "--axis", "3", "--mm-per-rev", "0"]);
    ended.assert_error("--mm-per-rev '0': a turn moves the load by 0.000001 to ");
    assert_eq!(ended.code(), Some(2), "{ended:?}");
    let kept = std::fs::read_to_string(&mill.0).unwrap();
    assert_eq!(kept, format!("{MILL}top-speed = 500\n"));
    // In braces, too; and what is no machine's file stays as it is.
    let braces = file("braces.toml", "axis = { 1 = { ramp = 100 } }\n");
    let args = ["init", "--file", braces.path(), "--top-speed", "500"];
    assert_eq!(stepwright(&args).code(), Some(0));
    on(&braces, &["move", "10", "--fast"]).assert(0, "position 10 ready");
    let other = file("other.toml", "axis = 3\n");
    stepwright(&["init", "--file", other.path(), "--top-speed", "5"]).assert_error("other.toml:1");
    assert_eq!(std::fs::read_to_string(&other.0).unwrap(), "axis = 3\n");
}

/// 20 on an axis of millimetres: the answer says which of the two it may be.
#[test]
fn init_takes_no_bare_speed_of_an_axis_with_millimetres() {
    let new = Scratch::new("bare.toml");
    let init = |options: &[&str]| stepwright(&[&["init", "--file", new.path()], options].concat());
    let ended = init(&["--mm-per-rev", "8", "--top-speed", "20"]);
    ended.assert(2, "");
    ended.assert_error("--top-speed 20: mm/s or steps/s? write 20mm/s, or 20steps/s");
    let ended = init(&["--mm-per-rev", "8", "--accel", "20"]);
    ended.assert_error("--accel 20: mm/s2 or steps/s2? write 20mm/s2, or 20steps/s2");
    assert!(!new.0.exists());
    assert_eq!(init(&["--mm-per-rev", "8", "--top-speed", "20steps/s"]).code(), Some(0));
    assert_eq!(init(&["--axis", "2", "--top-speed", "20"]).code(), Some(0));
    // The file's own millimetres count.
    init(&["--accel", "20"]).assert_error("--accel 20: mm/s2 or steps/s2?");
}
