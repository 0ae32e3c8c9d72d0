//! `cargo xtask wasm`: the planner that the page of `stepwright serve` carries, and the virtual
//! board and the host library of the page for any host.
//!
//! As with the images of firmware, another compiler makes other bytes, so beside each module
//! stands a digest of all that it is built from, and of itself.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::digest::Digest;
use crate::setup;
use crate::toolchain::Cross;
use crate::workspace::{Workspace, output, run};

/// Build the planner, the virtual board and the host library of the page, and put them beside the
/// page's files.
#[derive(clap::Args)]
pub struct Wasm {
    /// Change nothing, and fail if those that are there were built from other code.
    #[arg(long)]
    check: bool,
}

/// A browser. (A linker is the compiler's own.)
pub const BROWSER: &str = "wasm32-unknown-unknown";

/// The profile of the workspace that they are built by.
const PROFILE: &str = "wasm";

/// A module that the page carries.
#[derive(Clone, Copy)]
pub struct Module {
    /// Its package.
    package: &'static str,
    /// Its file among those of the page.
    file: &'static str,
    /// The crates of the standard library that it takes.
    library: &'static str,
    /// How it is optimised: `s` for speed within a size, `z` for size alone.
    level: &'static str,
    /// What else the compiler is told.
    flags: &'static str,
    /// All that it is built from, besides this file.
    sources: &'static [&'static str],
}

/// The planner.
pub const PLAN: Module = Module {
    package: "stepwright-wasm",
    file: "plan.wasm",
    library: "core",
    level: "s",
    flags: "",
    sources: &["stepwright", "stepwright-austin", "stepwright-oracle", "stepwright-wasm"],
};

/// The virtual board.
pub const BOARD: Module = Module {
    package: "stepwright-wasm-board",
    file: "board.wasm",
    library: "core",
    level: "s",
    flags: "",
    sources: &[
        "stepwright",
        "stepwright-protocol",
        "stepwright-device",
        "stepwright-sim",
        "stepwright-wasm-board",
    ],
};

/// The host library. It allocates, so its panics can't be proven away: they are traps.
pub const HOST: Module = Module {
    package: "stepwright-wasm-host",
    file: "host.wasm",
    library: "std,panic_abort",
    level: "z",
    // A panic is a trap without words, which would be a fifth of the module.
    // Nor does it print for debugging: `{:?}` of what no page can cause.
    flags: "-Zunstable-options -Cpanic=immediate-abort -Zfmt-debug=none",
    sources: &[
        "stepwright",
        "stepwright-protocol",
        "stepwright-host",
        "stepwright-keeper",
        "stepwright-wasm-host",
    ],
};

const MODULES: [Module; 3] = [PLAN, BOARD, HOST];

impl Wasm {
    /// Builds and writes, or compares.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        if self.check {
            return check(ws);
        }
        setup::ensure(&[setup::CROSS])?;
        for module in MODULES {
            let built = fs::read(module.build(ws)?)?;
            fs::write(module.place(ws), &built)?;
            println!("{}  {} bytes", module.place(ws).display(), built.len());
            fs::write(module.digests_of(ws), module.digests(ws)?)?;
        }
        Ok(())
    }
}

/// Whether the modules are those that were built, from the code that is there.
pub fn check(ws: &Workspace) -> Result<()> {
    for module in MODULES {
        let carried = fs::read_to_string(module.digests_of(ws)).unwrap_or_default();
        let now = module.digests(ws)?;
        ensure!(
            carried == now,
            "the page's {} was built from other code: run `cargo xtask wasm`\n{carried}now\n{now}",
            module.file
        );
    }
    Ok(())
}

impl Module {
    /// Where it lies.
    pub fn place(&self, ws: &Workspace) -> PathBuf {
        ws.root.join("crates/stepwright-serve/src/page").join(self.file)
    }

    fn digests_of(&self, ws: &Workspace) -> PathBuf {
        self.place(ws).with_extension("digests.txt")
    }

