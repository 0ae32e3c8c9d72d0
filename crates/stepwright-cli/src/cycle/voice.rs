//! Prints a player's messages on standard output and standard error. Ctrl-C ends the player.

use std::fmt::Display;

use stepwright_play::{PlayError, PlayVoice};

use crate::failure::Failure;
use crate::{interrupt, say};

/// The voice of the command line.
pub struct Aloud;

impl PlayVoice for Aloud {
    fn result(&self, line: &dyn Display) {
        say::result(line);
    }

    fn note(&self, line: &dyn Display) {
        say::note(line);
    }

    fn asked(&self) -> bool {
        interrupt::asked()
    }
}

impl From<PlayError> for Failure {
    fn from(error: PlayError) -> Failure {
        let mut failure = match error.interrupted {
            true => Failure::interrupted(error.message),
            false => Failure::new(error.message),
        };
        if let Some(place) = error.place {
            failure = failure.at(place.what, place.line);
            if let Some(column) = place.column {
                failure = failure.column(column);
            }
            if let Some(motor) = place.motor {
                failure = failure.motor(&motor);
            }
        }
        match error.hint {
            Some(hint) => failure.hint(hint),
            None => failure,
        }
    }
}
