//! What plays groups.

use stepwright::drive::Axes;
use stepwright::{Ticks, Timing};

use crate::group::StepGroup;

/// What a player that was halted had not played, of one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Halted {
    /// Groups of which no step was made.
    pub waiting: u8,
    /// Steps of the group before those that were not made; `u32::MAX` for all of them.
    pub left: u32,
}

/// Hardware that plays groups of equal steps, for some axes, each with a store of its own.
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
/// **Time.** Step k of a group MUST rise k intervals behind the last rising edge of the group before;
/// of the first group behind a start, k intervals behind the start, or as much later or sooner on
/// all axes. STEP stays high for [`Timing::pulse`]. Nothing that the program does, and no other
/// axis, moves an edge. What is put while the last group is played, before its last pulse has
/// ended, follows in time.
///
/// **DIR** is set between two groups: behind the end of a pulse, by at most [`LAG`](Player::LAG)
/// ticks, and at once behind a start. The engine sees to set-up and hold.
///
/// **Counts.** [`waiting`](Player::waiting) never counts a group of which a step was made; it may count
/// one for a moment that has begun. What a halt tells is exact: not a step more or less has been made.
///
/// All methods are called with the interrupt held off that the player asks to be served by, and by
/// nobody else. For an axis that there is not they do nothing.
///
/// [`check`](crate::check) tries a player.
pub trait Player {
    /// Groups of an axis that can wait, at most, behind the one that is played: 1 to 7.
    const DEPTH: u8;

    /// Ticks from the end of a pulse to a change of DIR, at most.
    const LAG: Ticks;

    /// The time, in ticks. It MUST NOT go backward; it may stand still for a microsecond.
    fn now(&self) -> u64;

    /// Has these drivers' times from now on. All axes rest.
    fn set_timing(&mut self, timing: &Timing);

    /// Whether another group of an axis can be put.
    fn has_room(&self, axis: u8) -> bool;

    /// Appends a group. Called if there is room. Its interval is at least the minimum interval of
    /// [`Timing`]. An axis that was not started since it was halted keeps it for its start; one that has
    /// run dry plays it at once.
    fn put(&mut self, axis: u8, group: StepGroup);

    /// Starts these axes, in the same tick. They were halted, and have been given a group each since.
    fn start(&mut self, axes: Axes);

    /// Groups that were put, and have not begun.
    fn waiting(&self, axis: u8) -> u8;

    /// Whether all that was put has been played, to the end of its last pulse.
    fn rests(&self, axis: u8) -> bool;

    /// Whether an axis had nothing to play at any time since its start, or since this was asked
    /// last. Asked behind [`put`](Player::put), so that it has something now.
    fn ran_dry(&mut self, axis: u8) -> bool;

    /// Halts these axes at once. A pulse that has begun is made to its end.
    fn halt(&mut self, axes: Axes);

    /// What was left of an axis that was halted, which is forgotten. It may be started again then,
    /// with other groups.
    fn forget(&mut self, axis: u8) -> Halted;
}
