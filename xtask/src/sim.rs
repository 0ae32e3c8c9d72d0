//! `cargo xtask sim`: the firmware on a simulated chip, in real time, on a
//! pseudo-terminal, so that any serial program drives the real binary.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;
#[cfg(not(unix))]
use anyhow::bail;

use crate::firmware::Board;
use crate::workspace::Workspace;
use crate::{rig, setup};

/// Run the firmware on a simulated chip, on a pseudo-terminal.
#[derive(clap::Args)]
pub struct Sim {
    board: Board,
    /// Also make the pseudo-terminal known by this name.
    #[arg(long, value_name = "PATH")]
    pty_link: Option<PathBuf>,
    /// Another firmware than the one of this checkout.
    #[arg(long, value_name = "FILE")]
    elf: Option<PathBuf>,
}

impl Sim {
    /// Builds what is needed and becomes the simulator, which ends at Ctrl-C.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        setup::ensure(rig::NEEDS)?;
        if self.elf.is_none() {
            rig::firmware(ws, self.board, false)?;
        }
        let mut sim = Command::new(rig::program(ws, "sim")?);
        rig::with_firmware(ws, &mut sim);
        sim.arg(self.board.name());
        if let Some(elf) = &self.elf {
            sim.arg("--elf").arg(elf);
        }
        if let Some(link) = &self.pty_link {
            sim.arg("--pty-link").arg(link);
        }
        become_it(sim)
    }
}

/// So that Ctrl-C reaches the simulator alone, and its summary comes last.
#[cfg(unix)]
fn become_it(mut program: Command) -> Result<()> {
    use std::os::unix::process::CommandExt;
    Err(program.exec().into())
}

#[cfg(not(unix))]
fn become_it(_: Command) -> Result<()> {
    bail!("the simulated chip needs pseudo-terminals, which this system has not")
}
