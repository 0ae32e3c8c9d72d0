//! Tests of the conversation with a board. The virtual board is behind the line.

use std::collections::VecDeque;
use std::io;

use stepwright_host::link::simulated::{VirtualLink, VirtualProgram};
use stepwright_play::timed::{TimedOrder, TimedWiring};
use stepwright_sim::timed::{TimedLineBoard, TimedMotor};
use stepwright_timed::SetSpeed;
use stepwright_timed::line::LONGEST;

use super::*;

const HZ: u32 = 16_000_000;
/// A byte on the line, in ticks.
const BYTE: u64 = 1_388;

/// The program `timed` with its identification. Its time passes while the caller waits.
struct Chip {
    board: VirtualLink<VirtualProgram<TimedMotor, LONGEST>>,
    about: &'static str,
    line: Vec<u8>,
    answers: VecDeque<u8>,
}

impl Chip {
    fn new(about: &'static str) -> Chip {
        let board = VirtualLink::new(VirtualProgram::new(TimedLineBoard::uno(), HZ, BYTE), true);
        Chip { board, about, line: Vec::new(), answers: VecDeque::new() }
    }
}

impl Link for Chip {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        for byte in bytes {
            self.line.push(*byte);
            if *byte != b'\r' {
                continue;
            }
            let line = std::mem::take(&mut self.line);
            let sum = self.about.bytes().fold(0, stepwright_protocol::crc);
            let summed = format!("{}*{sum:02X}\r", self.about);
            match line.as_slice() {
                b"?\r" => self.answers.extend(self.about.bytes().chain([b'\r'])),
                [b'?', ..] => self.answers.extend(summed.bytes()),
                _ if self.about == "E" => self.answers.extend(b"E\r"),
                line => self.board.write(line)?,
            }
        }
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        match (self.answers.pop_front(), buffer.first_mut()) {
            (Some(byte), Some(first)) => {
                *first = byte;
                Ok(1)
            }
            _ => self.board.read(buffer, limit),
        }
    }

    fn now(&self) -> Duration {
        self.board.now()
    }

    fn name(&self) -> String {
        "the chip".into()
    }
}

const UNO: &str = "stepwright-timed uno hz=16000000 axes=0 can=sum timers=1";

fn order(set_speed: SetSpeed, poll_ms: Option<u32>) -> TimedOrder {
    TimedOrder { set_speed, poll_ms, case: None, steps_per_turn: 200 }
}

/// Gives an order to a board, and examines the result.
fn play<T>(
    about: &'static str,
    timer: u8,
    order: &TimedOrder,
    see: impl FnOnce(&TimedCourse) -> T,
) -> Result<T, Failure> {
    let mut board = Board::meet(Box::new(Chip::new(about)))?;
    let wire = Wire {
        port: b'B',
        mask: 0b11_0000,
        sequence: stepwright::drive::sequence::SHIELD.on_bits(&[4, 5]),
        shield: true,
        phase: 0,
    };
    let wiring = TimedWiring {
        name: None,
        sequence: wire.sequence,
        phase: 0,
        signals: Vec::new(),
        wire: Some(wire),
    };
    let log = Moments::Every(100.0, 200.0);
    let hardware = Hardware::avr16(HZ);
    let (latched, for_ms) = (false, None);
    let play = TimedPlay { hardware, latched, order, wiring: &wiring, for_ms, log: Some(&log) };
    board.play(&play, timer, wire).map(|course| see(&course))
}

/// At any time, also before the motor has pins.
#[test]
fn speed_0_stops_the_motor() {
    let mut board = Board::meet(Box::new(Chip::new(UNO))).unwrap();
    board.stop(1).unwrap();
    assert!(board.stop(3).unwrap_err().message().contains("has no motor on timer 3"));
}

#[test]
fn an_order_is_watched_to_its_end() {
    // 250 steps/s, 300 steps: 1.2 s.
    let set_speed = SetSpeed { limit: 300, ..SetSpeed::fixed(Control::DRV_EN, 64_000) };
    let order = order(set_speed, Some(50));
    play(UNO, 1, &order, |course| {
        assert_eq!((course.code, course.made, course.moving), (Code::FINE, Some(300), false));
        assert_eq!(course.calls, [(1_200.0, Call::Reached)]);
        let left: Vec<_> = course.dumps.iter().map(|dump| dump.dump.steps_left).collect();
        // A poll takes some milliseconds on the line, and a step comes every 4 ms.
        let near = |(left, wanted): (&u32, u32)| (wanted - 5..=wanted).contains(left);
        assert!(left.iter().zip([275, 225, 175, 125, 75, 25]).all(near), "{left:?}");
        assert_eq!(left.len(), 6);
    })
    .unwrap();
}

#[test]
fn an_endless_order_ends_with_the_watch_and_a_fault_is_told() {
    let control = Control::DRV_EN | Control::SPEED_VARIABLE | Control::FASTER;
    let set_speed = SetSpeed {
        control,
        top: 2_000,
        limit: 0,
        modification: 600,
        update_ms: 100,
        mod_counts: 5,
    };
    play(UNO, 1, &order(set_speed, Some(20)), |course| {
        assert_eq!((course.code, course.made, course.moving), (Code::WARN_RANGE, None, true));
        assert_eq!(course.calls, [(300.0, Call::Fault)]);
        let tops: Vec<_> = course.updates.iter().map(|update| update.top).collect();
        assert_eq!(tops, [2_000, 1_400, 800]);
    })
    .unwrap();
}

#[test]
fn what_can_t_be_is_refused_with_what_to_do() {
    let fixed = order(SetSpeed::fixed(Control::DRV_EN, 64_000), None);
    let fast = order(SetSpeed::fixed(Control::DRV_EN, 639), None);
    for (about, timer, order, part) in [
        ("stepwright 0.1 axes=3", 1, &fixed, "runs the controller"),
        ("E", 1, &fixed, "does not answer"),
        (UNO, 3, &fixed, "no motor on timer 3"),
        ("stepwright-timed uno hz=8000000 timers=1", 1, &fixed, "run at 8000000 Hz"),
        (UNO, 1, &fast, "too fast"),
    ] {
        let failure = play(about, timer, order, |_| ()).unwrap_err();
        assert!(failure.message().contains(part), "{failure:?}");
    }
}
