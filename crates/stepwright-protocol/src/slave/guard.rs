//! The conditions that a board checks before motion, and its errors.

use stepwright::Travel;

use crate::axis::AxisId;
use crate::errors::{BoardError, Errors};
use crate::machine::{Machine, Refusal};
use crate::setting::Setting;
use crate::stop::{self, Stop};

/// The guard of one slave.
#[derive(Clone, Debug)]
pub(super) struct Guard<const AXES: usize> {
    /// The errors since the last `!`. The machine counts the late steps.
    errors: Errors,
    /// The start of the last travel of each axis with a soft limit: `@` counts from there.
    origins: [i32; AXES],
    /// The axes whose g ends at their soft limit; bit 0 is axis 1.
    bounded: u8,
    /// The axes whose g will do so once it starts.
    staged: u8,
}

impl<const AXES: usize> Guard<AXES> {
    /// No errors.
    pub(super) const NONE: Guard<AXES> =
        Guard { errors: Errors::NONE, origins: [0; AXES], bounded: 0, staged: 0 };

    /// Adds the error with this letter, if there is one.
    pub(super) fn note(&mut self, letter: u8) {
        self.errors.note(letter);
    }

    /// Notes that these axes get this letter of a stop, or `-`.
    pub(super) fn mark(&mut self, axes: u8, letter: u8) {
        self.errors.note(letter);
        if letter != stop::NONE {
            self.bounded &= !axes;
        }
    }

    /// The reported letter of the stop of an axis; `letter` is the stored one.
    pub(super) fn stop<M: Machine>(&self, letter: u8, index: u8, machine: &M) -> u8 {
        let ended = self.bounded & bit(index) != 0 && !machine.busy(AxisId::at(index));
        if ended && letter == stop::NONE { Stop::Limit.letter() } else { letter }
    }

    /// Clears the errors at a `!`, while these axes are busy.
    pub(super) fn clear(&mut self, busy: u8) {
        self.errors = Errors::NONE;
        self.bounded &= busy;
    }

    /// The errors, with late steps if `late`.
    pub(super) fn errors(&self, late: bool) -> Errors {
        if late { self.errors.with(BoardError::Late) } else { self.errors }
    }

    /// Whether this axis may begin this travel. An endless travel towards a soft limit becomes one
    /// that ends there.
    pub(super) fn admit<M: Machine>(
        &mut self,
        index: u8,
        travel: &mut Travel,
        machine: &mut M,
    ) -> Result<(), Refusal> {
        let axis = AxisId::at(index);
        if machine.busy(axis) {
            return Err(Refusal::Busy);
        }
        admit_start(self.errors, machine)?;
        let bit = bit(index);
        self.staged &= !bit;
        let limited = set(machine, Setting::SoftLimits) & bit != 0;
        let Some(here) = machine.position(axis) else {
            // g is allowed: homing uses it to find the position.
            let wanted = limited || is_set(machine, Setting::HomeFirst);
            let to_target = matches!(travel, Travel::By(_));
            return if wanted && to_target { Err(Refusal::Uncertain) } else { Ok(()) };
        };
        if !limited {
            return Ok(());
        }
        // Limits are within 10⁹ steps of 0: no travel from beyond 2³¹ is certain to end inside
        // them.
        let here = i32::try_from(here).map_err(|_| Refusal::Limit)?;
        if let Some(origin) = self.origins.get_mut(usize::from(index)) {
            *origin = here;
        }
        match *travel {
            Travel::By(0) => Ok(()),
            Travel::By(steps) => admit_target(index, here, steps, machine),
            Travel::Endless(forward) => {
                if has_switch(bit, forward, machine) {
                    return Ok(());
                }
                let here = if forward { here } else { here.wrapping_neg() };
                let limit = limit(index, forward, machine) as i32;
                let steps = limit.checked_sub(here).ok_or(Refusal::Travel)?;
                if steps <= 0 {
                    return Err(Refusal::Limit);
                }
                *travel = Travel::By(if forward { steps } else { steps.wrapping_neg() });
                self.staged |= bit;
                Ok(())
            }
        }
    }

