//! Steps in two lanes, side by side.
//!
//! ```text
//! lane 1   fmt  words  ..  clippy | unit ............... | firmware | rig ....... | chips |
//! lane 2   python ...... | wasm | page .. | api | senders | pico .. | ports | fuzz | bench | uno | flash
//! ```
//!
//! The first computes, and keeps all processors busy most of the time. The second drives boards,
//! browsers and other programs, and waits for them most of the time. One after the other they left a
//! quarter of two processors idle; side by side a tenth. The lane that is through first takes steps from
//! the end of the other. Two short steps can't stand a busy machine: they run behind both lanes.
//!
//! On a busy machine a wait may be too short: such steps run once more if they fail, when all others
//! have ended.

use std::collections::VecDeque;
use std::iter;
use std::panic::resume_unwind;
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::Result;

use super::Step;
use super::apart::{self, Said};
use crate::workspace::Workspace;

/// The second lane, in this order: first those that take no firmware, as the first lane builds it
/// meanwhile. What steps of both lanes install is installed by one at a time.
const SECOND: &[&str] = &[
    "python",
    "wasm",
    "page",
    "api",
    "senders",
    "pyserial",
    "sigrok",
    "pico",
    "ports",
    "page-chip",
];

/// Behind both lanes: a chip that is simulated in real time, and a boot loader that waits for a second.
const ALONE: &[&str] = &["uno", "flash"];

/// Steps with waits by the clock of this machine: one that fails runs once more, and the summary says so.
const BY_THE_CLOCK: &[&str] = &[
    "unit",
    "qemu",
    "pico",
    "ports",
    "pyserial",
    "python",
    "senders",
    "uno",
    "flash",
    "page",
    "page-chip",
    "api",
];

/// How a step ended.
pub struct Ended {
    /// Its name.
    pub name: &'static str,
    /// Whether it passed, at the first or at the second run.
    pub passed: bool,
    /// The same in words.
    pub verdict: &'static str,
    /// Of all its runs.
    pub time: Duration,
    /// The last lines of a run that failed, of the first.
    pub last: Vec<String>,
}

impl Ended {
    /// Runs a step in this process.
    pub fn here(step: &Step, ws: &Workspace) -> Ended {
        let run = |_: &str| Ok(Said { passed: super::here(step, ws), last: Vec::new() });
        Ended::of(step.name, &run)
    }

    fn of(name: &'static str, run: &impl Fn(&str) -> Result<Said>) -> Ended {
        let (said, time) = timed(name, run);
        let (passed, last) = (said.passed, if said.passed { Vec::new() } else { said.last });
        let verdict = if passed { "passed" } else { "FAILED" };
        Ended { name, passed, verdict, time, last }
    }

    /// Runs it once more if it failed, and another run tells more.
    fn again(self, run: &impl Fn(&str) -> Result<Said>) -> Ended {
        if self.passed || !BY_THE_CLOCK.contains(&self.name) {
            return self;
        }
        println!("\n=== {} once more", self.name);
        let (said, time) = timed(self.name, run);
        let verdict = if said.passed { "passed at the second run" } else { "FAILED twice" };
        Ended { passed: said.passed, verdict, time: self.time + time, ..self }
    }
}

/// Runs a step. One that can't be started has failed, and the others go on.
fn timed(name: &str, run: &impl Fn(&str) -> Result<Said>) -> (Said, Duration) {
    let start = Instant::now();
    let said =
        run(name).unwrap_or_else(|error| Said { passed: false, last: vec![format!("{error:#}")] });
    (said, start.elapsed())
}

/// Runs these steps, each in a process of its own, whatever fails; how they ended, in the order given.
///
/// # Errors
/// This program is not to be found.
pub fn run(steps: &[&Step]) -> Result<Vec<Ended>> {
    let program = apart::program()?;
    let names: Vec<_> = steps.iter().map(|step| step.name).collect();
    let wide = names.iter().map(|name| name.len()).max().unwrap_or_default();
    let lanes = lanes(&names, thread::available_parallelism().map_or(1, usize::from));
    let before = |name: &str| match lanes.len() {
        1 => String::new(),
        _ => format!("{name:<wide$} | "),
    };
    Ok(side_by_side(&lanes, &names, &|name| {
        apart::tell(apart::step(&program, name), &before(name))
    }))
}

