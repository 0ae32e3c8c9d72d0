//! The common part of the tests of the chip: a board to talk to, and the expected effect of orders.
#![allow(dead_code)] // // each test uses a part of it

pub mod cycles;

use std::time::Duration;

use stepwright::profile::{Path, Ramp};
use stepwright::{Accel, Order, Rate, Speed, Ticks, Travel, late_after};
use stepwright_rig::edges::{Needs, Step, check, steps_of};
use stepwright_rig::{Board, Chip, Image, firmware};

/// The board under test: `STEPWRIGHT_BOARD`, or the Uno.
pub fn board() -> Board {
    let name = std::env::var("STEPWRIGHT_BOARD").unwrap_or_else(|_| "uno".into());
    name.parse().expect("STEPWRIGHT_BOARD")
}

/// Its firmware; with `STEPWRIGHT_TIMER`, the firmware for another step timer.
pub fn image() -> Image {
    let timer = std::env::var("STEPWRIGHT_TIMER").unwrap_or_else(|_| "1".into());
    let name = match &*timer {
        "1" => board().to_string(),
        timer => format!("{}-timer{timer}", board()),
    };
    let image = firmware::load(&name).unwrap_or_else(|error| panic!("{error:#}"));
    assert_eq!(board().step_timer(&image).number.to_string(), timer, "the timer of {name}");
    image
}

/// A board that has just been switched on and listens.
pub fn chip() -> Chip {
    let mut chip = Chip::new(board(), &image());
    wake(&mut chip);
    chip
}

/// A board that has just been switched on, with another program.
pub fn program(name: &str) -> Chip {
    let board = board();
    let image =
        firmware::load(&format!("{board}-{name}")).unwrap_or_else(|error| panic!("{error:#}"));
    let mut chip = Chip::new(board, &image);
    wake(&mut chip);
    chip
}

/// Waits until a board answers after a reset.
#[track_caller]
pub fn wake(chip: &mut Chip) {
    // The start takes a few milliseconds at most. A line sent during it is lost, and an empty line
    // gets in step again.
    for _ in 0..10 {
        if chip.ask("").is_some() {
            return;
        }
    }
    panic!("the board does not answer");
}

/// Long enough for every travel of the tests.
pub const MINUTE: Duration = Duration::from_secs(60);

/// Sends lines that must all be accepted.
#[track_caller]
pub fn say(chip: &mut Chip, lines: &str) {
    for line in lines.split_whitespace() {
        chip.expect(line, "Y");
    }
}

/// Waits for the end of the selected axes' travel, checks that no other axis moves, and checks
/// every driver's requirements.
#[track_caller]
pub fn rest(chip: &mut Chip) {
    assert!(chip.run_to_rest(MINUTE), "it never comes to rest");
    let made = chip.edges().len();
    chip.run_for(stepwright_rig::board::HZ / 20);
    assert_eq!(chip.edges().len(), made, "an axis that is not selected still moves");
    check(chip.edges(), Needs::DEFAULT).unwrap();
}

/// Plays a table: a line and its answer, with `*` for any characters. `*rest` waits for the end of
/// the travel, `*wait 5` this many milliseconds.
#[track_caller]
pub fn talk(chip: &mut Chip, table: &str) {
    for row in table.lines().map(str::trim).filter(|row| !row.is_empty()) {
        let (line, answer) = row.split_once(' ').unwrap_or((row, ""));
        match line {
            "*rest" => rest(chip),
            "*wait" => chip.run_for(16_000 * answer.trim().parse::<u64>().unwrap()),
            _ => {
                let got = chip.ask(&line.replace("\"\"", "")).expect(row);
                assert!(matches(&got, answer.trim()), "{row}: {got}");
            }
        }
    }
}

/// Whether `text` matches `pattern`, in which each `*` stands for anything.
fn matches(text: &str, pattern: &str) -> bool {
    match pattern.split_once('*') {
        Some((begin, rest)) => text.strip_prefix(begin).is_some_and(|left| {
            left.char_indices().map(|(at, _)| &left[at..]).chain([""]).any(|end| matches(end, rest))
        }),
        None => text == pattern,
    }
}

/// The rate of both boards' timers.
pub fn rate() -> Rate {
    Rate::from_hz(16_000_000).unwrap()
}

/// The path of an order with ramps in steps.
pub fn path_of_steps(start: u32, top: u32, ramp: u16, steps: u32) -> Path {
    path(start, top, Ramp::Steps(ramp), steps)
}

/// The path of an order with ramps in steps/s².
pub fn path_of_accel(start: u32, top: u32, accel: u32, steps: u32) -> Path {
    path(start, top, Ramp::Accel(Accel::from_steps(accel).unwrap()), steps)
}

fn path(start: u32, top: u32, ramp: Ramp, steps: u32) -> Path {
    let order = Order {
        start: Speed::from_steps(start).unwrap(),
        top: Speed::from_steps(top).unwrap(),
        up: ramp,
        down: ramp,
        jerk: None,
        travel: Travel::By(steps as i32),
    };
    order.path(rate()).unwrap()
}

/// Runs keep to the law within 1 µs, and a deadline is rounded to a cycle.
pub const FIT: i64 = 16 + 1;

/// The cycles from a deadline to its edge while other interrupts run too: the longest of them, and
/// the entry of the step interrupt. The first step's own latency shifts all others the other way.
pub const LATENCY: i64 = 250;

/// The same while other axes move, whose turns and slow steps take the long path.
pub const BESIDE: i64 = 1_500;

/// Checks that every step of `axis` comes at the time of the closed form, relative to the first
/// step.
#[track_caller]
pub fn follows(steps: &[Step], path: &Path, slack: i64) {
    assert_eq!(steps.len() as u64, u64::from(path.pulses()), "steps");
    let Some(first) = steps.first() else { return };
    let off = |n: usize| (steps[n].time - first.time) as i64 - path.time_of(n as u32) as i64;
    let worst = (0..steps.len()).max_by_key(|&n| off(n).abs()).unwrap();
    assert!(off(worst).abs() <= slack, "step {worst} is {} cycles off", off(worst));
}

/// The first step that is late by the edges alone: later than the earliest one, which waited for
/// nothing, by half of the interval to the next step and 1 µs. Its number and its lateness.
pub fn late_step(steps: &[Step], path: &Path) -> Option<(usize, i64)> {
    let from = steps.first()?.time as i64;
    let due = |n: usize| from + path.time_of(n as u32) as i64;
    let mut least = 0;
    steps.iter().enumerate().find_map(|(n, step)| {
        let off = step.time as i64 - due(n);
        least = least.min(off);
        let next = if n + 1 < steps.len() { n } else { n.saturating_sub(1) };
        let interval = (due(next + 1) - due(next)) as Ticks;
        (off - least > i64::from(late_after(interval, rate()))).then_some((n, off - least))
    })
}

/// The recorded steps of an axis of `chip`.
pub fn steps(chip: &Chip, axis: u8) -> Vec<Step> {
    steps_of(chip.edges(), axis)
}
