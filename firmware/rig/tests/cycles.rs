//! `stepwright cycle FILE --port` with the program `cycles` on the chip: every file of
//! `examples/cycles` plays as on the virtual board, edge for edge and row for row of csv, or is
//! refused before anything moves.
//!
//! The command talks to the simulated chip over a pseudo-terminal. The chip's time runs as fast as
//! this machine allows.

use std::collections::BTreeMap;
use std::env;
use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{self, board};
use stepwright_rig::board::Pin as ChipPin;
use stepwright_rig::pty::Pty;
use stepwright_rig::{Board, Chip};

/// The cycles of a µs.
const MICRO: f64 = 16.0;
/// The largest difference between an edge and the virtual board's, in cycles: a stay in the step
/// interrupt that makes three steps takes 1,647 (`cycle_step`), and an edge may wait for it.
/// Measured: 1,502 to 1,609, depending on the line's interrupts.
const EDGE: f64 = 1_700.0;
/// The same beside a leg that turns, which takes that long.
const BESIDE_TURNS: f64 = 6_400.0;
/// The same where a switch closes: the brake is planned then, in the step interrupt.
const BRAKES: f64 = 20_000.0;
/// The same from one part of a homing to the next, which the main loop begins between two bytes of
/// its answers.
const PARTS: f64 = 80_000.0;
/// The same after a pause, which the main loop begins and ends between its answers: 1 ms. Measured:
/// 2,600 to 7,700.
const AFTER_PAUSE: f64 = 16_000.0;
/// The same for a time that the board reports, in µs.
const REPORT: f64 = 1_000.0;
/// The cycles between two checks of the switches.
const SLICE: u64 = 400;
/// On a busy machine.
const LIMIT: Duration = Duration::from_secs(400);

fn command(args: &[&str]) -> Command {
    let path = env::var_os("STEPWRIGHT_COMMAND").expect("STEPWRIGHT_COMMAND: where it is built");
    let mut command = Command::new(PathBuf::from(path));
    command.arg("cycle").args(args).stdin(Stdio::null());
    command
}

