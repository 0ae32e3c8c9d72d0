//! The conversation with a board, which is the virtual one behind the line.

use std::collections::VecDeque;
use std::io;

use stepwright_sim::timed::TimedBoard;
use stepwright_timed::Model;

use super::*;
use crate::timed::order::Order;
use crate::timed::wiring::Wiring;

const HZ: u32 = 16_000_000;

/// The program `timed`, its time that of the caller's waiting.
struct Chip {
    about: &'static str,
    board: Option<TimedBoard>,
    model: Model,
    check: u32,
    reached: Option<u32>,
    fault: Option<u32>,
    said: Vec<u8>,
    answers: VecDeque<u8>,
    now: Duration,
}

impl Chip {
    fn new(about: &'static str) -> Chip {
        Chip {
            about,
            board: None,
            model: Model::Ideal,
            check: 0,
            reached: None,
            fault: None,
            said: Vec::new(),
            answers: VecDeque::new(),
            now: Duration::ZERO,
        }
    }

    fn millis(&self) -> u32 {
        self.board.as_ref().map_or(0, |board| (board.now() / u64::from(HZ / 1000)) as u32)
    }

    fn answer(&mut self) -> String {
        let text = std::mem::take(&mut self.said);
        let Some(line) = Line::read(&text) else { return "E".into() };
        match line {
            Line::Info => return self.about.into(),
            Line::Wire(1, wire) => {
                let mut board = TimedBoard::new(Hardware::avr16(HZ), self.model, wire.sequence, 0);
                board.restore(wire.phase);
                self.board = Some(board);
            }
            Line::Latched(1, latched) => {
                self.model = if latched { Model::Latched } else { Model::Ideal }
            }
            Line::Check(1, ms) => self.check = ms.into(),
            Line::Move(1, order, _) => {
                let code = match &mut self.board {
                    Some(board) => board.set_speed(&order),
                    None if order == SetSpeed::STOP => Code::FINE,
                    None => Code::NOT_WIRED,
                };
                return code.get().to_string();
            }
            Line::Look(1) => {
                let (ms, reached, fault) = (self.millis(), self.reached, self.fault);
                let board = self.board.as_mut().unwrap();
                let (dump, moving) = (board.dump(), board.is_moving());
                let report = Report { ms, dump, moving, reached, fault };
                let numbers: Vec<_> = report.numbers().iter().map(u32::to_string).collect();
                return numbers.join(",");
            }
            _ => return "E".into(),
        }
        "Y".into()
    }
}

impl Link for Chip {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        for byte in bytes {
            if *byte == b'\r' {
                let answer = self.answer() + "\r";
                self.answers.extend(answer.bytes());
            } else {
                self.said.push(*byte);
            }
        }
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        match self.answers.pop_front() {
            Some(byte) => {
                buffer[0] = byte;
                Ok(1)
            }
            None => {
                self.rest(limit);
                Ok(0)
            }
        }
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn name(&self) -> String {
        "the chip".into()
    }

    fn rest(&mut self, time: Duration) {
        self.now += time;
        for _ in 0..time.as_millis() {
            let ms = self.millis() + 1;
            let Some(board) = &mut self.board else { return };
            board.run_for_millis(1);
            if self.check != 0 && ms.is_multiple_of(self.check) {
                let (reached, fault) = (&mut self.reached, &mut self.fault);
                board.update_check(|call| match call {
                    Call::Reached => *reached = Some(ms),
                    Call::Fault => *fault = Some(ms),
                });
            }
        }
    }
}

const UNO: &str = "stepwright-timed uno hz=16000000 timers=1";

fn order(set_speed: SetSpeed, poll_ms: Option<u32>) -> Order {
    Order { set_speed, poll_ms, case: None, steps_per_turn: 200 }
}

/// Gives an order to a board, and looks at what came of it.
fn play<T>(
    about: &'static str,
    timer: u8,
    order: &Order,
    see: impl FnOnce(&Course) -> T,
) -> Result<T, Failure> {
    let mut board = Board::meet(Box::new(Chip::new(about)))?;
    let wire = Wire {
        port: b'B',
        mask: 0b11_0000,
        sequence: stepwright::drive::sequence::SHIELD.on_bits(&[4, 5]),
        shield: true,
        phase: 0,
    };
    let wiring = Wiring {
        name: None,
        sequence: wire.sequence,
        phase: 0,
        signals: Vec::new(),
        wire: Some(wire),
    };
    let log = Moments::Every(100.0, 200.0);
    let hardware = Hardware::avr16(HZ);
    let (latched, for_ms) = (false, None);
    let play = Play { hardware, latched, order, wiring: &wiring, for_ms, log: Some(&log) };
    board.play(&play, timer, wire).map(|course| see(&course))
}

/// Whatever it plays, and before it has pins.
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
        assert_eq!(left, [275, 225, 175, 125, 75, 25]);
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
