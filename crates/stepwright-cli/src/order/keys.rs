//! Keys while a motor moves: faster, slower, stop.
//!
//! On a terminal each key is read as it is pressed; elsewhere there are no keys.
//! Ctrl-C keeps its function.

use std::iter;

use stepwright_host::Conversation;
use stepwright_protocol::{Command, MilliSpeed, Order, Refusal};

use super::held::{Decoder, Key};
use super::terminal::{self, Keys};

/// The keys, for the user.
pub const HELP: &str = "keys: + faster, - slower, s stop";

/// A press changes the top speed by a tenth.
const PART: u32 = 10;

/// The action of a key.
pub enum Act {
    /// Brake the motor.
    Stop,
    /// Send this line.
    Say(Command),
    /// Print the keys.
    Help,
}

/// The control of a moving motor by keys.
pub struct KeyControl {
    keys: Option<Keys>,
    decoder: Decoder,
    /// The top speed of the travel in progress, and the lowest it can have, in
    /// 0.001 steps/s.
    top: u32,
    least: u32,
    /// The top speed that was requested and not confirmed yet.
    wanted: u32,
}

impl KeyControl {
    /// Listens to the keys, if there are any, for a motor that follows this order. The speed can't
    /// be changed on a board that knows only the Nano slave's lines.
    pub fn on(talk: &Conversation, order: &Order) -> KeyControl {
        let (top, start) = (order.top.millisteps(), order.start.millisteps());
        let able = terminal::is_there() && talk.info().is_some();
        let keys = if able { Keys::listen() } else { None };
        let decoder = Decoder::default();
        KeyControl { keys, decoder, top, least: start.min(top).max(1), wanted: top }
    }

    /// Whether there are keys.
    pub fn listens(&self) -> bool {
        self.keys.is_some()
    }

    /// The action of the next key.
    pub fn act(&mut self) -> Option<Act> {
        let keys = self.keys.as_ref()?;
        // A sequence is one key.
        let key = iter::from_fn(|| keys.next()).find_map(|byte| self.decoder.take(byte))?;
        let step = part(self.top);
        self.wanted = match key {
            Key::Sign(b'+' | b'=') => self.top.saturating_add(step).min(MilliSpeed::LARGEST.get()),
            Key::Sign(b'-' | b'_') => self.top.saturating_sub(step).max(self.least),
            Key::Sign(b's' | b'S' | b' ') => return Some(Act::Stop),
            Key::Up(_) => return None,
            _ => return Some(Act::Help),
        };
        Some(Act::Say(changed_top(self.wanted)))
    }

    /// The result of the line that was sent, for the user.
    pub fn said(&mut self, line: Command, taken: Result<(), Option<Refusal>>) -> String {
        match taken {
            Ok(()) => {
                self.top = self.wanted;
                format!("top speed {} steps/s", shown(self.top))
            }
            Err(Some(why)) => format!("the board refused {line}: {why}"),
            Err(None) => format!("the board refused {line}"),
        }
    }
}

/// A tenth of a speed in 0.001 steps/s; in whole steps/s above 10 steps/s.
pub fn part(top: u32) -> u32 {
    let part = top / PART;
    (if part >= 1000 { part / 1000 * 1000 } else { part }).max(1)
}

/// The line that sets this top speed, in 0.001 steps/s.
pub fn changed_top(top: u32) -> Command {
    let speed = stepwright::Speed::from_millisteps(top).unwrap_or(stepwright::Speed::MAX);
    Command::top(speed).unwrap_or(Command::Milli(MilliSpeed::clamped(top)))
}

/// A speed in 0.001 steps/s, as steps/s for display.
pub fn shown(millisteps: u32) -> f64 {
    f64::from(millisteps) / 1000.0
}
