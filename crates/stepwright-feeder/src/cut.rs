//! Cuts: taking back frames that were sent ahead.
//!
//! ```text
//!            kept                        taken back
//!   ───────────────────────┬──────────────────────────────────►  frames that the board has not opened
//!   now        opening ─►  │ a frame's beginning: how all axes and the records stood is known
//!                          └─ cut, and the first records of what comes instead
//! ```
//!
//! A cut names the first frame that the board is to forget, and carries the first records that replace it.
//! The board therefore has the old frames or the new ones, whatever happens on the line in between. A board
//! that has opened the named frame does not take the cut: the old plan goes on, and the caller asks for a
//! later place.

use stepwright_stream::credit::Credit;
use stepwright_stream::frame::{CUT, Kind};

use crate::axis::AxisFeed;
use crate::clock::opening;
use crate::laser::LaserFeed;
use crate::{FeedState, LEAD, Mark, SPAN, StreamFeeder, fine};

/// A cut is sent this long before the board opens the frame that it names, in µs, after the bytes that wait
/// before the wire: enough for the cut and the frame after it on a line whose answers come some 6 ms late. The margin grows
/// after a cut that came too late.
pub(crate) const MARGIN: u64 = 12_000;
/// The largest margin, in µs.
const MOST: u64 = 60_000;
/// By how much the margin grows after a cut that came too late, and shrinks after one in time, in µs.
const MORE: u64 = 4_000;
const LESS: u64 = 1_000;
/// The number of short frames after a cut.
const SHORT: u8 = 4;
/// The way of a cut and the frame after it from the computer to the board, in µs.
const WAY: u64 = 11_000;

/// The place from which on other steps can come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// The time on the path, in s.
    pub time: f64,
    /// The number of steps of all axes that the board makes all the same. Later steps are forgotten.
    pub steps: u64,
}

/// A cut that the board has not taken yet.
#[derive(Debug)]
pub(crate) struct Cutting {
    /// The number of the first forgotten frame, and the bytes of all forgotten frames.
    keep: u64,
    frees: u32,
    end: u64,
    /// The latest gate time at which the cut may be sent.
    until: u64,
    sent: bool,
    before: Before,
}

/// The feeder's state without the cut.
#[derive(Debug)]
struct Before {
    axes: [Option<AxisFeed>; stepwright_stream::record::AXES],
    marks: std::collections::VecDeque<Mark>,
    trails: [stepwright_stream::record::Trail; stepwright_stream::record::AXES],
    laser: LaserFeed,
    steps: std::collections::VecDeque<u64>,
    /// The frame number of the first mark.
    first: u64,
    offered: u64,
    known: u64,
    over: bool,
    ended: bool,
}

impl Cutting {
    /// The time from which on other steps come, as long as the cut has not been sent.
    pub(crate) fn waits(&self) -> Option<u64> {
        (!self.sent).then_some(self.end)
    }
}

impl StreamFeeder {
    /// Takes back the frames that the board has not begun. The caller continues from the returned time with
    /// other steps, or with [the end](StreamFeeder::end). `brakes` promises that no axis makes its next step
    /// sooner than planned before; the cut can be sooner then.
    ///
    /// `None` while nothing plays, and while the board has not taken the last cut: ask again later.
    pub fn cut(&mut self, now: u64, brakes: bool) -> Option<Cut> {
        if self.state != FeedState::Running || self.cutting.is_some() {
            return None;
        }
        let here = self.clock.at(now)?;
        let (frames, end) = self.sender.retract();
        self.offered -= frames;
        self.ended &= !end;
        self.late = false;
        // Back to the frames that the sender has sent or holds.
        self.go_back(self.offered, u64::MAX);
        if !self.sender.has_room() {
            return None;
        }
        let before = Before {
            axes: self.axes.clone(),
            marks: self.marks.clone(),
            trails: self.packer.trails(),
            laser: self.laser.clone(),
            steps: self.steps.clone(),
            first: self.gone,
            offered: self.offered,
            known: self.known,
            over: self.over,
            ended: self.ended,
        };
        let soonest = here + self.clock.ticks(self.margin + self.sender.waiting(now));
        let keep = (self.gone..)
            .zip(&self.marks)
            .find(|(_, mark)| opening(mark.start) >= soonest)
            .map_or(self.offered, |(number, _)| number);
        let first = self.marks.get((keep - self.gone) as usize);
        let until = first
            .map_or(u64::MAX, |mark| opening(mark.start).saturating_sub(self.clock.ticks(WAY)));
        let end = self.free_from(keep, brakes);
        let cut = self.marks.iter().skip((keep - self.gone) as usize);
        let frees = cut.map(|mark| mark.cost).sum();
        self.go_back(keep, end);
        self.offered = keep;
        let kept = self.steps.partition_point(|asked| *asked < end);
        self.steps.truncate(kept);
        (self.known, self.over, self.ended) = (end, false, false);
        self.cutting = Some(Box::new(Cutting { keep, frees, end, until, sent: false, before }));
        self.pace.changed = true;
        let time = (end as f64 - fine(LEAD) as f64) / self.units();
        Some(Cut { time, steps: self.dropped + kept as u64 })
    }

