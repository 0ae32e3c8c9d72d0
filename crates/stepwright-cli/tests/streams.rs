//! Standard output that can't be written: a full disk is a failure, a reader that has
//! seen enough is none.
#![cfg(target_os = "linux")]

use std::fs::File;
use std::io::Read;
use std::process::{Command, Stdio};

use crate::common::{self, stepwright};

const ANSWERS: [&[&str]; 8] = [
    &["--help"],
    &["move", "--help"],
    &["--version"],
    &["move", "40", "--fast"],
    &[
        "plan",
        "trapezoid",
        "--steps",
        "20000",
        "--accel",
        "4000",
        "--top-speed",
        "2000",
        "--format",
        "csv",
    ],
    &["calc", "timer", "10rpm"],
    &["figures", "8", "--format", "csv"],
    &["completions", "bash"],
];

fn command(args: &[&str], out: impl Into<Stdio>) -> Command {
    let mut command = Command::new(common::program());
    command.args(args).stdin(Stdio::null()).stdout(out).stderr(Stdio::piped());
    command
}

#[test]
fn a_full_disk_is_a_failure() {
    for args in ANSWERS {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let ended = command(args, full).output().unwrap();
        let said = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(ended.status.code(), Some(1), "{args:?}: {said}");
        let error = "error: can't write to standard output: No space left";
        assert_eq!(said.matches(error).count(), 1, "{args:?}: {said}");
    }
}

#[test]
fn a_reader_may_leave() {
    for args in ANSWERS {
        let mut child = command(args, Stdio::piped()).spawn().unwrap();
        // The first byte and no more.
        child.stdout.take().unwrap().read_exact(&mut [0]).unwrap();
        let ended = child.wait_with_output().unwrap();
        let said = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(
            (ended.status.code(), said.contains("error")),
            (Some(0), false),
            "{args:?} {said}"
        );
    }
}

/// What is not text is refused as an argument, and is a name as good as any of a file.
#[test]
fn arguments_need_not_be_text() {
    use std::os::unix::ffi::OsStrExt;
    let odd = std::ffi::OsStr::from_bytes(b"\xff\xfe");
    let end = |words: &[&str]| command(words, Stdio::null()).arg(odd).output().unwrap();
    assert_eq!(end(&["move"]).status.code(), Some(2));
    for words in [&["cycle"][..], &["status", "--port"]] {
        let ended = end(words);
        let said = String::from_utf8(ended.stderr).unwrap();
        assert!(ended.status.code() == Some(1) && said.starts_with("error: "), "{said}");
    }
    assert_eq!(stepwright(&["move", ""]).code(), Some(2));
}
