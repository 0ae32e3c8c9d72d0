//! Runs test programs in parallel.
//!
//! `cargo test` runs them one after another. Many tests are long, or wait for a clock, and leave a
//! processor idle. Here cargo builds them, and as many run at a time as there are processors; the
//! output of each is printed in one piece at its end. The test files of a crate are modules of one
//! program, which is linked once and runs once for each of them.
//!
//! Random tests use a fixed seed here, so that a change is judged by the same cases as the state
//! before it. A plain `cargo test` uses other seeds each time.

use std::collections::{BTreeMap, VecDeque};
use std::env;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::thread;

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::workspace::{cargo_path, line, output};

/// The variable for proptest's seed, and its default.
const SEED: (&str, &str) = ("PROPTEST_RNG_SEED", "20");

/// A test program, or a module of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TestProgram {
    /// The package's folder, and the name of the program or of the module, for messages.
    pub name: String,
    program: PathBuf,
    /// The tests to run; all if empty.
    tests: Vec<String>,
    /// The working directory, as with cargo.
    folder: PathBuf,
}

impl TestProgram {
    /// A command that runs it.
    pub fn command(&self) -> Command {
        let mut command = Command::new(&self.program);
        if !self.tests.is_empty() {
            command.arg("--exact").args(&self.tests);
        }
        command.current_dir(&self.folder).env("CARGO", cargo_path());
        command.env("CARGO_MANIFEST_DIR", &self.folder);
        if env::var_os(SEED.0).is_none() {
            command.env(SEED.0, SEED.1);
        }
        command
    }

    /// Splits it into one for each module of the crate's tests. The unit tests of the crate's own
    /// files stay together.
    fn modules(self) -> Result<Vec<TestProgram>> {
        if !self.name.ends_with(ALL) {
            return Ok(vec![self]);
        }
        let tests = output(self.command().args(["--list", "--format=terse"]))?;
        Ok(self.split(&tests))
    }

    /// Splits it by a list of its tests.
    fn split(self, list: &str) -> Vec<TestProgram> {
        let mut modules: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for test in list.lines().filter_map(|line| line.strip_suffix(": test")) {
            let module = test.split_once("::").map_or("", |(module, _)| module);
            modules.entry(module).or_default().push(test.to_owned());
        }
        let package = self.name.trim_end_matches(ALL);
        let one = |(module, tests)| TestProgram {
            name: format!("{package} {module}"),
            tests,
            ..self.clone()
        };
        modules.into_iter().map(one).collect()
    }
}

/// The end of the name of a program with all test files of its crate.
const ALL: &str = " all";

/// Builds the test programs of a `cargo test`, and splits them by modules. The order is that of
/// cargo.
pub fn build(cargo: &mut Command) -> Result<Vec<TestProgram>> {
    cargo.args(["--no-run", "--message-format=json-render-diagnostics"]);
    eprintln!("$ {}", line(cargo));
    let out = cargo.stdin(Stdio::null()).stderr(Stdio::inherit()).output()?;
    if !out.status.success() {
        bail!("{}: {}", line(cargo), out.status);
    }
    let text = String::from_utf8_lossy(&out.stdout);
    let mut programs = Vec::new();
    for message in text.lines() {
        let message: Value = serde_json::from_str(message).context("cargo's messages")?;
        if let Some(program) = program(&message) {
            programs.append(&mut program.modules()?);
        }
    }
    Ok(programs)
}

/// The test program in a message of cargo.
fn program(message: &Value) -> Option<TestProgram> {
    if message["reason"] != "compiler-artifact" || message["profile"]["test"] != true {
        return None;
    }
    let manifest = PathBuf::from(message["manifest_path"].as_str()?);
    let folder = manifest.parent()?.to_owned();
    let package = folder.file_name()?.to_string_lossy().into_owned();
    Some(TestProgram {
        name: format!("{package} {}", message["target"]["name"].as_str()?),
        program: message["executable"].as_str()?.into(),
        tests: Vec::new(),
        folder,
    })
}

/// A failed program: its name, its command, and its last lines.
type Failed = (String, Command, String);

/// Runs all programs, also after failures.
///
/// # Errors
/// The names of the failed programs, and the last lines of each.
pub fn run(commands: Vec<(String, Command)>) -> Result<()> {
    verdict(beside(commands, thread::available_parallelism().map_or(2, usize::from))?)
}

/// Like [`run`], for programs that depend on this machine's clock: each that fails beside others
/// runs again alone, and that result counts. Both outputs are printed.
pub fn run_by_the_clock(commands: Vec<(String, Command)>) -> Result<()> {
    let failed = beside(commands, thread::available_parallelism().map_or(2, usize::from))?;
    if !failed.is_empty() {
        let names: Vec<_> = failed.iter().map(|(name, ..)| name.as_str()).collect();
        println!("=== once more, alone: {}", names.join(", "));
    }
    verdict(beside(failed.into_iter().map(|(name, command, _)| (name, command)).collect(), 1)?)
}

