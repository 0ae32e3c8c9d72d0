//! `stepwright cycle` with files that go to its limits: of size, speed, length of a
//! line, and names.

use crate::common::{Scratch, stepwright, stepwright_with};

/// A motor of a file: a step is a unit.
fn motor(name: &str, smallest: u32) -> String {
    format!("[[motor]]\nname = {name}\nstep = 1\nsmallest-delay-us = {smallest}\n")
}

/// A line of X alone.
fn line(to: i64, speed: f64) -> String {
    format!("[[cycle]]\nline = {{ to = {{ X = {to} }}, speed = {speed:?}, accel = 10_000 }}\n")
}

/// Times in seconds at which a motor makes a step, and which way its position goes.
fn steps(csv: &str, motor: &str) -> Vec<f64> {
    let rows = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let rising = rows.filter(|row| row.len() == 5 && row[1..4] == [motor, "step", "1"]);
    rising.map(|row| row[0].parse::<f64>().unwrap() / 1e6).collect()
}

/// Each begins from rest: at 10,000 steps/s² the first interval is 14 ms, and so long the
/// motor stands between two lines at least, on or back.
#[test]
fn lines_in_a_row_each_begin_from_rest() {
    let scratch = Scratch::new("cycle-joint.toml");
    for second in [400, 0, 201] {
        let text = motor("\"X\"", 100) + &line(200, 1_000.0) + &line(second, 1_000.0);
        std::fs::write(scratch.path(), text).unwrap();
        let ended = stepwright(&["cycle", scratch.path(), "--format", "csv"]);
        assert_eq!(ended.code(), Some(0), "{}", ended.stderr);
        let times = steps(&ended.stdout, "X");
        assert_eq!(times.len() as i64, 200 + (second - 200i64).abs());
        let joint = times[200] - times[199];
        assert!(joint >= (2.0f64 / 10_000.0).sqrt(), "{joint} before {second}");
    }
}

/// So it is in the drawing, between lines and arcs: 32,000 steps/s² along them.
#[test]
fn the_pieces_of_a_drawing_each_begin_from_rest() {
    let drawing = format!("{}/../../examples/cycles/drawing.toml", env!("CARGO_MANIFEST_DIR"));
    let ended = stepwright(&["cycle", &drawing, "--format", "csv"]);
    assert_eq!(ended.code(), Some(0), "{}", ended.stderr);
    let begun: Vec<f64> = (ended.stdout.lines())
        .filter_map(|line| line.strip_suffix(",,cycle,start,"))
        .map(|time| time.parse::<f64>().unwrap() / 1e6)
        .collect();
    assert_eq!(begun.len(), 12);
    for motor in ["X", "Y"] {
        let times = steps(&ended.stdout, motor);
        // The first cycle is the homing, which has delays and no ramp.
        for start in &begun[1..] {
            let at = times.partition_point(|time| time < start);
            let (Some(before), Some(after)) = (at.checked_sub(1), times.get(at)) else { continue };
            let joint = after - times[before];
            assert!(joint >= (2.0f64 / 32_000.0).sqrt(), "{motor} after {start}: {joint}");
        }
    }
}

/// A path that a motor can't follow is refused before it moves, with the largest speed
/// that would do; and that does.
#[test]
fn a_path_that_is_too_fast_is_refused_with_the_speed_that_would_do() {
    let scratch = Scratch::new("cycle-too-fast.toml");
    let motors = motor("\"X\"", 50) + &motor("\"Y\"", 500);
    let play = |path: &str, speed: f64, accel: f64| {
        let text = format!("{motors}[[cycle]]\n{path}, speed = {speed:?}, accel = {accel:?} }}\n");
        std::fs::write(scratch.path(), text).unwrap();
        stepwright(&["cycle", scratch.path()])
    };
    let (long, arc) = (
        "line = { to = { X = 3000, Y = 4000 }",
        "arc = { motors = [\"X\", \"Y\"], centre = [0, 300], degrees = 360",
    );
    // Y makes 0.8 of the way, and all of it somewhere on the circle.
    for (path, most, end) in
        [(long, 2_500.0, "X.pos=3000, Y.pos=4000"), (arc, 2_000.0, "X.pos=0, Y.pos=0")]
    {
        for speed in [1e5, most * 1.01] {
            let ended = play(path, speed, 100_000.0);
            // Not a step was made.
            ended.assert(1, "X.pos=0, Y.pos=0");
            assert_eq!(ended.stdout.lines().count(), 1, "{}", ended.stdout);
            ended.assert_error(":9:1: too fast for Y, whose smallest delay is 500 µs");
            let hint = format!("the largest speed that would do is {most}\n");
            assert!(ended.stderr.contains(&hint), "{}", ended.stderr);
        }
        let ended = play(path, most, 100_000.0);
        ended.assert(0, end);
        assert!(ended.stderr.contains(" 0 steps late"), "{}", ended.stderr);
    }
    // One that never comes to its speed is not refused for it.
    play("line = { to = { X = 30, Y = 40 }", 1e9, 10_000.0).assert(0, "X.pos=30, Y.pos=40");
}

