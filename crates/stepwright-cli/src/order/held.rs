//! Which key of a jog is held, from the bytes that a terminal sends.
//!
//! ```text
//!   bytes ──► Decoder ──► keys ──► Hold ──► which way the motor is to run now
//! ```
//!
//! A terminal reports that a key goes down, and repeats the report while the key is held. Most
//! terminals do not report that a key comes up. So a key counts as held for a while after each
//! report: longer after the first one, because repeats begin late. Terminals with kitty's keyboard
//! protocol are asked to report releases; there a release counts at once.

use std::time::Duration;

use stepwright_protocol::Direction;

/// The time from a key to its first repeat: 660 ms under X, less elsewhere.
const FIRST: Duration = Duration::from_millis(700);

/// The time between two repeats: 30 to 90 ms, plus the delay of a connection.
const NEXT: Duration = Duration::from_millis(250);

/// Asks a terminal to report released keys. Other terminals ignore it.
pub const ASK_RELEASES: &str = "\x1b[>2u";

/// Undoes [`ASK_RELEASES`].
pub const NO_RELEASES: &str = "\x1b[<u";

/// A key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// An arrow goes down or repeats: → and ↑ forward, ← and ↓ backward.
    Down(Direction),
    /// An arrow comes up.
    Up(Direction),
    /// A letter or a sign.
    Sign(u8),
    /// A key without a function in a jog.
    Other,
}

/// Assembles bytes to keys. Sequences may be split anywhere.
#[derive(Default)]
pub struct Decoder {
    /// The bytes since ESC, without ESC.
    sequence: Option<Vec<u8>>,
}

/// The longest sequence of a key.
const LONGEST: usize = 24;

impl Decoder {
    /// Takes a byte. Returns the key that it completes.
    pub fn take(&mut self, byte: u8) -> Option<Key> {
        if byte == b'\x1b' {
            self.sequence = Some(Vec::new());
            return None;
        }
        let Some(sequence) = &mut self.sequence else { return Some(Key::Sign(byte)) };
        sequence.push(byte);
        let whole = match sequence.as_slice() {
            // SS3: one byte follows.
            [b'O'] => false,
            [b'['] => false,
            // CSI: the sequence ends with a letter or one of @^_`{|}~.
            [b'[', ..] => (b'@'..=b'~').contains(&byte),
            _ => true,
        };
        if !whole && sequence.len() < LONGEST {
            return None;
        }
        let sequence = self.sequence.take().unwrap_or_default();
        Some(arrow(&sequence))
    }
}

/// The arrow of a sequence without its ESC: `[C`, `OC`, or `[1;1:3C` when it comes up.
fn arrow(sequence: &[u8]) -> Key {
    let (Some(last), Some(b'[' | b'O')) = (sequence.last(), sequence.first()) else {
        return Key::Other;
    };
    let way = match last {
        b'A' | b'C' => Direction::Forward,
        b'B' | b'D' => Direction::Backward,
        _ => return Key::Other,
    };
    let inside = sequence.get(1..sequence.len().saturating_sub(1)).unwrap_or_default();
    if inside.ends_with(b":3") { Key::Up(way) } else { Key::Down(way) }
}

/// The state of the held key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Free,
    /// A key of this direction is held until this time.
    Held(Direction, Duration),
    /// A key that may still be held, but has no effect any more.
    Spent(Direction, Duration),
}

/// The direction in which the motor shall run, from the held key.
pub struct Hold(State);

impl Hold {
    /// Nothing is held.
    pub fn new() -> Hold {
        Hold(State::Free)
    }

    /// An arrow goes down or repeats.
    pub fn down(&mut self, way: Direction, now: Duration) {
        self.0 = match self.0 {
            State::Held(held, until) if held == way && now < until => {
                State::Held(way, until.max(now + NEXT))
            }
            State::Spent(spent, until) if spent == way && now < until => {
                State::Spent(way, until.max(now + NEXT))
            }
            _ => State::Held(way, now + FIRST),
        };
    }

    /// An arrow comes up.
    pub fn up(&mut self, way: Direction) {
        if let State::Held(held, _) | State::Spent(held, _) = self.0
            && held == way
        {
            self.0 = State::Free;
        }
    }

    /// Makes the held key ineffective until it is released and pressed again.
    pub fn spend(&mut self, now: Duration) {
        if let State::Held(way, _) = self.0 {
            self.0 = State::Spent(way, now + FIRST);
        }
    }