fn example(name: &str) -> String {
    format!("{}/../../examples/cycles/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// A switch between a pin and ground, closed while its motor is at `at` steps or beyond.
struct Switch {
    pin: ChipPin,
    motor: usize,
    at: i64,
    below: bool,
    closed: bool,
}

/// A motor's pins.
struct Wires {
    step: ChipPin,
    direction: ChipPin,
}

/// A step of the chip: the time, and the position after it.
#[derive(Clone, Copy, Debug)]
struct Step {
    time: f64,
    forward: bool,
}

/// The board with its motors.
struct Machine {
    chip: Chip,
    pty: Pty,
    switches: Vec<Switch>,
    /// The steps by motor.
    steps: Vec<Vec<Step>>,
    at: Vec<i64>,
    levels: Vec<bool>,
    read: usize,
}

impl Machine {
    fn new(program: &str, wires: &[Wires], mut switches: Vec<Switch>) -> Machine {
        let mut chip = common::program(program);
        let pins: Vec<_> = wires.iter().flat_map(|w| [w.step, w.direction]).collect();
        chip.watch_pins(&pins);
        for switch in &mut switches {
            switch.closed = false;
        }
        Machine {
            chip,
            pty: Pty::open().unwrap(),
            switches,
            steps: vec![Vec::new(); wires.len()],
            at: vec![0; wires.len()],
            levels: vec![false; wires.len()],
            read: 0,
        }
    }

    /// Simulates a slice of time: the line, the motors, the switches.
    fn pass(&mut self) {
        let bytes = self.pty.read().unwrap();
        self.chip.send(&bytes);
        for _ in 0..20 {
            self.chip.run_for(SLICE);
            self.look();
        }
        let said = self.chip.take_said();
        self.pty.write(&said);
    }

    fn look(&mut self) {
        let changes = &self.chip.watched_changes()[self.read..];
        self.read += changes.len();
        for (time, which, level) in changes {
            let motor = usize::from(which / 2);
            if which % 2 == 1 {
                self.levels[motor] = *level;
            } else if *level {
                let forward = self.levels[motor];
                self.at[motor] += if forward { 1 } else { -1 };
                self.steps[motor].push(Step { time: *time as f64, forward });
            }
        }
        for switch in &mut self.switches {
            let at = self.at[switch.motor];
            let closed = if switch.below { at <= switch.at } else { at >= switch.at };
            if closed != switch.closed {
                switch.closed = closed;
                self.chip.pull(switch.pin, closed);
            }
        }
    }

    fn port(&self) -> String {
        self.pty.path().to_str().unwrap().to_owned()
    }

    /// Simulates until a command has ended.
    fn until_ended(&mut self, mut child: Child) -> Output {
        let begun = Instant::now();
        while child.try_wait().unwrap().is_none() {
            self.pass();
            if begun.elapsed() > LIMIT {
                _ = child.kill();
                panic!("it does not end: {:?}", child.wait_with_output());
            }
        }
        child.wait_with_output().unwrap()
    }

    fn play(&mut self, file: &str, format: &str) -> Output {
        let port = self.port();
        let mut command = command(&[file, "--port", &port, "--format", format]);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
        self.until_ended(child.expect("the command"))
    }
}

/// The shield's pins for three motors.
fn shield() -> Vec<Wires> {
    let board = board();
    let pins = board.step().into_iter().zip(board.direction());
    pins.map(|(step, direction)| Wires { step, direction }).collect()
}

/// A row of csv.
#[derive(Clone, Debug)]
struct Row {
    us: f64,
    motor: String,
    event: String,
    value: String,
    position: String,
}

fn rows(csv: &[u8]) -> Vec<Row> {
    let text = std::str::from_utf8(csv).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("time_us,motor,event,value,position"));
    let row = |line: &str| {
        let cells: Vec<_> = line.split(',').collect();
        let [us, motor, event, value, position] = cells[..] else { panic!("{line}") };
        let [motor, event, value, position] = [motor, event, value, position].map(String::from);
        Row { us: us.parse().unwrap(), motor, event, value, position }
    };
    lines.map(row).collect()
}

/// A cycle of the virtual board: the time of its first step, the time at which it was resumed, and
/// the steps of each motor, by its index.
#[derive(Default)]
struct Segment {
    steps: BTreeMap<usize, Vec<Step>>,
    resumed: Option<f64>,
    paused: f64,
}

/// The cycles one after another, with motors by their indices in the file.
fn segments(rows: &[Row], names: &[&str]) -> Vec<Segment> {
    let (mut all, mut forward): (Vec<Segment>, Vec<bool>) = (Vec::new(), vec![false; names.len()]);
    for row in rows {
        let motor = names.iter().position(|name| *name == row.motor);
        let high = row.value == "1";
        let time = row.us * MICRO;
        match (row.event.as_str(), motor) {
            ("cycle", _) if row.value == "start" => all.push(Segment::default()),
            ("cycle", _) if row.value == "resume" => {
                all.last_mut().unwrap().resumed = Some(time);
            }
            ("cycle", _) if row.value == "pause" => all.last_mut().unwrap().paused = time,
            ("dir", Some(motor)) => forward[motor] = high,
            ("step", Some(motor)) if high => {
                let step = Step { time, forward: forward[motor] };
                all.last_mut().unwrap().steps.entry(motor).or_default().push(step);
            }
            _ => {}
        }
    }
    all
}

fn first(steps: &BTreeMap<usize, Vec<Step>>) -> f64 {
    steps.values().map(|steps| steps[0].time).fold(f64::MAX, f64::min)
}

/// Compares every step with the virtual board's. Returns the largest difference, and the largest
/// after a pause.
fn compare_edges(machine: &Machine, ideal: &[Segment]) -> (f64, f64) {
    let mut done = vec![0; machine.steps.len()];
    let (mut worst, mut paused, mut early) = (0f64, 0f64, 0);
    for (n, segment) in ideal.iter().enumerate().filter(|(_, s)| !s.steps.is_empty()) {
        let real: BTreeMap<usize, Vec<Step>> = (segment.steps.iter())
            .map(|(&motor, steps)| {
                let from = done[motor];
                done[motor] += steps.len();
                let real = machine.steps[motor].get(from..done[motor]);
                let made = machine.steps[motor].len();
                (motor, real.unwrap_or_else(|| panic!("cycle {n}: {made} steps")).to_vec())
            })
            .collect();
        let (begun, ideally) = (first(&real), first(&segment.steps));
        for (motor, ideal) in &segment.steps {
            for (k, (real, ideal)) in real[motor].iter().zip(ideal).enumerate() {
                assert_eq!(real.forward, ideal.forward, "cycle {n}, motor {motor}, step {k}");
                let off = ((real.time - begun) - (ideal.time - ideally)).abs();
                match segment.resumed {
                    // A step that is due at the moment of the pause may be made before it.
                    Some(resumed) if ideal.time > resumed && off > AFTER_PAUSE => {
                        let late = (real.time - begun) - (segment.paused - ideally);
                        assert!((0.0..AFTER_PAUSE).contains(&late), "motor {motor}, step {k}");
                        early += 1;
                    }
                    Some(resumed) if ideal.time > resumed => paused = paused.max(off),
                    _ => worst = worst.max(off),
                }
            }
        }
    }
    assert!(early <= machine.steps.len(), "{early} steps in the moment of a pause");
    for (motor, steps) in machine.steps.iter().enumerate() {
        assert_eq!(steps.len(), done[motor], "steps of motor {motor}");
    }
    (worst, paused)
}

/// Compares the reports of cycles and faults, and the positions of the motors, with the virtual
/// board's, in the cycles of this file.
fn compare_rows(real: &[Row], ideal: &[Row], text: &str) -> usize {
    let told = |rows: &[Row]| -> Vec<Row> {
        // During a homing the next report comes after its faults are over.
        let faults = !text.contains("home =");
        let told = |row: &&Row| row.event == "cycle" || row.event == "fault" && faults;
        rows.iter().filter(told).cloned().collect()
    };
    let (told_real, told_ideal) = (told(real), told(ideal));
    let what = |rows: &[Row]| -> Vec<String> {
        // A board reports a fault at the next poll, with the position then: a motor may brake.
        let left_out = |r: &Row| text.contains("\"brake-") && r.event == "fault";
        let at = |r: &Row| if left_out(r) { String::new() } else { r.position.clone() };
        let said = |r: &Row| [&*r.motor, &*r.event, &*r.value, &at(r)].join(",");
        rows.iter().map(said).collect()
    };
    assert_eq!(what(&told_real), what(&told_ideal));
    // The errors of consecutive cycles add up, and so do those of a homing's parts; a motor's last
    // interval of braking is long.
    let apart = text.contains("home =") || text.contains("\"brake-");
    let mut cycles = if apart { 9.0 } else { 0.0 };
    for (real, ideal) in told_real.iter().zip(&told_ideal) {
        let off = (real.us - ideal.us).abs();
        assert!(off <= REPORT * (1.0 + cycles), "{real:?} instead of {ideal:?}");
        cycles += f64::from(real.value == "start");
    }
    let mut looks = 0;
    for row in real.iter().filter(|row| row.event == "at") {
        let of = |ideal: &&Row| ideal.motor == row.motor && ideal.event != "fault";
        let steps: Vec<_> = ideal.iter().filter(of).collect();
        let near = REPORT * (1.0 + cycles);
        let at: i64 = row.position.parse().unwrap();
        // Positions within the time by which the report may be off, and the next one: a pause may
        // come a step later.
        let from = steps.partition_point(|step| step.us < row.us - near).saturating_sub(1);
        let next = steps.partition_point(|step| step.us <= row.us + near);
        let rest = steps[next..].iter().take(2);
        let known: Vec<i64> =
            steps[from..next].iter().chain(rest).map(|s| s.position.parse().unwrap()).collect();
        assert!(known.contains(&at), "{row:?}: {known:?}");
        looks += 1;
    }
    looks
}

/// Plays a file on the chip and on the virtual board. Returns the edges of both and the output of
/// both.
fn played(
    file: &str,
    names: &[&str],
    wires: &[Wires],
    switches: Vec<Switch>,
) -> (Machine, Vec<Segment>, Vec<Row>, Vec<Row>) {
    let ideal = command(&[file, "--format", "csv"]).output().expect("the command");
    let mut machine = Machine::new("cycles", wires, switches);
    let ended = machine.play(file, "csv");
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), ideal.status.code(), "{said}");
    let ideal = rows(&ideal.stdout);
    (machine, segments(&ideal, names), rows(&ended.stdout), ideal)
}

