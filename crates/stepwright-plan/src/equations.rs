//! Austin's equations, in f64 and as they are printed.
//!
//! Nothing here comes from `stepwright-austin`, whose integer laws are tested against these equations.
//! Delays are in timer counts, angles in radians; n is the step number on a ramp from rest, i the step of the
//! move.

use std::f64::consts::E;

/// A motor on a timer.
#[derive(Clone, Copy, Debug)]
pub struct Counter {
    /// Timer counts per second, f.
    pub hz: f64,
    /// Angle of a step, α.
    pub step: f64,
}

/// The article's motor: 1 MHz and 1.8°.
pub const MOTOR: Counter = Counter { hz: 1e6, step: std::f64::consts::PI / 100.0 };

/// How a ramp by Eq 13 begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begin {
    /// Eq 7, and c1 = 0.4056 c0: n = 1 as a special case.
    Special,
    /// Eq 15: the inaccuracy at n = 1 ignored, c0 shorter instead.
    Short,
}

impl Counter {
    /// Eq 2: the speed of a delay, in rad/s.
    pub fn speed(self, c: f64) -> f64 {
        self.step * self.hz / c
    }

    /// Eq 2 solved for the delay of a speed.
    pub fn delay(self, speed: f64) -> f64 {
        self.step * self.hz / speed
    }

    /// Eq 3: the acceleration between two delays, in rad/s².
    pub fn accel(self, c1: f64, c2: f64) -> f64 {
        2.0 * self.step * self.hz * self.hz * (c1 - c2) / (c1 * c2 * (c1 + c2))
    }

    /// Eq 7: the first delay of an exact ramp.
    pub fn c0(self, accel: f64) -> f64 {
        self.hz * (2.0 * self.step / accel).sqrt()
    }

    /// Eq 8: the delay between pulse n and pulse n + 1 of an exact ramp.
    ///
    /// Computed as 1 / (√(n+1) + √n), which is equal and needs no subtraction.
    pub fn exact(self, accel: f64, n: f64) -> f64 {
        self.c0(accel) / ((n + 1.0).sqrt() + n.sqrt())
    }

    /// Eq 16: the step number of a speed on a ramp from rest.
    pub fn step_of(self, speed: f64, accel: f64) -> f64 {
        speed * speed / (2.0 * self.step * accel)
    }

    /// Eq 21: k of the power term.
    pub fn power(self, accel: f64, top: f64, p: i32) -> f64 {
        4.0 * (2.0 * self.step * accel / (top * top)).powi(p - 1)
    }

    /// Eq 23: the speed at the end of a transition from step n1 to step n2.
    pub fn top(self, accel: f64, n1: f64, n2: f64) -> f64 {
        let (from, to) = (n1 + 0.5, n2 + 0.5);
        (2.0 / E * self.step * accel * from * (to / from).powf(n2 / (n2 - n1))).sqrt()
    }

    /// Eq 23 solved for n2 at a top speed, not rounded.
    ///
    /// `None` if even the shortest transition is faster than the top speed.
    pub fn transition(self, accel: f64, n1: f64, top: f64) -> Option<f64> {
        let (mut low, mut high) = (n1 + 1.0, 1e18);
        if !(self.top(accel, n1, low) <= top && top <= self.top(accel, n1, high)) {
            return None;
        }
        // Eq 23 grows with n2. Bisection ends at the last bit.
        while low.midpoint(high) > low && low.midpoint(high) < high {
            let middle = low.midpoint(high);
            if self.top(accel, n1, middle) < top { low = middle } else { high = middle }
        }
        Some(high)
    }

    /// Eq 24: n2 of a transition that begins at rest, with the article's rounded 2/e.
    pub fn transition_from_rest(self, accel: f64, top: f64) -> f64 {
        (top * top / (0.736 * self.step * accel)).floor()
    }

    /// The first delays of a ramp that continues by Eq 13.
    pub fn begin(self, accel: f64, start: Begin) -> Vec<f64> {
        let c0 = self.c0(accel);
        match start {
            Begin::Special => vec![c0, 0.4056 * c0],
            Begin::Short => vec![0.676 * c0],
        }
    }
}

/// Eq 9, corrected: the exact c_n / c_{n−1}.
///
/// Both differences of roots on its right side are rewritten as sums, so that no digit is lost to a
/// subtraction.
pub fn exact_ratio(n: f64) -> f64 {
    (1.0 + (1.0 - 1.0 / n).sqrt()) / ((1.0 + 1.0 / n).sqrt() + 1.0)
}

