//! A browser drives the page of `stepwright serve`: Playwright from npm, with the Chromium
//! that the system has.

use std::env;
use std::path::PathBuf;
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
    let script = "crates/stepwright-serve/tests/page/drive.mjs";
    let mut drive = Command::new("node");
    drive.current_dir(&ws.root).arg(script).arg(ws.built("stepwright")).arg(browser);
    if let Some(folder) = env::var_os("STEPWRIGHT_PICTURES") {
        drive.arg(folder);
    }
    drive.env("NODE_PATH", node::PLAYWRIGHT.modules(ws));
    if run_within(LIMIT, &mut drive).is_err() {
        bail!("the page does not do what it shows");
    }
    Ok(())
}