/// The output for a file on the chip, and on the virtual board.
fn agree(file: &str, real: &[Row], ideal: &[Row]) {
    let text = fs::read_to_string(file).unwrap();
    let looks = compare_rows(real, ideal, &text);
    println!("{looks} looks");
    assert!(looks > 0);
}

/// Plays a file on both, and compares edge by edge.
fn agrees(file: &str, names: &[&str], wires: &[Wires], switches: Vec<Switch>, bound: f64) {
    let name = file.rsplit('/').next().unwrap_or(file);
    let (machine, segments, real, ideal) = played(file, names, wires, switches);
    let (worst, paused) = compare_edges(&machine, &segments);
    println!("{name}: {worst} cycles, {paused} behind a pause");
    assert!(worst <= bound && paused <= AFTER_PAUSE, "{worst}, {paused}");
    agree(file, &real, &ideal);
}

/// Checks the refusal, and that nothing has moved.
#[track_caller]
fn refuses(program: &str, name: &str, message: &str, hint: &str) {
    refuses_file(program, &example(name), message, hint);
}

#[track_caller]
fn refuses_file(program: &str, file: &str, message: &str, hint: &str) {
    let mut machine = Machine::new(program, &shield(), Vec::new());
    let ended = machine.play(file, "list");
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(1), "{said}");
    assert!(said.contains(message) && said.contains(hint), "{said}");
    assert!(machine.steps.iter().all(Vec::is_empty));
}

