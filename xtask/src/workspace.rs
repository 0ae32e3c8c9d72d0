//! The paths of the checkout, and running programs.

use std::env;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::processor;

/// This checkout, as cargo describes it.
pub struct Workspace {
    /// The folder of the top `Cargo.toml`.
    pub root: PathBuf,
    /// Where cargo builds: `target/` unless `CARGO_TARGET_DIR` says otherwise.
    pub target: PathBuf,
    /// What `cargo metadata --no-deps` prints.
    pub metadata: Value,
}

impl Workspace {
    /// Asks cargo about the checkout of the working directory.
    pub fn load() -> Result<Workspace> {
        let out = output(Command::new(cargo_path()).args([
            "metadata",
            "--no-deps",
            "--format-version=1",
        ]))?;
        let metadata: Value = serde_json::from_str(&out).context("reading cargo metadata")?;
        let path = |key: &str| -> Result<PathBuf> {
            Ok(metadata[key].as_str().with_context(|| format!("cargo metadata: no {key}"))?.into())
        };
        Ok(Workspace { root: path("workspace_root")?, target: path("target_directory")?, metadata })
    }

    /// A cargo command at the root of the checkout.
    pub fn cargo<S: AsRef<OsStr>>(&self, args: impl IntoIterator<Item = S>) -> Command {
        let mut cargo = Command::new(cargo_path());
        cargo.current_dir(&self.root).args(args);
        cargo
    }

    /// Builds the command as it ships, with the release profile, if needed. Returns its path.
    pub fn shipped(&self) -> Result<PathBuf> {
        run(&mut self.cargo(["build", "--release", "--package", "stepwright-cli"]))?;
        Ok(self.command())
    }

    /// The path of the command that [`shipped`](Workspace::shipped) builds.
    pub fn command(&self) -> PathBuf {
        self.released("stepwright")
    }

    /// The path of a program of `cargo build --release`.
    pub fn released(&self, name: &str) -> PathBuf {
        self.target.join("release").join(format!("{name}{}", env::consts::EXE_SUFFIX))
    }

    /// The path of a program of `cargo build` in the dev profile.
    pub fn built(&self, name: &str) -> PathBuf {
        self.target.join("debug").join(format!("{name}{}", env::consts::EXE_SUFFIX))
    }
}

/// Locks a folder until the returned file is dropped, for a build or an installation. Programs of
/// several boards have the same name there, and each is copied after its build.
pub fn alone_in(folder: &Path) -> Result<File> {
    fs::create_dir_all(folder)?;
    let file = File::create(folder.join(".copied"))?;
    file.lock().with_context(|| format!("waiting for {}", folder.display()))?;
    Ok(file)
}

/// Copies a file that another process may be reading, which sees either the old or the new file,
/// complete.
pub fn put(from: &Path, to: &Path) -> Result<()> {
    let beside = to.with_extension(format!("{}.tmp", std::process::id()));
    fs::copy(from, &beside).with_context(|| format!("copying {}", from.display()))?;
    fs::rename(&beside, to).with_context(|| format!("writing {}", to.display()))
}

/// The cargo that runs this chore.
pub fn cargo_path() -> OsString {
    env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// Runs a program to its end. A failure of it is an error.
pub fn run(command: &mut Command) -> Result<()> {
    eprintln!("$ {}", line(command));
    let before = processor::time();
    let status = command
        .stdin(Stdio::null())
        .status()
        .with_context(|| format!("starting {}", line(command)))?;
    tell_cost(before);
    verdict(command, status)
}

/// Prints the processor time of a long command, to show in a long log which to make shorter.
fn tell_cost(before: Duration) {
    let used = processor::time().saturating_sub(before);
    if used >= Duration::from_secs(5) {
        eprintln!("  {:.0} s of a processor", used.as_secs_f64());
    }
}

/// Like [`run`], but ends a program that takes longer than `limit`.
pub fn run_within(limit: Duration, command: &mut Command) -> Result<()> {
    eprintln!("$ {}", line(command));
    let before = processor::time();
    let child = Guard(
        command
            .stdin(Stdio::null())
            .spawn()
            .with_context(|| format!("starting {}", line(command)))?,
    );
    let ended = child.wait_within(limit)?;
    tell_cost(before);
    match ended {
        Some(status) => verdict(command, status),
        None => bail!("{} did not end within {} s", line(command), limit.as_secs()),
    }
}

/// Runs a program and returns its output as text. A failure of it is an error.
pub fn output(command: &mut Command) -> Result<String> {
    let out = command
        .stdin(Stdio::null())
        .output()
        .with_context(|| format!("starting {}", line(command)))?;
    if !out.status.success() {
        bail!("{}: {}\n{}", line(command), out.status, String::from_utf8_lossy(&out.stderr));
    }
    Ok(String::from_utf8_lossy(&out.stdout).into_owned())
}

/// Whether a program can be started and succeeds. Prints nothing.
pub fn succeeds(program: impl AsRef<OsStr>, args: &[&str]) -> bool {
    let mut command = Command::new(program);
    command.args(args).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

fn verdict(command: &Command, status: ExitStatus) -> Result<()> {
    if status.success() {
        return Ok(());
    }
    bail!("{}: {status}", line(command))
}

/// A command as a user would type it.
pub fn line(command: &Command) -> String {
    let program = command.get_program();
    let program = if program == cargo_path() { "cargo".as_ref() } else { program };
    let words: Vec<_> = std::iter::once(program)
        .chain(command.get_args())
        .map(|word| word.to_string_lossy())
        .collect();
    words.join(" ")
}

/// A running program that is killed at the end of its scope, so that a failed step leaves nothing
/// running.
pub struct Guard(pub Child);

impl Guard {
    /// Waits for the program's end; `None` if it still runs after `limit`.
    pub fn wait_within(mut self, limit: Duration) -> Result<Option<ExitStatus>> {
        let start = Instant::now();
        loop {
            if let Some(status) = self.0.try_wait()? {
                return Ok(Some(status));
            }
            if start.elapsed() > limit {
                return Ok(None);
            }
            sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        // Both fail only if it has ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
