//! The Arduino driver's examples on the chip: the published logs from its serial line, and its
//! edges compared with the virtual board's.

use stepwright::drive::sequence::{L6219_QUARTER, SHIELD};
use stepwright_rig::board::Pin;
use stepwright_rig::{Board, Chip, IsrSpan, avr8js, firmware};
use stepwright_sim::timed::{TimedBoard, published};
use stepwright_timed::fit::Hardware;
use stepwright_timed::{Control, Model, SetSpeed};

use crate::common::board;

const MILLIS: u64 = 16_000;
/// `millis()` at the call.
const CALL: u32 = published::CALL_MS;
const CASE_1: SetSpeed = published::CASE_1.order;
const CASE_2: SetSpeed = published::CASE_2.order;
const CASE_3: SetSpeed = published::CASE_3.order;
/// The largest difference between an edge and the virtual board's, in cycles.
const EDGE: u64 = 40;

/// D12 and D13: the directions of windings A and B.
fn windings(board: Board) -> [Pin; 2] {
    match board {
        Board::Uno => [Pin('B', 4), Pin('B', 5)],
        Board::Mega => [Pin('B', 6), Pin('B', 7)],
    }
}

/// D3 and D11: the enables.
fn enables(board: Board) -> [Pin; 2] {
    match board {
        Board::Uno => [Pin('D', 3), Pin('B', 3)],
        Board::Mega => [Pin('E', 5), Pin('B', 5)],
    }
}

/// The board under test with an example in its flash. The watched pins are the windings', 0 and 1,
/// and the enables, 2 and 3.
fn example(name: &str) -> Chip {
    let board = board();
    let image = firmware::load(&format!("{}-{name}", board.name()))
        .unwrap_or_else(|error| panic!("{error:#}"));
    let mut chip = Chip::new(board, &image);
    chip.watch_pins(&[windings(board), enables(board)].concat());
    chip
}

/// The cycles of the steps made by pins `first` and the next one. A step changes one of them.
fn steps(changes: &[(u64, u8, bool)], first: u8) -> Vec<u64> {
    let pins = first..first + 2;
    changes.iter().filter(|(_, which, _)| pins.contains(which)).map(|(time, ..)| *time).collect()
}

/// The largest distance of the chip's steps from the virtual board's, both relative to their first.
#[track_caller]
fn compare(real: &[u64], ideal: &[u64]) -> u64 {
    assert!(real.len().abs_diff(ideal.len()) <= 1, "{} and {} steps", real.len(), ideal.len());
    let (r0, i0) = (real[0], ideal[0]);
    real.iter().zip(ideal).map(|(r, i)| (r - r0).abs_diff(i - i0)).max().unwrap_or(0)
}

/// The output of the chip, line by line.
fn lines(chip: &mut Chip) -> Vec<String> {
    split(&String::from_utf8(chip.take_said()).expect("no ASCII"))
}

fn split(text: &str) -> Vec<String> {
    text.split("\r\n").map(String::from).collect()
}

/// The dumps in `lines`, each with its ten fields in the article's order.
fn dumps(lines: &[String]) -> Vec<[u32; 10]> {
    const NAMES: [&str; 10] = [
        "motor_ctrl_irq: 0x",
        "motor_timer_top32virt_irq: ",
        "motor_timer_modify_irq: ",
        "motor_step_count_limit_irq: ",
        "motor_time_irq: ",
        "motor_stat_irq: 0x",
        "motor_update_time_irq: ",
        "motor_millis_endtime_irq: ",
        "motor_modCounts_irq: ",
        "motor_pattern_irq: ",
    ];
    let begins = (0..lines.len()).filter(|n| lines[*n].starts_with(NAMES[0]));
    begins
        .map(|begin| {
            std::array::from_fn(|n| {
                let line = &lines[begin + n];
                let value = line.strip_prefix(NAMES[n]).unwrap_or_else(|| panic!("{line:?}"));
                let radix = if NAMES[n].ends_with('x') { 16 } else { 10 };
                assert!(radix == 10 || value.len() == 2, "{line:?}");
                u32::from_str_radix(value, radix).expect(line)
            })
        })
        .collect()
}

fn virtual_board(model: Model, order: &SetSpeed) -> TimedBoard {
    let mut board = TimedBoard::new(Hardware::avr16(16_000_000), model, SHIELD, CALL);
    board.set_speed(order);
    board
}

