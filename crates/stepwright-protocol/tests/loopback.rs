//! The master against the slave, over a good line and over a bad one.

use std::collections::VecDeque;

use crate::common::{Bench, Random, lines};
use proptest::prelude::*;
use stepwright::{Accel, Speed};
use stepwright_protocol::{
    Abilities, AxisId, Command, Direction, Distance, Errors, Info, Master, Order, Ramp, RampSteps,
    Reply, Script, Slave, Stops, Travel, VERSION,
};

/// A master and a slave with a wire between them.
struct Link {
    master: Master,
    slave: Slave<3>,
    bench: Bench,
    random: Random,
    /// One byte in this many is damaged; 0 for no damage.
    noise: usize,
    /// Whether the damage is a flipped bit that no receiver notices.
    flips: bool,
}

impl Link {
    fn new(noise: usize, seed: u64) -> Link {
        Link {
            master: Master::new(),
            slave: Slave::new(),
            bench: Bench::new(3),
            random: Random(seed),
            noise,
            flips: false,
        }
    }

    /// A link whose lines have checksums, on a wire that flips bits.
    fn summed(noise: usize, seed: u64) -> Link {
        let mut link = Link { flips: true, ..Link::new(noise, seed) };
        link.master.use_sums(true);
        link
    }

    /// The bytes that arrive for a byte on the wire, and whether the receiver noticed damage.
    ///
    /// It excludes a digit that becomes another digit: the Nano slave's lines have no checksum, so
    /// such damage can't be detected.
    fn wire(&mut self, byte: u8) -> (Vec<u8>, bool) {
        if self.noise == 0 || !self.random.one_in(self.noise) {
            return (vec![byte], false);
        }
        if self.flips {
            return (vec![byte ^ 1 << self.random.below(8)], false);
        }
        let junk = 0x80 | self.random.byte();
        match self.random.below(4) {
            0 => (vec![], true),
            1 => (vec![junk], false),
            2 => (vec![junk, byte], false),
            _ => (vec![byte, junk, b'\n'], false),
        }
    }

    /// Sends bytes over the wire, and lets both sides respond.
    fn carry(&mut self, bytes: impl Iterator<Item = u8>) -> Option<Reply> {
        let (mut answer, mut back) = (None, VecDeque::new());
        for byte in bytes {
            let (bytes, lost) = self.wire(byte);
            if lost {
                self.slave.garbled();
            }
            for byte in bytes {
                self.slave.receive(byte, &mut self.bench);
                while self.slave.work(&mut self.bench) {}
                back.extend(std::iter::from_fn(|| self.slave.next_byte(&mut self.bench)));
            }
        }
        while let Some(byte) = back.pop_front() {
            for byte in self.wire(byte).0 {
                answer = answer.or(self.master.receive(byte));
            }
        }
        answer
    }

    fn send(&mut self, command: Command) -> Option<Reply> {
        let bytes = self.master.send(command).expect("in step");
        self.carry(bytes)
    }

    /// Behaves as a careful host: sends one line after the other. Without an answer it gets in step
    /// and checks the result.
    fn order(&mut self, orders: &[(AxisId, Order)]) {
        'again: for _ in 0..10_000 {
            for command in Script::new(orders).unwrap() {
                match self.send(command) {
                    Some(Reply::Yes) => continue,
                    // Refused because the line was damaged: begin again.
                    Some(Reply::No) => continue 'again,
                    Some(other) => panic!("{other:?} to {command}"),
                    None => {}
                }
                let state = (0..1000).find_map(|_| {
                    let bytes = self.master.resync();
                    self.carry(bytes)
                });
                match state {
                    Some(Reply::Busy) => return, // // E had come through
                    Some(_) => continue 'again,
                    None => panic!("never in step again"),
                }
            }
            return;
        }
        panic!("the order never came through");
    }
}