    /// The direction of the held key.
    pub fn wanted(&self, now: Duration) -> Option<Direction> {
        match self.0 {
            State::Held(way, until) if now < until => Some(way),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Decoder, Hold, Key};
    use std::time::Duration;
    use stepwright_protocol::Direction::{Backward, Forward};

    fn keys(bytes: &[u8]) -> Vec<Key> {
        let mut decoder = Decoder::default();
        bytes.iter().filter_map(|&byte| decoder.take(byte)).collect()
    }

    #[test]
    fn arrows_of_all_terminals() {
        for (bytes, key) in [
            (&b"\x1b[C"[..], Key::Down(Forward)),
            (b"\x1bOA", Key::Down(Forward)),
            (b"\x1b[D", Key::Down(Backward)),
            (b"\x1b[1;5B", Key::Down(Backward)),
            (b"\x1b[1;1:1C", Key::Down(Forward)),
            (b"\x1b[1;1:2C", Key::Down(Forward)),
            (b"\x1b[1;1:3C", Key::Up(Forward)),
            (b"\x1b[1;1:3D", Key::Up(Backward)),
            (b"\x1b[5~", Key::Other),
            (b"\x1b[113;1:3u", Key::Other),
            (b"\x1bx", Key::Other),
            (b"q", Key::Sign(b'q')),
        ] {
            assert_eq!(keys(bytes), [key], "{bytes:?}");
        }
        assert_eq!(keys(b"\x1b\x1b[Cq"), [Key::Down(Forward), Key::Sign(b'q')]);
        // A sequence without an end is no key, and the bytes after it are read.
        let mut endless = b"\x1b[".to_vec();
        endless.extend([b'1'; 23]);
        assert_eq!(keys(&[endless, b"q".to_vec()].concat()), [Key::Other, Key::Sign(b'q')]);
    }

    /// The wanted direction every 10 ms, with these keys: `+` forward, `-` backward, `^` release of
    /// forward, `x` spends.
    fn wanted(script: &[(u64, char)], until: u64) -> String {
        let mut hold = Hold::new();
        let mut all = String::new();
        for ms in (0..until).step_by(10) {
            let now = Duration::from_millis(ms);
            for (_, key) in script.iter().filter(|(at, _)| *at == ms) {
                match key {
                    '+' => hold.down(Forward, now),
                    '-' => hold.down(Backward, now),
                    '^' => hold.up(Forward),
                    _ => hold.spend(now),
                }
            }
            let sign = hold.wanted(now).map_or('.', |w| if w == Forward { '+' } else { '-' });
            if !all.ends_with(sign) {
                all.push(sign);
            }
        }
        all
    }

    #[test]
    fn a_key_is_held_until_it_repeats_no_more() {
        // A tap counts for 700 ms, or until the terminal reports the release.
        assert_eq!(wanted(&[(0, '+')], 690), "+");
        assert_eq!(wanted(&[(0, '+')], 720), "+.");
        assert_eq!(wanted(&[(0, '+'), (50, '^')], 60), "+.");
        // Repeats hold it without a gap, however late the first one is.
        let mut held: Vec<_> = (660..3000).step_by(90).map(|at| (at, '+')).collect();
        held.insert(0, (0, '+'));
        assert_eq!(wanted(&held, 3000), "+");
        assert_eq!(wanted(&held, 3300), "+.");
        // The other arrow replaces the first; the release of the first has no effect.
        assert_eq!(wanted(&[(0, '+'), (100, '-'), (150, '^')], 700), "+-");
    }

    #[test]
    fn what_is_spent_has_to_be_pressed_again() {
        let held: Vec<_> = (500..2000).step_by(50).map(|at| (at, '+')).collect();
        let spent = |more: &[(u64, char)]| {
            let mut all = [&[(0, '+'), (100, 'x')], &held[..], more].concat();
            all.sort_by_key(|(at, _)| *at);
            all
        };
        assert_eq!(wanted(&spent(&[]), 2500), "+.");
        assert_eq!(wanted(&spent(&[(2400, '+')]), 2500), "+.+");
        assert_eq!(wanted(&spent(&[(1950, '^'), (1960, '+')]), 2500), "+.+");
        assert_eq!(wanted(&spent(&[(1960, '-')]), 2500), "+.-");
    }
}
