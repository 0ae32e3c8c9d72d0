//! The board's half of a streamed run: frames come in, entries go to the queues of the axes, and the axes
//! brake when entries are missing.
//!
//! ```text
//!           setup            start                end, and all played
//!   empty ────────► filled ─────────► running ─────────────────────────► at rest
//!     ▲                                  │ silence, dry, stop, a wrong record
//!     │ setup, at rest                   ▼
//!     └─────────────── off the path ◄─ braking
//! ```
//!
//! **When a frame is opened.** The gate of a frame says when its first record starts. The player opens the
//! frame about [`AHEAD`] before that, so that the queues of all axes end at about the same time, and a hold
//! finds everything later still in the FIFO.
//!
//! **When the axes brake.** If an axis that moves has at most one entry waiting, or one that rests has none, while the
//! FIFO is empty and no end has come (or an axis is at speed at the end); or if no whole frame came for the lease. Each axis
//! then continues from its last entry by its own [`BrakeLaw`] until it rests. The player refuses all frames
//! until the next setup.

use stepwright::drive::Axes;
use stepwright::entry::Wiring;
use stepwright::queue::Producer;
use stepwright::{Control, Ticks};

use crate::brake::{BrakeLaw, Braking};
use crate::credit::Credit;
use crate::frame::Kind;
use crate::link::{Came, FrameLink};
use crate::power::{self, PowerQueue, UNIT_BITS};
use crate::record::{self, AXES, NOTHING, RecordAct, Trail};

/// How long before its first record starts a frame is opened, in 2¹⁶ ticks: this, and up to one more.
pub const AHEAD: i16 = 3;
/// A gate that seems to be this far after the last one, or farther, is before it, in 2¹⁶ ticks.
const BEFORE: u8 = 0xC0;
/// The most records decoded in one call of `poll`.
const PIECE: u8 = 3;
/// The most entries of a braking axis that wait in its queue.
const BRAKES: u8 = 4;
/// Milliseconds in one unit of the lease.
const LEASE: u8 = 8;

/// The state of one axis.
#[derive(Debug)]
struct Lane {
    trail: Trail,
    /// The axis faces backward. A stream begins forward, so the first record has to turn DIR.
    turns: bool,
    law: BrakeLaw,
    braking: Braking,
}

impl Lane {
    const NONE: Lane =
        Lane { trail: Trail::NONE, turns: false, law: BrakeLaw::NONE, braking: Braking::NONE };
}

/// Plays a stream on a board. The queue of each axis holds `Q` entries, the FIFO `LEN` bytes of frames.
pub struct StreamPlayer<'q, E, const Q: usize, const LEN: usize> {
    engine: E,
    feeds: [Producer<'q, Q>; AXES],
    wirings: [Wiring; AXES],
    least: Ticks,
    link: FrameLink<LEN>,
    lanes: [Lane; AXES],
    laser: PowerQueue,
    /// The number of the next frame.
    expected: u8,
    /// The number of data frames opened, modulo 256.
    opened: u8,
    /// Bytes left of the open frame.
    left: u8,
    /// Flags of [`Credit`].
    flags: u8,
    set_up: bool,
    ended: bool,
    /// Nothing is left to be queued.
    closed: bool,
    owes: bool,
    /// The time since the last whole frame in units of 8 ms, and ms of the present unit.
    quiet: u8,
    millis: u8,
    lease: u8,
    /// The inputs that stop; those among them that stop when they open; and whether one was active at the
    /// last look.
    watched: u8,
    high: u8,
    closing: bool,
    /// The 2¹⁶ ticks since the start, the gate of the last opened frame in the same count, and the last
    /// reading of the timer.
    epoch: u16,
    gate: u16,
    seen: u16,
    /// Axes of unknown position: they were stopped at once while they moved, or by a reset.
    unknown: Axes,
}

impl<'q, E: Control, const Q: usize, const LEN: usize> StreamPlayer<'q, E, Q, LEN> {
    /// A player for axes that rest. A record with a wait shorter than `least` ticks is refused.
    pub const fn new(
        engine: E,
        feeds: [Producer<'q, Q>; AXES],
        wirings: [Wiring; AXES],
        least: Ticks,
    ) -> StreamPlayer<'q, E, Q, LEN> {
        StreamPlayer {
            engine,
            feeds,
            wirings,
            least,
            link: FrameLink::new(),
            lanes: [Lane::NONE; AXES],
            laser: PowerQueue::NONE,
            expected: 0,
            opened: 0,
            left: 0,
            flags: 0,
            set_up: false,
            ended: false,
            closed: true,
            owes: false,
            quiet: 0,
            millis: 0,
            lease: 0,
            watched: 0,
            high: 0,
            closing: false,
            epoch: 0,
            gate: 0,
            seen: 0,
            unknown: 0,
        }
    }

