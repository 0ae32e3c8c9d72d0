//! The power of a laser, beside the records of the axes.
//!
//! A change of the power is a record of the fourth axis number, which no axis has. It stands in the order of
//! the starts, as the records of the axes do.
//!
//! ```text
//!   ┌──────┬───────────┬───────────┬───────┐
//!   │ 1101 │ wait high │  wait low │ power │     wait: 12 bits, in 2⁸ ticks since the last change
//!   └──────┴───────────┴───────────┴───────┘     power: 0, off, to 255
//! ```
//!
//! The first wait counts from the start. A wait is at most 65 ms at 16 MHz: a longer one is several records of
//! the same power.
//!
//! **On the board.** Decoded changes wait in a [`PowerQueue`] of [`WAITING`]. The main loop makes a change with
//! its first [`poll`](crate::player::StreamPlayer::poll) at or after the change's time. The laser goes off as
//! soon as the board leaves the path, and when all axes rest at the end.

/// The first byte of a change, without the high bits of its wait.
pub const POWER: u8 = 0xD0;
/// Bytes of a change.
pub const LEN: usize = 3;
/// Ticks of one unit of a wait, as a power of two.
pub const UNIT_BITS: u32 = 8;
/// The longest wait of a change, in units.
pub const LONGEST: u16 = 0xFFF;
/// The most changes that wait on a board. While a change finds no room, the records after it wait too: a host
/// keeps changes far enough apart.
pub const WAITING: usize = 8;

/// The bytes of a change.
///
/// ```
/// use stepwright_stream::power;
/// assert_eq!(power::bytes(0x123, 200), [0xD1, 0x23, 200]);
/// assert_eq!(power::decode([0xD1, 0x23, 200]), (0x123, 200));
/// ```
pub const fn bytes(wait: u16, power: u8) -> [u8; LEN] {
    let wait = if wait < LONGEST { wait } else { LONGEST };
    let [high, low] = wait.to_be_bytes();
    [POWER | high, low, power]
}

/// The wait of a change, in units, and its power.
pub const fn decode([high, low, power]: [u8; LEN]) -> (u16, u8) {
    (u16::from_be_bytes([high & 0x0F, low]), power)
}

/// Whether a record with this first byte is a change of the power.
#[inline(always)]
pub const fn is_power(head: u8) -> bool {
    head & 0xF0 == POWER
}

/// The changes that wait on a board, and the present power.
#[derive(Clone, Debug)]
pub struct PowerQueue {
    /// The times of the changes, in units since the start modulo 2¹⁶, and their powers.
    at: [u16; WAITING],
    power: [u8; WAITING],
    first: u8,
    waiting: u8,
    /// The time of the last change that was put.
    last: u16,
    /// The unit of the timer in which the run started.
    origin: u16,
    now: u8,
}

impl PowerQueue {
    /// A laser that is off, with nothing waiting.
    pub const NONE: PowerQueue = PowerQueue {
        at: [0; WAITING],
        power: [0; WAITING],
        first: 0,
        waiting: 0,
        last: 0,
        origin: 0,
        now: 0,
    };

    /// Whether another change can be put.
    pub const fn has_room(&self) -> bool {
        self.waiting < WAITING as u8
    }

    /// Puts a change after the last one.
    pub fn put(&mut self, wait: u16, power: u8) {
        self.last = self.last.wrapping_add(wait);
        let place = usize::from(self.first.wrapping_add(self.waiting)) % WAITING;
        if let (Some(at), Some(known)) = (self.at.get_mut(place), self.power.get_mut(place)) {
            (*at, *known) = (self.last, power);
            self.waiting = self.waiting.wrapping_add(1).min(WAITING as u8);
        }
    }

    /// The run starts at this time, in units of the timer.
    pub fn start(&mut self, time: u16) {
        self.origin = time;
    }

    /// Makes the changes up to this time, in units of the timer.
    #[inline(always)]
    pub fn pass(&mut self, time: u16) {
        if self.waiting != 0 {
            self.make(time.wrapping_sub(self.origin));
        }
    }

    #[inline(never)]
    fn make(&mut self, time: u16) {
        while self.waiting != 0 {
            let place = usize::from(self.first) % WAITING;
            let (Some(at), Some(power)) = (self.at.get(place), self.power.get(place)) else {
                return;
            };
            if (time.wrapping_sub(*at) as i16) < 0 {
                return;
            }
            self.now = *power;
            self.first = self.first.wrapping_add(1);
            self.waiting = self.waiting.wrapping_sub(1);
        }
    }

    /// Switches the laser off, and forgets all changes.
    pub fn off(&mut self) {
        *self = PowerQueue::NONE;
    }

    /// The present power.
    #[inline(always)]
    pub const fn power(&self) -> u8 {
        self.now
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_made_at_its_time() {
        let mut queue = PowerQueue::NONE;
        queue.put(100, 7);
        queue.put(3, 9);
        queue.start(0xFFF0);
        let mut powers = Vec::new();
        for time in 0..=110u16 {
            queue.pass(0xFFF0u16.wrapping_add(time));
            if powers.last().is_none_or(|(_, power)| *power != queue.power()) {
                powers.push((time, queue.power()));
            }
        }
        assert_eq!(powers, [(0, 0), (100, 7), (103, 9)]);
    }

    #[test]
    fn all_its_room_is_used_over_and_over() {
        let mut queue = PowerQueue::NONE;
        let (mut time, mut made) = (0u16, 0);
        for n in 0..10_000u32 {
            while !queue.has_room() {
                time = time.wrapping_add(1);
                let before = queue.power();
                queue.pass(time);
                made += u32::from(queue.power() != before);
            }
            queue.put(40, (n % 2) as u8 + 1);
        }
        assert!(made + WAITING as u32 >= 10_000, "{made}");
        queue.off();
        assert_eq!((queue.power(), queue.has_room()), (0, true));
    }
}
