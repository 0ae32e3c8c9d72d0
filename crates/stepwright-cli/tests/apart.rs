//! A file that a command line names twice: nothing is written over it.

use std::fs;

use crate::common::{Ended, Scratch, stepwright};

const JOB: &str = "G1 X1 F600\n";

const CYCLES: &str = "[[motor]]\nname = \"X\"\nstep = 1\nsmallest-delay-us = 100\n\
    [[cycle]]\nline = { to = { X = 5 }, speed = 100, accel = 1_000 }\n";

#[track_caller]
fn refused(ended: &Ended, options: &str) {
    assert_eq!((ended.code(), ended.stdout.as_str()), (Some(2), ""), "{ended:?}");
    let begin = format!("error: {options} are the same file: ");
    assert!(ended.stderr.starts_with(&begin), "{ended:?}");
    assert!(ended.stderr.contains("\n hint: give "), "{ended:?}");
}

#[test]
fn what_is_read_is_not_written_over() {
    let file = Scratch::new("job.nc");
    fs::write(file.path(), JOB).unwrap();
    // The same file by another path.
    let folder = file.0.parent().unwrap().to_str().unwrap();
    let around = format!("{folder}/./{}", file.0.file_name().unwrap().to_str().unwrap());
    for option in ["--vcd", "--mcap"] {
        let ended = stepwright(&["gcode", file.path(), "--fast", option, &around]);
        refused(&ended, &format!("FILE and {option}"));
        assert_eq!(fs::read_to_string(file.path()).unwrap(), JOB);
    }
    fs::write(file.path(), CYCLES).unwrap();
    refused(&stepwright(&["cycle", file.path(), "--vcd", file.path()]), "FILE and --vcd");
    assert_eq!(fs::read_to_string(file.path()).unwrap(), CYCLES);
}

#[test]
fn two_outputs_are_two_files() {
    let file = Scratch::new("edges.vcd");
    let both = ["--fast", "--vcd", file.path(), "--mcap", file.path()];
    refused(&stepwright(&[&["move", "10"][..], &both].concat()), "--vcd and --mcap");
    assert!(!file.0.exists());
    let (cycles, drawn) = (Scratch::new("two.toml"), Scratch::new("two.svg"));
    fs::write(cycles.path(), CYCLES).unwrap();
    let words = ["cycle", cycles.path(), "--plot", drawn.path(), "--xy", drawn.path()];
    refused(&stepwright(&words), "--plot and --xy");
    assert!(!drawn.0.exists());
}

#[test]
fn the_machine_file_is_not_written_over() {
    let file = Scratch::new("machine.toml");
    fs::write(file.path(), "").unwrap();
    let words = ["--machine", file.path(), "move", "10", "--fast", "--vcd", file.path()];
    refused(&stepwright(&words), "--machine and --vcd");
    assert_eq!(fs::read_to_string(file.path()).unwrap(), "");
}

/// Nothing is kept there, so there is nothing to lose.
#[cfg(unix)]
#[test]
fn a_device_may_be_named_twice() {
    let words = ["move", "10", "--fast", "--vcd", "/dev/null", "--mcap", "/dev/null"];
    let ended = stepwright(&words);
    assert!(!ended.stderr.contains("same file"), "{ended:?}");
}
