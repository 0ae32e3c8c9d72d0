//! Resets for every reason, at every moment: the position is known afterwards if it is still true,
//! and otherwise unknown.

use crate::common::{board, chip, image, rest, say, talk, wake};
use stepwright_rig::{Cause, Chip};

const CAUSES: [Cause; 4] = [Cause::Power, Cause::Button, Cause::BrownOut, Cause::Watchdog];

/// The activity of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Doing {
    /// It has not moved since it was switched on.
    Nothing,
    /// It rests, after moving.
    Rest,
    Motion,
}

fn doing(what: Doing) -> Chip {
    let mut chip = chip();
    match what {
        Doing::Nothing => talk(&mut chip, "V1 0\n*wait 20"),
        Doing::Rest => {
            say(&mut chip, "PO T100 G-40 E");
            rest(&mut chip);
            talk(&mut chip, "V1 -40\n*wait 5");
        }
        Doing::Motion => {
            say(&mut chip, "PO T100 G+4000 E");
            chip.run_for(8_000_000);
        }
    }
    chip
}

/// Whether all positions are known; then they are 0.
#[track_caller]
fn is_known(chip: &mut Chip) -> bool {
    wake(chip);
    match chip.ask("V1").as_deref() {
        Some("0") => {
            talk(chip, "V2 0\nV3 0\n? stepwright * uncertain=0 *");
            true
        }
        Some("E") => {
            talk(chip, "V2 E\n? stepwright * uncertain=7 *");
            // Until it is set to 0.
            talk(chip, "I1 Y\nV1 0\nV2 E");
            false
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_reset_is_held_against_what_the_board_was_doing() {
    for cause in CAUSES {
        for (what, known) in [
            (Doing::Nothing, cause != Cause::Watchdog),
            (Doing::Rest, cause == Cause::Power),
            (Doing::Motion, false),
        ] {
            let mut chip = doing(what);
            chip.reset_by(cause);
            assert_eq!(is_known(&mut chip), known, "{cause:?} in {what:?}");
        }
    }
}

/// With the drivers on, the mark depends on no line but the order's own, wherever in a millisecond it
/// comes.
#[test]
fn a_later_order_is_marked_at_every_moment() {
    for phase in (0..40).map(|n| n * 400) {
        let mut chip = chip();
        say(&mut chip, "PO G+4 E");
        rest(&mut chip);
        say(&mut chip, "PO T100 G+2000");
        chip.run_for(phase);
        say(&mut chip, "E");
        chip.run_for(4_000_000);
        chip.reset_by(Cause::Power);
        assert!(!is_known(&mut chip), "after {phase} cycles");
    }
}

/// Then the board can't distinguish the resets: RAM alone tells whether it has moved.
#[test]
fn a_boot_loader_may_clear_the_reason() {
    for cause in CAUSES {
        for what in [Doing::Nothing, Doing::Rest, Doing::Motion] {
            let mut chip = doing(what);
            chip.reset_by(cause);
            chip.clear_cause();
            assert_eq!(is_known(&mut chip), what == Doing::Nothing, "{cause:?} in {what:?}");
        }
    }
}

#[test]
fn a_board_that_is_switched_on_is_at_0() {
    for clears in [false, true] {
        let mut chip = Chip::new(board(), &image());
        for _ in 0..2 {
            if clears {
                chip.clear_cause();
            }
            assert!(is_known(&mut chip));
            say(&mut chip, "PO T100 G+9 E");
            rest(&mut chip);
            // For a long time: RAM has lost the mark.
            chip.power_loss(0xFF);
        }
    }
}

/// An unknown position does not become known by another reset.
#[test]
fn a_doubt_outlasts_further_resets() {
    for clears in [false, true] {
        let mut chip = doing(Doing::Motion);
        for _ in 0..3 {
            chip.reset_by(Cause::Button);
            if clears {
                chip.clear_cause();
            }
            assert!(!is_known(&mut chip));
        }
    }
}
