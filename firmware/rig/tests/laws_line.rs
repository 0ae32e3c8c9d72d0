//! Austin's laws ordered over the serial line, as by `stepwright move --law --port`: every edge
//! compared with the virtual board's.

use stepwright::{Accel, Rate, Speed};
use stepwright_austin::line::Line;
use stepwright_austin::station::Costs;
use stepwright_austin::{Austin, C0, Divisor, LawName, LinearFactor, Piecewise, PowerTerm, Recipe};
use stepwright_protocol::crc;
use stepwright_rig::edges::steps_of;
use stepwright_rig::{Board, Chip};
use stepwright_sim::{Description, Edge, LawBoard, Pin, Queues};

use crate::common::{self, board};

/// A millisecond in cycles.
const MILLIS: u64 = 16_000;
/// The largest difference between an edge and the virtual board's, in cycles: a byte of the line
/// delays a step by 27, the prologue of another interrupt by some more.
const EDGE: u64 = 40;

/// The program that has a law.
fn program(law: LawName) -> &'static str {
    match law {
        _ if board() != Board::Uno => "laws",
        LawName::Austin | LawName::AustinFixed => "laws",
        LawName::LinearFactor | LawName::Piecewise => "transitions",
        LawName::Power => "power-term",
    }
}

fn chip(law: LawName) -> Chip {
    common::program(program(law))
}

fn accel(steps: u32) -> Accel {
    Accel::from_steps(steps).unwrap()
}

/// The top speed for this shortest delay in µs.
fn speed(micros: u32) -> Speed {
    Speed::from_millisteps(1_000_000_000 / micros).unwrap()
}

/// Every law at the highest speed that its board accepts, and its variants.
fn recipes(pulses: u32) -> Vec<(&'static str, Recipe)> {
    let (rate, costs) = (Rate::MHZ, Costs::AVR);
    let general = Austin::new(rate, speed(costs.austin), accel(10_000)).with_decel(accel(7_000));
    let linear = LinearFactor::new(rate, speed(costs.linear_factor), accel(5_000));
    let power = PowerTerm::new(rate, speed(4 * costs.power), accel(500), 4);
    let steep = PowerTerm::new(rate, speed(9 * costs.power), accel(100), 9);
    let steep = steep.with_decel(accel(300));
    let pieces = Piecewise::new(rate, speed(costs.piecewise), accel(2_000));
    let two_n = general.with_divisor(Divisor::TwoN);
    vec![
        ("general form", Recipe::Austin(general.constants(pulses).unwrap())),
        ("c/2n", Recipe::Austin(two_n.constants(pulses).unwrap())),
        (
            "exact first step",
            Recipe::Austin(general.with_c0(C0::FirstStep).constants(pulses).unwrap()),
        ),
        ("the article's demo", Recipe::AustinFixed(50_000, 2_500)),
        ("listing", Recipe::AustinFixed(9_560, costs.austin_fixed)),
        ("linear factor", Recipe::LinearFactor(linear.constants(pulses).unwrap())),
        (
            "linear factor, knee",
            Recipe::LinearFactor(
                linear.with_knee(500).with_decel(accel(9_000)).constants(pulses).unwrap(),
            ),
        ),
        ("power term", Recipe::Power(power.constants(pulses).unwrap())),
        ("power term of 9", Recipe::Power(steep.constants(pulses).unwrap())),
        ("piecewise", Recipe::Piecewise(pieces.constants(pulses).unwrap())),
        (
            "piecewise, 8 breaks",
            Recipe::Piecewise(
                pieces.with_breaks(8).with_decel(accel(4_000)).constants(pulses).unwrap(),
            ),
        ),
    ]
}

/// The state of a motor.
#[derive(Debug, PartialEq)]
struct Seen {
    moving: bool,
    position: Option<i64>,
    late: u32,
}

#[track_caller]
fn look(chip: &mut Chip) -> Seen {
    let mut ask = |line| chip.ask(line).unwrap_or_else(|| panic!("{line}: no answer"));
    let moving = ask("F") == "B";
    let position = match ask("V1").as_str() {
        "E uncertain" => None,
        number => Some(number.parse().unwrap()),
    };
    let about = ask("?");
    let late = about.split(' ').find_map(|word| word.strip_prefix("late=")).unwrap();
    Seen { moving, position, late: late.parse().unwrap() }
}

