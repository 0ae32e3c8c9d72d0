//! `gcode FILE --laser --port` and `grbl --port` on `board --pty --program stream`: the power beside the edges, by
//! its dump alone.
#![cfg(unix)]

use rustix::process::Signal;

use crate::common::{PtyBoard, Running, Scratch, stepwright, stepwright_with};

/// Steps of X in a mm.
const STEPS_MM: f64 = 80.0;

/// What a dump has: the position of X in mm, and its time, where the laser's power changes to this.
#[derive(Debug)]
struct Change {
    x: f64,
    seconds: f64,
    power: f64,
}

/// The changes of a dump, and each step of X: its time and where it leads, in mm.
fn read(dump: &str) -> (Vec<Change>, Vec<(f64, f64)>) {
    let head = dump.split("$enddefinitions").next().unwrap();
    let id = |name: &str| {
        let line = head.lines().find(|line| line.split(' ').nth(4) == Some(name));
        line.unwrap_or_else(|| panic!("{head}")).split(' ').nth(3).unwrap().to_owned()
    };
    let scale = head.split("$timescale").nth(1).unwrap().split("$end").next().unwrap().trim();
    let (count, unit) = scale.split_once(' ').unwrap();
    let unit = count.parse::<f64>().unwrap() * if unit == "ps" { 1e-12 } else { 1e-9 };
    let (step, dir, laser) = (id("step1"), id("dir1"), id("laser"));
    let (mut time, mut x, mut forward) = (0.0, 0i64, true);
    let (mut changes, mut steps) = (vec![], vec![]);
    for line in dump.lines() {
        if let Some(ticks) = line.strip_prefix('#') {
            time = ticks.parse::<f64>().unwrap() * unit;
        } else if let Some(value) = line.strip_prefix('r') {
            let (value, name) = value.split_once(' ').unwrap();
            if name == laser {
                let power = value.parse().unwrap();
                changes.push(Change { x: x as f64 / STEPS_MM, seconds: time, power });
            }
        } else if *line == format!("1{step}") {
            x += if forward { 1 } else { -1 };
            steps.push((time, x as f64 / STEPS_MM));
        } else if let Some(level) = line.strip_suffix(&*dir) {
            forward = level == "1";
        }
    }
    (changes, steps)
}

/// Runs a job on a board, and reads its dump.
fn streamed(text: &str, options: &[&str]) -> (Vec<Change>, Vec<(f64, f64)>) {
    let dump = Scratch::new("laser.vcd");
    let job = Scratch::new("laser.nc");
    std::fs::write(job.path(), text).unwrap();
    let board = PtyBoard::new(&["--program", "stream", "--vcd", dump.path()]);
    let command = ["gcode", job.path(), "--laser", "--port", &board.1];
    let ended = stepwright(&[&command, options].concat());
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    board.0.signal(Signal::INT);
    assert_eq!(board.0.end().code(), Some(0));
    read(&std::fs::read_to_string(dump.path()).unwrap())
}

/// A change is made within this many ms.
const WITHIN: f64 = 0.2;

#[test]
fn a_constant_power_is_on_along_its_moves() {
    let (changes, steps) =
        streamed("M3 S500\nG0 X10\nG1 X30 F6000\nS250 X40\nG0 X50\nG1 X60 S1000\n", &[]);
    // By M3 on, other, off on the rapid, on, off at the end; the first one is before the first step.
    let wanted = [(10.0, 0.5), (30.0, 0.25), (40.0, 0.0), (50.0, 1.0), (60.0, 0.0)];
    let changes: Vec<_> = changes.iter().skip_while(|change| change.power == 0.0).collect();
    assert_eq!(changes.len(), wanted.len(), "{changes:?}");
    for (change, (x, power)) in changes.iter().zip(wanted) {
        assert!((change.power - power).abs() < 0.003, "{change:?}");
        // 100 mm/s, 200 on a rapid.
        assert!((change.x - x).abs() <= 200.0 * WITHIN / 1e3 + 1.0 / STEPS_MM, "{change:?}");
    }
    assert_eq!(steps.len(), 60 * 80);
}

