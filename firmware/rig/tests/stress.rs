//! Random stories on the chip, briefly: `cargo xtask stress --board uno` tells more.

mod common;

use common::{board, image};
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
