//! `cargo xtask book`: the documentation as one book, `target/book/html/index.html`.
//!
//! The pages stay in their folders, so that their links also work on a code host. The book's source
//! is a copy of them, and of each file that they link to, in the same folders.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::workspace::{Workspace, output, run};

pub mod links;

/// Build the guide, and all other documentation, as a book of HTML.
#[derive(clap::Args)]
pub struct Book {}

/// The folder of `book.toml`, and of `src/SUMMARY.md`.
const GUIDE: &str = "docs/guide";
/// The pinned version of mdBook, which `cargo install` takes exactly.
const MDBOOK: &str = "0.5.4";

impl Book {
    /// Builds the book and prints its path.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        println!("{}", build(ws)?.join("index.html").display());
        Ok(())
    }
}

/// Builds the book. Returns its folder of HTML.
///
/// # Errors
/// mdBook fails or warns.
pub fn build(ws: &Workspace) -> Result<PathBuf> {
    let mdbook = mdbook(ws)?;
    let book = ws.target.join("book");
    if book.exists() {
        fs::remove_dir_all(&book)?;
    }
    let source = book.join("src");
    let guide = ws.root.join(GUIDE);
    let summary = guide.join("src/SUMMARY.md");
    let mut files = BTreeSet::new();
    let text = fs::read_to_string(&summary).with_context(|| summary.display().to_string())?;
    let mut moved = text.clone();
    for link in links::of_markdown(&text) {
        let page = links::resolve(&summary, &link.path);
        let name = within(ws, &page)?;
        moved = moved.replace(&format!("]({})", link.target()), &format!("]({name})"));
        let text = fs::read_to_string(&page).with_context(|| page.display().to_string())?;
        let linked = links::of_markdown(&text).into_iter().filter(|link| !link.path.is_empty());
        files.extend(linked.map(|link| links::resolve(&page, &link.path)));
        files.insert(page);
    }
    for file in files {
        let to = source.join(within(ws, &file)?);
        fs::create_dir_all(to.parent().unwrap_or(&source))?;
        if file.is_file() {
            fs::copy(&file, to).with_context(|| file.display().to_string())?;
        }
    }
    fs::write(source.join("SUMMARY.md"), moved)?;
    fs::copy(guide.join("book.toml"), book.join("book.toml"))?;
    let html = book.join("html");
    let said = Command::new(mdbook).arg("build").arg(&book).arg("-d").arg(&html).output()?;
    let said = [said.stdout, said.stderr].map(|said| String::from_utf8_lossy(&said).into_owned());
    let said = said.concat();
    print!("{said}");
    ensure!(html.join("index.html").is_file(), "mdBook has not built the book");
    if said.lines().any(|line| line.contains("WARN") || line.contains("ERROR")) {
        bail!("mdBook warns");
    }
    Ok(html)
}

/// A file's path from the top of the checkout.
fn within(ws: &Workspace, file: &Path) -> Result<String> {
    let name = file.strip_prefix(&ws.root);
    let name = name.with_context(|| format!("{} is outside", file.display()))?;
    Ok(name.to_string_lossy().replace('\\', "/"))
}

/// mdBook's program: `target/mdbook`, compiled once.
fn mdbook(ws: &Workspace) -> Result<PathBuf> {
    let root = ws.target.join("mdbook");
    let program = root.join("bin/mdbook").with_extension(std::env::consts::EXE_EXTENSION);
    let ready =
        || output(Command::new(&program).arg("--version")).is_ok_and(|v| v.contains(MDBOOK));
    if !ready() {
        let build = root.join("build");
        // Built without optimisation, debug lines, its server and search: this saves a minute.
        run(ws
            .cargo(["install", "mdbook", "--locked", "--debug", "--no-default-features"])
            .args(["--version", MDBOOK])
            .arg("--root")
            .arg(&root)
            .arg("--target-dir")
            .arg(&build)
            .env("CARGO_PROFILE_DEV_DEBUG", "none"))?;
        fs::remove_dir_all(&build)?;
        ensure!(ready(), "{} is not mdBook {MDBOOK}", program.display());
    }
    Ok(program)
}
