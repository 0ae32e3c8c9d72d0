//! Signals: whatever would end the command brakes its motor along the ramp first, and
//! gives the terminal back. Only a second Ctrl-C kills.
#![cfg(target_os = "linux")]

use std::fs::File;
use std::io::Read;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{self, LIMIT, Running, pty, stepwright};
use rustix::process::{Pid, Signal, kill_process};
use rustix::termios::{Termios, tcgetattr};

/// A virtual board that stays, and a motor of it that moves by our command on a terminal
/// of its own.
struct Moving {
    _board: Running,
    port: String,
    /// Our end, until it is closed.
    terminal: Option<File>,
    kept: File,
    before: Termios,
    child: Child,
    seen: String,
}

/// From 2000 steps/s it brakes in two seconds: time for more signals.
const ORDER: [&str; 8] =
    ["move", "1000000", "--top-speed", "2000", "--accel", "20000", "--decel", "1000"];

impl Moving {
    /// `env` gives the signals back that whoever runs this test has ignored; `setsid`
    /// makes the terminal the one that rules the command.
    fn start(env: &str, order: &[&str]) -> Moving {
        let mut board = Running::start(&["board", "--pty"]);
        let port = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
        let (terminal, path) = pty();
        let side = || Stdio::from(File::options().read(true).write(true).open(&path).unwrap());
        let kept = File::open(&path).unwrap();
        let before = tcgetattr(&kept).unwrap();
        let child = Command::new("setsid")
            .args(["--ctty", "env", env])
            .arg(common::program())
            .args(order)
            .args(["--port", &port])
            .stdin(side())
            .stdout(side())
            .stderr(side())
            .spawn()
            .unwrap();
        let (terminal, seen) = (Some(terminal), String::new());
        Moving { _board: board, port, terminal, kept, before, child, seen }
    }

    fn at_speed() -> Moving {
        let mut moving = Moving::start("--default-signal", &ORDER);
        // It holds the terminal, and is fast after a tenth of a second.
        moving.wait_for("keys: + faster");
        thread::sleep(Duration::from_millis(300));
        assert_ne!(modes(&tcgetattr(&moving.kept).unwrap()), modes(&moving.before));
        moving
    }

    #[track_caller]
    fn wait_for(&mut self, part: &str) {
        let begin = Instant::now();
        while !self.seen.contains(part) {
            self.look();
            assert!(begin.elapsed() < LIMIT, "no {part:?} in {}", self.seen);
        }
    }

    /// Reads what it has said, or waits a little.
    fn look(&mut self) {
        match &mut self.terminal {
            Some(terminal) if readable(terminal) => {
                let mut bytes = [0; 512];
                let count = terminal.read(&mut bytes).unwrap_or(0);
                self.seen.push_str(&String::from_utf8_lossy(&bytes[..count]));
            }
            _ => thread::sleep(Duration::from_millis(5)),
        }
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    /// How it ended, and what it said on the way.
    #[track_caller]
    fn end(&mut self) -> ExitStatus {
        let begin = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status;
            }
            assert!(begin.elapsed() < LIMIT, "it does not end: {}", self.seen);
            self.look();
        }
    }

    /// That the motor was braked: it rests, its position is known, and it is not where it
    /// would be without a ramp.
    #[track_caller]
    fn assert_braked(&self) {
        assert_ramped(&stepwright(&["position", "--port", &self.port]));
    }
}

/// That this ended with the motor at rest behind its ramp.
#[track_caller]
fn assert_ramped(ended: &common::Ended) {
    let at = ended.last_line().strip_prefix("position ");
    let at = at.and_then(|at| at.strip_suffix(" ready")?.parse::<i64>().ok());
    // 2000²/2/1000 steps is its way down.
    assert!(at.is_some_and(|at| (2_000..100_000).contains(&at)), "{ended:?}");
}

