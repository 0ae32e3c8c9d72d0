//! The program `cycles`, through its lines.

use stepwright_cycle::line::{CycleLine, CycleReport, LineProgram, MotorPins};
use stepwright_cycle::{Calibration, Leg, Motor};
use stepwright_rig::board::Pin;
use stepwright_rig::{Board, Chip};

/// Sends a line that must be obeyed.
#[track_caller]
pub fn say(chip: &mut Chip, line: CycleLine) {
    assert_eq!(chip.ask(&line.to_string()).as_deref(), Some("Y"), "{line}");
}

/// Reads the status.
#[track_caller]
pub fn look(chip: &mut Chip) -> CycleReport {
    let answer = chip.ask(&CycleLine::Look.to_string()).expect("an answer");
    CycleReport::read(answer.as_bytes()).unwrap_or_else(|| panic!("{answer}"))
}

/// The watched pins of one of the first three motors: STEP, DIR and ENABLE.
pub fn wires(board: Board, motor: usize) -> [Pin; 3] {
    let analog = if board == Board::Uno { 'C' } else { 'F' };
    [board.step()[motor], board.direction()[motor], Pin(analog, 2 + motor as u8)]
}

/// Sets up a motor and its pins.
pub fn wire(chip: &mut Chip, motor: u8, what: Motor) {
    let mut codes = [MotorPins::NO_PIN; 5];
    for (code, Pin(port, bit)) in codes.iter_mut().zip(wires(chip.board(), motor.into())) {
        *code = 8 * (port as u8 - b'A') + bit;
    }
    say(chip, CycleLine::Motor(motor, what));
    say(chip, CycleLine::Wire(motor, MotorPins { codes }));
}

/// Prepares the motors from 0 on with a series each.
pub fn prepare(chip: &mut Chip, all: &[&[Leg]]) {
    let mut first = 0;
    for (motor, legs) in (0..).zip(all) {
        for (at, leg) in (first..).zip(*legs) {
            say(chip, CycleLine::Leg(at, *leg));
        }
        let count = legs.len() as u16;
        let program = LineProgram::Legs { first, count };
        say(chip, CycleLine::Prepare(motor, Calibration::None, program));
        first += count;
    }
}

/// Polls the status until the cycle is over, at most for this many milliseconds.
#[track_caller]
pub fn rest(chip: &mut Chip, limit: u64) -> CycleReport {
    let end = chip.now() + limit * 16_000;
    loop {
        let report = look(chip);
        if !report.running {
            return report;
        }
        assert!(chip.now() < end, "it still runs: {report:?}");
        chip.run_for(80_000);
    }
}
