//! Compares a cycle file on the chip with the virtual board's csv, each cycle separately, because
//! the command pauses between cycles.

use anyhow::{Context, Result, ensure};

use super::steps::{Step, first, worst};

/// The cycles of a µs.
const MICRO: f64 = 16.0;
/// The largest difference of a step after a pause, which the main loop begins and ends: 1 ms.
pub const PAUSE: f64 = 16_000.0;

/// The largest total delay of a part of a homing: the main loop begins it between two bytes of its
/// answers, three times.
const PARTS: f64 = 240_000.0;

/// A cycle of the virtual board: the steps of each motor, and the times of its pause and
/// resumption.
struct Segment {
    steps: Vec<Vec<Step>>,
    paused: f64,
    resumed: f64,
}

/// Parses the cycles of a file from the output of `--format csv`, for the motors of these names.
fn segments(csv: &str, names: &[&str]) -> Result<Vec<Segment>> {
    let mut lines = csv.lines();
    ensure!(lines.next() == Some("time_us,motor,event,value,position"), "no csv:\n{csv}");
    let (mut all, mut forward): (Vec<Segment>, _) = (Vec::new(), vec![false; names.len()]);
    for line in lines {
        let cells: Vec<_> = line.split(',').collect();
        let [us, motor, event, value, _] = cells[..] else { continue };
        let (time, high) = (us.parse::<f64>()? * MICRO, value == "1");
        let motor = names.iter().position(|name| *name == motor);
        if (event, value) == ("cycle", "start") {
            let steps = vec![Vec::new(); names.len()];
            all.push(Segment { steps, paused: f64::MAX, resumed: f64::MAX });
        }
        let segment = all.last_mut().context("a row before the first cycle");
        match (event, motor) {
            ("cycle", _) if value == "pause" => segment?.paused = time,
            ("cycle", _) if value == "resume" => segment?.resumed = time,
            ("dir", Some(motor)) => forward[motor] = high,
            ("step", Some(motor)) if high => {
                segment?.steps[motor].push(Step { time, forward: forward[motor] });
            }
            _ => {}
        }
    }
    Ok(all)
}

/// Which cycles of a file are homings.
pub fn homes(file: &str) -> Vec<bool> {
    file.split("[[cycle]]").skip(1).map(|cycle| cycle.trim_start().starts_with("home =")).collect()
}

/// Compares the parts of a homing: there, back, there again. The main loop begins each part, so its
/// times count from its own first step. Returns the largest difference of a step.
fn worst_of_homing(real: &[Step], ideal: &[Step], begun: (f64, f64)) -> Result<f64> {
    ensure!(real.len() == ideal.len(), "{} steps instead of {}", real.len(), ideal.len());
    let (mut at, mut edge) = (0, 0f64);
    for part in ideal.chunk_by(|a, b| a.forward == b.forward) {
        let real = &real[at..at + part.len()];
        at += part.len();
        let own = (real[0].time, part[0].time);
        let late = (own.0 - begun.0) - (own.1 - begun.1);
        ensure!(late.abs() <= PARTS, "a part of the homing begins {late:.0} cycles late");
        edge = edge.max(worst(real, part, own)?);
    }
    Ok(edge)
}

