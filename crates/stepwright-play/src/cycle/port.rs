//! A board that runs the program `cycles`, and words for its troubles.

use stepwright::drive::Arduino;
use stepwright_host::LinkError;
use stepwright_host::programs::{CycleProblem, CycleSession, RowProblem};

use crate::PlayError;

/// Which Arduino it is.
pub fn arduino(board: &CycleSession) -> Arduino {
    if board.board() == "mega" { Arduino::Mega } else { Arduino::Uno }
}

/// Why a row was not obeyed, though the file is fine.
pub fn failure(name: &str, problem: CycleProblem) -> PlayError {
    let version = "does it run the same version of the program as this command?";
    let trouble = match problem {
        RowProblem::Lost(trouble) => trouble,
        RowProblem::Noise { .. } => LinkError::Silent,
        RowProblem::Refused { row, reason } => {
            return PlayError::new(format!("{name} refused the line {row}: {reason}"))
                .hint(version);
        }
        RowProblem::Nonsense { answer, .. } | RowProblem::OtherProgram(answer) => {
            return PlayError::new(format!("{name} answered {answer:?}, which is no answer"))
                .hint(version);
        }
    };
    // The board was there a moment ago.
    PlayError::lost(name, &trouble).hint("what it plays goes on; a reset of the board ends it")
}
