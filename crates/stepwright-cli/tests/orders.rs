//! `move` and `run` on the virtual board, and what every order refuses.

use crate::common::{Scratch, stepwright, stepwright_with};

#[test]
fn a_move_shows_what_it_understood_and_ends_where_it_was_ordered() {
    let ended = stepwright(&["move", "4000", "--fast"]);
    assert_eq!(
        ended.stdout,
        "\
axis 1 by +4000 steps on the virtual board
  start speed 50 steps/s
  top speed   1000 steps/s
  ramp up     200 steps (2494 steps/s²)
  ramp down   200 steps (2494 steps/s²)
  takes       4.361 s
  lines       PO S5 T100 R200 G+4000 E
position 4000 ready
"
    );
    assert_eq!((ended.code(), ended.stderr.as_str()), (Some(0), ""));
}

#[test]
fn a_line_shows_what_each_axis_does_and_ends_where_it_was_ordered() {
    let ended = stepwright(&[
        "line",
        "4001",
        "-2001",
        "0",
        "--fast",
        "--start-speed",
        "0",
        "--accel",
        "8000",
    ]);
    assert_eq!(
        ended.stdout,
        "\
line of +4001 -2001 +0 steps on the virtual board
  start speed 0 steps/s
  top speed   1000 steps/s
  ramp up     8000 steps/s² (62 steps)
  ramp down   8000 steps/s² (62 steps)
  takes       4.125 s
  lines       PO s0 T100 a8000 d8000 G+4001 A2 s0 T50 a4000 d4000 G-2001 E
position 4001 -2001 0 ready
"
    );
    assert_eq!((ended.code(), ended.stderr.as_str()), (Some(0), ""));
}

#[test]
fn lines_that_can_not_be_are_refused_and_shares_that_are_rounded_said() {
    stepwright(&["line", "1", "2", "3", "--fast"]).assert(0, "position 1 2 3 ready");
    stepwright(&["line", "0", "--fast"]).assert(0, "position 0 ready");
    stepwright(&["line", "9", "9", "--top-speed", "5", "--fast"]).assert(0, "position 9 9 ready");
    // Ramps that differ from the line's are made up for by the top speed.
    for line in [["2000", "5"], ["10000", "51"], ["20000", "200"]] {
        let ended = stepwright(&[&["line", "--fast", "--accel", "100"], &line[..]].concat());
        ended.assert(0, &format!("position {} {} ready", line[0], line[1]));
        let within = ended.stderr.split("the axes end within ").nth(1);
        assert!(within.is_none_or(|time| time.starts_with("0.00")), "{ended:?}");
    }
    // Axes that can't be kept on the line end together, and how far off they are is said.
    let far = ["line", "10000", "9000", "--top-speed", "9000", "--accel", "1", "--fast"];
    let ended = stepwright(&far);
    ended.assert(0, "position 10000 9000 ready");
    assert!(ended.stderr.contains("the axes leave the line by up to "), "{ended:?}");
    // What can't be is refused with a value that can.
    let long = ["line", "100000", "4000", "--top-speed", "5000", "--fast"];
    let gentle = stepwright(&[&long[..], &["--accel", "10"]].concat());
    assert_eq!(gentle.code(), Some(1));
    gentle.assert_error("axis 2: its share of the acceleration");
    let hint = gentle.stderr.rsplit_once("--accel ").expect("a value").1;
    let accel = hint.split_whitespace().next().unwrap();
    let ended = stepwright(&[&long[..], &["--accel", accel]].concat());
    ended.assert(0, "position 100000 4000 ready");
    assert_eq!(stepwright(&["line", "1", "2", "3", "4", "--fast"]).code(), Some(1));
    assert_eq!(stepwright(&["line", "--fast"]).code(), Some(2));
}

/// Two or three axes at once can't have as steep ramps as one; with a limit of jerk still less.
#[test]
fn the_default_ramp_of_a_line_is_taken() {
    for (line, ready) in [
        ("20000 20000 20000 --top-speed 20000", "20000 20000 20000"),
        ("4000 4000 4000 --jerk 10000", "4000 4000 4000"),
        ("9000 -9000 --jerk 50000 --top-speed 4000", "9000 -9000"),
    ] {
        let words: Vec<_> = format!("line {line} --fast").split(' ').map(str::to_owned).collect();
        stepwright(&words).assert(0, &format!("position {ready} ready"));
    }
    // One axis has the ramp of a move.
    let ended = stepwright(&["line", "20000", "0", "0", "--top-speed", "20000", "--fast"]);
    assert!(ended.stdout.contains("ramp up     50000 steps/s²"), "{ended:?}");
}

