//! The reports of the program `timed`, field by field, and its actions other than steps: a callback
//! comes once, a shield's drivers are on from an order to its stop.

use stepwright::drive::sequence::SHIELD;
use stepwright_rig::board::Pin;
use stepwright_rig::{Board, Chip};
use stepwright_sim::timed::TimedBoard;
use stepwright_timed::fit::Hardware;
use stepwright_timed::line::{Line, Report, Wire};
use stepwright_timed::{Control, Model, SetSpeed};

use crate::common::{self, board};

const MILLIS: u64 = 16_000;
/// The caller's clock at the call.
const CALL: u32 = 1_009;

/// A board with a shield's motor on timer 1.
fn chip() -> Chip {
    let mut chip = common::program("timed");
    let bits = if board() == Board::Uno { [4, 5] } else { [6, 7] };
    let (sequence, mask) = (SHIELD.on_bits(&bits), 1 << bits[0] | 1 << bits[1]);
    let wire = Wire { port: b'B', mask, sequence, shield: true, phase: 0 };
    assert_eq!(ask(&mut chip, Line::Wire(1, wire)), "Y");
    chip
}

#[track_caller]
fn ask(chip: &mut Chip, line: Line) -> String {
    chip.ask(&line.to_string()).unwrap_or_else(|| panic!("{line}: no answer"))
}

#[track_caller]
fn look(chip: &mut Chip) -> Report {
    let answer = ask(chip, Line::Look(1));
    Report::read(answer.as_bytes()).unwrap_or_else(|| panic!("{answer}"))
}

/// Between two steps, 100 ms apart: every field, and the pattern, are the virtual board's.
#[test]
fn a_report_has_every_field_of_the_dump() {
    let slow = SetSpeed {
        control: Control::DRV_EN | Control::SPEED_VARIABLE | Control::IRQ_TIMING,
        top: 1_600_000,
        limit: 13,
        modification: 16_000,
        update_ms: 300,
        mod_counts: 4,
    };
    let millis = Control::ENDPOINT_MILLIS | Control::DIRECTION | Control::VARIABLE_PWR;
    for order in [slow, SetSpeed { control: slow.control | millis, limit: 1_280, ..slow }] {
        let mut chip = chip();
        assert_eq!(ask(&mut chip, Line::Move(1, order, CALL)), "0");
        let mut ideal = TimedBoard::new(Hardware::avr16(16_000_000), Model::Ideal, SHIELD, CALL);
        ideal.set_speed(&order);
        chip.run_for(45 * MILLIS);
        let mut patterns = 0u8;
        for _ in 0..16 {
            let report = look(&mut chip);
            ideal.run_for_millis(CALL + report.ms - ideal.millis());
            assert_eq!(report.dump, ideal.dump(), "{} ms after the call", report.ms);
            assert_eq!(report.moving, ideal.is_moving());
            patterns |= 1 << report.dump.pattern;
            let next = (report.ms / 100 + 1) * 100 + 45;
            chip.run_for(u64::from(next - report.ms) * MILLIS);
        }
        assert_eq!(patterns, 0b1111, "it was at every row of its table");
    }
}

#[test]
fn the_end_is_called_back_once() {
    let mut chip = chip();
    ask(&mut chip, Line::Check(1, 20));
    let order = SetSpeed { limit: 100, ..SetSpeed::fixed(Control::DRV_EN, 16_000) };
    assert_eq!(ask(&mut chip, Line::Move(1, order, CALL)), "0");
    chip.run_for(90 * MILLIS);
    assert_eq!(look(&mut chip).reached, None);
    chip.run_for(50 * MILLIS);
    let reached = look(&mut chip).reached;
    assert!((Some(100)..=Some(120)).contains(&reached), "{reached:?}");
    chip.run_for(500 * MILLIS);
    assert_eq!(look(&mut chip).reached, reached);
}

/// D3 and D11.
#[test]
fn a_shields_drivers_are_on_from_the_order_to_its_stop() {
    let enables = match board() {
        Board::Uno => [Pin('D', 3), Pin('B', 3)],
        Board::Mega => [Pin('E', 5), Pin('B', 5)],
    };
    let mut chip = chip();
    chip.watch_pins(&enables);
    assert_eq!(ask(&mut chip, Line::Move(1, SetSpeed::fixed(Control::DRV_EN, 16_000), 0)), "0");
    chip.run_for(20 * MILLIS);
    let on: Vec<_> = chip.watched_changes().iter().map(|change| (change.1, change.2)).collect();
    assert_eq!(on.len(), 2);
    assert!(on.contains(&(0, true)) && on.contains(&(1, true)), "{on:?}");
    assert_eq!(ask(&mut chip, Line::Move(1, SetSpeed::STOP, 0)), "0");
    let off: Vec<_> = chip.watched_changes()[2..].iter().map(|c| (c.1, c.2)).collect();
    assert_eq!(off.len(), 2);
    assert!(off.contains(&(0, false)) && off.contains(&(1, false)), "{off:?}");
}
