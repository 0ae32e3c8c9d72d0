//! `stepwright selftest`: what it says of a line, and what it refuses.

use std::io::Write;
use std::process::{Command, Stdio};

use crate::common::{program, stepwright};
use stepwright_selftest::{Chip, Crc32, Found, Line, ORDERS, plan};

/// What the simulated chips have said (`cargo xtask test --only pico --only qemu`).
const PICO: &str = "stepwright-selftest format=1 chip=rp2040 firmware=0.1.0-992c4408 hz=125000000 \
                    orders=16 plan=ce8e8cc6 steps=2097 edges=2097 off=32 late=0 khz=125000 \
                    crc=14292c8e";
const MICROBIT: &str = "stepwright-selftest format=1 chip=nrf51 firmware=0.1.0-5c82f708 hz=16000000 \
                        orders=16 plan=31942da3 steps=2097 edges=2097 off=659 late=0 khz=- \
                        crc=285d3358";

/// A line as its chip would say it today, with what its planner plans now, and something else found.
fn today(said: &str, change: impl FnOnce(&mut Line<'_>)) -> String {
    let mut line = Line::read(said).unwrap();
    let chip = Chip::named(line.chip).unwrap();
    let (mut sum, mut steps) = (Crc32::new(), 0);
    (0..ORDERS).for_each(|number| assert!(plan(chip, number, &mut sum, |_| steps += 1)));
    assert_eq!(steps, line.found.steps);
    line.found.plan = sum.end();
    change(&mut line);
    let mut text = Vec::new();
    line.tell(|byte| text.push(byte));
    String::from_utf8(text).unwrap()
}

/// The line of the Pico, likewise.
fn found(change: impl FnOnce(&mut Line<'_>)) -> String {
    today(PICO, change)
}

#[test]
fn a_line_of_a_chip_that_does_as_it_should_passes() {
    let pico = found(|_| {});
    let ended = stepwright(&["selftest", &pico]);
    ended.assert(0, "passed");
    assert!(
        ended.stdout.contains("worst edge  0.256 µs from its time; 1.016 µs are allowed"),
        "{ended:?}"
    );
    assert!(ended.stdout.contains("edges       2097 of 2097"), "{ended:?}");
    // Unquoted, as a shell hands it over.
    let micro_bit = today(MICROBIT, |_| {});
    let words: Vec<_> = ["selftest"].into_iter().chain(micro_bit.split(' ')).collect();
    let ended = stepwright(&words);
    ended.assert(0, "passed");
    assert!(ended.stdout.contains("not measured"), "{ended:?}");
    let json = stepwright(&["selftest", &pico, "--format", "json"]);
    assert_eq!(json.code(), Some(0));
    let said: serde_json::Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(said["passed"], true);
    let planned = format!("{:08x}", Line::read(&pico).unwrap().found.plan);
    assert_eq!((&said["plan"], &said["off_us"]), (&planned.into(), &0.256.into()));
}

#[test]
fn the_first_whole_line_on_standard_input_is_judged() {
    let mut command = Command::new(program());
    let mut child =
        command.arg("selftest").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    // Who opens a port hears the end of a line first.
    let pico = found(|_| {});
    let half = &pico[50..];
    let mut input = child.stdin.take().unwrap();
    write!(input, "{half}\r\n{pico}\r\n{half}").unwrap();
    drop(input);
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stdout.ends_with(b"passed\n"), "{output:?}");
}

#[test]
fn what_is_wrong_is_said_in_plain_words() {
    let refused = |line: &str, error: &str, hint: &str| {
        let ended = stepwright(&["selftest", line]);
        assert_eq!(ended.code(), Some(1), "{ended:?}");
        ended.assert_error(error);
        assert!(ended.stderr.contains(hint), "{ended:?}");
        assert!(!ended.stdout.contains("passed"), "{ended:?}");
    };
    refused(&PICO.replace("late=0", "late=1"), "the line was changed on its way", "whole line");
    refused(&PICO[..PICO.find(" edges").unwrap()], "has no word `edges=`", "whole line");
    refused("hello", "this is no line of a self-test", "stepwright-selftest");
    refused(&PICO.replace("format=1", "format=9"), "reads form 1", "newer stepwright");
    let line = found(|line| line.found.plan ^= 1);
    refused(&line, "it planned something else than this command:", "same release");
    let line = found(|line| line.found.off = 128);
    refused(&line, "an edge came 1.024 µs from its time, and 1.016 µs are allowed", "try again");
    let line = found(|line| line.found.late = 2);
    refused(&line, "2 steps were late", "send the line");
    let line = found(|line| line.found.edges -= 1);
    refused(&line, "2096 edges were captured on STEP, and 2097 were planned", "STEP pins");
    let line = found(|line| line.khz = Some(120_000));
    refused(&line, "its clock is 120000 kHz", "crystal");
    let line = found(|line| line.chip = "rp2350");
    refused(&line, "no chip rp2350 is known", "rp2040, nrf51, stm32f411");
    // All of it, and for programs.
    let line = found(|line| line.found = Found { late: 1, orders: ORDERS - 1, ..line.found });
    let ended = stepwright(&["selftest", &line, "--format", "json"]);
    assert_eq!(ended.code(), Some(1));
    let said: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(said["passed"], false);
    assert_eq!(said["faults"], serde_json::json!(["it took 15 of 16 orders", "1 step was late"]));
    assert!(
        ended.stderr.contains(r#""error":"the self-test was not passed: it took 15"#),
        "{ended:?}"
    );
}