    /// Notes that these axes have started.
    pub(super) fn started(&mut self, axes: u8) {
        self.bounded = self.bounded & !axes | self.staged & axes;
    }

    /// Whether these moving axes may get a target this many steps from where their travel began.
    pub(super) fn admit_target<M: Machine>(
        &self,
        axes: u8,
        steps: i32,
        machine: &mut M,
    ) -> Result<(), Refusal> {
        admit_start(self.errors, machine)?;
        let unknown = machine.uncertain();
        if axes & unknown != 0 && is_set(machine, Setting::HomeFirst) {
            return Err(Refusal::Uncertain);
        }
        let limited = axes & set(machine, Setting::SoftLimits);
        if limited & unknown != 0 {
            return Err(Refusal::Uncertain);
        }
        let mut left = limited;
        for (index, origin) in (0..).zip(&self.origins) {
            if left & 1 != 0 {
                admit_target(index, *origin, steps, machine)?;
            }
            left >>= 1;
        }
        Ok(())
    }

    /// Notes that these axes have a new target.
    pub(super) fn retargeted(&mut self, axes: u8) {
        self.bounded &= !axes;
    }

    /// Whether t, a or d may change the travels of these axes. A lower deceleration could carry an
    /// axis beyond its limit.
    pub(super) fn admit_change<M: Machine>(
        &self,
        axes: u8,
        letter: u8,
        machine: &mut M,
    ) -> Result<(), Refusal> {
        if letter == b'd' && axes & set(machine, Setting::SoftLimits) & !machine.uncertain() != 0 {
            return Err(Refusal::Limit);
        }
        Ok(())
    }
}

/// Whether an axis may start.
fn admit_start<M: Machine>(errors: Errors, machine: &mut M) -> Result<(), Refusal> {
    if errors.any_stop() && is_set(machine, Setting::SafeStart) {
        return Err(Refusal::Stopped);
    }
    Ok(())
}

/// Whether a travel of this axis, which has soft limits, may end `steps` from `from`.
#[cfg_attr(target_arch = "avr", inline(never))]
fn admit_target<M: Machine>(
    index: u8,
    from: i32,
    steps: i32,
    machine: &mut M,
) -> Result<(), Refusal> {
    // A target outside 32 bits is beyond any limit.
    let to = from.checked_add(steps).ok_or(Refusal::Limit)?;
    let limit = limit(index, to >= 0, machine);
    if to.unsigned_abs() > limit { Err(Refusal::Limit) } else { Ok(()) }
}

/// The soft limit of this axis in this direction, in steps from 0. The limit itself is allowed.
fn limit<M: Machine>(index: u8, forward: bool, machine: &mut M) -> u32 {
    let first = if forward { Setting::AheadX } else { Setting::BehindX };
    machine.settings().map_or(0, |settings| settings.number((first as u8).wrapping_add(index)))
}

/// Whether a limit switch ends the travels of this axis in this direction: then g is homing.
fn has_switch<M: Machine>(bit: u8, forward: bool, machine: &mut M) -> bool {
    let ahead = set(machine, Setting::SwitchForward) & bit != 0;
    set(machine, Setting::Switches) & bit != 0 && ahead == forward
}

/// The value of a setting that is a switch or a set of axes.
fn set<M: Machine>(machine: &mut M, setting: Setting) -> u8 {
    machine.settings().map_or(0, |settings| settings.byte(setting))
}

/// Whether a setting of the board is 1.
fn is_set<M: Machine>(machine: &mut M, setting: Setting) -> bool {
    set(machine, setting) != 0
}

/// The bit of an axis.
fn bit(index: u8) -> u8 {
    1u8.wrapping_shl(index.into())
}