    /// The engine.
    pub fn engine(&mut self) -> &mut E {
        &mut self.engine
    }

    /// The queues of the axes, for a board that lends them after the player has its final address.
    pub fn feeds(&mut self) -> &mut [Producer<'q, Q>; AXES] {
        &mut self.feeds
    }

    /// Whether an axis moves or waits for its next entry.
    pub fn is_busy(&self) -> bool {
        (0..AXES as u8).any(|axis| !self.engine.is_idle(axis))
    }

    /// The position of an axis in steps; `None` if it is unknown.
    pub fn position(&self, axis: u8) -> Option<i64> {
        (self.unknown >> axis & 1 == 0).then(|| self.engine.position(axis))
    }

    /// Makes the present position of an axis 0. An axis that moves is left alone.
    pub fn set_zero(&mut self, axis: u8) {
        if self.engine.is_idle(axis) {
            self.engine.set_position(axis, 0);
            self.unknown &= !(1 << axis);
        }
    }

    /// Makes all positions unknown, as after a reset in motion.
    pub fn mark_unknown(&mut self) {
        self.unknown = (1 << AXES) - 1;
    }

    /// The present power of a laser: 0, off, to 255. It is off whenever the axes rest before and after a run, and
    /// once the board has left the path.
    #[inline(always)]
    pub const fn laser(&self) -> u8 {
        self.laser.power()
    }

    /// The state of the stream, as it is told to the host.
    pub fn credit(&mut self) -> Credit {
        let mut flags = self.flags;
        if self.link.is_deaf() {
            flags |= Credit::DEAF;
        }
        if self.is_busy() {
            flags |= Credit::MOVES;
        }
        let free = (self.link.fifo().free() >> 3).min(255) as u8;
        Credit { next: self.expected, opened: self.opened, free, flags }
    }

    /// The answer that is due to the host now; returned once.
    #[inline(always)]
    pub fn answer(&mut self) -> Option<Credit> {
        if !self.owes {
            return None;
        }
        self.owes = false;
        Some(self.credit())
    }

    /// Takes a byte from the line; `None` stands for a damaged byte. Frames are obeyed here and never returned.
    #[inline(always)]
    pub fn hear(&mut self, byte: Option<u8>) -> Came {
        match self.link.hear(byte) {
            Came::Frame(kind, number) => {
                self.accept(kind, number);
                Came::Nothing
            }
            came => {
                self.owes |= came == Came::Broken;
                came
            }
        }
    }

    /// Obeys a complete frame.
    #[inline(never)]
    fn accept(&mut self, kind: Kind, number: u8) {
        (self.owes, self.quiet) = (true, 0);
        match kind {
            Kind::Ping => return,
            Kind::Setup => {
                if self.is_busy() || !self.closed {
                    return;
                }
                self.begin();
                self.expected = number;
            }
            _ if number != self.expected || self.is_off() => return,
            Kind::Data => {
                if self.ended || !self.link.data() {
                    return;
                }
            }
            Kind::Start => self.start(),
            Kind::Cut => {
                if !self.cut() {
                    return;
                }
            }
            Kind::End => self.ended = true,
        }
        self.expected = self.expected.wrapping_add(1);
    }

    /// Forgets the data frames from the named one on, and puts the data of the cut in their place. False, and
    /// the cut is not taken, if the named frame is open already, if nothing plays any more, or without room.
    #[inline(never)]
    fn cut(&mut self) -> bool {
        let len = self.link.small_len();
        let mut bytes = *self.link.small();
        let frames = bytes[0].wrapping_sub(self.opened);
        if frames >= 0x80 || self.closed && self.flags & Credit::STARTED != 0 {
            return false;
        }
        // A cut without data may end as a frame of data may.
        let bare = len <= 1 || len == 2 && bytes[1] == NOTHING;
        let fifo = self.link.fifo();
        let mut keep = u16::from(self.left);
        for _ in 0..frames {
            if keep >= fifo.used() {
                break;
            }
            keep = keep.wrapping_add(1).wrapping_add(fifo.peek(keep).into());
        }
        if !bare && keep.wrapping_add(len.into()) > LEN as u16 {
            return false;
        }
        fifo.cut(keep);
        self.ended = false;
        if bare {
            return true;
        }
        // In the FIFO a data frame begins with its length.
        bytes[0] = len.wrapping_sub(1);
        for byte in bytes.iter().take(len.into()) {
            fifo.write(*byte);
        }
        fifo.commit()
    }

