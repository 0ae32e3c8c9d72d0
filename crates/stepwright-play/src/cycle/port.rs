//! A board with the program `cycles`, and the messages for its errors.

use stepwright::drive::Arduino;
use stepwright_host::LinkError;
use stepwright_host::programs::{CycleProblem, CycleSession, RowProblem};

use crate::PlayError;

/// The Arduino model of the board.
pub fn arduino(board: &CycleSession) -> Arduino {
    if board.board() == "mega" { Arduino::Mega } else { Arduino::Uno }
}

/// The error for a row that was not carried out although the file is correct.
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
    // The board answered before.
    PlayError::lost(name, &trouble).hint("what it plays goes on; a reset of the board ends it")
}