/// Neither the whole line nor a panic: the part around the mistake.
#[test]
fn a_mistake_far_along_a_line_is_shown_with_what_is_around_it() {
    let scratch = Scratch::new("cycle-long-line.toml");
    for far in [100, 1_000, 65_600, 200_000] {
        let list = "900, ".repeat(far / 5);
        let text = format!(
            "{}[[cycle]]\nmove.X = {{ delays-us = [{list}oops, {list}] }}\n",
            motor("\"X\"", 100)
        );
        std::fs::write(scratch.path(), text).unwrap();
        let ended = stepwright(&["cycle", scratch.path()]);
        assert_eq!(ended.code(), Some(1), "{}", ended.stderr.len());
        assert!(ended.stderr.contains(&format!(":6:{}: ", 25 + list.len())), "{}", ended.stderr);
        let lines: Vec<_> = ended.stderr.lines().collect();
        assert!(lines.iter().all(|line| line.chars().count() < 200), "{}", ended.stderr.len());
        let shown = lines.iter().find(|line| line.contains("oops")).unwrap();
        let mark = lines.iter().find(|line| line.trim_end().ends_with('^')).unwrap();
        let column = shown.chars().position(|c| c == 'o').unwrap();
        assert_eq!(mark.chars().count(), column + 1, "{}", ended.stderr);
    }
    // Nor is a name echoed that is as long as the file.
    let text = format!("{}[[cycle]]\nmove.{}.steps = 1\n", motor("\"X\"", 100), "q".repeat(90_000));
    std::fs::write(scratch.path(), text).unwrap();
    let ended = stepwright(&["cycle", scratch.path()]);
    ended.assert_error("there is no motor \"qqq");
    assert!(ended.stderr.len() < 1_000, "{}", ended.stderr.len());
}

/// A line to where the motors stand is made already, and the cycles go on.
#[test]
fn a_line_of_no_length_is_none() {
    let scratch = Scratch::new("cycle-no-length.toml");
    let file = scratch.path();
    let text = motor("\"X\"", 100)
        + &line(0, 500.0)
        + "rest-s = 2\n"
        + &line(70, 500.0)
        + &line(70, 500.0);
    std::fs::write(file, &text).unwrap();
    let ended = stepwright(&["cycle", file]);
    ended.assert(0, "X.pos=70");
    // It rests all the same.
    let ended = stepwright(&["cycle", file, "--format", "csv"]);
    assert!(steps(&ended.stdout, "X")[0] > 2.0);
    assert_eq!(ended.stdout.matches(",,cycle,end,").count(), 3, "{}", ended.stdout);
    let arc = "[[cycle]]\narc = { motors = [\"X\", \"Y\"], centre = [9, 9], degrees = 0, speed = 9, accel = 9 }\n";
    std::fs::write(file, motor("\"X\"", 100) + &motor("\"Y\"", 100) + arc).unwrap();
    stepwright(&["cycle", file]).assert(0, "X.pos=0, Y.pos=0");
    // One around a centre that is further than can be counted is another mistake.
    let far = arc
        .replace("[9, 9]", "[0, 9_000_000_000_000_000_000]")
        .replace("degrees = 0", "degrees = 1e-12");
    std::fs::write(file, motor("\"X\"", 100) + &motor("\"Y\"", 100) + &far).unwrap();
    stepwright(&["cycle", file]).assert_error("too long: at most 2147483647 steps of an axis, and");
    // There is nothing on its way to be changed.
    std::fs::write(file, text.replace("rest-s = 2", "feed = [{ at-s = 0, percent = 50 }]"))
        .unwrap();
    stepwright(&["cycle", file]).assert_error("the path is over by then");
}

/// What --limit ends is told as such wherever it is told, and no switch is blamed for it.
#[test]
fn what_the_limit_ends_is_told_as_such() {
    let scratch = Scratch::new("cycle-limit.toml");
    let slow = "[[cycle]]\nmove.X = { steps = 3, delay-us = 4_000_000_000 }\n";
    let homing = "switch-min = -9_000\n[[cycle]]\nhome = { motor = \"X\", end = \"min\", \
                  reach = 10_000, back-off = 100, fast-us = 1_000_000, slow-us = 1_000_000 }\n";
    for (cycle, seconds) in [(slow, 5.0), (homing, 5.0)] {
        std::fs::write(scratch.path(), motor("\"X\"", 100) + cycle).unwrap();
        let played = |format| {
            let ended = stepwright(&["cycle", scratch.path(), "--limit", "5", "--format", format]);
            assert_eq!(ended.code(), Some(1), "{}", ended.stderr);
            let said = "cycle 1 has not ended after 5 s";
            assert!(ended.stderr.contains(said), "{}", ended.stderr);
            ended.stdout
        };
        let json: serde_json::Value = serde_json::from_str(&played("json")).unwrap();
        let told = &json["cycles"][0];
        let error = told["error"].as_str().unwrap_or_default();
        assert!(error.starts_with("cycle 1 has not ended after 5 s"), "{json:#}");
        assert!(told["line"].is_u64(), "{json:#}");
        assert!((told["seconds"].as_f64().unwrap() - seconds).abs() < 0.01, "{json:#}");
        let rows = played("csv");
        let rows: Vec<_> = rows.lines().filter(|row| row.contains(",,cycle,")).collect();
        assert_eq!(rows[0], "0,,cycle,start,");
        let ends: Vec<_> = rows[1..].iter().map(|row| row.split_once(',').unwrap().1).collect();
        assert_eq!(ends, [",cycle,finish,", ",cycle,end,"], "{rows:?}");
    }
}

