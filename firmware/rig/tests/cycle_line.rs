//! The program `cycles` through its lines only: positions of 64 bits during motion, inverted
//! directions, an ENABLE for each motor, the longest time of its handler.

use crate::common;
use crate::common::cycles::{look, prepare, say, wire};
use stepwright_cycle::line::{CycleLine, LineProgram};
use stepwright_cycle::{AtTiming, Calibration, Clock, Leg, Motor, Strategies};
use stepwright_protocol::crc;
use stepwright_rig::Chip;
use stepwright_rig::board::Pin;

/// The watched pins of a motor: STEP, DIR and ENABLE.
fn wires(motor: usize) -> [Pin; 3] {
    common::cycles::wires(common::board(), motor)
}

/// The times when a watched pin changed to a level.
fn changes(chip: &Chip, which: usize, level: bool) -> Vec<u64> {
    let all = chip.watched_changes().iter();
    let all = all.filter(|change| usize::from(change.1) == which && change.2 == level);
    all.map(|change| change.0).collect()
}

/// With the first calibration every step leaves the motor at its minimum; with the second, beyond
/// every bound, it moves the maximum along.
#[test]
fn calibrations_stay_at_the_minimum_and_take_the_maximum_along() {
    let mut chip = common::program("cycles");
    wire(&mut chip, 0, Motor::new(10, 1_000).between(-300, 200));
    say(&mut chip, CycleLine::Position(0, 50));
    let down = (Calibration::StartMin, -70, -300, 200);
    let up = (Calibration::BoundsMax, 90, 600, 600);
    for (n, (calibration, count, position, max)) in (1..).zip([down, up]) {
        say(&mut chip, CycleLine::New);
        let program = LineProgram::Steps { count, delay: 1_000 };
        say(&mut chip, CycleLine::Prepare(0, calibration, program));
        say(&mut chip, CycleLine::Start(n));
        chip.run_for(10 * 16_000);
        let report = look(&mut chip);
        assert!(report.running && (position == 600 || report.motors[0].position == -300));
        chip.run_for(100 * 16_000);
        let report = look(&mut chip);
        let motor = report.motors[0];
        assert!(!report.running && motor.faults == 0);
        assert_eq!((motor.position, motor.max), (position, Some(max)));
    }
}

const STEPS: i32 = 200;

/// Each moves in a cycle of its own; the second is inverted. Steps of 4 m in nm, from −800 m on.
#[test]
fn positions_have_64_bits_and_each_motor_its_enable_and_direction() {
    let mut chip = common::program("cycles");
    chip.watch_pins(&[wires(0), wires(1)].concat());
    chip.keep_visits();
    let wide = Motor::new(4_000_000_000, 1_000);
    for (motor, what) in [(0, wide), (1, wide.inverted())] {
        wire(&mut chip, motor, what);
        say(&mut chip, CycleLine::Position(motor, -800_000_000_000));
    }
    for motor in [0usize, 1] {
        let step = 3 * motor;
        say(&mut chip, CycleLine::New);
        let program = LineProgram::Steps { count: STEPS, delay: 2_000 };
        say(&mut chip, CycleLine::Prepare(motor as u8, Calibration::None, program));
        say(&mut chip, CycleLine::Start(motor as u8 + 1));
        let mut on_the_way = 0;
        loop {
            let before = changes(&chip, step, true).len() as i64;
            let report = look(&mut chip);
            let after = changes(&chip, step, true).len() as i64;
            let at = report.motors[motor].position;
            let steps = (at + 800_000_000_000) / 4_000_000_000;
            assert!(before <= steps && steps <= after, "{at} after {before} to {after} steps");
            if !report.running {
                break;
            }
            on_the_way += i32::from(steps > 2);
            chip.run_for(320_000);
        }
        assert!(on_the_way > 10);
        assert_eq!(look(&mut chip).motors[motor].position, 0);
    }
    // The longest time of the handler, in µs: that of the last step, without the part that ends the
    // cycle. So it lies between the longest stay that ended neither cycle and the longest of all.
    let longest = u64::from(look(&mut chip).longest);
    let mut seen: Vec<u64> = chip.take_visits().iter().map(|v| (v.exit - v.entry) / 16).collect();
    seen.sort_unstable_by(|a, b| b.cmp(a));
    let known = seen[2]..seen[0];
    assert!(known.contains(&longest), "{longest} µs, {known:?} by the simulator");
    for motor in [0usize, 1] {
        let [step, direction, enable] = [3 * motor, 3 * motor + 1, 3 * motor + 2];
        let rises = changes(&chip, step, true);
        assert_eq!(rises.len(), STEPS as usize);
        let (first, last) = (rises[0], rises[rises.len() - 1]);
        // Low is on: from before the first step of its own cycle until after the last.
        let (on, off) = (changes(&chip, enable, false), changes(&chip, enable, true));
        let [on] = on[..] else { panic!("motor {motor}: on {on:?}") };
        let off = off.into_iter().find(|off| *off > on).expect("it is never off");
        assert!(on < first && last < off && off - on < 17_000_000, "{on} to {off}");
        let forward = changes(&chip, direction, true).iter().any(|up| {
            *up < first && !changes(&chip, direction, false).iter().any(|d| d > up && *d < first)
        });
        assert_eq!(forward, motor == 0, "DIR of motor {motor}");
    }
}

