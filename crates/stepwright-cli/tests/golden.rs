//! Conversations with the command, held to the letter.
//!
//! A file in `golden/` is a list of command lines, each with what it answers:
//!
//! ```text
//! $ stepwright plan trapezoid --steps 3 …
//! what stands on standard output
//! ! what stands on standard error
//! ? 1                                   the exit status, unless it is 0
//! ```
//!
//! After a change that is meant, `STEPWRIGHT_GOLDEN=write cargo test -p
//! stepwright-cli --test golden` writes them again; read the diff.

mod common;

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// What the command answers to one line, in the form of the files.
fn answer(line: &str) -> String {
    let words = line.split_whitespace().skip(1);
    let output = Command::new(common::program())
        .args(words)
        .env_remove("CLICOLOR_FORCE")
        .output()
        .expect("the command runs");
    let mut text = String::from_utf8(output.stdout).expect("UTF-8");
    // How far a long plan is says only a machine that takes more than a second for it.
    let is_progress = |line: &&str| line.contains(" % of ") && line.ends_with(" steps");
    let complaint = String::from_utf8(output.stderr).expect("UTF-8");
    for line in complaint.lines().filter(|line| !is_progress(line)) {
        writeln!(text, "! {line}").unwrap();
    }
    match output.status.code() {
        Some(0) => {}
        Some(code) => writeln!(text, "? {code}").unwrap(),
        None => text.push_str("? a signal\n"),
    }
    // A line end of its own for editors, not for comparing.
    text.lines().fold(String::new(), |all, line| all + line.trim_end() + "\n")
}

#[test]
fn conversations() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let write = std::env::var("STEPWRIGHT_GOLDEN").is_ok_and(|v| v == "write");
    let mut files: Vec<_> = folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty());
    for file in files {
        let golden = std::fs::read_to_string(&file).unwrap();
        let lines = golden.lines().filter(|line| line.starts_with("$ "));
        let now: Vec<_> = lines.map(|line| format!("{line}\n{}", answer(&line[2..]))).collect();
        let now = now.join("\n");
        if write {
            std::fs::write(&file, &now).unwrap();
        } else {
            assert!(golden == now, "{} differs; it would now be:\n\n{now}", file.display());
        }
    }
}
