//! Lists, callbacks and waits (stepper_h's buffered and dynamic series).
//!
//! A series takes its delays from any iterator of [`Part`]s: a list that was
//! prepared, or [`core::iter::from_fn`] for a callback. Exact by definition: the delays are the
//! ones that were given.

use crate::units::Ticks;

/// A piece of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// `count` steps, `delay` ticks before each.
    Steps {
        /// How many; 0 is an empty part.
        count: u32,
        /// Ticks before each step.
        delay: Ticks,
    },
    /// No step for this many ticks: added to the next step's delay.
    Wait(Ticks),
}

/// The delays of a list of parts.
///
/// ```
/// use stepwright::profile::{Part, Series};
/// let parts = [
///     Part::Steps { count: 2, delay: 100 },
///     Part::Wait(1000),
///     Part::Steps { count: 2, delay: 50 },
/// ];
/// assert_eq!(Series::new(parts).collect::<Vec<_>>(), [100, 100, 1050, 50]);
///
/// // A callback gives each next delay until it has enough.
/// let mut delay = 400;
/// let faster = std::iter::from_fn(|| {
///     delay -= 100;
///     (delay > 0).then_some(Part::Steps { count: 1, delay })
/// });
/// assert_eq!(Series::new(faster).collect::<Vec<_>>(), [300, 200, 100]);
/// ```
#[derive(Clone, Debug)]
pub struct Series<I> {
    parts: I,
    left: u32,
    delay: Ticks,
    wait: Ticks,
}

impl<I: Iterator<Item = Part>> Series<I> {
    /// A series of `parts`. Waits at the end are dropped; waits that add up to
    /// more than 2³² − 1 ticks saturate.
    pub fn new(parts: impl IntoIterator<IntoIter = I>) -> Series<I> {
        Series { parts: parts.into_iter(), left: 0, delay: 0, wait: 0 }
    }
}

impl<I: Iterator<Item = Part>> Iterator for Series<I> {
    type Item = Ticks;

    fn next(&mut self) -> Option<Ticks> {
        while self.left == 0 {
            match self.parts.next()? {
                Part::Steps { count, delay } => (self.left, self.delay) = (count, delay),
                Part::Wait(ticks) => self.wait = self.wait.saturating_add(ticks),
            }
        }
        self.left -= 1;
        Some(self.delay.saturating_add(core::mem::take(&mut self.wait)))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn empty_parts_and_trailing_waits_give_nothing() {
        let parts = [Part::Steps { count: 0, delay: 9 }, Part::Wait(5)];
        assert_eq!(Series::new(parts).count(), 0);
    }

    #[test]
    fn waits_saturate() {
        let parts = [Part::Wait(u32::MAX), Part::Wait(7), Part::Steps { count: 2, delay: 3 }];
        assert_eq!(Series::new(parts).collect::<Vec<_>>(), [u32::MAX, 3]);
    }
}
