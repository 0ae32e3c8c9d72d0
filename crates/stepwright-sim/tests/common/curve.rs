//! The independent curve: what an order should do, in f64 on the line of
//! the Nano slave.

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
    /// Corners and peak: where the rise ends, where the fall begins.
    fn corners(&self) -> (f64, f64, f64) {
        let start = self.start.min(self.top);
        let gain = self.top * self.top - start * start;
        let (s1, s2) = (gain / (2.0 * self.a), self.length - gain / (2.0 * self.d));
        if s1 <= s2 {
            return (s1, s2, self.top);
        }
        let s = self.length * self.d / (self.a + self.d);
        (s, s, (start * start + 2.0 * self.a * s).sqrt())
    }

    /// Speed at pulse n.
    pub fn speed(&self, n: f64) -> f64 {
        let start = self.start.min(self.top);
        let (s1, s2, peak) = self.corners();
        if n < s1 {
            (start * start + 2.0 * self.a * n).sqrt()
        } else if n <= s2 {
            peak
        } else {
            (start * start + 2.0 * self.d * (self.length - n)).sqrt()
        }
    }

    /// Ticks from the first pulse to pulse n.
    pub fn time(&self, n: f64) -> f64 {
        let start = self.start.min(self.top);
        let (s1, s2, peak) = self.corners();
        let mut t = (self.speed(n.min(s1)).min(peak) - start) / self.a;
        if n > s1 {
            t += (n.min(s2) - s1) / peak;
        }
        if n > s2 {
            t += (peak - self.speed(n)) / self.d;
        }
        t * self.hz
    }

    /// Steps that a stop from pulse n takes: the way to rest, rounded up. Two
    /// answers where a hair decides.
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

    /// Ticks from pulse n to the i-th of `steps` steps to rest: on at the same
    /// speed for what is left over of a step, then the fall.
    pub fn stop_time(&self, n: f64, steps: u32, i: u32) -> f64 {
        let v = self.speed(n);
        let start = self.start.min(self.top).min(v);
        let wait = (f64::from(steps) - self.stop_way(n)).max(0.0);
        // From the end, where a difference of squares would lose everything.
        let left = f64::from(steps - i).min(self.stop_way(n));
        let speed = (start * start + 2.0 * self.d * left).sqrt();
        (wait.min(i.into()) / v + (v - speed) / self.d) * self.hz
    }
}
