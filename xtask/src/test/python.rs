//! The Python package: its wheel is built, put into a clean environment, and tried there on virtual
//! boards, in the process and behind a pseudo-terminal.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};

use crate::python;
use crate::workspace::{self, Guard, Workspace, run_within};

/// An example is something to read and try: it has to be done soon, on a loaded machine, too.
const EXAMPLE_LIMIT: Duration = Duration::from_secs(60);
/// All tests.
const TESTS_LIMIT: Duration = Duration::from_secs(240);
/// A task of a lab is a script of this many lines of code at most.
const SHORT: usize = 15;

/// Builds the wheel; runs every example on both kinds of board without any other package, then the
/// tests and the check of the types with numpy beside it.
pub fn run(ws: &Workspace) -> Result<()> {
    python::MOTION.prepare(ws)?;
    let tools = python::MOTION.interpreter(ws);
    let command = ws.shipped()?;
    let wheel = build(ws, &tools)?;

    let clean = python::clean(ws, "venv-wheel")?;
    install(&clean, &wheel, &["--no-index"])?;
    let examples = ws.root.join("examples/python");
    let folder = ws.target.join("xtask/python");
    fs::create_dir_all(&folder)?;
    for script in scripts(&examples)? {
        try_example(&clean, &script, &folder, &command)?;
    }

    install(&tools, &wheel, &["--no-index", "--no-deps", "--force-reinstall"])?;
    let python = ws.root.join("python");
    let mut tests = Command::new(&tools);
    tests.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).arg(python.join("tests"));
    // From elsewhere: the package is the installed one, not the folder beside the tests.
    run_within(TESTS_LIMIT, tests.env("STEPWRIGHT_COMMAND", &command).current_dir(&folder))?;
    let mut types = Command::new(&tools);
    let cache = ws.target.join("mypy");
    types.args(["-m", "mypy", "--strict", "stepwright_motion", "tests", "--cache-dir"]).arg(cache);
    workspace::run(types.current_dir(&python))
}

/// Builds the wheel, and gives its path.
fn build(ws: &Workspace, tools: &Path) -> Result<PathBuf> {
    let (target, python) = (ws.target.join("python"), ws.root.join("python"));
    let wheels = target.join("wheels");
    if wheels.exists() {
        fs::remove_dir_all(&wheels)?;
    }
    let lint = ["clippy", "--release", "--locked", "--target-dir"];
    let mut clippy = ws.cargo(lint);
    workspace::run(clippy.arg(&target).args(["--", "-D", "warnings"]).current_dir(&python))?;
    let mut build = Command::new(tools);
    build.args(["-m", "maturin", "build", "--release", "--locked", "--target-dir"]).arg(&target);
    workspace::run(build.arg("-o").arg(&wheels).current_dir(&python))?;
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

/// The numbered examples in their order, each of them short.
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

/// Runs a script on a virtual board of its own, and on one behind a pseudo-terminal, at once.
fn try_example(python: &Path, script: &Path, folder: &Path, stepwright: &Path) -> Result<()> {
    let mut board = Command::new(stepwright);
    // A switch, for the one that looks for it.
    board.args(["board", "--pty", "--switch", "1:-300"]);
    board.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut board = Guard(board.spawn().context("starting the virtual board")?);
    let mut first = String::new();
    let stdout = board.0.stdout.take().context("the board has no stdout")?;
    BufReader::new(stdout).read_line(&mut first)?;
    let Some(port) = first.trim_end().strip_prefix("pty ") else {
        bail!("the board's first line is {first:?}, not `pty PATH`");
    };
    let on_its_own = folder.join("virtual");
    fs::create_dir_all(&on_its_own)?;
    let mut alone = Command::new(python);
    alone.arg(script).current_dir(&on_its_own).stdin(Stdio::null()).stdout(Stdio::null());
    let alone = Guard(alone.env("STEPWRIGHT_MACHINE", "none").spawn()?);
    let mut there = Command::new(python);
    there.arg(script).arg(port).current_dir(folder).env("STEPWRIGHT_MACHINE", "none");
    run_within(EXAMPLE_LIMIT, &mut there)?;
    match alone.wait_within(EXAMPLE_LIMIT)? {
        Some(status) if status.success() => Ok(()),
        Some(status) => bail!("{} on a virtual board: {status}", script.display()),
        None => bail!("{} on a virtual board did not end", script.display()),
    }
}
