//! Rows of a program on a line that delays and spoils answers: no answer is taken for that to another row, and
//! a board tells which program it runs.

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use stepwright_host::link::Link;
use stepwright_host::link::lossy::{Harm, Lossy};
use stepwright_host::link::simulated::{VirtualLink, VirtualProgram};
use stepwright_host::motion::{Action, Ended, RestPlace};
use stepwright_host::{Board, Error, LinkError, Session};
use stepwright_protocol::{AxisId, crc};
use stepwright_sim::{Description, LawBoard, Queues};

const ABOUT: &str = "stepwright-echo virtual axes=0 can=sum";

fn summed(line: &str) -> String {
    format!("{line}*{:02X}", line.bytes().fold(0, crc))
}

/// A board that echoes each row. The answer to line n takes the nth of these times, in ms.
struct Echo {
    delays: VecDeque<u64>,
    line: Vec<u8>,
    /// When the board can answer the next line.
    free: Duration,
    answers: VecDeque<(Duration, u8)>,
    now: Duration,
}

impl Echo {
    fn new(delays: &[u64]) -> Echo {
        let (delays, line, answers) =
            (delays.iter().copied().collect(), Vec::new(), VecDeque::new());
        Echo { delays, line, free: Duration::ZERO, answers, now: Duration::ZERO }
    }
}

impl Link for Echo {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        for byte in bytes {
            if *byte != b'\r' {
                self.line.push(*byte);
                continue;
            }
            let line = String::from_utf8(std::mem::take(&mut self.line)).unwrap();
            let (bare, sum) =
                line.split_once('*').map_or((&*line, false), |(bare, _)| (bare, true));
            let answer = match bare {
                "?" => ABOUT,
                "F" => "R",
                row if row.starts_with(':') => row,
                _ => "E line",
            };
            let answer = if sum { summed(answer) } else { answer.to_owned() };
            let delay = self.delays.pop_front().unwrap_or(0);
            self.free = self.free.max(self.now) + Duration::from_millis(delay);
            self.answers.extend(answer.bytes().chain(*b"\r").map(|byte| (self.free, byte)));
        }
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        match (self.answers.front(), buffer.first_mut()) {
            (Some((due, byte)), Some(first)) if *due <= self.now + limit => {
                (self.now, *first) = (self.now.max(*due), *byte);
                self.answers.pop_front();
                Ok(1)
            }
            _ => {
                self.now += limit;
                Ok(0)
            }
        }
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn name(&self) -> String {
        "the echo".into()
    }
}

/// No answer is taken for another row's, whatever the delays and wherever a row was given up.
#[test]
fn an_answer_is_never_taken_for_that_to_another_row() {
    for delays in [
        &[0, 0, 0, 700, 0, 0, 1_300, 0, 0][..],
        &[0, 0, 0, 1_700, 900, 0, 0, 0, 1_600, 0, 0],
        &[0, 0, 0, 600, 0, 0, 600, 0, 0, 600, 600],
        &[0, 0, 0, 900, 0, 0, 1_700, 600, 0, 600],
    ] {
        let mut session = Session::new(Box::new(Echo::new(delays)));
        assert_eq!(session.meet_program().unwrap(), ABOUT);
        let mut answered = 0;
        for n in 0..12 {
            let row = format!(":V{n}");
            if let Ok(Some(answer)) = session.row(&row, true) {
                assert_eq!(answer, row, "{delays:?}");
                answered += 1;
            }
        }
        assert!(answered >= 8, "{delays:?}: {answered}");
    }
}

#[test]
fn a_board_with_another_program_says_which() {
    let Err(Error::Lost { trouble, moving: false }) = Board::on(Box::new(Echo::new(&[]))) else {
        panic!("it is no controller");
    };
    assert!(matches!(trouble, LinkError::Program(about) if about == ABOUT));
}

/// An order by a law, from its rows to its end, with each byte spoiled or lost once.
#[test]
fn a_spoiled_byte_of_an_order_is_mended_or_moves_nothing() {
    for at in 0..120 {
        for harm in [Harm::LoseThere, Harm::LoseBack, Harm::SpoilThere, Harm::SpoilBack] {
            let harm = harm(at);
            let queues = Box::leak(Box::<Queues>::default());
            let board: LawBoard<'_, ()> = LawBoard::new(queues, Description::uno(), ());
            let link = VirtualLink::new(VirtualProgram::new(board, 16_000_000, 1_388), true);
            let mut session = Session::new(Box::new(Lossy::new(link, harm)));
            session.meet_program().unwrap();
            assert_eq!(session.row(":F5000,1000", true).unwrap().as_deref(), Some("Y"));
            let axis = AxisId::FIRST;
            let from = session.rest_position(axis).unwrap();
            assert_eq!(session.begin_by(axis, ":G40", from).unwrap(), "Y", "{harm:?}");
            let watched = session.watch(axis, None, |_, _| Action::GoOn);
            let Ended { end, .. } = session.conclude(axis, watched);
            assert_eq!(end, RestPlace::At(40), "{harm:?}");
        }
    }
}
