//! `cargo xtask sim`: the firmware on a simulated chip, in real time, on a
//! pseudo-terminal, so that any serial program drives the real binary.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;

#[cfg(not(unix))]
use anyhow::bail;
use anyhow::{Result, ensure};

use crate::firmware::{self, Board, Build};
use crate::program::{CONTROLLER, Program};
use crate::workspace::Workspace;
use crate::{image, rig, setup};

/// Run the firmware on a simulated chip, on a pseudo-terminal.
///
/// Lines on standard input act on the machine: `press 1`, `release 1` (the limit switch of an
/// axis), `reset` (the button), `power` (the plug is pulled and put back), `end` (as Ctrl-C).
/// `where` prints the chip's time, and each axis by the edges of its pins.
#[derive(clap::Args)]
pub struct Sim {
    board: Board,
    /// Also make the pseudo-terminal known by this name.
    #[arg(long, value_name = "PATH")]
    pty_link: Option<PathBuf>,
    /// Another program than the controller: see `cargo xtask firmware BOARD --list`.
    #[arg(long, value_name = "NAME", default_value = CONTROLLER)]
    program: String,
    /// Another firmware than the one of this checkout.
    #[arg(long, value_name = "FILE", conflicts_with = "program")]
    elf: Option<PathBuf>,
    /// Give an axis a limit switch to ground at a place, in steps from where its shaft is at
    /// the start: 1:-300. On another pin than the shield's: 1:500@D12.
    #[arg(long, value_name = "AXIS:STEPS", allow_hyphen_values = true)]
    switch: Vec<String>,
    /// Write down every change of the board's pins, for GTKWave or PulseView.
    #[arg(long, value_name = "FILE")]
    vcd: Option<PathBuf>,
    /// Let its time pass as fast as this machine can, instead of in real time.
    #[arg(long)]
    fast: bool,
}

impl Sim {
    /// Builds the programs and becomes the simulator, which ends at Ctrl-C.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        if let Some(elf) = &self.elf {
            ensure!(elf.is_file(), "there is no file {}", elf.display());
        }
        eprintln!("1 of 3: what the chip runs, {} for the {}", self.what(), self.board.name());
        let (kind, firmware) = self.firmware(ws)?;
        eprintln!("2 of 3: the simulator; the first time it takes some minutes to compile");
        setup::ensure(rig::SIM_NEEDS)?;
        let mut sim = Command::new(rig::program(ws, "sim")?);
        rig::with_firmware(ws, &mut sim);
        sim.arg(self.board.name());
        sim.arg(kind).arg(firmware);
        for switch in &self.switch {
            sim.args(["--switch", switch]);
        }
        if let Some(vcd) = &self.vcd {
            sim.arg("--vcd").arg(vcd);
        }
        if self.fast {
            sim.arg("--fast");
        }
        if let Some(command) = self.elf.is_none().then(|| tried_with(&self.program)).flatten() {
            sim.args(["--tried-with", command]);
        }
        if let Some(link) = &self.pty_link {
            sim.arg("--pty-link").arg(link);
        }
        eprintln!("3 of 3: the chip runs");
        become_it(sim)
    }
}

/// A subcommand for a program, as an example; `None` if there is none.
fn tried_with(program: &str) -> Option<&'static str> {
    Some(match program {
        CONTROLLER => "move 4000",
        "timed" => "timed --speed 100 --steps 200",
        "cycles" => "cycle examples/cycles/readme.toml",
        "laws" => "move 400 --law austin",
        "transitions" => "move 400 --law linear-factor",
        "power-term" => "move 400 --law power",
        "stream" => "gcode examples/gcode/badge.nc",
        _ => return None,
    })
}

/// The command that starts a simulated board with a program and writes its time to a file. The path
/// of the file must be appended.
pub fn in_its_own_time(ws: &Workspace, board: Board, program: &str) -> Result<Vec<OsString>> {
    setup::ensure(rig::SIM_NEEDS)?;
    let sim = Sim {
        board,
        pty_link: None,
        program: program.to_owned(),
        elf: None,
        switch: Vec::new(),
        vcd: None,
        fast: false,
    };
    let (kind, firmware) = sim.firmware(ws)?;
    let simulator = rig::program(ws, "sim")?.into();
    Ok(vec![simulator, board.name().into(), kind.into(), firmware.into(), "--clock".into()])
}

impl Sim {
    /// The firmware's name, for messages.
    fn what(&self) -> String {
        match &self.elf {
            Some(elf) => elf.display().to_string(),
            None => format!("the program {}", self.program),
        }
    }

    /// The firmware, and the simulator's option for its kind. For a carried program whose image is
    /// up to date, neither a cross compiler nor a build is needed.
    fn firmware(&self, ws: &Workspace) -> Result<(&'static str, PathBuf)> {
        if let Some(elf) = &self.elf {
            return Ok(("--elf", elf.clone()));
        }
        let program = Program::named(ws, &self.program)?;
        if let Some(carried) = image::carried(ws, self.board, &program) {
            eprintln!("the firmware is the carried one: {}", carried.display());
            return Ok(("--flash", carried));
        }
        eprintln!(
            "it is compiled with the core library; the first time that takes a minute or two"
        );
        setup::ensure(firmware::NEEDS)?;
        let build = Build { board: self.board, timer: 1, bench: false };
        Ok(("--elf", build.make(ws, &program)?.elf))
    }
}

/// Replaces this process, so that Ctrl-C reaches only the simulator, and its summary comes last.
#[cfg(unix)]
fn become_it(mut program: Command) -> Result<()> {
    use std::os::unix::process::CommandExt;
    Err(program.exec().into())
}

#[cfg(not(unix))]
fn become_it(_: Command) -> Result<()> {
    bail!("the simulated chip needs pseudo-terminals, which this system has not")
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::tried_with;
    use crate::firmware::Board;
    use crate::program::{CONTROLLER, Program};
    use crate::workspace::{Workspace, cargo_path, output};
    use serde_json::Value;

    /// Every program that a subcommand can drive over its serial line is carried by
    /// `stepwright flash`.
    #[test]
    fn only_programs_with_a_line_are_tried_by_a_command() {
        let ws = Workspace::load().unwrap();
        for program in Program::all(&ws).unwrap() {
            let carried =
                [Board::Uno, Board::Mega].into_iter().any(|board| program.is_carried(board));
            assert_eq!(tried_with(&program.name).is_some(), carried, "{}", program.name);
        }
        assert_eq!((tried_with(CONTROLLER), tried_with("first-move")), (Some("move 4000"), None));
    }

    #[test]
    fn the_simulated_board_takes_few_crates() {
        let ws = Workspace::load().unwrap();
        let manifest = ws.root.join("firmware/rig/Cargo.toml");
        let mut cargo = Command::new(cargo_path());
        cargo
            .args(["metadata", "--no-deps", "--format-version=1", "--manifest-path"])
            .arg(manifest);
        let metadata: Value = serde_json::from_str(&output(&mut cargo).unwrap()).unwrap();
        let all = metadata["packages"][0]["dependencies"].as_array().unwrap();
        let needed = all.iter().filter(|one| one["kind"].is_null() && one["optional"] == false);
        let mut names: Vec<_> = needed.filter_map(|one| one["name"].as_str()).collect();
        names.sort_unstable();
        let few =
            "anyhow clap ctrlc rustix simavr-ffi stepwright stepwright-protocol stepwright-sim";
        assert_eq!(names.join(" "), few);
    }
}
