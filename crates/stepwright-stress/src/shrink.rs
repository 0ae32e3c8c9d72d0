//! Shortens a story that breaks a rule.

use crate::fault::Fault;
use crate::story::Story;

/// Removes acts while `play` still breaks the same rule.
pub fn shrink(
    story: &Story,
    fault: Fault,
    mut play: impl FnMut(&Story) -> Result<(), Fault>,
) -> (Story, Fault) {
    let (mut story, mut fault) = (story.clone(), fault);
    let mut length = story.acts.len().div_ceil(2);
    while length > 0 {
        let mut at = 0;
        while at < story.acts.len() {
            let mut shorter = story.clone();
            shorter.acts.drain(at..(at + length).min(story.acts.len()));
            match play(&shorter) {
                Err(other) if other.rule == fault.rule => (story, fault) = (shorter, other),
                _ => at += length,
            }
        }
        length /= 2;
    }
    (story, fault)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::{Rule, Rules};
    use crate::story::{Act, Board};

    #[test]
    fn what_matters_is_left() {
        let acts = (0..50).map(Act::Wait).collect();
        let story =
            Story { board: Board::simulated(1_000_000, false, 1, [9; 3], 0), acts, noise: 0 };
        let play = |story: &Story| {
            let both = [7, 31].iter().all(|n| story.acts.contains(&Act::Wait(*n)));
            if both { Rules::default().broken(Rule::Stop, 0, String::new) } else { Ok(()) }
        };
        let (short, _) = shrink(&story, play(&story).unwrap_err(), play);
        assert_eq!(short.acts, [Act::Wait(7), Act::Wait(31)]);
    }
}
