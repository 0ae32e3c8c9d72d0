//! The stress, briefly: stories of known seeds.

use stepwright_stress::run::{Run, tell};
use stepwright_stress::{Rules, make, simulate};

fn clean(seed: u64, stories: u64) {
    // These say of motion what is being mended now.
    let rules: Rules = "dwell,rise,fall,top".parse().unwrap();
    let run = Run { stories, rules, faults: 1, ..Run::default() };
    let outcome = run.all(seed, &make::story, &simulate);
    if let Some((seed, fault)) = outcome.faults.first() {
        panic!("{}", tell(*seed, &make::story(*seed), fault, |story| simulate(story, rules)));
    }
    assert_eq!(outcome.sum.stories, stories);
    assert!(outcome.sum.steps > 100 * stories && outcome.sum.noise > 0, "{:?}", outcome.sum);
}

#[test]
fn known_seeds() {
    clean(1000, 1500);
}