    /// Whether the last cut came too late; reported once. The plan from before the cut goes on, and steps that
    /// were handed over since are forgotten: call [`cut`](StreamFeeder::cut) again.
    pub fn was_late(&mut self) -> bool {
        std::mem::take(&mut self.late)
    }

    /// Whether the board has not taken the last cut yet.
    pub fn is_cutting(&self) -> bool {
        self.cutting.is_some()
    }

    /// The soonest time from which on all axes can do something else, if frame `keep` is the first forgotten.
    fn free_from(&self, keep: u64, brakes: bool) -> u64 {
        let now = self.mark(0);
        let mark = self.marks.get((keep - self.gone) as usize).unwrap_or(&now);
        let axes = || {
            let axes = self.axes.iter().zip(&mark.axes);
            axes.filter_map(|(axis, mark)| Some((axis.as_ref()?, mark.as_ref()?)))
        };
        let start = axes().map(|(_, mark)| mark.start()).min().unwrap_or(0);
        // No record of several steps that begins before `start` lasts longer.
        let patience = start + fine(self.terms.ticks(2 * SPAN + 1_000));
        let soonest = axes().map(|(axis, mark)| axis.free_from(mark, patience, brakes));
        let mut end = soonest.fold(start, u64::max);
        // The cut separates no pair of cancelled steps.
        loop {
            let apart = axes().fold(end, |end, (axis, _)| axis.between_pairs(end));
            if apart == end {
                return end;
            }
            end = apart;
        }
    }

    /// Returns to the beginning of frame `number`, and forgets the steps asked for at `end` and later.
    fn go_back(&mut self, number: u64, end: u64) {
        self.frames.clear();
        let at = (number - self.gone) as usize;
        let mark = self.marks.get(at).cloned().unwrap_or_else(|| self.mark(0));
        for (axis, mark) in self.axes.iter_mut().zip(&mark.axes) {
            if let (Some(axis), Some(mark)) = (axis, mark) {
                axis.rewind(mark, end);
            }
        }
        self.laser.rewind(&mark.laser, end);
        self.marks.truncate(at);
        // Short frames: the first fits into the cut, and each axis soon has its next record.
        let short = if end == u64::MAX { 0 } else { SHORT };
        self.packer.rewind(mark.trails, short, CUT as u8);
    }

    /// Hands a cut that is ready to the sender, with its first records. Returns whether other frames may follow.
    pub(crate) fn offer_cut(&mut self, packed: bool, now: u64) -> bool {
        let waiting = self.clock.ticks(self.sender.waiting(now));
        let Some(cutting) = self.cutting.as_mut().filter(|cutting| !cutting.sent) else {
            return true;
        };
        if self.frames.is_empty() && !packed || !self.sender.has_room() {
            return false;
        }
        if self.clock.at(now).is_some_and(|here| here + waiting > cutting.until) {
            self.uncut();
            return false;
        }
        let frame = self.frames.pop_front().or_else(|| self.packer.flush());
        let data = frame.as_ref().map_or(&[][..], |frame| frame.as_bytes());
        cutting.sent = true;
        self.sender.offer_cut(cutting.keep, data, cutting.frees, now);
        if frame.is_some() {
            self.offered(data.len() as u32 + 1);
        }
        true
    }

    /// Learns from the board's credit whether the cut was taken or came too late.
    pub(crate) fn learn_of_cut(&mut self, credit: Credit, now: u64) {
        if !self.cutting.as_ref().is_some_and(|cutting| cutting.sent) {
            return;
        }
        if !self.sender.holds(Kind::Cut) {
            self.cutting = None;
            self.margin = self.margin.saturating_sub(LESS).max(MARGIN);
            return;
        }
        // The board has reached its end meanwhile, or has opened a frame that the cut names.
        let stands = credit.is(Credit::STARTED) && !credit.is(Credit::MOVES);
        if !(self.sender.is_cut_late() || self.sender.is_next(Kind::Cut) && stands) {
            return;
        }
        self.sender.withdraw(now);
        self.uncut();
    }

    /// Restores the state from before the last cut, which the sender no longer holds.
    fn uncut(&mut self) {
        let Some(cutting) = self.cutting.take() else { return };
        let Before { axes, marks, trails, laser, steps, first, offered, known, over, ended } =
            cutting.before;
        self.frames.clear();
        (self.axes, self.marks, self.steps, self.laser) = (axes, marks, steps, laser);
        self.packer.rewind(trails, 0, 0);
        (self.offered, self.known, self.over, self.ended) = (offered, known, over, ended);
        self.marks.drain(..((self.gone - first) as usize).min(self.marks.len()));
        self.margin = (self.margin + MORE).min(MOST);
        self.late = true;
    }
}
