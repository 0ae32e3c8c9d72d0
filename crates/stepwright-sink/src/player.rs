//! The contract of a player.

use stepwright::drive::Axes;
use stepwright::{Ticks, Timing};

use crate::group::StepGroup;

/// The groups and steps of one axis that a player had not played when it was halted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Halted {
    /// The number of groups of which no step was made.
    pub waiting: u8,
    /// The number of steps that were not made of the group before these; `u32::MAX` for all of them.
    pub left: u32,
}

/// Hardware that plays groups of equal steps, for several axes, each with a FIFO of its own.
///
/// ```text
///           put                put                       halt
///            │                  │                          │
///   STEP  ───┼─────┬┐──────┬┐───┼──┬┐───────┬┐───────┬┐────┼──────
///            └─ interval ──┘└ interval ─┘
///          start       group 1         │  group 2, waiting 1, then 0
/// ```
///
/// # Contract
///
/// **Time.** Step k of a group MUST rise k intervals after the last rising edge of the group before. In the
/// first group after a start it rises k intervals after the start, with an offset that is the same for all
/// axes. STEP stays high for [`Timing::pulse`]. Neither the program nor another axis moves an edge. A group
/// that is put before the last pulse of the last group has ended follows in time.
///
/// **DIR** is set between two groups: at most [`LAG`](Player::LAG) ticks after the end of a pulse, and
/// at once after a start. The engine keeps the set-up and hold times.
///
/// **Counts.** [`waiting`](Player::waiting) never counts a group of which a step was made. For a moment it
/// may count a group that has begun. The counts after a halt are exact to the step.
///
/// All methods are called by one caller, with the player's interrupt held off. For an axis that does not
/// exist they do nothing.
///
/// [`check`](crate::check) tries a player.
pub trait Player {
    /// The most groups of an axis that can wait after the group that is played: 1 to 7.
    const DEPTH: u8;

    /// The longest time from the end of a pulse to a change of DIR, in ticks.
    const LAG: Ticks;

    /// The time, in ticks. It MUST NOT go backward; it may stand still for a microsecond.
    fn now(&self) -> u64;

    /// Sets the drivers' times. Called while all axes rest.
    fn set_timing(&mut self, timing: &Timing);

    /// Whether another group of an axis can be put.
    fn has_room(&self, axis: u8) -> bool;

    /// Appends a group, whose interval is at least the minimum interval of [`Timing`]. Called only if there is
    /// room. An axis that was not started since its last halt keeps the group for its start. An axis that has
    /// run dry plays the group at once.
    fn put(&mut self, axis: u8, group: StepGroup);

    /// Starts these axes in the same tick. Each of them was halted, and has got a group since.
    fn start(&mut self, axes: Axes);

    /// The number of groups that were put and have not begun.
    fn waiting(&self, axis: u8) -> u8;

    /// Whether all groups have been played, to the end of the last pulse.
    fn rests(&self, axis: u8) -> bool;

    /// Whether an axis had nothing to play at some time since its start, or since the last call of this
    /// method. Called after [`put`](Player::put), so that the axis has a group now.
    fn ran_dry(&mut self, axis: u8) -> bool;

    /// Halts these axes at once. A pulse that has begun is completed.
    fn halt(&mut self, axes: Axes);

    /// Forgets the remaining groups of a halted axis, and returns their counts. The axis may then be started
    /// with other groups.
    fn forget(&mut self, axis: u8) -> Halted;
}