/// The published log of case 1, with the call before it and the stop after it.
#[track_caller]
fn case_1s_log(lines: &[String]) {
    assert_eq!(lines[..3], ["IRQ Timer 1 Enabled", "Ioclk 16000000 Hz", ">>>motorSetSpeed"]);
    let name = if board() == Board::Uno { "Arduino Uno" } else { "Arduino Mega" };
    assert_eq!(lines[3], name);
    assert_eq!(lines[14], "Exit Code: 00");
    let dumps = dumps(lines);
    let log = published::CASE_1.log;
    assert_eq!(dumps.len(), log.len() + 2, "the call, the log, the stop");
    for (dump, row) in dumps[1..].iter().zip(log) {
        assert_eq!([dump[1], dump[2], dump[4], dump[8]], [row[0], row[1], row[3], row[4]]);
        assert!(dump[3].abs_diff(row[2]) <= 1, "{} steps left, {} in the log", dump[3], row[2]);
        assert_eq!([dump[0], dump[5], dump[6], dump[7]], [0xF0, 0, 1_000, 0]);
    }
    assert_eq!(dumps[dumps.len() - 1], [0, 0, 0, 0, 13_009, 0, 0, 0, 0, 0]);
    assert!(lines.iter().any(|line| line == "Motor halted"));
}

/// All steps of case 1, the enables around them, and the distances of the edges.
#[track_caller]
fn case_1s_edges(changes: &[(u64, u8, bool)]) -> u64 {
    let real = steps(changes, 0);
    assert_eq!(real.len(), 8_900);
    for which in [2, 3] {
        let enable: Vec<_> = changes.iter().filter(|(_, pin, _)| *pin == which).collect();
        assert_eq!(enable.len(), 2);
        assert!(enable[0].2 && enable[0].0 < real[0]);
        assert!(!enable[1].2 && enable[1].0 > real[8_899]);
    }
    let mut ideal = virtual_board(Model::Latched, &CASE_1);
    ideal.run_for_millis(20_000);
    compare(&real, ideal.steps())
}

#[test]
fn case_1_prints_the_published_log() {
    let mut chip = example("case1");
    chip.keep_visits();
    chip.run_for(u64::from(CALL + 15_000) * MILLIS);
    // The time of the step interrupt: plain, with an update at prescaler 1, with any update.
    let visits = chip.take_visits();
    let long = |visit: &IsrSpan| visit.exit - visit.entry;
    let mut plain: Vec<_> = visits.iter().map(long).collect();
    plain.sort_unstable();
    let plain = plain[plain.len() / 2];
    let early = visits.iter().filter(|visit| visit.exit < 9_000 * MILLIS).map(long).max();
    let longest = visits.iter().map(long).max();
    println!("step interrupt: {plain} cycles, {early:?} with an update, {longest:?} at most");
    assert!(plain <= 360 && early <= Some(1_300) && longest <= Some(1_400));
    case_1s_log(&lines(&mut chip));

    let off = case_1s_edges(chip.watched_changes());
    println!("case 1: {off} cycles");
    assert!(off <= EDGE, "{off} cycles off");
}

/// The same in fast PWM, mode 15: the compare register is buffered by the chip, not by a model.
#[test]
fn case_1_in_fast_pwm() {
    if board() != Board::Uno {
        return;
    }
    let pins = [windings(Board::Uno), enables(Board::Uno)].concat();
    let run = avr8js::run("uno-fast-pwm", CALL + 15_000, &pins);
    let run = run.unwrap_or_else(|error| panic!("{error:#}"));
    case_1s_log(&split(&run.said));
    let off = case_1s_edges(&run.changes);
    println!("case 1 in fast PWM: {off} cycles");
    assert!(off <= EDGE, "{off} cycles off");
    // It is not the other model: there the step after the tenth update ends 19 ms sooner.
    let real = steps(&run.changes, 0);
    let mut other = virtual_board(Model::Ideal, &CASE_1);
    other.run_for_millis(20_000);
    assert!(compare(&real, other.steps()) > 300_000);
}

