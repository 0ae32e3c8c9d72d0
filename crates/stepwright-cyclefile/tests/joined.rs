//! A path of several pieces, for a board's memory.

use stepwright_cyclefile::{CycleText, along, read};

/// The legs of all motors of the example, in the order of the motors.
fn legs(text: &str) -> usize {
    let text = CycleText::named("joined.toml", text);
    let mut plan = read(&text).unwrap();
    let mut stages = std::mem::take(&mut plan.stages);
    let stage = &mut stages[0];
    let moves = along(&plan, &text, &plan.positions, &stage.task, &mut stage.acts, &stage.at);
    let mut legs = Vec::new();
    for mut part in moves.unwrap() {
        assert!(part.joined_path().is_some() && part.path().is_none());
        assert!(part.line(&mut legs).is_some());
    }
    legs.len()
}

/// A limit of jerk takes a few runs more; one that is no jerk is refused.
#[test]
fn a_path_with_limited_jerk_is_planned() {
    let example = include_str!("../../../examples/cycles/joined.toml");
    let with =
        |jerk: &str| example.replace("[cycle.path]", &format!("[cycle.path]\njerk = {jerk}"));
    let (plain, smooth) = (legs(example), legs(&with("8_000_000_000")));
    assert!(smooth > plain && smooth <= 2 * plain, "{smooth} {plain}");
    let text = with("-1");
    assert!(read(&CycleText::named("joined.toml", &text)).is_err());
}

#[test]
fn the_example_fits_the_memory_of_a_mega() {
    let example = include_str!("../../../examples/cycles/joined.toml");
    let count = legs(example);
    println!("{count} legs");
    assert!(count <= 400, "{count}");
}
