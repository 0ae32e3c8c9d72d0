//! G-code jobs drawn and run by `stepwright serve`: against the numbers of the job, and against
//! what `stepwright gcode` plans.

use std::time::Instant;

use crate::common::{self, Running, stepwright};
use crate::served::{Served, answered, next};
use serde_json::{Value, json};

const BADGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/gcode/badge.nc");

/// nm in a mm.
const MM: f64 = 1e6;

/// A step of a usual machine, in nm.
const STEP: f64 = 12_500.0;

/// What a line of a job does: its kind, its number, where it ends, in mm; of an arc the centre and
/// the radius.
type End = (&'static str, u64, [f64; 3], Option<[f64; 3]>);

fn file(name: &str, text: &str) -> Value {
    json!({"name": name, "text": text})
}

fn badge() -> String {
    std::fs::read_to_string(BADGE).unwrap()
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().unwrap().iter().map(|one| one.as_f64().unwrap()).collect()
}

fn number(of: &Value, name: &str) -> f64 {
    of[name].as_f64().unwrap_or_else(|| panic!("{name}: {of}"))
}

fn places(drawing: &Value) -> [Vec<f64>; 3] {
    [0, 1, 2].map(|axis| numbers(&drawing["places"][axis]))
}

fn fact<'a>(drawing: &'a Value, name: &str) -> Option<&'a str> {
    let facts = drawing["facts"].as_array().unwrap();
    facts.iter().find(|fact| fact["name"] == name)?["value"].as_str()
}

/// The same time: a plan has twelve digits.
#[track_caller]
fn same_time(drawing: &Value, plan: &Value) {
    let [drawn, planned] = [drawing, plan].map(|of| number(of, "seconds"));
    assert!((drawn - planned).abs() <= 1e-11 * planned, "{drawn} {planned}");
}

/// What `stepwright gcode --plan` says of a job.
fn planned(job: &str, options: &[&str]) -> Value {
    let args = [&["gcode", "-", "--plan", "--format", "json"], options].concat();
    let mut running = Running::start(&args);
    std::io::Write::write_all(&mut running.child.stdin.take().unwrap(), job.as_bytes()).unwrap();
    let ended = running.end();
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    serde_json::from_str(&ended.stdout).unwrap()
}

