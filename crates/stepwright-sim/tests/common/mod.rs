//! The independent curve: what an order should do, in f64 on the line of
//! document 004, and pulses rebuilt from edges alone.

use stepwright_sim::{Edge, Pin};

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

/// The steps of one axis, rebuilt from the edges of STEP and DIR: times and
/// the position after each.
pub fn steps_of(edges: &[Edge], axis: u8) -> Vec<(u64, i64)> {
    let (mut forward, mut position) = (true, 0i64);
    let mut steps = Vec::new();
    for edge in edges.iter().filter(|edge| edge.axis == axis) {
        match edge.pin {
            Pin::Direction => forward = edge.level,
            Pin::Step if edge.level => {
                position += if forward { 1 } else { -1 };
                steps.push((edge.time, position));
            }
            Pin::Step => {}
        }
    }
    steps
}

/// Pulse width, direction set-up and hold, as the driver sees them.
pub fn check_timing(edges: &[Edge], pulse: u64, setup: u64, hold: u64, min: u64) {
    for axis in 0..3 {
        let (mut rise, mut turn, mut high) = (None::<u64>, None::<u64>, false);
        for edge in edges.iter().filter(|edge| edge.axis == axis) {
            let t = edge.time;
            match (edge.pin, edge.level) {
                (Pin::Step, true) => {
                    assert!(!high, "axis {axis} rises twice");
                    if let Some(rise) = rise {
                        assert!(t - rise >= min, "axis {axis}: {} ticks apart at {t}", t - rise);
                    }
                    if let Some(turn) = turn {
                        assert!(t - turn >= setup, "axis {axis}: set-up {} at {t}", t - turn);
                    }
                    (rise, high) = (Some(t), true);
                }
                (Pin::Step, false) => {
                    assert!(high && t - rise.unwrap() >= pulse, "axis {axis}: pulse at {t}");
                    high = false;
                }
                (Pin::Direction, _) => {
                    if let Some(rise) = rise {
                        assert!(t - rise >= hold, "axis {axis}: hold {} at {t}", t - rise);
                    }
                    turn = Some(t);
                }
            }
        }
        assert!(!high, "axis {axis} is left high");
    }
}
