//! Whether an axis that left its path came to rest by its own deceleration: from the times of its edges
//! and those of its path. It knows no record, no entry and no law of a board.
//!
//! ```text
//!   v │▔▔▔▔▔▔▔╲                   between the means over two spans side by side, t₀ … t₁ … t₂,
//!     │ path   ╲ braked           v₀₁ − v₁₂ ≤ a·(t₂ − t₀)/2, for spans of each length;
//!     │         ╲                 behind the last step there is less than one step left to go:
//!     └──────────╲──── t          v²/2a < 1
//! ```

use super::{HZ, Step};

/// Steps keep to the path by this much: beyond it an axis is off the path, in s.
const OFF: f64 = 60e-6;
/// An edge is off by at most this much, in s, as interrupts of other axes come in between …
const LATE: f64 = 16e-6;
/// … or by this part of a step, as a brake falls by stairs.
const PART: f64 = 1.0 / 8.0;
/// A deceleration may be larger by this part.
const MARGIN: f64 = 1.01;

/// What an axis did after the path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Verdict {
    /// Steps of the path, and behind it.
    pub kept: usize,
    pub braked: usize,
    /// When it made the last step of the path, in s from the first.
    pub left: f64,
    /// The largest part of the deceleration that its edges prove.
    pub steepest: f64,
    /// The speed at the end of the path, in steps/s.
    pub speed: f64,
}

