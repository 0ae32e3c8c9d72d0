#![forbid(unsafe_code)]
//! The host's half of a streamed run, without I/O.
//!
//! ```text
//!   steps ─► moments ─► records ─► frames ─► sender ─► bytes for the line
//!            an axis     by fit     in order   ▲
//!   what became of it ◄── credit ◄── bytes of the line
//! ```
//!
//! A [`StreamFeeder`] takes the steps of all axes in the order of their times, as long as it
//! [wants](StreamFeeder::wants) some. It returns bytes for the line, and takes the bytes of the board.
//! The caller's times are in µs from any origin.
//!
//! **Changes.** [`cut`](StreamFeeder::cut) takes back frames that were sent ahead, and returns the time from
//! which on other steps can come: some 35 ms later.

mod axis;
mod clock;
mod cut;
mod laser;
mod pace;
mod terms;

use std::collections::VecDeque;

use axis::{AxisFeed, AxisMark};
use clock::BoardClock;
pub use cut::Cut;
use cut::Cutting;
use laser::{LaserFeed, LaserMark};
use pace::Pace;
use stepwright_stream::credit::{Answered, Credit, CreditReader};
use stepwright_stream::frame::{Kind, MOST};
use stepwright_stream::pack::{DataBytes, FramePacker};
use stepwright_stream::record::{AXES, Trail};
use stepwright_stream::send::FrameSender;
pub use terms::FeedTerms;
use terms::fit_terms;

/// Converts ticks to 2⁻⁸ ticks.
const fn fine(ticks: u64) -> u64 {
    ticks << 8
}

/// From the start of the stream to the start of the path, in ticks.
const LEAD: u64 = 32_000;
/// The records of a frame start within this time, and a record of several steps lasts no longer, in µs.
const SPAN: u64 = 8_000;
/// After a cut this much of the new plan is sent before the rest is planned, in µs.
const FIRST: u64 = 150_000;
/// A change is over once the board has this much ahead again, in µs.
const ENOUGH: u64 = 150_000;
/// Tolerances of a step in ns, each for less than this many µs ahead of the board.
const SHORT: [(u64, u32); 2] = [(60_000, 25_000), (130_000, 10_000)];
/// A board without progress, or without any answer, for this long is lost, in µs.
const LOST: u64 = 3_000_000;
/// The most time between two looks at the line that counts as silence of the board, in µs.
const LOOK: u64 = 100_000;

/// The state of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedState {
    /// The feeder fills the board's FIFO.
    Filling,
    /// The board plays.
    Running,
    /// The board has made all steps, and all axes rest.
    Over,
    /// The board ran short of frames or heard nothing, and has braked: it is off the path.
    Off,
    /// An input has stopped the run, and the board has braked: it is off the path.
    Tripped,
    /// The board has refused a record.
    Wrong,
    /// The board does not answer.
    Lost,
}

impl FeedState {
    /// Whether the run is over, for good or bad.
    pub const fn is_end(self) -> bool {
        !matches!(self, FeedState::Filling | FeedState::Running)
    }
}

/// The beginning of a frame, and the state of all axes there.
#[derive(Clone, Debug)]
struct Mark {
    start: u64,
    /// The bytes of the FIFO that the frame takes, once it is complete.
    cost: u32,
    axes: [Option<AxisMark>; AXES],
    trails: [Trail; AXES],
    laser: LaserMark,
}

/// Feeds one run to a board.
#[derive(Debug)]
pub struct StreamFeeder {
    terms: FeedTerms,
    patience: u64,
    axes: [Option<AxisFeed>; AXES],
    laser: LaserFeed,
    packer: FramePacker,
    sender: FrameSender,
    reader: CreditReader,
    /// Frames that the sender does not have yet.
    frames: VecDeque<DataBytes>,
    /// The marks of all frames that the board has not opened, beginning with frame number `gone`. The last frame
    /// may be incomplete. Frames before number `offered` are with the sender.
    marks: VecDeque<Mark>,
    gone: u64,
    offered: u64,
    /// The start of the frame that the board opened last.
    played: u64,
    /// The time before which all steps are known.
    known: u64,
    /// The times of the steps, beginning with step number `dropped`.
    steps: VecDeque<u64>,
    dropped: u64,
    clock: BoardClock,
    /// A cut that the board has not taken yet.
    cutting: Option<Box<Cutting>>,
    pace: Pace,
    /// When the line was last looked at, and how long the board has been silent, in µs.
    looked: u64,
    silent: u64,
    /// Whether the last cut came too late; and how long before a frame is opened a cut is sent, in µs.
    late: bool,
    margin: u64,
    over: bool,
    state: FeedState,
    /// Free bytes of the FIFO before the start, once they are known.
    room: Option<u32>,
    ended: bool,
    /// The run begins with the steps that are known.
    begins: bool,
    /// The run does not begin yet.
    waits: bool,
    said: Vec<u8>,
    text: Vec<u8>,
}

