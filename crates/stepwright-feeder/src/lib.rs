#![forbid(unsafe_code)]
//! A host's half of a streamed run, without I/O.
//!
//! ```text
//!   steps ─► moments ─► records ─► frames ─► sender ─► bytes for the line
//!            an axis     by fit     in order   ▲
//!   what became of it ◄── credit ◄── bytes of the line
//! ```
//!
//! A [`StreamFeeder`] takes steps of all axes in the order of their times while it
//! [wants](StreamFeeder::wants) some, hands out bytes, and takes those of the board. Times are µs
//! from any beginning.
//!
//! **Changes.** What was sent ahead can be taken back: [`cut`](StreamFeeder::cut) tells from when on
//! other steps can come, some 35 ms later.

mod axis;
mod clock;
mod cut;
mod pace;

use std::collections::VecDeque;

use axis::{AxisFeed, AxisMark};
use clock::BoardClock;
pub use cut::Cut;
use cut::Cutting;
use pace::Pace;
use stepwright_stream::brake::BrakeLaw;
use stepwright_stream::credit::{Answered, Credit, CreditReader};
use stepwright_stream::fit::FitTerms;
use stepwright_stream::frame::{Kind, MOST};
use stepwright_stream::pack::{DataBytes, FramePacker};
use stepwright_stream::record::{AXES, Trail};
use stepwright_stream::send::{FrameSender, LinkTimes};

/// Ticks in 2⁻⁸ ticks.
const fn fine(ticks: u64) -> u64 {
    ticks << 8
}

/// How a run is fed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeedTerms {
    /// Ticks a second of the board's step timer.
    pub hz: u32,
    /// Steps keep to their times by this many ns, while there is enough ahead.
    pub tolerance: u32,
    /// No more is sent ahead of what the board plays than this, in µs. What its FIFO holds is the bound
    /// as well: some 0.3 s of three busy axes on an Uno, more than 1 s on a Mega.
    pub ahead: u32,
    /// Without a whole frame for this long the board brakes, in ms; 0 for never. At most 2,040.
    pub lease: u32,
    /// Axes that take part, a bit each. One that does not rests; one that has no steps costs a board
    /// time all the same.
    pub axes: u8,
    /// How each axis brakes.
    pub brakes: [BrakeLaw; AXES],
    /// Inputs that stop: see [`Kind::Start`].
    pub inputs: u8,
    /// Of these, the ones that stop when they open.
    pub high: u8,
    /// Axes come this many ticks after one another, so that equal ones do not step at once.
    pub stagger: u32,
    /// No wait is shorter than this many ticks.
    pub shortest: u32,
    /// The line's times.
    pub times: LinkTimes,
}

impl FeedTerms {
    /// For a board on an AVR, by a serial line of 115,200 baud.
    pub const fn avr(brakes: [BrakeLaw; AXES]) -> FeedTerms {
        FeedTerms {
            hz: 16_000_000,
            tolerance: 5_000,
            ahead: 300_000,
            lease: 1_000,
            axes: (1 << AXES) - 1,
            brakes,
            inputs: 0,
            high: 0,
            stagger: 75,
            shortest: 72,
            times: LinkTimes::of_baud(115_200),
        }
    }

    fn ticks(&self, micros: u64) -> u64 {
        micros * u64::from(self.hz) / 1_000_000
    }

    /// An axis without steps for this long is told to wait, in 2⁻⁸ ticks: it may rest then. A step
    /// that comes earlier has to be known, so that a board which hears nothing more makes it.
    fn patience(&self) -> u64 {
        let taking_part = (0..).zip(&self.brakes).filter(|(axis, _)| self.axes >> axis & 1 != 0);
        // One step behind an interval of 1/√(2a) an axis may rest: half the slowest one.
        let slowest = taking_part.map(|(_, law)| u64::from(law.slowest())).max().unwrap_or(0);
        fine(self.ticks(PATIENCE)).max(slowest / 2)
    }
}

