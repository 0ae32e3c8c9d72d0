//! Tests the page of `stepwright serve` in a browser: Playwright from npm, with the system's
//! Chromium.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Result, bail, ensure};

use crate::firmware::{Board, Build};
use crate::workspace::{self, Workspace, run_within, succeeds};
use crate::{node, page, rig, setup};

/// The time limit of a script, which takes a minute on an idle machine.
const LIMIT: Duration = Duration::from_secs(600);

/// The names of Chromium's program.
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// The path of a browser; Playwright needs a path.
fn browser() -> Option<PathBuf> {
    let path = env::var_os("PATH")?;
    let places = env::split_paths(&path).flat_map(|folder| BROWSERS.map(|name| folder.join(name)));
    places.into_iter().find(|place| place.is_file() && succeeds(place, &["--version"]))
}

/// The tools of the page's scripts.
struct Driver<'a> {
    ws: &'a Workspace,
    browser: PathBuf,
    /// The page for any host.
    page: PathBuf,
}

impl<'a> Driver<'a> {
    /// Prepares the tools; `None` if there is no browser.
    fn prepare(ws: &'a Workspace) -> Result<Option<Driver<'a>>> {
        if browser().is_none()
            && let Err(error) = setup::ensure(&[setup::CHROMIUM])
        {
            println!("{error:#}");
        }
        let Some(browser) = browser() else {
            // In CI, a page that was not tested is a failure.
            ensure!(env::var_os("CI").is_none(), "there is no browser to test the page with");
            println!("skipped: there is no browser here, and none can be installed");
            return Ok(None);
        };
        ws.shipped()?;
        node::PLAYWRIGHT.prepare(ws)?;
        let page = ws.target.join("page/static");
        page::write_static(ws, &page)?;
        Ok(Some(Driver { ws, browser, page }))
    }

    fn play(&self, script: &str, more: &[&Path]) -> Result<()> {
        let mut drive = Command::new("node");
        drive.current_dir(&self.ws.root);
        drive.arg(format!("crates/stepwright-serve/tests/page/{script}"));
        drive.arg(self.ws.command()).arg(&self.browser).args(more);
        if let Some(folder) = env::var_os("STEPWRIGHT_PICTURES") {
            drive.arg(folder);
        }
        drive.env("NODE_PATH", node::PLAYWRIGHT.modules(self.ws));
        rig::with_firmware(self.ws, &mut drive);
        if run_within(LIMIT, &mut drive).is_err() {
            bail!("the page does not do what it shows");
        }
        Ok(())
    }
}

/// Checks that the carried files are the right ones, and tests the page.
pub fn run(ws: &Workspace) -> Result<()> {
    page::check(ws)?;
    let Some(driver) = Driver::prepare(ws)? else { return Ok(()) };
    let copied = ws.target.join("page/copied");
    driver.play("drive.mjs", &[])?;
    driver.play("plan.mjs", &[&driver.page, &copied])?;
    driver.play("paths.mjs", &[&driver.page])?;
    driver.play("jobs.mjs", &[])?;
    driver.play("alone.mjs", &[&driver.page])?;
    compile(ws, &copied)
}

/// Tests the page with a simulated Uno, against the chip's pins.
pub fn run_chip(ws: &Workspace) -> Result<()> {
    let Some(driver) = Driver::prepare(ws)? else { return Ok(()) };
    Build { board: Board::Uno, timer: 1, bench: false }.controller(ws)?;
    let sim = rig::program(ws, "sim")?;
    driver.play("chip.mjs", &[&driver.page, &sim])
}

/// Runs the code from "copy as Rust", and compares its durations with those that the page has
/// shown.
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
