//! The host's end of the link: sends frames, and sends them again until the board has taken them.
//!
//! Up to [`WINDOW`] frames are under way. The data frames among them never have more bytes than the board's
//! FIFO had free by its last credit. The queue before the wire is short, so that urgent frames wait for
//! little: [`QUEUED`] µs of bytes, or as many as [`queue`](FrameSender::queue) says. If the board is deaf, or
//! nothing has gone forward for some time, four [`FILL`] call the board, and all frames that it has not taken
//! are sent again.

use crate::credit::Credit;
use crate::frame::{CUT, FILL, FrameBytes, Kind, LONGEST, MOST};
use crate::record::NOTHING;

/// The most frames under way.
pub const WINDOW: usize = 16;
/// The usual queue before the wire, in µs of bytes.
pub const QUEUED: u64 = 3_000;

/// A frame that the board has not taken yet.
#[derive(Clone, Copy, Debug)]
struct Held {
    kind: Kind,
    bytes: [u8; LONGEST],
    len: u8,
    /// The bytes of the FIFO that a cut frees.
    frees: u32,
}

impl Held {
    const NONE: Held = Held { kind: Kind::Ping, bytes: [0; LONGEST], len: 0, frees: 0 };

    /// The bytes of the FIFO that the frame takes.
    fn cost(&self) -> u32 {
        match self.kind {
            Kind::Data => u32::from(self.len).wrapping_add(1),
            // The cut's number takes no byte of the FIFO, the length of its data takes one.
            Kind::Cut if self.len > 1 => self.len.into(),
            _ => 0,
        }
    }

    /// The bytes taken after this frame, if the frames before it take `taken`.
    fn behind(&self, taken: i32) -> i32 {
        taken.saturating_sub_unsigned(self.frees).saturating_add_unsigned(self.cost())
    }

    fn frame(&self, number: u8) -> FrameBytes {
        let payload = self.bytes.get(..usize::from(self.len)).unwrap_or(&[]);
        let frame = FrameBytes::new(self.kind, number, payload);
        if !frame.is_barred() {
            return frame;
        }
        let mut longer = *self;
        if let Some(place) = longer.bytes.get_mut(usize::from(self.len)) {
            (*place, longer.len) = (NOTHING, self.len.wrapping_add(1));
        }
        let payload = longer.bytes.get(..usize::from(longer.len)).unwrap_or(&[]);
        FrameBytes::new(self.kind, number, payload)
    }
}

/// The times of a link, in µs where no other unit is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LinkTimes {
    /// The time of a byte on the wire, in ns.
    pub byte: u32,
    /// All frames are sent again after this long without progress.
    pub again: u64,
    /// The time between two calls of a deaf board.
    pub call: u64,
    /// The time from the last byte to a ping.
    pub ping: u64,
}

impl LinkTimes {
    /// The times of a computer's serial line at this baud rate, with 10 bits per byte.
    ///
    /// ```
    /// use stepwright_stream::send::LinkTimes;
    /// let times = LinkTimes::of_baud(115_200);
    /// assert_eq!((times.byte, times.again, times.call), (86_805, 30_000, 6_000));
    /// // Of a slow line a frame takes longer: 64 bytes at 9,600 baud take 67 ms.
    /// assert_eq!(LinkTimes::of_baud(9_600).again, 266_666);
    /// ```
    pub const fn of_baud(baud: u32) -> LinkTimes {
        let byte = 10_000_000_000 / if baud == 0 { 1 } else { baud as u64 };
        // Four of the longest frames; a call and its answer.
        let (frames, call) = (byte * (4 * MOST as u64) / 1_000, byte * 16 / 1_000);
        let again = if frames > 30_000 { frames } else { 30_000 };
        let call = if call > 6_000 { call } else { 6_000 };
        let byte = if byte > u32::MAX as u64 { u32::MAX } else { byte as u32 };
        LinkTimes { byte, again, call, ping: 100_000 }
    }
}

/// Sends frames until the board has taken them. It does no I/O. Times are in µs from any origin.
#[derive(Clone, Debug)]
pub struct FrameSender {
    times: LinkTimes,
    held: [Held; WINDOW],
    /// The number of frames held, and of those sent since the last call.
    have: u8,
    sent: u8,
    /// The number of held frames that were sent at any time.
    high: u8,
    /// The sequence number of the first held frame.
    base: u8,
    /// Free bytes of the FIFO before the first held frame.
    free: u32,
    opened: u64,
    flags: u8,
    /// Whether the board must be called.
    calls: bool,
    /// Whether a ping is unanswered.
    pinged: bool,
    /// When the wire has sent everything, in ns; and the longest queue before it, in µs of bytes.
    wire: u64,
    queued: u64,
    /// The times of the last progress, the last call, and the last bytes sent.
    forward: u64,
    called: u64,
    said: u64,
    again: u64,
}