/// From the start to the path's, in ticks.
const LEAD: u64 = 32_000;
/// A frame's records begin within this, and those of several steps take no longer, in µs.
const SPAN: u64 = 8_000;
/// An axis without steps for at least this long is told to wait, in µs.
const PATIENCE: u64 = 40_000;
/// Of what comes after a cut this much goes before all else is planned, in µs.
const FIRST: u64 = 150_000;
/// Behind a change, with this much ahead of the board, in µs, all is as before.
const ENOUGH: u64 = 150_000;
/// With less than this ahead, in µs, steps keep to their times less closely: by this many ns.
const SHORT: [(u64, u32); 2] = [(60_000, 25_000), (130_000, 10_000)];
/// Without progress for this long, in µs, the board is lost.
const LOST: u64 = 3_000_000;

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedState {
    /// The board's FIFO is being filled.
    Filling,
    /// It plays.
    Running,
    /// All steps were made, and all axes rest.
    Over,
    /// The board was short of frames, or heard nothing, and has braked: off the path.
    Off,
    /// An input has closed, and the board has braked: off the path.
    Tripped,
    /// The board has refused a record.
    Wrong,
    /// The board doesn't answer.
    Lost,
}

impl FeedState {
    /// Whether nothing more comes of it.
    pub const fn is_end(self) -> bool {
        !matches!(self, FeedState::Filling | FeedState::Running)
    }
}

/// The beginning of a frame: what led there.
#[derive(Clone, Debug)]
struct Mark {
    start: u64,
    /// Bytes of the FIFO that the frame takes, once it is whole.
    cost: u32,
    axes: [Option<AxisMark>; AXES],
    trails: [Trail; AXES],
}

/// Feeds a board.
#[derive(Debug)]
pub struct StreamFeeder {
    terms: FeedTerms,
    patience: u64,
    axes: [Option<AxisFeed>; AXES],
    packer: FramePacker,
    sender: FrameSender,
    reader: CreditReader,
    /// Frames that were not offered yet.
    frames: VecDeque<DataBytes>,
    /// Of all frames that the board has not opened, from frame number `gone` on: the last one may have
    /// been begun alone. Those before number `offered` are the sender's.
    marks: VecDeque<Mark>,
    gone: u64,
    offered: u64,
    /// When what the board opened last began.
    played: u64,
    /// All steps before this time are known.
    known: u64,
    /// When steps were asked for, from number `dropped` on.
    steps: VecDeque<u64>,
    dropped: u64,
    clock: BoardClock,
    /// A cut that the board has not taken yet.
    cutting: Option<Box<Cutting>>,
    pace: Pace,
    /// The last cut came too late; and how long before a frame is opened it is to come, in µs.
    late: bool,
    margin: u64,
    over: bool,
    state: FeedState,
    /// Bytes of the FIFO that are left before the start, once that is known.
    room: Option<u32>,
    ended: bool,
    /// It begins with what is there.
    begins: bool,
    said: Vec<u8>,
    text: Vec<u8>,
}

impl StreamFeeder {
    /// Begins a run now.
    pub fn new(terms: FeedTerms, now: u64) -> StreamFeeder {
        let mut sender = FrameSender::new(terms.times);
        let brakes: Vec<u8> = terms.brakes.iter().flat_map(|law| law.bytes()).collect();
        sender.offer(Kind::Setup, &brakes, now);
        let mut n = 0;
        let axes = [(); AXES].map(|()| {
            n += 1;
            let takes_part = terms.axes >> (n - 1) & 1 != 0;
            takes_part.then(|| {
                AxisFeed::new(
                    fit_terms(&terms, terms.tolerance, n - 1),
                    fine(u64::from(terms.stagger) * (n - 1)),
                )
            })
        });
        StreamFeeder {
            axes,
            packer: FramePacker::new(fine(terms.ticks(SPAN))),
            sender,
            reader: CreditReader::new(),
            frames: VecDeque::new(),
            marks: VecDeque::new(),
            gone: 0,
            offered: 0,
            played: 0,
            known: 0,
            steps: VecDeque::new(),
            dropped: 0,
            clock: BoardClock::new(terms.hz),
            cutting: None,
            pace: Pace::default(),
            late: false,
            margin: cut::MARGIN,
            over: false,
            state: FeedState::Filling,
            room: None,
            ended: false,
            begins: false,
            said: Vec::new(),
            text: Vec::new(),
            patience: terms.patience(),
            terms,
        }
    }