#[test]
fn the_basic_example_plays_as_on_the_virtual_board() {
    agrees(&example("readme"), &["X", "Y", "Z"], &shield(), Vec::new(), EDGE);
}

#[test]
fn calibrations_find_the_switches() {
    let board = board();
    // 50 mm and 170 mm from its position: closed where the virtual switches are.
    let max = if board == Board::Uno { ChipPin('B', 4) } else { ChipPin('B', 6) };
    let switch = |pin, at, below| Switch { pin, motor: 0, at, below, closed: false };
    let switches = vec![switch(board.switch()[0], -3_000, true), switch(max, 13_600, false)];
    agrees(&example("calibrate"), &["X"], &shield()[..1], switches, EDGE);
}

/// A file of this test.
fn written(name: &str, text: &str) -> String {
    let path = format!("{}/{name}.toml", env!("CARGO_TARGET_TMPDIR"));
    fs::write(&path, text).unwrap();
    path
}

/// Two motors, one of which closes a switch during its motion at 2,000 steps/s.
fn braking(strategy: &str) -> String {
    written(
        strategy,
        &format!(
            "[strategies]\nhard-end = {strategy:?}\ntiming = \"ignore\"\n\
             [[motor]]\nname = \"X\"\nstep = 1\nsmallest-delay-us = 300\ndecel = 20_000\n\
             switch-max = 400\n\
             [[motor]]\nname = \"Y\"\nstep = 1\nsmallest-delay-us = 300\ndecel = 9_000\n\
             [[cycle]]\nmove.X = {{ steps = 1000, delay-us = 500 }}\n\
             move.Y = {{ steps = -700, delay-us = 1300 }}\n"
        ),
    )
}

/// 100 steps beyond the switch: one motor, while the other continues, or both.
#[test]
fn motors_brake_at_a_switch() {
    for strategy in ["brake-motor", "brake-all"] {
        let file = braking(strategy);
        if board() == Board::Uno {
            refuses_file("cycles", &file, "no room for braking at a switch", "on a Mega");
            continue;
        }
        let pin = board().switch()[0];
        let switches = vec![Switch { pin, motor: 0, at: 400, below: false, closed: false }];
        agrees(&file, &["X", "Y"], &shield()[..2], switches, BRAKES);
    }
}

