//! The terms of a run.

use stepwright_stream::brake::BrakeLaw;
use stepwright_stream::fit::FitTerms;
use stepwright_stream::record::AXES;
use stepwright_stream::send::LinkTimes;

use crate::{SPAN, fine};

/// The least time without steps after which an axis is told to wait, in µs.
const PATIENCE: u64 = 40_000;

/// The terms of a run: the board, the line and the axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeedTerms {
    /// Ticks per second of the board's step timer.
    pub hz: u32,
    /// The largest deviation of a step from its time, in ns, while the board has enough ahead.
    pub tolerance: u32,
    /// How far ahead of the board the feeder sends at most, in µs. The board's FIFO is a bound as well: it holds
    /// some 0.3 s of three busy axes on an Uno, more than 1 s on a Mega.
    pub ahead: u32,
    /// The board brakes after this long without a whole frame, in ms: at most 2,040; 0 for never.
    pub lease: u32,
    /// The axes that take part, one bit each. The others rest. An axis that takes part costs the board time,
    /// even without steps.
    pub axes: u8,
    /// The brake of each axis.
    pub brakes: [BrakeLaw; AXES],
    /// The inputs that stop the run: see [`Start`](stepwright_stream::frame::Kind::Start).
    pub inputs: u8,
    /// The inputs among these that stop the run when they open.
    pub high: u8,
    /// Whether the board's laser takes part: see [`power`](crate::StreamFeeder::power).
    pub laser: bool,
    /// Each axis is this many ticks behind the one before, so that equal axes do not step at once.
    pub stagger: u32,
    /// The shortest wait, in ticks.
    pub shortest: u32,
    /// The times of the line.
    pub times: LinkTimes,
}

impl FeedTerms {
    /// The terms of an AVR board on a serial line of 115,200 baud.
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
            laser: false,
            stagger: 75,
            shortest: 72,
            times: LinkTimes::of_baud(115_200),
        }
    }

    pub(crate) fn ticks(&self, micros: u64) -> u64 {
        micros * u64::from(self.hz) / 1_000_000
    }

    /// An axis without steps for this long is told to wait and may rest, in 2⁻⁸ ticks. A step that comes
    /// sooner is sent before, so that a board that hears nothing more makes it.
    pub(crate) fn patience(&self) -> u64 {
        let taking_part = (0..).zip(&self.brakes).filter(|(axis, _)| self.axes >> axis & 1 != 0);
        // An axis may rest one step after an interval of 1/√(2a), which is half the slowest one.
        let slowest = taking_part.map(|(_, law)| u64::from(law.slowest())).max().unwrap_or(0);
        fine(self.ticks(PATIENCE)).max(slowest / 2)
    }
}

pub(crate) fn fit_terms(terms: &FeedTerms, tolerance: u32, axis: u64) -> FitTerms {
    let hz = u64::from(terms.hz);
    // From this interval on an axis may rest at once.
    let slowest = terms.brakes.get(axis as usize).map_or(0, |brake| brake.slowest());
    FitTerms {
        patience: slowest.max(fine(terms.ticks(2 * SPAN)) as u32),
        tolerance: (u64::from(tolerance) * hz * 256 / 1_000_000_000) as u32,
        longest: fine(terms.ticks(SPAN)) as u32,
        shortest: terms.shortest,
    }
}
