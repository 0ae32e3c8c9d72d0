//! Keys while a motor moves: faster, slower, stop.
//!
//! On a terminal each key is read as it is pressed; elsewhere there are none.
//! Ctrl-C stays what it is.

use std::io::{self, IsTerminal};

use stepwright_protocol::{Command, Order, Reply, Selection, TopSpeed};

use crate::talk::{Talk, Trouble};

/// What the keys are, for the user.
pub const HELP: &str = "keys: + faster, - slower, s stop";

/// A tenth of the top speed is a press.
const PART: u32 = 10;

/// What a key has come to.
pub enum Act {
    /// The motor is to be braked.
    Stop,
    /// This is to be told.
    Told(String),
}

/// A hand on a moving motor.
pub struct Hand {
    keys: Option<terminal::Keys>,
    /// The top speed of the travel in progress, and the lowest it can have, in
    /// steps/s.
    top: u32,
    least: u32,
}

impl Hand {
    /// Listens to the keys if there are any, for a motor that follows this
    /// order. A board that knows only the Nano slave's lines can't change its speed.
    pub fn on(talk: &Talk, order: &Order) -> Hand {
        let whole = |speed: stepwright::Speed| speed.millisteps() / 1000;
        let (top, start) = (whole(order.top), whole(order.start));
        let seen = io::stdin().is_terminal() && io::stderr().is_terminal();
        let keys = if seen && talk.info().is_some() { terminal::Keys::listen() } else { None };
        Hand { keys, top, least: start.min(top).max(1) }
    }

    /// No hand.
    #[cfg(test)]
    pub fn off() -> Hand {
        Hand { keys: None, top: 1, least: 1 }
    }

    /// Whether there are keys.
    pub fn listens(&self) -> bool {
        self.keys.is_some()
    }

    /// Does what the next key says.
    pub fn act(&mut self, talk: &mut Talk, axis: Selection) -> Result<Option<Act>, Trouble> {
        let Some(key) = self.keys.as_ref().and_then(terminal::Keys::next) else { return Ok(None) };
        let step = (self.top / PART).max(1);
        let top = match key {
            b'+' | b'=' => self.top.saturating_add(step).min(TopSpeed::LARGEST.get()),
            b'-' | b'_' => self.top.saturating_sub(step).max(self.least),
            b's' | b'S' | b' ' => return Ok(Some(Act::Stop)),
            _ => return Ok(Some(Act::Told(HELP.to_owned()))),
        };
        let command = Command::Top(TopSpeed::clamped(top));
        if talk.ask_of(axis, command)? == Reply::Yes {
            self.top = top;
            return Ok(Some(Act::Told(format!("top speed {top} steps/s"))));
        }
        Ok(Some(Act::Told(match talk.why()? {
            Some(why) => format!("the board refused {command}: {why}"),
            None => format!("the board refused {command}"),
        })))
    }
}

/// Gives the terminal back, whatever it was changed to.
pub fn restore() {
    terminal::restore();
}

#[cfg(unix)]
mod terminal {
    use std::io;
    use std::sync::Mutex;

    use rustix::process::getpgrp;
    use rustix::termios::{
        LocalModes, OptionalActions, SpecialCodeIndex, Termios, tcgetattr, tcgetpgrp, tcsetattr,
    };

    /// How the terminal was before.
    static BEFORE: Mutex<Option<Termios>> = Mutex::new(None);

    /// A terminal that gives keys.
    pub struct Keys(());

    /// Whether the terminal is ours: a command in the background that touched
    /// it would be stopped, and its motor left alone. One that rules no jobs is.
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
            // To read is not to wait.
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
mod terminal {
    /// There are none.
    pub struct Keys(());

    impl Keys {
        pub fn listen() -> Option<Keys> {
            None
        }

        pub fn next(&self) -> Option<u8> {
            None
        }
    }

    pub fn restore() {}
}
