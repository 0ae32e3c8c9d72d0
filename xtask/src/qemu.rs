//! QEMU, the firmware for chips of 32 bits, and what runs them: `firmware/qemu`.
//!
//! QEMU is the machine's, or Debian's packages are installed. Where they can't stand beside what is
//! there (another QEMU's tools, say) they are unpacked under `target`, and nothing is removed.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::setup::{self, Need};
use crate::toolchain::{Chip, Cross};
use crate::workspace::{Workspace, cargo_path, output, run, succeeds};

/// What building the firmware takes.
pub const BUILD_NEEDS: &[&Need] = &[setup::CROSS];

/// A board by its name: a folder in `firmware`, whose manifest says the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SmallBoard {
    /// BBC micro:bit (nRF51822, Cortex-M0).
    Nrf51,
    /// Raspberry Pi Pico (RP2040, Cortex-M0+).
    Rp2040,
    /// QEMU's `virt` (RISC-V).
    Virt,
}

impl SmallBoard {
    /// All of them.
    pub const ALL: [SmallBoard; 3] = [SmallBoard::Nrf51, SmallBoard::Rp2040, SmallBoard::Virt];

    /// Its folder.
    pub const fn name(self) -> &'static str {
        match self {
            SmallBoard::Nrf51 => "nrf51",
            SmallBoard::Rp2040 => "rp2040",
            SmallBoard::Virt => "virt",
        }
    }

    /// Builds its programs: one `.elf` each in `target/firmware`.
    pub fn build(self, ws: &Workspace) -> Result<Vec<PathBuf>> {
        build(ws, self.name())
    }
}

/// The folder with programs for the micro:bit that have an executor, RTIC or a main loop of their own.
pub const EXAMPLES: &str = "microbit";

/// Builds the programs of a folder in `firmware`: one `.elf` each in `target/firmware`.
pub fn build(ws: &Workspace, name: &str) -> Result<Vec<PathBuf>> {
    let cross = Cross::find().context("no compiler for small chips: run `cargo xtask setup`")?;
    let folder = ws.root.join("firmware").join(name);
    let mut cargo = Command::new(cargo_path());
    cargo.args(["metadata", "--no-deps", "--format-version=1", "--manifest-path"]);
    let metadata: Value = serde_json::from_str(&output(cargo.arg(folder.join("Cargo.toml")))?)?;
    let package = &metadata["packages"][0];
    let triple = package["metadata"]["board"]["triple"].as_str().context("a triple")?;
    let triple: &'static str = triple.to_owned().leak();
    let built = ws.target.join("chips");
    let mut cargo = cross.cargo_in(ws, "build", &[&Chip { triple, flags: "" }], &built);
    if let Some(linker) = linker() {
        let name = triple.to_uppercase().replace('-', "_");
        cargo.env(format!("CARGO_TARGET_{name}_LINKER"), linker);
    }
    run(cargo.current_dir(&folder).args(["--release", "--bins"]))?;
    let to = ws.target.join("firmware");
    fs::create_dir_all(&to)?;
    let mut elves = Vec::new();
    for target in package["targets"].as_array().into_iter().flatten() {
        if target["kind"][0] == "bin" {
            let program = target["name"].as_str().context("a program's name")?;
            let elf = to.join(format!("{name}-{}.elf", program.replace('_', "-")));
            fs::copy(built.join(triple).join("release").join(program), &elf)?;
            elves.push(elf);
        }
    }
    Ok(elves)
}

/// LLVM's linker: the compiler's own, else that of any toolchain that rustup has. `None` if the
/// compiler is to look for it.
fn linker() -> Option<PathBuf> {
    let active = output(Command::new("rustc").args(["--print", "sysroot"])).ok()?;
    let host = output(Command::new("rustc").arg("-vV")).ok()?;
    let host = host.lines().find_map(|line| line.strip_prefix("host: "))?.to_owned();
    let own = Path::new(active.trim()).join("lib/rustlib").join(host).join("bin/rust-lld");
    own.is_file().then_some(own)
}

/// The programs of QEMU that boards are simulated by.
const PROGRAMS: [&str; 2] = ["qemu-system-arm", "qemu-system-riscv32"];

/// Where QEMU is: `None` if it is installed.
pub fn prepare(ws: &Workspace) -> Result<Option<PathBuf>> {
    if PROGRAMS.iter().all(|program| succeeds(program, &["--version"])) {
        return Ok(None);
    }
    let root = ws.target.join("qemu-packages");
    if works(&root) {
        return Ok(Some(root));
    }
    match setup::ensure(&[setup::QEMU]) {
        Ok(()) => Ok(None),
        Err(error) => {
            println!("{error:#}\nunpacking the packages under target instead");
            unpack(&root)?;
            ensure!(works(&root), "QEMU was unpacked to {}, and does not run", root.display());
            Ok(Some(root))
        }
    }
}

/// Whether QEMU runs that was unpacked here.
fn works(root: &Path) -> bool {
    PROGRAMS.iter().all(|program| {
        let mut command = Command::new(root.join("usr/bin").join(program));
        command.env("LD_LIBRARY_PATH", libraries(root)).arg("--version");
        output(&mut command).is_ok()
    })
}

/// Its libraries.
fn libraries(root: &Path) -> String {
    let folder = |folder: &str| root.join(folder).join(format!("{}-linux-gnu", env::consts::ARCH));
    ["usr/lib", "lib"].map(|name| folder(name).display().to_string()).join(":")
}

/// Downloads the packages with all that they need and that is not installed, and unpacks them.
fn unpack(root: &Path) -> Result<()> {
    let mut simulate = Command::new("apt-get");
    simulate.args(["install", "--simulate", "--no-install-recommends"]);
    let plan = output(simulate.args(setup::QEMU.packages()))?;
    let names = plan.lines().filter_map(|line| line.strip_prefix("Inst ")?.split(' ').next());
    let names: Vec<_> = names.collect();
    let folder = root.join("packages");
    fs::create_dir_all(&folder)?;
    run(Command::new("apt-get").args(["download", "--quiet=2"]).args(names).current_dir(&folder))?;
    for entry in folder.read_dir()? {
        run(Command::new("dpkg-deb").arg("--extract").arg(entry?.path()).arg(root))?;
    }
    fs::remove_dir_all(folder).context("removing the packages")
}

/// A cargo command for `firmware/qemu`, which is told where everything is.
pub fn cargo(ws: &Workspace, verb: &str, qemu: Option<&Path>) -> Command {
    let target = ws.target.join("qemu");
    let mut cargo = ws.cargo([verb]);
    cargo.current_dir(ws.root.join("firmware/qemu")).arg("--target-dir").arg(&target);
    tell(ws, &mut cargo, qemu);
    cargo
}

/// Tells a program of `firmware/qemu` where everything is.
pub fn tell(ws: &Workspace, command: &mut Command, qemu: Option<&Path>) {
    command.env("STEPWRIGHT_FIRMWARE", ws.target.join("firmware"));
    let plugin =
        format!("{}stepwright_qemu_plugin{}", env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX);
    command.env("STEPWRIGHT_PLUGIN", ws.target.join("qemu/release").join(plugin));
    if let Some(root) = qemu {
        command.env("STEPWRIGHT_QEMU", root);
    }
}

/// Builds the plugin.
pub fn plugin(ws: &Workspace) -> Result<()> {
    run(cargo(ws, "build", None).args(["--release", "--package", "stepwright-qemu-plugin"]))
}
