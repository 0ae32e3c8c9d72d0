//! A sequence of delays as curves and as rows.

use crate::equations::Counter;
use crate::sheet::Cell;
use stepwright_plot::{Curve, PALETTE};

/// One curve of a figure: the delays of a move.
#[derive(Clone, Debug)]
pub struct Trace {
    /// The name in the legend.
    pub name: String,
    /// The motor that moves.
    pub motor: Counter,
    /// c0, c1 … in timer counts.
    pub delays: Vec<f64>,
}

/// The grey of a curve that others are compared with.
pub const GREY: usize = 5;

impl Trace {
    /// Seconds from pulse 0 to each pulse.
    pub fn times(&self) -> Vec<f64> {
        let mut counts = 0.0;
        let time = |c: &f64| {
            counts += c;
            counts / self.motor.hz
        };
        std::iter::once(0.0).chain(self.delays.iter().map(time)).collect()
    }

    /// The sum of all delays in seconds.
    pub fn seconds(&self) -> f64 {
        self.times().last().copied().unwrap_or(0.0)
    }

    /// The highest speed, in rad/s.
    pub fn peak(&self) -> f64 {
        self.motor.speed(self.delays.iter().copied().fold(f64::INFINITY, f64::min))
    }

    /// The speed at a time, in rad/s; after the end the last speed.
    pub fn speed_at(&self, seconds: f64) -> f64 {
        let passed = self.times().iter().skip(1).take_while(|&&t| t <= seconds).count();
        let c = self.delays.get(passed).or(self.delays.last());
        c.map_or(0.0, |&c| self.motor.speed(c))
    }

    /// Speed over time as it changes from step to step, by Eq 2, in `unit` per rad/s.
    pub fn stairs(&self, colour: usize, unit: f64) -> Curve {
        let times = self.times();
        let step = |(c, t): (&f64, &[f64])| {
            let speed = self.motor.speed(*c) * unit;
            [(t[0], speed), (t[1], speed)]
        };
        let points = self.delays.iter().zip(times.windows(2)).flat_map(step).collect();
        Curve { name: self.name.clone(), colour: PALETTE[colour], points, ..Curve::default() }
    }

    /// Speed in the middle of each interval over time, in rad/s.
    pub fn line(&self, colour: usize) -> Curve {
        let times = self.times();
        let middle = |(c, t): (&f64, &[f64])| (t[0].midpoint(t[1]), self.motor.speed(*c));
        let points = self.delays.iter().zip(times.windows(2)).map(middle).collect();
        Curve { name: self.name.clone(), colour: PALETTE[colour], points, ..Curve::default() }
    }

    /// Acceleration by Eq 3 at the pulses between two delays, in rad/s².
    pub fn accels(&self, colour: usize) -> Curve {
        let times = self.times();
        let at = |(c, t): (&[f64], &f64)| (*t, self.motor.accel(c[0], c[1]));
        let points = self.delays.windows(2).zip(&times[1..]).map(at).collect();
        Curve { name: self.name.clone(), colour: PALETTE[colour], points, ..Curve::default() }
    }

    /// Keys and headings of the rows.
    pub const COLUMNS: [(&'static str, &'static str); 6] = [
        ("curve", "curve"),
        ("step", "step"),
        ("delay", "delay"),
        ("time_s", "time, s"),
        ("speed_rad_s", "ω, rad/s"),
        ("accel_rad_s2", "ω′ (3), rad/s²"),
    ];

    /// Every delay: its number, its start, its speed, and the acceleration from the delay before.
    pub fn rows(&self) -> impl Iterator<Item = Vec<Cell>> + '_ {
        let times = self.times();
        self.delays.iter().enumerate().map(move |(i, &c)| {
            let accel = i.checked_sub(1).and_then(|i| self.delays.get(i));
            let accel = accel.map(|&before| Cell::fixed(self.motor.accel(before, c), 4));
            vec![
                self.name.as_str().into(),
                (i as i64).into(),
                Cell::fixed(c, 3),
                Cell::fixed(times[i], 6),
                Cell::fixed(self.motor.speed(c), 5),
                accel.into(),
            ]
        })
    }
}

/// A dashed line that other curves are compared with.
pub fn target(name: &str, points: Vec<(f64, f64)>) -> Curve {
    Curve { name: name.into(), colour: PALETTE[GREY], points, dashed: true, ..Curve::default() }
}
