//! Programs with fewer features on every board, ordered over their lines: Austin's laws and motor
//! cycles. Their edges are the virtual board's.

use std::cell::Cell;
use std::thread;
use std::time::Duration;

use stepwright::{Accel, Rate, Speed};
use stepwright_austin::line::Line;
use stepwright_austin::station::Costs;
use stepwright_austin::{Austin, LinearFactor, Piecewise, PowerTerm, Recipe};
use stepwright_cycle::line::{CycleLine, CycleReport, LineProgram, MotorPins};
use stepwright_cycle::{Calibration, Clock, DelayRamp, Leg, Motor};
use stepwright_qemu::boards::WITH_PROGRAMS;
use stepwright_qemu::{Edge, Machine, Pace, Simulated, machine, virtual_board};
use stepwright_sim::{CycleBoard, CycleLineBoard, LawBoard, Queues, Stand};

/// Ticks between an edge and the virtual board's, for one motor.
const ALONE: f64 = 10.0;
/// Instructions between them for several motors: a visit queries up to three programs.
const BESIDE: f64 = 450.0;

/// The ticks of a board in which it executes these instructions.
fn ticks(board: &Simulated, instructions: f64) -> f64 {
    instructions * Pace::Quick.micros() * board.mhz()
}

/// Sends lines that are all obeyed, and waits for rest; no step may be late.
fn carry_out(chip: &mut Machine, lines: &[String]) {
    // Until the board is up, QEMU keeps its input, and passes it on at once: more than its ring
    // holds.
    assert_eq!(chip.ask("F").unwrap(), "R");
    for line in lines {
        assert_eq!(chip.ask(line).unwrap(), "Y", "{line}");
    }
    for _ in 0..5_000 {
        if chip.ask("F").unwrap() == "R" {
            return;
        }
        thread::sleep(Duration::from_millis(2));
    }
    panic!("it never rests after {lines:?}");
}

/// The largest distance of the edges of all motors, when the median of all is aligned.
fn worst(real: &[Edge], ideal: &[stepwright_sim::Edge]) -> f64 {
    let mut off = Vec::new();
    for axis in 0..3 {
        let (real, ideal) = (machine::steps(real, axis), virtual_board::steps(ideal, axis));
        assert_eq!(real.len(), ideal.len(), "steps of motor {axis}");
        off.extend(real.iter().zip(&ideal).map(|(real, ideal)| real - *ideal as f64));
    }
    off.sort_by(f64::total_cmp);
    let median = off[off.len() / 2];
    off.iter().map(|off| (off - median).abs().round()).fold(0.0, f64::max)
}

