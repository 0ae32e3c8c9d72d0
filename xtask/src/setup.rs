//! `cargo xtask setup`: the programs that the machine must have, and their installation.
//!
//! A need is met if a probe of the program itself succeeds, whoever installed it. Debian's packages
//! are used to install it, not to look for it. If all needs are met, this takes a fraction of a
//! second and changes nothing.

use std::env;
use std::io::{IsTerminal, stdin};
use std::path::Path;
use std::process::Command;
use std::sync::Once;

use anyhow::{Context, Result, bail};

use crate::toolchain::Cross;
use crate::workspace::{Workspace, alone_in, output, run, succeeds};
use crate::{node, python, qemu};

/// Find what the chores need, and install what is missing.
#[derive(clap::Args)]
pub struct Setup {}

impl Setup {
    /// Meets every need, also of chores that are not tests.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        ensure(ALL)?;
        python::SERIAL.prepare(ws)?;
        python::API.prepare(ws)?;
        python::PIO.prepare(ws)?;
        node::AVR8JS.prepare(ws)?;
        node::RP2040JS.prepare(ws)?;
        qemu::prepare(ws)?;
        for need in ALL {
            println!("{:<16}found", need.name);
        }
        Ok(())
    }
}

/// A program or library that a chore needs.
pub struct Need {
    name: &'static str,
    /// Whether this machine has it; quick, and silent.
    found: fn() -> bool,
    /// The Debian 12 packages that contain it.
    packages: &'static [&'static str],
    /// Another way to get it, as a sentence, or "".
    or_else: &'static str,
}

impl Need {
    /// The packages that contain it.
    pub fn packages(&self) -> &'static [&'static str] {
        self.packages
    }
}

/// A compiler for small chips.
pub const CROSS: &Need = &Need {
    name: "cross compiler",
    found: || Cross::find().is_some(),
    packages: &["rustc-web", "rust-web-src", "libstd-rust-web-dev"],
    or_else: "(They can't stand beside Debian's rustc.) Or, with rustup: rustup component add rust-src",
};

/// A linker for AVR, with its C library and objdump.
pub const AVR_GCC: &Need = &Need {
    name: "avr-gcc",
    found: || {
        // avr-gcc returns a name that it can't find unchanged.
        let start = ["-mmcu=atmega328p", "-print-file-name=crtatmega328p.o"];
        output(Command::new("avr-gcc").args(start))
            .is_ok_and(|path| Path::new(path.trim()).is_absolute())
            && succeeds("avr-objdump", &["--version"])
    },
    packages: &["gcc-avr", "avr-libc", "binutils-avr"],
    or_else: "",
};

/// The program that writes a firmware to a board.
pub const AVRDUDE: &Need = &Need {
    name: "avrdude",
    // It has no option that only prints its version; without arguments it prints its help.
    found: || output(&mut Command::new("avrdude")).is_ok(),
    packages: &["avrdude"],
    or_else: "",
};

/// The tools and libraries with which the crate `simavr-ffi` compiles and links simavr.
pub const SIMAVR: &Need = &Need {
    name: "simavr's needs",
    found: || {
        succeeds("make", &["--version"])
            && succeeds("pkg-config", &["--exists", "libelf", "libzstd"])
            && libclang()
    },
    packages: &["clang", "libclang-14-dev", "libelf-dev", "libzstd-dev", "pkg-config", "make"],
    or_else: "",
};

/// A Python that can make virtual environments: [`python::Environment`] makes one.
pub const PYTHON: &Need = &Need {
    name: "python",
    found: || python::base().is_some(),
    packages: &["python3", "python3-venv"],
    or_else: "",
};

/// A Node for the second simulator and for the browser: [`node::Packages`] installs both.
pub const NODE: &Need = &Need {
    name: "node 18 and npm",
    found: node::found,
    packages: &["nodejs", "npm"],
    or_else: "",
};

/// A sender of G-code with a graphical interface, and a virtual screen for it.
pub const BCNC: &Need = &Need {
    name: "bCNC",
    found: || {
        ["/usr/bin/bCNC", "/usr/bin/xvfb-run", "/usr/bin/xauth"]
            .iter()
            .all(|file| Path::new(file).is_file())
    },
    packages: &["bcnc", "xvfb", "xauth"],
    or_else: "",
};

/// A logic analyser that reads the VCD dumps.
pub const SIGROK: &Need = &Need {
    name: "sigrok-cli",
    found: || succeeds("sigrok-cli", &["--version"]),
    packages: &["sigrok-cli"],
    or_else: "",
};

/// The boot loader of a Nano from before 2018, which uses STK500. (In Debian's build, that of an
/// Uno is too long for its place.)
pub const NANO_LOADER: &str =
    "/usr/share/arduino/hardware/arduino/avr/bootloaders/atmega/ATmegaBOOT_168_atmega328.hex";

/// The boot loader of a Mega, which uses STK500 version 2.
pub const MEGA_LOADER: &str =
    "/usr/share/arduino/hardware/arduino/avr/bootloaders/stk500v2/stk500boot_v2_mega2560.hex";