#[test]
fn a_job_is_drawn_where_it_goes_and_takes_as_long_as_it_is_planned() {
    let served = Served::board();
    let drawing = served.order("/api/path", file("badge.nc", &badge()));
    let plan = planned(&badge(), &["--machine", "none"]);
    assert_eq!((&drawing["kind"], &drawing["unit"]), (&json!("gcode"), &json!("nm")));
    same_time(&drawing, &plan);
    assert_eq!(drawing["refused"], Value::Null);
    assert_eq!(fact(&drawing, "Time"), Some(&*format!("{:.6} s", number(&plan, "seconds"))));
    assert_eq!(fact(&drawing, "X"), Some("0 to 50 mm"));
    assert_eq!(fact(&drawing, "Z"), Some("-1 to 3 mm"));
    // Four quarters of 5 mm and a circle of 7 mm.
    assert_eq!(fact(&drawing, "Arcs"), Some("5, 75.398 mm"));
    let corners = drawing["facts"].as_array().unwrap().iter();
    let corners: Vec<_> = corners.filter_map(|fact| fact["line"].as_u64()).collect();
    let right = plan["corners"]["rows"].as_array().unwrap().iter();
    assert_eq!(corners, right.map(|one| one["line"].as_u64().unwrap()).collect::<Vec<_>>());

    let (times, [x, y, z]) = (numbers(&drawing["times"]), places(&drawing));
    assert!(times.is_sorted() && times.len() < 2_000, "{}", times.len());
    // By the lines of the file: where each move ends, and the centre of an arc.
    let legs = drawing["legs"].as_array().unwrap();
    let right: [End; 17] = [
        ("rapid", 4, [0.0, 0.0, 3.0], None),
        ("rapid", 5, [5.0, 0.0, 3.0], None),
        ("line", 6, [5.0, 0.0, -1.0], None),
        ("line", 7, [45.0, 0.0, -1.0], None),
        ("arc", 8, [50.0, 5.0, -1.0], Some([45.0, 5.0, 5.0])),
        ("line", 9, [50.0, 25.0, -1.0], None),
        ("arc", 10, [45.0, 30.0, -1.0], Some([45.0, 25.0, 5.0])),
        ("line", 11, [5.0, 30.0, -1.0], None),
        ("arc", 12, [0.0, 25.0, -1.0], Some([5.0, 25.0, 5.0])),
        ("line", 13, [0.0, 5.0, -1.0], None),
        ("arc", 14, [5.0, 0.0, -1.0], Some([5.0, 5.0, 5.0])),
        ("rapid", 15, [5.0, 0.0, 3.0], None),
        ("rapid", 16, [32.0, 15.0, 3.0], None),
        ("line", 17, [32.0, 15.0, -0.5], None),
        ("arc", 18, [32.0, 15.0, -0.5], Some([25.0, 15.0, 7.0])),
        ("rapid", 19, [32.0, 15.0, 3.0], None),
        ("rapid", 21, [0.0, 0.0, 3.0], None),
    ];
    assert_eq!(legs.len(), right.len());
    let mut next = 0;
    for (leg, (kind, line, end, round)) in legs.iter().zip(right) {
        assert_eq!((&leg["kind"], &leg["line"]), (&json!(kind), &json!(line)));
        let (first, last) = (leg["first"].as_u64().unwrap(), leg["last"].as_u64().unwrap());
        assert_eq!(first, next);
        next = last + 1;
        let at = |n: u64| [&x, &y, &z].map(|places| places[n as usize] / MM);
        assert_eq!(at(last), end, "{line}");
        if let Some([cx, cy, radius]) = round {
            let off = |n: u64| ((at(n)[0] - cx).hypot(at(n)[1] - cy) - radius).abs();
            assert!((first..=last).all(|n| off(n) < 0.001), "{line}");
            // The chords of a picture of 50 mm: within a few thousandths of it.
            let turned = (first..last).map(|n| {
                let [a, b] = [at(n), at(n + 1)].map(|p| (p[1] - cy).atan2(p[0] - cx));
                (b - a + 9.0 * std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
                    - std::f64::consts::PI
            });
            assert!(turned.clone().all(|turn| turn.abs() < 0.25), "{line}");
            let (all, full) = (turned.sum::<f64>().abs(), if line == 18 { 4.0 } else { 1.0 });
            assert!((all - full * std::f64::consts::FRAC_PI_2).abs() < 1e-4, "{line}: {all}");
        }
    }
    // F600 is 10 mm/s; a rapid move along X is at the top speed of 200 mm/s or below.
    let outline = &legs[3];
    assert_eq!((number(outline, "peak"), number(outline, "ordered")), (10.0 * MM, 10.0 * MM));
    assert_eq!(legs[1]["ordered"], Value::Null);
}

/// Speeds between the points are those of the way.
#[test]
fn the_speeds_of_a_drawing_are_those_of_its_way() {
    let served = Served::board();
    let job = "G1 F6000 X40\nX40.5 Y3\nG2 X60.5 Y3 I10\nG4 P0.5\nG0 X-10 Y-20 Z5\nG1 F300 X-9\n";
    let drawing = served.order("/api/path", file("a.NGC", job));
    let (times, speeds) = (numbers(&drawing["times"]), numbers(&drawing["speeds"]));
    let places = places(&drawing);
    let mut way = 0.0;
    for n in 1..times.len() {
        let time = times[n] - times[n - 1];
        let part = places.iter().map(|axis| axis[n] - axis[n - 1]).fold(0.0, f64::hypot);
        let mean = (speeds[n] + speeds[n - 1]) / 2.0;
        // 1 % of the peak, and a chord of an arc.
        assert!((part - mean * time).abs() <= 0.012 * 250.0 * MM * time + 0.02 * MM, "{n}");
        way += part;
    }
    // 40 + √9.25 + an arc + √(70² + 23² + 5²) + 1 mm.
    assert!((way / MM - 148.5).abs() < 1.5, "{way}");
    let rest = drawing["legs"].as_array().unwrap().iter().find(|leg| leg["kind"] == "rest");
    let rest = rest.unwrap();
    assert_eq!((&rest["line"], number(rest, "peak")), (&json!(4), 0.0));
    assert!((number(rest, "end") - number(rest, "begin") - 0.5).abs() < 2e-6, "{rest}");
}

#[test]
fn what_is_wrong_with_a_job_is_told_with_line_and_column() {
    let served = Served::board();
    for (job, what) in [
        ("G0 X1\nG1 X5 F-1\n", "a.gcode, line 2, column 7: error 4: F is negative"),
        ("G1 F100 X5\n\n(a\nG5\n", "a.gcode, line 4, column 1: error 20: this code"),
        ("[[motor]]\n", "a.gcode, line 1, column 1: error 1: no word begins here"),
    ] {
        let said = served.declined("/api/path", file("a.gcode", job), 422);
        assert!(said.starts_with(what), "{said}");
        served.declined("/api/path/run", file("a.gcode", job), 422);
    }
    assert_eq!(served.get("/api/path"), Value::Null);
    // A job without a move is none that goes wrong.
    for job in ["", "(nothing)\n", "G21 G90\nM30\n"] {
        let drawing = served.order("/api/path", file("a.nc", job));
        assert_eq!(
            (number(&drawing, "seconds"), drawing["legs"].as_array().unwrap().len()),
            (0.0, 1)
        );
    }
}

/// Speeds, accelerations and steps are those of the machine file, as `stepwright gcode` has them.
#[test]
fn a_job_goes_by_the_machine_file() {
    let folder = tempfile::tempdir().unwrap();
    let machine = folder.path().join("slow.toml");
    let axis = |n, top| {
        format!(
            "[axis.{n}]\nsteps-per-rev = 1600\nmm-per-rev = 8\ntop-speed = \"{top}mm/s\"\naccel = \"90mm/s2\"\n"
        )
    };
    let text = [axis(1, 30), axis(2, 25), axis(3, 4)].concat();
    std::fs::write(&machine, text).unwrap();
    let machine = machine.to_str().unwrap();
    let served = Served::on(&["--machine", machine, "--virtual"]);
    let drawing = served.order("/api/path", file("badge.nc", &badge()));
    let plan = planned(&badge(), &["--machine", machine]);
    same_time(&drawing, &plan);
    assert_ne!(drawing["seconds"], planned(&badge(), &["--machine", "none"])["seconds"]);
    assert_eq!(drawing["motors"][0]["step"], 5_000.0);
}

/// What the board can't do is drawn, and not run.
#[test]
fn a_job_that_is_too_fast_for_the_board_is_drawn_and_not_run() {
    let folder = tempfile::tempdir().unwrap();
    let machine = folder.path().join("fast.toml");
    let text = "[axis.1]\nsteps-per-rev = 12800\nmm-per-rev = 40\ntop-speed = \"500mm/s\"\n";
    std::fs::write(&machine, text).unwrap();
    let served = Served::on(&["--machine", machine.to_str().unwrap(), "--virtual"]);
    let job = file("fast.nc", "G4 P0.1\nG0 X400\n");
    let drawing = served.order("/api/path", job.clone());
    let refused = drawing["refused"].as_str().unwrap();
    assert!(refused.starts_with("An Uno would refuse it: in line 2 X comes to"), "{refused}");
    let said = served.declined("/api/path/run", job, 422);
    assert!(said.contains(refused), "{said}");
}

/// A long job has a drawing of bounded size, and the server answers others meanwhile.
#[test]
fn a_long_job_holds_nothing_up() {
    let served = Served::board();
    let line = |n: u32| {
        let (angle, radius) = (f64::from(n) * 0.02, 20.0 + f64::from(n % 1_000) * 0.05);
        format!("G1 X{:.3} Y{:.3}\n", radius * angle.cos(), radius * angle.sin())
    };
    let job = format!("F3000\n{}", (0..100_000).map(line).collect::<String>());
    let waiting = served.send("POST", "/api/path", &file("long.nc", &job).to_string());
    let mut slowest = 0.0_f64;
    for _ in 0..20 {
        let begun = Instant::now();
        served.get("/api/state");
        slowest = slowest.max(begun.elapsed().as_secs_f64());
    }
    assert!(slowest < 1.0, "{slowest} s");
    let (status, drawing) = answered(waiting);
    assert_eq!(status, 200, "{drawing}");
    let count = drawing["times"].as_array().unwrap().len();
    assert!((5_000..=20_400).contains(&count), "{count}");
    let legs = drawing["legs"].as_array().unwrap();
    assert!((300..=400).contains(&legs.len()), "{}", legs.len());
    assert_eq!((&legs[0]["kind"], &legs[0]["line"]), (&json!("lines"), &json!(2)));
    assert_eq!(legs.last().unwrap()["to_line"], 100_001);
    for two in legs.windows(2) {
        assert_eq!(number(&two[0], "to_line") + 1.0, number(&two[1], "line"));
        assert_eq!(number(&two[0], "last") + 1.0, number(&two[1], "first"));
    }
    let plan = planned(&job, &["--machine", "none"]);
    same_time(&drawing, &plan);
    // Each point is on the spiral, once it has come there: no corner was cut by more than a little
    // of the picture.
    let [x, y, _] = places(&drawing);
    let radii = x.iter().zip(&y).map(|(x, y)| x.hypot(*y) / MM);
    assert!(radii.skip_while(|r| *r < 19.9).all(|radius| (19.9..70.1).contains(&radius)));

    // What is longer is refused: a request of 4,000,000 bytes, a cycle file of 200,000.
    served.declined("/api/path", file("a.nc", &" ".repeat(4_000_000)), 413);
    let said = served.declined("/api/path", file("a.txt", &" ".repeat(200_001)), 422);
    assert!(said.contains("too long for a cycle file"), "{said}");
}

/// The reports of a run up to its end, as a page hears them.
fn followed(live: &mut tungstenite::WebSocket<std::net::TcpStream>) -> Vec<Value> {
    let (mut all, begun) = (Vec::<Value>::new(), Instant::now());
    let going = ["running", "held", "braking"];
    while all.last().is_none_or(|last| going.contains(&last["state"].as_str().unwrap())) {
        assert!(begun.elapsed() < common::LIMIT, "it goes on and on: {:?}", all.last());
        all.push(next(live, "path"));
    }
    all
}

/// 100 mm at 50 mm/s: X goes 80 mm up, Y 60 mm down.
const SLANT: &str = "G1 F3000 X80 Y-60\nM30\n";

#[test]
fn a_run_of_a_job_takes_its_time_and_ends_where_the_job_does() {
    let served = Served::board();
    let mut live = served.live();
    let drawing = served.order("/api/path", file("slant.nc", SLANT));
    let seconds = number(&drawing, "seconds");
    assert!((2.0..2.1).contains(&seconds), "{seconds}");
    let begun = Instant::now();
    served.order("/api/path/run", file("slant.nc", SLANT));
    let said = served.declined("/api/path/run", file("slant.nc", SLANT), 409);
    assert!(said.contains("a file is being run"), "{said}");
    let reports = followed(&mut live);
    assert!(begun.elapsed().as_secs_f64() >= seconds);
    let last = reports.last().unwrap();
    assert_eq!((&last["state"], &last["trouble"]), (&json!("done"), &Value::Null));
    assert_eq!(last["places"], json!([80_000_000, -60_000_000, 0]));
    assert!((number(last, "seconds") - seconds).abs() < 1e-6, "{last} {seconds}");
    assert_eq!(last["id"], drawing["id"]);
    assert!(reports.len() > 20, "{}", reports.len());
    // Each is where the line is then: between two points of the drawing.
    let (times, [x, ..]) = (numbers(&drawing["times"]), places(&drawing));
    for report in &reports {
        let (t, at) = (number(report, "seconds"), numbers(&report["places"]));
        assert!((at[0] * 0.75 + at[1]).abs() <= 2.0 * STEP, "{report}");
        let n = times.partition_point(|time| *time < t).clamp(1, times.len() - 1);
        let part = ((t - times[n - 1]) / (times[n] - times[n - 1])).clamp(0.0, 1.0);
        let off = at[0] - x[n - 1] - (x[n] - x[n - 1]) * part;
        // A step, what lies between two looks at it, and what the drawing leaves out.
        assert!(off.abs() <= 2.0 * STEP + 0.03 * MM, "{t}: {off} nm");
    }
    // The board that is served has not moved.
    assert_eq!(served.axis(1)["position"], 0);
}

#[test]
fn a_stop_brakes_a_job_along_its_path_and_a_kill_ends_it() {
    let served = Served::board();
    let mut live = served.live();
    served.order("/api/path/run", file("slant.nc", SLANT));
    while number(&next(&mut live, "path"), "seconds") < 0.5 {}
    served.order("/api/stop", json!({}));
    let reports = followed(&mut live);
    let last = reports.last().unwrap();
    assert_eq!(last["state"], "stopped");
    let braking = reports.iter().find(|one| one["state"] == "braking").unwrap();
    let [from, to] = [braking, last].map(|one| numbers(&one["places"]));
    // On the line, by its ramp: no less than v²/2a of the axis that brakes hardest, 80 % of it X.
    assert!((to[0] * 0.75 + to[1]).abs() <= 2.0 * STEP, "{last}");
    let far = (to[0] - from[0]) / MM;
    assert!((0.5..3.0).contains(&far), "{far} mm");
    assert!(to[0] < 60.0 * MM, "{last}");

    served.order("/api/path/run", file("slant.nc", SLANT));
    while number(&next(&mut live, "path"), "seconds") < 0.3 {}
    served.post("/api/kill", json!({}));
    let killed = followed(&mut live).last().unwrap().clone();
    assert_eq!(killed["state"], "killed");
    assert!(numbers(&killed["places"])[0] < 70.0 * MM, "{killed}");
}

/// A job that is still being drawn is not begun behind a stop.
#[test]
fn a_stop_before_a_job_has_begun_keeps_it_from_it() {
    let served = Served::board();
    // Drawn in a tenth of a second, or much later.
    let line = |n: u32| format!("G1 X{:.3} Y{}\n", f64::from(n) * 0.001, n % 2);
    let job = format!("F3000\n{}", (0..100_000).map(line).collect::<String>());
    let waiting = served.send("POST", "/api/path/run", &file("late.nc", &job).to_string());
    std::thread::sleep(std::time::Duration::from_millis(50));
    served.order("/api/stop", json!({}));
    let (status, said) = answered(waiting);
    assert_eq!((status, &said["what"]), (409, &json!("it was stopped before it had begun")));
    assert_eq!(served.get("/api/path"), Value::Null);
}

/// `stepwright gcode` is what plays it: the same end.
#[test]
fn the_command_ends_at_the_same_place() {
    let ended = stepwright(&["gcode", BADGE, "--machine", "none", "--fast", "--format", "json"]);
    let found: Value = serde_json::from_str(&ended.stdout).unwrap();
    let served = Served::board();
    let drawing = served.order("/api/path", file("badge.nc", &badge()));
    let last = places(&drawing).map(|places| *places.last().unwrap());
    assert_eq!(numbers(&found["position_mm"]), last.map(|place| place / MM));
    // To a tick.
    let off = number(&found, "seconds") - number(&drawing, "seconds");
    assert!(off.abs() * 16e6 < 1.0, "{off}");
}

/// Runs [`SLANT`], holds it at some 0.5 s until it stands, and has it go on: the reports.
fn held_and_resumed(served: &Served) -> Vec<Value> {
    let mut live = served.live();
    served.order("/api/path/run", file("slant.nc", SLANT));
    while number(&next(&mut live, "path"), "seconds") < 0.5 {}
    served.order("/api/path/hold", json!({}));
    let mut held = 0;
    let mut all = Vec::new();
    while held < 60 {
        let report = next(&mut live, "path");
        held += usize::from(report["state"] == "held");
        let goes_on = ["running", "held"].contains(&report["state"].as_str().unwrap());
        all.push(report);
        if !goes_on {
            return all;
        }
    }
    served.order("/api/path/resume", json!({}));
    all.extend(followed(&mut live));
    all
}

/// Likewise, again where a busy computer has kept the board short: it brakes then, and says so.
fn held_on_a_board(served: &Served) -> Vec<Value> {
    for _ in 0..10 {
        let reports = held_and_resumed(served);
        let trouble = reports[reports.len() - 1]["trouble"]["what"].as_str();
        if !trouble.is_some_and(|what| what.contains("short of what comes next")) {
            return reports;
        }
    }
    panic!("the board was always short of what comes next");
}

/// It brakes on its line, stands, and ends where it would have without the hold.
fn holds_on_its_line(reports: &[Value]) {
    let place = |report: &Value| numbers(&report["places"]);
    let held: Vec<_> = reports.iter().filter(|one| one["state"] == "held").collect();
    let (first, last) = (place(held[0]), place(held[held.len() - 1]));
    // At 50 mm/s and 1,000 mm/s²: 40 ms to rest, X has 80 % of the way.
    assert!((0.2..3.5).contains(&((last[0] - first[0]) / MM)), "{first:?} {last:?}");
    assert!((10.0..40.0).contains(&(last[0] / MM)), "{last:?}");
    // At rest for more than half of the hold, and on the line.
    assert!(held[held.len() / 2..].iter().all(|one| place(one) == last), "{held:?}");
    assert!(reports.iter().all(|one| (place(one)[0] * 0.75 + place(one)[1]).abs() <= 2.0 * STEP));
    let end = &reports[reports.len() - 1];
    assert_eq!((&end["state"], &end["trouble"]), (&json!("done"), &Value::Null));
    assert_eq!(end["places"], json!([80_000_000, -60_000_000, 0]));
    // The time of the hold is left out, but for its ramps.
    assert!((2.0..2.25).contains(&number(end, "seconds")), "{end}");
}

#[test]
fn a_job_is_held_and_goes_on() {
    let mut served = Served::board();
    let said = served.declined("/api/path/hold", json!({}), 409);
    assert!(said.contains("no file is being run"), "{said}");
    holds_on_its_line(&held_and_resumed(&served));
    let said = served.declined("/api/path/resume", json!({}), 409);
    assert!(said.contains("no file is being run"), "{said}");
    // A stop ends a hold.
    let mut live = served.live();
    served.order("/api/path/run", file("slant.nc", SLANT));
    served.order("/api/path/hold", json!({}));
    while next(&mut live, "path")["state"] != "held" {}
    // Who controls, alone, has it go on; everybody may stop it.
    let key = std::mem::take(&mut served.key);
    served.declined("/api/path/resume", json!({}), 409);
    served.order("/api/stop", json!({}));
    served.key = key;
    assert_eq!(followed(&mut live).last().unwrap()["state"], "stopped");
    let cycle = std::fs::read_to_string(format!(
        "{}/../../examples/cycles/drawing.toml",
        env!("CARGO_MANIFEST_DIR")
    ));
    served.order("/api/path/run", file("drawing.toml", &cycle.unwrap()));
    let said = served.declined("/api/path/hold", json!({}), 409);
    assert!(said.contains("a cycle file can't be held"), "{said}");
}

/// The same on a board that plays streams: the virtual one at a pseudo-terminal, in real time.
#[cfg(unix)]
#[test]
fn a_board_that_plays_streams_runs_a_job() {
    let board = common::PtyBoard::new(&["--program", "stream"]);
    let served = Served::start(&["--virtual", "--stream", &board.1]);
    let table = served.get("/api/path/examples");
    assert_eq!((&table["job_port"], &table["port"]), (&json!(board.1), &Value::Null));
    assert!(table["jobs"].as_str().unwrap().contains(&board.1), "{table}");
    let mut live = served.live();
    // 1 axis is as good as 3.
    served.order("/api/path/run", file("there.nc", "G1 F1200 X-3\n"));
    let reports = followed(&mut live);
    let last = reports.last().unwrap();
    assert_eq!((&last["state"], &last["trouble"]), (&json!("done"), &Value::Null), "{last}");
    assert_eq!(last["places"], json!([-3_000_000, 0, 0]));
    // On the way it is followed.
    assert!(reports.iter().any(|one| (-2.5e6..-0.5e6).contains(&numbers(&one["places"])[0])));
    holds_on_its_line(&held_on_a_board(&served));

    // What that told is not of this run.
    let mut live = served.live();
    served.order("/api/path/run", file("slant.nc", SLANT));
    while number(&next(&mut live, "path"), "seconds") < 0.5 {}
    served.order("/api/stop", json!({}));
    let stopped = followed(&mut live).last().unwrap().clone();
    assert_eq!(stopped["state"], "stopped", "{stopped}");
    let to = numbers(&stopped["places"]);
    assert!((to[0] * 0.75 + to[1]).abs() <= 2.0 * STEP && to[0] < 60.0 * MM, "{stopped}");

    served.order("/api/path/run", file("slant.nc", SLANT));
    while number(&next(&mut live, "path"), "seconds") < 0.3 {}
    served.post("/api/kill", json!({}));
    assert_eq!(followed(&mut live).last().unwrap()["state"], "killed");

    // A stop that comes before the board has begun keeps it from it. A busy computer may stop too late.
    let stopped = |_| {
        served.order("/api/path/run", file("slant.nc", SLANT));
        served.order("/api/stop", json!({}));
        followed(&mut live).last().unwrap().clone()
    };
    let mut stopped = (0..10).map(stopped).inspect(|last| assert_eq!(last["state"], "stopped"));
    assert!(stopped.any(|last| last["places"] == json!([0, 0, 0])));
    drop(stopped);

    // A board that is not there is told, and the page lives on.
    drop(board);
    served.order("/api/path/run", file("slant.nc", SLANT));
    let failed = followed(&mut live).last().unwrap().clone();
    assert_eq!(failed["state"], "failed");
    assert!(failed["trouble"]["do"].is_string(), "{failed}");
}

/// It brakes for as long as it has run.
#[cfg(unix)]
#[test]
fn a_second_signal_kills_a_run() {
    use rustix::process::Signal;
    let folder = tempfile::tempdir().unwrap();
    let machine = folder.path().join("heavy.toml");
    std::fs::write(
        &machine,
        "[axis.1]\nsteps-per-rev = 1600\nmm-per-rev = 8\naccel = \"5mm/s2\"\n",
    )
    .unwrap();
    let board = common::PtyBoard::new(&["--program", "stream"]);
    for on in [&[][..], &["--stream", &board.1]] {
        let args = [&["--machine", machine.to_str().unwrap(), "--virtual"], on].concat();
        let served = Served::on(&args);
        let mut live = served.live();
        served.order("/api/path/run", file("far.nc", "G1 F3000 X300\n"));
        while number(&next(&mut live, "path"), "seconds") < 4.0 {}
        served.command.signal(Signal::INT);
        std::thread::sleep(std::time::Duration::from_millis(300));
        let second = Instant::now();
        served.command.signal(Signal::INT);
        served.command.end();
        assert!(second.elapsed().as_secs_f64() < 2.5, "{:?}", second.elapsed());
    }
}

#[test]
fn a_port_is_one_board() {
    for two in [["--cycles", "--stream"], ["--port", "--stream"]] {
        let ended = stepwright(&["serve", two[0], "/dev/x", two[1], "/dev/x"]);
        assert_eq!(ended.code(), Some(2), "{}", ended.stderr);
        assert!(ended.stderr.contains("are two boards"), "{}", ended.stderr);
    }
}
