//! Resets, losses of power at any moment, and the drivers' pins meanwhile.

use crate::common::{board, chip, image, rest, say, steps, talk, wake};
use stepwright_rig::Chip;

#[test]
fn a_reset_stops_everything_and_the_board_starts_afresh() {
    let mut chip = chip();
    say(&mut chip, "PO T100 G+4000 E");
    chip.run_for(8_000_000);
    let before = steps(&chip, 0).len();
    assert!((100..1000).contains(&before), "{before}");
    chip.reset();
    wake(&mut chip);
    talk(&mut chip, "F R\n*wait 100");
    assert_eq!(steps(&chip, 0).len(), before, "it stepped on");
    assert_eq!(chip.resets(), 1);
    say(&mut chip, "I1 PO G+7 E");
    rest(&mut chip);
    chip.expect("V1", "7");
    assert_eq!(steps(&chip, 0).len(), before + 7);
}

#[test]
fn a_power_loss_stops_everything_and_the_board_starts_afresh() {
    let mut chip = chip();
    say(&mut chip, "PO T100 G+4000 A2 G-4000 E");
    chip.run_for(8_000_000);
    let before = steps(&chip, 0).len();
    chip.power_loss(0xFF);
    wake(&mut chip);
    talk(&mut chip, "F R\nA2 Y\nF R\nV1 0\nV2 0\n*wait 100");
    assert_eq!(steps(&chip, 0).len(), before, "it stepped on");
}

/// An EEPROM in which `$pulse-us` is 5.
fn kept() -> Vec<u8> {
    let mut chip = chip();
    say(&mut chip, "$pulse-us=5");
    chip.run_for(16_000_000 / 2);
    assert!(!chip.eeprom_is_busy() && chip.eeprom_written() > 0);
    chip.eeprom()
}

#[test]
fn settings_outlast_the_power() {
    let eeprom = kept();
    let mut chip = Chip::new(board(), &image());
    chip.set_eeprom(0, &eeprom);
    wake(&mut chip);
    chip.expect("$pulse-us", "pulse-us=5");
    chip.power_loss(0);
    wake(&mut chip);
    chip.expect("$pulse-us", "pulse-us=5");
    say(&mut chip, "PO T100 G+50 E");
    rest(&mut chip);
    let (edges, wide) = (chip.edges(), 5 * 16);
    let pulses = edges.iter().filter(|edge| edge.is_step());
    for rise in pulses {
        let fall = edges.iter().find(|edge| {
            edge.axis == 0 && edge.pin == rise.pin && !edge.level && edge.time > rise.time
        });
        assert!(
            fall.unwrap().time - rise.time >= wide,
            "{} of {wide}",
            fall.unwrap().time - rise.time
        );
    }
}

#[test]
fn a_power_loss_at_any_byte_leaves_the_old_settings_or_the_new_ones() {
    let (eeprom, image) = (kept(), image());
    // A byte takes 54,400 cycles: every one of them is hit more than once.
    let (mut old, mut new) = (0, 0);
    for cut in (0..).map(|n| 1_000 + n * 23_456) {
        let mut chip = Chip::new(board(), &image);
        chip.set_eeprom(0, &eeprom);
        wake(&mut chip);
        say(&mut chip, "$pulse-us=9");
        chip.run_for(cut);
        let writing = chip.eeprom_is_busy();
        let before = chip.eeprom_written();
        chip.power_loss([0x00, 0xFF, 0x50, 0xA5][cut as usize / 23_456 % 4]);
        wake(&mut chip);
        match chip.ask("$pulse-us").as_deref() {
            Some("pulse-us=5") => old += 1,
            Some("pulse-us=9") => new += 1,
            other => panic!("cut at {cut}: {other:?}"),
        }
        // Everything else is unchanged, and can be set again.
        chip.expect("$hold-us", "hold-us=1");
        say(&mut chip, "$pulse-us=3");
        chip.run_for(16_000_000 / 2);
        chip.power_loss(0xFF);
        wake(&mut chip);
        chip.expect("$pulse-us", "pulse-us=3");
        // Between two bytes it is not busy either.
        if !writing && before > 0 && new > 0 {
            break;
        }
        assert!(cut < 16_000_000, "it never ends writing");
    }
    assert!(old > 3 && new > 0, "old {old}, new {new}");
}

#[test]
fn the_drivers_are_enabled_before_the_first_step_and_off_after_the_idle_time() {
    let mut chip = chip();
    // High is off.
    assert!(chip.enable_changes().last().is_some_and(|change| change.1), "enabled at power-up");
    say(&mut chip, "$enable-ms=20 $idle-ms=100 PO T100 G+10 E");
    rest(&mut chip);
    let (on, level) = *chip.enable_changes().last().unwrap();
    assert!(!level, "still off");
    let (first, last) = (steps(&chip, 0)[0].time, steps(&chip, 0)[9].time);
    assert!(first - on >= 20 * 16_000, "{} cycles", first - on);
    chip.run_for(16_000 * 120);
    let (off, level) = *chip.enable_changes().last().unwrap();
    assert!(level, "still on");
    let idle = off - last;
    assert!((99 * 16_000..104 * 16_000).contains(&idle), "{idle} cycles");
}

#[test]
fn a_silent_host_makes_it_brake() {
    let mut chip = chip();
    say(&mut chip, "$timeout-ms=200 T100 g+");
    chip.run_for(16_000_000 * 2);
    let (count, last) = (steps(&chip, 0).len(), steps(&chip, 0).last().unwrap().time);
    assert!(last < chip.now() - 8_000_000, "it runs on");
    chip.expect("F", "R");
    chip.expect("V1", &count.to_string());
}

/// An answer of 8 ms, of which 3 ms are sent in the background, is no silence either.
#[test]
fn a_line_that_takes_long_is_no_silence() {
    for (ms, lines) in [(2, ["E", "@+500", "Z"]), (5, ["E", "?", "Z"])] {
        let mut chip = chip();
        say(&mut chip, &format!("$timeout-ms={ms} PO T50 G+900 A2 T50 G+900 A3 T50 G-900"));
        for line in lines {
            chip.ask(line);
        }
        let health = chip.ask("?").unwrap();
        assert!(health.contains("stop=--Z"), "{ms} ms: {health}");
        chip.run_for(16_000 * (ms + 4));
        let health = chip.ask("?").unwrap();
        assert!(health.contains("stop=TTZ"), "{ms} ms: {health}");
    }
}

#[test]
fn statics_and_stack_leave_room_in_the_ram() {
    let mut chip = chip();
    // The deepest paths: an order of three axes, refused and accepted, all settings, and traffic in
    // motion.
    say(&mut chip, "PO t900 a5000 d5000 G+900 A2 t800 G+800 A3 t700 G-700");
    chip.ask("A9");
    chip.ask("E");
    say(&mut chip, "PO A1 t900 a5000 d5000 G+900 A2 t800 G+800 A3 t700 G-700 E");
    chip.ask("$");
    chip.ask("?");
    chip.poll(&["V1", "F", "?"]);
    chip.run_for(16_000_000);
    chip.poll(&[]);
    let (statics, stack) = chip.ram();
    let ram = match board() {
        stepwright_rig::Board::Uno => 2_048,
        stepwright_rig::Board::Mega => 8_192,
    };
    assert!(statics + stack + 64 <= ram, "{statics} bytes of statics, {stack} of stack");
}
