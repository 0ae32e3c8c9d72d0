//! Records of all axes become the payloads of frames.

use crate::frame::LONGEST;
use crate::power;
use crate::record::{AXES, Record, RecordBytes, Trail};

/// The payload of a data frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataBytes {
    bytes: [u8; LONGEST],
    len: u8,
    /// The start of the first record, in 2⁻⁸ ticks since the start of the stream.
    pub start: u64,
}

impl DataBytes {
    const NONE: DataBytes = DataBytes { bytes: [0; LONGEST], len: 0, start: 0 };

    /// The bytes, in order.
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or(&[])
    }

    fn push(&mut self, byte: u8) {
        if let Some(place) = self.bytes.get_mut(usize::from(self.len)) {
            *place = byte;
            self.len = self.len.wrapping_add(1);
        }
    }
}

/// Bytes of a frame at most.
const WHOLE: u8 = LONGEST as u8 - 1;

/// Collects records, which are handed over in the order of their starts.
#[derive(Clone, Debug)]
pub struct FramePacker {
    frame: DataBytes,
    span: u64,
    /// The most bytes of the next short frames, and the number of these frames.
    most: u8,
    short: u8,
    trails: [Trail; AXES],
}

impl FramePacker {
    /// A packer. The records of one frame start within `span`, in 2⁻⁸ ticks.
    pub const fn new(span: u64) -> FramePacker {
        // One byte is left for `NOTHING`, which may have to end the frame.
        FramePacker {
            frame: DataBytes::NONE,
            span,
            most: WHOLE,
            short: 0,
            trails: [Trail::NONE; AXES],
        }
    }

    /// Whether the next record will be the first of a frame.
    pub const fn is_empty(&self) -> bool {
        self.frame.len == 0
    }

    /// The trails of all axes after their last records.
    pub const fn trails(&self) -> [Trail; AXES] {
        self.trails
    }

    /// Continues as if the last records had led to these trails. Forgets the frame that was not handed out.
    /// The next `short` frames have at most `most` bytes.
    pub fn rewind(&mut self, trails: [Trail; AXES], short: u8, most: u8) {
        (self.trails, self.frame) = (trails, DataBytes::NONE);
        (self.short, self.most) = (short, most);
    }

    /// Adds a record of an axis. Returns the frame before, if it had no room for the record.
    ///
    /// # Errors
    /// [`Unsent`] if the record cannot be encoded, or the axis does not exist. Nothing has changed then.
    pub fn add(
        &mut self,
        axis: u8,
        record: &Record,
        start: u64,
    ) -> Result<Option<DataBytes>, Unsent> {
        let trail = self.trails.get_mut(usize::from(axis)).ok_or(Unsent)?;
        let bytes = RecordBytes::new(axis, record, trail).ok_or(Unsent)?;
        trail.pass(record);
        Ok(self.append(bytes.as_bytes(), start))
    }

    /// Adds a change of the [`power`] of a laser, `wait` units after the last one. Returns the frame before, if
    /// it had no room for the change.
    pub fn add_power(&mut self, wait: u16, power: u8, start: u64) -> Option<DataBytes> {
        self.append(&power::bytes(wait, power), start)
    }

    fn append(&mut self, bytes: &[u8], start: u64) -> Option<DataBytes> {
        let most = if self.short == 0 { WHOLE } else { self.most };
        let full = usize::from(self.frame.len) + bytes.len() > usize::from(most)
            || start.saturating_sub(self.frame.start) > self.span;
        let done = if full { self.flush() } else { None };
        if self.frame.len == 0 {
            self.frame.start = start;
            self.frame.push((start >> 24) as u8);
        }
        bytes.iter().for_each(|byte| self.frame.push(*byte));
        done
    }

    /// Hands out the frame with the collected records; `None` if there are none.
    pub fn flush(&mut self) -> Option<DataBytes> {
        if self.frame.len == 0 {
            return None;
        }
        self.short = self.short.saturating_sub(1);
        Some(core::mem::replace(&mut self.frame, DataBytes::NONE))
    }
}

/// The record cannot be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unsent;
