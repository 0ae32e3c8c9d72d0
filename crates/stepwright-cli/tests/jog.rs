//! `stepwright jog` on a terminal: keys run a motor, and everything else stops it.
#![cfg(unix)]

use std::fs::File;
use std::io::{Read, Write};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::common::{self, LIMIT, Running, pty, stepwright};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, Signal, kill_process};
use rustix::termios::tcgetattr;

const RIGHT: &str = "\x1b[C";
const LEFT: &str = "\x1bOD";
const RIGHT_UP: &str = "\x1b[1;1:3C";

/// A jog on a terminal of its own.
struct Jog {
    child: Child,
    terminal: Option<File>,
    seen: Arc<Mutex<String>>,
    kept: File,
    modes: u32,
    reader: Option<JoinHandle<()>>,
    closed: Arc<AtomicBool>,
}

fn readable(file: &File) -> bool {
    let mut polled = [PollFd::new(file, PollFlags::IN)];
    let soon = Timespec { tv_sec: 0, tv_nsec: 5_000_000 };
    poll(&mut polled, Some(&soon)).is_ok_and(|count| count > 0)
}

impl Jog {
    fn start(options: &[&str]) -> Jog {
        let (terminal, path) = pty();
        let side = || Stdio::from(File::options().read(true).write(true).open(&path).unwrap());
        let kept = File::open(&path).unwrap();
        let modes = tcgetattr(&kept).unwrap().local_modes.bits();
        let child = Command::new(common::program())
            .arg("jog")
            .args(options)
            .env("TERM", "xterm")
            .stdin(side())
            .stderr(side())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let seen = Arc::new(Mutex::new(String::new()));
        let closed = Arc::new(AtomicBool::new(false));
        let (mut reads, writes) = (terminal.try_clone().unwrap(), seen.clone());
        let ends = closed.clone();
        let reader = thread::spawn(move || {
            let mut bytes = [0; 512];
            while !ends.load(Ordering::Relaxed) {
                if readable(&reads) {
                    let Ok(count @ 1..) = reads.read(&mut bytes) else { break };
                    writes.lock().unwrap().push_str(&String::from_utf8_lossy(&bytes[..count]));
                }
            }
        });
        let (terminal, reader) = (Some(terminal), Some(reader));
        let jog = Jog { child, terminal, seen, kept, modes, reader, closed };
        jog.wait_for("q end");
        jog
    }

    /// Closes the terminal, as a window is.
    fn close(&mut self) {
        self.closed.store(true, Ordering::Relaxed);
        self.reader.take().unwrap().join().unwrap();
        self.terminal = None;
    }

    fn seen(&self) -> String {
        self.seen.lock().unwrap().clone()
    }

    #[track_caller]
    fn wait_for(&self, part: &str) {
        let begin = Instant::now();
        while !self.seen().contains(part) {
            assert!(begin.elapsed() < LIMIT, "no {part:?} in {:?}", self.seen());
            thread::sleep(Duration::from_millis(5));
        }
    }

    fn press(&mut self, keys: &str) {
        self.terminal.as_mut().unwrap().write_all(keys.as_bytes()).unwrap();
    }

    /// A key that is held so long, as terminals say it.
    fn hold(&mut self, key: &str, time: Duration) {
        let begin = Instant::now();
        while begin.elapsed() < time {
            self.press(key);
            thread::sleep(Duration::from_millis(50));
        }
    }

    /// Where it was seen last.
    fn last_seen(&self) -> Option<(i64, String)> {
        let seen = self.seen();
        let last = seen.rsplit("position ").next()?;
        let mut words = last.split(|c: char| c != '-' && !c.is_ascii_alphanumeric());
        Some((words.next()?.parse().ok()?, words.next()?.to_owned()))
    }

