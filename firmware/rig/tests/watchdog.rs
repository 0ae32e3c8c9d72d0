//! The watchdog: a main loop that hangs.
//!
//! The chip's own code is changed while it runs: the main loop's planning becomes a jump to itself.
//! On a board that would be a fault of the program or of the chip; after the reset it may be gone
//! or not.

use crate::common::{chip, image, rest, say, steps, talk, wake};
use stepwright_rig::Chip;
use stepwright_sim::Pin;

/// `rjmp .-2`: interrupts continue.
const HANGS: &[u8] = &[0xFF, 0xCF];
/// `cli` before it: they don't.
const HANGS_DEAF: &[u8] = &[0xF8, 0x94, 0xFF, 0xCF];

/// 64 K cycles of 128 kHz. (A chip's 128 kHz may be a tenth off.)
const BITE: u64 = 8_192_000;
/// From the loop's own feeding to the place where it hangs.
const LOOP: u64 = 20_000;
/// The planned time ahead: the horizon of 16 ms and a run of 8 ms.
const AHEAD: u64 = 16_000 * 24;

/// The place where the loop hangs, and its original code.
struct Hung {
    address: u32,
    code: Vec<u8>,
}

/// Makes the main loop hang in its next round.
fn hang(chip: &mut Chip, code: &[u8]) -> Hung {
    let image = image();
    let address = image.functions(&["9main_loop4plan"]).next().expect("a main loop").address;
    assert!(chip.run_to(16_000_000, |chip| chip.pc() == address), "it never plans");
    Hung { address, code: chip.set_code(address, code) }
}

/// Waits until the reset. Returns the cycles.
#[track_caller]
fn bite(chip: &mut Chip) -> u64 {
    let (begin, resets) = (chip.now(), chip.resets());
    assert!(chip.run_to(2 * BITE, |chip| chip.resets() > resets), "nothing bites");
    chip.now() - begin
}

/// Removes the fault, and checks that the board has come back.
#[track_caller]
fn mend(chip: &mut Chip, hung: Hung) {
    chip.set_code(hung.address, &hung.code);
    wake(chip);
    assert_eq!(chip.resets(), 1);
}

#[test]
fn a_loop_that_hangs_is_reset_and_the_position_is_uncertain() {
    let mut chip = chip();
    say(&mut chip, "PO s0 t1000 a5000 d5000 G+4000 A2 G-4000 E");
    chip.run_for(16_000_000);
    let (begin, hung) = (chip.now(), hang(&mut chip, HANGS));
    let took = bite(&mut chip);
    assert!((BITE - LOOP..=BITE + 100).contains(&took), "{took} cycles");
    // Planned steps are made, and then there are no more.
    let made = steps(&chip, 0);
    assert!((500..1500).contains(&made.len()), "{} steps", made.len());
    assert!(made.last().unwrap().time < begin + LOOP + AHEAD, "it steps on");

    mend(&mut chip, hung);
    talk(
        &mut chip,
        "F       R
         V1      E
         V2      E
         V3      E
         ?       stepwright * uncertain=7*
         *wait   100",
    );
    assert_eq!(steps(&chip, 0).len(), made.len(), "it goes on after the reset");
    talk(&mut chip, "A1 Y\nI1 Y\nV1 0\nV2 E\nA2 Y\nV1 0\nV2 E");
    say(&mut chip, "A0 I1 I2 I3 A1 PO T100 G-70 E");
    rest(&mut chip);
    talk(&mut chip, "V1 -70\nV2 0\nV3 0\n? stepwright * uncertain=0*");
}

#[test]
fn one_that_hangs_without_interrupts_is_reset_and_steps_no_more() {
    let mut chip = chip();
    say(&mut chip, "PO s0 t1000 a5000 d5000 G+4000 E");
    chip.run_for(16_000_000);
    let hung = hang(&mut chip, HANGS_DEAF);
    let edges = chip.edges().len();
    let took = bite(&mut chip);
    assert!((BITE - LOOP..=BITE + 100).contains(&took), "{took} cycles");
    let after = &chip.edges()[edges..];
    // The reset releases all pins, also a high one.
    assert!(after.iter().all(|edge| !edge.level), "{after:?}");
    assert!(after.iter().filter(|edge| edge.pin == Pin::Step).count() <= 1, "{after:?}");
    mend(&mut chip, hung);
    talk(&mut chip, "F R\nV1 E\nI1 Y\nV1 0");
}

#[test]
fn a_board_at_rest_that_hangs_is_reset_and_doubts_too() {
    let mut chip = chip();
    say(&mut chip, "PO T100 G+30 E");
    rest(&mut chip);
    chip.expect("V1", "30");
    let hung = hang(&mut chip, HANGS);
    bite(&mut chip);
    mend(&mut chip, hung);
    talk(&mut chip, "V1 E\nI1 Y\nV1 0");
}

#[test]
fn it_bites_for_as_long_as_it_hangs() {
    let mut chip = chip();
    say(&mut chip, "PO T100 g+");
    chip.run_for(8_000_000);
    hang(&mut chip, HANGS);
    bite(&mut chip);
    let made = steps(&chip, 0).len();
    for _ in 0..3 {
        let took = bite(&mut chip);
        // The start comes before the loop.
        assert!((BITE..BITE + 160_000).contains(&took), "{took} cycles");
    }
    assert_eq!(steps(&chip, 0).len(), made, "it steps");
}

#[test]
fn a_loop_that_goes_round_is_left_alone() {
    let mut chip = chip();
    say(&mut chip, "PO T50 g-");
    chip.poll(&["V1", "?"]);
    chip.run_for(4 * BITE);
    assert_eq!(chip.resets(), 0);
}