/// Eq 11: the ratio of [`exact_ratio`] by the second-order approximation.
pub fn ratio(n: f64) -> f64 {
    (4.0 * n - 1.0) / (4.0 * n + 1.0)
}

/// Eq 13, and Eq 14 with n = i − m: the delay after c. n is anything but −1/4; a negative n decelerates.
pub fn next(c: f64, n: f64) -> f64 {
    c - 2.0 * c / (4.0 * n + 1.0)
}

/// Eq 12 with 4n + 1 ≈ 4n.
pub fn next_simple(c: f64, n: f64) -> f64 {
    c - c / (2.0 * n)
}

/// Eq 18: n for another acceleration at the same speed, signed.
pub fn renumber(n: f64, from: f64, to: f64) -> f64 {
    (n + 0.5) * from / to - 0.5
}

/// Eq 19: where a move of m steps begins to decelerate.
pub fn turning_point(m: f64, accel: f64, decel: f64) -> f64 {
    m * decel / (accel + decel)
}

/// Eq 20: the delay after c, with the power term k·n^p.
pub fn next_power(c: f64, n: f64, k: f64, p: i32) -> f64 {
    c - 2.0 * c / (4.0 * n + 1.0 + k * n.powi(p))
}

/// Eq 22 and 25: Eq 13 with the change scaled by a factor.
pub fn next_scaled(c: f64, n: f64, factor: f64) -> f64 {
    c - 2.0 * c / (4.0 * n + 1.0) * factor
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers in the article's text.
    #[test]
    fn the_text() {
        // "A maximum motor speed of 300rpm is then equivalent to a delay count of 1,000."
        let rpm = std::f64::consts::PI / 30.0;
        assert!((MOTOR.delay(300.0 * rpm) - 1000.0).abs() < 1e-9);
        assert!((MOTOR.delay(120.0 * rpm) - 2500.0).abs() < 1e-9);
        // 67.6 % and 88.6 %, and c1 = 0.4056 c0 so that both beginnings continue alike.
        assert!((0.6f64 * 0.676 - 0.4056).abs() < 1e-12);
        assert_eq!(format!("{:.3}", std::f64::consts::PI.sqrt() / 2.0), "0.886");
        // Γ(3/4) / (2 Γ(5/4)): the limit of the exact delay over the delay by Eq 11, from the same c0.
        let far = 1e6;
        let product = (1..=1_000_000).fold(1.0, |c, n| c * ratio(f64::from(n)));
        let short = 1.0 / ((far + 1.0f64).sqrt() + far.sqrt()) / product;
        assert_eq!(format!("{short:.6}"), "0.675978");
        // 2/e.
        assert_eq!(format!("{:.3}", 2.0 / E), "0.736");
    }

    /// Eq 3 of Eq 8's delays is nearly the acceleration; it is exactly the slope of the speeds at the
    /// middles of the intervals.
    #[test]
    fn equation_3_is_the_slope_of_the_speeds() {
        let (c1, c2) = (2813.0, 2806.0);
        let slope = (MOTOR.speed(c2) - MOTOR.speed(c1)) / ((c1 + c2) / 2.0 / MOTOR.hz);
        assert!((MOTOR.accel(c1, c2) / slope - 1.0).abs() < 1e-9);
        let (c1, c2) = (MOTOR.exact(10.0, 198.0), MOTOR.exact(10.0, 199.0));
        assert!((MOTOR.accel(c1, c2) - 10.0).abs() < 1e-3);
    }

    #[test]
    fn equation_23_turns_round() {
        for n1 in [0.0, 18.0, 98.0] {
            let n2 = MOTOR.transition(10.0, n1, 12.0).unwrap();
            assert!((MOTOR.top(10.0, n1, n2) - 12.0).abs() < 1e-9, "{n1}");
        }
        assert_eq!(MOTOR.transition(10.0, 1000.0, 12.0), None);
        // The same for a very long transition.
        let n2 = MOTOR.transition(1e-9, 1e8, 12.0).unwrap();
        assert!(n2 > 1e9 && (MOTOR.top(1e-9, 1e8, n2) - 12.0).abs() < 1e-9, "{n2}");
        // Eq 24 is Eq 23 from rest, up to the half step and the rounded 2/e.
        let n2 = MOTOR.transition(10.0, 0.0, 10.0).unwrap();
        assert!((n2 - MOTOR.transition_from_rest(10.0, 10.0)).abs() < 1.0, "{n2}");
    }
}