/// RFC 4180: what would not be one field is quoted.
#[test]
fn names_are_quoted_in_csv() {
    let scratch = Scratch::new("cycle-names.toml");
    let names = [r#"'a,b'"#, r#"'say "x"'"#, "'plain'"];
    let moves = names.map(|name| format!("move.{name}.steps = 1\n")).concat();
    let text = names.map(|name| motor(name, 500)).concat() + "[[cycle]]\n" + &moves;
    std::fs::write(scratch.path(), text).unwrap();
    let ended = stepwright(&["cycle", scratch.path(), "--format", "csv"]);
    assert_eq!(ended.code(), Some(0), "{}", ended.stderr);
    for field in [r#""a,b""#, r#""say ""x""""#, "plain"] {
        let step = format!(",{field},step,1,");
        assert_eq!(ended.stdout.matches(&step).count(), 1, "{field}: {}", ended.stdout);
    }
    let text = motor("\"a\\nb\"", 500) + "[[cycle]]\nmove.X.steps = 1\n";
    std::fs::write(scratch.path(), text).unwrap();
    stepwright(&["cycle", scratch.path()]).assert_error(":2:8: one line, without control");
    let text =
        format!("unit = \"\\u001b[31m\"\n{}[[cycle]]\nmove.X.steps = 1\n", motor("'X'", 500));
    std::fs::write(scratch.path(), text).unwrap();
    stepwright(&["cycle", scratch.path()]).assert_error(":1:8: one line, without control");
}

/// A file without end is read up to the bound.
#[test]
fn a_file_has_a_bound() {
    let what = "it has more than 1000000 bytes";
    stepwright_with(&["cycle", "-"], &vec![b'#'; 1_000_001]).assert_error(what);
    #[cfg(unix)]
    stepwright(&["cycle", "/dev/zero"]).assert_error(what);
    let scratch = Scratch::new("cycle-size.toml");
    let text = motor("\"X\"", 500) + &line(7, 500.0);
    let whole = format!("{text}#{}", "x".repeat(1_000_000 - text.len() - 1));
    std::fs::write(scratch.path(), whole).unwrap();
    stepwright(&["cycle", scratch.path()]).assert(0, "X.pos=7");
    std::fs::write(scratch.path(), b"# fine\n\n# \xff\n").unwrap();
    stepwright(&["cycle", scratch.path()]).assert_error("line 3 is not text in UTF-8");
    std::fs::write(scratch.path(), b"\xff\xfe#\0\n\0").unwrap();
    let said = stepwright(&["cycle", scratch.path()]).stderr;
    assert!(said.contains(" hint: it is UTF-16, as Windows PowerShell's >"), "{said}");
}

/// A motor is drawn where it stands, before its first step and behind its last one.
#[test]
fn a_position_is_drawn_from_the_start_to_the_end() {
    let (scratch, page) = (Scratch::new("cycle-drawn.toml"), Scratch::new("cycle-drawn.html"));
    let text = motor("\"X\"", 100)
        + &motor("\"Y\"", 100)
        + "[[cycle]]\nmove.X = { steps = 40, delay-us = 25_000 }\n\
           [[cycle]]\nmove.Y = { steps = -40, delay-us = 25_000 }\nrest-s = 3\n";
    std::fs::write(scratch.path(), text).unwrap();
    let ended = stepwright(&["cycle", scratch.path(), "--plot", page.path()]);
    assert_eq!(ended.code(), Some(0), "{}", ended.stderr);
    let page = std::fs::read_to_string(page.path()).unwrap();
    let data = page.split("const probes = ").nth(1).unwrap().split(";\n").next().unwrap();
    let probes: serde_json::Value = serde_json::from_str(data).unwrap();
    let probes = probes.as_array().unwrap().iter();
    let positions: Vec<_> =
        probes.filter(|probe| probe["y"].as_str().unwrap().ends_with("from the start")).collect();
    let mut drawn = 0;
    for curve in positions.iter().flat_map(|probe| probe["curves"].as_array().unwrap()) {
        let points = curve["points"].as_array().unwrap();
        let at = |n: usize| [2, 3].map(|i| points[n][i].as_f64().unwrap());
        let end = if curve["name"] == "X" { 40.0 } else { -40.0 };
        let [time, last] = at(points.len() - 1);
        assert_eq!((at(0), last), ([0.0, 0.0], end), "{curve}");
        // The first step is made a pulse behind the start.
        assert!((5.0..5.0001).contains(&time), "{time}");
        drawn += 1;
    }
    assert_eq!(drawn, 2, "{positions:?}");
}
