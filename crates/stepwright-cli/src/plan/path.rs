//! A law whose motion the core gives as a path: at most three pieces of
//! constant acceleration.

use stepwright::profile::{Cursor, Delays, Fit, Path, Phase};
use stepwright::{Rate, Run, Speed, Ticks};

use super::ideal::Ideal;
use super::law::{Closeness, Law, Span};
use super::real::Real;

/// A path beside its ideal.
pub struct PathLaw {
    path: Path,
    delays: Delays,
    ideal: Ideal,
    start: Speed,
}

impl PathLaw {
    /// A law's path and delays, to be measured against a profile of the same
    /// values.
    pub fn new(path: Path, delays: Delays, rate: Rate, start: Speed, top: Speed) -> PathLaw {
        let ideal = Ideal::new(rate, start, top, path.slopes(), path.pulses());
        PathLaw { path, delays, ideal, start: start.min(top) }
    }
}

impl Law for PathLaw {
    fn pulses(&self) -> u32 {
        self.path.pulses()
    }

    fn delays(&self) -> Box<dyn Iterator<Item = Ticks> + '_> {
        Box::new(self.delays.clone())
    }

    fn stretches(&self) -> Box<dyn Iterator<Item = Run> + '_> {
        Box::new(Cursor::new(self.path, Fit::EXACT)) // what `Delays` plays
    }

    fn ideal(&self, n: u32) -> Real {
        self.ideal.time(n)
    }

    fn spans(&self) -> Vec<Span> {
        // Phases only ever follow each other: look for where they change.
        let (pulses, phase) = (self.pulses(), |n| self.path.phase_of(n));
        let first_not = |from: u32, wanted: fn(Phase) -> bool| {
            let (mut low, mut high) = (from, pulses);
            while low < high {
                let middle = low + (high - low) / 2;
                if wanted(phase(middle)) { low = middle + 1 } else { high = middle }
            }
            low
        };
        let up = first_not(0, |p| p == Phase::Up);
        let cruise = first_not(up, |p| p == Phase::Cruise);
        [(Phase::Up, up), (Phase::Cruise, cruise - up), (Phase::Down, pulses - cruise)]
            .into_iter()
            .filter(|(_, pulses)| *pulses > 0)
            .map(|(phase, pulses)| Span { phase, pulses })
            .collect()
    }

    fn runs(&self, fit: Closeness) -> Box<dyn Iterator<Item = Run> + '_> {
        Box::new(Cursor::new(self.path, fit.fit()))
    }

    fn ends(&self) -> f64 {
        f64::from(self.start.millisteps()) / 1000.0
    }

    fn peak(&self) -> f64 {
        if self.pulses() < 2 { 0.0 } else { self.ideal.peak() }
    }

    fn braking(&self) -> u32 {
        self.path.braking_steps()
    }
}
