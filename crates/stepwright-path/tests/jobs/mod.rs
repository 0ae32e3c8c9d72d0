//! Jobs with which other planners were measured: mm, mm/s, 80 steps/mm, 1000 mm/s², a jump of 5 mm/s.
//! docs/paths.md has the table.

use std::f64::consts::{PI, TAU};

use stepwright_path::{AxisPace, Route};

pub const AXIS: AxisPace =
    AxisPace { step: 0.0125, speed: 300.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };

/// Random numbers in 0..1 from a seed.
pub struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Places, and the feed to each.
pub type Job = Vec<([f64; 2], f64)>;

/// A circle of 20 mm in chords of 0.5 mm, four times, reached from its centre at 50 mm/s.
pub fn circle(feed: f64) -> Job {
    let place = |n: u32| {
        let angle = TAU * f64::from(n) / 251.0;
        [20.0 * angle.cos(), 20.0 * angle.sin()]
    };
    let chords = (1..=4 * 251).map(|n| (place(n), feed));
    [([20.0, 0.0], 50.0)].into_iter().chain(chords).collect()
}

/// 400 lines between random places of a square of 100 mm, at 100 mm/s. Of the first hundred seeds, the one
/// whose lines are nearest to the length of the published job, 21,240 mm.
pub fn lines() -> Job {
    let job = |seed| {
        let mut dice = Dice(seed);
        (0..400).map(|_| ([100.0 * dice.roll(), 100.0 * dice.roll()], 100.0)).collect::<Job>()
    };
    let off = |job: &Job| (length(job) - 21_240.0).abs();
    (0..100).map(job).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
}

/// 60 passes of 60 mm, 0.4 mm apart, at 100 mm/s.
pub fn raster() -> Job {
    let passes = (0..60u32).flat_map(|n| {
        let (x, y) = (if n.is_multiple_of(2) { 60.0 } else { 0.0 }, 0.4 * f64::from(n));
        [([x, y], 100.0), ([x, y + 0.4], 100.0)]
    });
    passes.collect()
}

/// 40 legs of 10 mm in chords of 0.2 mm, X and Y in turn, at 100 mm/s.
pub fn staircase() -> Job {
    let (mut at, mut job) = ([0.0f64; 2], Vec::new());
    for leg in 0..40 {
        let from = at[leg % 2];
        for n in 1..=50 {
            at[leg % 2] = from + 0.2 * f64::from(n);
            job.push((at, 100.0));
        }
    }
    job
}

/// 20 half circles of 4 mm, left and right in turn, in chords of 0.1 mm.
pub fn arcs(feed: f64) -> Job {
    let count = (PI * 4.0 / 0.1).round();
    let half = |k: u32| {
        (1..=count as u32).map(move |n| {
            let (angle, up) =
                (PI * f64::from(n) / count, if k.is_multiple_of(2) { 1.0 } else { -1.0 });
            let x = 4.0 + 8.0 * f64::from(k) - 4.0 * angle.cos();
            ([x, up * 4.0 * angle.sin()], feed)
        })
    };
    (0..20).flat_map(half).collect()
}

/// A closed curve of 1003.5 mm in 3,548 chords, at 50 mm/s. It replaces the published job, whose file is lost,
/// and is fitted to its seven published figures (docs/paths.md).
pub fn organic() -> Job {
    let place = |n: u32| {
        let t = TAU * f64::from(n) / 3_548.0;
        let wave = 0.085_816 * (7.0 * t).cos()
            + 0.228_091 * (41.0 * t + 4.993_197).cos()
            + 0.055_360 * (82.0 * t + 2.258_980).cos();
        let r = 23.417_771 * (1.0 + wave);
        ([r * t.cos(), r * t.sin()], 50.0)
    };
    (0..=3_548).map(place).collect()
}

/// A circle of 50 mm, three times, in chords of this length, at 300 mm/s.
pub fn chords(chord: f64) -> Job {
    let angle = 2.0 * (chord / 100.0).asin();
    let place = |n: u32| {
        let angle = angle * f64::from(n);
        [50.0 * angle.cos() - 50.0, 50.0 * angle.sin()]
    };
    (1..=(3.0 * TAU / angle) as u32).map(|n| (place(n), 300.0)).collect()
}

pub fn length(job: &Job) -> f64 {
    let mut at = [0.0; 2];
    let way = |(to, _): &([f64; 2], f64)| {
        let from = std::mem::replace(&mut at, *to);
        (to[0] - from[0]).hypot(to[1] - from[1])
    };
    job.iter().map(way).sum()
}

/// The time of a job, in s.
pub fn time(job: &Job, route: Route<2>) -> f64 {
    let (mut route, mut time) = (route, 0.0);
    for (to, feed) in job {
        route.line_to(*to, *feed).unwrap();
        while let Some(stretch) = route.pass_over() {
            time = stretch.end();
        }
    }
    route.close();
    while let Some(stretch) = route.pass_over() {
        time = stretch.end();
    }
    assert!(route.is_over());
    time
}
