//! Makes arcs from their words.

use crate::geometry::{centre, radii_agree, square};
use crate::modal::MotionMode;
use crate::state::State;
use crate::words::{Letter, OFFSETS, Refused, Words};
use crate::{Arc, Fault, Length, Point};

impl State {
    /// The arc to `to`, from the words of its centre or its radius. `column` is the place of a fault of the
    /// whole arc.
    pub fn arc(&self, words: &mut Words, to: Point, column: u16) -> Result<Arc, Refused> {
        let clockwise = self.modal.motion == MotionMode::Clockwise;
        let plane = self.modal.plane;
        let [first, second, _] = plane.axes();
        let parts = |point: Point| [first, second].map(|axis| point.0[axis]);
        let (from, to) = (parts(self.position), parts(to));
        let radius = words.take(Letter::R);
        let offsets = [first, second].map(|axis| OFFSETS[axis]);
        let offset = if let Some(radius) = radius {
            let length = self.length(radius)?.picometres();
            let way = difference(to, from);
            if way == [0, 0] {
                return Err((Fault::ArcClosed, column));
            }
            // The shorter arc of a positive radius turns about a centre on its inner side.
            let left = clockwise == (length < 0);
            centre(way, length, left).ok_or(radius.fault(Fault::ArcRadius))?
        } else {
            let words = offsets.map(|letter| words.take(letter));
            if let [None, None] = words {
                return Err((Fault::ArcCentre, column));
            }
            let mut offset = [0; 2];
            for (offset, word) in offset.iter_mut().zip(words) {
                if let Some(word) = word {
                    *offset = self.length(word)?.picometres();
                }
            }
            offset
        };
        let mut centre = from;
        for (axis, offset) in centre.iter_mut().zip(offset) {
            *axis = Length::from_picometres(axis.picometres() + offset)
                .ok_or((Fault::TooFar, column))?;
        }
        if radius.is_none() {
            let start = square(offset);
            if start == 0 || !radii_agree(start, square(difference(to, centre))) {
                return Err((Fault::ArcRadii, column));
            }
        }
        Ok(Arc { plane, clockwise, centre })
    }
}

fn difference(a: [Length; 2], b: [Length; 2]) -> [i64; 2] {
    [a[0].picometres() - b[0].picometres(), a[1].picometres() - b[1].picometres()]
}