    const fn is_off(&self) -> bool {
        self.flags & Credit::OFF != 0
    }

    fn begin(&mut self) {
        self.set_up = true;
        self.link.fifo().cut(0);
        self.laser.off();
        // Entries of a stream that was set up but never started are still in the queues.
        self.engine.kill((1 << AXES) - 1);
        let mut bytes = self.link.small().iter().copied();
        for (axis, lane) in (0..).zip(&mut self.lanes) {
            let mut law = [0; BrakeLaw::LEN];
            law.fill_with(|| bytes.next().unwrap_or(0));
            let turns = !self.engine.is_forward(axis);
            *lane = Lane { turns, law: BrakeLaw::from_bytes(law), ..Lane::NONE };
        }
        (self.opened, self.left, self.flags, self.lease) = (0, 0, 0, 0);
        (self.epoch, self.gate) = (0, 0);
        (self.ended, self.closed) = (false, true);
    }

    fn start(&mut self) {
        if self.flags & Credit::STARTED != 0 {
            return;
        }
        let [axes, lease, watched, high, ..] = *self.link.small();
        (self.lease, self.watched, self.high, self.closing) = (lease, watched, high, false);
        self.flags |= Credit::STARTED;
        self.closed = false;
        self.laser.start(units(self.epoch, self.seen));
        for (axis, feed) in self.feeds.iter_mut().enumerate() {
            if axes >> axis & 1 != 0 {
                feed.set_open(true);
            }
        }
        self.engine.start(axes & ((1 << AXES) - 1));
    }

    /// Whether a setup has come: the drivers are to be on from then on.
    pub const fn is_set_up(&self) -> bool {
        self.set_up
    }

    /// Whether an axis may move: from a setup until all that came after it has been played.
    pub fn may_move(&self) -> bool {
        let over = self.closed && self.flags & (Credit::STARTED | Credit::OFF) != 0;
        self.set_up && (!over || self.is_busy())
    }

    /// Notes that a millisecond has passed, and the inputs that are closed. A [watched](Kind::Start) input
    /// that is active twice in a row makes all axes brake.
    pub fn tick(&mut self, inputs: u8) {
        let closed = (inputs ^ self.high) & self.watched != 0;
        if closed && self.closing && !self.closed && !self.is_off() {
            self.flags |= Credit::TRIPPED;
            self.stop();
        }
        self.closing = closed;
        self.millis = self.millis.wrapping_add(1);
        if self.millis >= LEASE {
            self.millis = 0;
            self.quiet = self.quiet.saturating_add(1);
        }
    }

    /// Decodes some records, or continues braking. `now` is the step timer, or its lower 16 bits. To be called
    /// as often as possible, at least every 2¹⁵ ticks.
    #[inline(never)]
    pub fn poll(&mut self, now: u16) {
        let started = self.flags & Credit::STARTED != 0;
        if started && now < self.seen {
            self.epoch = self.epoch.wrapping_add(1);
        }
        self.seen = now;
        if started {
            self.laser.pass(units(self.epoch, now));
        }
        if self.closed && started {
            // The axes may still play what is queued.
            if self.laser.power() != 0 && !self.is_busy() {
                self.laser.off();
            }
            return;
        }
        if started && self.lease != 0 && self.quiet >= self.lease && !self.ended && !self.is_off() {
            self.stop();
        }
        let mut did = false;
        for _ in 0..PIECE {
            if !self.record() {
                break;
            }
            did = true;
        }
        if !started {
            return;
        }
        if !did && self.link.fifo().used() == 0 {
            did = self.dry();
        }
        if did {
            self.engine.refill();
        }
    }

    /// Stops along the brakes: forgets the FIFO, plays the queued entries, then brakes all axes. A stream that
    /// has not started does not start any more.
    pub fn stop(&mut self) {
        let filled = self.set_up && self.flags & (Credit::STARTED | Credit::OFF) == 0;
        if self.is_off() || self.closed && !filled {
            return;
        }
        self.link.fifo().forget();
        self.left = 0;
        self.go_off();
    }

    /// Stops all axes at once. The position of an axis that moved is unknown from then on.
    pub fn kill(&mut self) {
        self.link.fifo().forget();
        self.left = 0;
        // No credit tells of it: whoever kills from a terminal waits for text alone.
        self.flags |= Credit::OFF;
        self.closed = true;
        self.laser.off();
        for axis in 0..AXES as u8 {
            if !self.engine.is_idle(axis) {
                self.unknown |= 1 << axis;
            }
        }
        self.engine.kill((1 << AXES) - 1);
    }

