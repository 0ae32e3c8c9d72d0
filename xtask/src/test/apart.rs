//! Runs a step in a separate process.
//!
//! Its output is passed on as it comes, and the last lines are kept: a CI shows only the end of a
//! long log, and a failed step must give its reason there.

use std::collections::VecDeque;
use std::env;
use std::io::{BufRead, BufReader, pipe};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result};

/// The number of lines that are kept.
const KEPT: usize = 60;
/// After this time without output, checks whether the program has ended.
const QUIET: Duration = Duration::from_secs(1);

/// The result of a program.
pub struct Said {
    /// Whether it succeeded.
    pub passed: bool,
    /// The last lines of its stdout and stderr, in their order.
    pub last: Vec<String>,
}

/// The path of this program. To be called before the first step: a step that rebuilds it replaces
/// the file.
pub fn program() -> Result<PathBuf> {
    env::current_exe().context("where this program is")
}

/// A command that runs one step.
pub fn step(program: &Path, name: &str) -> Command {
    let mut command = Command::new(program);
    command.args(["test", "--only", name]);
    command
}

/// Runs a program to its end and passes on its output, with `before` before each line. Does not
/// wait for processes that it leaves running, though they hold its outputs open.
///
/// # Errors
/// It can't be started.
pub fn tell(mut command: Command, before: &str) -> Result<Said> {
    let (reader, writer) = pipe()?;
    command.stdin(Stdio::null()).stdout(writer.try_clone()?).stderr(writer);
    let mut child = command.spawn().context("starting a step")?;
    // The command holds copies of the pipe's write end, which would keep the pipe open.
    drop(command);
    let (lines, heard) = channel();
    thread::spawn(move || {
        for line in BufReader::new(reader).split(b'\n').map_while(Result::ok) {
            if lines.send(line).is_err() {
                return;
            }
        }
    });
    let mut last = VecDeque::with_capacity(KEPT);
    loop {
        match heard.recv_timeout(QUIET) {
            Ok(line) => {
                let line = String::from_utf8_lossy(&line).into_owned();
                println!("{before}{line}");
                if last.len() == KEPT {
                    last.pop_front();
                }
                last.push_back(line);
            }
            Err(RecvTimeoutError::Timeout) if child.try_wait()?.is_none() => {}
            Err(_) => break,
        }
    }
    Ok(Said { passed: child.wait()?.success(), last: last.into() })
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;

    fn shell(script: &str) -> Said {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        tell(command, "").unwrap()
    }

    #[test]
    fn the_last_lines_of_both_outputs_are_kept_in_their_order() {
        let said = shell("for k in $(seq 100); do echo $k; echo -$k >&2; done; exit 3");
        assert!(!said.passed);
        assert_eq!(said.last.len(), KEPT);
        assert_eq!(said.last[KEPT - 2..], ["100", "-100"]);
        assert_eq!(said.last[0], "71");
    }

    #[test]
    fn a_last_line_needs_no_end() {
        let said = shell("printf 'no end'");
        assert!(said.passed);
        assert_eq!(said.last, ["no end"]);
    }

    #[test]
    fn what_is_left_behind_is_not_waited_for() {
        let begun = Instant::now();
        let said = shell("sleep 20 & echo ended; exit 0");
        assert!(said.passed);
        assert_eq!(said.last, ["ended"]);
        assert!(begun.elapsed() < Duration::from_secs(10));
    }
}
