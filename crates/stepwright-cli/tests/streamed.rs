//! `gcode FILE --port` on `board --pty --program stream`: the same way as on a real board.
#![cfg(unix)]

use std::process::{Command, Output, Stdio};
use std::time::Duration;

use crate::common::{PtyBoard, program};

fn stepwright() -> Command {
    Command::new(program())
}

/// A job for a board.
fn gcode(board: &PtyBoard, job: &std::path::Path) -> Command {
    let mut command = stepwright();
    command.arg("gcode").arg(job).args(["--port", &board.1]);
    command
}

fn job(text: &str) -> tempfile::NamedTempFile {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), text).unwrap();
    file
}

fn said(output: &Output) -> (String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr))
}

#[test]
fn a_job_is_streamed_to_its_exact_end() {
    let board = PtyBoard::new(&["--program", "stream"]);
    let file = job("G1 F6000 X20 Y10\nG4 P0.3\nG2 X0 Y0 I-10 J-5\nG0 Z1\n");
    let plan = stepwright().arg("gcode").arg(file.path()).args(["--fast"]).output().unwrap();
    let (wanted, _) = said(&plan);
    let (out, err) = said(&gcode(&board, file.path()).output().unwrap());
    let last = |text: &str| text.lines().last().unwrap_or_default().to_owned();
    assert_eq!(last(&out), last(&wanted), "{out}{err}");
    assert!(out.contains("late steps  0"), "{out}{err}");
}

/// How a job, and the command that ends it from another terminal, end.
fn ended_by(word: &str) -> [Output; 2] {
    let board = PtyBoard::new(&["--program", "stream"]);
    let file = job("G1 F1200 X200\n");
    let mut command = gcode(&board, file.path());
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(1_500));
    let other = stepwright().args([word, "--port", &board.1]).output().unwrap();
    [child.wait_with_output().unwrap(), other]
}

/// Another program says its line, and asks for what came of it, while the job does.
#[test]
fn a_stop_from_another_terminal_says_where_it_rests() {
    let [output, stop] = ended_by("stop");
    let ((out, err), (told, trouble)) = (said(&output), said(&stop));
    assert_eq!(output.status.code(), Some(1), "{out}{err}");
    assert_eq!(stop.status.code(), Some(0), "{told}{trouble}");
    let first = told.lines().next().and_then(|line| line.strip_prefix("axis 1 position "));
    let place = first.and_then(|rest| rest.strip_suffix(" ready"));
    let place = place.unwrap_or_else(|| panic!("{told}{trouble}"));
    assert!(place.parse::<i64>().unwrap() > 0 && told.lines().count() == 3, "{told}");
    assert!(err.contains(&format!(", at {place} 0 0\n")), "{told}{err}");
    assert!(err.contains("the positions are known"), "{err}");
}

#[test]
fn places_that_a_kill_has_lost_are_not_called_known() {
    let [output, kill] = ended_by("kill");
    let ((out, err), (told, trouble)) = (said(&output), said(&kill));
    assert!(told.starts_with("axis 1 position uncertain\naxis 2 position 0 "), "{told}{trouble}");
    assert_eq!(output.status.code(), Some(1), "{out}{err}");
    assert!(err.contains("has stopped, off the path, at ? 0 0\n"), "{err}");
    assert!(!err.contains("known"), "{err}");
}

#[test]
fn a_signal_brakes_along_the_path() {
    let board = PtyBoard::new(&["--program", "stream"]);
    let file = job("G1 F1200 X200 Y100\n");
    let mut command = gcode(&board, file.path());
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(2_500));
    let pid = nix::unistd::Pid::from_raw(child.id() as i32);
    nix::sys::signal::kill(pid, nix::sys::signal::Signal::SIGTERM).unwrap();
    let output = child.wait_with_output().unwrap();
    let (out, err) = said(&output);
    assert_eq!(output.status.code(), Some(130), "{out}{err}");
    // On the line: Y makes half the steps of X, to half a step.
    let last = out.lines().last().unwrap_or_default();
    let numbers: Vec<i64> = last.split(' ').filter_map(|word| word.parse().ok()).collect();
    assert!(last.ends_with("stopped") && numbers[0] > 100, "{out}{err}");
    assert!((numbers[0] - 2 * numbers[1]).abs() <= 2, "{out}{err}");
}

/// A second Ctrl-C kills, and says so only if the board does.
#[test]
fn a_second_signal_kills_and_says_what_is_known() {
    use nix::sys::signal::{Signal, kill};
    let pid = |child: &std::process::Child| nix::unistd::Pid::from_raw(child.id() as i32);
    for silent in [false, true] {
        let board = PtyBoard::new(&["--program", "stream"]);
        let file = job("G1 F3000 X200 Y100\n");
        let mut command = gcode(&board, file.path());
        // It brakes for a second: the kill finds it on its way.
        command.args(["--accel", "50"]);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(1_500));
        if silent {
            kill(pid(&board.0.child), Signal::SIGSTOP).unwrap();
        }
        for _ in 0..2 {
            kill(pid(&child), Signal::SIGINT).unwrap();
            std::thread::sleep(Duration::from_millis(10));
        }
        let output = child.wait_with_output().unwrap();
        let (out, err) = said(&output);
        assert_eq!(output.status.code(), Some(130), "{out}{err}");
        if silent {
            assert!(err.contains("did not confirm K") && err.contains("power"), "{err}");
            kill(pid(&board.0.child), Signal::SIGCONT).unwrap();
            continue;
        }
        assert!(err.contains("killed: the positions"), "{err}");
        let places = stepwright().args(["stop", "--port", &board.1]).output().unwrap();
        let (out, err) = said(&places);
        assert!(out.starts_with("axis 1 position uncertain"), "{out}{err}");
    }
}

#[test]
fn another_program_is_refused_with_the_remedy() {
    let board = PtyBoard::new(&[]);
    let file = job("G1 F600 X1\n");
    let output = gcode(&board, file.path()).output().unwrap();
    let (out, err) = said(&output);
    assert_eq!(output.status.code(), Some(1), "{out}{err}");
    assert!(err.contains("stepwright flash uno --program stream"), "{out}{err}");
}
