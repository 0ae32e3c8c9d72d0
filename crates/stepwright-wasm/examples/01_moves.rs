//! Random travels by every law, with a hash of their delays, one per line as JSON.
//!
//!   cargo run -p stepwright-wasm --example 01_moves -- 10000 | node tests/equal.mjs
//!
//! The hash is of the delays of the core's own iterators; the module must have the same.

use std::io::{self, BufWriter, Write};

use stepwright::fixed::Q32;
use stepwright::profile::{SCurve, Trapezoid, Unfit};
use stepwright_austin::{Austin, Fixed, LinearFactor, Piecewise, PowerTerm};
use stepwright_wasm::{PlanLaw, PlanOrder};

/// xorshift64*.
struct Random(u64);

impl Random {
    /// A number from 0 to 1.
    fn part(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A number of any order of magnitude with equal probability, to a thousandth.
    fn size(&mut self, low: f64, high: f64) -> f64 {
        let value = low * (high / low).powf(self.part());
        (value * 1e3).round() / 1e3
    }

    fn below(&mut self, end: u32) -> f64 {
        (self.part() * f64::from(end)).floor()
    }

    /// The numbers of a travel, in order.
    fn travel(&mut self) -> [f64; 14] {
        let rate = self.size(1e5, 2e8).round();
        let steps = self.size(1.0, 5e3).round() - 1.0;
        let start = if self.part() < 0.5 { 0.0 } else { self.size(1.0, 1e4) };
        let top = self.size(1.0, 9e4);
        let accel = self.size(1.0, 1e7);
        let decel = if self.part() < 0.5 { accel } else { self.size(1.0, 1e7) };
        let jerk = self.size(10.0, 1e11);
        let (c0, divisor) = (self.below(3), self.below(2));
        let knee = self.below(901) / 1e3;
        let (power, breaks) = (2.0 + self.below(8), self.below(17));
        [rate, steps, start, top, accel, decel, jerk, c0, divisor, knee, power, breaks, 0.0, 1e12]
    }
}

/// FNV-1a over words of 32 bits.
fn hash(delays: impl Iterator<Item = u32>) -> u64 {
    delays.fold(0xcbf2_9ce4_8422_2325, |hash, delay| {
        (hash ^ u64::from(delay)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// The hash of a travel's delays by the core.
fn delays(law: PlanLaw, order: &PlanOrder) -> Result<u64, Unfit> {
    let PlanOrder { rate, steps, start, top, accel, decel, jerk, c0, .. } = *order;
    Ok(match law {
        PlanLaw::Trapezoid => {
            hash(Trapezoid::new(rate, start, top, accel).with_decel(decel).delays(steps)?)
        }
        PlanLaw::SCurve => {
            hash(SCurve::new(rate, start, top, accel, jerk).with_decel(decel).delays(steps)?)
        }
        PlanLaw::Austin => {
            let law = Austin::new(rate, top, accel).with_decel(decel).with_c0(c0);
            hash(law.with_divisor(order.divisor).delays(steps)?)
        }
        PlanLaw::AustinFixed => {
            let law = Austin::new(rate, top, accel).with_c0(c0).constants(steps)?;
            let ticks = |delay: Q32| (delay.saturating_add(1 << 31) >> 32) as u32;
            hash(Fixed::new(steps, ticks(law.lead), ticks(law.shortest)))
        }
        PlanLaw::LinearFactor => {
            let law = LinearFactor::new(rate, top, accel).with_decel(decel).with_c0(c0);
            hash(law.with_knee(order.knee).delays(steps)?)
        }
        PlanLaw::Power => {
            let law = PowerTerm::new(rate, top, accel, order.power).with_decel(decel);
            hash(law.with_c0(c0).delays(steps)?)
        }
        PlanLaw::Piecewise => {
            let law = Piecewise::new(rate, top, accel).with_decel(decel).with_c0(c0);
            hash(law.with_breaks(order.breaks).delays(steps)?)
        }
    })
}

fn main() -> io::Result<()> {
    let moves: u32 = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(10);
    let mut out = BufWriter::new(io::stdout().lock());
    let mut random = Random(0x5743);
    for (law, number) in PlanLaw::ALL.into_iter().zip(0..) {
        for _ in 0..moves {
            let mut numbers = random.travel();
            if law == PlanLaw::AustinFixed {
                // This law brakes as it speeds up.
                numbers[5] = numbers[4];
            }
            let order = PlanOrder::check(&numbers).expect("a travel within the ranges");
            let hash = delays(law, &order).expect("a travel that this timer can hold");
            writeln!(out, "{{\"law\":{number},\"numbers\":{numbers:?},\"hash\":\"{hash:016x}\"}}")?;
        }
    }
    out.flush()
}