#[test]
fn backward_far_and_nowhere() {
    stepwright(&["move", "-4000", "--fast"]).assert(0, "position -4000 ready");
    stepwright(&["move", "--fast", "--", "-4000"]).assert(0, "position -4000 ready");
    stepwright(&["move", "+3", "--fast", "--axis", "3"]).assert(0, "position 3 ready");
    stepwright(&["move", "0", "--fast"]).assert(0, "position 0 ready");
    let far = ["move", "90000", "--fast", "--top-speed", "90000", "--accel", "500000"];
    stepwright(&far).assert(0, "position 90000 ready");
}

#[test]
fn in_real_time_by_default() {
    let begin = std::time::Instant::now();
    let ended = stepwright(&["move", "-300", "--accel", "5000"]);
    ended.assert(0, "position -300 ready");
    // 0.38 s to 1000 steps/s and back over 200 steps, and 100 steps at it.
    assert!(begin.elapsed().as_secs_f64() > 0.45, "{:?}", begin.elapsed());
}

#[test]
fn units_are_converted_and_what_is_sent_is_shown() {
    let ended = stepwright(&[
        "move",
        "400",
        "--fast",
        "--top-speed",
        "120rpm",
        "--start-speed",
        "1.2mm/s",
        "--accel",
        "100rad/s2",
        "--decel",
        "9000",
        "--steps-per-rev",
        "400",
        "--mm-per-rev",
        "8",
    ]);
    ended.assert(0, "position 400 ready");
    for row in [
        "  start speed 1.2mm/s → 60 steps/s\n",
        "  top speed   120rpm → 800 steps/s\n",
        "  ramp up     100rad/s2 ≈ 6366.198 steps/s², sent as 6366 (50 steps)\n",
        "  ramp down   9000 steps/s² (35 steps)\n",
        "  lines       PO S6 T80 a6366 d9000 G+400 E\n",
    ] {
        assert!(ended.stdout.contains(row), "{row} in {}", ended.stdout);
    }
}

#[test]
fn json_is_one_line() {
    let ended = stepwright(&["move", "-40", "--fast", "--axis", "2", "--format", "json"]);
    assert_eq!((ended.code(), ended.stdout.lines().count()), (Some(0), 1), "{ended:?}");
    let result: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(result["position"], -40);
    assert_eq!(result["target"], -40);
    assert_eq!(result["state"], "ready");
    assert_eq!(result["axis"], 2);
    assert_eq!(result["late"], 0);
    assert_eq!(result["lines"][6], "G-40");
    assert_eq!(result["motion"]["top_speed"], 1000.0);
}

