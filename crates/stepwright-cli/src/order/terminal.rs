//! Reads each key of a terminal as it is pressed. Ctrl-C keeps its function.

use std::io::{self, IsTerminal};

#[cfg(unix)]
pub use unix::{Keys, restore};

#[cfg(windows)]
pub use console::{Keys, restore};

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

#[cfg(windows)]
mod console {
    use std::cell::RefCell;
    use std::collections::VecDeque;
    use std::mem;

    use windows_sys::Win32::System::Console::{
        GetStdHandle, INPUT_RECORD, KEY_EVENT, KEY_EVENT_RECORD, PeekConsoleInputW,
        ReadConsoleInputW, STD_INPUT_HANDLE,
    };

    /// A console, whose keys are given as the bytes of a terminal that reports releases.
    pub struct Keys(RefCell<VecDeque<u8>>);

    impl Keys {
        pub fn listen() -> Option<Keys> {
            event(false).map(|_| Keys(RefCell::default()))
        }

        pub fn next(&self) -> Option<u8> {
            let mut bytes = self.0.borrow_mut();
            // Reading waits for an event; looking does not.
            while bytes.is_empty() && event(false)?.is_some() {
                bytes.extend(typed(&event(true)??));
            }
            bytes.pop_front()
        }

        /// Whether the console was closed.
        pub fn are_gone(&self) -> bool {
            event(false).is_none()
        }
    }

    /// A console's events are read one by one, without a change of its modes.
    pub fn restore() {}

    /// The next event if there is one, which stays there unless it is taken. `None` if standard input is no console.
    fn event(take: bool) -> Option<Option<INPUT_RECORD>> {
        // SAFETY: has no requirements. A missing handle is refused below.
        let input = unsafe { GetStdHandle(STD_INPUT_HANDLE) };
        // SAFETY: a structure of integers.
        let (mut record, mut count) = (unsafe { mem::zeroed() }, 0);
        let look = if take { ReadConsoleInputW } else { PeekConsoleInputW };
        // SAFETY: writes at most one record, and the count; refuses a handle of another kind.
        let seen = unsafe { look(input, &mut record, 1, &mut count) };
        (seen != 0).then_some((count == 1).then_some(record))
    }

    /// The bytes for an event: a character, or the sequence of an arrow.
    fn typed(record: &INPUT_RECORD) -> Vec<u8> {
        if u32::from(record.EventType) != KEY_EVENT {
            return Vec::new();
        }
        // SAFETY: the type is that of this event.
        let KEY_EVENT_RECORD { bKeyDown, wVirtualKeyCode, uChar, .. } =
            unsafe { record.Event.KeyEvent };
        // SAFETY: both variants are integers, of which this is the wider one.
        let unit = unsafe { uChar.UnicodeChar };
        let is_down = bKeyDown != 0;
        // VK_LEFT to VK_DOWN.
        let arrow = match wVirtualKeyCode {
            0x25 => b'D',
            0x26 => b'A',
            0x27 => b'C',
            0x28 => b'B',
            _ => {
                let sign = char::from_u32(unit.into()).filter(|sign| is_down && *sign != '\0');
                return sign.map(String::from).unwrap_or_default().into_bytes();
            }
        };
        [if is_down { &b"\x1b["[..] } else { b"\x1b[1;1:3" }, &[arrow]].concat()
    }
}
