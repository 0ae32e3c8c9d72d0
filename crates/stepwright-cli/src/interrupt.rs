//! Ctrl-C, and every other request to end: a moving motor brakes before the command ends.
//!
//! | signal | effect |
//! | --- | --- |
//! | INT (Ctrl-C), once | an orderly end: the motor brakes along its ramp |
//! | INT, twice | a hard end: the motor is killed |
//! | HUP (a terminal is closed), TERM, QUIT, ABRT, USR1, ALRM and all others that end a process | an orderly end, however often they come |
//! | TSTP (Ctrl-Z) | while a motor is held: an orderly end, too; a process that is stopped could not brake it |
//! | TTIN, TTOU | nothing: a terminal suspends no command that is in its background |
//! | STOP | the process stops; the board goes on with its order, and so does the command when it is continued |
//!
//! On Windows a closed window, Ctrl-Break, a logoff and a shutdown end the command like HUP. Windows waits
//! some seconds; then the process ends, and a board that was told to brake goes on braking.
//!
//! Under `nohup` a closed terminal ends nothing. Signals for a fault in the process itself, after
//! which it could not continue (SEGV, BUS, ILL, FPE), are left alone.

use std::process;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use stepwright_host::{Activity, Interrupt, LinkError};

use crate::failure::Failure;
use crate::order::terminal;

static PRESSES: AtomicUsize = AtomicUsize::new(0);
static ASKED: AtomicBool = AtomicBool::new(false);

/// The exit status after Ctrl-C, as in shells: 128 + SIGINT.
pub const STATUS: u8 = 130;

/// After this many Ctrl-C the line is considered stuck, and the process ends at once.
const ENOUGH: usize = 4;

/// The activity of a command while it listens for signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum While {
    /// It controls a moving motor.
    Holding,
    /// Nothing urgent: Ctrl-Z suspends it.
    Waiting,
}

/// Prevents a terminal from suspending this process, even in the background: its motor would run on
/// without control, and no stop could be sent. To be called before there are threads.
pub fn stay_awake() {
    #[cfg(unix)]
    signals::stay_awake();
}

/// Begins to listen for signals. From now on no signal ends the process before an orderly end.
pub fn listen(meanwhile: While) -> Result<(), Failure> {
    signals::listen(meanwhile)
        .map_err(|error| Failure::new(format!("can't listen for signals: {error}")))
}

/// The effect of a request to end on a session that waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// The first Ctrl-C brakes, which the caller does; the second kills.
    ByBraking,
    /// The first Ctrl-C kills; any other signal ends the waiting. For sessions in which neither can
    /// brake.
    ByKilling,
}

/// An interrupt that ends the waiting of a session at the user's request.
pub fn guard(ends: Ends) -> Option<Interrupt> {
    Some(Box::new(move |waiting| {
        let most = if ends == Ends::ByBraking { 2 } else { 1 };
        match (ends, waiting) {
            _ if presses() >= most => Some(LinkError::Killed),
            (Ends::ByKilling, _) if asked() => Some(LinkError::Ended),
            // This command has moved nothing yet, so the first request is enough.
            (Ends::ByBraking, Activity::Meeting) if asked() => Some(LinkError::Killed),
            _ => None,
        }
    }))
}

/// Whether an orderly end was requested.
pub fn asked() -> bool {
    ASKED.load(Ordering::Acquire)
}

/// How often Ctrl-C was pressed.
pub fn presses() -> usize {
    PRESSES.load(Ordering::Relaxed)
}

/// The message to the user while a motor brakes.
pub fn braking() -> &'static str {
    match (asked(), presses()) {
        (false, _) => "braking",
        (true, 0) => "braking; Ctrl-C twice kills",
        _ => "braking; Ctrl-C again kills",
    }
}

/// Records a signal; `press` if it is Ctrl-C.
fn come(press: bool) {
    let presses = if press { PRESSES.fetch_add(1, Ordering::Relaxed) + 1 } else { 0 };
    // Stored after the count of presses, so that a reader that sees the request also sees the
    // count.
    ASKED.store(true, Ordering::Release);
    if presses >= ENOUGH {
        terminal::restore();
        process::exit(STATUS.into());
    }
}

#[cfg(unix)]
mod signals {
    use std::thread;
    use std::{fs, io};

    use nix::sys::signal::{SigSet, Signal};
    use signal_hook::consts::signal::*;
    use signal_hook::iterator::Signals;

    use super::While;

    /// All signals that end a process by default, except KILL, which can't be caught, and those of
    /// a fault in the process. (SIGPIPE is not among them: writing to a closed pipe is an error.)
    const ENDING: [i32; 14] = [
        SIGHUP, SIGINT, SIGQUIT, SIGALRM, SIGTERM, SIGUSR1, SIGUSR2, SIGPROF, SIGVTALRM, SIGXCPU,
        SIGXFSZ, SIGABRT, SIGSYS, SIGTRAP,
    ];

    /// Blocks the signals instead of catching them: with a handler, a write to the terminal would
    /// be retried for ever.
    pub fn stay_awake() {
        // If this fails, the signals keep their default effect.
        let _ = SigSet::from_iter([Signal::SIGTTIN, Signal::SIGTTOU]).thread_block();
    }

    /// Further signals of Linux: IO, power failure, coprocessor fault, and those that are free for
    /// any use.
    fn others() -> Vec<i32> {
        if !cfg!(target_os = "linux") {
            return Vec::new();
        }
        use rustix::process::Signal;
        let named = [Signal::IO, Signal::POWER, Signal::STKFLT];
        named.iter().map(|signal| signal.as_raw()).chain(34..=64).collect()
    }

    pub fn listen(meanwhile: While) -> io::Result<()> {
        let mut heard = [&ENDING[..], &others()].concat();
        if meanwhile == While::Holding {
            heard.push(SIGTSTP);
        }
        if without_terminal() {
            heard.retain(|signal| *signal != SIGHUP);
        }
        let mut signals = Signals::new(heard)?;
        thread::spawn(move || signals.forever().for_each(|signal| super::come(signal == SIGINT)));
        Ok(())
    }

    /// Whether HUP is ignored, as under `nohup`. Only Linux reports this.
    fn without_terminal() -> bool {
        let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
        let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        let ignored = ignored.and_then(|set| u64::from_str_radix(set.trim(), 16).ok());
        ignored.unwrap_or(0) >> (SIGHUP - 1) & 1 != 0
    }
}

#[cfg(windows)]
mod signals {
    use std::{io, thread};

    use windows_sys::Win32::System::Console::{
        CTRL_BREAK_EVENT, CTRL_C_EVENT, SetConsoleCtrlHandler,
    };
    use windows_sys::core::BOOL;

    use super::While;

    pub fn listen(_: While) -> io::Result<()> {
        // SAFETY: a static function, which Windows calls on a thread of its own.
        match unsafe { SetConsoleCtrlHandler(Some(handle), 1) } {
            0 => Err(io::Error::last_os_error()),
            _ => Ok(()),
        }
    }

    extern "system" fn handle(event: u32) -> BOOL {
        super::come(event == CTRL_C_EVENT);
        // After all other events Windows ends the process when this returns, or after some seconds.
        while ![CTRL_C_EVENT, CTRL_BREAK_EVENT].contains(&event) {
            thread::park();
        }
        1
    }
}
