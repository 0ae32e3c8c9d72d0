//! stepper_h's triangle on the real binary, each side a line: its motors begin and end together,
//! each on a ramp of its own, scaled by its share of the distance.
//!
//! The rates are the highest ones of the bench without a late step, `rate_ramps` in
//! `bench/avr.json`, with its 40,000 steps/s² and its traffic. The criterion is also the bench's:
//! no late step, no byte lost, every edge within half an interval of the closed form. At
//! stepper_h's own size the side of two motors is so short that it turns round at 23,000 steps/s;
//! ten times as large, every side reaches its rate and holds it. The bench's rates are for motors
//! that differ by some tenths of a per cent; motors that end together keep a little less.
//!
//! `docs/benchmarks.md` has the rates of motors that do not end together, and the reason.

use std::path::Path;

use crate::common::{FIT, LATENCY, board, image, path_of_accel, rest, say, steps, wake};
use stepwright_rig::bench::Table;
use stepwright_rig::edges::Step;
use stepwright_rig::{Board, Chip, Image, firmware};

/// From (0, 0, 0) to (20000, 6666, 2666), to (6667, 20000, 2666), and back.
const SIDES: [[i32; 3]; 3] =
    [[20_000, 6_666, 2_666], [-13_333, 13_334, 0], [-6_667, -20_000, -2_666]];

/// Steps/s² of the motor that moves farthest: the bench's.
const ACCEL: u32 = 40_000;

/// The rate that two motors keep in every phase of the traffic if they reach their corners at the
/// same time: two runs have to be planned where the bench has one. At 36,000 some steps are late.
const TWO_TOGETHER: u32 = 35_000;

/// The same for three motors that end together: at the bench's 35,007 one step of the 200,000 of a
/// side is late, and also at 34,700.
const THREE_TOGETHER: u32 = 34_000;

/// The same for one motor: in some phases of the traffic, which change with every build, steps are
/// late at 114,000.
const ALONE: u32 = 110_000;

/// The bench's figures, in steps/s each, for 2 and for 3 motors.
fn rates() -> [u32; 2] {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../bench/avr.json");
    let table = Table::read(Path::new(file)).unwrap_or_else(|error| panic!("{error:#}"));
    [2, 3].map(|axes| table.get("rate_ramps", axes, "queued").expect("no rate_ramps") as u32)
}

fn awake(image: &Image) -> Chip {
    let mut chip = Chip::new(board(), image);
    wake(&mut chip);
    chip
}

/// A motor's part of a side.
#[derive(Clone, Copy, Debug)]
struct Part {
    axis: u8,
    way: i32,
    top: u32,
    accel: u32,
}

/// The part of each motor so that all of them move along a line, the farthest at `rate`.
fn line(way: [i32; 3], rate: u32) -> Vec<Part> {
    let longest = u64::from(way.iter().map(|way| way.unsigned_abs()).max().unwrap_or(1).max(1));
    let moving = (0..).zip(way).filter(|(_, way)| *way != 0);
    moving
        .map(|(axis, way)| {
            let share = |of: u32| {
                ((u64::from(of) * u64::from(way.unsigned_abs()) + longest / 2) / longest) as u32
            };
            Part { axis, way, top: share(rate), accel: share(ACCEL) }
        })
        .collect()
}