    fn build(&self, ws: &Workspace) -> Result<PathBuf> {
        let cross = Cross::find().context("no compiler for wasm: run `cargo xtask setup`")?;
        println!("compiler: {}", cross.describe());
        let folder = ws.target.join("cross");
        let mut cargo = cross.cargo_with(self.library, ws, "rustc", &folder);
        cargo.args(["--target", BROWSER]);
        cargo.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS", self.flags);
        cargo.env("CARGO_PROFILE_WASM_OPT_LEVEL", self.level);
        cargo.args(["--package", self.package, "--profile", PROFILE, "--crate-type", "cdylib"]);
        cargo.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", linker()?);
        run(&mut cargo)?;
        let folder = folder.join(BROWSER).join(PROFILE);
        Ok(folder.join(self.package.replace('-', "_")).with_extension("wasm"))
    }

    /// A line for the sources, and one for the module.
    fn digests(&self, ws: &Workspace) -> Result<String> {
        let mut sources = Digest::NEW;
        let crates = ws.root.join("crates");
        for name in self.sources {
            sources.add_all(&ws.root, &crates.join(name).join("Cargo.toml"))?;
            sources.add_all(&ws.root, &crates.join(name).join("src"))?;
        }
        sources.add_all(&ws.root, &ws.root.join("xtask/src/wasm.rs"))?;
        let mut module = Digest::NEW;
        module.add(&fs::read(self.place(ws)).unwrap_or_default());
        Ok(format!("sources {:016x}\nmodule {:016x}\n", sources.value(), module.value()))
    }
}

/// Builds a package with this feature as a module of its own, and fails if that imports anything:
/// its panic handler is to be an import.
pub fn cannot_panic(ws: &Workspace, package: &str, feature: &str) -> Result<()> {
    let cross = Cross::find().context("no compiler for wasm: run `cargo xtask setup`")?;
    let folder = ws.target.join("cross");
    let mut cargo = cross.cargo_with("core", ws, "rustc", &folder);
    cargo.args(["--target", BROWSER, "--package", package, "--features", feature]);
    cargo.args(["--profile", PROFILE, "--crate-type", "cdylib"]);
    // As chips have it. For size alone the bounds of a table in `core`'s square root stay checked.
    cargo.env("CARGO_PROFILE_WASM_OPT_LEVEL", "3");
    // An undefined function is an import, so that the failure can be told.
    cargo.env(
        "CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS",
        "-Clink-arg=--allow-undefined -Clink-arg=--export=push",
    );
    cargo.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", linker()?);
    run(&mut cargo)?;
    let file = folder.join(BROWSER).join(PROFILE).join(package.replace('-', "_"));
    let module = fs::read(file.with_extension("wasm"))?;
    let sections = sections(&module).context("no module of WebAssembly")?;
    ensure!(sections.contains(&CODE), "{package}: the module holds no code");
    ensure!(!sections.contains(&IMPORTS), "{package}: it can panic: its module has imports");
    Ok(())
}

/// The numbers of two sections of a module.
const IMPORTS: u8 = 2;
const CODE: u8 = 10;

/// The numbers of a module's sections.
fn sections(module: &[u8]) -> Option<Vec<u8>> {
    let mut rest = module.strip_prefix(b"\0asm\x01\0\0\0")?;
    let mut found = Vec::new();
    while let Some((number, mut tail)) = rest.split_first() {
        let (mut size, mut shift) = (0usize, 0u32);
        loop {
            let (byte, after) = tail.split_first()?;
            tail = after;
            size |= usize::from(byte & 0x7f).checked_shl(shift)?;
            shift += 7;
            if byte & 0x80 == 0 {
                break;
            }
        }
        found.push(*number);
        rest = tail.get(size..)?;
    }
    Some(found)
}

/// The linker of rustup's toolchain, or of the system.
pub fn linker() -> Result<PathBuf> {
    let root = output(Command::new("rustc").args(["--print", "sysroot"]))?;
    let about = output(Command::new("rustc").arg("-vV"))?;
    let host = about.lines().find_map(|line| line.strip_prefix("host: ")).unwrap_or_default();
    let own = Path::new(root.trim()).join("lib/rustlib").join(host).join("bin/rust-lld");
    Ok(if own.is_file() { own } else { "wasm-ld".into() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_of_a_module_are_found() {
        let long = [b"\0asm\x01\0\0\0\x02\x81\x01".as_slice(), &[7; 129], b"\x0a\0"].concat();
        assert_eq!(sections(&long), Some(vec![IMPORTS, CODE]));
        assert_eq!(sections(&long[..long.len() - 1]), None);
        assert_eq!(sections(b"\0asm"), None);
    }
}
