//! Compares the steps of a chip with those of the virtual board.

use anyhow::{Context, Result, ensure};

use super::dump::Dump;

/// A step: its time in cycles, and its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    pub time: f64,
    pub forward: bool,
}

/// The steps of a motor, from its wires STEP and DIR.
pub fn steps(dump: &Dump, step: &str, dir: &str) -> Result<Vec<Step>> {
    let mut turns = dump.wire(dir)?.iter().peekable();
    let mut forward = false;
    let rises = dump.wire(step)?.iter().filter(|(_, level)| *level);
    Ok(rises
        .map(|&(time, _)| {
            while let Some((_, level)) = turns.next_if(|turn| turn.0 <= time) {
                forward = *level;
            }
            Step { time, forward }
        })
        .collect())
}

/// The first step of any motor.
pub fn first(motors: &[Vec<Step>]) -> f64 {
    motors.iter().flatten().map(|step| step.time).fold(f64::MAX, f64::min)
}

/// The largest difference between steps of `real`, whose time begins at `begun.0`, and those of
/// `ideal`, whose begins at `begun.1`, in cycles.
///
/// # Errors
/// The number or the directions of the steps differ.
pub fn worst(real: &[Step], ideal: &[Step], begun: (f64, f64)) -> Result<f64> {
    ensure!(real.len() == ideal.len(), "{} steps instead of {}", real.len(), ideal.len());
    let mut worst = 0f64;
    for (n, (real, ideal)) in real.iter().zip(ideal).enumerate() {
        ensure!(real.forward == ideal.forward, "step {n} leads the wrong way");
        worst = worst.max(((real.time - begun.0) - (ideal.time - begun.1)).abs());
    }
    Ok(worst)
}

/// Like [`worst`], for a motor that runs until it is stopped, at another moment in each: compares
/// from its first step into the cruise, and from there to its last step.
///
/// # Errors
/// As in [`worst`]; or a motor never reaches a cruise.
pub fn worst_of_runs(real: &[Step], ideal: &[Step], bound: f64) -> Result<f64> {
    let half = real.len().min(ideal.len()) / 2;
    ensure!(half > 10, "{} steps, and {}", real.len(), ideal.len());
    for steps in [real, ideal] {
        let interval = |n: usize| steps[n].time - steps[n - 1].time;
        let cruise = (1..steps.len()).map(interval).fold(f64::MAX, f64::min);
        for middle in [half, steps.len() - half] {
            let off = interval(middle) - cruise;
            ensure!(off <= bound, "step {middle} is not of the cruise: {off} cycles more");
        }
    }
    let (real_end, ideal_end) = (&real[real.len() - half..], &ideal[ideal.len() - half..]);
    let begun = (real[0].time, ideal[0].time);
    let ended = (real_end[half - 1].time, ideal_end[half - 1].time);
    Ok(worst(&real[..half], &ideal[..half], begun)?.max(worst(real_end, ideal_end, ended)?))
}

/// Like [`worst`], for a homing: compares each way between two turns from its first step on,
/// because the host orders them one after another.
///
/// # Errors
/// As in [`worst`]; or the ways differ in number or direction.
pub fn worst_of_ways(real: &[Step], ideal: &[Step]) -> Result<f64> {
    let ways = |steps: &[Step]| -> Vec<Vec<Step>> {
        steps.chunk_by(|a, b| a.forward == b.forward).map(<[Step]>::to_vec).collect()
    };
    let (real, ideal) = (ways(real), ways(ideal));
    ensure!(!ideal.is_empty(), "no step");
    ensure!(real.len() == ideal.len(), "{} ways instead of {}", real.len(), ideal.len());
    let mut all = 0f64;
    for (n, (real, ideal)) in real.iter().zip(&ideal).enumerate() {
        let begun = (real[0].time, ideal[0].time);
        all = all.max(worst(real, ideal, begun).with_context(|| format!("way {n}"))?);
    }
    Ok(all)
}

/// The level of several wires from each change on, as bits.
pub fn levels(dump: &Dump, wires: &[&str]) -> Result<Vec<(f64, u8)>> {
    let mut all: Vec<(f64, u8, bool)> = Vec::new();
    for (bit, wire) in wires.iter().enumerate() {
        all.extend(dump.wire(wire)?.iter().map(|&(time, level)| (time, 1 << bit, level)));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut levels, mut now): (Vec<(f64, u8)>, u8) = (Vec::new(), 0);
    for (time, bit, level) in all {
        now = if level { now | bit } else { now & !bit };
        match levels.last_mut() {
            Some(last) if last.0 == time => last.1 = now,
            _ => levels.push((time, now)),
        }
    }
    Ok(levels)
}

