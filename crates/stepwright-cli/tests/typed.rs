//! What a person types at the first try: it is taken, or the answer says what to type.

use crate::common::{Ended, Scratch, stepwright};
use serde_json::Value;

fn typed(line: &str) -> Ended {
    let words: Vec<_> = line.split(' ').collect();
    stepwright(&[&words[..], &["--machine", "none"]].concat())
}

#[track_caller]
fn refused(line: &str, error: &str, hint: &str) {
    let ended = typed(line);
    let has = |begin: &str, text: &str| {
        ended.stderr.lines().any(|said| said.starts_with(begin) && said.contains(text))
    };
    assert!(has("error: ", error), "{line}: {ended:#?}");
    assert!(has(" hint: ", hint), "{line}: {ended:#?}");
    assert_eq!(ended.code(), Some(2), "{line}: {ended:#?}");
}

#[test]
fn a_number_may_stand_apart_from_its_unit() {
    typed("move 10 mm --mm-per-rev 40 --fast").assert(0, "position 50 ready");
    typed("move -90 deg --top-speed 60 rpm --fast").assert(0, "position -50 ready");
    typed("line 10 mm -5 mm --mm-per-rev 40 --fast").assert(0, "position 50 -25 ready");
    typed("run -120 rpm --for 0.1 s --fast")
        .assert(0, typed("run -120rpm --for 0.1s --fast").last_line());
    refused("move 10 mm --fast", "10mm: millimetres", "--mm-per-rev 40");
}

#[test]
fn a_speed_is_taken_by_its_short_name() {
    typed("move 100 --speed 500 --fast").assert(0, "position 100 ready");
    let long = typed("move 100 --top-speed 500 --fast");
    assert_eq!(typed("move 100 --speed 500 --fast").stdout, long.stdout);
    assert_eq!(typed("line 100 --speed 500 --fast").code(), Some(0));
    assert_eq!(typed("run --speed 100 --for 1s --fast").code(), Some(0));
    typed("plan trapezoid --steps 10 --accel 100 --speed 100")
        .assert(0, typed("plan trapezoid --steps 10 --accel 100 --top-speed 100").last_line());
}

#[test]
fn a_timer_has_its_clock_in_mhz() {
    let plan = |hz| {
        typed(&format!("plan trapezoid --steps 10 --accel 100 --top-speed 100 --timer-hz {hz}"))
    };
    let plain = plan("16000000");
    assert_eq!(plain.code(), Some(0), "{plain:#?}");
    for same in ["16MHz", "16000kHz", "16 MHz", "16000000Hz"] {
        assert_eq!(plan(same).stdout, plain.stdout, "{same}");
    }
    let ended = plan("1GHz");
    assert!(ended.stderr.contains("100000 Hz to 200 MHz"), "{ended:#?}");
}

#[test]
fn axes_have_letters_too() {
    for (axis, number) in [("X", 1), ("y", 2), ("Z", 3)] {
        let ended = typed(&format!("move 10 --axis {axis} --fast"));
        ended.assert(0, "position 10 ready");
        assert!(ended.stdout.starts_with(&format!("axis {number} ")), "{ended:#?}");
    }
    let ended = typed("move 10 --axis 9 --fast");
    assert!(ended.stderr.contains("1 to 8, or X, Y, Z"), "{ended:#?}");
}

