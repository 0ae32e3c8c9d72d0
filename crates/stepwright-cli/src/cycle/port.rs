//! `cycle FILE --port`: the line to a board that runs the program `cycles`, and the command's words
//! for its troubles.

use stepwright::drive::Arduino;
use stepwright_cycle::line::NAME;
use stepwright_host::Session;
use stepwright_host::link::Link;
use stepwright_host::programs::{CycleProblem, CycleSession, RowProblem};

use crate::failure::Failure;
use crate::order::target;

/// Meets the board at the end of a line.
pub fn meet(link: Box<dyn Link>) -> Result<CycleSession, Failure> {
    // A signal ends the watching, and the cycle is finished then.
    let mut session = Session::new(link);
    let name = session.name();
    let about = target::met_program(&mut session, NAME, |_| "cycles")?;
    CycleSession::of(session, about).map_err(|problem| failure(&name, problem))
}

/// Which Arduino it is.
pub fn arduino(board: &CycleSession) -> Arduino {
    if board.board() == "mega" { Arduino::Mega } else { Arduino::Uno }
}

/// Why a row was not obeyed, though the file is fine.
pub fn failure(name: &str, problem: CycleProblem) -> Failure {
    let version = "does it run the same version of the program as this command?";
    let trouble = match problem {
        RowProblem::Lost(trouble) => trouble,
        RowProblem::Noise { .. } => stepwright_host::LinkError::Silent,
        RowProblem::Refused { row, reason } => {
            return Failure::new(format!("{name} refused the line {row}: {reason}")).hint(version);
        }
        RowProblem::Nonsense { answer, .. } | RowProblem::OtherProgram(answer) => {
            return Failure::new(format!("{name} answered {answer:?}, which is no answer"))
                .hint(version);
        }
    };
    // The board was there a moment ago.
    target::lost(name, &trouble).hint("what it plays goes on; a reset of the board ends it")
}
