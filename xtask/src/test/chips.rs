//! The firmware for every board of 32 bits builds, fits its chip, and takes no more than its bound.

use anyhow::{Result, ensure};

use crate::small::SmallBoard;
use crate::workspace::{Workspace, run as carry_out};

/// Builds all programs of all boards, and says what each takes.
pub fn run(ws: &Workspace) -> Result<()> {
    let mut complaints = Vec::new();
    for board in SmallBoard::all(ws)? {
        // A workspace of its own: nothing else looks at its style.
        let fmt = carry_out(ws.cargo(["fmt", "--all", "--check"]).current_dir(board.folder()));
        let built = fmt.and_then(|()| board.build(ws));
        let told = built.and_then(|elves| elves.iter().try_for_each(|elf| board.tell_size(elf)));
        // The others may do.
        if let Err(error) = told {
            complaints.push(format!("{}: {error:#}", board.name));
        }
    }
    ensure!(complaints.is_empty(), "{}", complaints.join("\n"));
    Ok(())
}