#[test]
fn steps_to_plan_may_be_a_length() {
    let options = "--accel 100 --top-speed 100 --mm-per-rev 40";
    let (mm, steps) = (
        typed(&format!("plan trapezoid --steps 10mm {options}")),
        typed(&format!("plan trapezoid --steps 50 {options}")),
    );
    assert_eq!(mm.code(), Some(0), "{mm:?}");
    let shown = "  distance          10mm → 50 steps\n";
    assert_eq!(mm.stdout.replacen(shown, "", 1), steps.stdout);
    assert!(mm.stdout.contains(shown), "{mm:?}");
    // What is rounded is said, by every law and for programs too.
    for law in ["trapezoid", "s-curve --jerk 1e4", "austin", "power", "piecewise", "linear-factor"]
    {
        let ended = typed(&format!("plan {law} --steps 0.09mm {options}"));
        assert!(
            ended.stdout.contains("  distance          0.09mm ≈ 0 steps\n"),
            "{law}: {ended:?}"
        );
    }
    let ramp = "plan ramp --steps 0.39mm --ramp 9 --start-speed 9 --top-speed 100 --mm-per-rev 40";
    assert!(typed(ramp).stdout.contains("0.39mm ≈ 2 steps"), "{:?}", typed(ramp));
    let fixed = "plan austin-fixed --steps 0.39mm --c0 2000 --c-min 900 --mm-per-rev 40";
    assert!(typed(fixed).stdout.contains("0.39mm ≈ 2 steps"), "{:?}", typed(fixed));
    let json = typed(&format!("plan trapezoid --steps 0.39mm {options} --format json"));
    let json: Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(json["values"][0]["given"], "0.39mm");
    let error = "--steps 10mm: millimetres need the distance of one turn";
    refused("plan trapezoid --steps 10mm --accel 100 --top-speed 100", error, "--mm-per-rev");
    refused(
        "plan power --steps -10 --accel 100 --top-speed 100",
        "--steps -10: a travel has 0 to 2147483647 steps",
        "leave the minus out",
    );
}

#[test]
fn a_jerk_of_0_is_none() {
    let none = typed("move 100 --fast");
    assert_eq!(typed("move 100 --jerk 0 --fast").stdout, none.stdout);
    refused("move 100 --jerk 0 --law s-curve --fast", "--law s-curve needs a jerk", "--jerk");
    let hint = "stepwright plan trapezoid";
    refused("plan s-curve --steps 9 --accel 9 --top-speed 9 --jerk 0", "--jerk 0", hint);
}

#[test]
fn no_speed_is_told_in_steps() {
    let allowed = "must be 0.001 to 1,000,000 steps/s";
    refused("run 0 --for 1s --fast", &format!("the speed {allowed}, not 0"), "stepwright stop");
    refused("move 9 --top-speed 0 --fast", &format!("--top-speed {allowed}, not 0"), "");
    refused("move 9 --top-speed 0.0001 --fast", &format!("--top-speed {allowed}, not 0.0001"), "");
    refused("move 9 --top-speed 1e7 --fast", &format!("--top-speed {allowed}, not 1e7"), "unit");
}

#[test]
fn a_run_without_end_is_not_hurried() {
    refused("run 100 --fast", "--fast", "--for");
    refused("run 100 --fast --law austin", "--fast", "--for");
}

/// Each law at the top speed that the board can, where none is typed.
#[test]
fn every_law_moves_without_options() {
    for law in ["austin", "austin-fixed", "linear-factor", "power", "piecewise"] {
        let ended = typed(&format!("move 400 --law {law} --fast"));
        ended.assert(0, "position 400 ready");
        let ended = typed(&format!("run 100 --law {law} --for 2s --fast"));
        assert_eq!(ended.code(), Some(0), "{law}: {ended:#?}");
    }
    // What is typed is not lowered.
    let ended = typed("move 400 --law power --top-speed 1000 --fast");
    ended.assert_error("too slow for the law power at this top speed");
}

#[test]
fn a_driver_is_not_set_beyond_its_current() {
    let ended = typed("calc vref 3A");
    assert!(ended.stdout.contains("3 A is more than the 2.5 A of a DRV8825: take"), "{ended:#?}");
    assert!(!ended.stdout.contains("mA?"), "{ended:#?}");
    let ended = typed("calc vref 600");
    assert!(ended.stdout.contains("Then write 600mA"), "{ended:#?}");
}

/// Every number that is not whole, anywhere in a value.
fn fractions(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::Number(number) if number.is_f64() => found.push(number.to_string()),
        Value::Array(all) => all.iter().for_each(|one| fractions(one, found)),
        Value::Object(all) => all.values().for_each(|one| fractions(one, found)),
        _ => {}
    }
}

