//! Random stories on the chip, briefly: `cargo xtask stress --board uno` plays more.

use crate::common::{board, image};
use stepwright_rig::Board;
use stepwright_rig::stress::{play, story};
use stepwright_stress::{Rules, Sum};

#[test]
fn stories_are_clean() {
    let (board, image) = (board(), image());
    let mut sum = Sum::default();
    for seed in 0..200 {
        let story = story(board, seed);
        match play(board, &image, &story, Rules::default()) {
            Ok(one) => sum = sum.plus(one),
            Err(fault) => panic!("# seed {seed}: {fault}\n{story}"),
        }
    }
    assert!(sum.steps > 1000 && sum.noise > 0, "{sum:?}");
}

/// Stories that once violated a rule on a chip, and on no virtual board. A board without S-curves
/// skips those with jerk.
#[test]
fn kept_stories_are_clean() {
    let (board, image) = (board(), image());
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/stories");
    let stories = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    let mut count = 0;
    for path in stories {
        let text = std::fs::read_to_string(&path).unwrap();
        if board == Board::Uno && text.contains("\n> j") {
            continue;
        }
        let story = text.parse().unwrap();
        let told = play(board, &image, &story, Rules::default());
        told.unwrap_or_else(|fault| panic!("{}: {fault}", path.display()));
        count += 1;
    }
    assert!(count >= if board == Board::Mega { 18 } else { 17 }, "{count}");
}

/// The board works longer on an order than its lease lasts: the host does not count as silent
/// meanwhile.
#[test]
fn an_order_that_takes_longer_than_a_lease() {
    if board() != Board::Uno {
        return;
    }
    let story = "board hz=16000000 bits=16 axes=3 cost=125,184,251 byte=1389\n\
        > L4\n> PO\n> G+2\n> A2\n> G+10\n> E\nwait 7708\n";
    let story = story.parse().unwrap();
    play(board(), &image(), &story, Rules::default()).unwrap_or_else(|fault| panic!("{fault}"));
}