/// The largest difference between the changes of two such motors, from their first changes on, in
/// cycles.
///
/// # Errors
/// The patterns differ; `real` has fewer changes, or with `whole` a different number.
pub fn worst_of_levels(real: &[(f64, u8)], ideal: &[(f64, u8)], whole: bool) -> Result<f64> {
    let (made, wanted) = (real.len(), ideal.len());
    ensure!(wanted > 0 && made >= wanted, "{made} steps instead of {wanted}");
    ensure!(!whole || made == wanted, "{made} steps instead of {wanted}");
    let begun = (real[0].0, ideal[0].0);
    let mut worst = 0f64;
    for (n, (real, ideal)) in real.iter().zip(ideal).enumerate() {
        ensure!(real.1 == ideal.1, "step {n}: {:02b} instead of {:02b}", real.1, ideal.1);
        worst = worst.max(((real.0 - begun.0) - (ideal.0 - begun.1)).abs());
    }
    Ok(worst)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(times: &[f64]) -> Vec<Step> {
        times.iter().map(|&time| Step { time, forward: true }).collect()
    }

    #[test]
    fn a_step_that_is_off_missing_or_turned_is_seen() {
        let ideal = at(&[0.0, 100.0, 200.0]);
        assert_eq!(worst(&at(&[7.0, 110.0, 204.0]), &ideal, (7.0, 0.0)).unwrap(), 3.0);
        assert!(worst(&at(&[0.0, 100.0]), &ideal, (0.0, 0.0)).is_err());
        let mut turned = ideal.clone();
        turned[1].forward = false;
        assert!(worst(&turned, &ideal, (0.0, 0.0)).is_err());
        assert_eq!(first(&[at(&[9.0]), Vec::new(), ideal]), 0.0);
    }

    /// A ramp, a cruise and a ramp: the stop comes later, and the ramps are equal.
    #[test]
    fn runs_are_compared_at_both_ends() {
        let run = |cruise: usize, last: f64| {
            let ramp = (1..20).map(|n| 2000.0 - 100.0 * f64::from(n)).chain(Vec::new());
            let down = (1..20).rev().map(|n| 2000.0 - 100.0 * f64::from(n)).chain([last]);
            let flat = std::iter::repeat_n(100.0, cruise);
            let sum = |at: &mut f64, by: f64| Some(std::mem::replace(at, *at + by));
            at(&ramp.chain(flat).chain(down).scan(0.0, sum).collect::<Vec<_>>())
        };
        let ideal = run(100, 0.0);
        assert_eq!(worst_of_runs(&run(180, 0.0), &ideal, 1.0).unwrap(), 0.0);
        let mut late = run(180, 0.0);
        let end = late.len() - 5;
        late[end].time += 30.0;
        assert_eq!(worst_of_runs(&late, &ideal, 1.0).unwrap(), 30.0);
        assert!(worst_of_runs(&ideal[..25], &ideal, 1.0).is_err(), "cut off on its ramp");
    }

    #[test]
    fn ways_are_compared_between_turns() {
        let way = |from: f64, count: u32, forward: bool| -> Vec<Step> {
            (0..count).map(|n| Step { time: from + 100.0 * f64::from(n), forward }).collect()
        };
        let homing = |steps, pause: f64| {
            [way(0.0, steps, false), way(5000.0 + pause, 5, true), way(9000.0, 7, false)].concat()
        };
        let ideal = homing(30, 0.0);
        assert_eq!(worst_of_ways(&homing(30, 700.0), &ideal).unwrap(), 0.0);
        assert!(worst_of_ways(&homing(31, 0.0), &ideal).is_err(), "halted a step later");
        assert!(worst_of_ways(&ideal[..35], &ideal).is_err(), "a way is missing");
        let mut late = ideal.clone();
        late[33].time += 40.0;
        assert_eq!(worst_of_ways(&late, &ideal).unwrap(), 40.0);
    }

    #[test]
    fn patterns_are_compared_from_their_first_change_on() {
        let ideal = [(5.0, 1), (15.0, 3), (25.0, 2)];
        let real = [(105.0, 1), (117.0, 3), (125.0, 2), (135.0, 0)];
        assert_eq!(worst_of_levels(&real, &ideal, false).unwrap(), 2.0);
        assert!(worst_of_levels(&real, &ideal, true).is_err());
        assert!(worst_of_levels(&real[..2], &ideal, false).is_err());
        assert!(worst_of_levels(&[(0.0, 2), (10.0, 3), (20.0, 1)], &ideal, true).is_err());
    }
}
