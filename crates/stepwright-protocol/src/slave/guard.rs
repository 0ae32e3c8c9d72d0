//! What a board with the feature `safety` asks before motion, and what it keeps of errors.

use stepwright::Travel;

use crate::errors::{BoardError, Errors};
use crate::machine::{Machine, Refusal};
use crate::setting::Setting;

/// The guard of one slave.
#[derive(Clone, Debug)]
pub(super) struct Guard {
    /// Since the last `!`. Late steps are the machine's to count.
    errors: Errors,
}

impl Guard {
    /// Nothing has gone wrong.
    pub(super) const NONE: Guard = Guard { errors: Errors::NONE };

    /// Keeps the error with this letter, if it is one.
    pub(super) fn note(&mut self, letter: u8) {
        self.errors.note(letter);
    }

    /// `!` has come.
    pub(super) fn clear(&mut self) {
        self.errors = Errors::NONE;
    }

    /// What has gone wrong.
    pub(super) fn errors(&self, late: bool) -> Errors {
        if late { self.errors.with(BoardError::Late) } else { self.errors }
    }

    /// Whether the axis of this bit may begin this travel.
    pub(super) fn admit<M: Machine>(
        &self,
        bit: u8,
        travel: Travel,
        machine: &mut M,
    ) -> Result<(), Refusal> {
        match travel {
            Travel::By(_) => self.admit_target(bit, machine),
            Travel::Endless(_) => self.admit_start(machine),
        }
    }

    /// Whether these axes may be sent to a place.
    pub(super) fn admit_target<M: Machine>(
        &self,
        axes: u8,
        machine: &mut M,
    ) -> Result<(), Refusal> {
        self.admit_start(machine)?;
        if axes & machine.uncertain() != 0 && is_set(machine, Setting::HomeFirst) {
            return Err(Refusal::Uncertain);
        }
        Ok(())
    }

    /// Whether an axis may be sent anywhere.
    fn admit_start<M: Machine>(&self, machine: &mut M) -> Result<(), Refusal> {
        if self.errors.any_stop() && is_set(machine, Setting::SafeStart) {
            return Err(Refusal::Stopped);
        }
        Ok(())
    }
}

/// Whether a setting of the board is 1.
fn is_set<M: Machine>(machine: &mut M, setting: Setting) -> bool {
    machine.settings().is_some_and(|settings| settings.byte(setting) != 0)
}