#[test]
fn what_is_too_fast_is_refused_with_the_reason() {
    let ended = stepwright(&["move", "99999", "--fast", "--top-speed", "200000", "--ramp", "1"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("refused E: faster than the board can step: lower the top speed");
    assert!(ended.stderr.contains("at most 128000 steps/s"), "{ended:?}");
    assert!(!ended.last_line().starts_with("position"), "{ended:?}");
}

#[test]
fn what_makes_no_sense_is_a_usage_error() {
    for args in [
        &["move"][..],
        &["move", "far"],
        &["move", "1.5"],
        &["move", "2147483648"],
        &["move", "-2147483649"],
        &["move", "10", "--ramp", "0"],
        &["move", "10", "--ramp", "1000"],
        &["move", "10", "--ramp", "10", "--accel", "10"],
        &["move", "10", "--axis", "0"],
        &["move", "10", "--axis", "9"],
        &["move", "10", "--top-speed", "fast"],
        &["move", "10", "--top-speed", "10mm/s"],
        &["move", "10", "--baud", "9600"],
        &["move", "10", "--fast", "--port", "/dev/null"],
        &["run", "fast"],
        &["run", "10", "--for", "soon"],
        &["board"],
        &["board", "--stdio", "--pty"],
        &["send"],
    ] {
        let ended = stepwright(args);
        assert_eq!(ended.code(), Some(2), "{args:?} {ended:?}");
        assert!(ended.stderr.starts_with("error: "), "{args:?} {ended:?}");
    }
}

#[test]
fn values_out_of_range_say_what_is_allowed() {
    let ended = stepwright(&["move", "10", "--top-speed", "0"]);
    assert_eq!(ended.code(), Some(2), "{ended:?}");
    ended.assert_error("--top-speed must be 0.001 to 1,000,000 steps/s, not 0");
    let ended = stepwright(&["move", "10", "--axis", "4"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("no axis 4");
    assert!(ended.stderr.contains("1 to 3"), "{ended:?}");
}

#[test]
fn a_run_for_a_time_brakes_and_is_done() {
    // 3 s in all but the two ramps, at 400 steps/s.
    let ended = stepwright(&["run", "-120rpm", "--for", "3s", "--fast", "--ramp", "40"]);
    let position =
        ended.last_line().strip_prefix("position -").and_then(|s| s.strip_suffix(" ready"));
    let position: i64 =
        position.and_then(|s| s.parse().ok()).unwrap_or_else(|| panic!("{ended:?}"));
    assert!((1180..=1220).contains(&position), "{ended:?}");
    assert_eq!(ended.code(), Some(0));
    let twice = stepwright(&["run", "-120rpm", "--for", "3s", "--fast", "--ramp", "40"]);
    assert_eq!(twice.stdout, ended.stdout);
    stepwright(&["run", "+7", "--for", "0s", "--fast"]).code();
}

#[test]
fn orders_to_a_board_that_stays_ask_for_it() {
    for order in ["stop", "kill", "status", "position", "zero"] {
        let ended = stepwright(&[order]);
        assert_eq!(ended.code(), Some(2), "{ended:?}");
        ended.assert_error("needs a board: --port PATH");
        assert!(ended.stderr.contains("stepwright board --pty"), "{ended:?}");
    }
    let ended = stepwright(&["send", "F"]);
    assert_eq!(ended.code(), Some(2), "{ended:?}");
}

#[test]
fn edges_are_recorded() {
    let file = Scratch::new("move.vcd");
    stepwright(&["move", "-40", "--fast", "--vcd", file.path()]).assert(0, "position -40 ready");
    let dump = std::fs::read_to_string(&file.0).unwrap();
    assert_eq!(dump.lines().filter(|line| *line == "1a").count(), 40);
    assert!(dump.contains("0b\n"), "backward");
    let ended = stepwright(&["move", "40", "--fast", "--vcd", "/nowhere/at/all.vcd"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("can't write /nowhere/at/all.vcd");
}

/// Another reader finds each step at its time, of a move and of cycles.
#[test]
fn edges_are_recorded_as_mcap() {
    let (file, dump) = (Scratch::new("move.mcap"), Scratch::new("beside.vcd"));
    let both = ["move", "40", "--fast", "--mcap", file.path(), "--vcd", dump.path()];
    stepwright(&both).assert(0, "position 40 ready");
    let bytes = std::fs::read(&file.0).unwrap();
    let messages: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
    let high = messages.iter().filter(|one| *one.data == *br#"{"level":1}"#);
    let rises: Vec<u64> =
        high.filter(|one| one.channel.topic == "/step1").map(|one| one.log_time).collect();
    // The dump has them in units of 100 ps.
    let mut time = 0;
    let mut right = Vec::new();
    for line in std::fs::read_to_string(&dump.0).unwrap().lines() {
        match line.strip_prefix('#') {
            Some(units) => time = units.parse::<u64>().unwrap() / 10,
            None if line == "1a" => right.push(time),
            None => {}
        }
    }
    assert_eq!((rises.len(), &rises), (40, &right));
    // And at each step where the axis is and how fast, at the end at rest.
    let motion: Vec<_> = messages.iter().filter(|one| one.channel.topic == "/axis1").collect();
    let number = |n: usize, name: &str| {
        let told: serde_json::Value = serde_json::from_slice(&motion[n].data).unwrap();
        told[name].as_f64().unwrap()
    };
    assert_eq!(motion.len(), 41);
    assert!((0..40).all(|n| motion[n].log_time == rises[n]));
    assert!((0..40).all(|n| number(n, "position") == n as f64 + 1.0));
    assert_eq!((number(40, "position"), number(40, "speed")), (40.0, 0.0));
    let speed = 1e9 / (rises[20] - rises[19]) as f64;
    assert!((number(20, "speed") - speed).abs() < 0.001, "{speed}");
    let cycle = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/cycles/series.toml");
    let file = Scratch::new("cycle.mcap");
    assert_eq!(stepwright(&["cycle", cycle, "--mcap", file.path()]).code(), Some(0));
    let bytes = std::fs::read(&file.0).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let topics: Vec<_> = summary.channels.values().map(|one| one.topic.as_str()).collect();
    assert!(topics.contains(&"/step1") && topics.contains(&"/max1"), "{topics:?}");
    assert!(topics.contains(&"/axis1"), "{topics:?}");
    let ended = stepwright(&["move", "40", "--fast", "--mcap", "/nowhere/at/all.mcap"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("can't write /nowhere/at/all.mcap");
}

/// A pipe takes what a file takes.
#[test]
fn recordings_go_into_pipes() {
    for (option, name) in
        [("--vcd", "edges.vcd"), ("--mcap", "edges.mcap"), ("--plot", "edges.svg")]
    {
        let (file, pipe) = (Scratch::new(name), Scratch::new(&format!("pipe-{name}")));
        let made = std::process::Command::new("mkfifo").arg(pipe.path()).status();
        assert!(made.unwrap().success());
        let from = pipe.0.clone();
        let reader = std::thread::spawn(move || std::fs::read(from).unwrap());
        for path in [file.path(), pipe.path()] {
            stepwright(&["move", "400", "--fast", option, path]).assert(0, "position 400 ready");
        }
        assert!(reader.join().unwrap() == std::fs::read(&file.0).unwrap(), "{option}");
    }
}

/// The shaft is followed by its coils: it is on the switch when the board says so.
#[test]
fn a_motor_on_coils_goes_where_it_is_sent() {
    let (dump, plot) = (Scratch::new("coils.vcd"), Scratch::new("coils.svg"));
    let script = b"$switches=1\rPO\rS5\rT500\ra9000\rd9000\rG-400\rE\r";
    let args = ["board", "--stdio", "--fast", "--drive", "1:unipolar-half", "--switch", "1:-30"];
    let files = ["--vcd", dump.path(), "--plot", plot.path()];
    let ended = stepwright_with(&[&args[..], &files].concat(), script);
    let dump = std::fs::read_to_string(&dump.0).unwrap();
    assert!(dump.contains(" coil1d $end") && !dump.contains("step1"), "{dump:.400}");
    // A half step changes one line.
    let edges = dump.split("$end\n").last().unwrap().lines();
    let steps = edges.filter(|line| ["0w0", "1w0"].iter().any(|begin| line.starts_with(begin)));
    assert_eq!((steps.count(), ended.stderr.contains("position -30 ready")), (30, true));
    assert!(std::fs::read_to_string(&plot.0).unwrap().starts_with("<svg"));
    let ended = stepwright(&["board", "--stdio", "--drive", "1:servo"]);
    assert_eq!(ended.code(), Some(2), "{ended:?}");
    ended.assert_error("unipolar-half");
}

#[test]
fn the_speed_is_drawn() {
    let file = Scratch::new("move.svg");
    let ended = stepwright(&["move", "400", "--fast", "--plot", file.path()]);
    ended.assert(0, "position 400 ready");
    let drawn = std::fs::read_to_string(&file.0).unwrap();
    assert!(drawn.starts_with("<svg") && drawn.contains("Axis 1 by +400 steps"), "{drawn:.300}");
    let ended = stepwright(&["move", "40", "--fast", "--plot", "/nowhere/at/all.png"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("can't write /nowhere/at/all.png");
    assert_eq!(stepwright(&["move", "40", "--plot", "x.pdf"]).code(), Some(2));
}

#[test]
fn ports_are_listed_or_not() {
    let ended = stepwright(&["ports"]);
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    assert!(!ended.stdout.is_empty() || ended.stderr.contains("board --pty"), "{ended:?}");
    let ended = stepwright(&["ports", "--format", "json"]);
    let ports: Vec<String> = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(ports.is_empty(), stepwright(&["ports"]).stdout.is_empty());
}

/// What went wrong is for programs, too, where the result would be.
#[test]
fn a_failure_is_json_where_the_result_would_be() {
    for (args, code, part) in [
        (&["move", "10mm", "--format", "json"][..], 2, r#"{"error":"DISTANCE 10mm: millimetres"#),
        (&["move", "10", "--top-speed", "x", "--format=json"], 2, "invalid value 'x' for"),
        (&["move", "10", "--port", "/nonexistent", "--format", "json"], 1, "no port /nonexistent"),
        (&["plan", "circle", "--format", "json"], 2, "unrecognized subcommand"),
    ] {
        let ended = stepwright(args);
        assert_eq!((ended.code(), ended.stdout.as_str()), (Some(code), ""), "{ended:#?}");
        let last = ended.stderr.lines().last().unwrap();
        assert!(last.contains(part), "{last}");
        let said: serde_json::Value = serde_json::from_str(last).unwrap();
        assert_eq!(said["status"], code, "{last}");
        assert!(said["hint"].is_string() && said["error"].is_string(), "{last}");
    }
}