impl Drop for Moving {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn readable(file: &File) -> bool {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let mut polled = [PollFd::new(file, PollFlags::IN)];
    let soon = Timespec { tv_sec: 0, tv_nsec: 5_000_000 };
    poll(&mut polled, Some(&soon)).is_ok_and(|count| count > 0)
}

fn modes(terminal: &Termios) -> (u32, [u8; 2]) {
    use rustix::termios::SpecialCodeIndex as Code;
    let codes = [Code::VMIN, Code::VTIME].map(|code| terminal.special_codes[code]);
    (terminal.local_modes.bits(), codes)
}

/// Whatever comes, and comes again, but for a second Ctrl-C.
#[test]
fn signals_brake_along_the_ramp_and_give_the_terminal_back() {
    let cases = [
        [Signal::HUP, Signal::HUP, Signal::HUP],
        [Signal::TERM, Signal::TERM, Signal::INT],
        [Signal::INT, Signal::TERM, Signal::HUP],
        [Signal::QUIT, Signal::QUIT, Signal::TERM],
        [Signal::USR1, Signal::USR2, Signal::USR1],
        [Signal::ALARM, Signal::VTALARM, Signal::PROF],
        [Signal::TSTP, Signal::CONT, Signal::TSTP],
        [Signal::IO, Signal::POWER, Signal::XCPU],
        [Signal::ABORT, Signal::ABORT, Signal::SYS],
        [Signal::SYS, Signal::TRAP, Signal::ABORT],
        [Signal::TRAP, Signal::SYS, Signal::TRAP],
    ];
    // All at once: each brakes for two seconds.
    thread::scope(|scope| {
        for signals in cases {
            scope.spawn(move || brakes_at(signals));
        }
    });
}

fn brakes_at(signals: [Signal; 3]) {
    let mut moving = Moving::at_speed();
    moving.signal(signals[0]);
    moving.wait_for("braking");
    signals[1..].iter().for_each(|signal| moving.signal(*signal));
    let status = moving.end();
    assert_eq!(status.code(), Some(130), "{signals:?} {status}: {}", moving.seen);
    moving.assert_braked();
    let after = tcgetattr(&moving.kept).unwrap();
    assert_eq!(modes(&after), modes(&moving.before), "{signals:?}");
    moving.wait_for(" stopped");
}

/// TERM is no Ctrl-C: after it the first Ctrl-C kills nothing, the second does.
#[test]
fn only_a_second_ctrl_c_kills() {
    let mut moving = Moving::at_speed();
    moving.signal(Signal::TERM);
    moving.wait_for("braking; Ctrl-C twice kills");
    moving.signal(Signal::INT);
    thread::sleep(Duration::from_millis(200));
    assert!(moving.child.try_wait().unwrap().is_none(), "{}", moving.seen);
    moving.signal(Signal::INT);
    let status = moving.end();
    assert_eq!(status.code(), Some(130), "{}", moving.seen);
    moving.wait_for("position uncertain");
}

/// The kernel's own HUP, and a terminal that takes no line any more.
#[test]
fn a_closed_terminal_brakes() {
    let mut moving = Moving::at_speed();
    moving.terminal = None;
    let status = moving.end();
    assert_eq!(status.code(), Some(130), "{status}");
    moving.assert_braked();
}

/// Nobody is left who could brake it, but `nohup` says that this is meant.
#[test]
fn without_a_hangup_a_closed_terminal_ends_nothing() {
    let mut moving = Moving::start("--ignore-signal=HUP", &["move", "3000", "--accel", "20000"]);
    moving.wait_for("keys: + faster");
    moving.terminal = None;
    // What it has to say is lost with the terminal.
    assert_eq!(moving.end().code(), Some(1));
    stepwright(&["position", "--port", &moving.port]).assert(0, "position 3000 ready");
}

/// STOP can't be caught. The board goes on, and the command finds where it is.
#[test]
fn a_stopped_command_goes_on_where_the_motor_is() {
    let mut moving = Moving::start("--default-signal", &["move", "2000", "--accel", "20000"]);
    moving.wait_for("keys: + faster");
    moving.signal(Signal::STOP);
    thread::sleep(Duration::from_millis(1500));
    moving.signal(Signal::CONT);
    assert_eq!(moving.end().code(), Some(0), "{}", moving.seen);
    moving.wait_for("position 2000 ready");
}

/// What a terminal sends to a command in the background suspends none, so its motor stays
/// watched and a later signal brakes it.
#[test]
fn a_terminal_suspends_no_command() {
    for signal in [Signal::TTIN, Signal::TTOU, Signal::TSTP] {
        // In a group of its own whose parent is in another: one without is never suspended.
        let mut command = Command::new(common::program());
        let mut moving = Running::of(command.args(ORDER).process_group(0));
        moving.wait_err("position ");
        moving.signal(signal);
        thread::sleep(Duration::from_millis(300));
        moving.signal(Signal::TERM);
        let ended = moving.end();
        assert_eq!(ended.code(), Some(130), "{signal:?}: {ended:?}");
        assert!(ended.last_line().ends_with(" stopped"), "{signal:?}: {ended:?}");
    }
}

/// `timeout` makes its command one of the background, and this terminal stops what writes from
/// there.
#[test]
fn a_stop_in_the_background_says_its_result() {
    let mut moving = Moving::at_speed();
    let (mut terminal, path) = pty();
    let side = || Stdio::from(File::options().read(true).write(true).open(&path).unwrap());
    let stop = format!(
        "stty tostop; timeout 20 '{}' stop --port {}; echo status $?",
        common::program().display(),
        moving.port
    );
    let child = Command::new("setsid")
        .args(["--ctty", "env", "--default-signal", "sh", "-c", &stop])
        .stdin(side())
        .stdout(side())
        .stderr(side())
        .spawn()
        .unwrap();
    let mut shell = Ended(child);
    let (begin, mut said) = (Instant::now(), String::new());
    while !said.contains("status ") {
        if readable(&terminal) {
            let mut bytes = [0; 512];
            let count = terminal.read(&mut bytes).unwrap_or(0);
            said.push_str(&String::from_utf8_lossy(&bytes[..count]));
        }
        assert!(begin.elapsed() < LIMIT, "it hangs: {said}");
    }
    assert!(said.contains(" ready") && said.contains("status 0"), "{said}");
    shell.0.wait().unwrap();
    moving.end();
    moving.assert_braked();
}

/// A process that is not left running, however the test ends.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Whoever holds the port may be suspended, and gives it back to nobody: a stop sees for itself
/// that the motor rests.
#[test]
fn a_stop_does_not_wait_for_a_suspended_holder() {
    let moving = Moving::at_speed();
    moving.signal(Signal::STOP);
    let ended = stepwright(&["stop", "--axis", "1", "--port", &moving.port]);
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    assert_ramped(&ended);
    let ended = stepwright(&["kill", "--port", &moving.port]);
    assert_eq!(ended.code(), Some(0), "{ended:?}");
}

/// A stop and a watch end by the first signal: what was said is said, and nothing more is done.
#[test]
fn a_signal_ends_a_stop_and_a_watch() {
    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
    let order = ["move", "100000", "--accel", "20000", "--decel", "10", "--detach"];
    let moved = stepwright(&[&order[..], &["--port", &port]].concat());
    assert_eq!(moved.code(), Some(0), "{moved:?}");
    // From 1000 steps/s it would brake for 100 s.
    for (order, said) in [("watch", "nothing was stopped"), ("stop", "told to brake")] {
        let running = Running::start(&[order, "--port", &port]);
        thread::sleep(Duration::from_millis(1500));
        running.signal(Signal::TERM);
        let ended = running.end();
        assert_eq!(ended.code(), Some(130), "{ended:?}");
        ended.assert_error(said);
    }
    let ended = stepwright(&["position", "--port", &port]);
    assert!(ended.last_line().ends_with(" busy"), "it brakes, and was not killed: {ended:?}");
}
