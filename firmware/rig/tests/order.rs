//! An order of three axes is started piece by piece: the time of each piece, and what comes between
//! them.

use crate::common::{board, chip, image, rest, say, steps};
use stepwright_rig::{Board, Chip};

/// Orders with all kinds of ramps; each axis steps at once, or turns first.
const ORDERS: [&str; 5] = [
    "PO s0 t9000 a20000 d18000 G+4000 A2 s0 t8500 a18500 d18500 G+3000 A3 s0 t8000 a15500 d14500 G+2500",
    "PO s50 t9000 R999 G-4000 A2 s50 t8500 R900 G+3000 A3 s50 t8000 R777 G-2500",
    "PO s0 t9000 R999 G+200 A2 s0 t8500 R900 G-190 A3 s0 t8000 R777 G-175",
    "PO s0 t9000 a3000 d5000 G+200 A2 s50 t8500 R900 G+190 A3 s0 t8000 a88 d100000000 G-175",
    "PO s0 t9000 a100000000 d90000000 G+3 A2 s9000 t8500 G+2 A3 t1 G+1",
];

/// The cycles of a call of the main loop.
const PIECE: u64 = 3_200;

/// Sends E. Returns the calls of a part of the main loop up to the answer.
fn calls(chip: &mut Chip, method: &str, answer: &str) -> Vec<u64> {
    let image = image();
    let parts = ["9main_loop", method];
    let function = image.functions(&parts).next().expect("a part of the main loop");
    chip.watch_calls(function.address);
    assert_eq!(chip.ask("E").as_deref(), Some(answer));
    chip.take_calls()
}

#[test]
fn no_piece_of_an_order_takes_long() {
    // A Mega uses more bytes for an address, and its S-curves exceed a piece.
    if board() == Board::Mega {
        return;
    }
    for order in ORDERS {
        for method in ["4work", "6listen"] {
            let mut chip = chip();
            say(&mut chip, "$max-accel=100000000 $max-speed=1000000");
            say(&mut chip, order);
            let longest = calls(&mut chip, method, "Y").into_iter().max().unwrap();
            assert!(longest <= PIECE, "{longest} cycles of {method}: {order}");
        }
    }
}

#[test]
fn a_refused_third_axis_moves_none_and_takes_no_longer() {
    let order =
        "PO s0 t9000 a20000 d18000 G+4000 A2 t9000 G+4000 A3 s0 t62000 a90000 d90000 G+90000";
    let mut chip = chip();
    say(&mut chip, order);
    let longest = calls(&mut chip, "4work", "E").into_iter().max().unwrap();
    assert!(longest <= PIECE || board() == Board::Mega, "{longest}");
    assert!(chip.ask("?").unwrap().contains(" last=too-fast "));
    chip.run_for(16_000_000 / 50);
    assert!((0..3).all(|axis| steps(&chip, axis).is_empty()));
    say(&mut chip, "PO A1 G+3 E");
    rest(&mut chip);
    assert_eq!(steps(&chip, 0).len(), 3);
}

/// All of them make their first step in one visit of the step interrupts, or as far apart as they
/// are due.
#[test]
fn all_axes_begin_together() {
    for order in ORDERS {
        let mut chip = chip();
        say(&mut chip, order);
        chip.expect("E", "Y");
        say(&mut chip, "A0");
        rest(&mut chip);
        let firsts: Vec<u64> = (0..3).map(|axis| steps(&chip, axis)[0].time).collect();
        let apart = firsts.iter().max().unwrap() - firsts.iter().min().unwrap();
        assert!(apart < 600, "{firsts:?}: {order}");
    }
}

/// Planning does not go beyond a wait of 16 ms, so the first axes are ready while the last begins:
/// the drivers' time still counts from ENABLE.
#[test]
fn the_drivers_have_their_time() {
    for phase in 0..8 {
        let mut chip = chip();
        say(&mut chip, "$enable-ms=15 PO A0 t8589 s1238 a20000 d20000 G+89");
        chip.run_for(phase * 2_000);
        chip.expect("E", "Y");
        rest(&mut chip);
        let (on, level) = *chip.enable_changes().last().unwrap();
        assert!(!level, "still off");
        for axis in 0..3 {
            let waited = steps(&chip, axis)[0].time - on;
            assert!((15 * 16_000..20 * 16_000).contains(&waited), "{waited} cycles");
        }
    }
}

/// K acts between the pieces: no axis of the order moves, moving axes stop, and the line is in
/// step.
#[test]
fn a_kill_between_the_pieces_refuses_the_order() {
    let mut refused = 0;
    for after in (0..60).map(|n| n * 2_000) {
        let mut chip = chip();
        say(&mut chip, "t500 g+ A2 PO A2 s0 t9000 a20000 d18000 G+400 A3 t9000 G-400");
        chip.send(b"E\r");
        chip.run_for(2 * 1_389 + after);
        chip.send(b"K\r");
        chip.run_for(16_000_000 / 20);
        let said = String::from_utf8(chip.take_said()).unwrap();
        let moved = steps(&chip, 1).len() + steps(&chip, 2).len();
        assert!(matches!(&*said, "E\rY\r" | "Y\rY\r"), "{said:?} after {after}");
        if said == "E\rY\r" {
            refused += 1;
            assert_eq!(moved, 0, "after {after}");
            chip.expect("V2", "0");
            assert!(chip.ask("?").unwrap().contains(" last=killed uncertain=1 "));
        }
        let made = steps(&chip, 0).len();
        chip.run_for(16_000_000 / 20);
        assert_eq!(steps(&chip, 0).len(), made, "it moves after K");
        chip.expect("F", "R");
    }
    assert!(refused > 10, "K never came in between: {refused}");
}

/// A switch that closes between the pieces stops its axis, which the line says; the others move.
#[test]
fn a_switch_between_the_pieces_is_told() {
    let mut stopped = 0;
    for after in (0..40).map(|n| n * 4_000) {
        let mut chip = chip();
        say(&mut chip, "$switches=1 $switch-forward=1 PO A0 s0 t9000 a20000 d18000 G+400");
        chip.send(b"E\r");
        chip.run_for(2 * 1_389 + after);
        chip.press(0, true);
        chip.run_for(16_000_000 / 2);
        let said = String::from_utf8(chip.take_said()).unwrap();
        let moved = steps(&chip, 1).len();
        let about = chip.ask("?").unwrap();
        if said == "E\r" {
            assert!(about.contains(" last=fault "), "{about} after {after}");
            assert_eq!(moved, 0, "after {after}");
        } else {
            assert_eq!((&*said, moved), ("Y\r", 400), "after {after}");
            assert!(about.contains(" stop=S-- "), "{about} after {after}");
            stopped += u32::from(steps(&chip, 0).is_empty());
        }
    }
    assert!(stopped > 5, "the switch never closed in between: {stopped}");
}

/// Lines and noise that come meanwhile wait, and are answered in order.
#[test]
fn lines_that_come_meanwhile_wait() {
    let mut chip = chip();
    say(&mut chip, ORDERS[0]);
    chip.send(b"E\rF\rV1\rwhat\r\rF\r");
    chip.run_for(16_000_000 / 20);
    assert_eq!(String::from_utf8(chip.take_said()).unwrap(), "Y\rB\r0\rE\rE\rB\r");
    say(&mut chip, "A0");
    rest(&mut chip);
    chip.expect("V1", "4000");
}