impl StreamFeeder {
    /// Begins a run at `now`, in µs.
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
            laser: LaserFeed::default(),
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
            looked: now,
            silent: 0,
            late: false,
            margin: cut::MARGIN,
            over: false,
            state: FeedState::Filling,
            room: None,
            ended: false,
            begins: false,
            waits: false,
            said: Vec::new(),
            text: Vec::new(),
            patience: terms.patience(),
            terms,
        }
    }

    /// The state of the run.
    pub fn state(&self) -> FeedState {
        self.state
    }

    /// Whether the board has taken all of the run, its end too: it needs nothing more.
    pub fn has_ended(&self) -> bool {
        self.ended && self.sender.is_empty()
    }

    /// The number of retransmissions.
    pub fn again(&self) -> u64 {
        self.sender.again()
    }

    /// The time on the path up to which the board has opened frames, in s.
    pub fn time(&self) -> f64 {
        let lead = fine(LEAD);
        self.played.saturating_sub(lead) as f64 / self.units()
    }

    /// Whether the feeder wants more steps.
    pub fn wants(&self) -> bool {
        // After a cut the first part of the new plan is sent before the rest is planned.
        if let Some(end) = self.cutting.as_ref().and_then(|cutting| cutting.waits())
            && self.known >= end + fine(self.terms.ticks(FIRST))
        {
            return false;
        }
        let ahead = fine(self.terms.ticks(u64::from(self.terms.ahead) + 2 * SPAN));
        !self.over && self.known < self.played + ahead + self.patience
    }

    /// The time on the path where the board is, in s, by its last credit: the board may be some 8 ms farther.
    /// Before the path begins it is 0 or less.
    pub fn now(&self, now: u64) -> f64 {
        let at = self.clock.at(now).unwrap_or(0).saturating_sub(clock::SPAN);
        (at as f64 - fine(LEAD) as f64) / self.units()
    }

    /// 2⁻⁸ ticks per second.
    fn units(&self) -> f64 {
        256.0 * f64::from(self.terms.hz)
    }

    /// Adds the next step of an axis, at a time in s after the start of the path. Times must not decrease.
    /// Steps of an axis that does not take part are ignored.
    pub fn step(&mut self, axis: usize, time: f64, forward: bool) {
        self.know(time);
        let at = self.known;
        self.steps.push_back(at);
        if let Some(Some(axis)) = self.axes.get_mut(axis) {
            axis.step(at, forward);
        }
    }

    /// Sets the power of the laser from this time on, in s after the start of the path: 0, off, to 255. It is off
    /// at first and from the end on. Times must not decrease, and a change must be added before steps at
    /// later times, and before [`know`](StreamFeeder::know) of a later time. Without
    /// [`laser`](FeedTerms::laser) it is ignored.
    pub fn power(&mut self, time: f64, power: u8) {
        if self.terms.laser {
            let at = (time * self.units()).round() as u64 + fine(LEAD);
            self.laser.add(at, power);
        }
    }

    /// Promises that no step comes before this time, in s after the start of the path.
    pub fn know(&mut self, time: f64) {
        let at = (time * self.units()).round() as u64 + fine(LEAD);
        self.known = self.known.max(at);
    }

    /// Lets the board begin with the steps that are known now, though its FIFO has room for more: no more steps
    /// will be known for a while.
    pub fn begin(&mut self) {
        self.begins = true;
    }

    /// Keeps a run that has not begun from beginning, or lets it begin. Without effect on one that has begun.
    pub fn wait(&mut self, waits: bool) {
        self.waits = waits;
    }

    /// Ends the path at this time, in s: there are no more steps.
    pub fn end(&mut self, time: f64) {
        if !self.over {
            self.know(time);
            self.over = true;
            for axis in self.axes.iter_mut().flatten() {
                axis.end(self.known);
            }
            self.laser.end(self.known);
        }
    }

    /// Queues a text line, given without its end. [`hear`](StreamFeeder::hear) returns the answer.
    pub fn say(&mut self, line: &str) {
        self.said.extend(line.bytes());
        self.said.push(b'\r');
    }

    /// Takes bytes from the line. Returns the bytes that are text.
    pub fn hear(&mut self, bytes: &[u8], now: u64) -> Vec<u8> {
        let mut credits = Vec::new();
        for byte in bytes {
            self.reader.hear(*byte, |told| match told {
                Answered::Credit(credit) => credits.push(credit),
                Answered::Text(byte) => self.text.push(byte),
            });
        }
        if !credits.is_empty() {
            self.silent = 0;
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
            // Before the start opened frames only wait in the queues.
            if credit.is(Credit::STARTED) {
                self.clock.opened(self.played, now);
            }
            self.forget();
        }
        self.learn_of_cut(credit, now);
        // The credit is of another run until the board has taken the setup.
        if self.state.is_end() || self.sender.holds(Kind::Setup) {
            return;
        }
        let over = self.has_ended() && credit.is(Credit::STARTED) && !credit.is(Credit::MOVES);
        self.state = match self.state {
            _ if !credit.is(Credit::OFF) => match self.state {
                FeedState::Running if over => FeedState::Over,
                state => state,
            },
            _ if credit.is(Credit::WRONG) => FeedState::Wrong,
            _ if credit.is(Credit::TRIPPED) => FeedState::Tripped,
            _ => FeedState::Off,
        };
    }

    /// Drops moments and steps that no cut can take back any more.
    fn forget(&mut self) {
        if let Some(mark) = self.marks.front().filter(|_| self.cutting.is_none()) {
            for (axis, mark) in self.axes.iter_mut().zip(&mark.axes) {
                if let (Some(axis), Some(mark)) = (axis, mark) {
                    axis.forget(mark);
                }
            }
            self.laser.forget(&mark.laser);
            let old = mark.start.saturating_sub(fine(self.terms.ticks(2 * SPAN)));
            while self.steps.front().is_some_and(|asked| *asked < old) {
                self.steps.pop_front();
                self.dropped += 1;
            }
        }
    }

    /// Returns the bytes to send now. To be called after bytes came, and every millisecond.
    pub fn bytes(&mut self, now: u64) -> Vec<u8> {
        let mut bytes = Vec::new();
        if self.state.is_end() {
            bytes.append(&mut self.said);
            return bytes;
        }
        // A computer that was away for longer has looked for no answer meanwhile.
        self.silent += now.saturating_sub(self.looked).min(LOOK);
        self.looked = now;
        if self.sender.stuck(now) > LOST || self.silent > LOST {
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

    /// Makes frames of the known steps, as far ahead as may be sent. Returns false if more steps are needed
    /// first.
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
                self.pack_laser(self.known);
                self.frames.extend(self.packer.flush());
                return true;
            };
            if start > self.played + ahead {
                return true;
            }
            self.relax(start);
            let Some(axis) = &mut self.axes[n] else { return false };
            if self.known > start + patience {
                // Short waits, so that a place for a cut comes soon.
                for _ in 0..3 {
                    if !axis.is_known(2 * longest) {
                        axis.wait(self.known, longest);
                    }
                }
            }
            if !axis.is_known(2 * longest) {
                return false;
            }
            self.pack_laser(start);
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
                // The fitter makes no such record.
                Err(_) => self.state = FeedState::Wrong,
            }
        }
    }

    /// Packs the changes of the laser up to this time.
    fn pack_laser(&mut self, until: u64) {
        while self.terms.laser
            && let Some(record) = self.laser.due(until)
        {
            let mark = self.mark(record.at);
            self.laser.make(&record);
            let first = self.packer.is_empty();
            let frame = self.packer.add_power(record.wait, record.power, record.at);
            if first || frame.is_some() {
                self.marks.push_back(mark);
            }
            self.frames.extend(frame);
        }
    }

    /// The mark of a frame that starts at this time with the next record.
    fn mark(&self, start: u64) -> Mark {
        let axes = self.axes.each_ref().map(|axis| axis.as_ref().map(AxisFeed::mark));
        Mark { start, cost: 0, axes, trails: self.packer.trails(), laser: self.laser.mark() }
    }

    /// Notes that the sender has the next frame, which takes `cost` bytes of the FIFO.
    fn offered(&mut self, cost: u32) {
        if let Some(mark) = self.marks.get_mut((self.offered - self.gone) as usize) {
            mark.cost = cost;
        }
        self.offered += 1;
    }

    /// Whether the board has taken [`ENOUGH`] and no cut is under way.
    fn has_enough(&self) -> bool {
        let next = self.offered.saturating_sub(self.sender.data()).saturating_sub(self.gone);
        let taken = self.marks.get(next as usize).map_or(self.played, |mark| mark.start);
        !self.is_cutting() && taken >= self.played + fine(self.terms.ticks(ENOUGH))
    }

    /// Widens the tolerance while the board has little ahead: records are fewer then.
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

    /// Hands frames to the sender. The start is sent once the FIFO is full or holds all that may be ahead.
    /// Frames that do not fit wait until the board has played some.
    fn offer(&mut self, packed: bool, now: u64) {
        if self.state == FeedState::Filling {
            // The answer to the setup says how much room there is.
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
            let left =
                self.frames.front().is_some_and(|frame| frame.as_bytes().len() as u32 >= room);
            let begins = full && (self.frames.is_empty() || left);
            // The start is sent alone: before that the run can still be called off.
            if begins && !self.waits && self.sender.is_empty() {
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