#[test]
fn numbers_for_programs_have_no_noise() {
    for line in [
        "line 10mm 20 --mm-per-rev 40 --fast",
        "line 10mm 20mm 30mm --mm-per-rev 40 --fast --accel 333.3",
        "move 333 --top-speed 333.3 --fast",
        "plan trapezoid --steps 10 --accel 100.1 --top-speed 33.3",
        "plan s-curve --steps 10 --accel 100.1 --top-speed 33.3 --jerk 1000",
        "plan austin --steps 10 --accel 100.1 --top-speed 33.3",
        "calc belt --teeth 20 --microsteps 3",
        "calc delay --period 200us",
        "timed --speed 10 --steps 20",
    ] {
        let ended = typed(&format!("{line} --format json"));
        let value = serde_json::from_str(&ended.stdout);
        let value: Value = value.unwrap_or_else(|error| panic!("{line}: {error} {ended:#?}"));
        let mut found = Vec::new();
        fractions(&value, &mut found);
        for number in found {
            let digits = number.split('e').next().unwrap().replace(['.', '-'], "");
            let digits = digits.trim_start_matches('0').trim_end_matches('0').len();
            assert!(digits <= 12, "{line}: {number}");
        }
    }
}

#[test]
fn a_line_of_mixed_units_says_what_each_number_is() {
    let ended = typed("line 10mm 20 --mm-per-rev 40 --fast");
    ended.assert(0, "position 50 20 ready");
    for row in ["  axis 1      10mm → 50 steps\n", "  axis 2      20 steps\n"] {
        assert!(ended.stdout.contains(row), "{ended:#?}");
    }
    assert!(!typed("line 50 20 --fast").stdout.contains("  axis 1"));
}

/// The hint is one for the command that was typed.
#[test]
fn a_hint_is_of_its_own_command() {
    let job = Scratch::new("typed-hint.nc");
    std::fs::write(job.path(), "G1 F600 X10\n").unwrap();
    let gcode = format!("gcode {} --plan", job.path());
    let hint = |line: &str| {
        let ended = typed(line);
        let hint = ended.stderr.lines().find_map(|said| said.strip_prefix(" hint: "));
        hint.unwrap_or_else(|| panic!("{line}: {ended:?}")).to_owned()
    };
    for (line, has, hasnt) in [
        (format!("{gcode} --start-speed 0"), "0.001 steps/s", "stepwright stop"),
        ("move 9 --top-speed 0 --fast".into(), "0 is no motion", "stepwright stop"),
        ("run 0 --for 1s --fast".into(), "stepwright stop", "--start-speed"),
        (format!("{gcode} --jerk 1e-10mm/s3"), "leave it out", "plan trapezoid"),
        ("move 9 --jerk 1e-9 --fast".into(), "leave it out", "plan trapezoid"),
        ("calc belt --teeth 10000 --speed 5mm/s".into(), "rev/s", "--mm-per-rev"),
    ] {
        let said = hint(&line);
        assert!(said.contains(has) && !said.contains(hasnt), "{line}: {said}");
    }
    for (line, error) in [
        ("--tolerance -1", "\"-1\" is no tolerance: 0 to 1000 mm"),
        ("--laser --laser-max -5", "\"-5\" is no S of full power"),
        ("--jerk -1", "give it without a sign"),
        ("--accel -1,2,3", "give it without a sign"),
    ] {
        let ended = typed(&format!("{gcode} {line}"));
        assert!(ended.code() == Some(2) && ended.stderr.contains(error), "{line}: {ended:?}");
    }
    let ended = typed("calc timed 6 -800 --updates 3");
    let error = "error: -800: give it without a sign";
    assert!(ended.code() == Some(2) && ended.stderr.contains(error), "{ended:?}");
}

/// What makes no sense for any board is an invalid command line.
#[test]
fn what_no_board_could_do_is_a_mistake_of_the_line() {
    let limits = "--steps 9 --accel 9";
    for law in ["trapezoid", "austin", "power", "piecewise", "linear-factor"] {
        let line = format!("plan {law} {limits} --top-speed 0");
        refused(&line, "--top-speed must be 0.001 to 1,000,000 steps/s, not 0", "no motion");
    }
    refused(
        "plan ramp --steps 9 --ramp 9 --start-speed 0 --top-speed 0",
        "--top-speed must be",
        "no motion",
    );
    refused(
        "plan compare trapezoid --steps 2000000 --accel 9 --top-speed 9",
        "2000000 steps are too many to compare",
        "1000000 or fewer",
    );
    let clkpr = typed("calc range --clkpr 3");
    let choices = "1, 2, 4, 8, 16, 32, 64, 128, 256";
    assert!(clkpr.code() == Some(2) && clkpr.stderr.contains(choices), "{clkpr:?}");
}

