//! Reads each key of a terminal as it is pressed. Ctrl-C keeps its function.

use std::io::{self, IsTerminal};

#[cfg(unix)]
pub use unix::{Keys, restore};

#[cfg(not(unix))]
pub use elsewhere::{Keys, restore};

/// Whether a person uses the command: standard input and standard error are a terminal.
pub fn is_there() -> bool {
    io::stdin().is_terminal() && io::stderr().is_terminal()
}

/// Whether standard error is a terminal that can update a line in place.
pub fn has_sequences() -> bool {
    let plain = |name: &std::ffi::OsStr| name.is_empty() || name == "dumb";
    let named = std::env::var_os("TERM").is_some_and(|name| !plain(&name));
    (named || cfg!(windows)) && io::stderr().is_terminal()
}

#[cfg(unix)]
mod unix {
    use std::io;
    use std::sync::Mutex;

    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    use rustix::process::getpgrp;
    use rustix::termios::{
        LocalModes, OptionalActions, SpecialCodeIndex, Termios, tcgetattr, tcgetpgrp, tcsetattr,
    };

    /// The terminal's modes before.
    static BEFORE: Mutex<Option<Termios>> = Mutex::new(None);

    /// A terminal that gives keys.
    pub struct Keys(());

    /// Whether this process is in the terminal's foreground. A background command that changes the
    /// terminal would be suspended, without control of its motor. True if the terminal has no job
    /// control.
    fn is_ours() -> bool {
        tcgetpgrp(io::stdin()).map_or(true, |group| group == getpgrp())
    }

    impl Keys {
        pub fn listen() -> Option<Keys> {
            if !is_ours() {
                return None;
            }
            let before = tcgetattr(io::stdin()).ok()?;
            let mut keys = before.clone();
            keys.local_modes.remove(LocalModes::ICANON | LocalModes::ECHO);
            // Reads do not block.
            keys.special_codes[SpecialCodeIndex::VMIN] = 0;
            keys.special_codes[SpecialCodeIndex::VTIME] = 0;
            *BEFORE.lock().ok()? = Some(before);
            tcsetattr(io::stdin(), OptionalActions::Now, &keys).ok()?;
            Some(Keys(()))
        }

        pub fn next(&self) -> Option<u8> {
            let mut key = [0];
            let count = if is_ours() { rustix::io::read(io::stdin(), &mut key).ok()? } else { 0 };
            (count == 1).then_some(key[0])
        }

        /// Whether the terminal was closed.
        pub fn are_gone(&self) -> bool {
            let stdin = io::stdin();
            let mut polled = [PollFd::new(&stdin, PollFlags::empty())];
            let now = Timespec { tv_sec: 0, tv_nsec: 0 };
            poll(&mut polled, Some(&now)).is_ok_and(|count| count > 0)
        }
    }

    impl Drop for Keys {
        fn drop(&mut self) {
            restore();
        }
    }

    pub fn restore() {
        let Ok(mut before) = BEFORE.lock() else { return };
        if let Some(before) = before.take()
            && is_ours()
        {
            let _ = tcsetattr(io::stdin(), OptionalActions::Now, &before);
        }
    }
}

#[cfg(not(unix))]
mod elsewhere {
    /// There are no keys.
    pub struct Keys(());

    impl Keys {
        pub fn listen() -> Option<Keys> {
            None
        }

        pub fn next(&self) -> Option<u8> {
            None
        }

        pub fn are_gone(&self) -> bool {
            false
        }
    }

    pub fn restore() {}
}
