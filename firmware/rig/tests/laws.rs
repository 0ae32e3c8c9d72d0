//! Laws that are computed step by step, on a chip: the cost of a step of each (the table in
//! `docs/laws.md`), and the motor that they move. Their delays are the host's.

use std::fmt::Write;

use stepwright::profile::Trapezoid;
use stepwright::{Accel, Rate, Speed};
use stepwright_austin::{
    Austin, Carried, Divisor, Fixed, LinearFactor, Piecewise, PowerTerm, Ramp, Slope,
};
use stepwright_rig::board::Pin;
use stepwright_rig::edges::{Needs, Step, check, steps_of};
use stepwright_rig::{Board, Chip, firmware};

/// A law, the sum of its delays here, and the cycles of a step there: the mean, and the longest.
type Law = (&'static str, u32, u64, u64);

/// A move, and its delays here, in µs.
type Move = (&'static str, Vec<u32>);

/// A program: the laws that it measures, the moves that it makes.
struct Program {
    name: &'static str,
    laws: Vec<Law>,
    moves: Vec<Move>,
}

const STEPS: u32 = 1_000;
/// The article's demo, and the fast one: c₀ and the shortest delay in µs.
const DEMO: (u32, u32) = (50_000, 2_500);
const LISTED: (u32, u32) = (9_560, 500);

/// The cycles by which a step may be off: the instruction that the interrupt waits for.
const BESIDE: u64 = 4;

fn programs() -> Vec<Program> {
    let rate = Rate::MHZ;
    let speed = |steps| Speed::from_steps(steps).unwrap();
    let accel = |steps| Accel::from_steps(steps).unwrap();
    let (top, slope) = (speed(2_000), accel(10_000));
    let law = Austin::new(rate, top, slope);
    let two_n = law.with_divisor(Divisor::TwoN);
    let mut ramp = Ramp::new(rate, slope, Default::default()).unwrap();
    let up = ramp.by_ref().take(STEPS as usize / 2).sum();
    ramp.set(Slope::Down(slope));
    let trapezoid = Trapezoid::new(rate, Speed::ZERO, top, slope);
    let power = |p| PowerTerm::new(rate, top, slope, p).delays(STEPS).unwrap().sum();
    let slow_power = |p| PowerTerm::new(rate, speed(150), accel(500), p).delays(300).unwrap();
    let linear = |top| LinearFactor::new(rate, top, slope).delays(STEPS).unwrap();
    let pieces = |top, slope| Piecewise::new(rate, top, slope).delays(STEPS).unwrap();
    let listing = |(first, shortest)| Fixed::new(STEPS, first, shortest);
    let carried = |(first, shortest)| Carried::new(STEPS, first, shortest);
    vec![
        Program {
            name: "closed",
            laws: vec![("trapezoid", trapezoid.delays(STEPS).unwrap().sum(), 4002, 62_293)],
            moves: vec![],
        },
        Program {
            name: "listing",
            laws: vec![
                ("listing", listing(LISTED).sum(), 1052, 2631),
                ("remainder carried", carried(LISTED).sum(), 660, 1718),
            ],
            moves: vec![
                ("the demo", listing(DEMO).collect()),
                ("the demo, its remainder carried", carried(DEMO).collect()),
                ("listing, 2,000 steps/s", listing(LISTED).collect()),
                ("remainder carried, 2,000 steps/s", carried(LISTED).collect()),
            ],
        },
        Program {
            name: "general",
            laws: vec![
                ("general form", law.delays(STEPS).unwrap().sum(), 2823, 7182),
                ("c/2n", two_n.delays(STEPS).unwrap().sum(), 2820, 7246),
                ("ramp that changes, up", up, 8175, 8804),
                ("ramp that changes, down", ramp.sum(), 8191, 8789),
            ],
            moves: vec![
                ("general form", law.delays(STEPS).unwrap().collect()),
                ("c/2n", two_n.delays(STEPS).unwrap().collect()),
                ("a ramp that changes", changing()),
            ],
        },
        Program {
            name: "power",
            laws: vec![
                ("power term, p = 2", power(2), 54_770, 77_625),
                ("power term, p = 4", power(4), 66_386, 95_925),
            ],
            moves: vec![
                ("power term, p = 2", slow_power(2).collect()),
                ("power term, p = 4", slow_power(4).collect()),
            ],
        },
        Program {
            name: "linear",
            laws: vec![("linear factor", linear(top).sum(), 7407, 8161)],
            moves: vec![("linear factor", linear(speed(1_200)).collect())],
        },
        Program {
            name: "piecewise",
            laws: vec![("piecewise", pieces(top, slope).sum(), 13_682, 21_750)],
            moves: vec![("piecewise", pieces(speed(500), accel(2_000)).collect())],
        },
    ]
}

/// Up at 200 steps/s², from the 101st step on at 500, from the 301st on down at 400.
fn changing() -> Vec<u32> {
    let accel = |steps| Accel::from_steps(steps).unwrap();
    let mut ramp = Ramp::new(Rate::MHZ, accel(200), Default::default()).unwrap();
    let mut delays: Vec<u32> = ramp.by_ref().take(100).collect();
    ramp.set(Slope::Up(accel(500)));
    delays.extend(ramp.by_ref().take(200));
    ramp.set(Slope::Down(accel(400)));
    delays.extend(ramp);
    delays
}

#[test]
fn laws_cost_what_the_table_says_and_move_a_motor_by_the_hosts_delays() {
    let board: Board = std::env::var("STEPWRIGHT_BOARD").map_or(Board::Uno, |b| b.parse().unwrap());
    if board != Board::Uno {
        return;
    }
    let mut wrong = String::new();
    for program in programs() {
        let mut chip = play(&program);
        costs(&program, &mut chip, &mut wrong);
        moves(&program, &mut chip, &mut wrong);
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Runs a program until its pins have been still for a second.
fn play(program: &Program) -> Chip {
    let name = format!("uno-laws-{}", program.name);
    let image = firmware::load(&name).unwrap_or_else(|error| panic!("{error:#}"));
    let mut chip = Chip::new(Board::Uno, &image);
    chip.watch_pins(&[Pin('B', 4), Pin('B', 5)]);
    let mut seen = (0, 0);
    loop {
        chip.run_for(16_000_000);
        let changes = (chip.watched_changes().len(), chip.edges().len());
        if changes == seen {
            return chip;
        }
        seen = changes;
    }
}

/// Compares the cost of each law with the table.
fn costs(program: &Program, chip: &mut Chip, wrong: &mut String) {
    // The cycles of each computed delay, law by law.
    let mut cycles: Vec<Vec<u64>> = Vec::new();
    let mut since = 0;
    for &(cycle, pin, level) in chip.watched_changes() {
        match (pin, level) {
            (1, true) => cycles.push(Vec::new()),
            (0, true) => since = cycle,
            (0, false) => cycles.last_mut().unwrap().push(cycle - since),
            _ => {}
        }
    }
    assert_eq!(cycles.len(), program.laws.len(), "laws of {}", program.name);
    let (place, _) = firmware::load(&format!("uno-laws-{}", program.name))
        .unwrap_or_else(|error| panic!("{error:#}"))
        .variable("LAW_SUMS");
    for ((n, &(name, sum, mean, most)), mut cycles) in (0u16..).zip(&program.laws).zip(cycles) {
        // The last one is the end.
        cycles.pop();
        let here = [0, 1, 2, 3].map(|byte| chip.byte(place + 4 * n + byte));
        let here = u32::from_le_bytes(here);
        let (got, longest) =
            (cycles.iter().sum::<u64>() / cycles.len() as u64, *cycles.iter().max().unwrap());
        println!("{name}: {got}, at most {longest}, {} steps", cycles.len());
        if here != sum {
            writeln!(wrong, "{name}: all delays are {here} ticks, not {sum}").unwrap();
        }
        let near = |a: u64, b: u64| a.abs_diff(b) * 20 <= b;
        if !near(got, mean) || !near(longest, most) {
            writeln!(wrong, "{name}: {got} and {longest} cycles, not {mean} and {most}").unwrap();
        }
    }
}

/// Compares the edges of each move with the host's delays: there, and back.
fn moves(program: &Program, chip: &mut Chip, wrong: &mut String) {
    let edges = chip.take_edges();
    check(&edges, Needs::DEFAULT).unwrap_or_else(|error| panic!("{}: {error}", program.name));
    let steps = steps_of(&edges, 0);
    let mut left: &[Step] = &steps;
    let (mut at, mut forward) = (0, true);
    for (name, delays) in &program.moves {
        // There is no delay before the first step.
        let delays: Vec<u64> = delays
            .iter()
            .filter(|delay| **delay != 0)
            .map(|delay| u64::from(*delay) * 16)
            .collect();
        let count = delays.len() + 1;
        assert!(left.len() >= count, "{name}: {} steps of {count}", left.len());
        let (these, rest) = left.split_at(count);
        left = rest;
        let (mut due, mut worst) = (these[0].time, 0);
        for (step, delay) in these[1..].iter().zip(&delays) {
            due += delay;
            worst = worst.max(step.time.abs_diff(due));
        }
        at += if forward { count as i64 } else { -(count as i64) };
        forward = !forward;
        let fastest = 16_000_000 / delays.iter().min().unwrap();
        println!("{name}: {count} steps to {at}, {fastest} steps/s, {worst} cycles beside");
        if worst > BESIDE {
            writeln!(wrong, "{name}: a step is {worst} cycles beside its time").unwrap();
        }
        if these[count - 1].position != at {
            let there = these[count - 1].position;
            writeln!(wrong, "{name}: it ends at {there}, not {at}").unwrap();
        }
    }
    assert!(left.is_empty(), "{}: {} steps too many", program.name, left.len());
}
