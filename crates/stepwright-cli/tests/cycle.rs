//! `stepwright cycle`: the examples, and files with a mistake.

use crate::common::{Scratch, stepwright};

fn example(name: &str) -> String {
    format!("{}/../../examples/cycles/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// The positions of a line of the list.
fn positions(line: &str) -> Vec<i64> {
    line.split(", ").map(|part| part.split_once(".pos=").unwrap().1.parse().unwrap()).collect()
}

/// stepper_h's listing: 21 lines, X by 999 to 1001 steps a line, the last
/// exact.
#[test]
fn the_example_of_the_readme_prints_its_lines() {
    let ended = stepwright(&["cycle", &example("readme")]);
    ended.assert(0, "X.pos=150000000, Y.pos=75000000, Z.pos=7500000");
    let lines: Vec<_> = ended.stdout.lines().map(positions).collect();
    assert_eq!(lines.len(), 21);
    for pair in lines.windows(2) {
        let steps = (pair[1][0] - pair[0][0]) / 7_500;
        assert!((999..=1_001).contains(&steps), "{pair:?}");
    }
}

/// Every second while motors move, every ten while none does.
#[test]
fn a_triangle_ends_where_it_began() {
    let svg = Scratch::new("cycle-triangle.svg");
    let ended = stepwright(&["cycle", &example("triangle"), "--xy", svg.path()]);
    ended.assert(0, "X.pos=0, Y.pos=0, Z.pos=0");
    let lines: Vec<_> = ended.stdout.lines().map(positions).collect();
    // 0 to 53 s, and two of the 25 s that it stands still.
    assert_eq!(lines.len(), 54 + 2);
    assert_eq!(lines[20], [150_000_000, 49_995_000, 19_995_000]);
    let svg = std::fs::read_to_string(svg.path()).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("X, mm"));
}

#[test]
fn calibrations_find_the_switches() {
    let ended = stepwright(&["cycle", &example("calibrate"), "--format", "json"]);
    assert_eq!(ended.code(), Some(0));
    let all: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    let motor = &all["motors"][0];
    assert_eq!((&motor["min"], &motor["max"]), (&0.into(), &207_500_000.into()));
    assert_eq!((&motor["position"], &motor["faults"]), (&207_500_000.into(), &8.into()));
}

/// A row for each event, in the order of time; the steps add up.
#[test]
fn csv_has_a_row_for_each_event() {
    let ended = stepwright(&["cycle", &example("series"), "--format", "csv"]);
    assert_eq!(ended.code(), Some(0));
    let mut lines = ended.stdout.lines();
    assert_eq!(lines.next(), Some("time_us,motor,event,value,position"));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let mut last = 0.0;
    for row in &rows {
        assert_eq!(row.len(), 5, "{row:?}");
        let time: f64 = row[0].parse().unwrap();
        assert!(time >= last, "{row:?}");
        last = time;
    }
    let steps = |motor: &str| {
        let (mut forward, mut at) = (true, 0i64);
        for row in rows.iter().filter(|row| row[1] == motor) {
            match (row[2], row[3]) {
                ("dir", level) => forward = level == "1",
                ("step", "1") => at += if forward { 1 } else { -1 },
                ("step", "0") => assert_eq!(row[4].parse(), Ok(at), "{row:?}"),
                _ => {}
            }
        }
        at
    };
    assert_eq!(["list", "series", "callback", "bounded"].map(steps), [700, 0, 800, 300]);
    let has =
        |motor, event, value| rows.iter().any(|r| (r[1], r[2], r[3]) == (motor, event, value));
    assert!(has("bounded", "fault", "soft-end-max") && has("", "cycle", "pause"));
    assert!(
        rows.iter().all(|row| !(705_000.0..900_000.0).contains(&row[0].parse::<f64>().unwrap()))
    );
}

#[test]
fn plots_and_dumps_are_written() {
    let (png, vcd) = (Scratch::new("cycle-speed.png"), Scratch::new("cycle-edges.vcd"));
    let series = example("series");
    let ended = stepwright(&["cycle", &series, "--plot", png.path(), "--vcd", vcd.path()]);
    assert_eq!(ended.code(), Some(0));
    assert!(std::fs::read(png.path()).unwrap().starts_with(b"\x89PNG"));
    let vcd = std::fs::read_to_string(vcd.path()).unwrap();
    assert_eq!(vcd.lines().filter(|line| *line == "1a").count(), 700);
    assert!(vcd.contains("$var wire 1 B min1 $end"));
}

/// What is wrong, the line, and the place in it.
#[test]
fn mistakes_are_shown_where_they_are() {
    let scratch = Scratch::new("cycle-mistakes.toml");
    let file = scratch.path();
    let good = std::fs::read_to_string(example("readme")).unwrap();
    let wrong = |from: &str, to: &str, place: &str, what: &str| {
        assert!(good.contains(from), "{from}");
        std::fs::write(file, good.replacen(from, to, 1)).unwrap();
        let ended = stepwright(&["cycle", file]);
        assert_eq!(ended.code(), Some(1), "{to}");
        let message = format!("error: {file}:{place}: ");
        assert!(ended.stderr.contains(&message), "{to}: {}", ended.stderr);
        assert!(ended.stderr.contains(what), "{to}: {}", ended.stderr);
        assert!(ended.stderr.lines().any(|line| line.trim() == "|" || line.contains('^')));
    };
    wrong("step = 7500", "step = 75oo", "7:8", "string values must be quoted");
    wrong("step = 7500", "step = 0", "7:8", "a step leads somewhere");
    wrong("step = 7500", "stop = 7500", "7:1", "unknown field `stop`");
    wrong("delay-us = 1000\n", "delay-us = 0\n", "8:21", "a step takes some time");
    wrong("max = 300_000_000", "max = -1", "10:7", "below the minimum of 0");
    wrong("name = \"Y\"", "name = \"X\"", "13:8", "a name of its own");
    wrong("move.X", "move.Q", "29:6", "there is no motor \"Q\"");
    wrong("{ steps = 20_000,", "{ whirl = \"up\",", "29:20", "`forward` or `backward`");
    wrong("steps = 20_000", "each = 2, steps = 20_000", "29:10", "each does not belong here");
    wrong("delay-us = 1_000 }", "delay-us = 10 }", "29:10", "the first delay of X is below");
    // A refusal calls the motor by its name in the file, whichever it is.
    wrong("delay-us = 20_000", "delay-us = 9", "31:10", "the first delay of Z is below its");
    wrong("{ steps = 20_000", "{ steps = -5", "29:10", "cancelled after 0.001 s: X: soft-end-min");
    wrong("[[cycle]]", "[[cycle]]\nresume-s = 1", "28:1", "resume-s without pause-s");
    wrong("[[cycle]]", "[clock]\ntick-us = 700\n[[cycle]]", "31:10", "for X: a step takes");
    wrong("[[cycle]]", "[clock]\ntick-us = 700\n[[cycle]]", "31:10", "at least 2100 µs");
    let odd = "[clock]\ntick-us = 300\n[[cycle]]";
    wrong("[[cycle]]", odd, "31:10", "the smallest delay of X is no multiple of the fixed tick");
}

/// Two motors at 125,000 steps/s beside a third are more than the board has time for.
#[test]
fn a_motor_that_is_too_fast_is_named() {
    let scratch = Scratch::new("cycle-fast.toml");
    let file = scratch.path();
    let motor =
        |name: &str| format!("[[motor]]\nname = \"{name}\"\nstep = 1\nsmallest-delay-us = 8\n");
    let text = ["pan", "tilt", "focus"].map(motor).concat();
    let moves = "[[cycle]]\nmove.pan = { steps = 9, delay-us = 900 }\nmove.tilt.steps = 9\nmove.focus.steps = 9\n";
    std::fs::write(file, text + moves).unwrap();
    let ended = stepwright(&["cycle", file]);
    assert_eq!(ended.code(), Some(1));
    let message = format!("{file}:15:6: too fast for this board: tilt needs delays of at least ");
    assert!(ended.stderr.contains(&message), "{}", ended.stderr);
}

#[test]
fn what_never_ends_is_finished() {
    let scratch = Scratch::new("cycle-endless.toml");
    let file = scratch.path();
    let text = "[[motor]]\nname = \"X\"\nstep = 1\nsmallest-delay-us = 500\n\n[[cycle]]\n\
                move.X = { whirl = \"forward\" }\n";
    std::fs::write(file, text).unwrap();
    let ended = stepwright(&["cycle", file, "--limit", "3"]);
    assert_eq!((ended.code(), ended.last_line()), (Some(1), "X.pos=6000"));
    ended.assert_error("cycle 1 has not ended after 3 s");
    std::fs::write(file, format!("{text}finish-s = 1.5\n")).unwrap();
    let ended = stepwright(&["cycle", file]);
    assert_eq!((ended.code(), ended.last_line()), (Some(0), "X.pos=3000"));
}

/// Homing, lines and arcs: where they lead, and that a pause brakes on the way.
#[test]
fn a_drawing_ends_where_it_should() {
    let drawing = example("drawing");
    let ended = stepwright(&["cycle", &drawing, "--format", "csv"]);
    assert_eq!(ended.code(), Some(0), "{}", ended.stderr);
    let rows: Vec<Vec<&str>> =
        ended.stdout.lines().skip(1).map(|l| l.split(',').collect()).collect();
    let last = |motor: &str| {
        let row = rows.iter().rev().find(|row| row[1] == motor && row[2] == "step");
        row.unwrap()[4].parse::<i64>().unwrap()
    };
    assert_eq!((last("X"), last("Y")), (25_000_000, 10_000_000));
    // The circle stands still from the end of its braking until it is resumed.
    let time = |row: &Vec<&str>| row[0].parse::<f64>().unwrap();
    let begun = rows.iter().filter(|row| row[3] == "start").map(time).next_back().unwrap();
    let still = begun + 960_000.0..begun + 1_190_000.0;
    assert!(rows.iter().all(|row| !still.contains(&time(row))));
    // Within a step of the true circle, as long as it is drawn.
    let (mut x, mut y) = (25_000_000.0f64, 10_000_000.0f64);
    for row in rows.iter().filter(|row| time(row) > begun && row[2] == "step" && row[3] == "1") {
        let at = row[4].parse().unwrap();
        if row[1] == "X" {
            x = at
        } else {
            y = at
        }
        let radius = (x - 25e6).hypot(y - 25e6);
        assert!((radius - 15e6).abs() <= 12_500.0, "{radius} at {row:?}");
    }
}

#[test]
fn mistakes_in_a_path_are_shown_too() {
    let scratch = Scratch::new("cycle-path-mistakes.toml");
    let good = std::fs::read_to_string(example("drawing")).unwrap();
    let wrong = |from: &str, to: &str, what: &str| {
        assert!(good.contains(from), "{from}");
        std::fs::write(scratch.path(), good.replacen(from, to, 1)).unwrap();
        let ended = stepwright(&["cycle", scratch.path()]);
        assert_eq!(ended.code(), Some(1), "{to}");
        assert!(ended.stderr.contains(what), "{to}: {}", ended.stderr);
    };
    wrong("to = { X = 10_000_000, Y = 0 }", "to = {}", "a line: say where a motor is to go");
    wrong("speed = 60_000_000", "speed = 0", "a speed must be 10^-12 to 10^24");
    wrong("motors = [\"X\", \"Y\"]", "motors = [\"X\", \"X\"]", "an arc takes two motors");
    wrong("motors = [\"X\", \"Y\"]", "motors = [\"X\", \"Q\"]", "there is no motor \"Q\"");
    wrong("reach = 10_000", "reach = 100", "the switch was not found");
    wrong("motor = \"X\", end", "motor = \"Y\", end", "the switch was not found");
    wrong("fast-us = 300,", "fast-us = 40,", "the first delay of X is below its smallest");
    wrong("[[cycle]]\nline", "[[cycle]]\nmove.X = { steps = 1 }\nline", "a cycle has either moves");
    wrong("[[motor]]", "[clock]\ntick-us = 10\n[[motor]]", "what X does needs deadlines");
    wrong("pause-s = 0.8\nresume-s = 1.2", "pause-s = 0.8", "paused for ever");
}

/// The rows of a csv: time, motor, event, value, position.
fn rows(text: &str) -> Vec<Vec<&str>> {
    text.lines().skip(1).map(|line| line.split(',').collect()).collect()
}

/// Steps/s of a motor around a time, by the rising edges of 50 ms.
fn speed(rows: &[Vec<&str>], motor: &str, at: f64) -> f64 {
    let rising = rows.iter().filter(|row| row[1..4] == [motor, "step", "1"]);
    let times = rising.map(|row| row[0].parse::<f64>().unwrap() / 1e6);
    times.filter(|time| (time - at).abs() < 0.025).count() as f64 / 0.05
}

/// A feed, a new end on the line, and one elsewhere: the speeds, by the edges, and
/// the place where it ends.
#[test]
fn a_line_changes_on_the_way() {
    let ended = stepwright(&["cycle", &example("feed"), "--format", "csv"]);
    assert_eq!(ended.code(), Some(0), "{}", ended.stderr);
    let rows = rows(&ended.stdout);
    // 50 mm/s along (4, 1) are 48.5 mm/s of X; half of that, and a fifth more.
    let full = 50e6 / 12_500.0 * 4.0 / 17f64.sqrt();
    for (at, part) in [(0.45, 1.0), (1.0, 0.5), (1.8, 1.2)] {
        let (x, y) = (speed(&rows, "X", at), speed(&rows, "Y", at));
        assert!((x - full * part).abs() <= 21.0, "{x} at {at}");
        assert!((y - full * part / 4.0).abs() <= 21.0, "{y} at {at}");
    }
    let last = |motor: &str| {
        let row = rows.iter().rev().find(|row| row[1] == motor && row[2] == "step");
        row.unwrap()[4].parse::<i64>().unwrap()
    };
    assert_eq!((last("X"), last("Y")), (20_000_000, 50_000_000));
}

#[test]
fn mistakes_in_changes_are_shown_at_their_line() {
    let scratch = Scratch::new("cycle-change-mistakes.toml");
    let file = scratch.path();
    let good = std::fs::read_to_string(example("feed")).unwrap();
    let arc = "arc = { motors = [\"X\", \"Y\"], centre = [20_000_000, 0], degrees = 360, \
               speed = 50_000_000, accel = 250_000_000 } #";
    let round = good.replace("line = {", arc);
    let wrong = |from: &str, to: &str, place: &str, what: &str| {
        let good = if from.contains("120_") { &round } else { &good };
        assert!(good.contains(from), "{from}");
        std::fs::write(file, good.replacen(from, to, 1)).unwrap();
        let ended = stepwright(&["cycle", file]);
        assert_eq!(ended.code(), Some(1), "{to}");
        let message = format!("error: {file}:{place}: {what}");
        assert!(ended.stderr.contains(&message), "{to}: {}", ended.stderr);
    };
    let jerk = "jerk = 2_500_000_000";
    let no_jerk = "a jerk must be 10^-12 to 10^24";
    wrong(jerk, "jerk = 0", "22:99", no_jerk);
    wrong(jerk, "jerk = -1.5", "22:99", no_jerk);
    wrong(jerk, "jerk = inf", "22:99", no_jerk);
    wrong("speed = 50_000_000", "speed = nan", "22:59", "a speed must be");
    wrong("accel = 250_000_000", "accel = -1", "22:79", "an acceleration must be");
    wrong("percent = 50", "percent = 5", "23:33", "a feed is 10 to 200 percent");
    wrong("percent = 50", "percent = nan", "23:33", "a feed is 10 to 200 percent");
    wrong("at-s = 0.6", "at-s = -1", "23:18", "0 to 1000000 seconds");
    wrong("at-s = 1.2", "at-s = 120", "23:39", "the path is over by then");
    wrong("at-s = 2.2", "at-s = 220", "26:3", "the path is over by then");
    wrong("{ X = 20_000_000, Y = 50_000_000 }", "{}", "26:22", "a new end: say where");
    wrong("to = { X = 20_000_000, ", "to = { Z = 1, ", "26:24", "there is no motor \"Z\"");
    wrong("line = {", "move.X.steps = 1\n#", "24:9", "only along a path the feed can be changed");
    let both = "the arc is left for a line: say where both";
    wrong("X = 120_000_000, ", "", "25:22", both);
}

/// At its switch a motor stops at once, or brakes, alone or all of them; the
/// positions are those of the edges.
#[test]
fn motors_brake_at_a_switch() {
    let scratch = Scratch::new("cycle-brake.toml");
    let file = scratch.path();
    let play = |strategy: &str, decel: &str| {
        let motor = |name: &str| {
            format!("[[motor]]\nname = \"{name}\"\nstep = 10\nsmallest-delay-us = 100\n{decel}")
        };
        let text = format!(
            "strategies.hard-end = \"{strategy}\"\n{}switch-max = 10_000\n{}[[cycle]]\n\
             move.X.steps = 9_000\nmove.Y.steps = 4_000\n",
            motor("X"),
            motor("Y"),
        );
        std::fs::write(file, text).unwrap();
        stepwright(&["cycle", file, "--format", "json"])
    };
    let result = |strategy: &str| {
        let ended = play(strategy, "decel = 1_000_000\n");
        let all: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
        let position = |n: usize| all["motors"][n]["position"].as_i64().unwrap() / 10;
        (ended.code(), position(0), position(1), all["cycles"][0]["error"].clone())
    };
    let (all, none) = ("an error of X".into(), serde_json::Value::Null);
    // 10,000 steps/s and 100,000 steps/s²: 500 steps.
    let (code, x, y, error) = result("brake-motor");
    assert_eq!((code, y, error), (Some(0), 4_000, none.clone()));
    assert!((1_500..=1_502).contains(&x), "{x}");
    assert_eq!(result("stop-motor"), (Some(0), 1_000, 4_000, none));
    let (code, x, y, error) = result("brake-all");
    assert_eq!((code, error), (Some(1), all));
    assert!((1_500..=1_502).contains(&x) && (1_500..=1_502).contains(&y), "{x} {y}");
    let (code, x, y, _) = result("cancel");
    assert_eq!((code, x, y), (Some(1), 1_000, 1_000));
    for (decel, line, what) in [
        ("", 2, "X is to brake at its switch: give it a decel"),
        ("decel = 1\n", 6, "a deceleration is 1 to 4294967295 steps/s²"),
        ("decel = nan\n", 6, "a deceleration is 1 to 4294967295 steps/s²"),
    ] {
        let ended = play("brake-motor", decel);
        assert_eq!(ended.code(), Some(1));
        let place = format!("{file}:{line}:");
        assert!(ended.stderr.contains(&place) && ended.stderr.contains(what), "{}", ended.stderr);
    }
}

/// A refused cycle and a cancelled one, for programs: what is wrong, which motor, which line.
#[test]
fn json_of_a_failed_cycle_names_the_motor_and_the_line() {
    let scratch = Scratch::new("cycle-refused.toml");
    let motors = "[[motor]]\nname = \"X\"\nstep = 1\nsmallest-delay-us = 1000\nmax = 5\n\
                  [[motor]]\nname = \"Y\"\nstep = 1\nsmallest-delay-us = 1000\n";
    let cases = [
        ("[[cycle]]\nmove.X = { steps = 3 }\nmove.Y = { steps = 5, delay-us = 10 }\n", "Y", 12),
        ("[[cycle]]\nmove.Y = { steps = 3 }\nmove.X = { steps = 50 }\n", "X", 12),
    ];
    for (cycle, motor, line) in cases {
        std::fs::write(scratch.path(), format!("{motors}{cycle}")).unwrap();
        let ended = stepwright(&["cycle", scratch.path(), "--format", "json"]);
        assert_eq!(ended.code(), Some(1));
        let all: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
        let said: serde_json::Value =
            serde_json::from_str(ended.stderr.lines().last().unwrap()).unwrap();
        let failed = &all["cycles"][0];
        assert!(failed["error"].as_str().unwrap().contains(motor), "{failed}");
        for place in [failed, &said] {
            assert_eq!(
                (place["motor"].as_str(), place["line"].as_u64()),
                (Some(motor), Some(line))
            );
        }
    }
}

/// The steps of X and Y of a run as csv: times in s, and both positions in mm.
fn way(csv: &str, from: [f64; 2]) -> Vec<(f64, [f64; 2])> {
    let mut at = from;
    let steps = csv.lines().filter(|line| line.contains(",step,1,")).map(|line| {
        let cells: Vec<_> = line.split(',').collect();
        at[usize::from(cells[1] == "Y")] = cells[4].parse::<f64>().unwrap() / 1e6;
        (cells[0].parse::<f64>().unwrap() / 1e6, at)
    });
    steps.collect()
}

/// Lines and arcs of one path: 60 mm/s through all smooth joints, by its steps, and its end exact.
#[test]
fn the_joints_of_a_path_are_passed_at_speed() {
    let file = Scratch::new("cycle-joined.toml");
    let example = std::fs::read_to_string(example("joined")).unwrap();
    let text = example.replace("pause-s = 0.8\nresume-s = 1.2\n", "");
    assert!(!text.contains("-s = "), "{text}");
    std::fs::write(file.path(), &text).unwrap();
    let ended = stepwright(&["cycle", file.path(), "--format", "csv"]);
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    let way = way(&ended.stdout, [10.0, 0.0]);
    let (end, last) = *way.last().unwrap();
    assert_eq!(last, [10.0, 0.0]);
    // 120 mm of lines and 20π of arcs; two ramps of 0.15 s cost half of it each, on an arc less.
    let by_hand = (120.0 + 20.0 * std::f64::consts::PI) / 60.0 + 0.15;
    assert!(end < by_hand && end > by_hand - 0.02, "{end} {by_hand}");
    // Between the ramps, over 40 ms each: 2.4 mm, less what an arc is longer than its chord.
    let (mut windows, mut from) = (0, way[0]);
    for (time, at) in way.into_iter().filter(|(time, _)| (0.2..end - 0.2).contains(time)) {
        if time - from.0 >= 0.04 {
            let speed = (at[0] - from.1[0]).hypot(at[1] - from.1[1]) / (time - from.0);
            assert!(from.0 < 0.2 || (58.5..61.0).contains(&speed), "{speed} mm/s at {time}");
            (windows, from) = (windows + 1, (time, at));
        }
    }
    assert!(windows > 60, "{windows}");
    // As it stands it is paused in a corner, for 0.4 s less its ramps.
    std::fs::write(file.path(), &example).unwrap();
    let ended = stepwright(&["cycle", file.path(), "--format", "csv"]);
    let paused = self::way(&ended.stdout, [10.0, 0.0]);
    assert_eq!(paused.last().unwrap().1, [10.0, 0.0]);
    let gap = paused.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(0.0, f64::max);
    assert!((0.2..0.3).contains(&gap), "{gap}");
    // Told to finish, it brakes on the way.
    let finished = text.replace("[cycle.path]", "finish-s = 1.0\n[cycle.path]");
    std::fs::write(file.path(), finished).unwrap();
    let ended = stepwright(&["cycle", file.path(), "--format", "csv"]);
    let (end, [x, y]) = *self::way(&ended.stdout, [10.0, 0.0]).last().unwrap();
    assert!((1.1..1.2).contains(&end) && (x - 50.0).abs() < 0.02 && y > 10.0, "{end} {x} {y}");
}

/// A corner is passed at what the motors may change their speed by, and no faster.
#[test]
fn a_path_has_corners() {
    let file = Scratch::new("cycle-corner.toml");
    let motor = "[[motor]]\nname = \"N\"\nstep = 12_500\nsmallest-delay-us = 50\n";
    let motors = ["X", "Y"].map(|name| motor.replace('N', name)).concat();
    let path = |start: &str| {
        format!(
            "{motors}[[cycle]]\n[cycle.path]\nspeed = 50_000_000\naccel = 500_000_000\n{start}\n\
             pieces = [{{ to = {{ X = 25_000_000 }} }}, {{ to = {{ Y = 25_000_000 }} }}]\n"
        )
    };
    let time = |start: &str| {
        std::fs::write(file.path(), path(start)).unwrap();
        let ended = stepwright(&["cycle", file.path(), "--format", "json"]);
        assert_eq!(ended.code(), Some(0), "{ended:#?}");
        let all: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
        let at = [0, 1].map(|n| all["motors"][n]["position"].as_i64());
        assert_eq!(at, [Some(25_000_000); 2]);
        all["seconds"].as_f64().unwrap()
    };
    // Two lines of 25 mm at 50 mm/s with ramps of 0.1 s, and 100 µs before the start; at the corner
    // (50 − v)²/(50·500) s for the ramps down to v and up again.
    let cost = |v: f64| 1.0 + 0.1 + (50.0 - v).powi(2) / 25_000.0 + 0.000_1;
    for v in [2.0, 10.0] {
        let found = time(&format!("start-speed = {}", v * 1e6));
        assert!((found - cost(v)).abs() < 1e-5, "{v}: {found}, not {}", cost(v));
    }
    // Without one, what a step from rest leads to.
    let found = time("");
    assert!((found - cost((2.0f64 * 500.0 * 0.0125).sqrt())).abs() < 1e-5, "{found}");
}

#[test]
fn a_path_with_a_mistake_is_refused_at_its_line() {
    let file = Scratch::new("cycle-path-wrong.toml");
    let example = std::fs::read_to_string(example("joined")).unwrap();
    let line = |part: &str| example[..example.find(part).unwrap()].matches('\n').count() + 1;
    let to = "{ to = { X = 40_000_000 } }";
    for (from, into, line, said) in [
        (to, "{ to = { Q = 4 } }", line(to), "there is no motor \"Q\""),
        (to, "{ degrees = 9 }", line(to), "a piece is a line, which has to, or an arc"),
        (to, "{ to = { X = 4 }, degrees = 9 }", line(to), "a piece is a line"),
        (
            "degrees = 90 },\n    { to = { Y = 40",
            "degrees = 0 },\n    { to = { Y = 40",
            line(to) + 1,
            "the sweep of an arc",
        ),
        (
            "start-speed = 3_000_000",
            "start-speed = -1",
            line("start-speed = "),
            "the jump of an axis",
        ),
        ("speed = 60_000_000", "speed = 0", line("speed = 60"), "a speed must be"),
        (
            "pause-s = 0.8",
            "retarget = [{ at-s = 1, to = { X = 1 } }]\npause-s = 0.8",
            line("pause-s = 0.8"),
            "a path of several pieces keeps its end",
        ),
        (
            "[cycle.path]",
            "arc = { motors = [\"X\", \"Y\"], centre = [1, 1], degrees = 1, speed = 1, accel = 1 }\n[cycle.path]",
            line("[cycle.path]") + 1,
            "a cycle has either",
        ),
    ] {
        assert!(example.contains(from), "{from}");
        std::fs::write(file.path(), example.replacen(from, into, 1)).unwrap();
        let ended = stepwright(&["cycle", file.path(), "--format", "json"]);
        assert_eq!(ended.code(), Some(1), "{into}: {ended:#?}");
        let wrong: serde_json::Value =
            serde_json::from_str(ended.stderr.trim().lines().last().unwrap()).unwrap();
        assert!(wrong["error"].as_str().unwrap().contains(said), "{into}: {ended:#?}");
        assert_eq!(wrong["line"], line, "{into}: {ended:#?}");
    }
}
