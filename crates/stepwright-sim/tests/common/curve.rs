//! The independent curve: the course of an order, and of a stop on its way.

use stepwright_oracle::IdealTrapezoid;

/// A travel in real numbers: speeds in steps/s, a and d in steps/s².
#[derive(Clone, Copy, Debug)]
pub struct Curve {
    pub hz: f64,
    pub start: f64,
    pub top: f64,
    pub a: f64,
    pub d: f64,
    /// Steps between the first and the last pulse; infinite if endless.
    pub length: f64,
}

impl Curve {
    /// The curve by the oracle.
    fn ideal(&self) -> IdealTrapezoid<f64> {
        let slopes = (2.0 * self.a, 2.0 * self.d);
        IdealTrapezoid::new((self.start, self.start), self.top, slopes, self.length)
    }

    /// The speed at pulse n.
    pub fn speed(&self, n: f64) -> f64 {
        self.ideal().speed(n)
    }

    /// Ticks from the first pulse to pulse n.
    pub fn time(&self, n: f64) -> f64 {
        self.ideal().time(n) * self.hz
    }

    /// The steps of a stop from pulse n: the way to rest, rounded up. Two answers where rounding decides.
    pub fn stop_steps(&self, n: f64) -> [u32; 2] {
        let way = self.stop_way(n);
        let hair = 1e-7 * way.max(1.0);
        [(way - hair).max(0.0).ceil() as u32, (way + hair).ceil() as u32]
    }

    fn stop_way(&self, n: f64) -> f64 {
        let v = self.speed(n);
        let start = self.start.min(self.top).min(v);
        (v * v - start * start) / (2.0 * self.d)
    }

    /// Ticks from pulse n to the i-th of `steps` steps to rest: the rest of a step at constant speed, then the
    /// fall.
    pub fn stop_time(&self, n: f64, steps: u32, i: u32) -> f64 {
        let v = self.speed(n);
        let start = self.start.min(self.top).min(v);
        let wait = (f64::from(steps) - self.stop_way(n)).max(0.0);
        // From the end, as a difference of squares would lose all precision.
        let left = f64::from(steps - i).min(self.stop_way(n));
        let speed = (start * start + 2.0 * self.d * left).sqrt();
        (wait.min(i.into()) / v + (v - speed) / self.d) * self.hz
    }
}
