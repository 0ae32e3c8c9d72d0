//! The built command, run as a user would: with time limits, so that a test
//! fails rather than hangs, and nothing left running.
#![allow(dead_code, reason = "each test uses what it needs")]

use std::ffi::OsString;
use std::io::{BufReader, Read, Write};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

/// Longer than anything here takes, even on a loaded machine.
pub const LIMIT: Duration = Duration::from_secs(60);

/// The command under test: the one that `STEPWRIGHT_COMMAND` names, as `cargo xtask test` does
/// with the release binary, or else the one that was built with this test.
pub fn program() -> OsString {
    std::env::var_os("STEPWRIGHT_COMMAND")
        .unwrap_or_else(|| env!("CARGO_BIN_EXE_stepwright").into())
}

/// A running command. Its output is read all the time, so that it never waits
/// for its reader; it is killed when this is dropped.
pub struct Running {
    pub child: Child,
    /// Lines on standard output and standard error as they come.
    out: Receiver<String>,
    err: Receiver<String>,
    said: String,
    complained: String,
}

/// How a command ended.
#[derive(Debug)]
pub struct Ended {
    pub status: ExitStatus,
    pub stdout: String,
    pub stderr: String,
}

impl Ended {
    pub fn code(&self) -> Option<i32> {
        self.status.code()
    }

    pub fn last_line(&self) -> &str {
        self.stdout.lines().last().unwrap_or("")
    }

    /// Fails with all there is to know, unless it ended so.
    #[track_caller]
    pub fn assert(&self, code: i32, last_line: &str) {
        assert_eq!((self.code(), self.last_line()), (Some(code), last_line), "{self:#?}");
    }

    /// Fails unless it complained so, in the house's form.
    #[track_caller]
    pub fn assert_error(&self, part: &str) {
        let error = self.stderr.lines().find(|line| line.starts_with("error: "));
        assert!(error.is_some_and(|error| error.contains(part)), "{part}: {self:#?}");
    }
}

/// Lines as they come, each with its end: LF, or CR as the protocol has it.
fn lines(from: impl Read + Send + 'static) -> Receiver<String> {
    let (tell, hear) = mpsc::channel();
    thread::spawn(move || {
        let mut line = Vec::new();
        for byte in BufReader::new(from).bytes().map_while(Result::ok) {
            line.push(byte);
            if matches!(byte, b'\n' | b'\r') {
                let text = String::from_utf8_lossy(&line).into_owned();
                let _ = tell.send(text);
                line.clear();
            }
        }
        let _ = tell.send(String::from_utf8_lossy(&line).into_owned());
    });
    hear
}

impl Running {
    pub fn start<S: AsRef<str>>(args: &[S]) -> Running {
        let mut command = Command::new(program());
        Running::of(command.args(args.iter().map(AsRef::as_ref)))
    }

    /// Another program than the command.
    pub fn of(command: &mut Command) -> Running {
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let out = lines(child.stdout.take().unwrap());
        let err = lines(child.stderr.take().unwrap());
        Running { child, out, err, said: String::new(), complained: String::new() }
    }

    /// Waits for a line on standard output that begins so.
    #[track_caller]
    pub fn wait_out(&mut self, begin: &str) -> String {
        let line = wait_line(&self.out, begin, &mut self.said);
        line.unwrap_or_else(|| panic!("no {begin:?} on stdout: {:?}", self.said))
    }

    /// Waits for a line on standard error that begins so.
    #[track_caller]
    pub fn wait_err(&mut self, begin: &str) -> String {
        let line = wait_line(&self.err, begin, &mut self.complained);
        line.unwrap_or_else(|| panic!("no {begin:?} on stderr: {:?}", self.complained))
    }

    /// Sends a signal: INT is Ctrl-C.
    #[cfg(unix)]
    pub fn signal(&self, signal: rustix::process::Signal) {
        let pid = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(pid, signal).expect("it takes the signal");
    }

    /// Waits for the end.
    #[track_caller]
    pub fn end(mut self) -> Ended {
        drop(self.child.stdin.take());
        let begin = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            assert!(begin.elapsed() < LIMIT, "it does not end: {} {}", self.said, self.complained);
            thread::sleep(Duration::from_millis(5));
        };
        let mut stdout = std::mem::take(&mut self.said);
        let mut stderr = std::mem::take(&mut self.complained);
        stdout.extend(self.out.iter());
        stderr.extend(self.err.iter());
        Ended { status, stdout, stderr }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn wait_line(lines: &Receiver<String>, begin: &str, all: &mut String) -> Option<String> {
    let end = Instant::now() + LIMIT;
    loop {
        let line = lines.recv_timeout(end.saturating_duration_since(Instant::now())).ok()?;
        all.push_str(&line);
        if line.starts_with(begin) {
            return Some(line.trim_end().to_owned());
        }
    }
}

/// A virtual board, and the path that it is on, until this is dropped.
pub struct PtyBoard(pub Running, pub String);

impl PtyBoard {
    /// With these options.
    #[track_caller]
    pub fn new(options: &[&str]) -> PtyBoard {
        let mut board = Running::start(&[&["board", "--pty"], options].concat());
        let path = board.wait_out("pty ").strip_prefix("pty ").unwrap().to_owned();
        PtyBoard(board, path)
    }
}

/// Runs the command with this input to its end.
#[track_caller]
pub fn stepwright_with<S: AsRef<str>>(args: &[S], input: &[u8]) -> Ended {
    let mut running = Running::start(args);
    let mut stdin = running.child.stdin.take().unwrap();
    let input = input.to_vec();
    // On a thread of its own: the command may not read all of it.
    let writer = thread::spawn(move || drop(stdin.write_all(&input)));
    let ended = running.end();
    writer.join().unwrap();
    ended
}

/// Runs the command to its end.
#[track_caller]
pub fn stepwright<S: AsRef<str>>(args: &[S]) -> Ended {
    Running::start(args).end()
}

/// A file of its own for each test, away with it at the end.
pub struct Scratch(pub std::path::PathBuf);

impl Scratch {
    pub fn new(name: &str) -> Scratch {
        let dir = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        Scratch(dir.join(format!("{}-{count}-{name}", std::process::id())))
    }

    pub fn path(&self) -> &str {
        self.0.to_str().unwrap()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// A pseudo-terminal of our own: the end to hold, and the path of the other.
#[cfg(unix)]
pub fn pty() -> (std::fs::File, String) {
    use rustix::io::{FdFlags, fcntl_setfd};
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    // Ours alone: who starts meanwhile would keep the terminal open.
    fcntl_setfd(&master, FdFlags::CLOEXEC).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let path = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
    (master.into(), path)
}
