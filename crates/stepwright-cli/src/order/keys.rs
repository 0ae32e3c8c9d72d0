//! Keys while a motor moves: faster, slower, stop.
//!
//! On a terminal each key is read as it is pressed; elsewhere there are none.
//! Ctrl-C stays what it is.

use stepwright_protocol::{Command, MilliSpeed, Order, Reply, Selection};

use super::terminal::{self, Keys};
use crate::session::{LinkError, Session};

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
    /// This line has changed the motion, and the rest is to be told.
    Changed(Command, String),
}

/// A hand on a moving motor.
pub struct KeyControl {
    keys: Option<Keys>,
    /// The top speed of the travel in progress, and the lowest it can have, in
    /// 0.001 steps/s.
    top: u32,
    least: u32,
}

impl KeyControl {
    /// Listens to the keys if there are any, for a motor that follows this
    /// order. A board that knows only the Nano slave's lines can't change its speed.
    pub fn on(session: &Session, order: &Order) -> KeyControl {
        let (top, start) = (order.top.millisteps(), order.start.millisteps());
        let able = terminal::is_there() && session.info().is_some();
        let keys = if able { Keys::listen() } else { None };
        KeyControl { keys, top, least: start.min(top).max(1) }
    }

    /// No hand.
    #[cfg(test)]
    pub fn off() -> KeyControl {
        KeyControl { keys: None, top: 1, least: 1 }
    }

    /// Whether there are keys.
    pub fn listens(&self) -> bool {
        self.keys.is_some()
    }

    /// Does what the next key says.
    pub fn act(
        &mut self,
        session: &mut Session,
        axis: Selection,
    ) -> Result<Option<Act>, LinkError> {
        match self.keys.as_ref().and_then(Keys::next) {
            Some(key) => self.press(key, session, axis).map(Some),
            None => Ok(None),
        }
    }

    /// Does what this key says.
    fn press(&mut self, key: u8, session: &mut Session, axis: Selection) -> Result<Act, LinkError> {
        let step = part(self.top);
        let top = match key {
            b'+' | b'=' => self.top.saturating_add(step).min(MilliSpeed::LARGEST.get()),
            b'-' | b'_' => self.top.saturating_sub(step).max(self.least),
            b's' | b'S' | b' ' => return Ok(Act::Stop),
            _ => return Ok(Act::Told(HELP.to_owned())),
        };
        let command = changed_top(top);
        if session.ask_of(axis, command)? == Reply::Yes {
            self.top = top;
            return Ok(Act::Changed(command, format!("top speed {} steps/s", shown(top))));
        }
        Ok(Act::Told(match session.why()? {
            Some(why) => format!("the board refused {command}: {why}"),
            None => format!("the board refused {command}"),
        }))
    }
}

/// A tenth of a speed in 0.001 steps/s; of one above 10 steps/s in whole steps/s.
pub fn part(top: u32) -> u32 {
    let part = top / PART;
    (if part >= 1000 { part / 1000 * 1000 } else { part }).max(1)
}

/// The line that sets this top speed, in 0.001 steps/s.
pub fn changed_top(top: u32) -> Command {
    let speed = stepwright::Speed::from_millisteps(top).unwrap_or(stepwright::Speed::MAX);
    Command::top(speed).unwrap_or(Command::Milli(MilliSpeed::clamped(top)))
}

/// A speed in 0.001 steps/s for people, in steps/s.
pub fn shown(millisteps: u32) -> f64 {
    f64::from(millisteps) / 1000.0
}