/// The steps of each lane, in their order.
fn lanes(names: &[&'static str], processors: usize) -> Vec<Vec<&'static str>> {
    let (mut first, mut second) = (Vec::new(), Vec::new());
    for &name in names.iter().filter(|name| !ALONE.contains(name)) {
        if SECOND.contains(&name) { second.push(name) } else { first.push(name) }
    }
    second.sort_by_key(|name| SECOND.iter().position(|other| other == name));
    if processors < 2 {
        first.append(&mut second);
    }
    [first, second].into_iter().filter(|lane| !lane.is_empty()).collect()
}

/// The next step of a lane: its own, or the last one of another.
fn next(left: &mut [VecDeque<&'static str>], lane: usize) -> Option<&'static str> {
    left[lane].pop_front().or_else(|| left.iter_mut().find_map(VecDeque::pop_back))
}

/// Runs all lanes, then the others, then once more what is worth it; in the order of `names`.
fn side_by_side(
    lanes: &[Vec<&'static str>],
    names: &[&'static str],
    run: &(impl Fn(&str) -> Result<Said> + Sync),
) -> Vec<Ended> {
    let left = Mutex::new(lanes.iter().cloned().map(VecDeque::from).collect::<Vec<_>>());
    let one_after_another = |lane| {
        let next = || next(&mut left.lock().unwrap_or_else(PoisonError::into_inner), lane);
        iter::from_fn(next).map(|name| Ended::of(name, run)).collect::<Vec<_>>()
    };
    let all = thread::scope(|scope| {
        let lanes = (0..lanes.len()).map(|lane| scope.spawn(move || one_after_another(lane)));
        let lanes: Vec<_> = lanes.collect();
        let ended = lanes.into_iter().map(|lane| lane.join().unwrap_or_else(|p| resume_unwind(p)));
        ended.flatten().collect::<Vec<_>>()
    });
    let alone = names.iter().filter(|name| ALONE.contains(name)).map(|name| Ended::of(name, run));
    let mut all: Vec<_> = all.into_iter().chain(alone).map(|ended| ended.again(run)).collect();
    all.sort_by_key(|ended| names.iter().position(|name| *name == ended.name));
    all
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::super::STEPS;
    use super::*;

    /// What becomes of steps that fail so often first: whether each passed, how often it ran, the lines that
    /// are repeated, and the verdict.
    fn fail(times: &[(&'static str, u32)]) -> Vec<(bool, u32, Vec<String>, &'static str)> {
        let runs = Mutex::new(HashMap::new());
        let names: Vec<_> = times.iter().map(|&(name, _)| name).collect();
        let run = |name: &str| {
            let mut runs = runs.lock().unwrap();
            let count = runs.entry(name.to_owned()).or_insert(0);
            *count += 1;
            let fails = times.iter().find(|(other, _)| *other == name).unwrap().1;
            Ok(Said { passed: *count > fails, last: vec![format!("run {count}")] })
        };
        let ended = side_by_side(&lanes(&names, 2), &names, &run);
        let runs = runs.into_inner().unwrap();
        ended.into_iter().map(|one| (one.passed, runs[one.name], one.last, one.verdict)).collect()
    }

    #[test]
    fn a_step_that_goes_by_the_clock_runs_once_more() {
        let first = vec!["run 1".to_owned()];
        let ended = fail(&[("rig", 1), ("page", 0), ("uno", 1), ("fmt", 0), ("pico", 2)]);
        assert_eq!(ended[0], (false, 1, first.clone(), "FAILED"));
        assert_eq!(ended[1], (true, 1, vec![], "passed"));
        assert_eq!(ended[2], (true, 2, first.clone(), "passed at the second run"));
        assert_eq!(ended[3], (true, 1, vec![], "passed"));
        assert_eq!(ended[4], (false, 2, first, "FAILED twice"));
    }

    #[test]
    fn what_runs_alone_runs_behind_both_lanes() {
        let names = ["uno", "fmt", "flash", "page"];
        let order = Mutex::new(Vec::new());
        let run = |name: &str| {
            order.lock().unwrap().push(name.to_owned());
            Ok(Said { passed: true, last: Vec::new() })
        };
        side_by_side(&lanes(&names, 2), &names, &run);
        assert_eq!(order.into_inner().unwrap()[2..], ["uno", "flash"]);
    }

    #[test]
    fn a_lane_that_is_through_takes_the_last_step_of_the_other() {
        let mut left = [VecDeque::from(["fmt", "unit", "fuzz"]), VecDeque::from(["page"])];
        let mut taken = |lane| next(&mut left, lane);
        assert_eq!(
            [1, 1, 0, 1, 0, 1].map(&mut taken),
            [Some("page"), Some("fuzz"), Some("fmt"), Some("unit"), None, None]
        );
    }

    #[test]
    fn a_step_that_cannot_be_started_has_failed() {
        let none = |_: &str| anyhow::bail!("no such file");
        let ended = side_by_side(&lanes(&["fmt"], 2), &["fmt"], &none);
        assert_eq!(
            (ended[0].verdict, ended[0].last.clone()),
            ("FAILED", vec!["no such file".into()])
        );
    }

    #[test]
    fn one_processor_has_one_lane() {
        let names = ["fmt", "page", "unit", "python"];
        assert_eq!(lanes(&names, 2), [["fmt", "unit"], ["python", "page"]]);
        assert_eq!(lanes(&names, 1), [["fmt", "unit", "python", "page"]]);
        assert_eq!(lanes(&["fmt"], 2), [["fmt"]]);
        assert!(lanes(&["uno"], 2).is_empty());
    }

    #[test]
    fn the_lists_name_steps() {
        let mut names = SECOND.iter().chain(BY_THE_CLOCK).chain(ALONE);
        assert!(names.all(|name| STEPS.iter().any(|step| step.name == *name)));
    }
}
