//! Checks that the firmware of every 32-bit board builds, fits its chip, and stays within its size
//! limits.

use anyhow::{Result, ensure};

use crate::small::SmallBoard;
use crate::workspace::{Workspace, run as carry_out};

/// Builds all programs of all boards, and prints their sizes.
pub fn run(ws: &Workspace) -> Result<()> {
    let mut complaints = Vec::new();
    for board in SmallBoard::all(ws)? {
        // A separate workspace, which no other step formats.
        let fmt = carry_out(ws.cargo(["fmt", "--all", "--check"]).current_dir(board.folder()));
        let built = fmt.and_then(|()| board.build(ws));
        let told = built.and_then(|elves| elves.iter().try_for_each(|elf| board.tell_size(elf)));
        // Continues with the other boards.
        if let Err(error) = told {
            complaints.push(format!("{}: {error:#}", board.name));
        }
    }
    ensure!(complaints.is_empty(), "{}", complaints.join("\n"));
    Ok(())
}