#[test]
fn case_2_prints_the_published_log() {
    let mut chip = example("case2");
    chip.run_for(u64::from(CALL + 12_500) * MILLIS);
    let dumps = dumps(&lines(&mut chip));
    let log = published::CASE_2.log;
    assert!(dumps.len() > log.len());
    for (dump, row) in dumps[1..].iter().zip(log) {
        assert_eq!([dump[1], dump[2], dump[3], dump[4], dump[8]], *row);
        assert_eq!([dump[0], dump[5], dump[6], dump[7]], [0xF2, 0, 1_000, 0]);
    }
    let real = steps(chip.watched_changes(), 0);
    let mut ideal = virtual_board(Model::Latched, &CASE_2);
    while ideal.steps().len() < real.len() {
        ideal.run_until(ideal.due().unwrap());
    }
    let off = compare(&real, ideal.steps());
    println!("case 2: {off} cycles");
    assert!(off <= EDGE, "{off} cycles off");
}

#[test]
fn case_3_calls_back_once_and_its_main_loop_runs_on() {
    let mut chip = example("case3");
    chip.run_for(u64::from(CALL + 40_000) * MILLIS);
    let lines = lines(&mut chip);
    let called = lines.iter().filter(|line| line.as_str() == REACHED).count();
    assert_eq!(called, 1, "{lines:?}");
    let at = lines.iter().position(|line| line == REACHED).unwrap();
    let numbers = |lines: &[String]| -> Vec<u32> {
        lines.iter().filter_map(|line| line.parse().ok()).collect()
    };
    let (before, after) = (numbers(&lines[..at]), numbers(&lines[at..]));
    assert!(before.len() > 10 && after.len() > 3, "{lines:?}");
    let all = [before, after].concat();
    assert!(all.windows(2).all(|pair| pair[1] > pair[0] + 1_000), "{all:?}");

    let real = steps(chip.watched_changes(), 0);
    assert_eq!(real.len(), 10_000);
    let mut ideal = virtual_board(Model::Latched, &CASE_3);
    while ideal.is_moving() {
        ideal.run_for_millis(50);
        ideal.update_check(|_| {});
    }
    let off = compare(&real, ideal.steps());
    println!("case 3: {off} cycles");
    assert!(off <= EDGE, "{off} cycles off");
}

/// The fuses choose the oscillator, CLKPR divides it, and the firmware reads both. 0x62 is the
/// factory setting of a chip.
#[test]
fn the_io_clock_comes_from_fuses_and_clkpr() {
    for (low, clock) in [(0xFF, 16_000_000), (0xE2, 8_000_000), (0x62, 1_000_000), (0xE3, 128_000)]
    {
        let mut chip = example("case3");
        chip.set_low_fuse(low);
        chip.run_for(20 * MILLIS);
        assert_eq!(lines(&mut chip)[1], format!("Ioclk {clock} Hz"));
    }
}

const REACHED: &str = "Motor position reached / rotation stopped";

/// The time by which the other timer's interrupt may delay an edge, on its entry and exit.
const BESIDE: u64 = 250;

#[test]
fn two_shields_on_two_timers() {
    if board() != Board::Mega {
        return;
    }
    let image = firmware::load("mega-shields").unwrap_or_else(|error| panic!("{error:#}"));
    let mut chip = Chip::new(Board::Mega, &image);
    // D12, D13; D9, D8.
    chip.watch_pins(&[Pin('B', 6), Pin('B', 7), Pin('H', 6), Pin('H', 5), Pin('E', 5)]);
    chip.run_for(12_000 * MILLIS);
    let lower = SetSpeed { limit: 3_000, update_ms: 200, mod_counts: 10, ..CASE_1 };
    let upper = SetSpeed {
        control: Control::DRV_EN
            .and(Control::SPEED_VARIABLE)
            .and(Control::IRQ_TIMING)
            .and(Control::FASTER)
            .and(Control::DIRECTION),
        top: 80_000,
        limit: 2_000,
        modification: 3_000,
        update_ms: 100,
        mod_counts: 24,
    };
    for (first, order, count) in [(0, lower, 3_000), (2, upper, 2_000)] {
        let real = steps(chip.watched_changes(), first);
        assert_eq!(real.len(), count);
        let mut ideal = virtual_board(Model::Ideal, &order);
        ideal.run_for_millis(20_000);
        let off = compare(&real, ideal.steps());
        println!("shield on pins {first}: {off} cycles");
        assert!(off <= BESIDE, "{off} cycles off");
    }
    // The shields share the enables: high until the last one has stopped.
    let enable: Vec<_> = chip.watched_changes().iter().filter(|(_, pin, _)| *pin == 4).collect();
    assert_eq!(enable.len(), 2);
    let last = steps(chip.watched_changes(), 0)[2_999].max(steps(chip.watched_changes(), 2)[1_999]);
    assert!(enable[1].0 > last);
    let lines = lines(&mut chip);
    assert!(lines.iter().any(|line| line == "lower shield: position reached"));
    assert!(lines.iter().any(|line| line == "upper shield: position reached"));
}

