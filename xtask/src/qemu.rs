//! QEMU, the firmware for 32-bit chips, and the programs that run it: `firmware/qemu`.
//!
//! If QEMU is missing, Debian's packages are installed. If they conflict with installed packages
//! (another QEMU's tools, say), they are unpacked under `target`, and nothing is removed.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::setup::{self, Need};
use crate::workspace::{Workspace, alone_in, output, run, succeeds};

/// The needs for building the firmware.
pub const BUILD_NEEDS: &[&Need] = &[setup::CROSS];

/// The programs of QEMU that simulate the boards.
const PROGRAMS: [&str; 2] = ["qemu-system-arm", "qemu-system-riscv32"];

/// Finds or installs QEMU. Returns the folder where it was unpacked; `None` if it is installed.
pub fn prepare(ws: &Workspace) -> Result<Option<PathBuf>> {
    if PROGRAMS.iter().all(|program| succeeds(program, &["--version"])) {
        return Ok(None);
    }
    let root = ws.target.join("qemu-packages");
    // Steps of both lanes may do this.
    let _alone = alone_in(&ws.target.join("xtask/qemu"))?;
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

/// Whether the QEMU that was unpacked in this folder runs.
fn works(root: &Path) -> bool {
    PROGRAMS.iter().all(|program| output(command(Some(root), program).arg("--version")).is_ok())
}

/// A command for a program of QEMU, from the result of [`prepare`].
pub fn command(root: Option<&Path>, program: &str) -> Command {
    let Some(root) = root else { return Command::new(program) };
    let mut command = Command::new(root.join("usr/bin").join(program));
    command.env("LD_LIBRARY_PATH", libraries(root));
    command
}

/// The library path of an unpacked QEMU.
fn libraries(root: &Path) -> String {
    let folder = |folder: &str| root.join(folder).join(format!("{}-linux-gnu", env::consts::ARCH));
    ["usr/lib", "lib"].map(|name| folder(name).display().to_string()).join(":")
}

/// Downloads the packages and their missing dependencies, and unpacks them.
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

/// A cargo command for `firmware/qemu`, with the paths that it needs.
pub fn cargo(ws: &Workspace, verb: &str, qemu: Option<&Path>) -> Command {
    let target = ws.target.join("qemu");
    let mut cargo = ws.cargo([verb]);
    cargo.current_dir(ws.root.join("firmware/qemu")).arg("--target-dir").arg(&target);
    tell(ws, &mut cargo, qemu);
    cargo
}

/// Sets the paths for a program of `firmware/qemu`.
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