/// A law of each kind, as fast as a board accepts it, or nearly.
fn recipes(pulses: u32) -> [(&'static str, Recipe); 5] {
    let accel = |steps| Accel::from_steps(steps).unwrap();
    let speed = |micros| Speed::from_millisteps(1_000_000_000 / micros).unwrap();
    let (rate, costs) = (Rate::MHZ, Costs::AVR);
    let general = Austin::new(rate, speed(costs.austin), accel(10_000)).with_decel(accel(7_000));
    let linear = LinearFactor::new(rate, speed(costs.linear_factor), accel(5_000));
    let power = PowerTerm::new(rate, speed(4 * costs.power), accel(500), 4);
    let pieces = Piecewise::new(rate, speed(costs.piecewise), accel(2_000));
    [
        ("general form", Recipe::Austin(general.constants(pulses).unwrap())),
        ("listing", Recipe::AustinFixed(9_560, costs.austin_fixed)),
        ("linear factor", Recipe::LinearFactor(linear.constants(pulses).unwrap())),
        ("power term", Recipe::Power(power.constants(pulses).unwrap())),
        ("piecewise", Recipe::Piecewise(pieces.constants(pulses).unwrap())),
    ]
}

#[test]
fn every_law_steps_as_on_the_virtual_board() {
    const PULSES: i32 = 300;
    for board in WITH_PROGRAMS {
        for (what, recipe) in recipes(PULSES as u32) {
            let lines = [Line::Law(recipe), Line::Go(PULSES)].map(|line| line.to_string());
            let mut chip = Machine::start(board, "laws", Pace::Quick).unwrap();
            carry_out(&mut chip, &lines);
            assert_eq!(chip.ask("V1").unwrap(), PULSES.to_string());
            let about = chip.ask("?").unwrap();
            assert!(about.contains(" late=0"), "{}, {what}: {about}", board.name);
            let mut queues = Queues::default();
            let description = virtual_board::description(board);
            let mut ideal: LawBoard<Vec<stepwright_sim::Edge>, u32> =
                LawBoard::new(&mut queues, description, Vec::new());
            for line in &lines {
                format!("{line}\r").bytes().for_each(|byte| ideal.receive(byte));
                assert_eq!(ideal.take_answers(), b"Y\r", "{line}");
            }
            while ideal.is_busy() {
                let next = ideal.now() + 16_000;
                ideal.run_until(next);
            }
            let off = worst(&chip.end().unwrap(), ideal.recorder());
            println!("{}, {what}: {off} ticks", board.name);
            assert!(off <= ALONE, "{}, {what}: {off} ticks", board.name);
        }
    }
}

/// The lines of a cycle: motors on the board's pins, and the program of each.
fn cycle(board: &Simulated, programs: &[LineProgram], legs: &[Leg]) -> Vec<String> {
    let mut lines = vec![CycleLine::New];
    lines.extend((0u16..).zip(legs).map(|(at, leg)| CycleLine::Leg(at, *leg)));
    for (motor, program) in (0u8..).zip(programs) {
        let (step, dir) = board.view.pins();
        let mut codes = [MotorPins::NO_PIN; 5];
        (codes[0], codes[1]) = (step as u8 + motor, dir as u8 + motor);
        lines.push(CycleLine::Motor(motor, Motor::new(7_500, 300)));
        lines.push(CycleLine::Wire(motor, MotorPins { codes }));
        lines.push(CycleLine::Prepare(motor, Calibration::None, *program));
    }
    lines.push(CycleLine::Start(1));
    lines.iter().map(CycleLine::to_string).collect()
}

/// The position of a motor after these edges, in steps.
fn position_of(edges: &[Edge], axis: u8) -> i64 {
    let (mut forward, mut at) = (false, 0);
    for edge in edges.iter().filter(|edge| edge.axis == axis) {
        if !edge.is_pulse {
            forward = edge.level;
        } else if edge.level {
            at += if forward { 1 } else { -1 };
        }
    }
    at
}

/// The report of a board's motors.
fn positions(answer: &str) -> Vec<(i64, u8)> {
    let report = CycleReport::read(answer.as_bytes()).unwrap_or_else(|| panic!("{answer}"));
    report.motors.iter().take(3).map(|motor| (motor.position, motor.faults)).collect()
}

#[test]
fn motor_cycles_step_as_on_the_virtual_board() {
    let steps = |count, delay| LineProgram::Steps { count, delay };
    let ramp = DelayRamp { from: 4_000, to: 700, by: 11 };
    let ramp = LineProgram::Ramp { steps: Some(300), forward: true, ramp };
    let legs = [
        Leg::Steps { count: 150, delay: 900 },
        Leg::Wait { count: 3, delay: 5_000 },
        Leg::Steps { count: -400, delay: 650 },
    ];
    for board in WITH_PROGRAMS {
        for (what, programs, legs, most) in [
            ("steps", vec![steps(700, 500)], &[][..], ALONE),
            ("steps backward", vec![steps(-300, 1_000)], &[], ALONE),
            ("a ramp", vec![ramp], &[], ALONE),
            (
                "three motors",
                vec![steps(900, 700), LineProgram::Legs { first: 0, count: 3 }, steps(-200, 2_900)],
                &legs,
                ticks(board, BESIDE),
            ),
        ] {
            let lines = cycle(board, &programs, legs);
            let mut chip = Machine::start(board, "cycles", Pace::Quick).unwrap();
            carry_out(&mut chip, &lines);
            let real = positions(&chip.ask(":?").unwrap());

            let motors = [Motor::new(1, 1); 3];
            let cycle = CycleBoard::new(
                motors,
                [Stand::default(); 3],
                Clock::Deadlines,
                board.board.rate,
                Vec::new(),
            );
            let store = [const { Cell::new(Leg::Steps { count: 0, delay: 0 }) }; 24];
            let mut ideal = CycleLineBoard::new(cycle, &store);
            let mut ask = |line: &str| {
                format!("{line}\r").bytes().for_each(|byte| ideal.receive(byte));
                String::from_utf8(ideal.take_answers()).unwrap().trim_end().to_owned()
            };
            for line in &lines {
                assert_eq!(ask(line), "Y", "{line}");
            }
            let second = u64::from(board.board.rate.hz());
            ideal.run_until(5 * second);
            let mut ask = |line: &str| {
                format!("{line}\r").bytes().for_each(|byte| ideal.receive(byte));
                String::from_utf8(ideal.take_answers()).unwrap().trim_end().to_owned()
            };
            assert_eq!(real, positions(&ask(":?")), "{}, {what}", board.name);
            assert!(
                real.iter().all(|(_, faults)| *faults == 0),
                "{}, {what}: {real:?}",
                board.name
            );
            let edges = ideal.program().hold().with_recorder(|edges| edges.clone());
            let seen = chip.end().unwrap();
            for (motor, (position, _)) in (0u8..).zip(&real) {
                assert_eq!(7_500 * position_of(&seen, motor), *position, "{}, {what}", board.name);
            }
            let off = worst(&seen, &edges);
            println!("{}, {what}: {off} ticks", board.name);
            assert!(off <= most, "{}, {what}: {off} ticks", board.name);
        }
    }
}

/// A motor is accepted on the board's own pins for it, and on no others.
#[test]
fn a_motor_of_a_cycle_is_on_the_boards_pins() {
    for board in WITH_PROGRAMS {
        let (step, dir) = board.view.pins();
        let mut chip = Machine::start(board, "cycles", Pace::Quick).unwrap();
        let mut wire =
            |codes| chip.ask(&CycleLine::Wire(1, MotorPins { codes }).to_string()).unwrap();
        let (step, dir) = (step as u8 + 1, dir as u8 + 1);
        assert_eq!(wire([step, dir, 255, 255, 255]), "Y");
        for codes in
            [[step + 1, dir, 255, 255, 255], [step, 255, 255, 255, 255], [step, dir, 99, 255, 255]]
        {
            let answer = wire(codes);
            assert!(answer.starts_with("E pin"), "{codes:?}: {answer}");
        }
    }
}
