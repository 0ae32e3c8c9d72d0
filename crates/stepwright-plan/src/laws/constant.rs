//! A law whose motion the core gives as a path: at most three pieces of constant acceleration.

use stepwright::profile::{Cursor, Delays, Fit, Path, Phase};
use stepwright::{Rate, Run, Speed, Ticks};
use stepwright_oracle::{Double, IdealTrapezoid, Number};

use crate::law::{Closeness, PlannedLaw, Span};

/// A path and its ideal.
pub(crate) struct ConstantLaw {
    path: Path,
    delays: Delays,
    /// In steps and thousandths of a step/s, so its times are in 1000 s.
    ideal: IdealTrapezoid<Double>,
    /// Ticks in 1000 s.
    ticks: Double,
    start: Speed,
}

impl ConstantLaw {
    /// A law's path and delays, measured against an ideal profile of the same values.
    pub fn new(path: Path, delays: Delays, rate: Rate, start: Speed, top: Speed) -> ConstantLaw {
        let speed = |speed: Speed| Double::whole(speed.millisteps().into());
        let ends = (speed(start), speed(start));
        let slopes = (Double::whole(path.slopes().0), Double::whole(path.slopes().1));
        let length = Double::whole(path.pulses().saturating_sub(1).into());
        let ideal = IdealTrapezoid::new(ends, speed(top), slopes, length);
        let ticks = Double::whole(1000 * u64::from(rate.hz()));
        ConstantLaw { path, delays, ideal, ticks, start: start.min(top) }
    }
}

impl PlannedLaw for ConstantLaw {
    fn pulses(&self) -> u32 {
        self.path.pulses()
    }

    fn delays(&self) -> Box<dyn Iterator<Item = Ticks> + '_> {
        Box::new(self.delays.clone())
    }

    fn stretches(&self) -> Box<dyn Iterator<Item = Run> + '_> {
        Box::new(Cursor::new(self.path, Fit::EXACT)) // what `Delays` plays
    }

    fn ideal(&self, n: u32) -> Double {
        self.ideal.time(Double::whole(n.into())) * self.ticks
    }

    fn spans(&self) -> Vec<Span> {
        // Each phase occurs once: look for the changes between them.
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
        if self.pulses() < 2 { 0.0 } else { self.ideal.peak().to_f64() / 1000.0 }
    }

    fn braking(&self) -> u32 {
        self.path.braking_steps()
    }
}
