//! The failures of a homing, as messages of the command.

use stepwright_host::homing::HomingFailure;

use crate::failure::Failure;

/// The message, and a hint.
pub fn failure(why: HomingFailure) -> Failure {
    let failure = Failure::new(why.to_string());
    match why {
        HomingFailure::NotFound { .. } => {
            failure.hint("is it wired, and on this side (switch-forward)? Else a longer --within")
        }
        HomingFailure::StillClosed { .. } => {
            failure.hint("a longer --back-off, or look at the switch, its wiring and switch-high")
        }
        HomingFailure::Unstopped => failure.hint("did another master or a reset stop it?"),
        HomingFailure::NotAway => failure.hint("`stepwright status` may say what stopped it"),
        _ => failure,
    }
}
