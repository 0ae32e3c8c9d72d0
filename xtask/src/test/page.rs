//! A browser drives the page of `stepwright serve`: Playwright from npm, with the Chromium
//! that the system has.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Result, bail, ensure};

use crate::setup;
use crate::workspace::{self, Workspace, run_within, succeeds};
use crate::{node, page};

/// Some ten seconds on an idle machine.
const LIMIT: Duration = Duration::from_secs(600);

/// What a Chromium is called.
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// Where a browser is: Playwright takes no bare name.
fn browser() -> Option<PathBuf> {
    let path = env::var_os("PATH")?;
    let places = env::split_paths(&path).flat_map(|folder| BROWSERS.map(|name| folder.join(name)));
    places.into_iter().find(|place| place.is_file() && succeeds(place, &["--version"]))
}

/// The files that are carried are the right ones, and the page does what it shows.
pub fn run(ws: &Workspace) -> Result<()> {
    page::check(ws)?;
    if browser().is_none()
        && let Err(error) = setup::ensure(&[setup::CHROMIUM])
    {
        println!("{error:#}");
    }
    let Some(browser) = browser() else {
        // Where the tests count, a page that nobody has looked at is a failure.
        ensure!(env::var_os("CI").is_none(), "there is no browser to test the page with");
        println!("skipped: there is no browser here, and none can be installed");
        return Ok(());
    };
    workspace::run(&mut ws.cargo(["build", "--package", "stepwright-cli"]))?;
    node::PLAYWRIGHT.prepare(ws)?;
    let place = ws.target.join("page");
    let (alone, copied) = (place.join("static"), place.join("copied"));
    page::write_static(ws, &alone)?;
    for (script, folders) in [
        ("drive.mjs", vec![]),
        ("plan.mjs", vec![&alone, &copied]),
        ("paths.mjs", vec![]),
        ("alone.mjs", vec![&alone]),
    ] {
        let mut drive = Command::new("node");
        drive.current_dir(&ws.root).arg(format!("crates/stepwright-serve/tests/page/{script}"));
        drive.arg(ws.built("stepwright")).arg(&browser).args(folders);
        if let Some(folder) = env::var_os("STEPWRIGHT_PICTURES") {
            drive.arg(folder);
        }
        drive.env("NODE_PATH", node::PLAYWRIGHT.modules(ws));
        if run_within(LIMIT, &mut drive).is_err() {
            bail!("the page does not do what it shows");
        }
    }
    compile(ws, &copied)
}

/// Runs what "copy as Rust" has given, against the durations that the page has shown.
fn compile(ws: &Workspace, copied: &Path) -> Result<()> {
    let crates = ws.root.join("crates");
    let text = format!(
        "[package]\nname = \"copied\"\nedition = \"2024\"\n\n[[bin]]\nname = \"copied\"\n\
         path = \"main.rs\"\n\n[dependencies]\nstepwright = {{ path = \"{0}/stepwright\" }}\n\
         stepwright-austin = {{ path = \"{0}/stepwright-austin\" }}\n\n[workspace]\n",
        crates.display()
    );
    fs::write(copied.join("Cargo.toml"), text)?;
    let mut program = ws.cargo(["run", "--target-dir"]);
    workspace::run(program.arg(&ws.target).current_dir(copied))
}
