//! Converts values to pixels, and chooses the round numbers of an axis.

use std::ops::RangeInclusive;

/// The fewest numbers with which an axis can be read.
const FEWEST: usize = 4;

/// An axis: values from `low` to `high` along some pixels.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    low: f64,
    high: f64,
    /// The pixels of `low` and `high`.
    from: f64,
    to: f64,
}

impl Scale {
    /// `low` lies at pixel `from`, `high` at `to`.
    pub fn new((low, high): (f64, f64), (from, to): (f64, f64)) -> Scale {
        // A length of 0, or one that is tiny compared to its values, would cause a division by
        // zero.
        let least = (low.abs() * 1e-12).max(1e-290);
        let high = if high - low <= least { low + (low.abs() * 1e-9).max(1.0) } else { high };
        // An infinite range or NaN has no round numbers.
        let ends = low.abs() <= 1e300 && high.abs() <= 1e300;
        let (low, high) = if ends { (low, high) } else { (0.0, 1.0) };
        Scale { low, high, from, to }
    }

    /// The pixel of a value.
    pub fn at(&self, value: f64) -> f64 {
        self.from + (value - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// About `wanted` round values on the axis, at least four unless fewer are wanted, and the
    /// decimals that they need.
    pub fn ticks(&self, wanted: usize) -> (Vec<f64>, usize) {
        let mut step = round_step((self.high - self.low) / wanted.max(1) as f64);
        while wanted > 1 && self.every(step).count() < FEWEST {
            // The next smaller of 1, 2 and 5.
            step = round_step(step * 0.45);
        }
        let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
        (self.every(step).map(|i| i as f64 * step).collect(), decimals)
    }

    /// The multiples of a step on the axis, as factors.
    fn every(&self, step: f64) -> RangeInclusive<i64> {
        let slack = step * 1e-9;
        let first = ((self.low - slack) / step).ceil() as i64;
        first..=((self.high + slack) / step).floor() as i64
    }
}

/// 1, 2 or 5 times a power of ten: the nearest to `step` by ratio.
fn round_step(step: f64) -> f64 {
    let power = 10f64.powf(step.log10().floor());
    // The limits between neighbours are √2, √10 and √50.
    let factor = match step / power {
        f if f < 1.414 => 1.0,
        f if f < 3.162 => 2.0,
        f if f < 7.071 => 5.0,
        _ => 10.0,
    };
    factor * power
}

/// A number with separated thousands: `1 000 000`, `0.25`, `−3`.
pub fn number(value: f64, decimals: usize) -> String {
    let text = format!("{:.decimals$}", value.abs());
    let (whole, part) = text.split_once('.').map_or((text.as_str(), None), |(w, p)| (w, Some(p)));
    let negative = value < 0.0 && text.bytes().any(|b| matches!(b, b'1'..=b'9'));
    let mut out = String::from(if negative { "−" } else { "" });
    for (i, digit) in whole.chars().enumerate() {
        // Four digits are readable without a gap.
        if i > 0 && (whole.len() - i) % 3 == 0 && whole.len() > 4 {
            out.push('\u{2009}');
        }
        out.push(digit);
    }
    if let Some(part) = part {
        out.push('.');
        out.push_str(part);
    }
    out
}

/// A suitable unit of time for this many seconds, and its number per second.
pub fn time_unit(seconds: f64) -> (&'static str, f64) {
    match seconds {
        s if s < 2e-3 => ("µs", 1e6),
        s if s < 1.0 => ("ms", 1e3),
        s if s < 900.0 => ("s", 1.0),
        s if s < 3.0 * 3600.0 => ("min", 1.0 / 60.0),
        _ => ("h", 1.0 / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_round_numbers() {
        let ticks = |low, high, n| Scale::new((low, high), (0.0, 1.0)).ticks(n);
        assert_eq!(ticks(0.0, 1000.0, 5), (vec![0.0, 200.0, 400.0, 600.0, 800.0, 1000.0], 0));
        let (values, decimals) = ticks(0.0, 0.31, 4);
        assert_eq!((values.len(), decimals), (4, 1));
        // Never so few that the axis can't be read.
        assert_eq!(ticks(-432.0, 432.0, 3).0, [-400.0, -200.0, 0.0, 200.0, 400.0]);
        assert_eq!(ticks(0.0, 9612.0, 3).0, [0.0, 2000.0, 4000.0, 6000.0, 8000.0]);
        for n in 1..2000 {
            let (low, high) = (-f64::from(n % 7) * 13.7, f64::from(n) * 0.37);
            let (few, more) = (ticks(low, high, 2).0.len(), ticks(low, high, 12).0.len());
            assert!((4..=10).contains(&few) && (6..=20).contains(&more), "{n}: {few}, {more}");
        }
        let (values, _) = ticks(-1000.0, 1000.0, 4);
        assert_eq!(values, [-1000.0, -500.0, 0.0, 500.0, 1000.0]);
    }

    #[test]
    fn numbers_are_grouped() {
        assert_eq!(number(1_234_567.0, 0), "1\u{2009}234\u{2009}567");
        assert_eq!(number(9000.0, 0), "9000");
        assert_eq!(number(-0.25, 2), "−0.25");
        assert_eq!(number(-0.001, 2), "0.00");
    }

    #[test]
    fn an_empty_axis_is_no_trouble() {
        let scale = Scale::new((3.0, 3.0), (0.0, 100.0));
        assert!(scale.at(3.0).is_finite());
        assert!(!scale.ticks(5).0.is_empty());
    }

    #[test]
    fn any_ends_make_an_axis() {
        let all = [0.0, 1.0, -3.0, 1e17, -1e17, 1e300, 1e-300, 5e-324, f64::MAX, f64::MIN];
        let none = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        for low in all.into_iter().chain(none) {
            for high in all.into_iter().chain(none) {
                let scale = Scale::new((low, high), (0.0, 100.0));
                let (values, _) = scale.ticks(5);
                assert!((4..=20).contains(&values.len()), "{low} {high}: {values:?}");
                assert!(values.iter().all(|value| scale.at(*value).is_finite()), "{low} {high}");
            }
        }
    }
}
