//! `cargo xtask wasm`: the planner that the page of `stepwright serve` carries.
//!
//! As with the images of firmware, another compiler makes other bytes, so beside the module
//! stands a digest of all that it is built from, and of itself.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::digest::Digest;
use crate::setup;
use crate::toolchain::{Chip, Cross};
use crate::workspace::{Workspace, output, run};

/// Build the planner of the page, and put it beside the page's files.
#[derive(clap::Args)]
pub struct Wasm {
    /// Change nothing, and fail if the one that is there was built from other code.
    #[arg(long)]
    check: bool,
}

/// A browser. (A linker is the compiler's own.)
const BROWSER: Chip = Chip { triple: "wasm32-unknown-unknown", flags: "" };

/// The package, and the profile of the workspace that it is built by.
const PACKAGE: &str = "stepwright-wasm";
const PROFILE: &str = "wasm";

/// All that it is built from.
const SOURCES: [&str; 7] = [
    "crates/stepwright/Cargo.toml",
    "crates/stepwright/src",
    "crates/stepwright-austin/Cargo.toml",
    "crates/stepwright-austin/src",
    "crates/stepwright-wasm/Cargo.toml",
    "crates/stepwright-wasm/src",
    "xtask/src/wasm.rs",
];

impl Wasm {
    /// Builds and writes, or compares.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        if self.check {
            return check(ws);
        }
        setup::ensure(&[setup::CROSS])?;
        let built = fs::read(build(ws)?)?;
        fs::write(place(ws), &built)?;
        println!("{}  {} bytes", place(ws).display(), built.len());
        Ok(fs::write(digests_of(ws), digests(ws)?)?)
    }
}

/// Whether the module is the one that was built, from the code that is there.
pub fn check(ws: &Workspace) -> Result<()> {
    let carried = fs::read_to_string(digests_of(ws)).unwrap_or_default();
    let now = digests(ws)?;
    ensure!(
        carried == now,
        "the page's planner was built from other code: run `cargo xtask wasm`\n{carried}now\n{now}"
    );
    Ok(())
}

/// Where it lies.
pub fn place(ws: &Workspace) -> PathBuf {
    ws.root.join("crates/stepwright-serve/src/page/plan.wasm")
}

fn digests_of(ws: &Workspace) -> PathBuf {
    place(ws).with_extension("digests.txt")
}

fn build(ws: &Workspace) -> Result<PathBuf> {
    let cross = Cross::find().context("no compiler for wasm: run `cargo xtask setup`")?;
    println!("compiler: {}", cross.describe());
    let mut cargo = cross.cargo(ws, "rustc", &[&BROWSER]);
    cargo.args(["--package", PACKAGE, "--profile", PROFILE, "--crate-type", "cdylib"]);
    cargo.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", linker()?);
    run(&mut cargo)?;
    let folder = ws.target.join("cross").join(BROWSER.triple).join(PROFILE);
    Ok(folder.join("stepwright_wasm.wasm"))
}

/// The linker of rustup's toolchain, or of the system.
fn linker() -> Result<PathBuf> {
    let root = output(Command::new("rustc").args(["--print", "sysroot"]))?;
    let about = output(Command::new("rustc").arg("-vV"))?;
    let host = about.lines().find_map(|line| line.strip_prefix("host: ")).unwrap_or_default();
    let own = Path::new(root.trim()).join("lib/rustlib").join(host).join("bin/rust-lld");
    Ok(if own.is_file() { own } else { "wasm-ld".into() })
}

/// A line for the sources, and one for the module.
fn digests(ws: &Workspace) -> Result<String> {
    let mut sources = Digest::NEW;
    for source in SOURCES {
        sources.add_all(&ws.root, &ws.root.join(source))?;
    }
    let mut module = Digest::NEW;
    module.add(&fs::read(place(ws)).unwrap_or_default());
    Ok(format!("sources {:016x}\nmodule {:016x}\n", sources.value(), module.value()))
}