    #[track_caller]
    fn wait_until(&self, what: &str, right: impl Fn(i64, &str) -> bool) -> i64 {
        let begin = Instant::now();
        loop {
            if let Some((at, word)) = self.last_seen()
                && right(at, &word)
            {
                return at;
            }
            assert!(begin.elapsed() < LIMIT, "never {what}: {:?}", self.seen());
            thread::sleep(Duration::from_millis(5));
        }
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    /// Its status and what it says last; the terminal is as it was before.
    #[track_caller]
    fn end(&mut self) -> (ExitStatus, String) {
        let begin = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            assert!(begin.elapsed() < LIMIT, "it does not end: {:?}", self.seen());
            thread::sleep(Duration::from_millis(5));
        };
        if self.terminal.is_some() && status.code().is_some() {
            assert_eq!(tcgetattr(&self.kept).unwrap().local_modes.bits(), self.modes);
        }
        let mut out = String::new();
        self.child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        (status, out.lines().last().unwrap_or_default().to_owned())
    }
}

impl Drop for Jog {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn at(line: &str) -> i64 {
    let at = line.strip_prefix("position ").and_then(|line| line.strip_suffix(" ready"));
    at.and_then(|at| at.parse().ok()).unwrap_or_else(|| panic!("{line}"))
}

/// A virtual board that other programs reach.
fn board() -> (Running, String) {
    let mut board = Running::start(&["board", "--pty"]);
    let path = board.wait_out("pty ").replace("pty ", "");
    (board, path)
}

#[test]
fn a_held_key_runs_and_the_other_one_runs_back() {
    let mut jog = Jog::start(&["--top-speed", "2000", "--accel", "20000"]);
    jog.hold(RIGHT, Duration::from_millis(1500));
    let far = jog.wait_until("at rest", |at, word| at > 0 && word == "ready");
    // 1.5 s and up to 0.25 s more, at 2000 steps/s; a loaded machine may be late.
    assert!(far > 1500, "{far}");
    jog.hold(LEFT, Duration::from_millis(300));
    let near = jog.wait_until("back", |at, word| at < far && word == "ready");
    jog.press("q");
    let (status, last) = jog.end();
    assert_eq!((status.code(), at(&last)), (Some(0), near), "{:?}", jog.seen());
}

#[test]
fn a_key_that_comes_up_brakes_at_once() {
    let mut jog = Jog::start(&["--accel", "100000", "--top-speed", "100", "--start-speed", "100"]);
    jog.press(RIGHT);
    jog.wait_until("on its way", |_, word| word == "busy");
    let begin = Instant::now();
    jog.press(RIGHT_UP);
    jog.wait_until("at rest", |at, word| at > 0 && word == "ready");
    let took = begin.elapsed();
    // Without a word of it a single press runs for 0.7 s.
    assert!(took < Duration::from_millis(600), "{took:?}");
    jog.press("q");
    assert_eq!(jog.end().0.code(), Some(0));
}

#[test]
fn steps_speeds_and_zero() {
    let mut jog = Jog::start(&["--step", "7", "--format", "json"]);
    jog.press("...");
    jog.wait_until("three steps", |at, word| at == 21 && word == "ready");
    jog.press(",");
    jog.wait_until("one back", |at, word| at == 14 && word == "ready");
    for (key, said) in [("+", "top speed 1100"), ("-", "top speed 990"), ("0", "this place is 0")] {
        jog.press(key);
        jog.wait_for(said);
    }
    jog.wait_until("the new 0", |at, word| at == 0 && word == "ready");
    jog.press(".");
    jog.wait_until("from the new 0", |at, word| at == 7 && word == "ready");
    jog.press("q");
    let (status, last) = jog.end();
    let json = r#"{"axis":1,"board":"the virtual board","position":7,"state":"ready"}"#;
    assert_eq!((status.code(), &last[..]), (Some(0), json));
}

/// Space, while the key stays down.
#[test]
fn space_stops_until_the_key_is_pressed_again() {
    let mut jog = Jog::start(&["--accel", "100000"]);
    jog.hold(RIGHT, Duration::from_millis(300));
    jog.press(" ");
    jog.hold(RIGHT, Duration::from_millis(600));
    let rest = jog.wait_until("at rest", |at, word| at > 0 && word == "ready");
    jog.hold(RIGHT, Duration::from_millis(300));
    thread::sleep(Duration::from_millis(800));
    assert_eq!(jog.last_seen(), Some((rest, "ready".to_owned())));
    jog.press(RIGHT);
    jog.wait_until("running again", |at, _| at > rest);
    jog.press("q");
    assert_eq!(jog.end().0.code(), Some(0));
}

/// Ctrl-C brakes and ends, whatever is held.
#[test]
fn ctrl_c_brakes() {
    let mut jog = Jog::start(&[]);
    jog.press(RIGHT);
    jog.wait_until("on its way", |at, _| at > 10);
    jog.signal(Signal::INT);
    let (status, last) = jog.end();
    assert!(status.code() == Some(0) && at(&last) > 10, "{status} {last}");
    assert!(jog.seen().contains("braking; Ctrl-C again kills"), "{:?}", jog.seen());
}

#[test]
fn a_second_ctrl_c_kills() {
    let slow = ["--top-speed", "2000", "--accel", "20000", "--decel", "200"];
    let mut jog = Jog::start(&slow);
    jog.press(RIGHT);
    jog.wait_until("fast", |at, _| at > 200);
    jog.signal(Signal::INT);
    jog.wait_for("braking");
    jog.signal(Signal::INT);
    let (status, last) = jog.end();
    assert_eq!((status.code(), &last[..]), (Some(130), "position uncertain"));
}

/// Nobody is left to let the key go: the board brakes by the lease.
#[test]
fn a_killed_jog_is_braked_by_the_board() {
    let (_board, path) = board();
    let mut jog = Jog::start(&["--port", &path]);
    jog.press(RIGHT);
    jog.wait_until("on its way", |at, _| at > 10);
    jog.signal(Signal::KILL);
    jog.end();
    // A question would be a word from here. The lease is 0.5 s, the way down 0.4 s.
    thread::sleep(Duration::from_secs(3));
    let ended = stepwright(&["position", "--port", &path]);
    assert!((10..5000).contains(&at(ended.last_line())), "{ended:?}");
    let why = stepwright(&["status", "--port", &path]);
    assert!(why.stdout.contains("stopped by"), "{why:?}");
}

#[test]
fn a_closed_terminal_brakes_and_ends() {
    let (_board, path) = board();
    let mut jog = Jog::start(&["--port", &path, "--lease", "60s"]);
    jog.press(RIGHT);
    jog.wait_until("on its way", |at, _| at > 10);
    // It is not the terminal that rules this process: no signal comes.
    jog.close();
    jog.end();
    let rest = stepwright(&["position", "--port", &path]);
    assert!(at(rest.last_line()) > 10, "{rest:?}");
}

#[test]
fn without_a_terminal_there_are_no_keys() {
    let ended = stepwright(&["jog"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("a jog needs a terminal");
    assert!(ended.stderr.contains("run ±SPEED --for TIME"), "{ended:?}");
    for (wrong, why) in [(["--step", "0"], "1 step or more"), (["--step", "-3"], "1 step or more")]
    {
        let ended = stepwright(&[&["jog"], &wrong[..]].concat());
        assert_eq!(ended.code(), Some(2), "{ended:?}");
        ended.assert_error(why);
    }
}

/// What is said last is where the axis is, counted from the new 0.
#[test]
fn the_place_that_was_called_0_is_said_last() {
    let mut jog = Jog::start(&["--step", "7"]);
    jog.press(".");
    jog.wait_until("a step", |at, word| at == 7 && word == "ready");
    jog.press("0");
    jog.wait_for("this place is 0");
    jog.press("q");
    let (status, last) = jog.end();
    assert_eq!((status.code(), &last[..]), (Some(0), "position 0 ready"));
}
