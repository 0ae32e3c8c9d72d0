//! The jerk of a motion, from its accelerations.

/// The number of accelerations on either side of a time from whose slope the jerk is taken.
const BESIDE: usize = 2;

/// Seconds and steps/s³, from accelerations in the order of time: the slope of the best-fitting
/// line through the neighbours of each. Only two neighbours would show the ticks of the timer.
pub(crate) fn jerk(accels: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let around = |n: usize| {
        let near = &accels[n.saturating_sub(BESIDE)..(n + BESIDE + 1).min(accels.len())];
        Some((accels[n].0, slope(near)?))
    };
    (0..accels.len()).filter_map(around).collect()
}

/// The slope of the best-fitting line.
fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let across: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let along: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    (across > 0.0).then(|| along / across)
}

#[cfg(test)]
mod tests {
    use super::jerk;

    #[test]
    fn an_even_rise_has_one_jerk_and_noise_little() {
        let noisy = |n: i32| (f64::from(n) * 0.01, f64::from(n) * 40.0 + f64::from(n % 2));
        let points = jerk(&(0..100).map(noisy).collect::<Vec<_>>());
        assert_eq!(points.len(), 100);
        assert!(points.iter().all(|(_, jerk)| (jerk - 4000.0).abs() < 60.0), "{points:?}");
    }

    #[test]
    fn of_one_acceleration_nothing_is_known() {
        assert!(jerk(&[]).is_empty() && jerk(&[(0.0, 3.0)]).is_empty());
        assert!(jerk(&[(1.0, 3.0), (1.0, 4.0)]).is_empty());
    }
}