/// The serial line carries whole steps/s² and steps/s³. What is rounded is shown; less than 1 would be more than twice
/// as much.
#[test]
fn accelerations_and_jerks_below_1_are_refused_and_others_shown_as_sent() {
    let hint = "whole numbers";
    for text in ["0.4", "0.5", "0.999"] {
        let order = "--start-speed 0 --top-speed 5 --fast";
        let error = |name: &str, unit: &str| format!("{name} {text} is less than 1 {unit}");
        refused(&format!("move 20 --accel {text} {order}"), &error("--accel", "step/s²"), hint);
        refused(&format!("run 9 --for 1s --decel {text} --fast"), "--decel", hint);
        refused(&format!("home --accel {text} --fast"), &error("--accel", "step/s²"), hint);
        refused(&format!("move 20 --jerk {text} {order}"), &error("--jerk", "step/s³"), hint);
        let retarget = format!("retarget --accel {text} --port /nonexistent");
        refused(&retarget, &error("--accel", "step/s²"), hint);
    }
    refused("move 9 --jerk 5e9 --fast", "--jerk 5e9 is more than 4000000000 steps/s³", "");
    let ended = typed("move 20 --accel 1.5 --jerk 1.7 --top-speed 5 --fast --start-speed 0");
    for shown in ["ramp up     1.5 steps/s², sent as 2\n", "jerk        1.7 steps/s³, sent as 2\n"]
    {
        assert!(ended.stdout.contains(shown), "{shown}: {ended:#?}");
    }
}

/// Austin's laws begin at rest, and accelerate by steps/s².
#[test]
fn options_without_effect_on_a_law_are_refused() {
    for order in ["move 100", "run 100 --for 1s"] {
        for law in ["austin", "austin-fixed", "linear-factor", "power", "piecewise"] {
            let refused = |option: &str, laws: &str| {
                let error = format!("{option} is for --law {laws}");
                refused(&format!("{order} --law {law} --fast {option} 20"), &error, option);
            };
            refused("--start-speed", "trapezoid, s-curve");
            refused("--ramp", "trapezoid, s-curve");
            refused("--jerk", "s-curve");
        }
        typed(&format!("{order} --law trapezoid --start-speed 20 --ramp 9 --fast"));
    }
    let plan = "plan compare trapezoid austin --steps 9 --accel 9 --top-speed 9 --jerk 9";
    refused(plan, "--jerk is for s-curve", "leave --jerk out");
}

/// A negative number is a value: the answer says what is allowed, and shows what was typed.
#[test]
fn numbers_out_of_range_are_told_what_is_allowed() {
    for (line, said) in [
        ("move 9 --ramp -1", "'-1' for '--ramp <STEPS>': give a whole number from 1 to 999"),
        ("move 9 --ramp 1.5", "'1.5' for '--ramp <STEPS>': give a whole number from 1 to 999"),
        ("move 9 --mm-per-rev -8", "'-8' for '--mm-per-rev <MM>'"),
        ("move 9 --law linear-factor --knee -0.1", "'-0.1' for '--knee <PART>': it is 0 to 0.9"),
        ("move 9 --accel x", "like 4000 or 10rad/s2"),
        ("move 9 --jerk x", "like 400000 or 200rad/s3"),
        ("run 9 --for -1s", "invalid value '-1s' for '--for <TIME>'"),
        ("cycle x.toml --limit -1", "'-1' for '--limit <S>': give a whole number"),
        ("calc belt --teeth -4", "'-4' for '--teeth <N>': give a whole number from 1 to 10000"),
        ("timed --speed 9 --log -5", "'-5' for '--log <WHEN>'"),
        ("init --top-speed -5 --file /nonexistent", "-5"),
        ("timed --speed 9 --steps 9 --double", "<--faster <CLOCKS>|--slower <CLOCKS>>"),
        ("home --back-off 5000 --fast", "--back-off 5000 is not less than --within 2000"),
    ] {
        let ended = typed(line);
        assert!(ended.stderr.contains(said), "{line}: {ended:#?}");
        assert_eq!(ended.code(), Some(2), "{line}: {ended:#?}");
    }
}
