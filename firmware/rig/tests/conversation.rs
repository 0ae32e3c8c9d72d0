//! The Nano slave's conversations with the real binary.

mod common;

use common::{chip, rest, say, steps, talk};
use stepwright_rig::Chip;
use stepwright_sim::Pin;

#[test]
fn the_travel_order_of_the_document() {
    let mut chip = chip();
    talk(
        &mut chip,
        "F       R
         PO      Y
         S5      Y
         T100    Y
         R200    Y
         G+400   Y
         E       Y
         F       B
         V1      *
         *rest
         V1      400
         P0      Y
         G-1234  Y
         E       Y
         *rest
         V1      -834",
    );
    assert_eq!(steps(&chip, 0).len(), 1634);
    assert_eq!(steps(&chip, 0).last().unwrap().position, -834);
}

#[test]
fn while_busy_no_line_of_an_order_is_taken() {
    talk(
        &mut chip(),
        "g+      Y
         PO      E
         S5      E
         T5      E
         R5      E
         G+5     E
         g-      E
         E       E
         I1      E
         F       B
         V1      *
         A1      Y
         ?       stepwright * last=busy uncertain=0*
         !       Y
         Z       Y
         Z       Y
         K       Y
         F       R
         V1      E
         I1      Y
         V1      0",
    );
}

#[test]
fn drive_until_stopped() {
    let mut chip = chip();
    talk(
        &mut chip,
        "T50     Y
         g-      Y
         *wait 900
         F       B
         Z       Y
         F       B
         *rest
         V1      -*",
    );
    let position = chip.ask("V1").unwrap().parse::<i64>().unwrap();
    assert_eq!(steps(&chip, 0).last().unwrap().position, position);
    assert!(position < -200, "{position}");
}

#[test]
fn a_kill_loses_the_position_and_stops_at_once() {
    let mut chip = chip();
    talk(&mut chip, "K Y\nV1 0\ng+ Y\n*wait 100\nK Y");
    let seen = chip.edges().len();
    talk(&mut chip, "F R\nV1 E\nV2 0\n*wait 100");
    assert_eq!(chip.edges().len(), seen, "it stepped on");
    talk(&mut chip, "? stepwright *uncertain=1*\nI1 Y\nV1 0");
}

#[test]
fn nothing_one_and_two_steps() {
    let mut chip = chip();
    talk(&mut chip, "PO Y\nG+0 Y\nE Y\nF R\nV1 0");
    assert!(steps(&chip, 0).is_empty());
    for (line, position) in [("G+1", 1), ("G+2", 3), ("G-2", 1), ("G-1", 0)] {
        say(&mut chip, &format!("PO {line} E"));
        rest(&mut chip);
        assert_eq!(steps(&chip, 0).last().unwrap().position, position);
        chip.expect("V1", &position.to_string());
    }
    assert_eq!(steps(&chip, 0).len(), 6);
}

#[test]
fn what_cannot_be_is_refused_and_nothing_moves() {
    let mut chip = chip();
    talk(
        &mut chip,
        "E       E
         PO      Y
         T1000   E
         G+4000  Y
         E       E
         ?       stepwright * last=range uncertain=0*
         PO      Y
         t1000000 Y
         a100000000 Y
         d100000000 Y
         G+50000 Y
         E       E
         ?       stepwright * last=too-fast uncertain=0*
         G+-5    E
         V9      E
         12345678901234567 E
         T100    Y
         \"\"    E
         F       R",
    );
    assert!(steps(&chip, 0).is_empty());
    talk(&mut chip, "PO Y\nT100 Y\nR200 Y\nG+5 Y\nE Y\n*rest\nV1 5");
}

#[test]
fn one_step_beyond_the_limit_is_refused_and_the_limit_is_not() {
    let mut chip = chip();
    let health = chip.ask("?").unwrap();
    let max = health.split("max=").nth(1).unwrap().split(' ').next().unwrap();
    let max: u32 = max.parse().unwrap();
    say(&mut chip, &format!("PO s{max} t{} G+2000", max + 1));
    chip.expect("E", "E");
    talk(&mut chip, "? stepwright * last=too-fast uncertain=0*");
    say(&mut chip, &format!("PO s{max} t{max} G+2000 E"));
    rest(&mut chip);
    chip.expect("V1", "2000");
    assert_eq!(steps(&chip, 0).len(), 2000);
}

#[test]
fn the_longest_travel_begins_and_brakes() {
    let mut chip = chip();
    say(&mut chip, "PO T100 R200 G+2147483647 E");
    chip.run_for(16_000_000);
    talk(&mut chip, "F B\nZ Y\n*rest");
    let position = steps(&chip, 0).last().unwrap().position;
    chip.expect("V1", &position.to_string());
    assert!((950..1150).contains(&position), "{position}");
}

#[test]
fn bytes_lost_on_the_line_are_no_order() {
    let mut chip = chip();
    // Noise without a pause, far more than a buffer holds.
    chip.send(&[0xFF; 300]);
    chip.run_for(600_000);
    chip.ask("");
    talk(&mut chip, "F R\nV1 0\nPO Y\nG+3 Y\nE Y\n*rest\nV1 3");
}

/// DIR is kept for `hold-us`, 1 ms at most, even if the setting comes with the last step.
#[test]
fn a_pin_is_turned_round_no_sooner_than_after_the_last_step() {
    let mut chip = chip();
    say(&mut chip, "$hold-us=1000 PO T100 G+20 E");
    chip.send(b"$reverse=1");
    let rises = |chip: &Chip| {
        chip.edges().iter().filter(|edge| edge.pin == Pin::Step && edge.level).count()
    };
    assert!(chip.run_to(16_000_000, |chip| rises(chip) == 20));
    chip.send(b"\r");
    chip.run_for(16_000 * 5);
    let last = steps(&chip, 0)[19].time;
    let turned = chip.edges().iter().rfind(|edge| edge.pin == Pin::Direction).unwrap();
    assert!(turned.time > last + 16_000 && !turned.level, "{turned:?}, {last}");
}