/// Fast to the switch, back, slowly to it again; then a move from there.
#[test]
fn a_motor_homes() {
    let text = "[[motor]]\nname = \"X\"\nstep = 1\nsmallest-delay-us = 300\nswitch-min = -350\n\
        [[cycle]]\nhome = { motor = \"X\", end = \"min\", reach = 5_000, back-off = 40, \
        fast-us = 500, slow-us = 2000 }\n\
        [[cycle]]\nmove.X = { steps = 100, delay-us = 800 }\n";
    let file = written("home", text);
    if board() == Board::Uno {
        return refuses_file("cycles", &file, "no room for homing", "on a Mega");
    }
    let pin = board().switch()[0];
    let switches = vec![Switch { pin, motor: 0, at: -350, below: true, closed: false }];
    let (machine, segments, told, wanted) = played(&file, &["X"], &shield()[..1], switches);
    agree(&file, &told, &wanted);
    let ideal = &segments[0].steps[&0];
    let real = &machine.steps[0][..ideal.len()];
    // 350 steps there, 40 back, 40 there, and 100 from 0 on, each at its own delay.
    assert_eq!(machine.steps[0].len(), ideal.len() + segments[1].steps[&0].len());
    let (mut parts, mut worst) = (0, 0f64);
    for (real, ideal) in real.windows(2).zip(ideal.windows(2)) {
        assert_eq!(real[1].forward, ideal[1].forward);
        let off = (real[1].time - real[0].time) - (ideal[1].time - ideal[0].time);
        if off > EDGE {
            assert!(off <= PARTS, "{off} cycles between two parts");
            parts += 1;
        } else {
            worst = worst.max(off.abs());
        }
    }
    println!("homing: {} steps, {worst} cycles", real.len());
    assert!(parts <= 2 && worst <= EDGE, "{parts} parts, {worst} cycles");
}

/// From the Mega's memory, where a path is a few hundred runs: two motors along it at 4,800
/// steps/s, with turns, a pause, feed rates and new targets on the way.
#[test]
fn lines_and_arcs_play_as_on_the_virtual_board() {
    if board() == Board::Uno {
        refuses("cycles", "feed", "a uno has no room for lines and arcs", "stepwright line --port");
        return refuses("cycles", "drawing", "a uno has no room for homing", "on a Mega");
    }
    agrees(&example("feed"), &["X", "Y"], &shield()[..2], Vec::new(), BESIDE_TURNS);
    // The drawing from the present position: another test covers homing.
    let text = fs::read_to_string(example("drawing")).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with("switch-min"));
    let text: Vec<_> = lines.filter(|line| !line.starts_with("home = ")).collect();
    let text = text.join("\n").replace("[[cycle]]\n\n[[cycle]]", "[[cycle]]");
    let file = written("drawing", &text);
    agrees(&file, &["X", "Y"], &shield()[..2], Vec::new(), BESIDE_TURNS);
    // With a strategy that allows no late step: a circle at 600 steps/s.
    let motor = |name| format!("[[motor]]\nname = {name:?}\nstep = 1\nsmallest-delay-us = 300\n");
    let arc = "[[cycle]]\narc = { motors = [\"X\", \"Y\"], centre = [200, 0], degrees = 360, \
               speed = 600, accel = 9_000 }\n";
    let file = written("circle", &(motor("X") + &motor("Y") + arc));
    agrees(&file, &["X", "Y"], &shield()[..2], Vec::new(), BESIDE_TURNS);
}

/// More runs than the memory holds; steps closer together than the board can play.
#[test]
fn paths_too_long_or_too_fast_are_refused() {
    if board() == Board::Uno {
        return;
    }
    let arc = |degrees: u32, speed: u32| {
        let motor =
            |name| format!("[[motor]]\nname = {name:?}\nstep = 1\nsmallest-delay-us = 100\n");
        let arc = format!(
            "[[cycle]]\narc = {{ motors = [\"X\", \"Y\"], centre = [900, 0], degrees = {degrees}, \
             speed = {speed}, accel = 20_000 }}\n"
        );
        motor("X") + &motor("Y") + &arc
    };
    let file = written("long-path", &arc(1440, 3_000));
    refuses_file("cycles", &file, "runs, and a mega keeps 400", "make two cycles of it");
    // No step may be late; or some may.
    let file = written("late-path", &arc(90, 3_000));
    refuses_file("cycles", &file, "delays of at least 1500 µs", "timing = \"ignore\"");
    let late = "[strategies]\ntiming = \"ignore\"\n";
    let file = written(
        "fast-path",
        &(late.to_owned()
            + &arc(90, 12_000).replace("20_000", "90_000").replace("us = 100", "us = 50")),
    );
    refuses_file("cycles", &file, "too fast for this board", "at least 200 µs");
}