fn verdict(failed: Vec<Failed>) -> Result<()> {
    if failed.is_empty() {
        return Ok(());
    }
    let ends: String = failed.iter().map(|(.., end)| end.as_str()).collect();
    let names: Vec<_> = failed.iter().map(|(name, ..)| name.as_str()).collect();
    bail!("{ends}{} test programs failed: {}", names.len(), names.join(", "))
}

/// Runs all programs, some at a time. Returns those that fail.
fn beside(commands: Vec<(String, Command)>, lanes: usize) -> Result<Vec<Failed>> {
    let waiting = Mutex::new(VecDeque::from(commands));
    let lane = || -> Result<Vec<Failed>> {
        let mut failed = Vec::new();
        loop {
            let next = waiting.lock().map(|mut all| all.pop_front()).ok().flatten();
            let Some((name, mut command)) = next else { return Ok(failed) };
            let out = command.stdin(Stdio::null()).output();
            let out = out.with_context(|| format!("starting {}", line(&command)))?;
            // Printed in one piece, because both lanes print.
            let mut text = format!("     Running {name}\n");
            text += &String::from_utf8_lossy(&out.stderr);
            text += &String::from_utf8_lossy(&out.stdout);
            print!("{text}");
            if !out.status.success() {
                failed.push((name, command, end(&text)));
            }
        }
    };
    let failed = thread::scope(|scope| {
        let lanes: Vec<_> = (0..lanes).map(|_| scope.spawn(lane)).collect();
        let ended = lanes.into_iter().map(|lane| lane.join().unwrap_or_else(|p| resume_unwind(p)));
        ended.collect::<Result<Vec<_>>>()
    })?;
    Ok(failed.into_iter().flatten().collect())
}

/// The last lines of a program's output, where libtest repeats the failures.
fn end(text: &str) -> String {
    let lines: Vec<_> = text.lines().collect();
    let last = &lines[lines.len().saturating_sub(20)..];
    last.iter().map(|line| format!("{line}\n")).collect()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_message_tells_of_a_test_program_or_of_something_else() {
        let mut message = json!({
            "reason": "compiler-artifact",
            "manifest_path": "/a/crates/core/Cargo.toml",
            "target": { "name": "stop" },
            "profile": { "test": true },
            "executable": "/a/target/debug/deps/stop-1",
        });
        let found = program(&message).unwrap();
        assert_eq!(found.name, "core stop");
        assert_eq!(found.command().get_current_dir(), Some("/a/crates/core".as_ref()));
        message["profile"]["test"] = json!(false);
        assert_eq!(program(&message), None);
        assert_eq!(program(&json!({ "reason": "build-finished" })), None);
    }

    #[test]
    fn a_program_runs_once_for_each_module_of_its_tests() {
        let all = TestProgram {
            name: "core all".to_owned(),
            program: "/a/all-1".into(),
            tests: Vec::new(),
            folder: "/a/crates/core".into(),
        };
        let list = "stop::soft: test\nline::long::of_all: test\nstop::hard: test\n\n3 tests, 0 benchmarks\n";
        let modules = all.split(list);
        let names: Vec<_> = modules.iter().map(|module| module.name.as_str()).collect();
        assert_eq!(names, ["core line", "core stop"]);
        let command = modules[1].command();
        assert_eq!(command.get_args().collect::<Vec<_>>(), ["--exact", "stop::soft", "stop::hard"]);
    }

    #[test]
    fn all_run_and_those_that_fail_are_named() {
        let run_one = |name: &str| (name.to_owned(), Command::new(name));
        assert!(run(vec![run_one("true"), run_one("true"), run_one("true")]).is_ok());
        let error = run(vec![run_one("false"), run_one("true"), run_one("false")]).unwrap_err();
        let error = error.to_string();
        assert!(error.ends_with("\n2 test programs failed: false, false"), "{error}");
        assert!(run(vec![run_one("no such program")]).is_err());
    }

    #[test]
    fn the_last_lines_of_a_program_that_fails_are_told() {
        let mut command = Command::new("sh");
        command.args(["-c", "seq 100; echo why >&2; exit 1"]);
        let error = run(vec![("odd".to_owned(), command)]).unwrap_err().to_string();
        assert!(error.starts_with("81\n82\n"), "{error}");
        assert!(error.ends_with("100\n1 test programs failed: odd"), "{error}");
    }

    #[test]
    fn a_program_that_goes_by_the_clock_is_judged_by_its_second_run_alone() {
        // The first run fails, and leaves a file with which the second succeeds.
        let file = env::temp_dir().join(format!("stepwright-again-{}", std::process::id()));
        let mut once = Command::new("sh");
        once.args(["-c", "test -e \"$0\" || { touch \"$0\"; exit 1; }"]).arg(&file);
        let never = Command::new("false");
        let commands = vec![("once".to_owned(), once), ("never".to_owned(), never)];
        let error = run_by_the_clock(commands).unwrap_err().to_string();
        std::fs::remove_file(&file).unwrap();
        assert!(error.ends_with("\n1 test programs failed: never"), "{error}");
    }
}