/// Waits until it rests, polling every 20 ms as the command does.
#[track_caller]
fn rest(chip: &mut Chip) -> Seen {
    for _ in 0..5_000 {
        if chip.ask("F").as_deref() == Some("R") {
            return look(chip);
        }
        chip.ask("V1");
        chip.run_for(20 * MILLIS);
    }
    panic!("it never rests");
}

/// The steps of the virtual board for these lines.
fn wanted(lines: &[Line]) -> Vec<(u64, i64)> {
    let mut queues = Queues::default();
    let mut ideal: LawBoard<Vec<Edge>> = LawBoard::new(&mut queues, Description::uno(), Vec::new());
    for line in lines {
        format!("{line}\r").bytes().for_each(|byte| ideal.receive(byte));
        assert_eq!(ideal.take_answers(), b"Y\r", "{line}");
    }
    while ideal.is_busy() {
        let next = ideal.now() + MILLIS;
        ideal.run_until(next);
    }
    steps_of(ideal.recorder(), 0).iter().map(|step| (step.time, step.position)).collect()
}

/// Sends these lines, waits for the end, and compares every step with the virtual board's.
#[track_caller]
fn play(chip: &mut Chip, what: &str, lines: &[Line], position: i64) {
    // The direction from before.
    let facing = |edge: &Edge| edge.axis == 0 && edge.pin == Pin::Direction;
    let mut edges: Vec<Edge> = chip.take_edges().into_iter().rfind(facing).into_iter().collect();
    for line in lines {
        assert_eq!(chip.ask(&line.to_string()).as_deref(), Some("Y"), "{what}: {line}");
    }
    let seen = rest(chip);
    assert_eq!((seen.position, seen.late), (Some(position), 0), "{what}");
    edges.extend_from_slice(chip.edges());
    let real: Vec<(u64, i64)> =
        steps_of(&edges, 0).iter().map(|step| (step.time, step.position)).collect();
    let wanted = wanted(lines);
    assert_eq!(real.len(), wanted.len(), "{what}");
    let (r0, w0) = (real[0].0, wanted[0].0);
    let off = real.iter().zip(&wanted).map(|(r, w)| {
        assert_eq!(r.1, w.1, "{what}: its place");
        (r.0 - r0).abs_diff(w.0 - w0)
    });
    let off = off.max().unwrap();
    println!("{what}: {} steps, {off} cycles", real.len());
    assert!(off <= EDGE, "{what}: {off} cycles");
}

#[test]
fn every_law_steps_as_on_the_virtual_board_there_and_back() {
    const PULSES: i32 = 700;
    for (what, recipe) in recipes(PULSES as u32) {
        let mut chip = chip(recipe.law());
        play(&mut chip, what, &[Line::Law(recipe), Line::Go(PULSES)], PULSES.into());
        play(&mut chip, what, &[Line::Law(recipe), Line::Go(-PULSES)], 0);
    }
}

/// Eq 18, ordered beforehand: faster, slower, and as often as possible.
#[test]
fn a_ramp_changes_its_acceleration_on_its_way() {
    let law = Austin::new(Rate::MHZ, speed(1_000), accel(200)).with_decel(accel(400));
    let recipe = Line::Law(Recipe::Austin(law.constants(1_200).unwrap()));
    let changes = [(1, 900), (60, 150), (200, 1_000), (350, 77)];
    let lines: Vec<Line> = [recipe]
        .into_iter()
        .chain(changes.map(|(after, to)| Line::Change(after, accel(to))))
        .chain([Line::Go(1_200)])
        .collect();
    play(&mut chip(LawName::Austin), "a ramp that changes", &lines, 1_200);
}