/// The levels of the six lines of the L6219 from each change on, PHASE1 in bit 0.
fn levels(changes: &[(u64, u8, bool)]) -> Vec<(u64, u8)> {
    let mut all: Vec<(u64, u8)> = Vec::new();
    let mut now = 0;
    for (time, which, level) in changes {
        now = if *level { now | 1 << which } else { now & !(1 << which) };
        match all.last_mut() {
            Some(last) if last.0 == *time => last.1 = now,
            _ => all.push((*time, now)),
        }
    }
    all
}

/// Austin: the current goes on at the start and off after the last step; the phase stays, and is
/// restored at power-up.
#[test]
fn an_l6219_in_quarter_steps() {
    let board = board();
    let image = firmware::load(&format!("{}-l6219", board.name()));
    let mut chip = Chip::new(board, &image.unwrap_or_else(|error| panic!("{error:#}")));
    let port = if board == Board::Uno { 'B' } else { 'A' };
    chip.watch_pins(&[0, 1, 2, 3, 4, 5].map(|bit| Pin(port, bit)));
    chip.run_for(4_000 * MILLIS);
    let real = levels(chip.watched_changes());
    let forward = SetSpeed {
        control: Control::DRV_EN
            .and(Control::SPEED_VARIABLE)
            .and(Control::IRQ_TIMING)
            .and(Control::FASTER),
        top: 48_000,
        limit: 803,
        modification: 1_000,
        update_ms: 20,
        mod_counts: 30,
    };
    let back = Control::DRV_EN.and(Control::DIRECTION);
    let back = SetSpeed { limit: 401, ..SetSpeed::fixed(back, 24_000) };
    // Initially without current.
    assert_eq!(real[0].1, L6219_QUARTER.off());
    assert_eq!(real.len(), 1 + (803 + 2) + (401 + 2));
    let mut rest = &real[1..];
    let mut phase = 0;
    for order in [forward, back] {
        let mut ideal =
            TimedBoard::new(Hardware::avr16(16_000_000), Model::Ideal, L6219_QUARTER, 0);
        ideal.restore(phase);
        ideal.set_speed(&order);
        ideal.run_for_millis(3_000);
        let wanted: Vec<_> =
            ideal.changes()[1..].iter().map(|change| (change.time, change.levels)).collect();
        let (real, after) = rest.split_at(wanted.len());
        rest = after;
        let only = |all: &[(u64, u8)]| all.iter().map(|(_, levels)| *levels).collect::<Vec<_>>();
        assert_eq!(only(real), only(&wanted), "the current on, the steps, the current off");
        assert_eq!(wanted[wanted.len() - 1].1, L6219_QUARTER.off());
        let times = |all: &[(u64, u8)]| all[1..].iter().map(|(time, _)| *time).collect::<Vec<_>>();
        let off = compare(&times(real), &times(&wanted));
        let on = (real[1].0 - real[0].0).abs_diff(wanted[1].0 - wanted[0].0);
        println!("L6219: {off} cycles, the current on {on}");
        assert!(off <= EDGE && on <= 500, "{off} cycles off, the current on {on}");
        phase = ideal.phase();
    }
    assert_eq!(phase, 2, "803 - 401 = 25 · 16 + 2");
    let said = lines(&mut chip);
    assert_eq!(said[2..4], ["phase 3".to_owned(), format!("phase {phase}")]);

    // The power comes back: no step is lost.
    let before = chip.watched_changes().len();
    chip.power_loss(0xFF);
    chip.run_for(1_100 * MILLIS);
    let changes = &chip.watched_changes()[before..];
    let falls = changes.iter().take_while(|(.., level)| !level).count();
    let real = levels(&changes[falls..]);
    assert_eq!(real[0].1, L6219_QUARTER.off());
    assert_eq!(real[1].1, L6219_QUARTER.levels(phase));
    assert_eq!(real[2].1, L6219_QUARTER.levels(phase + 1));
}