impl FrameSender {
    /// A sender with nothing under way. Its first frame must be a [`Setup`](Kind::Setup); it has number 0.
    pub const fn new(times: LinkTimes) -> FrameSender {
        FrameSender {
            times,
            held: [Held::NONE; WINDOW],
            have: 0,
            sent: 0,
            high: 0,
            base: 0,
            free: 0,
            opened: 0,
            flags: 0,
            calls: true,
            pinged: false,
            wire: 0,
            queued: QUEUED,
            forward: 0,
            called: 0,
            said: 0,
            again: 0,
        }
    }

    /// Whether another frame may be [offered](FrameSender::offer).
    pub fn has_room(&self) -> bool {
        usize::from(self.have) < WINDOW
    }

    /// Whether the board has taken all frames.
    pub fn is_empty(&self) -> bool {
        self.have == 0
    }

    /// The number of data frames that the board has opened.
    pub fn opened(&self) -> u64 {
        self.opened
    }

    /// The flags of the board's last [`Credit`].
    pub fn flags(&self) -> u8 {
        self.flags
    }

    /// Free bytes of the FIFO after all frames that the board has taken, by its last credit.
    pub fn free(&self) -> u32 {
        self.free
    }

    /// The number of times that all frames were sent again.
    pub fn again(&self) -> u64 {
        self.again
    }

    /// The time since the last progress, in µs; 0 if nothing is under way.
    pub fn stuck(&self, now: u64) -> u64 {
        if self.have == 0 { 0 } else { now.saturating_sub(self.forward) }
    }

    /// Sets the longest queue before the wire, in µs of bytes. A longer queue bridges the pauses of a busy
    /// computer, and delays urgent frames.
    pub fn queue(&mut self, micros: u64) {
        self.queued = micros;
    }

    /// The queue before the wire, in µs of bytes.
    pub fn waiting(&self, now: u64) -> u64 {
        self.wire.saturating_sub(now.saturating_mul(1_000)) / 1_000
    }

    /// The number of data frames, and of cuts with data, that the board has not taken.
    pub fn data(&self) -> u64 {
        self.held.iter().take(self.have.into()).filter(|held| held.cost() != 0).count() as u64
    }

    /// Hands over the next frame; false if there is no room or the payload is too long.
    pub fn offer(&mut self, kind: Kind, payload: &[u8], now: u64) -> bool {
        let mut held = Held { kind, len: payload.len() as u8, ..Held::NONE };
        let (Some(to), Some(place)) =
            (held.bytes.get_mut(..payload.len()), self.held.get_mut(usize::from(self.have)))
        else {
            return false;
        };
        to.copy_from_slice(payload);
        *place = held;
        if self.have == 0 {
            self.forward = now;
        }
        self.have = self.have.wrapping_add(1);
        true
    }

    /// Hands over a [cut](Kind::Cut) as the next frame. Data frames before number `keep` stay. At most [`CUT`]
    /// bytes of data replace the other frames, which take `frees` bytes of the FIFO. False if there is no
    /// room.
    pub fn offer_cut(&mut self, keep: u64, data: &[u8], frees: u32, now: u64) -> bool {
        let mut payload = [keep as u8; CUT + 1];
        let len = data.len().wrapping_add(1);
        let (Some(to), Some(_)) = (payload.get_mut(1..len), self.held.get(usize::from(self.have)))
        else {
            return false;
        };
        to.copy_from_slice(data);
        let offered = self.offer(Kind::Cut, payload.get(..len).unwrap_or(&[]), now);
        let last = self.held.get_mut(usize::from(self.have.wrapping_sub(1)));
        if offered && let Some(held) = last {
            held.frees = frees;
        }
        offered
    }

    /// Drops the frames that were never sent. Returns the number of data frames among them, and whether the
    /// end was among them.
    pub fn retract(&mut self) -> (u64, bool) {
        let of = |kind: Kind| {
            let unsent = self.held.iter().take(self.have.into()).skip(self.high.into());
            unsent.filter(|held| held.kind == kind).count() as u64
        };
        let dropped = (of(Kind::Data), of(Kind::End) != 0);
        self.have = self.have.min(self.high);
        dropped
    }

    /// Whether the first held frame is a cut whose named frame the board has opened: the board never takes
    /// that cut.
    pub fn is_cut_late(&self) -> bool {
        let late = |held: &&Held| {
            let by = (self.opened as u8).wrapping_sub(held.bytes[0]);
            by != 0 && by < 0x80
        };
        self.is_next(Kind::Cut) && self.held.first().filter(late).is_some()
    }

