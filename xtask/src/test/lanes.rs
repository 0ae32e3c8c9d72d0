//! Runs steps in two parallel lanes.
//!
//! ```text
//! lane 1   fmt  words  ..  clippy | unit ............... | firmware | rig ....... | chips |
//! lane 2   python ...... | wasm | page .. | api | senders | pico .. | ports | fuzz | bench | uno | flash
//! ```
//!
//! The first lane computes, and keeps all processors busy most of the time. The second lane drives
//! boards, browsers and other programs, and waits for them most of the time. In sequence they left
//! a quarter of two processors idle; in parallel they leave a tenth. A lane that has finished takes
//! steps from the end of the other. Two short steps don't tolerate a busy machine: they run after
//! both lanes.
//!
//! On a busy machine a timeout may be too short. Steps with timeouts run once more if they fail,
//! after all others have ended.

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

/// The second lane, in this order: first the steps that need no firmware, while the first lane
/// builds it. Installations by steps of both lanes are locked against each other.
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

/// The steps after both lanes: a chip that is simulated in real time, and a boot loader that waits
/// for a second.
const ALONE: &[&str] = &["uno", "flash"];

/// Steps with timeouts by this machine's clock. If one fails, it runs once more, and the summary
/// says so.
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

/// The result of a step.
pub struct Ended {
    /// Its name.
    pub name: &'static str,
    /// Whether it passed, at the first or at the second run.
    pub passed: bool,
    /// The result in words.
    pub verdict: &'static str,
    /// The time of all its runs.
    pub time: Duration,
    /// The last lines of the first failed run.
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

    /// Runs the step once more if it failed and depends on the clock.
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

/// Runs a step. A step that can't be started has failed, and the others continue.
fn timed(name: &str, run: &impl Fn(&str) -> Result<Said>) -> (Said, Duration) {
    let start = Instant::now();
    let said =
        run(name).unwrap_or_else(|error| Said { passed: false, last: vec![format!("{error:#}")] });
    (said, start.elapsed())
}

/// Runs these steps, each in a separate process, also after failures. Returns the results in the
/// given order.
///
/// # Errors
/// The path of this program can't be determined.
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

/// The next step of a lane, or the last one of another lane.
fn next(left: &mut [VecDeque<&'static str>], lane: usize) -> Option<&'static str> {
    left[lane].pop_front().or_else(|| left.iter_mut().find_map(VecDeque::pop_back))
}

/// Runs all lanes, then the single steps, then repeats those that depend on the clock. Returns the
/// results in the order of `names`.
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

    /// The results of steps that fail this often at first: whether each passed, how often it ran,
    /// the repeated lines, and the verdict.
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
