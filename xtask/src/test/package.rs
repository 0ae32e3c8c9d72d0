//! Checks what users build from: the packages, the installed command, the library as a dependency.

use std::fs;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::workspace::{self, Workspace, line, output};

/// Checks that all packages that ship can be published, the command can be installed, and the
/// dependency and the law of the README make a program.
pub fn run(ws: &Workspace) -> Result<()> {
    // Without compiling, which the other steps do.
    let flags = ["--no-verify", "--allow-dirty", "--color=never"];
    clean(ws.cargo(["publish", "--dry-run", "--workspace"]).args(flags))?;
    // This crate is outside the workspace, so its dependencies would have to be published first.
    let avr = ws.root.join("crates/stepwright-avr/Cargo.toml");
    clean(
        ws.cargo(["package", "--exclude-lockfile", "--manifest-path"])
            .arg(avr)
            .args(flags)
            .arg("--target-dir")
            .arg(&ws.target),
    )?;
    install(ws)?;
    depend(ws)
}

/// Runs cargo. A warning is an error.
fn clean(command: &mut Command) -> Result<()> {
    eprintln!("$ {}", line(command));
    let out = command.output()?;
    let said = String::from_utf8_lossy(&out.stderr);
    let dry = |text: &&str| !text.ends_with("aborting upload due to dry run");
    let warnings = said.lines().filter(|text| text.starts_with("warning")).filter(dry).count();
    if !out.status.success() || warnings > 0 {
        bail!("{}: {}, {warnings} warnings\n{said}", line(command), out.status);
    }
    Ok(())
}

/// Installs as in the guide, with the build of the step `unit`.
fn install(ws: &Workspace) -> Result<()> {
    let root = ws.target.join("xtask/install");
    if root.exists() {
        fs::remove_dir_all(&root)?;
    }
    let mut install = ws.cargo(["install", "--path", "crates/stepwright-cli", "--locked"]);
    workspace::run(install.arg("--root").arg(&root).arg("--target-dir").arg(&ws.target))?;
    let mut order = Command::new(root.join("bin/stepwright"));
    order.args(["move", "1000", "--fast"]).env("STEPWRIGHT_MACHINE", "none");
    let said = output(&mut order)?;
    ensure!(said.ends_with("position 1000 ready\n"), "the installed command says {said}");
    Ok(())
}

/// A program beside a checkout, with the dependency and the last code of the README.
fn depend(ws: &Workspace) -> Result<()> {
    let readme = fs::read_to_string(ws.root.join("README.md"))?;
    let line = readme.lines().find(|line| line.starts_with("stepwright = { path"));
    let line = line.context("the README has no dependency line")?;
    let law = readme.rsplit("```rust\n").next().and_then(|rest| rest.split("```").next());
    let (uses, body) = law.and_then(|law| law.split_once("\n\n")).context("no code of a law")?;
    let folder = ws.target.join("xtask/beside");
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir_all(folder.join("mine/src"))?;
    // The checkout's folder may have another name.
    ensure!(line.contains("\"../stepwright/"), "the dependency is not in the checkout beside");
    let line = line.replace("../stepwright/", &format!("{}/", ws.root.display()));
    fs::write(
        folder.join("mine/Cargo.toml"),
        format!(
            "[package]\nname = \"mine\"\nedition = \"2024\"\n\n[dependencies]\n{line}\n\n[workspace]\n"
        ),
    )?;
    fs::write(
        folder.join("mine/src/main.rs"),
        format!(
            "{uses}\n\nfn main() -> Result<(), Box<dyn std::error::Error>> {{\n\
             let mut steps = 0;\n{}\nassert_eq!(steps, 4000);\nOk(())\n}}\n",
            body.replace("// ticks until", "let _ = delay; steps += 1; //")
        ),
    )?;
    let mut program = ws.cargo(["run", "--target-dir"]);
    workspace::run(program.arg(&ws.target).current_dir(folder.join("mine")))
}
