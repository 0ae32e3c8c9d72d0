//! `cargo xtask page`: the foreign files of the page of `stepwright serve`, and the page for any
//! host.
//!
//! The files are in the repository, so that nobody needs npm to build the command. Their digests
//! are in this file, so that a manual change is noticed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::setup;
use crate::workspace::{Workspace, output, run};

/// Fetch what the page of `stepwright serve` carries from elsewhere.
#[derive(clap::Args)]
pub struct Page {
    /// Fetch nothing, and fail if what is there is not that.
    #[arg(long)]
    check: bool,
    /// Write the page into a folder, for any host: without a server it drives a virtual board, or
    /// one on a serial port of the browser.
    #[arg(long, value_name = "FOLDER", conflicts_with = "check")]
    r#static: Option<PathBuf>,
}

/// The package of the plots, and its version.
const PACKAGE: &str = "uplot@1.6.32";
const ARCHIVE: &str = "uplot-1.6.32.tgz";

/// The folder of the files that only a page without a server needs.
const ALONE: &str = "alone";

/// The files of the package, their names in the repository, and their SHA-256.
const FILES: [(&str, &str, &str); 3] = [
    (
        "dist/uPlot.iife.min.js",
        "uPlot.iife.min.js",
        "19c8d4c6ad88929a79f4ae49d6f7161566dfd0ba3d15cc495e974f787eb78f1f",
    ),
    (
        "dist/uPlot.min.css",
        "uPlot.min.css",
        "df630c6a8d6f8eeaff264b50f73ce5b114f646ffd9a0bb74f049b0a00135fa04",
    ),
    (
        "LICENSE",
        "uPlot.LICENSE",
        "8f989229699b4fe2f1a0432d0e9edc338a8a911e250e2d1b01ecd770a5f5b1bd",
    ),
];

impl Page {
    /// Fetches the files, or compares them.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        if let Some(folder) = &self.r#static {
            return write_static(ws, folder);
        }
        if !self.check {
            setup::ensure(&[setup::NODE])?;
            let place = ws.target.join("page");
            fs::create_dir_all(&place)?;
            run(Command::new("npm").current_dir(&place).args(["pack", PACKAGE]))?;
            run(Command::new("tar").current_dir(&place).args(["-xzf", ARCHIVE]))?;
            fs::create_dir_all(folder(ws))?;
            for (from, to, _) in FILES {
                fs::copy(place.join("package").join(from), folder(ws).join(to))?;
            }
        }
        check(ws)
    }
}

/// Checks that the files are those of the package.
pub fn check(ws: &Workspace) -> Result<()> {
    for (_, name, digest) in FILES {
        let said = output(Command::new("sha256sum").arg(folder(ws).join(name)))?;
        ensure!(
            said.starts_with(digest),
            "{name} is not that of {PACKAGE}: run `cargo xtask page`"
        );
    }
    Ok(())
}

/// Writes every file of the page under the name by which the page loads it.
pub fn write_static(ws: &Workspace, to: &Path) -> Result<()> {
    check(ws)?;
    fs::create_dir_all(to)?;
    let vendor = folder(ws);
    let page = vendor.parent().context("the page has a folder")?;
    let mut files = vec![
        (vendor.join("uPlot.iife.min.js"), "uplot.js".to_owned()),
        (vendor.join("uPlot.min.css"), "uplot.css".to_owned()),
        (vendor.join("uPlot.LICENSE"), "uplot.LICENSE".to_owned()),
    ];
    for folder in [page.to_owned(), page.join(ALONE)] {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            let name = path.strip_prefix(page)?.to_string_lossy().into_owned();
            if path.is_file() && !name.ends_with(".txt") {
                files.push((path, name));
            }
        }
    }
    fs::create_dir_all(to.join(ALONE))?;
    for (from, name) in files {
        let bytes = fs::read(&from).with_context(|| from.display().to_string())?;
        let is_own = name.ends_with(".js") && !from.starts_with(&vendor);
        let bytes = if is_own { bare(str::from_utf8(&bytes)?).into_bytes() } else { bytes };
        fs::write(to.join(name), bytes)?;
    }
    Ok(())
}

/// A script without the comments that fill whole lines: they are for readers of the source, and 7 KB of what
/// a host would send.
fn bare(script: &str) -> String {
    let (mut bare, mut inside) = (String::new(), false);
    for line in script.split_inclusive('\n') {
        let text = line.trim();
        inside |= text.starts_with("/*") && (text.ends_with("*/") || !text.contains("*/"));
        if !inside && !text.starts_with("//") {
            bare.push_str(line);
        }
        inside &= !text.ends_with("*/");
    }
    bare
}

fn folder(ws: &Workspace) -> PathBuf {
    ws.root.join("crates/stepwright-serve/src/page/vendor")
}

#[cfg(test)]
mod tests {
    use super::bare;

    #[test]
    fn a_script_is_sent_without_its_comments() {
        let script =
            "/* a\n * b */\n// c\nlet d = 1; // e\n  /** f */\n  d /* g */ += 2;\n/* h */ d();\n";
        let sent = "let d = 1; // e\n  d /* g */ += 2;\n/* h */ d();\n";
        assert_eq!(bare(script), sent);
    }
}
