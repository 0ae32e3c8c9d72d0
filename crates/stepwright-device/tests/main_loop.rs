//! A round of the main loop: the calls to a board and its line, in order.

use std::collections::VecDeque;

use stepwright_device::main_loop::{Foreground, Received, SerialPort, round};

/// The calls to a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Call {
    Tick,
    Heard(u8),
    Garbled,
    Work,
    PollIo,
    Plan,
}

/// A board that takes `listens` bytes, has an answer to send, and pieces to plan.
#[derive(Default)]
struct Board {
    calls: Vec<Call>,
    listens: usize,
    answer: VecDeque<u8>,
    pieces: usize,
}

impl Foreground for Board {
    fn tick(&mut self) {
        self.calls.push(Call::Tick);
    }
    fn is_answering(&mut self) -> bool {
        !self.answer.is_empty()
    }
    fn listens(&mut self) -> bool {
        self.listens > 0
    }
    fn receive(&mut self, byte: u8) {
        self.listens -= 1;
        self.calls.push(Call::Heard(byte));
    }
    fn garbled(&mut self) {
        self.calls.push(Call::Garbled);
    }
    fn work(&mut self) {
        self.calls.push(Call::Work);
    }
    fn next_byte(&mut self) -> Option<u8> {
        self.answer.pop_front()
    }
    fn poll_io(&mut self) {
        self.calls.push(Call::PollIo);
    }
    fn plan(&mut self) -> bool {
        self.calls.push(Call::Plan);
        self.pieces = self.pieces.saturating_sub(1);
        self.pieces > 0
    }
}

/// A line with room for `room` bytes.
#[derive(Default)]
struct Line {
    heard: VecDeque<Received>,
    room: usize,
    said: Vec<u8>,
}

impl SerialPort for Line {
    fn receive(&mut self) -> Option<Received> {
        self.heard.pop_front()
    }
    fn has_room(&self) -> bool {
        self.said.len() < self.room
    }
    fn send(&mut self, byte: u8) {
        self.said.push(byte);
    }
}

/// Up to the end of a line; the bytes after it wait until the line is obeyed.
#[test]
fn a_round_listens_works_looks_and_plans_a_run() {
    let mut board = Board { listens: 2, pieces: 9, ..Board::default() };
    let heard = [Received::Byte(b'F'), Received::Garbled, Received::Byte(13), Received::Byte(b'V')];
    let mut line = Line { heard: heard.into(), ..Line::default() };
    round(&mut board, &mut line);
    let mut calls = vec![
        Call::Tick,
        Call::Heard(b'F'),
        Call::Garbled,
        Call::Heard(13),
        Call::Work,
        Call::PollIo,
    ];
    calls.extend([Call::Plan; 4]);
    assert_eq!(board.calls, calls);
    assert_eq!(line.heard, [Received::Byte(b'V')]);
}

#[test]
fn planning_ends_with_its_last_piece() {
    let mut board = Board { pieces: 2, ..Board::default() };
    round(&mut board, &mut Line::default());
    assert_eq!(board.calls, [Call::Tick, Call::Work, Call::PollIo, Call::Plan, Call::Plan]);
}

/// One byte a round, if there is room, so that planning continues in between; nothing is received
/// meanwhile.
#[test]
fn an_answer_is_said_byte_by_byte() {
    let answer = VecDeque::from(*b"0\r");
    let mut board = Board { listens: 9, answer, ..Board::default() };
    let heard = VecDeque::from([Received::Byte(b'F')]);
    let mut line = Line { heard, room: 1, ..Line::default() };
    round(&mut board, &mut line);
    assert_eq!(line.said, b"0");
    round(&mut board, &mut line);
    assert_eq!((line.said.len(), board.answer.len()), (1, 1), "there is no room");
    line.room = 2;
    round(&mut board, &mut line);
    assert_eq!(line.said, b"0\r");
    assert_eq!(board.calls, [Call::Tick, Call::PollIo, Call::Plan].repeat(3));
    round(&mut board, &mut line);
    assert!(board.calls.contains(&Call::Heard(b'F')));
}
