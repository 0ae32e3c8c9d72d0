//! What a step of each law costs an AVR: the table in `docs/laws.md`. And its delays are
//! the host's.

use std::fmt::Write;

use stepwright::profile::Trapezoid;
use stepwright::{Accel, Rate, Speed};
use stepwright_austin::{
    Austin, Carried, Divisor, Fixed, LinearFactor, Piecewise, PowerTerm, Ramp, Slope,
};
use stepwright_rig::board::Pin;
use stepwright_rig::{Board, Chip, firmware};

/// A law, the sum of its delays here, and a step's cycles there: the mean, and the longest.
type Law = (&'static str, u32, u64, u64);

const STEPS: u32 = 1_000;

/// The laws of each program, in its order.
fn programs() -> [(&'static str, Vec<Law>); 4] {
    let (rate, top) = (Rate::MHZ, Speed::from_steps(2_000).unwrap());
    let accel = Accel::from_steps(10_000).unwrap();
    let law = Austin::new(rate, top, accel);
    let mut ramp = Ramp::new(rate, accel, Default::default()).unwrap();
    let up = ramp.by_ref().take(STEPS as usize / 2).sum();
    ramp.set(Slope::Down(accel));
    let trapezoid = Trapezoid::new(rate, Speed::ZERO, top, accel);
    let factor = LinearFactor::new(rate, top, accel);
    let power = |p| PowerTerm::new(rate, top, accel, p).delays(STEPS).unwrap().sum();
    let pieces = Piecewise::new(rate, top, accel);
    [
        (
            "closed",
            vec![
                ("trapezoid", trapezoid.delays(STEPS).unwrap().sum(), 4002, 62_293),
                ("listing", Fixed::new(STEPS, 9_560, 500).sum(), 962, 2555),
                ("remainder carried", Carried::new(STEPS, 9_560, 500).sum(), 528, 1596),
            ],
        ),
        (
            "general",
            vec![
                ("general form", law.delays(STEPS).unwrap().sum(), 2719, 7074),
                ("c/2n", law.with_divisor(Divisor::TwoN).delays(STEPS).unwrap().sum(), 2717, 7127),
                ("ramp that changes, up", up, 8175, 8804),
                ("ramp that changes, down", ramp.sum(), 8191, 8789),
            ],
        ),
        (
            "power",
            vec![
                ("power term, p = 2", power(2), 52_193, 73_534),
                ("power term, p = 4", power(4), 63_797, 91_746),
            ],
        ),
        (
            "smooth",
            vec![
                ("linear factor", factor.delays(STEPS).unwrap().sum(), 7506, 8268),
                ("piecewise", pieces.delays(STEPS).unwrap().sum(), 13_743, 21_732),
            ],
        ),
    ]
}

#[test]
fn a_step_of_each_law_costs_what_the_table_says() {
    let board: Board = std::env::var("STEPWRIGHT_BOARD").map_or(Board::Uno, |b| b.parse().unwrap());
    if board != Board::Uno {
        return;
    }
    let mut wrong = String::new();
    for (program, laws) in programs() {
        measure(program, &laws, &mut wrong);
    }
    assert!(wrong.is_empty(), "{wrong}");
}

fn measure(program: &str, laws: &[Law], wrong: &mut String) {
    let name = format!("uno-laws-{program}");
    let image = firmware::load(&name).unwrap_or_else(|error| panic!("{error:#}"));
    let mut chip = Chip::new(Board::Uno, &image);
    chip.watch_pins(&[Pin('B', 4), Pin('B', 5)]);
    // Until the pins have been still for a second.
    let mut seen = 0;
    loop {
        chip.run_for(16_000_000);
        let changes = chip.watched_changes().len();
        if changes == seen {
            break;
        }
        seen = changes;
    }
    // Cycles of each delay that was made, law by law.
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
    assert_eq!(cycles.len(), laws.len(), "laws of {program}");
    let (place, _) = image.variable("LAW_SUMS");
    for ((n, &(name, sum, mean, most)), mut cycles) in (0u16..).zip(laws).zip(cycles) {
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