    /// Whether a frame of this kind is held.
    pub fn holds(&self, kind: Kind) -> bool {
        self.held.iter().take(self.have.into()).any(|held| held.kind == kind)
    }

    /// Whether the first held frame is of this kind.
    pub fn is_next(&self, kind: Kind) -> bool {
        self.have != 0 && self.held.first().is_some_and(|held| held.kind == kind)
    }

    /// Drops all held frames: the first is a cut that the board never takes, so it takes none of the others.
    pub fn withdraw(&mut self, now: u64) {
        (self.have, self.sent, self.high, self.forward) = (0, 0, 0, now);
    }

    /// Takes a credit of the board.
    pub fn hear(&mut self, credit: Credit, now: u64) {
        self.pinged = false;
        // Until the board has taken the setup, it may tell of the run before.
        let before = credit.flags & (Credit::OFF | Credit::STARTED) != 0;
        if self.is_next(Kind::Setup) && before {
            if credit.is(Credit::DEAF) && now.saturating_sub(self.called) > self.times.call {
                self.go_back(now);
            }
            return;
        }
        let taken = credit.next.wrapping_sub(self.base);
        // A credit older than the last one is ignored.
        if taken > self.high {
            return;
        }
        if taken != 0 {
            self.held.rotate_left(usize::from(taken).min(WINDOW));
            self.have = self.have.saturating_sub(taken);
            self.sent = self.sent.saturating_sub(taken);
            self.high = self.high.wrapping_sub(taken);
            self.base = credit.next;
            self.forward = now;
        }
        self.free = u32::from(credit.free) << 3;
        self.flags = credit.flags;
        let opened = credit.opened.wrapping_sub(self.opened as u8);
        if opened < 0x80 {
            self.opened = self.opened.wrapping_add(opened.into());
        }
        if credit.is(Credit::DEAF) && now.saturating_sub(self.called) > self.times.call {
            self.go_back(now);
        }
    }

    fn go_back(&mut self, now: u64) {
        (self.calls, self.sent, self.called) = (true, 0, now);
        self.again = self.again.saturating_add(1);
    }

    /// Writes the next bytes for the wire to `out`, and returns their number: 0 if nothing may be sent now.
    /// To be called after bytes came and every millisecond, until it returns 0.
    pub fn next(&mut self, now: u64, out: &mut [u8; MOST]) -> usize {
        if self.waiting(now) > self.queued {
            return 0;
        }
        let since = self.forward.max(self.called);
        if self.sent != 0 && !self.calls && now.saturating_sub(since) > self.times.again {
            self.go_back(now);
        }
        // The board may be deaf, and the credit that said so lost. With nothing under way only this calls it.
        let silent = now.saturating_sub(self.said) > self.times.ping;
        if silent && core::mem::take(&mut self.pinged) {
            self.go_back(now);
        }
        let bytes = if self.calls {
            self.calls = false;
            self.called = now;
            for place in out.iter_mut().take(4) {
                *place = FILL;
            }
            4
        } else if let Some(frame) = self.frame(now) {
            copy(&frame, out)
        } else if silent {
            self.pinged = true;
            copy(&FrameBytes::new(Kind::Ping, 0, &[]), out)
        } else {
            return 0;
        };
        self.said = now;
        let from = self.wire.max(now.saturating_mul(1_000));
        self.wire = from.saturating_add((bytes as u64).saturating_mul(self.times.byte.into()));
        bytes
    }

    /// The next frame, if it may be sent.
    fn frame(&mut self, now: u64) -> Option<FrameBytes> {
        if self.sent >= self.have {
            return None;
        }
        let held = self.held.get(usize::from(self.sent))?;
        let before = self.held.iter().take(self.sent.into());
        let taken = before.fold(0, |taken, before| before.behind(taken));
        // A start waits until the board has all data. The answer to a setup tells the free bytes.
        let alone = matches!(held.kind, Kind::Start | Kind::Setup);
        if alone && self.sent != 0 || held.cost() != 0 && held.behind(taken) > self.free as i32 {
            return None;
        }
        let frame = held.frame(self.base.wrapping_add(self.sent));
        if self.sent == 0 && self.high == 0 {
            self.forward = self.forward.max(now);
        }
        self.sent = self.sent.wrapping_add(1);
        self.high = self.high.max(self.sent);
        Some(frame)
    }
}

fn copy(frame: &FrameBytes, out: &mut [u8; MOST]) -> usize {
    let bytes = frame.as_bytes();
    for (place, byte) in out.iter_mut().zip(bytes) {
        *place = *byte;
    }
    bytes.len()
}
