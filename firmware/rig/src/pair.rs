//! Two chips whose serial ports are joined crosswise.

use crate::chip::Chip;

/// The time for which each chip runs alone: less than a byte takes, so that no byte comes too late.
const SLICE: u64 = 500;

/// A master and a slave on one cable.
pub struct Pair {
    /// One end of the cable.
    pub master: Chip,
    /// The other end.
    pub slave: Chip,
    /// All bytes from master to slave.
    pub orders: Vec<u8>,
    /// All bytes from slave to master.
    pub answers: Vec<u8>,
}

impl Pair {
    /// Joins two chips; both clocks continue from their present values.
    pub fn new(master: Chip, slave: Chip) -> Pair {
        Pair { master, slave, orders: Vec::new(), answers: Vec::new() }
    }

    /// Lets `cycles` pass on both.
    pub fn run_for(&mut self, cycles: u64) {
        let end = self.master.now() + cycles;
        while self.master.now() < end {
            let begin = (self.master.now(), self.slave.now());
            self.master.run_for(SLICE);
            self.slave.run_for(self.master.now() - begin.0);
            let orders = carry(&mut self.master, begin.0, &mut self.slave, begin.1);
            self.orders.extend(orders);
            let answers = carry(&mut self.slave, begin.1, &mut self.master, begin.0);
            self.answers.extend(answers);
        }
    }
}

/// Passes on the bytes whose sending has begun. `from_begin` and `to_begin` are the same moment on
/// both clocks.
fn carry(from: &mut Chip, from_begin: u64, to: &mut Chip, to_begin: u64) -> Vec<u8> {
    let sent = from.take_begun();
    for &(done, byte) in &sent {
        to.send_complete_at(to_begin + done.saturating_sub(from_begin), byte);
    }
    sent.into_iter().map(|(_, byte)| byte).collect()
}