/// A simulator of 32-bit chips: a micro:bit, and the RISC-V board `virt`.
pub const QEMU: &Need = &Need {
    name: "qemu",
    found: || {
        ["qemu-system-arm", "qemu-system-riscv32"]
            .iter()
            .all(|program| succeeds(program, &["--version"]))
    },
    packages: &["qemu-system-arm", "qemu-system-misc"],
    or_else: "",
};

/// Boot loaders for the simulated chip.
pub const ARDUINO: &Need = &Need {
    name: "boot loaders",
    found: || [NANO_LOADER, MEGA_LOADER].iter().all(|file| Path::new(file).is_file()),
    packages: &["arduino-core-avr"],
    or_else: "",
};

/// A browser for the page of `stepwright serve`. Any Chromium will do; the tests are skipped where
/// none can be installed.
pub const CHROMIUM: &Need = &Need {
    name: "chromium",
    found: || succeeds("chromium", &["--version"]),
    packages: &["chromium"],
    or_else: "",
};

/// The arguments that list the files of LinuxCNC; an error if it is not installed.
pub const LINUXCNC_FILES: [&str; 2] = ["--listfiles", "linuxcnc-uspace"];

/// An interpreter of G-code, `rs274`, and jobs for it. Only one chore needs it.
pub const LINUXCNC: &Need = &Need {
    name: "rs274",
    found: || succeeds("dpkg-query", &LINUXCNC_FILES),
    packages: &["linuxcnc-uspace"],
    or_else: "",
};

/// The needs that `setup` installs.
const ALL: &[&Need] = &[CROSS, AVR_GCC, AVRDUDE, SIMAVR, PYTHON, NODE, SIGROK, ARDUINO];

/// Checks `needs`, and installs only what is missing.
pub fn ensure(needs: &[&Need]) -> Result<()> {
    let missing: Vec<_> = needs.iter().filter(|need| !(need.found)()).collect();
    if !missing.is_empty() {
        let packages: Vec<_> = missing.iter().flat_map(|need| need.packages).copied().collect();
        apt(&packages).with_context(|| advice(&missing))?;
    }
    if let Some(need) = missing.iter().find(|need| !(need.found)()) {
        bail!(
            "{} is not there, or too old, although its packages are installed. Are Debian's \
             updates and security among the package sources? {}",
            need.name,
            need.or_else
        );
    }
    Ok(())
}

/// The message for missing needs that could not be installed.
fn advice(missing: &[&&Need]) -> String {
    let mut text = String::from(
        "something is missing that could not be installed. Install these Debian packages",
    );
    for need in missing {
        text += &format!("\n  {}: {} {}", need.name, need.packages.join(" "), need.or_else);
    }
    text + "\nand run the same command again. The reason"
}

/// Installs Debian packages, as root or through sudo.
fn apt(packages: &[&str]) -> Result<()> {
    if !succeeds("apt-get", &["--version"]) {
        bail!("no apt-get on this system");
    }
    let get = || -> Result<Command> {
        let mut command = if output(Command::new("id").arg("-u"))?.trim() == "0" {
            Command::new("apt-get")
        } else if succeeds("sudo", &["-n", "true"]) || (stdin().is_terminal() && sudo()) {
            let mut command = Command::new("sudo");
            command.arg("apt-get");
            command
        } else {
            bail!("installing packages takes root or sudo");
        };
        command.env("DEBIAN_FRONTEND", "noninteractive").arg("--quiet=2");
        Ok(command)
    };
    // Another step may run apt-get, which does not wait for the lock of the lists. Another user's
    // lock is ignored.
    let _alone = alone_in(&env::temp_dir().join("stepwright-apt")).ok();
    // Updates always, because with an image's old lists apt finds a rustc-web that is too old. A
    // failure is not fatal: it may be a single unreachable source of the user.
    static UPDATE: Once = Once::new();
    let mut update = get()?;
    UPDATE.call_once(|| {
        if let Err(error) = run(update.arg("update")) {
            println!("going on with the package lists as they are: {error}");
        }
    });
    // --no-remove: rustc-web conflicts with Debian's rustc and rustup, and the user must decide
    // about that.
    run(get()?
        .args(["install", "--yes", "--no-install-recommends", "--no-remove"])
        .args(["-o", "DPkg::Lock::Timeout=600", "-o", "DPkg::Use-Pty=0"])
        .args(packages))
}

/// Asks for the user's password once, on the terminal.
fn sudo() -> bool {
    Command::new("sudo").arg("-v").status().is_ok_and(|status| status.success())
}

/// Whether clang is installed with the library that bindgen loads.
fn libclang() -> bool {
    // …/lib/clang/14.0.6: the library is two folders up.
    let Ok(resources) = output(Command::new("clang").arg("-print-resource-dir")) else {
        return false;
    };
    let Some(lib) = Path::new(resources.trim()).ancestors().nth(2) else { return false };
    let Ok(files) = lib.read_dir() else { return false };
    files.flatten().any(|file| {
        // Not libclang-cpp, which is installed with clang itself.
        file.file_name().to_string_lossy().starts_with("libclang.")
    })
}
