//! Cycle files drawn by `stepwright serve`: their points against the numbers of the file, and
//! against what `stepwright cycle` plays.

use std::f64::consts::TAU;
use std::time::Instant;

use crate::common::stepwright;
use crate::served::{Served, next};
use serde_json::{Value, json};

/// A step of `drawing.toml`, in nm.
const STEP: f64 = 12_500.0;

fn example(name: &str) -> String {
    format!("{}/../../examples/cycles/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn draw(served: &Served, name: &str) -> Value {
    let text = std::fs::read_to_string(example(name)).unwrap();
    served.order("/api/path", json!({"name": name, "text": text}))
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().unwrap().iter().map(|one| one.as_f64().unwrap()).collect()
}

fn number(of: &Value, name: &str) -> f64 {
    of[name].as_f64().unwrap_or_else(|| panic!("{name}: {of}"))
}

/// A drawing of two motors, taken apart.
struct Points {
    times: Vec<f64>,
    speeds: Vec<f64>,
    x: Vec<f64>,
    y: Vec<f64>,
    legs: Vec<Value>,
}

impl Points {
    fn of(drawing: &Value) -> Points {
        Points {
            times: numbers(&drawing["times"]),
            speeds: numbers(&drawing["speeds"]),
            x: numbers(&drawing["places"][0]),
            y: numbers(&drawing["places"][1]),
            legs: drawing["legs"].as_array().unwrap().clone(),
        }
    }

    fn leg(&self, line: u64) -> (&Value, std::ops::RangeInclusive<usize>) {
        let leg = self.legs.iter().find(|leg| leg["line"] == line).unwrap();
        (leg, leg["first"].as_u64().unwrap() as usize..=leg["last"].as_u64().unwrap() as usize)
    }
}

#[test]
fn lines_end_where_the_file_says_and_arcs_are_round() {
    let served = Served::board();
    let points = Points::of(&draw(&served, "drawing.toml"));
    // By the lines of the file: where each path ends, and the centre of arcs with degrees.
    let mm = 1e6;
    for (line, kind, to, round) in [
        (26, "line", (10.0, 0.0), None),
        (29, "line", (40.0, 0.0), None),
        (31, "arc", (50.0, 10.0), Some(((40.0, 10.0), 10.0, 90.0))),
        (33, "line", (50.0, 40.0), None),
        (35, "arc", (40.0, 50.0), Some(((40.0, 40.0), 10.0, 90.0))),
        (37, "line", (10.0, 50.0), None),
        (39, "arc", (0.0, 40.0), Some(((10.0, 40.0), 10.0, 90.0))),
        (41, "line", (0.0, 10.0), None),
        (43, "arc", (10.0, 0.0), Some(((10.0, 10.0), 10.0, 90.0))),
        (46, "line", (25.0, 10.0), None),
        (48, "arc", (25.0, 10.0), Some(((25.0, 25.0), 15.0, -360.0))),
    ] {
        let (leg, all) = points.leg(line);
        assert_eq!((&leg["kind"], number(leg, "ordered")), (&json!(kind), 60.0 * mm), "{line}");
        let end = (points.x[*all.end()], points.y[*all.end()]);
        assert_eq!(end, (to.0 * mm, to.1 * mm), "{line}");
        let Some(((x, y), radius, degrees)) = round else {
            // Straight: no point is further from the line than a step.
            let (from, last) = ((points.x[*all.start()], points.y[*all.start()]), end);
            let (dx, dy) = (last.0 - from.0, last.1 - from.1);
            for n in all {
                let off = (points.x[n] - from.0) * dy - (points.y[n] - from.1) * dx;
                assert!(off.abs() / dx.hypot(dy) <= STEP, "{line}: {off}");
            }
            continue;
        };
        // Each axis is at its nearest position, and straight between two of them.
        let place = |n: usize| (points.x[n] - x * mm, points.y[n] - y * mm);
        let (mut turned, mut before) = (0.0, place(*all.start()));
        for n in all {
            let at = place(n);
            let off = at.0.hypot(at.1) - radius * mm;
            assert!(off.abs() <= STEP * std::f64::consts::SQRT_2, "{line}: {off} nm");
            turned += (before.0 * at.1 - before.1 * at.0).atan2(before.0 * at.0 + before.1 * at.1);
            before = at;
        }
        assert!((turned.to_degrees() - degrees).abs() < 0.2, "{line}: {}", turned.to_degrees());
    }
}

#[test]
fn speeds_are_those_of_the_way_and_within_the_order() {
    let served = Served::board();
    for name in ["drawing.toml", "feed.toml"] {
        let drawing = draw(&served, name);
        let points = Points::of(&drawing);
        // In feed.toml 50 mm/s, at 120 percent for a while.
        let ordered = 60e6;
        assert_eq!(number(&drawing, "peak"), ordered, "{name}");
        assert!(points.times.is_sorted());
        for leg in points.legs.iter().filter(|leg| leg["ordered"].is_f64()) {
            let (first, last) = (leg["first"].as_u64().unwrap(), leg["last"].as_u64().unwrap());
            for n in first as usize..last as usize {
                assert!(points.speeds[n] <= ordered, "{name}: {n}");
                let time = points.times[n + 1] - points.times[n];
                let way = (points.x[n + 1] - points.x[n]).hypot(points.y[n + 1] - points.y[n]);
                let mean = (points.speeds[n] + points.speeds[n + 1]) / 2.0;
                // By what a step more or less is in that time, and the arc above its chord.
                let least = 2.0 * STEP / time + 0.02 * ordered;
                assert!((way / time - mean).abs() <= least, "{name}: {n}: {way} {time} {mean}");
            }
        }
    }
}

/// The circle of `drawing.toml` brakes at 0.8 s of its time and goes on at 1.2 s.
#[test]
fn a_pause_is_a_time_at_rest_on_the_way() {
    let served = Served::board();
    let points = Points::of(&draw(&served, "drawing.toml"));
    let (leg, all) = points.leg(48);
    let begin = number(leg, "begin");
    let at_rest = |n: &usize| (1.0..1.15).contains(&(points.times[*n] - begin));
    let resting: Vec<_> = all.filter(at_rest).collect();
    assert!(!resting.is_empty());
    for n in resting {
        assert_eq!(points.speeds[n], 0.0, "{n}");
        let angle = (points.y[n] - 25e6).atan2(points.x[n] - 25e6).rem_euclid(TAU);
        // From −90° on at 60 mm/s for 0.8 s: by its first ramp half of it less, by the brake as
        // much more.
        let way = 60e6 * 0.8 / 15e6;
        let right = (-TAU / 4.0 - way).rem_euclid(TAU);
        assert!((angle - right).abs() < 0.02, "{angle} {right}");
    }
}

#[test]
fn every_example_is_drawn_and_takes_as_long_as_it_is_played() {
    let served = Served::board();
    let table = served.get("/api/path/examples");
    let examples = &table["examples"];
    assert_eq!(table["port"], Value::Null);
    assert!(examples.as_array().unwrap().len() >= 6);
    let cycles = |file: &&Value| file["name"].as_str().unwrap().ends_with(".toml");
    for file in examples.as_array().unwrap().iter().filter(cycles) {
        let name = file["name"].as_str().unwrap();
        let drawing = served.order("/api/path", file.clone());
        let played = stepwright(&["cycle", &example(name), "--format", "json"]);
        assert_eq!(played.code(), Some(0), "{name}");
        let played: Value = serde_json::from_str(&played.stdout).unwrap();
        assert_eq!(drawing["seconds"], played["seconds"], "{name}");
        assert_eq!(drawing["unit"], played["unit"], "{name}");
        let count = drawing["times"].as_array().unwrap().len();
        assert!((2..5_000).contains(&count), "{name}: {count}");
        for (n, motor) in played["motors"].as_array().unwrap().iter().enumerate() {
            assert_eq!(drawing["motors"][n]["name"], motor["name"], "{name}");
            let places = numbers(&drawing["places"][n]);
            assert_eq!(places.len(), count);
            assert_eq!(places[count - 1], number(motor, "position"), "{name}: {motor}");
        }
        let legs = drawing["legs"].as_array().unwrap();
        assert_eq!(number(&legs[0], "begin"), 0.0);
        assert!((number(legs.last().unwrap(), "end") - number(&drawing, "seconds")).abs() < 1e-6);
        for two in legs.windows(2) {
            assert!((number(&two[0], "end") - number(&two[1], "begin")).abs() < 2e-6, "{name}");
            assert_eq!(number(&two[0], "last") + 1.0, number(&two[1], "first"), "{name}");
        }
    }
}

#[test]
fn what_can_not_be_drawn_says_why_and_where() {
    let served = Served::board();
    let motor = "[[motor]]\nname = \"X\"\nstep = 10\nsmallest-delay-us = 100\n";
    for (text, status, what) in [
        ("", 422, "a.toml, line 1: missing field"),
        ("[[motor]]\nname = 5\n", 422, "a.toml, line 2: invalid type"),
        (
            &format!(
                "{motor}[[cycle]]\nline = {{ to = {{ X = 9000 }}, speed = 200_000, accel = 1e9 }}\n"
            ),
            422,
            "a.toml, line 5: too fast for X",
        ),
        (&format!("{motor}[[cycle]]\nmove.Y = {{ steps = 1 }}\n"), 422, "there is no motor \"Y\""),
        // It has no end.
        (
            &format!("{motor}[[cycle]]\nmove.X = {{ whirl = \"forward\" }}\n"),
            422,
            "too long to draw",
        ),
        (&" ".repeat(200_001), 422, "a.toml is too long for a cycle file"),
    ] {
        let said = served.declined("/api/path", json!({"name": "a.toml", "text": text}), status);
        assert!(said.contains(what), "{said}");
    }
    let fast = format!(
        "{motor}[[cycle]]\nline = {{ to = {{ X = 9000 }}, speed = 200_000, accel = 1e9 }}\n"
    );
    let (_, said) = served.post("/api/path", json!({"name": "a.toml", "text": fast}));
    assert!(said["do"].as_str().unwrap().contains("the largest speed that would do is"), "{said}");
    for name in ["a\nb", &"n".repeat(101)] {
        served.declined("/api/path", json!({"name": name, "text": ""}), 422);
    }
    // Nothing has moved.
    for axis in 1..=3 {
        assert_eq!(served.axis(axis)["position"], 0);
    }
}

/// A line of 100 mm at 50 mm/s, from X = 1 mm on.
const LINE: &str = "
[[motor]]
name = \"X\"
step = 12_500
smallest-delay-us = 50
position = 1_000_000

[[cycle]]
line = { to = { X = 101_000_000 }, speed = 50_000_000, accel = 500_000_000 }
";

fn line() -> Value {
    json!({"name": "line.toml", "text": LINE})
}

/// The reports of a run up to its end, as a page hears them.
fn followed(live: &mut tungstenite::WebSocket<std::net::TcpStream>) -> Vec<Value> {
    let mut all: Vec<Value> = Vec::new();
    let going = ["running", "braking"];
    while all.last().is_none_or(|last| going.contains(&last["state"].as_str().unwrap())) {
        all.push(next(live, "path"));
    }
    all
}

fn place(report: &Value) -> f64 {
    report["places"][0].as_f64().unwrap()
}

#[test]
fn a_run_takes_its_time_and_is_followed_to_its_end() {
    let served = Served::board();
    assert_eq!(served.get("/api/path"), Value::Null);
    let drawing = served.order("/api/path", line());
    let seconds = number(&drawing, "seconds");
    assert!((2.1..2.11).contains(&seconds), "{seconds}");
    let mut live = served.live();
    let begun = Instant::now();
    served.order("/api/path/run", line());
    assert_eq!(served.get("/api/path")["state"], "running");
    // One at a time.
    let said = served.declined("/api/path/run", line(), 409);
    assert!(said.contains("a file is being run"), "{said}");
    let reports = followed(&mut live);
    assert!(begun.elapsed().as_secs_f64() >= seconds);
    let last = reports.last().unwrap();
    assert_eq!((&last["state"], &last["trouble"]), (&json!("done"), &Value::Null));
    assert_eq!((place(last), number(last, "seconds")), (101e6, seconds));
    assert!(reports.len() > 20, "{}", reports.len());
    assert!(reports.iter().all(|one| one["id"] == drawing["id"] && one["name"] == "line.toml"));
    // Each is where the line is at its time: 50 mm/s after a ramp of 0.1 s, which costs 2.5 mm.
    for report in &reports {
        let t = number(report, "seconds");
        let way = match t {
            t if t < 0.1 => 250e6 * t * t,
            t if t > 2.0 => 100e6 - 250e6 * (seconds - t).powi(2),
            t => 50e6 * t - 2.5e6,
        };
        let off = place(report) - 1e6 - way;
        assert!(off.abs() <= 2.0 * STEP + 50e6 * 0.0005, "{t}: {off} nm");
    }
    assert_eq!(served.get("/api/path"), untyped(last));
    // And again: the player begins where the file says.
    served.order("/api/path/run", line());
    assert_eq!(served.get("/api/path")["state"], "running");
    served.post("/api/kill", json!({}));
    assert_eq!(followed(&mut live).last().unwrap()["state"], "killed");
    // The board that is served has not moved.
    assert_eq!(served.axis(1)["position"], 0);
}

/// A message without its type.
fn untyped(message: &Value) -> Value {
    let mut bare = message.clone();
    bare.as_object_mut().unwrap().remove("type");
    bare
}

#[test]
fn a_stop_brakes_a_run_along_its_path() {
    let mut served = Served::board();
    let mut live = served.live();
    served.order("/api/path/run", line());
    let moving = loop {
        let report = next(&mut live, "path");
        if number(&report, "seconds") > 0.5 {
            break report;
        }
    };
    // Everybody may.
    let key = std::mem::take(&mut served.key);
    served.order("/api/stop", json!({}));
    let reports = followed(&mut live);
    let last = reports.last().unwrap();
    assert_eq!(last["state"], "stopped");
    let braking = reports.iter().find(|one| one["state"] == "braking").unwrap();
    // From where it was told to: v/a and v²/2a, and 4 ms of steps that were handed out already.
    let took = number(last, "seconds") - number(braking, "seconds");
    assert!((0.1..=0.105).contains(&took), "{took} s");
    let far = place(last) - place(braking);
    assert!((2.5e6 - STEP..=2.5e6 + 0.005 * 50e6).contains(&far), "{far} nm");
    assert!(place(&moving) < place(last) && place(last) < 90e6, "{last}");
    // Only who controls runs anything.
    let said = served.declined("/api/path/run", line(), 409);
    assert!(said.contains("controls the board"), "{said}");
    served.key = key;
    // What is no file is not run.
    served.declined("/api/path/run", json!({"name": "a", "text": "x = 1"}), 422);
    assert_eq!(served.get("/api/path")["state"], "stopped");
}

/// A board that plays cycles, at a pseudo-terminal: the virtual one, in real time. Its motors are
/// where they are told to be.
#[cfg(unix)]
mod board {
    use std::cell::Cell;
    use std::io::{Read, Write};
    use std::thread;
    use std::time::{Duration, Instant};

    use stepwright::Rate;
    use stepwright_cycle::{Clock, Leg, Motor};
    use stepwright_sim::{CycleBoard, CycleLineBoard, Edge, Stand};

    const ABOUT: &str =
        "stepwright-cycle mega hz=16000000 axes=4 legs=400 late=0 can=sum,brakes,home,tick,paths";

    /// Its path.
    pub fn start() -> String {
        let (master, path) = crate::common::pty();
        rustix::io::ioctl_fionbio(&master, true).unwrap();
        thread::spawn(move || serve(master));
        path
    }

    fn serve(mut master: std::fs::File) {
        let rate = Rate::from_hz(16_000_000).unwrap();
        let (motors, stands) = ([Motor::new(1, 1); 4], [Stand::default(); 4]);
        let board: CycleBoard<Vec<Edge>, 4> =
            CycleBoard::new(motors, stands, Clock::Deadlines, rate, Vec::new());
        let legs = (0..400).map(|_| Cell::new(Leg::Steps { count: 0, delay: 0 }));
        let legs: &'static [Cell<Leg>] = legs.collect::<Vec<_>>().leak();
        let mut board = CycleLineBoard::new(board, legs);
        let (begun, mut line) = (Instant::now(), Vec::new());
        loop {
            let mut bytes = [0; 64];
            // Nobody is there, or nothing is said.
            let count = master.read(&mut bytes).unwrap_or(0);
            for byte in &bytes[..count] {
                line.push(*byte);
                if *byte != b'\r' {
                    continue;
                }
                let line = std::mem::take(&mut line);
                if line == b"?\r" {
                    write!(master, "{ABOUT}\r").unwrap();
                    continue;
                }
                if line.starts_with(b"?*") {
                    let sum = ABOUT.bytes().fold(0, stepwright_protocol::crc);
                    write!(master, "{ABOUT}*{sum:02X}\r").unwrap();
                    continue;
                }
                line.iter().for_each(|byte| board.receive(*byte));
                let _ = master.write_all(&board.take_answers());
            }
            // A board polls all the time.
            board.run_until(begun.elapsed().as_micros() as u64 * 16);
            if count == 0 {
                thread::sleep(Duration::from_micros(500));
            }
        }
    }
}

#[cfg(unix)]
#[test]
fn a_board_that_plays_cycles_runs_a_file_and_says_where_it_is() {
    let port = board::start();
    let served = Served::start(&["--virtual", "--cycles", &port]);
    let table = served.get("/api/path/examples");
    assert_eq!(table["port"], json!(port));
    assert!(table["player"].as_str().unwrap().contains(&port), "{table}");
    let mut live = served.live();
    served.order("/api/path/run", line());
    let reports = followed(&mut live);
    let last = reports.last().unwrap();
    assert_eq!((&last["state"], &last["trouble"]), (&json!("done"), &Value::Null), "{last}");
    assert_eq!(place(last), 101e6);
    assert!((2.1..2.12).contains(&number(last, "seconds")), "{last}");
    // Looks while it moved, each where the line is at the board's own time.
    let cruise = |one: &&Value| (0.1..2.0).contains(&number(one, "seconds"));
    let cruising: Vec<_> = reports.iter().filter(cruise).collect();
    assert!(cruising.len() >= 3, "{}", cruising.len());
    for report in cruising {
        let off = place(report) - 1e6 - (50e6 * number(report, "seconds") - 2.5e6);
        assert!(off.abs() <= 2.0 * STEP + 50e6 * 0.002, "{report}: {off} nm");
    }
    // A stop ends the cycle on the board, wherever it is.
    served.order("/api/path/run", line());
    while number(&next(&mut live, "path"), "seconds") < 0.5 {}
    served.order("/api/stop", json!({}));
    let stopped = followed(&mut live).last().unwrap().clone();
    assert_eq!(stopped["state"], "stopped");
    assert!(place(&stopped) > 20e6 && place(&stopped) < 95e6, "{stopped}");
    // What the board refuses is told, with the line of the file.
    let five = (1..=5)
        .map(|n| format!("[[motor]]\nname = \"M{n}\"\nstep = 1\nsmallest-delay-us = 1000\n"));
    let five = five.collect::<String>() + "[[cycle]]\nmove.M1 = { steps = 10 }\n";
    served.order("/api/path/run", json!({"name": "five.toml", "text": five}));
    let failed = followed(&mut live).last().unwrap().clone();
    assert_eq!(failed["state"], "failed");
    let said = failed["trouble"]["what"].as_str().unwrap();
    assert!(said.starts_with("five.toml, line 17: this mega moves 4 motors"), "{failed}");
    assert!(failed["trouble"]["do"].is_string(), "{failed}");
}
