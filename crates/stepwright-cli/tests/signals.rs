//! Signals: whatever would end the command brakes its motor along the ramp first, and
//! gives the terminal back. Only a second Ctrl-C kills.
#![cfg(target_os = "linux")]

mod common;

use std::fs::File;
use std::io::Read;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::{LIMIT, Running, pty, stepwright};
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
            .args(["--ctty", "env", env, env!("CARGO_BIN_EXE_stepwright")])
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
        let ended = stepwright(&["position", "--port", &self.port]);
        let at = ended.last_line().strip_prefix("position ").unwrap().strip_suffix(" ready");
        let at: i64 = at.unwrap_or_else(|| panic!("{ended:?} {}", self.seen)).parse().unwrap();
        // 2000²/2/1000 steps is its way down.
        assert!((2_000..100_000).contains(&at), "{at}");
    }
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