    /// Leaves the path: from now on each axis brakes by itself.
    fn go_off(&mut self) {
        self.flags |= Credit::OFF;
        self.owes = true;
        self.laser.off();
        for lane in &mut self.lanes {
            lane.braking = Braking::from(&lane.trail);
        }
    }

    /// Opens the next frame or decodes the next record, if its time has come and its queue has room. Returns
    /// whether it did.
    #[inline(never)]
    fn record(&mut self) -> bool {
        let fifo = self.link.fifo();
        if self.left == 0 {
            if fifo.used() == 0 {
                return false;
            }
            let len = fifo.peek(0);
            if len != 0 {
                // A gate is modulo 256: the one closest to the last gate is meant.
                let behind = fifo.peek(1).wrapping_sub(self.gate as u8);
                let back = if behind >= BEFORE { 256 } else { 0 };
                let gate = self.gate.wrapping_add(behind.into()).wrapping_sub(back);
                if gate.wrapping_sub(self.epoch) as i16 > AHEAD {
                    return false;
                }
                self.gate = gate;
                fifo.read();
            }
            fifo.read();
            self.left = len.saturating_sub(1);
            self.opened = self.opened.wrapping_add(1);
            self.owes |= self.left == 0;
            return true;
        }
        let head = fifo.peek(0);
        let Some(axis) = record::axis_of(head) else {
            if power::is_power(head) {
                return self.power_change();
            }
            fifo.read();
            self.left = self.left.wrapping_sub(1);
            self.owes |= self.left == 0;
            return true;
        };
        let n = usize::from(axis);
        let (Some(lane), Some(feed), Some(wiring)) =
            (self.lanes.get_mut(n), self.feeds.get_mut(n), self.wirings.get(n))
        else {
            return false;
        };
        if feed.waiting() >= Q as u8 {
            return false;
        }
        let before = fifo.used();
        fifo.read();
        let mut record = record::decode(head, &mut lane.trail, || fifo.read());
        let took = before.wrapping_sub(fifo.used()) as u8;
        if let RecordAct::Wait { turn, .. } = &mut record.act {
            *turn ^= core::mem::replace(&mut lane.turns, false);
        }
        if took > self.left || lane.turns || !record.is_playable(self.least) {
            lane.trail.moves = false;
            self.flags |= Credit::WRONG;
            self.stop();
            return true;
        }
        feed.put(record.entry(*wiring));
        self.left = self.left.wrapping_sub(took);
        self.owes |= self.left == 0;
        true
    }

    /// Decodes a change of the laser's power, if there is room for it.
    #[inline(never)]
    fn power_change(&mut self) -> bool {
        if !self.laser.has_room() {
            return false;
        }
        let Some(left) = self.left.checked_sub(power::LEN as u8) else {
            self.flags |= Credit::WRONG;
            self.stop();
            return true;
        };
        let fifo = self.link.fifo();
        let (wait, power) = power::decode([fifo.read(), fifo.read(), fifo.read()]);
        self.laser.put(wait, power);
        self.left = left;
        self.owes |= left == 0;
        true
    }

    /// Handles an empty FIFO: ends the stream, or brakes. Returns whether entries were queued or all is done.
    #[inline(never)]
    fn dry(&mut self) -> bool {
        if !self.is_off() {
            // An end while an axis is at speed is no end: the axis brakes as if the host were silent.
            if self.ended && !self.lanes.iter().any(|lane| lane.trail.moves) {
                for feed in &mut self.feeds {
                    feed.set_open(false);
                }
                self.closed = true;
                return true;
            }
            let mut low = false;
            for (axis, (lane, feed)) in (0u8..).zip(self.lanes.iter().zip(&self.feeds)) {
                low |= lane.trail.moves && feed.waiting() <= 1;
                // The wait of an axis that rests ends, and its next step would be late.
                low |= feed.is_empty() && !self.engine.is_idle(axis);
            }
            if !low {
                return false;
            }
            self.go_off();
        }
        let (mut did, mut rest) = (false, true);
        let lanes = self.lanes.iter_mut().zip(&mut self.feeds).zip(&self.wirings);
        for ((lane, feed), wiring) in lanes {
            if feed.waiting() >= BRAKES {
                rest = false;
            } else if let Some(record) = lane.braking.next(lane.law) {
                feed.put(record.entry(*wiring));
                (did, rest) = (true, false);
            } else {
                feed.set_open(false);
            }
        }
        self.closed = rest;
        did | rest
    }
}

/// The time of the step timer in units of a change of the power.
#[inline(always)]
const fn units(epoch: u16, now: u16) -> u16 {
    epoch.wrapping_shl(16 - UNIT_BITS) | now >> UNIT_BITS
}
