//! What a terminal shows of a moving motor: it fits, and it is right after a change, too.
#![cfg(unix)]

use std::fs::File;
use std::io::{Read, Write};
use std::process::{Command, Stdio};

use crate::common::{self, pty};
use rustix::termios::{Winsize, tcsetwinsize};

/// All that a terminal of this many columns shows of a command, with these keys pressed when
/// it shows the words before them.
fn shown(term: &str, columns: u16, args: &[&str], keys: &[(&str, &str)]) -> String {
    let (mut terminal, path) = pty();
    let size = Winsize { ws_row: 24, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
    tcsetwinsize(&terminal, size).unwrap();
    let side = || Stdio::from(File::options().read(true).write(true).open(&path).unwrap());
    let mut child = Command::new(common::program())
        .args(args)
        .env("TERM", term)
        .stdin(side())
        .stderr(side())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let (mut seen, mut keys) = (String::new(), keys.iter().peekable());
    let mut bytes = [0; 4096];
    while let Ok(count @ 1..) = terminal.read(&mut bytes) {
        seen.push_str(&String::from_utf8_lossy(&bytes[..count]));
        if let Some((_, key)) = keys.next_if(|(words, _)| seen.contains(words)) {
            terminal.write_all(key.as_bytes()).unwrap();
        }
    }
    child.wait().unwrap();
    seen
}

/// The states of the line that renews itself, without the sequences around them.
fn states(seen: &str) -> Vec<String> {
    let mut plain = String::new();
    let mut chars = seen.chars();
    while let Some(c) = chars.next() {
        if c == '\x1b' {
            // CSI: up to its letter.
            let _ = chars.find(|c| c.is_ascii_alphabetic());
            plain.push('\n');
        } else {
            plain.push(c);
        }
    }
    plain.split(['\r', '\n']).map(|line| line.trim_end().to_owned()).collect()
}

#[test]
fn it_fits_in_twenty_columns() {
    let args = ["move", "-1500", "--accel", "10000"];
    let seen = states(&shown("xterm", 20, &args, &[]));
    let lines: Vec<_> = seen.iter().filter(|line| line.contains("/s")).collect();
    assert!(lines.len() > 5, "{seen:?}");
    for line in &lines {
        assert!(line.chars().count() < 20, "{line:?}");
        assert!(line.starts_with('-') || line.starts_with('0'), "{line:?}");
    }
    assert!(lines.iter().any(|line| line.contains("1000/s")), "{lines:?}");
    // Wider ones show more.
    let wide = states(&shown("xterm", 80, &args, &[]));
    let whole = wide.iter().find(|line| line.contains('━') && line.contains(" s left"));
    assert!(whole.is_some_and(|line| line.contains("position -")), "{wide:?}");
}

#[test]
fn a_dumb_terminal_gets_plain_lines() {
    let seen = shown("dumb", 80, &["move", "2500", "--accel", "10000"], &[]);
    assert!(!seen.contains('\x1b'), "{seen:?}");
    let lines: Vec<_> = seen.lines().filter(|line| line.starts_with("position ")).collect();
    assert!((1..5).contains(&lines.len()), "{seen:?}");
    assert!(lines.iter().all(|line| line.ends_with(" s left")), "{lines:?}");
}

/// A key that a terminal sends as several bytes is one key.
#[test]
fn an_arrow_has_no_function_in_a_move() {
    let keys = [("s left", "\x1b[C")];
    let seen = shown("xterm", 80, &["move", "1000", "--accel", "10000"], &keys);
    assert_eq!(seen.matches("keys: + faster").count(), 2, "{seen:?}");
}

/// Seconds left, before and after the speed is changed by keys.
#[test]
fn after_a_change_the_time_left_is_that_of_the_new_motion() {
    let args = ["move", "3000", "--accel", "10000"];
    let slower = "-".repeat(5);
    let seen = shown("xterm", 80, &args, &[("1000 steps/s", &slower)]);
    let lines = states(&seen);
    let left = |line: &str| -> Option<f64> {
        let (_, left) = line.strip_suffix(" s left")?.rsplit_once("steps/s  ")?;
        left.parse().ok()
    };
    let at = |line: &str| -> Option<f64> {
        line.split("position ").nth(1)?.split(' ').next()?.parse().ok()
    };
    let mut after = 0;
    for line in &lines {
        let (Some(left), Some(at)) = (left(line), at(line)) else { continue };
        if !(500.0..2800.0).contains(&at) {
            continue;
        }
        // 1000, and in the end 590 steps/s (each press takes a tenth).
        let least = (3000.0 - at) / 1000.0;
        assert!((least - 0.1..least * 1.8 + 0.2).contains(&left), "{line}");
        after += usize::from(left > least * 1.5);
    }
    assert!(after > 5, "{lines:?}");
}