/// A change and a stop that come during motion, from the moment of their effect.
#[test]
fn a_change_and_a_stop_on_the_way_hold_from_the_next_delay_made() {
    let mut chip = chip(LawName::Austin);
    let law = Austin::new(Rate::MHZ, speed(1_000), accel(100)).with_decel(accel(500));
    let recipe = Recipe::Austin(law.constants(1 << 31).unwrap());
    assert_eq!(chip.ask(&Line::Law(recipe).to_string()).as_deref(), Some("Y"));
    assert_eq!(chip.ask(":R0").as_deref(), Some("Y"));
    chip.run_for(1_500 * MILLIS);
    // The reported position is that of a step made since the query.
    for _ in 0..10 {
        let before = steps_of(chip.edges(), 0).len() as i64;
        let at = -chip.ask("V1").unwrap().parse::<i64>().unwrap();
        let after = steps_of(chip.edges(), 0).len() as i64;
        assert!(
            look(&mut chip).moving && before <= at && at <= after,
            "{before}, {at}, {after} steps"
        );
        chip.run_for(MILLIS);
    }
    let before = steps_of(chip.edges(), 0).len();
    assert_eq!(chip.ask(":C0,900000").as_deref(), Some("Y"));
    chip.run_for(500 * MILLIS);
    let later = steps_of(chip.edges(), 0).len();
    assert_eq!(chip.ask("Z").as_deref(), Some("Y"));
    let seen = rest(&mut chip);
    assert_eq!(seen.late, 0);
    let steps = steps_of(chip.edges(), 0);
    assert_eq!(seen.position, Some(-(steps.len() as i64)));
    // The same by the law, changed and braked a few steps after the steps made.
    let ticks: Vec<u64> = steps.windows(2).map(|pair| pair[1].time - pair[0].time).collect();
    let fits = (0..10).any(|changed| {
        (0..10).any(|braked| {
            let mut delays = recipe.delays(1 << 31);
            let mut all: Vec<u32> = delays.by_ref().take(before + changed).collect();
            delays.set_accel(accel(900));
            all.extend(delays.by_ref().take(later + braked - before - changed));
            delays.stop();
            all.extend(delays);
            let near = |(real, want): (&u64, &u32)| real.abs_diff(u64::from(*want) * 16) <= EDGE;
            all.len() == steps.len() && ticks.iter().zip(&all[1..]).all(near)
        })
    });
    assert!(fits, "{before} and {later} of {} steps", steps.len());
}

#[test]
fn the_board_says_what_it_can_and_refuses_what_it_cannot() {
    let mut chip = chip(LawName::Austin);
    let about = chip.ask("?").unwrap();
    let (name, can) = match board() {
        Board::Uno => ("uno", "austin,austin-fixed"),
        _ => ("mega", "austin,austin-fixed,linear-factor,piecewise,power"),
    };
    assert_eq!(about, format!("stepwright-laws {name} hz=16000000 axes=1 late=0 can=sum,{can}"));
    for (line, answer) in [
        ("", "E line"),
        ("PO", "E line"),
        ("G10", "E line"),
        (":A1,2,3", "E line"),
        (":G1x", "E line"),
        (":G2147483648", "E range 1,-2147483648,2147483647"),
        (":F50000,18446744073709551616", "E line"),
        ("V2", "E axis"),
        (":G10", "E law"),
        (":C10,500000", "E law"),
        (":F0,2500", "E unsound"),
        (":F5000000,2500", "E unsound"),
        (":F50000,399", "E fast 400"),
        (":F50000,2500", "Y"),
        (":C10,500000", "E law"),
        (":G0", "Y"),
        (":G100", "Y"),
        (":G100", "E busy"),
        (":F50000,2500", "E busy"),
        ("I1", "E busy"),
        ("K", "Y"),
    ] {
        assert_eq!(chip.ask(line).as_deref(), Some(answer), "{line}");
    }
    let seen = look(&mut chip);
    assert_eq!((seen.moving, seen.position), (false, None));
    assert_eq!(chip.ask("I1").as_deref(), Some("Y"));
    assert_eq!(look(&mut chip).position, Some(0));
    // A kill leaves nothing behind.
    play(
        &mut chip,
        "after a kill",
        &[Line::Law(Recipe::AustinFixed(9_560, 1_000)), Line::Go(50)],
        50,
    );
}

/// With checksums, every bit of an order, its end too: it is obeyed as sent, or not at all. (A
/// digit of the checksum may become the small letter: that is the same order.)
#[test]
fn a_flipped_bit_of_an_order_moves_nothing() {
    let order = format!(":R1*{:02X}\r", b":R1".iter().fold(0, |sum, byte| crc(sum, *byte)));
    let order = order.into_bytes();
    let mut chip = chip(LawName::AustinFixed);
    assert_eq!(chip.ask(":F5000,1000").as_deref(), Some("Y"));
    let moves = |chip: &mut Chip, line: &[u8]| {
        chip.send(line);
        chip.run_for(5 * MILLIS);
        // The board may hold half a line.
        chip.ask("");
        let moves = chip.ask("F").as_deref() == Some("B");
        chip.ask("K");
        moves
    };
    assert!(moves(&mut chip, &order));
    for bit in 0..8 * order.len() {
        let mut line = order.clone();
        line[bit / 8] ^= 1 << (bit % 8);
        let digit = (order.len() - 3..order.len() - 1).contains(&(bit / 8));
        let same = digit && line.eq_ignore_ascii_case(&order);
        assert_eq!(moves(&mut chip, &line), same, "bit {bit}");
    }
}