/// The largest difference of a step, and of a step after a pause, in cycles. `homes` tells which
/// cycles are homings.
///
/// # Errors
/// The number or the directions of the steps differ.
pub fn worst_of_cycles(
    real: &[Vec<Step>],
    csv: &str,
    names: &[&str],
    homes: &[bool],
) -> Result<(f64, f64)> {
    let segments = segments(csv, names)?;
    let mut done = vec![0; names.len()];
    let (mut all, mut paused) = (0f64, 0f64);
    for (n, segment) in segments.iter().enumerate() {
        let mut made = Vec::new();
        for (motor, ideal) in segment.steps.iter().enumerate() {
            let steps = real[motor].get(done[motor]..done[motor] + ideal.len());
            let steps = steps.with_context(|| {
                format!("cycle {}: {} steps of {}", n + 1, real[motor].len(), names[motor])
            })?;
            done[motor] += ideal.len();
            made.push(steps.to_vec());
        }
        let begun = (first(&made), first(&segment.steps));
        for (made, ideal) in made.iter().zip(&segment.steps) {
            if homes.get(n) == Some(&true) {
                all = all.max(worst_of_homing(made, ideal, begun)?);
                continue;
            }
            let before = ideal.partition_point(|step| step.time <= segment.resumed);
            all = all.max(worst(&made[..before], &ideal[..before], begun)?);
            // A step that is due at the moment of the pause may be made before it.
            let end = segment.paused - begun.1 + PAUSE;
            let early = made.get(before).is_some_and(|step| step.time - begun.0 < end);
            let from = before + usize::from(early);
            paused = paused.max(worst(&made[from..], &ideal[from..], begun)?);
        }
    }
    for (motor, (steps, done)) in real.iter().zip(done).enumerate() {
        let (made, name) = (steps.len(), names[motor]);
        ensure!(made == done, "{made} steps of {name} instead of {done}");
    }

    Ok((all, paused))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CSV: &str = "time_us,motor,event,value,position\n0,,cycle,start,\n0,X,dir,1,0\n\
        100,X,step,1,0\n102,X,step,0,1\n200,X,step,1,1\n202,X,step,0,2\n210,,cycle,pause,\n\
        5000,,cycle,resume,\n5090,X,step,1,2\n6000,,cycle,end,\n6000,,cycle,start,\n\
        6000,Y,dir,0,0\n6100,Y,step,1,0\n";

    fn at(us: &[f64], forward: bool) -> Vec<Step> {
        us.iter().map(|us| Step { time: us * MICRO, forward }).collect()
    }

    #[test]
    fn each_cycle_counts_from_its_first_step() {
        let real = [at(&[1000.0, 1100.5, 5993.0], true), at(&[9000.0], false)];
        let worst_of = |real: &[Vec<Step>]| worst_of_cycles(real, CSV, &["X", "Y"], &[]);
        let (all, paused) = worst_of(&real).unwrap();
        assert_eq!((all, paused), (8.0, 48.0));
        let short = [real[0][..2].to_vec(), real[1].clone()];
        assert!(worst_of(&short).is_err());
        let long = [real[0].clone(), at(&[9000.0, 9001.0], false)];
        assert!(worst_of(&long).is_err());
        let turned = [real[0].clone(), at(&[9000.0], true)];
        assert!(worst_of(&turned).is_err());
        // Due as the pause begins: made before it, or far too early.
        let before = |us| [at(&[1000.0, 1100.0, us], true), real[1].clone()];
        let paused = |us| worst_of(&before(us)).unwrap().1;
        assert_eq!((paused(1111.0), paused(2300.0)), (0.0, 3690.0 * MICRO));
    }

    #[test]
    fn the_parts_of_a_homing_count_from_their_own_first_steps() {
        assert_eq!(homes("[[motor]]\n[[cycle]]\nhome = {}\n[[cycle]]\nline = {}"), [true, false]);
        let csv = "time_us,motor,event,value,position\n0,,cycle,start,\n100,X,step,1,0\n\
            200,X,step,1,0\n210,X,dir,1,0\n300,X,step,1,0\n400,X,step,1,0\n500,,cycle,end,\n";
        let worst_of = |back: f64| {
            let there = at(&[1000.0, 1100.0], false);
            let real = [there, at(&[1200.0 + back, 1303.0 + back], true)].concat();
            worst_of_cycles(&[real], csv, &["X"], &[true])
        };
        assert_eq!(worst_of(4_000.0).unwrap(), (48.0, 0.0));
        assert!(worst_of(16_000.0).is_err());
    }
}