#[test]
fn another_program_is_named() {
    let flash = format!("stepwright flash {} --program cycles", board());
    refuses("timed", "readme", "runs the timed driver", &flash);
}

#[test]
fn the_fixed_tick_plays_as_on_the_virtual_board() {
    if board() == Board::Uno {
        let message = "a uno has no room for the fixed tick";
        return refuses("cycles", "triangle", message, "leave tick-us out");
    }
    agrees(&example("triangle"), &["X", "Y", "Z"], &shield(), Vec::new(), EDGE);
}

/// Delays that are not multiples of the grid, waits and turns: STEP rises on the grid of the first
/// step, even after a pause of any length.
#[test]
fn a_pause_of_the_fixed_tick_ends_on_its_grid() {
    if board() == Board::Uno {
        return;
    }
    let tick = 1_000;
    let text = format!(
        "[clock]\ntick-us = {tick}\n\
         [[motor]]\nname = \"X\"\nstep = 1\nsmallest-delay-us = 3000\n\
         [[motor]]\nname = \"Y\"\nstep = 1\nsmallest-delay-us = 4000\n\
         [[cycle]]\nmove.X = {{ series = [{{ steps = 60, delay-us = 4130 }}, \
         {{ wait = 1, delay-us = 13333 }}, {{ steps = -40, delay-us = 3901 }}] }}\n\
         move.Y = {{ delays-us = [7000, 4111, 5777], each = 20 }}\n\
         pause-s = 0.2007\nresume-s = 0.2112\n"
    );
    // 10.5 ticks: without the grid all would be half a tick off.
    let file = written("grid", &text);
    let (machine, segments, ..) = played(&file, &["X", "Y"], &shield()[..2], Vec::new());
    let (worst, paused) = compare_edges(&machine, &segments);
    let tick = f64::from(tick) * MICRO;
    let begun = machine.steps.iter().map(|steps| steps[0].time).fold(f64::MAX, f64::min);
    let steps = machine.steps.iter().flatten().map(|step| (step.time - begun) / tick);
    let off = steps.map(|ticks| (ticks - ticks.round()).abs() * tick).fold(0f64, f64::max);
    println!("{worst} cycles, {paused} behind the pause, {off} from the grid");
    assert!(worst <= EDGE && paused <= AFTER_PAUSE && off <= EDGE);
}

/// Four motors on the Mega, one of them on its own pins.
#[test]
fn every_way_of_preparing_plays_as_on_the_virtual_board() {
    if board() == Board::Uno {
        return refuses("cycles", "series", "moves 3 motors, and the file has 4", "Mega");
    }
    let mut wires = shield();
    wires.push(Wires { step: ChipPin('F', 0), direction: ChipPin('F', 1) });
    let names = ["list", "series", "callback", "bounded"];
    agrees(&example("series"), &names, &wires, Vec::new(), BESIDE_TURNS);
}

#[test]
fn ctrl_c_ends_the_cycle() {
    let mut machine = Machine::new("cycles", &shield(), Vec::new());
    let (file, port) = (example("readme"), machine.port());
    let child = command(&[&file, "--port", &port])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command");
    let begun = Instant::now();
    while machine.steps[0].len() < 500 {
        machine.pass();
        assert!(begun.elapsed() < LIMIT);
    }
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.expect("kill").success());
    let ended = machine.until_ended(child);
    assert_eq!(ended.status.code(), Some(130), "{}", String::from_utf8_lossy(&ended.stderr));
    let made = machine.steps[0].len();
    assert!(made < 15_000, "{made}");
    for _ in 0..100 {
        machine.pass();
    }
    assert_eq!(machine.steps[0].len(), made);
    // The last line has the final positions: X counts 7500 nm a step.
    let text = String::from_utf8_lossy(&ended.stdout).into_owned();
    let last = text.lines().last().unwrap_or_default().to_owned();
    assert!(last.starts_with(&format!("X.pos={},", made * 7_500)), "{last}");
}
