//! How much longer routes take than an offline optimum, as executed: to the end of their last step.
//!
//! `STEPWRIGHT_OPTIMA` sets the number of random paths. Only the first few have bounds. docs/paths.md has the
//! figures of 60.

use crate::optimal::paths::{Kinds, Path};
use crate::optimal::{self, Grid};

/// The optimum with which a path is compared.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Best {
    /// The least time within the acceleration, and the same with the speed limited to that at which the path
    /// can turn.
    Accel,
    Level,
    /// The least time with the jerk limited along the path, and a smooth speed over corners; and the least time
    /// with the law of jerk of each axis, in turning and at corners.
    Even,
    Jerk,
}

/// The per cent by which a path takes longer than its optimum.
fn over<const N: usize>(seed: u64, kinds: Kinds, best: Best) -> f64 {
    let path: Path<N> = Path::random(seed, kinds);
    let smooth = best == Best::Even || best == Best::Jerk;
    let axes = path.axes(smooth);
    let grid = Grid::new(&path.pieces, &axes, best == Best::Level);
    let least = if smooth {
        optimal::barrier::fastest(&grid, &axes, best == Best::Jerk)
    } else {
        grid.time(&optimal::passes::fastest(&grid, &axes), false)
    };
    assert!(least.is_finite() && least > 0.0);
    let executed = path.executed(smooth);
    let over = 100.0 * (executed / least - 1.0);
    println!("path {seed} of {N} axes: {executed:.3} s, at best {least:.3} s, {over:+.2} %");
    over
}

/// The mean and the largest value of the first `daily` paths. The variable sets how many are printed.
fn spread(daily: u64, kinds: Kinds, best: Best) -> [f64; 2] {
    let count = std::env::var("STEPWRIGHT_OPTIMA")
        .map_or(daily, |text| text.parse().expect("a number of paths"))
        .max(daily);
    let one = |seed: u64| {
        if seed.is_multiple_of(2) {
            over::<2>(seed, kinds, best)
        } else {
            over::<3>(seed, kinds, best)
        }
    };
    let each: Vec<f64> = (0..count).map(one).collect();
    let [mean, most] = mean_and_most(&each);
    let least = each.iter().copied().fold(f64::INFINITY, f64::min);
    let within = each.iter().filter(|over| **over <= 2.0).count();
    println!(
        "{count} paths of {kinds:?} beside {best:?}: {mean:+.2} % in the mean, {least:+.2} to \
         {most:+.2} %, {within} within 2 %"
    );
    if best != Best::Even {
        // An optimum that is slower than the route would be wrong. The error of the grid is below this.
        assert!(least > -0.1, "{least} %");
    }
    mean_and_most(&each[..daily as usize])
}

fn mean_and_most(each: &[f64]) -> [f64; 2] {
    let mean = each.iter().sum::<f64>() / each.len() as f64;
    [mean, each.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
}

#[test]
fn paths_without_jerk_are_near_their_optimum() {
    let [mean, most] = spread(12, Kinds::All, Best::Level);
    assert!(mean <= 0.4 && most <= 2.0, "{mean} %, {most} %");
    let [mean, most] = spread(12, Kinds::All, Best::Accel);
    assert!(mean <= 0.6 && most <= 2.0, "{mean} %, {most} %");
}

/// No faster speed keeps the law of jerk and the jerk along each line.
#[test]
fn lines_with_jerk_are_as_near_to_their_optimum_as_they_were() {
    let [mean, most] = spread(1, Kinds::Lines, Best::Jerk);
    assert!(mean <= 5.2 && most <= 5.2, "{mean} %, {most} %");
}

/// The acceleration of this optimum is continuous over corners. That of a route jumps there, where the law
/// allows it, so the route is faster.
#[test]
fn lines_with_jerk_are_faster_than_without_jumps_of_acceleration() {
    let [mean, most] = spread(2, Kinds::Lines, Best::Even);
    assert!(mean <= -7.8 && most <= -4.4, "{mean} %, {most} %");
}

/// This optimum does not limit the jerk of turning either, which no motor can follow.
#[test]
fn curves_with_jerk_are_as_near_to_it_as_they_were() {
    let [mean, most] = spread(2, Kinds::All, Best::Even);
    assert!(mean <= 0.0 && most <= 1.7, "{mean} %, {most} %");
}

/// Speeds that a search for binding nodes lowered must not stay low in the next plan: these paths would take up
/// to 60 % longer. Nor must unequal axes have the smallest acceleration of the whole way everywhere.
#[test]
fn curves_of_unequal_axes_take_no_longer_than_they_did() {
    let time = |seed: u64| match seed % 2 {
        0 => Path::<2>::random(seed, Kinds::All).executed(true),
        _ => Path::<3>::random(seed, Kinds::All).executed(true),
    };
    for (seed, most) in [(152, 2.74), (320, 3.10), (222, 3.29), (35, 2.94)] {
        assert!(time(seed) <= most, "path {seed}: {} s", time(seed));
    }
    let all: f64 = (0..100).map(time).sum();
    assert!(all <= 340.5, "{all} s");
}
