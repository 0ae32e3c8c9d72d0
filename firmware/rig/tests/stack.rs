//! The deepest stack of every program keeps its distance from the statics.
//!
//! The worst case of each program is here. In addition, every chip of every test is checked when it
//! is switched off (`Chip`). The stack of `fast-pwm` is measured without its interrupt, which
//! simavr does not support.

use std::fs;

use crate::common::{self, board, cycles, program, talk};
use stepwright::{Accel, Rate, Speed};
use stepwright_austin::line::Line as LawLine;
use stepwright_austin::{Austin, LinearFactor, Piecewise, PowerTerm, Recipe};
use stepwright_cycle::line::{CycleLine, LineAct, LineProgram};
use stepwright_cycle::{AtHardEnd, Calibration, Clock, DelayRamp, End, Homing, Leg, Motor};
use stepwright_cycle::{AtTiming, Strategies};
use stepwright_rig::edges::steps_of;
use stepwright_rig::stack::RESERVE;
use stepwright_rig::{Board, Chip, Pair, firmware};

const MILLIS: u64 = 16_000;

/// A program, just switched on.
fn switched_on(name: &str) -> Chip {
    let image = firmware::load(name).unwrap_or_else(|error| panic!("{error:#}"));
    let mut chip = Chip::new(board(), &image);
    chip.watch_stack();
    chip
}

/// Sends lines whatever the answers, with 20 ms between them.
fn send(chip: &mut Chip, lines: &[&str]) {
    for line in lines {
        _ = chip.ask(line);
        chip.run_for(20 * MILLIS);
    }
}

/// Each query. While motors move, the longest answer takes longer than `ask` waits.
fn queries(chip: &mut Chip) {
    chip.take_said();
    chip.send(b"$\r");
    chip.run_for(150 * MILLIS);
    let said = chip.take_said();
    assert!(said.starts_with(b"max-speed=") && said.ends_with(b"\r"), "{said:?}");
    talk(chip, "? stepwright *\n$pulse-us *2\nV1 *\nA0 Y");
}

/// Everything that the controller can do: three axes, ramps and S-curves, changes of all axes on the way,
/// stops, every kind of query. Each line has to be obeyed.
fn controller() -> Chip {
    let mut chip = common::chip();
    chip.watch_stack();
    queries(&mut chip);
    talk(&mut chip, "$pulse-us=3 Y\n$pulse-us=2 Y\nI1 Y\nL30000 Y");
    talk(&mut chip, "PO Y");
    for axis in 1..=3 {
        let order = format!("A{axis} Y\ns300 Y\nt4000 Y\na10000 Y\nd15000 Y\nG+6000 Y");
        talk(&mut chip, &order);
    }
    talk(&mut chip, "A0 Y\nE Y\n*wait 100");
    queries(&mut chip);
    talk(&mut chip, "t3500 Y\na9000 Y\nd12000 Y\n@+5000 Y\nm3400000 Y");
    queries(&mut chip);
    talk(&mut chip, "A2 Y\n@+4000 Y\nA3 Y\nt1000 Y\nA0 Y\nF B\n*wait 200");
    queries(&mut chip);
    talk(&mut chip, "Z Y\n*rest");
    if board() == Board::Mega {
        talk(
            &mut chip,
            "PO Y\nA2 Y\ns100 Y\nt3000 Y\na10000 Y\nd10000 Y\nj200000 Y\nG+6000 Y\nE Y",
        );
        queries(&mut chip);
        talk(&mut chip, "A2 Y\nt2500 Y\na9000 Y\nd8000 Y\n@+5000 Y\n*wait 300");
        queries(&mut chip);
        talk(&mut chip, "Z Y\n*rest");
    }
    talk(&mut chip, "A1 Y\ns300 Y\nt9000 Y\na20000 Y\ng+ Y\n*wait 300\nF B\nK Y");
    talk(&mut chip, "V1 E\nI1 Y");
    for axis in 0..3 {
        let steps = steps_of(chip.edges(), axis).len();
        assert!(steps > 1_000, "axis {axis} makes {steps} steps");
    }
    chip
}