/// Judges an axis: its steps in cycles, what it was to do, its deceleration in steps/s².
///
/// # Errors
/// What it did that it may not, in a sentence.
pub fn judge(steps: &[(u64, bool)], path: &[Step], decel: f64) -> Result<Verdict, String> {
    let (Some(first), Some(begin)) = (steps.first(), path.first()) else {
        return if steps.is_empty() { Ok(Verdict::default()) } else { Err("it moves".into()) };
    };
    let made: Vec<f64> = steps.iter().map(|step| (step.0 - first.0) as f64 / HZ).collect();
    let asked: Vec<f64> = path.iter().map(|step| step.0 - begin.0).collect();
    let kept = made.iter().zip(&asked).take_while(|(made, asked)| (*made - *asked).abs() < OFF);
    let kept = kept.count();
    if let Some(n) = (0..kept).find(|n| steps[*n].1 != path[*n].1) {
        return Err(format!("step {n} goes the other way"));
    }
    let last = kept - 1;
    let braked = made.len() - kept;
    let mut verdict = Verdict { kept, braked, left: made[last], ..Verdict::default() };
    if kept == path.len() && braked == 0 {
        return Ok(verdict);
    }
    if steps[last..].iter().any(|step| step.1 != steps[last].1) {
        return Err(format!("it turns behind step {last}, off the path"));
    }
    let mean = |from: usize, to: usize| (to - from) as f64 / (made[to] - made[from]);
    // How far a mean may be off.
    let noise =
        |from: usize, to: usize| (mean(from, to) * LATE).max(PART) / (made[to] - made[from]);
    let mut span = 1;
    while span <= made.len() {
        // From the last span of the path on, the first half of which is of the path, or of what it braked;
        // what the path itself slows down there is its own.
        for from in last.saturating_sub(span)..made.len().saturating_sub(2 * span) {
            let (middle, to) = (from + span, from + 2 * span);
            let fell = mean(from, middle) - mean(middle, to);
            let own = if from >= last {
                0.0
            } else if middle <= last
                && to < path.len()
                && path[from..=to].iter().all(|step| step.1 == path[to].1)
            {
                let asked = |from: usize, to: usize| (to - from) as f64 / (asked[to] - asked[from]);
                // It may be left where it is slowest.
                let slowest = (from..last).map(|n| asked(n, n + 1)).fold(f64::MAX, f64::min);
                let begun = asked(from, middle);
                (begun - asked(middle, to)).max(begun - slowest).max(0.0)
            } else {
                // It turns or rests there; or half of it is braked, and judged with what follows.
                continue;
            };
            let sure = fell - own - noise(from, middle) - noise(middle, to);
            let part = 2.0 * sure / (made[to] - made[from]) / decel;
            verdict.steepest = verdict.steepest.max(part);
            if part > MARGIN {
                return Err(format!(
                    "{part:.2} of its deceleration over {span} steps behind step {from}, {} s after the path",
                    made[from] - made[last]
                ));
            }
        }
        span *= 2;
    }
    // The speed at the last step, by each span that ends there.
    let end = made.len() - 1;
    let mut speed = 0.0f64;
    let mut span = 1;
    while span <= end {
        let took = made[end] - made[end - span];
        if end - span >= last || span == 1 {
            speed = speed.max(mean(end - span, end) - decel * took / 2.0 - noise(end - span, end));
        }
        span *= 2;
    }
    if braked == 0 {
        // Where the path itself rests or turns, so may the axis.
        speed = match path.get(kept) {
            Some(next) if next.1 == steps[last].1 => speed.min(1.0 / (asked[kept] - asked[last])),
            _ => 0.0,
        };
    }
    if speed * speed / (2.0 * decel) > MARGIN {
        return Err(format!(
            "it stops dead at {speed:.1} steps/s behind step {end}, {braked} off the path"
        ));
    }
    let near = (0..last).rev().find(|n| made[last] - made[*n] > 2e-3).unwrap_or(0);
    let before = if last > near { mean(near, last) } else { 0.0 };
    let after = if braked > 0 { mean(last, last + 1) } else { 0.0 };
    verdict.speed = before.max(after);
    let way = verdict.speed * verdict.speed / (2.0 * decel);
    if braked as f64 > 1.2 * way + 6.0 {
        return Err(format!("{braked} steps from {:.1} steps/s, not {way:.0}", verdict.speed));
    }
    Ok(verdict)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path at a speed, left after 100 steps by a deceleration, to rest or until a step of it.
    fn braked(speed: f64, decel: f64, steps: usize) -> (Vec<(u64, bool)>, Vec<Step>) {
        let path: Vec<Step> = (0..1_000).map(|n| (f64::from(n) / speed, true)).collect();
        let left = 100.0 / speed;
        // x = v·t − a·t²/2
        let behind = (1..).map_while(|n| {
            let under = speed * speed - 2.0 * decel * f64::from(n);
            (under >= 0.0).then(|| left + (speed - under.sqrt()) / decel)
        });
        let all = path.iter().take(101).map(|step| step.0).chain(behind.take(steps));
        (all.map(|t| ((1.0 + t) * HZ) as u64).map(|t| (t, true)).collect(), path)
    }

    #[test]
    fn it_lets_the_deceleration_pass_and_no_larger_one() {
        for (speed, decel) in [(20_000.0, 40_000.0), (500.0, 2_000.0), (12.0, 20.0), (3.0, 2.0)] {
            let (steps, path) = braked(speed, decel, usize::MAX);
            let verdict = judge(&steps, &path, decel).unwrap();
            assert!(verdict.steepest > 0.8 || speed < 20.0, "{verdict:?}");
            let harder = judge(&steps, &path, decel / 1.3);
            assert!(harder.is_err() || speed < 20.0, "{speed}: {harder:?}");
        }
    }

    #[test]
    fn it_hears_a_dead_stop_at_any_place() {
        for (speed, decel) in [(20_000.0, 40_000.0), (500.0, 2_000.0), (30.0, 100.0), (5.0, 2.0)] {
            let (all, path) = braked(speed, decel, usize::MAX);
            for left in 0..all.len() - 102 {
                let why = judge(&all[..101 + left], &path, decel).unwrap_err();
                assert!(why.contains("stops dead"), "{why}");
            }
        }
    }

    #[test]
    fn it_hears_a_jump_and_a_turn() {
        let (mut steps, path) = braked(2_000.0, 10_000.0, usize::MAX);
        steps.truncate(150);
        let mut jump = steps.clone();
        jump[140..].iter_mut().for_each(|step| step.0 += 8_000);
        assert!(judge(&jump, &path, 10_000.0).unwrap_err().contains("of its deceleration"));
        steps[130].1 = false;
        assert!(judge(&steps, &path, 10_000.0).unwrap_err().contains("turns"));
    }
}