fn order(top: u32, travel: i32) -> Order {
    Order {
        start: Speed::from_steps(50).unwrap(),
        top: Speed::from_steps(top).unwrap(),
        up: Ramp::Steps(RampSteps::new(200).unwrap()),
        down: Ramp::Accel(Accel::from_steps(4000).unwrap()),
        jerk: None,
        travel: Travel::By(Distance::new(travel)),
    }
}

fn axis(n: u8) -> AxisId {
    AxisId::numbered(n).unwrap()
}

/// The orders as the machine receives them.
fn heard(orders: &[(AxisId, Order)]) -> Vec<(AxisId, stepwright::Order)> {
    orders.iter().map(|(axis, order)| (*axis, (*order).into())).collect()
}

#[test]
fn an_order_goes_through_and_is_watched() {
    let mut link = Link::new(0, 1);
    let orders = [(axis(2), order(1000, 4000))];
    assert_eq!(lines(Script::new(&orders).unwrap()), "A2 PO A2 S5 T100 R200 d4000 G+4000 E");
    link.order(&orders);
    assert_eq!(link.bench.asked, [heard(&orders)]);
    assert_eq!(link.send(Command::Status), Some(Reply::Busy));
    link.bench.arrive(1);
    assert_eq!(link.send(Command::Status), Some(Reply::Ready));
    assert_eq!(link.send(Command::Position(axis(2))), Some(Reply::Position(4000)));
    assert_eq!(link.send(Command::Run(Direction::Forward)), Some(Reply::Yes));
    assert_eq!(link.send(Command::Kill), Some(Reply::Yes));
    assert_eq!(link.send(Command::Position(axis(2))), Some(Reply::No));
    let info = Info {
        version: VERSION,
        axes: 3,
        max: 120_000,
        late: 0,
        refused: 1,
        last: Some(stepwright_protocol::Refusal::Uncertain),
        uncertain: 2,
        stops: Stops::parse(b"-K-"),
        errors: Some(Errors::parse(b"K")),
        can: Some(Abilities::OWN),
        closed: Some(0),
    };
    assert_eq!(link.send(Command::Info), Some(Reply::Info(info)));
}

#[test]
fn half_a_line_of_another_master_does_no_harm() {
    for half in ["G+40", "E", "g+", "K", "PO", "xxxxxxxxxxxxxxxxxxxxxxxxxxx"] {
        let mut link = Link::new(0, 1);
        let before = ["PO", "G+4000"];
        let before = before.iter().flat_map(|line| line.bytes().chain([b'\r']));
        link.carry(before.chain(half.bytes()));
        let bytes = link.master.resync();
        assert_eq!(link.carry(bytes), Some(Reply::Ready), "{half}");
        assert!(link.bench.asked.is_empty(), "{half}");
        assert_eq!(link.send(Command::Execute), Some(Reply::No), "{half}");
        link.order(&[(axis(1), order(500, 7))]);
        assert_eq!(link.bench.asked, [heard(&[(axis(1), order(500, 7))])], "{half}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5000))]

    /// With checksums the same holds on a wire that changes digits into other digits.
    #[test]
    fn flipped_bits_delay_an_order_and_change_nothing(
        seed: u64, noise in 100usize..1000, first in 1u8..=3,
        top in 1u32..100_000, by in 1i32..i32::MAX,
    ) {
        let mut link = Link::summed(noise, seed);
        let orders = vec![(axis(first), order(top, by))];
        link.order(&orders);
        prop_assert_eq!(&link.bench.asked, &vec![heard(&orders)]);
    }

    /// Over a bad line an order is carried out exactly once, or not yet.
    #[test]
    fn noise_delays_an_order_and_changes_nothing(
        seed: u64, noise in 20usize..200, first in 1u8..=3, both: bool,
        top in 1u32..100_000, by in 1i32..i32::MAX,
    ) {
        let mut link = Link::new(noise, seed);
        let mut orders = vec![(axis(first), order(top, by))];
        if both && first > 1 {
            orders.insert(0, (axis(1), order(1000, -by)));
        }
        link.order(&orders);
        prop_assert_eq!(&link.bench.asked, &vec![heard(&orders)]);
    }
}