    /// How far it is.
    pub fn state(&self) -> FeedState {
        self.state
    }

    /// Whether the board has taken all of the run, its end too: it needs nothing more.
    pub fn has_ended(&self) -> bool {
        self.ended && self.sender.is_empty()
    }

    /// How often frames were sent again.
    pub fn again(&self) -> u64 {
        self.sender.again()
    }

    /// Seconds of the path that the board has opened.
    pub fn time(&self) -> f64 {
        let lead = fine(LEAD);
        self.played.saturating_sub(lead) as f64 / self.units()
    }

    /// Whether it wants more steps.
    pub fn wants(&self) -> bool {
        // Of what follows a cut the first part goes before all else is planned.
        if let Some(end) = self.cutting.as_ref().and_then(|cutting| cutting.waits())
            && self.known >= end + fine(self.terms.ticks(FIRST))
        {
            return false;
        }
        let ahead = fine(self.terms.ticks(u64::from(self.terms.ahead) + 2 * SPAN));
        !self.over && self.known < self.played + ahead + self.patience
    }

    /// Where on the path the board is, in s: by what it has told, so that it may be some 8 ms farther.
    /// Before it begins, 0 and less.
    pub fn now(&self, now: u64) -> f64 {
        let at = self.clock.at(now).unwrap_or(0).saturating_sub(clock::SPAN);
        (at as f64 - fine(LEAD) as f64) / self.units()
    }

    /// 2⁻⁸ ticks a second.
    fn units(&self) -> f64 {
        256.0 * f64::from(self.terms.hz)
    }

    /// The next step: of an axis, in s after the start of the path, forward or backward.
    /// Times never fall. Steps of an axis that takes no part are left out.
    pub fn step(&mut self, axis: usize, time: f64, forward: bool) {
        self.know(time);
        let at = self.known;
        self.steps.push_back(at);
        if let Some(Some(axis)) = self.axes.get_mut(axis) {
            axis.step(at, forward);
        }
    }

    /// No step comes before this time, in s.
    pub fn know(&mut self, time: f64) {
        let at = (time * self.units()).round() as u64 + fine(LEAD);
        self.known = self.known.max(at);
    }

    /// The board begins with what is known by now, though it has room for more: nothing more is known
    /// for a while.
    pub fn begin(&mut self) {
        self.begins = true;
    }

    /// There are no more steps: the path ends then, in s.
    pub fn end(&mut self, time: f64) {
        if !self.over {
            self.know(time);
            self.over = true;
            for axis in self.axes.iter_mut().flatten() {
                axis.end(self.known);
            }
        }
    }

    /// A text line to be said, without its end. Answers are [heard](StreamFeeder::hear).
    pub fn say(&mut self, line: &str) {
        self.said.extend(line.bytes());
        self.said.push(b'\r');
    }

    /// Takes bytes of the line. What is text comes back.
    pub fn hear(&mut self, bytes: &[u8], now: u64) -> Vec<u8> {
        let mut credits = Vec::new();
        for byte in bytes {
            self.reader.hear(*byte, |told| match told {
                Answered::Credit(credit) => credits.push(credit),
                Answered::Text(byte) => self.text.push(byte),
            });
        }
        for credit in credits {
            self.sender.hear(credit, now);
            self.learn(credit, now);
        }
        std::mem::take(&mut self.text)
    }

