//! Builds the documentation as a book, and checks every link of every page.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};

use crate::book::{self, links};
use crate::workspace::{Workspace, output};

/// The least number of links of both kinds of pages, so that a checker that finds none fails.
const LEAST: (usize, usize) = (100, 800);

/// Checks the links within the project's Markdown, as a code host shows it, and those of the book.
/// Links to other machines are not followed.
pub fn run(ws: &Workspace) -> Result<()> {
    let files = output(&mut {
        let mut git = std::process::Command::new("git");
        git.current_dir(&ws.root).args(["ls-files", "--cached", "--others", "--exclude-standard"]);
        git.args(["-z", "*.md"]);
        git
    })?;
    let pages: Vec<_> = files
        .split_terminator('\0')
        .map(|name| ws.root.join(name))
        .filter(|f| f.is_file())
        .collect();
    let (markdown, mut faults) = links::follow(&pages)?;
    let html = book::build(ws)?;
    let mut pages = Vec::new();
    collect(&html, &mut pages)?;
    let (hypertext, more) = links::follow(&pages)?;
    faults.extend(more);
    for fault in &faults {
        println!("{fault}");
    }
    println!("{markdown} links of Markdown, {hypertext} of {} pages of HTML", pages.len());
    if !faults.is_empty() {
        bail!("{} links lead nowhere", faults.len());
    }
    ensure!(markdown > LEAST.0 && hypertext > LEAST.1, "there are more links than those");
    Ok(())
}

/// Collects the HTML pages below a folder, except the 404 page, which is for a server's root.
fn collect(folder: &Path, pages: &mut Vec<PathBuf>) -> Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, pages)?;
        } else if path.extension().is_some_and(|end| end == "html") && !path.ends_with("404.html") {
            pages.push(path);
        }
    }
    Ok(())
}
