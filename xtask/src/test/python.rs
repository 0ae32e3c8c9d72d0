//! Tests the Python package: builds its wheel, installs it in a clean environment, and tests it on
//! virtual boards, in the process and behind a pseudo-terminal, and on a simulated Uno.

use std::env;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};

use crate::firmware::{Board, Build};
use crate::program::Program;
use crate::workspace::{self, Guard, Workspace, run_within};
use crate::{node, python, rig, ticks};

/// The time limit of an example, which must be quick, also on a loaded machine.
const EXAMPLE_LIMIT: Duration = Duration::from_secs(60);
/// The time limit of all tests.
const TESTS_LIMIT: Duration = Duration::from_secs(480);
/// The most lines of code of a script for a task in a lab.
const SHORT: usize = 15;

/// The programs of a simulated Uno besides the controller that are tested.
const PROGRAMS: [&str; 4] = ["laws", "transitions", "power-term", "cycles"];

/// The travels of each law on chips for the tests: on a Cortex-M3 as many as are compared with the
/// command's, on an AVR fewer, whose simulator takes most of a second for one travel of each law.
const TRAVELS: [(&str, u32); 2] = [("avr", 40), ("cortex-m3", 1_000)];

/// Builds the wheel. Runs every example on each kind of board without any other package, then the
/// tests and the type check with numpy.
pub fn run(ws: &Workspace) -> Result<()> {
    python::MOTION.prepare(ws)?;
    let tools = python::MOTION.interpreter(ws);
    let command = ws.shipped()?;
    let wheel = build(ws, &tools)?;
    let uno = Build { board: Board::Uno, timer: 1, bench: false };
    let firmware = uno.controller(ws)?.elf;
    // The Mega has S-curves.
    Build { board: Board::Mega, ..uno }.controller(ws)?;
    for program in PROGRAMS {
        uno.make(ws, &Program::named(ws, program)?)?;
    }
    let sim = rig::program(ws, "sim")?;

    let clean = python::clean(ws, "venv-wheel")?;
    install(&clean, &wheel, &["--no-index"])?;
    let examples = ws.root.join("examples/python");
    let folder = ws.target.join("xtask/python");
    fs::create_dir_all(&folder)?;
    let chip = ["uno", "--elf", &firmware.to_string_lossy()];
    for script in scripts(&examples)? {
        try_example(&clean, &script, &folder, [(&command, &["board", "--pty"]), (&sim, &chip)])?;
    }

    install(&tools, &wheel, &["--no-index", "--no-deps", "--force-reinstall"])?;
    let python = ws.root.join("python");
    let mut tests = Command::new(&tools);
    tests.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).arg(python.join("tests"));
    // In another folder, so that the installed package is used, not the folder beside the tests.
    rig::with_firmware(ws, &mut tests);
    tests.env("STEPWRIGHT_COMMAND", &command).env("STEPWRIGHT_SIM", &sim);
    tests.env("STEPWRIGHT_TICKS", env::join_paths(ticks::compare(ws, &TRAVELS)?)?);
    run_within(TESTS_LIMIT, tests.current_dir(&folder))?;
    let mut notebook = Command::new(&tools);
    notebook.arg(python.join("tests/notebook.py")).arg("--check");
    run_within(TESTS_LIMIT, notebook.current_dir(&folder))?;
    let mut types = Command::new(&tools);
    let cache = ws.target.join("mypy");
    types.args(["-m", "mypy", "--strict", "stepwright_motion", "tests", "--cache-dir"]).arg(cache);
    workspace::run(types.current_dir(&python))?;
    node::PYRIGHT.prepare(ws)?;
    let mut types = Command::new("node");
    types.arg(node::PYRIGHT.modules(ws).join("pyright/index.js")).arg("--pythonpath").arg(&tools);
    workspace::run(types.arg("stepwright_motion").current_dir(&python))
}