    fn learn(&mut self, credit: Credit, now: u64) {
        let before = self.gone;
        while self.gone < self.sender.opened()
            && let Some(mark) = self.marks.pop_front()
        {
            (self.gone, self.played) = (self.gone + 1, mark.start);
        }
        if self.gone != before {
            // The first ones wait in the queues for the start.
            if credit.is(Credit::STARTED) {
                self.clock.opened(self.played, now);
            }
            self.forget();
        }
        self.learn_of_cut(credit, now);
        // Of another run, until the setup was heard.
        let open = !self.sender.is_empty() && !credit.is(Credit::OFF);
        if self.state != FeedState::Running || open {
            return;
        }
        let started = credit.is(Credit::STARTED);
        self.state = match self.state {
            _ if started && credit.is(Credit::WRONG) => FeedState::Wrong,
            _ if started && credit.is(Credit::TRIPPED) => FeedState::Tripped,
            _ if started && credit.is(Credit::OFF) => FeedState::Off,
            _ if self.ended && started && !credit.is(Credit::MOVES) => FeedState::Over,
            state => state,
        };
    }

    /// What is kept for a cut is kept no longer than frames can be cut.
    fn forget(&mut self) {
        if let Some(mark) = self.marks.front().filter(|_| self.cutting.is_none()) {
            for (axis, mark) in self.axes.iter_mut().zip(&mark.axes) {
                if let (Some(axis), Some(mark)) = (axis, mark) {
                    axis.forget(mark);
                }
            }
            let old = mark.start.saturating_sub(fine(self.terms.ticks(2 * SPAN)));
            while self.steps.front().is_some_and(|asked| *asked < old) {
                self.steps.pop_front();
                self.dropped += 1;
            }
        }
    }

    /// Bytes for the line, as many as it should have now. To be asked whenever bytes came, and each
    /// millisecond.
    pub fn bytes(&mut self, now: u64) -> Vec<u8> {
        let mut bytes = Vec::new();
        if self.state.is_end() {
            bytes.append(&mut self.said);
            return bytes;
        }
        if self.sender.stuck(now) > LOST {
            self.state = FeedState::Lost;
        }
        let packed = self.pack();
        self.offer(packed, now);
        self.pace.changed &= !self.has_enough();
        self.sender.queue(self.pace.look(now, self.sender.again()));
        let mut frame = [0; MOST];
        loop {
            match self.sender.next(now, &mut frame) {
                0 => break,
                len => bytes.extend(&frame[..len]),
            }
        }
        bytes.append(&mut self.said);
        bytes
    }

    /// Makes frames of what is known, as far as they may be sent: whether that is all for now.
    fn pack(&mut self) -> bool {
        let ahead = fine(self.terms.ticks(u64::from(self.terms.ahead)));
        let longest = fine(self.terms.ticks(SPAN));
        let patience = self.patience;
        loop {
            let Some((n, start)) = self
                .axes
                .iter()
                .enumerate()
                .filter_map(|(n, axis)| Some((n, axis.as_ref().filter(|axis| !axis.is_over())?)))
                .map(|(n, axis)| (n, axis.start()))
                .min_by_key(|(_, start)| *start)
            else {
                self.frames.extend(self.packer.flush());
                return true;
            };
            if start > self.played + ahead {
                return true;
            }
            self.relax(start);
            let Some(axis) = &mut self.axes[n] else { return false };
            if self.known > start + patience {
                // Short ones, so that there is soon a place for a cut.
                for _ in 0..3 {
                    if !axis.is_known(2 * longest) {
                        axis.wait(self.known, longest);
                    }
                }
            }
            if !axis.is_known(2 * longest) {
                return false;
            }
            let mark = self.mark(start);
            let Some(record) = self.axes[n].as_mut().and_then(AxisFeed::record) else {
                return false;
            };
            let first = self.packer.is_empty();
            match self.packer.add(n as u8, &record, start) {
                Ok(frame) => {
                    if first || frame.is_some() {
                        self.marks.push_back(mark);
                    }
                    self.frames.extend(frame);
                }
                // The fitter makes none.
                Err(_) => self.state = FeedState::Wrong,
            }
        }
    }