/// Plays a line under traffic, and checks every edge of it.
#[track_caller]
fn play(chip: &mut Chip, parts: &[Part]) {
    let before: Vec<Vec<Step>> = parts.iter().map(|part| steps(chip, part.axis)).collect();
    say(chip, "PO");
    for Part { axis, way, top, accel } in parts {
        say(chip, &format!("A{} s0 t{top} a{accel} d{accel} G{way:+}", axis + 1));
    }
    say(chip, "E");
    chip.poll(&["V1", "F"]);
    let paths =
        parts.iter().map(|part| path_of_accel(0, part.top, part.accel, part.way.unsigned_abs()));
    let paths: Vec<_> = paths.collect();
    let longest = paths.iter().map(|path| path.time_of(path.pulses() - 1)).max().unwrap();
    chip.run_for(longest);
    chip.poll(&[]);
    chip.run_for(1_000_000);
    chip.take_said();
    rest(chip);

    // Positions count all edges since power-up, so that DIR is known.
    let of_this =
        |(part, before): (&Part, &Vec<Step>)| steps(chip, part.axis)[before.len()..].to_vec();
    let made: Vec<Vec<Step>> = parts.iter().zip(&before).map(of_this).collect();
    for (((part, made), path), before) in parts.iter().zip(&made).zip(&paths).zip(&before) {
        let from = before.last().map_or(0, |step| step.position);
        let to = made.last().map_or(0, |step| step.position);
        assert_eq!(
            (made.len(), to - from),
            (part.way.unsigned_abs() as usize, part.way.into()),
            "{part:?}"
        );
        let off = |n: usize| (made[n].time - made[0].time) as i64 - path.time_of(n as u32) as i64;
        // The first step's latency is in all of them: the least counts as none.
        let least = (0..made.len()).map(off).min().unwrap();
        for n in 1..made.len() {
            let interval = path.time_of(n as u32) - path.time_of(n as u32 - 1);
            let late = off(n) - least;
            assert!(late <= interval as i64 / 2 + 2 * FIT, "{part:?}: step {n} is {late} late");
        }
    }
    assert_eq!(chip.lost(), 0);
    assert!(chip.ask("?").unwrap().contains(" late=0 "), "{parts:?}: {:?}", chip.ask("?"));
    let spread = |times: &[u64]| times.iter().max().unwrap() - times.iter().min().unwrap();
    let begun: Vec<u64> = made.iter().map(|made| made[0].time).collect();
    let ended: Vec<u64> = made.iter().map(|made| made[made.len() - 1].time).collect();
    assert!(spread(&begun) <= LATENCY as u64, "{parts:?} begin at {begun:?}");
    // Rates are whole steps/s, so some motors end a little before others.
    assert!(spread(&ended) <= longest / 2_000, "{parts:?} end at {ended:?}");
    stay_on_line(parts, &made);
}

/// Checks at each step of the motor that moves farthest that the others are on the line: to a step
/// that is due, a step that another motor made first, and half a step for each second, because
/// rates are whole steps/s.
#[track_caller]
fn stay_on_line(parts: &[Part], made: &[Vec<Step>]) {
    let lead = made.iter().max_by_key(|made| made.len()).unwrap();
    let all = lead.len() as f64;
    let seconds = (lead[lead.len() - 1].time - lead[0].time) as f64 / 16e6;
    for (part, own) in parts.iter().zip(made) {
        for (n, step) in (1u32..).zip(lead) {
            let at = own.partition_point(|one| one.time <= step.time) as f64;
            let off = at - f64::from(n) * own.len() as f64 / all;
            assert!(off.abs() <= 2.0 + seconds / 2.0, "{part:?}: {off} off at step {n}");
        }
    }
}

/// The triangle, `size` times as large, with these rates for two and for three motors.
fn triangle(chip: &mut Chip, size: i32, two: u32, three: u32) {
    let mut at = [0; 3];
    for side in SIDES {
        let way = side.map(|way| way * size);
        let parts = line(way, if way.contains(&0) { two } else { three });
        play(chip, &parts);
        for (axis, way) in (0..).zip(way) {
            at[axis] += way;
            chip.expect(&format!("V{}", axis + 1), &at[axis].to_string());
        }
    }
    assert_eq!(at, [0; 3]);
}

/// An Uno's figures do not apply to a Mega, which is slower.
fn bench() -> Option<Chip> {
    (board() == Board::Uno)
        .then(|| awake(&firmware::load("uno-bench").unwrap_or_else(|error| panic!("{error:#}"))))
}

#[test]
fn at_the_highest_clean_rates_of_the_bench() {
    let Some(mut chip) = bench() else { return };
    let [two, three] = rates();
    triangle(&mut chip, 1, two, three);
}

#[test]
fn ten_times_as_large_the_rates_are_reached_and_held() {
    let Some(mut chip) = bench() else { return };
    let [_, three] = rates();
    triangle(&mut chip, 10, TWO_TOGETHER, three.min(THREE_TOGETHER));
}

#[test]
fn one_motor_goes_out_and_back_and_out_and_back() {
    let Some(mut chip) = bench() else { return };
    for way in [400_000, -400_000, 400_000, -400_000] {
        play(&mut chip, &line([way, 0, 0], ALONE));
    }
    chip.expect("V1", "0");
}

/// The bench build refuses nothing; the flashed build does, and admits these.
#[test]
fn as_it_is_flashed() {
    let mut chip = awake(&image());
    let [two, three] = rates();
    triangle(&mut chip, 1, two, three);
}
