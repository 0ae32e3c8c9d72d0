//! Numbers that a file can't have: the message says which it can.

use stepwright_cyclefile::{CycleText, read};

/// What is wrong with a file of one cycle.
fn wrong(cycle: &str) -> String {
    let motor = "[[motor]]\nname = \"X\"\nstep = 1\nsmallest-delay-us = 100\n[[cycle]]\n";
    read(&CycleText::named("numbers.toml", format!("{motor}{cycle}\n"))).err().unwrap().what
}

#[test]
fn what_is_allowed_is_said_in_numbers() {
    let delay = |value: &str| wrong(&format!("move.X = {{ steps = 3, delay-us = {value} }}"));
    for value in ["-1", "99999999999", "nan", "1.5", "true", "\"10\"", "1e308", "1e-320"] {
        let said = delay(value);
        assert!(said.ends_with(", expected a whole number, 0 to 4294967295"), "{value}: {said}");
    }
    let said = wrong("move.X = { steps = 3000000000, delay-us = 900 }");
    assert!(said.ends_with(", expected a whole number, -2147483648 to 2147483647"), "{said}");
    let place = |value: &str| {
        wrong(&format!("line = {{ to = {{ X = {value} }}, speed = 100, accel = 1000 }}"))
    };
    let long = "4018446744073709551616000";
    let range = "a whole number, -9223372036854775808 to 9223372036854775807";
    for value in ["nan", "0.5", "1e308", "9223372036854775808", long] {
        let said = place(value);
        assert!(said.ends_with(&format!(", expected {range}")), "{value}: {said}");
        assert!(!said.contains("128"), "{value}: {said}");
    }
}

/// What was found is cut, and not what is expected.
#[test]
fn a_long_value_leaves_room_for_what_is_expected() {
    let said = wrong(&format!("\"{}\" = 1", "ä".repeat(400)));
    assert!(said.contains("…, expected one of `move`, `line`"), "{said}");
}

/// The range of a deceleration in the file's unit, and a file without a motor.
#[test]
fn what_there_is_is_said() {
    let decel = "[[motor]]\nname = \"X\"\nstep = 10\nsmallest-delay-us = 100\ndecel = 0.1\n[[cycle]]\nmove.X.steps = 1\n";
    let said =
        |text: &str| read(&CycleText::named("numbers.toml", text.to_owned())).err().unwrap().what;
    assert_eq!(
        said(decel),
        "a deceleration is 1 to 4294967295 steps/s²: 10 to 42949672950 units/s² here"
    );
    assert_eq!(
        said("motor = []\n[[cycle]]\nmove.X.steps = 1\n"),
        "there is no motor \"X\" in this file, nor any other"
    );
}