    /// Where all has come to, if the next frame starts then.
    fn mark(&self, start: u64) -> Mark {
        let axes = self.axes.each_ref().map(|axis| axis.as_ref().map(AxisFeed::mark));
        Mark { start, cost: 0, axes, trails: self.packer.trails() }
    }

    /// A frame is the sender's now, and takes this much of the FIFO.
    fn offered(&mut self, cost: u32) {
        if let Some(mark) = self.marks.get_mut((self.offered - self.gone) as usize) {
            mark.cost = cost;
        }
        self.offered += 1;
    }

    /// Whether the board has taken enough to be left alone for a while.
    fn has_enough(&self) -> bool {
        let next = self.offered.saturating_sub(self.sender.data()).saturating_sub(self.gone);
        let taken = self.marks.get(next as usize).map_or(self.played, |mark| mark.start);
        !self.is_cutting() && taken >= self.played + fine(self.terms.ticks(ENOUGH))
    }

    /// With little ahead of the board, records keep to their steps less closely, and are fewer.
    fn relax(&mut self, start: u64) {
        let ahead = start.saturating_sub(self.played);
        let short = SHORT.iter().find(|(most, _)| {
            self.state == FeedState::Running && ahead < fine(self.terms.ticks(*most))
        });
        let tolerance = short.map_or(self.terms.tolerance, |(_, ns)| self.terms.tolerance.max(*ns));
        for (n, axis) in (0..).zip(&mut self.axes) {
            if let Some(axis) = axis {
                axis.set_terms(fit_terms(&self.terms, tolerance, n));
            }
        }
    }

    /// Hands frames to the sender. All axes begin when the FIFO is full, or has all that is to be
    /// ahead: what does not fit waits until some has been played.
    fn offer(&mut self, packed: bool, now: u64) {
        if self.state == FeedState::Filling {
            // The answer to the setup tells how much there is room for.
            if self.room.is_none() && self.sender.is_empty() {
                self.room = Some(self.sender.free());
            }
            let Some(mut room) = self.room else { return };
            let mut full = packed || self.begins;
            while self.sender.has_room()
                && let Some(frame) = self.frames.front()
            {
                let cost = frame.as_bytes().len() as u32 + 1;
                full |= cost > room;
                if full && cost > room {
                    break;
                }
                room -= cost;
                self.room = Some(room);
                self.sender.offer(Kind::Data, frame.as_bytes(), now);
                self.frames.pop_front();
                self.offered(cost);
            }
            let waits =
                self.frames.front().is_some_and(|frame| frame.as_bytes().len() as u32 >= room);
            if full && (self.frames.is_empty() || waits) && self.sender.has_room() {
                let lease = (self.terms.lease / 8).min(255) as u8;
                let axes = self.terms.axes & ((1 << AXES) - 1);
                let payload = [axes, lease, self.terms.inputs, self.terms.high];
                self.sender.offer(Kind::Start, &payload, now);
                self.state = FeedState::Running;
            }
            return;
        }
        if !self.offer_cut(packed, now) {
            return;
        }
        while self.sender.has_room()
            && let Some(frame) = self.frames.pop_front()
        {
            self.sender.offer(Kind::Data, frame.as_bytes(), now);
            self.offered(frame.as_bytes().len() as u32 + 1);
        }
        let all = self.frames.is_empty() && self.axes.iter().flatten().all(AxisFeed::is_over);
        if all && packed && !self.ended && self.sender.has_room() {
            self.ended = self.sender.offer(Kind::End, &[], now);
        }
    }
}

fn fit_terms(terms: &FeedTerms, tolerance: u32, axis: u64) -> FitTerms {
    let hz = u64::from(terms.hz);
    // From there on an axis may rest at once.
    let slowest = terms.brakes.get(axis as usize).map_or(0, |brake| brake.slowest());
    FitTerms {
        patience: slowest.max(fine(terms.ticks(2 * SPAN)) as u32),
        tolerance: (u64::from(tolerance) * hz * 256 / 1_000_000_000) as u32,
        longest: fine(terms.ticks(SPAN)) as u32,
        shortest: terms.shortest,
    }
}