/// Queried back to back, while three motors turn every few steps and one step comes every 300 µs:
/// the step interrupt takes a millisecond, and the receiver holds three bytes.
#[test]
fn no_byte_is_lost_while_motors_turn() {
    let mut chip = common::program("cycles");
    let late = Strategies { timing: AtTiming::Ignore, ..Strategies::CANCEL };
    say(&mut chip, CycleLine::Clock(Clock::Deadlines, late));
    let turns = |n| Leg::Steps { count: if n % 2 == 0 { 5 } else { -4 }, delay: 1_000 };
    let legs: Vec<_> = (0..6).map(turns).collect();
    for motor in 0..3 {
        wire(&mut chip, motor, Motor::new(10, 300).between(-10_000, 10_000));
    }
    for number in 1..=40 {
        say(&mut chip, CycleLine::New);
        prepare(&mut chip, &[&legs, &legs, &legs]);
        say(&mut chip, CycleLine::Start(number));
        // With a checksum a query is longer than the receiver's buffer. It comes at other moments
        // of the cycle each time.
        chip.run_for(48_000 + 2_000 * u64::from(number));
        let asked = format!(":?*{:02X}", b":?".iter().fold(0, |sum, byte| crc(sum, *byte)));
        let answer = chip.ask(&asked).expect("an answer");
        assert!(answer.starts_with("1,"), "{answer}");
        // After a common line without a checksum rows need none.
        chip.ask("F");
        while look(&mut chip).running {}
    }
    assert_eq!((chip.lost(), look(&mut chip).motors[2].position), (0, 40 * 3 * 10));
}

/// With checksums, every bit of the line that starts a cycle, its end too: it starts as sent, or
/// not at all.
#[test]
fn a_flipped_bit_of_a_start_moves_nothing() {
    let mut chip = common::program("cycles");
    wire(&mut chip, 0, Motor::new(10, 1_000));
    let endless = LineProgram::Whirl { forward: true, delay: 1_000 };
    say(&mut chip, CycleLine::Prepare(0, Calibration::None, endless));
    let summed = |line: &str| format!("{line}*{:02X}\r", line.bytes().fold(0, crc)).into_bytes();
    let start = summed(":G1");
    let moves = |chip: &mut Chip, line: &[u8]| {
        chip.send(line);
        chip.run_for(5 * 16_000);
        // The board may hold half a line.
        chip.ask("");
        let moves = chip.ask("F").as_deref() == Some("B");
        assert_eq!(chip.ask("Z").as_deref(), Some("Y"));
        chip.run_for(16_000);
        // The number of the last cycle starts none.
        say(chip, CycleLine::New);
        say(chip, CycleLine::Prepare(0, Calibration::None, endless));
        if moves {
            say(chip, CycleLine::Start(200));
            assert_eq!(chip.ask("Z").as_deref(), Some("Y"));
            chip.run_for(16_000);
            say(chip, CycleLine::Prepare(0, Calibration::None, endless));
        }
        moves
    };
    assert!(moves(&mut chip, &start));
    for bit in 0..8 * start.len() {
        let mut line = start.clone();
        line[bit / 8] ^= 1 << (bit % 8);
        let digit = (start.len() - 3..start.len() - 1).contains(&(bit / 8));
        let same = digit && line.eq_ignore_ascii_case(&start);
        assert_eq!(moves(&mut chip, &line), same, "bit {bit}");
    }
}

/// K makes the position of a moving motor unknown, and I1 sets it.
#[test]
fn a_kill_loses_the_position_of_a_motor_that_moved() {
    let mut chip = common::program("cycles");
    for motor in 0..2 {
        wire(&mut chip, motor, Motor::new(10, 1_000));
        say(&mut chip, CycleLine::Position(motor, 50));
    }
    let endless = LineProgram::Whirl { forward: true, delay: 1_000 };
    say(&mut chip, CycleLine::Prepare(1, Calibration::None, endless));
    say(&mut chip, CycleLine::Start(1));
    chip.run_for(20 * 16_000);
    for (line, answer) in [
        ("F", "B"),
        ("I2", "E busy"),
        ("K", "Y"),
        ("F", "R"),
        ("V1", "50"),
        ("V2", "E uncertain"),
        ("V4", "E axis"),
        ("I2", "Y"),
        ("V2", "0"),
    ] {
        if !(line == "V4" && common::board() == stepwright_rig::Board::Mega) {
            assert_eq!(chip.ask(line).as_deref(), Some(answer), "{line}");
        }
    }
}