/// M4 is in proportion to the speed: of each change, by the steps around it.
#[test]
fn a_power_by_the_speed_follows_the_steps() {
    for options in [&[][..], &["--jerk", "20000"]] {
        let (changes, steps) = streamed("M4 S1000\nG1 X60 F6000\nG1 X20\n", options);
        assert!(changes.len() > 300, "{}", changes.len());
        let speed = |at: f64| {
            let n = steps.partition_point(|step| step.0 < at).clamp(8, steps.len() - 8);
            let (from, to) = (steps[n - 8], steps[n + 7]);
            (to.1 - from.1).abs() / (to.0 - from.0)
        };
        let mut far = 0;
        for pair in changes.windows(2) {
            // Where the speed turns its mean over 15 steps is none.
            let middle = (pair[0].seconds + pair[1].seconds) / 2.0;
            if pair[0].power > 0.2 {
                far += usize::from((pair[0].power - speed(middle) / 100.0).abs() > 0.02);
            }
        }
        assert!(far * 50 < changes.len(), "{far} of {}", changes.len());
        assert_eq!(changes.last().unwrap().power, 0.0);
    }
}

/// Ctrl-C brakes along the path: the laser burns to the rest, and goes off there.
#[test]
fn a_brake_ends_dark() {
    let dump = Scratch::new("laser.vcd");
    let job = Scratch::new("laser.nc");
    std::fs::write(job.path(), "M3 S500\nG1 X100 F1200\n").unwrap();
    let board = PtyBoard::new(&["--program", "stream", "--vcd", dump.path()]);
    let running = Running::start(&["gcode", job.path(), "--laser", "--port", &board.1]);
    std::thread::sleep(std::time::Duration::from_millis(2_500));
    running.signal(Signal::INT);
    assert_eq!(running.end().code(), Some(130));
    board.0.signal(Signal::INT);
    assert_eq!(board.0.end().code(), Some(0));
    let (changes, steps) = read(&std::fs::read_to_string(dump.path()).unwrap());
    let on: Vec<_> = changes.iter().skip_while(|change| change.power == 0.0).collect();
    let [first, off] = on[..] else { panic!("{on:?}") };
    assert!((first.power - 0.5).abs() < 0.003 && off.power == 0.0, "{on:?}");
    let (last, end) = *steps.last().unwrap();
    assert!(end < 99.0 && (off.seconds - last).abs() < 0.02, "{off:?} {last} {end}");
}

/// A sender's job with `$32=1` by `grbl --port`.
#[test]
fn a_senders_laser_follows_its_moves() {
    let dump = Scratch::new("laser.vcd");
    let board = PtyBoard::new(&["--program", "stream", "--vcd", dump.path()]);
    let settings = "$32=1\n$100=80\n$110=6000\n$120=500\n";
    let job = "M3 S500\nG1 X10 F3000\nG0 X20\nG1 X30 S1000\n";
    let ended = stepwright_with(
        &["grbl", "--stdio", "--port", &board.1],
        format!("{settings}{job}").as_bytes(),
    );
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    assert!(!ended.stdout.contains("error"), "{ended:#?}");
    board.0.signal(Signal::INT);
    assert_eq!(board.0.end().code(), Some(0));
    let (changes, steps) = read(&std::fs::read_to_string(dump.path()).unwrap());
    assert_eq!(steps.len(), 30 * 80);
    let wanted = [(0.0, 0.5), (10.0, 0.0), (20.0, 1.0), (30.0, 0.0)];
    let changes: Vec<_> = changes.iter().skip_while(|change| change.power == 0.0).collect();
    assert_eq!(changes.len(), wanted.len(), "{changes:?}");
    for (change, (x, power)) in changes.iter().zip(wanted) {
        assert!((change.power - power).abs() < 0.003, "{change:?}");
        // 100 mm/s on the rapid; and a step, at which it changes.
        assert!((change.x - x).abs() <= 100.0 * WITHIN / 1e3 + 2.0 / STEPS_MM, "{change:?}");
    }
}
