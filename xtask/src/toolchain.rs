//! The compiler that builds for small chips.
//!
//! No stable toolchain ships `core` for AVR, so cargo builds it from source (`-Zbuild-std=core`).
//! That needs a compiler *with the source of its own standard library*, and `RUSTC_BOOTSTRAP=1`,
//! which permits this on a stable compiler; a nightly is not needed. The same compiler serves every
//! chip, so nothing has to be installed per target.
//!
//! The first of these compilers that has its source is used:
//!
//! 1. rustup's toolchains, the active one first
//!    (`rustup component add rust-src` gives it the source);
//! 2. Debian's `rustc-web` with `rust-web-src`.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::workspace::{Workspace, output, run};

/// A chip, as a target of the compiler.
pub struct Chip {
    /// The compiler's target.
    pub triple: &'static str,
    /// Further flags, as in `RUSTFLAGS`.
    pub flags: &'static str,
}

/// The flags for all AVRs, after `-C target-cpu`. LLVM's passes over machine code keep constants
/// and addresses in registers for later. On this chip that costs more pushes and moves than it
/// saves loads. Without these passes the Uno's firmware is 370 bytes smaller.
macro_rules! avr {
    ($chip:literal) => {
        concat!(
            "-C target-cpu=",
            $chip,
            " -C link-arg=-mrelax",
            " -C llvm-args=-disable-machine-licm",
            " -C llvm-args=-disable-machine-cse",
            " -C llvm-args=-join-splitedges",
        )
    };
}

/// Arduino Uno and Nano: 8 bits, 16 MHz, 32 KiB flash, 2 KiB RAM.
pub const ATMEGA328P: Chip = Chip { triple: "avr-none", flags: avr!("atmega328p") };
/// Arduino Mega: the same with 256 KiB flash, 8 KiB RAM, more timers.
pub const ATMEGA2560: Chip = Chip { triple: "avr-none", flags: avr!("atmega2560") };
/// An Uno's core with 128 KiB flash, 16 KiB RAM. No supported board has it: it is simulated, for
/// programs that do not fit an Uno.
pub const ATMEGA1284P: Chip = Chip { triple: "avr-none", flags: avr!("atmega1284p") };
/// RP2040 and similar chips: 32 bits, no division instruction, no atomic swaps.
pub const CORTEX_M0: Chip = Chip { triple: "thumbv6m-none-eabi", flags: "" };

/// A compiler that can build `core`.
pub struct Cross {
    rustc: PathBuf,
    release: String,
}

impl Cross {
    /// The first compiler on this machine that has its source and is new
    /// enough for the workspace.
    pub fn find() -> Option<Cross> {
        let active = output(Command::new("rustc").args(["--print", "sysroot"])).ok();
        let rustup = output(Command::new("rustup").args(["toolchain", "list", "-v"])).ok();
        // A line is "stable-x86_64-unknown-linux-gnu (active, default) /path".
        let listed = rustup.as_deref().unwrap_or("").lines();
        let listed = listed.filter_map(|line| Some(&line[line.find('/')?..]));

        let active = active.as_deref().map(str::trim);
        active.into_iter().chain(listed).chain(["/usr"]).find_map(|root| Cross::at(Path::new(root)))
    }

    /// The compiler whose `rustc --print sysroot` is `root`.
    fn at(root: &Path) -> Option<Cross> {
        let source = root.join("lib/rustlib/src/rust/library/core/Cargo.toml");
        if !source.is_file() {
            return None;
        }
        let rustc = root.join("bin/rustc");
        let version = output(Command::new(&rustc).arg("-vV")).ok()?;
        let release = version.lines().find_map(|line| line.strip_prefix("release: "))?;
        let enough = minor(release)? >= minor(env!("CARGO_PKG_RUST_VERSION"))?;
        enough.then(|| Cross { rustc, release: release.into() })
    }

    /// A short description of the compiler.
    pub fn describe(&self) -> String {
        format!("{} ({})", self.rustc.display(), self.release)
    }

    /// A cargo command that compiles with this compiler for `chips`, `core`
    /// included, and keeps what it builds in `target/cross`.
    pub fn cargo(&self, ws: &Workspace, verb: &str, chips: &[&Chip]) -> Command {
        self.cargo_in(ws, verb, chips, &ws.target.join("cross"))
    }

    /// Like [`cargo`](Cross::cargo), but builds in `folder`.
    pub fn cargo_in(&self, ws: &Workspace, verb: &str, chips: &[&Chip], folder: &Path) -> Command {
        let mut cargo = self.cargo_plain(ws, verb, folder);
        for chip in chips {
            cargo.args(["--target", chip.triple]);
            let name = chip.triple.to_uppercase().replace('-', "_");
            cargo.env(format!("CARGO_TARGET_{name}_RUSTFLAGS"), chip.flags);
        }
        cargo
    }

    /// Like [`cargo_in`](Cross::cargo_in), without a chip.
    pub fn cargo_plain(&self, ws: &Workspace, verb: &str, folder: &Path) -> Command {
        self.cargo_with("core", ws, verb, folder)
    }

    /// Like [`cargo_plain`](Cross::cargo_plain), with these crates of the standard library.
    pub fn cargo_with(&self, library: &str, ws: &Workspace, verb: &str, folder: &Path) -> Command {
        let mut cargo = ws.cargo([verb, &format!("-Zbuild-std={library}"), "--target-dir"]);
        cargo.arg(folder);
        cargo.env("RUSTC", &self.rustc).env("RUSTC_BOOTSTRAP", "1");
        // These would override the chip's own flags.
        cargo.env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS");
        cargo
    }
}

/// Builds `packages` for all `chips` at once, to use both cores of a small machine: `core` is one
/// crate and compiles on one of them.
///
/// No two chips may share a triple.
pub fn cross_build(
    ws: &Workspace,
    chips: &[&Chip],
    packages: &[&str],
    profile: &str,
) -> Result<()> {
    let cross = Cross::find().context("no compiler for small chips: run `cargo xtask setup`")?;
    println!("compiler: {}", cross.describe());
    let mut cargo = cross.cargo(ws, "build", chips);
    cargo.args(["--profile", profile]);
    for package in packages {
        cargo.args(["--package", package]);
    }
    run(&mut cargo)
}

/// The 96 of "1.96.0-nightly".
fn minor(release: &str) -> Option<u32> {
    release.strip_prefix("1.")?.split('.').next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn releases_compare_by_their_minor_number() {
        assert_eq!(minor("1.96.0-nightly"), Some(96));
        assert_eq!(minor("1.88"), Some(88));
        assert_eq!(minor("2.0.0"), None);
    }
}