/// Measures the time to make a plan into an array.
pub fn bench(ws: &Workspace, check: bool) -> Result<()> {
    python::MOTION.prepare(ws)?;
    let tools = python::MOTION.interpreter(ws);
    let wheel = build(ws, &tools)?;
    install(&tools, &wheel, &["--no-index", "--no-deps", "--force-reinstall"])?;
    let mut bench = Command::new(&tools);
    bench.arg(ws.root.join("python/tests/bench_arrays.py")).arg(ws.root.join("bench/python.json"));
    if check {
        bench.arg("--check");
    }
    workspace::run(&mut bench)
}

/// Builds the wheel. Returns its path.
fn build(ws: &Workspace, tools: &Path) -> Result<PathBuf> {
    let wheels = ws.target.join("wheels");
    if wheels.exists() {
        fs::remove_dir_all(&wheels)?;
    }
    let mut build = Command::new(tools);
    build.args(["-m", "maturin", "build", "--release", "--locked", "--target-dir"]).arg(&ws.target);
    workspace::run(build.arg("-o").arg(&wheels).current_dir(ws.root.join("python")))?;
    let mut built = fs::read_dir(&wheels)?;
    let wheel = built.next().context("maturin has built nothing")??.path();
    let name = wheel.file_name().unwrap_or_default().to_string_lossy().into_owned();
    ensure!(name.contains("-cp39-abi3-"), "{name} is not for Python 3.9 and all later ones");
    Ok(wheel)
}

fn install(python: &Path, wheel: &Path, options: &[&str]) -> Result<()> {
    let mut pip = Command::new(python);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]).args(options);
    workspace::run(pip.arg(wheel))
}

/// The numbered examples in order. Checks that each is short.
fn scripts(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut scripts = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|end| end == "py") {
            let text = fs::read_to_string(&path)?;
            let code = text.lines().filter(|line| !line.trim().is_empty());
            let lines = code.filter(|line| !line.starts_with("\"\"\"")).count();
            ensure!(lines <= SHORT, "{} has {lines} lines of code", path.display());
            scripts.push(path);
        }
    }
    scripts.sort();
    ensure!(scripts.len() >= 10, "there are {} examples", scripts.len());
    Ok(scripts)
}

/// Runs a script on a new virtual board, and on each of these boards, all at once. The boards are
/// commands that print `pty PATH` first.
fn try_example(
    python: &Path,
    script: &Path,
    folder: &Path,
    boards: [(&PathBuf, &[&str]); 2],
) -> Result<()> {
    let (mut running, mut held) = (Vec::new(), Vec::new());
    for (number, board) in [None].into_iter().chain(boards.map(Some)).enumerate() {
        let place = folder.join(format!("board-{number}"));
        fs::create_dir_all(&place)?;
        let mut run = Command::new(python);
        run.arg(script).current_dir(&place).stdin(Stdio::null()).stdout(Stdio::null());
        if let Some((program, words)) = board {
            let (board, port) = begin(program, words)?;
            held.push(board);
            run.arg(port);
        }
        running.push(Guard(run.env("STEPWRIGHT_MACHINE", "none").spawn()?));
    }
    for (run, on) in running.into_iter().zip(["in the process", "behind a pty", "on a chip"]) {
        match run.wait_within(EXAMPLE_LIMIT)? {
            Some(status) if status.success() => {}
            Some(status) => bail!("{} on a board {on}: {status}", script.display()),
            None => bail!("{} on a board {on} did not end", script.display()),
        }
    }
    Ok(())
}

/// Starts a board with a switch, for the script that homes. Returns its port.
fn begin(program: &Path, words: &[&str]) -> Result<(Guard, String)> {
    let mut board = Command::new(program);
    board.args(words).args(["--switch", "1:-300"]);
    board.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut board = Guard(board.spawn().context("starting the board")?);
    let mut first = String::new();
    let stdout = board.0.stdout.take().context("the board has no stdout")?;
    BufReader::new(stdout).read_line(&mut first)?;
    match first.trim_end().strip_prefix("pty ") {
        Some(port) => Ok((board, port.to_owned())),
        None => bail!("the board's first line is {first:?}, not `pty PATH`"),
    }
}
