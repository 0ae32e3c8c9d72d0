//! A host at the other end of a serial line that can be left at any cycle: in the middle of a byte, of
//! a frame, of a line.

use std::collections::VecDeque;

use stepwright_feeder::{Cut, FeedTerms, StreamFeeder};
use stepwright_stream::credit::{Answered, Credit, CreditReader};

use super::{Job, MILLIS, Target};

/// Cycles of a byte at 115,200 baud.
const BYTE: u64 = 1_389;
/// The host looks at the line this often.
const LOOK: u64 = MILLIS / 4;

/// Bytes under way between a host and a board.
pub struct Wire {
    feeder: StreamFeeder,
    job: Job,
    /// Bytes, and when each of them is there.
    to: VecDeque<(u64, u8)>,
    from: VecDeque<(u64, u8)>,
    /// The line to the board is free from then on.
    free: u64,
    now: u64,
    look: u64,
}

impl Wire {
    /// A run begins at this cycle.
    pub fn new(job: Job, terms: FeedTerms, now: u64) -> Wire {
        Wire {
            feeder: StreamFeeder::new(terms, now / 16),
            job,
            to: VecDeque::new(),
            from: VecDeque::new(),
            free: 0,
            now,
            look: now,
        }
    }

    /// Whether the board has taken the end of the run.
    pub fn has_ended(&self) -> bool {
        self.feeder.has_ended()
    }

    /// The present, in cycles.
    pub fn now(&self) -> u64 {
        self.now
    }

    /// Bytes that are under way to the board.
    pub fn under_way(&self) -> usize {
        self.to.len()
    }

    /// How far the run is.
    pub fn feeder(&self) -> &StreamFeeder {
        &self.feeder
    }

    /// Takes back what was sent ahead: these steps come instead, none of which is sooner than it would
    /// have been. False while the board can't be told so.
    pub fn replan(&mut self, job: impl FnOnce(Cut) -> Job) -> bool {
        let cut = self.feeder.cut(self.now / 16, true);
        if let Some(cut) = cut {
            self.job = job(cut);
        }
        cut.is_some()
    }

    /// The board alone, until this cycle: what is under way arrives.
    pub fn pass(&mut self, board: &mut impl Target, cycle: u64) {
        while let Some((at, byte)) = self.to.front().copied()
            && at <= cycle
        {
            self.to.pop_front();
            board.run_until(at);
            board.receive(byte);
        }
        board.run_until(cycle);
        self.now = self.now.max(cycle);
    }

    /// The host feeds the board, until this cycle.
    pub fn feed(&mut self, board: &mut impl Target, cycle: u64) {
        while self.look <= cycle {
            let look = self.look;
            self.pass(board, look);
            self.look += LOOK;
            self.from.extend(board.said().into_iter().map(|byte| (look + MILLIS, byte)));
            let came = self.from.iter().take_while(|(at, _)| *at <= look).count();
            let heard: Vec<u8> = self.from.drain(..came).map(|(_, byte)| byte).collect();
            self.feeder.hear(&heard, look / 16);
            self.job.feed(&mut self.feeder);
            let bytes = self.feeder.bytes(look / 16);
            self.send(&bytes);
        }
        self.pass(board, cycle);
    }

    /// Bytes for the board, behind those that are under way.
    pub fn send(&mut self, bytes: &[u8]) {
        self.free = self.free.max(self.now);
        for byte in bytes {
            self.free += BYTE;
            self.to.push_back((self.free + MILLIS, *byte));
        }
    }

    /// Of what is under way this many bytes arrive, and no more.
    pub fn cut(&mut self, bytes: usize) {
        self.to.truncate(bytes);
        self.free = self.now;
    }
}

/// What a board says, without a host: the last credit, and lines of text.
#[derive(Default)]
pub struct Heard {
    reader: CreditReader,
    /// The last one.
    pub credit: Option<Credit>,
    /// Whether one of them said that the board is off the path.
    pub off: bool,
    text: Vec<u8>,
}

impl Heard {
    /// Takes what the board has said since.
    pub fn listen(&mut self, board: &mut impl Target) {
        for byte in board.said() {
            let (credit, off, text) = (&mut self.credit, &mut self.off, &mut self.text);
            self.reader.hear(byte, |told| match told {
                Answered::Credit(told) => {
                    *off |= told.is(Credit::OFF);
                    *credit = Some(told);
                }
                Answered::Text(byte) => text.push(byte),
            });
        }
    }

    /// Forgets the text, also what is no text but the end of a credit.
    pub fn forget(&mut self) {
        self.text.clear();
    }

    /// The line of text that is complete.
    pub fn line(&mut self) -> Option<String> {
        let end = self.text.iter().position(|byte| *byte == b'\r')?;
        let line = self.text.drain(..=end).collect::<Vec<u8>>();
        Some(String::from_utf8_lossy(&line[..end]).into_owned())
    }
}