/// Series on every motor with all available legs, between bounds, with queries during motion,
/// pauses and ramps; on a Mega also braking, homing and both ticks.
fn motor_cycles() -> Chip {
    let mut chip = program("cycles");
    chip.watch_stack();
    let about = chip.ask("?").unwrap();
    let legs = about.split(' ').find_map(|word| word.strip_prefix("legs=")).unwrap();
    let each = legs.parse::<usize>().unwrap() / 3;
    let motor = Motor::new(7_500, 1_000).between(-1 << 40, 1 << 40);
    for n in 0..3 {
        cycles::wire(
            &mut chip,
            n,
            if board() == Board::Mega { motor.braking(9_000) } else { motor },
        );
    }
    let turns = |n| Leg::Steps { count: if n % 2 == 0 { 3 } else { -2 }, delay: 3_000 };
    let legs: Vec<_> = (0..each as i32).map(turns).collect();
    cycles::say(&mut chip, CycleLine::New);
    cycles::prepare(&mut chip, &[&legs, &legs, &legs]);
    cycles::say(&mut chip, CycleLine::Act(LineAct::Pause, 1_600_000));
    cycles::say(&mut chip, CycleLine::Act(LineAct::Resume, 1_700_000));
    cycles::say(&mut chip, CycleLine::Start(1));
    for act in [LineAct::Pause, LineAct::Resume] {
        for _ in 0..10 {
            cycles::look(&mut chip);
        }
        cycles::say(&mut chip, CycleLine::Now(act));
    }
    cycles::rest(&mut chip, 5_000);
    let ramp = DelayRamp { from: 3_000, to: 1_000, by: 10 };
    let ramp = LineProgram::Ramp { steps: Some(300), forward: false, ramp };
    let mut clocks = vec![(Clock::Deadlines, AtHardEnd::Cancel)];
    if board() == Board::Mega {
        clocks.push((Clock::Deadlines, AtHardEnd::BrakeAll));
        clocks.push((Clock::Tick { period: 1_000 }, AtHardEnd::BrakeMotor));
        clocks.push((Clock::Grid { period: 100 }, AtHardEnd::Cancel));
    }
    for (number, (clock, hard_end)) in (2..).zip(clocks) {
        let strategies = Strategies { hard_end, timing: AtTiming::Ignore, ..Strategies::CANCEL };
        cycles::say(&mut chip, CycleLine::New);
        cycles::say(&mut chip, CycleLine::Clock(clock, strategies));
        for motor in 0..3 {
            let what = Motor::new(7_500, 3_000).between(-1 << 40, 1 << 40).braking(9_000);
            cycles::say(&mut chip, CycleLine::Motor(motor, what));
            cycles::say(&mut chip, CycleLine::Prepare(motor, Calibration::None, ramp));
        }
        cycles::say(&mut chip, CycleLine::Start(number));
        cycles::rest(&mut chip, 5_000);
    }
    if board() == Board::Mega {
        cycles::say(&mut chip, CycleLine::Clock(Clock::Deadlines, Strategies::CANCEL));
        cycles::say(&mut chip, CycleLine::Home(200, Homing::new(0, End::Min, 50, 10)));
        cycles::rest(&mut chip, 5_000);
    }
    chip
}

/// Every law of the program, there, changed and stopped.
fn laws(name: &str) -> Chip {
    let mut chip = program(name);
    chip.watch_stack();
    let (rate, speed) = (Rate::MHZ, Speed::from_steps(100).unwrap());
    let accel = |steps| Accel::from_steps(steps).unwrap();
    let pulses = 500;
    let all = [
        Recipe::Austin(Austin::new(rate, speed, accel(9_000)).constants(pulses).unwrap()),
        Recipe::AustinFixed(50_000, 2_500),
        Recipe::LinearFactor(
            LinearFactor::new(rate, speed, accel(2_000)).constants(pulses).unwrap(),
        ),
        Recipe::Power(PowerTerm::new(rate, speed, accel(500), 4).constants(pulses).unwrap()),
        Recipe::Piecewise(Piecewise::new(rate, speed, accel(2_000)).constants(pulses).unwrap()),
    ];
    let mut played = 0;
    for recipe in all {
        if chip.ask(&LawLine::Law(recipe).to_string()).as_deref() == Some("Y") {
            send(
                &mut chip,
                &["?", ":C20,5000000", ":G500", "V1", "F", ":C0,9000000", "?", "Z", "V1"],
            );
            chip.run_for(3_000 * MILLIS);
            played += 1;
        }
    }
    assert!(played > 0, "{name} has no law");
    chip
}

/// Both published ways to check, with changing steps, and queries.
fn timed() -> Chip {
    let mut chip = program("timed");
    chip.watch_stack();
    let wire =
        if board() == Board::Uno { "48,0,0,1,0,0,16,48,32" } else { "192,0,0,1,0,0,64,192,128" };
    for control in [240, 112] {
        let order = format!(":M1,{control},16000,3000,64,20,19,0");
        send(&mut chip, &["?", &format!(":W1,66,{wire}"), ":L1,1", ":U1,5", &order, ":?1", "F"]);
        chip.run_for(1_000 * MILLIS);
        send(&mut chip, &[":?1", ":M1,0,0,0,0,0,0,0", ":?1", "x"]);
    }
    chip
}

/// A master, with its slave at the end of the cable.
fn master() -> Chip {
    let mut pair = Pair::new(switched_on(&format!("{}-master", board())), common::chip());
    pair.run_for(6_000 * MILLIS);
    pair.master
}

/// The worst case of a firmware; `None` if it is another build of one that is here.
fn worst(name: &str) -> Option<Chip> {
    let program = name.strip_prefix(board().name())?;
    let program = program.strip_prefix('-').unwrap_or(program);
    let chip = match program {
        _ if program.contains("bench") || program.starts_with("timer") => return None,
        // It is called function by function.
        "arithmetic" => return None,
        "" => controller(),
        "cycles" => motor_cycles(),
        "laws" | "transitions" | "power-term" => laws(program),
        "timed" => timed(),
        "master" => master(),
        // They run by themselves.
        _ => {
            let mut chip = switched_on(name);
            chip.run_for(3_000 * MILLIS);
            chip
        }
    };
    Some(chip)
}

#[test]
fn no_stack_comes_near_the_statics() {
    let folder = firmware::path("x").parent().unwrap().to_owned();
    let files = fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    let mut names: Vec<String> = files
        .filter(|file| file.extension().is_some_and(|end| end == "elf"))
        .map(|file| file.file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    names.sort();
    let mut near = Vec::new();
    for name in &names {
        let Some(chip) = worst(name) else { continue };
        let ((statics, _), spare) = (chip.ram(), chip.spare());
        println!("{name}: {statics} bytes of statics, {spare} to spare");
        if spare < RESERVE.into() {
            near.push(name);
            // Its own check would report the same again.
            std::mem::forget(chip);
        }
    }
    assert!(near.is_empty(), "less than {RESERVE} bytes to spare: {near:?}");
    assert!(names.iter().any(|name| *name == format!("{}-cycles", board())), "{names:?}");
}
