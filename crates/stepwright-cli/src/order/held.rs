//! Which key of a jog is held, by the bytes that a terminal sends.
//!
//! ```text
//!   bytes ──► Decoder ──► keys ──► Hold ──► which way the motor is to run now
//! ```
//!
//! A terminal says that a key goes down, and says so again while it stays down; most do not
//! say that it comes up. So a key counts as held for a while after each word of it: longer
//! after the first one, for repeats begin late. Terminals that follow kitty's keyboard
//! protocol are asked to say it, and then letting go counts at once.

use std::time::Duration;

use stepwright_protocol::Direction;

/// From a key to its first repeat: 660 ms under X, less elsewhere.
const FIRST: Duration = Duration::from_millis(700);

/// Between two repeats: 30 to 90 ms, and what a connection adds.
const NEXT: Duration = Duration::from_millis(250);

/// Asks a terminal to say when a key comes up; others ignore it.
pub const ASK_RELEASES: &str = "\x1b[>2u";

/// Takes [`ASK_RELEASES`] back.
pub const NO_RELEASES: &str = "\x1b[<u";

/// A key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// An arrow goes down, or still is: → and ↑ forward, ← and ↓ backward.
    Down(Direction),
    /// An arrow comes up.
    Up(Direction),
    /// A letter or a sign.
    Sign(u8),
    /// A key that a jog has no use for.
    Other,
}

/// Puts bytes together to keys. Sequences may be torn anywhere.
#[derive(Default)]
pub struct Decoder {
    /// What came since ESC, without it.
    sequence: Option<Vec<u8>>,
}

/// No sequence of a key is longer.
const LONGEST: usize = 24;

impl Decoder {
    /// Takes a byte; the key that it completes.
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
            // CSI: up to a letter or one of @^_`{|}~.
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

/// What is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Free,
    /// This way, until then.
    Held(Direction, Duration),
    /// Still held, perhaps, but of no effect any more.
    Spent(Direction, Duration),
}

/// Which way the motor is to run.
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

    /// What is held has no effect any more, until it is let go and pressed again.
    pub fn spend(&mut self, now: Duration) {
        if let State::Held(way, _) = self.0 {
            self.0 = State::Spent(way, now + FIRST);
        }
    }

    /// The way that is held.
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
        // What has no end is none, and what follows is read.
        let mut endless = b"\x1b[".to_vec();
        endless.extend([b'1'; 23]);
        assert_eq!(keys(&[endless, b"q".to_vec()].concat()), [Key::Other, Key::Sign(b'q')]);
    }

    /// What is wanted every 10 ms, while these keys come: `+` forward, `-` backward, `^` up
    /// from forward, `x` spends.
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
        // A tap: 700 ms, or as long as the terminal says.
        assert_eq!(wanted(&[(0, '+')], 690), "+");
        assert_eq!(wanted(&[(0, '+')], 720), "+.");
        assert_eq!(wanted(&[(0, '+'), (50, '^')], 60), "+.");
        // Repeats hold it without a gap, however late the first one is.
        let mut held: Vec<_> = (660..3000).step_by(90).map(|at| (at, '+')).collect();
        held.insert(0, (0, '+'));
        assert_eq!(wanted(&held, 3000), "+");
        assert_eq!(wanted(&held, 3300), "+.");
        // The other arrow takes its place; the first one's release is nothing to it.
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
