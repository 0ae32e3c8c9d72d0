//! A line or an arc from the positions of the motors, and its changes on the way.

use std::ops::Range;

use stepwright_path::{Arc, Line, LivePath, Steps, Unplannable};

use crate::plan::{Act, CyclePlan, MOST, Move, Task, TimedAct};
use crate::text::{CycleText, FileError};

/// The moves of the motors along a path; none if the task is not a path.
///
/// The acts become changes of the path, so `acts` is empty afterwards. For a pause the path brakes and
/// continues; the cycle itself does not pause.
///
/// # Errors
/// The path is impossible, too fast for a motor, or changed after its end.
pub fn along(
    plan: &CyclePlan,
    text: &CycleText,
    positions: &[i64],
    task: &Task,
    acts: &mut Vec<TimedAct>,
    at: &Range<usize>,
) -> Result<Vec<Move>, FileError> {
    let here = |motor: u8| positions.get(usize::from(motor)).copied().unwrap_or(0);
    let distance = |motor: u8| plan.motors[usize::from(motor)].distance;
    // The time to set DIR, and at least as long as any smallest delay.
    let least = plan.motors.iter().map(|motor| motor.smallest_delay).max();
    let lead = plan.rate.micros(least.unwrap_or(0).max(100));
    let wrong = |what: Unplannable| text.blame(at.clone(), what);
    // To the nearest step.
    let way = |motor: u8, to: i64, at: &Range<usize>| {
        let way = i128::from(to) - i128::from(here(motor));
        let step = i128::from(distance(motor));
        let count = (2 * way + step).div_euclid(2 * step);
        i32::try_from(count).map_err(|_| text.blame(at.clone(), Unplannable::TooLong))
    };
    let (axes, end, steps): (Vec<u8>, Vec<i32>, Vec<Steps>) = match task {
        Task::Path(path) => return path.moves(plan, text, positions, acts, at, lead),
        Task::Moves | Task::Home(_) => return Ok(Vec::new()),
        Task::Line(to, pace) => {
            let mut line = Line { steps: [0; MOST], step: [1.0; MOST] };
            for motor in 0..plan.names.len() as u8 {
                line.step[usize::from(motor)] = f64::from(distance(motor));
            }
            for &(motor, to) in to {
                line.steps[usize::from(motor)] = way(motor, to, at)?;
            }
            if line.steps == [0; MOST] {
                return nothing(text, acts);
            }
            let steps = Steps::line(&line, *pace, plan.rate, lead).map_err(wrong)?;
            ((0..MOST as u8).collect(), line.steps.to_vec(), steps.into())
        }
        Task::Arc(motors, centre, sweep, pace) => {
            let from = |n: usize| centre[n] as f64 - here(motors[n]) as f64;
            let step = motors.map(|motor| f64::from(distance(motor)));
            let arc = Arc { centre: [from(0), from(1)], sweep: *sweep, step };
            if arc.sweep == 0.0 && arc.radius() > 0.0 {
                return nothing(text, acts);
            }
            let steps = Steps::arc(&arc, *pace, plan.rate, lead).map_err(wrong)?;
            // A new end gives the positions of both motors.
            (motors.to_vec(), vec![0; 2], steps.into())
        }
    };
    let mut path = Changes { end, moving: vec![matches!(task, Task::Arc(..)); axes.len()] };
    path.note();
    if let Some((law, lead)) = steps.first().map(|steps| (steps.law(), steps.lead())) {
        let hz = f64::from(plan.rate.hz());
        let smallest = |motor: u8| plan.motors[usize::from(motor)].smallest_delay;
        let fastest = |motor: &u8| hz / f64::from(plan.rate.micros(smallest(*motor)));
        let within = law.within(&axes.iter().map(fastest).collect::<Vec<_>>());
        within.map_err(|what| match what {
            Unplannable::TooFast { axis, most } => {
                let (name, delay) = (&plan.names[usize::from(axes[axis])], smallest(axes[axis]));
                let (peak, most) = (digits(law.now().peak(), f64::round), digits(most, f64::floor));
                let what = format!("too fast for {name}, whose smallest delay is {delay} µs");
                let unit = &plan.unit;
                text.blame(at.clone(), what).hint(format!(
                    "it comes to {peak} {unit}/s; the largest speed that would do is {most}"
                ))
            }
            what => wrong(what),
        })?;
        let begins = f64::from(lead) / hz;
        for TimedAct { us, at, act } in std::mem::take(acts) {
            let seconds = (us as f64 / 1e6 - begins).max(0.0);
            if let Act::To(to) = &act {
                for &(motor, to) in to {
                    let axis = axes.iter().position(|known| *known == motor).ok_or_else(|| {
                        let names = axes.iter().map(|n| plan.names[usize::from(*n)].as_str());
                        let names = names.collect::<Vec<_>>().join(" and ");
                        text.blame(at.clone(), format_args!("this path is one of {names} only"))
                    })?;
                    path.end[axis] = way(motor, to, &at)?;
                }
                path.note();
            }
            change(&law, seconds, &act, &path.end).map_err(|what| text.blame(at, what))?;
        }
    }
    let moves = axes.into_iter().zip(path.moving).zip(steps).filter(|((_, moving), _)| *moving);
    let least = |motor: u8| plan.rate.micros(plan.motors[usize::from(motor)].smallest_delay);
    let moves =
        moves.map(|((motor, _), steps)| Move::paced(motor, at.clone(), steps, least(motor)));
    Ok(moves.collect())
}

/// A path of no length: no motor moves, and there is nothing to change.
fn nothing(text: &CycleText, acts: &mut Vec<TimedAct>) -> Result<Vec<Move>, FileError> {
    match acts.drain(..).find(|act| matches!(act.act, Act::Feed(_) | Act::To(_))) {
        Some(act) => Err(text.blame(act.at, Unplannable::Over)),
        None => Ok(Vec::new()),
    }
}

/// A speed with nine digits, or with all digits before the point if they are more.
fn digits(speed: f64, round: fn(f64) -> f64) -> f64 {
    let behind = 10f64.powf((8.0 - speed.log10().floor()).clamp(0.0, 12.0));
    round(speed * behind) / behind
}

/// The present end of the path, and the motors that take part in it.
struct Changes {
    end: Vec<i32>,
    moving: Vec<bool>,
}

impl Changes {
    fn note(&mut self) {
        for (moving, steps) in self.moving.iter_mut().zip(&self.end) {
            *moving |= *steps != 0;
        }
    }
}

/// Makes an act a change of the path. For a pause the path brakes, and then continues.
fn change(law: &LivePath, seconds: f64, act: &Act, end: &[i32]) -> Result<(), Unplannable> {
    match act {
        Act::Pause => _ = law.pause(seconds),
        Act::Resume => _ = law.resume(seconds),
        Act::Finish => _ = law.finish(seconds),
        Act::Feed(scale) => _ = law.scale(seconds, *scale)?,
        Act::To(_) => _ = law.retarget(seconds, end)?,
    }
    Ok(())
}
