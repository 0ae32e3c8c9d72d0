//! The power of a laser by the level of its pin alone.

use super::HZ;

/// The level of a laser's pin.
pub struct Pulses {
    /// When it changed, in 2⁻⁴ µs, and to which level. It is low at first.
    pub changes: Vec<(u64, bool)>,
    /// A pulse and its pause.
    pub period: u64,
}

impl Pulses {
    /// The part of eight periods from a time on in which the pin is high.
    fn duty(&self, from: u64) -> f64 {
        let to = from + 8 * self.period;
        let n = self.changes.partition_point(|change| change.0 <= from);
        let mut level = n.checked_sub(1).is_some_and(|n| self.changes[n].1);
        let (mut at, mut high) = (from, 0);
        for &(time, next) in self.changes[n..].iter().take_while(|change| change.0 < to) {
            high += if level { time - at } else { 0 };
            (at, level) = (time, next);
        }
        high += if level { to - at } else { 0 };
        high as f64 / (8 * self.period) as f64
    }

    /// Checks the duty of each power, between its time and the next one's, in s after `begin`, that its pulses
    /// have the period, and that it comes within 0.3 ms and a period. `part` is the duty of a power. Between 0.1 s and the first change,
    /// and 0.1 s after the last one, the pin has to be low.
    pub fn check(&self, begin: f64, powers: &[(f64, u8)], part: impl Fn(u8) -> f64) {
        let at = |time: f64| (begin + time * HZ) as u64;
        let (first, last) = (powers[0].0, powers[powers.len() - 1]);
        assert_eq!(last.1, 0, "the last power");
        assert!(first > 0.1 && self.duty(at(0.1)) == 0.0 && self.duty(at(last.0 + 0.1)) == 0.0);
        for (n, &(time, power)) in powers.iter().enumerate() {
            let next = powers.get(n + 1).map_or(time + 0.2, |next| next.0);
            let wanted = part(power);
            for place in [0.1, 0.5, 0.9] {
                let duty = self.duty(at(time + (next - time) * place));
                assert!((duty - wanted).abs() < 0.01, "{time}: {duty} of {wanted}");
            }
            if wanted > 0.0 && wanted < 1.0 {
                let (from, to) = (at(time + 0.1 * (next - time)), at(time + 0.9 * (next - time)));
                let rises = |change: &&(u64, bool)| change.1 && (from..to).contains(&change.0);
                let rises = self.changes.iter().filter(rises).count() as u64;
                assert!(rises.abs_diff((to - from) / self.period) <= 1, "{time}: {rises} pulses");
            }
            let before = self.duty(at(time) - 8 * self.period - 4_800);
            let behind = self.duty(at(time) + 4_800);
            let was = part(n.checked_sub(1).map_or(0, |n| powers[n].1));
            assert!(
                (before - was).abs() < 0.05 && (behind - wanted).abs() < 0.05,
                "{time}: {before} {behind}"
            );
        }
    }
}
