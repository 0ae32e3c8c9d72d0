//! A law that computes each delay from the delay before, and its formula in f64.

use stepwright::compress::Compress;
use stepwright::profile::Phase;
use stepwright::{Rate, Run, Ticks};
use stepwright_oracle::Double;

use super::formula::Formula;
use crate::law::{Closeness, PlannedLaw, Span};

/// The core's delays, and the same travel by formula.
pub(crate) struct Counted<I> {
    delays: I,
    formula: Formula,
    rate: Rate,
    /// Why the peak may stay below the top speed, although the travel is long enough.
    short: &'static str,
}

impl<I> Counted<I> {
    /// `delays` are those of the core, one for each pulse.
    pub fn new(delays: I, formula: Formula, rate: Rate, short: &'static str) -> Counted<I> {
        Counted { delays, formula, rate, short }
    }
}

impl<I: Iterator<Item = Ticks> + Clone> PlannedLaw for Counted<I> {
    fn pulses(&self) -> u32 {
        self.formula.pulses()
    }

    fn delays(&self) -> Box<dyn Iterator<Item = Ticks> + '_> {
        Box::new(self.delays.clone())
    }

    fn ideal(&self, n: u32) -> Double {
        self.formula.time(n)
    }

    fn spans(&self) -> Vec<Span> {
        let first = u32::from(self.pulses() > 0);
        let (up, level, down) = self.formula.parts();
        [(Phase::Up, up + first), (Phase::Cruise, level), (Phase::Down, down)]
            .into_iter()
            .filter(|(_, pulses)| *pulses > 0)
            .map(|(phase, pulses)| Span { phase, pulses })
            .collect()
    }

    fn runs(&self, fit: Closeness) -> Box<dyn Iterator<Item = Run> + '_> {
        // The delays are within a tick of the formula. Constant stretches give whole runs, so looking far
        // ahead is worth it.
        Box::new(Compress::<_, 256>::new(self.delays.clone().skip(1), fit.error))
    }

    fn ends(&self) -> f64 {
        0.0
    }

    fn peak(&self) -> f64 {
        if self.pulses() < 2 { 0.0 } else { f64::from(self.rate.hz()) / self.formula.shortest() }
    }

    fn short(&self) -> &'static str {
        if self.formula.is_complete() { self.short } else { "the travel is too short" }
    }

    fn holds(&self) -> bool {
        true
    }

    fn braking(&self) -> u32 {
        self.formula.parts().2
    }
}
