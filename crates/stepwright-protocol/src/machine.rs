//! What a controller offers the slave.

use core::fmt;
use core::task::Poll;

use crate::flash::{Text, text};
use stepwright::{Change, Order};

use crate::{AxisId, Settings};

/// The controller behind the line: axes that travel, stop and know where
/// they are.
///
/// The slave checks the grammar, the ranges, that an axis exists and is idle,
/// and that an order keeps to the settings' limits. The machine decides whether
/// it can carry an order out. All calls come from the foreground, from inside
/// [`Slave::receive`](crate::Slave::receive), [`Slave::work`](crate::Slave::work) and
/// [`Slave::next_byte`](crate::Slave::next_byte), and none may wait for a motion: an order is
/// begun, not done, when `commit` is ready.
///
/// An implementation MUST keep these promises:
/// - Nothing moves but by `commit`.
/// - `axes` never changes, and every axis below it is accepted everywhere.
///   The slave never names another one.
/// - After `commit` was ready with `Ok`, `busy` is true for each axis of the order
///   until its last step has been emitted, whether the travel ran to its end,
///   was stopped, or was killed. A travel of 0 steps never is.
/// - A position is the steps emitted since it was last set to 0. It is `None`
///   from the moment it may be wrong until `zero`.
pub trait Machine {
    /// How many axes there are: 1 … 8. More than the slave has room for are
    /// left out.
    fn axes(&self) -> u8;

    /// Does the axis move, or has it yet to?
    fn busy(&self, axis: AxisId) -> bool;

    /// Takes a travel of one axis; the slave names each axis at most once,
    /// in the order of their numbers, and then calls `commit`, or `cancel` after
    /// any error.
    ///
    /// # Errors
    /// The reason why it can't be, [`Refusal::Busy`] for an axis that is.
    fn prepare(&mut self, axis: AxisId, order: &Order) -> Result<(), Refusal>;

    /// Does a piece of starting all that was prepared, together, or none of it: called
    /// until it is ready. Between the pieces `stop`, `kill` and `cancel` may be called, and
    /// what is ordered is not yet busy. A machine that does it in one piece is ready at once.
    ///
    /// # Errors
    /// The reason why not. Then no axis has moved, nor will it, and after
    /// `cancel`, which follows, everything is as it was before the first
    /// `prepare`.
    fn commit(&mut self) -> Poll<Result<(), Refusal>>;

    /// Forgets what was prepared. Nothing may have been.
    fn cancel(&mut self);

    /// Ramps the axis down from wherever it is on its way; its position stays
    /// known. An axis that is already ramping down goes on doing so.
    fn stop(&mut self, axis: AxisId);

    /// Changes the travels that these axes are on, all or none; bit 0 is axis 1.
    /// The slave names only axes that are busy.
    ///
    /// # Errors
    /// The reason why not, and all of them go on as they were. A machine that
    /// can't change a travel answers [`Refusal::Busy`].
    fn change(&mut self, axes: u8, change: Change) -> Result<(), Refusal> {
        let _ = (axes, change);
        Err(Refusal::Busy)
    }

    /// Stops every axis at once. Those that were busy are idle when this
    /// returns, and their position is unknown; the others keep theirs.
    fn kill(&mut self);

    /// Steps from 0, + clockwise, also on the way; `None` if uncertain.
    fn position(&self, axis: AxisId) -> Option<i64>;

    /// Axes whose position is not known: bit 0 is axis 1. Bits of axes that
    /// there are not may be set.
    fn uncertain(&self) -> u8 {
        let unknown = AxisId::first(self.axes()).filter(|axis| self.position(*axis).is_none());
        unknown.fold(0, |mask, axis| mask | 1u8.wrapping_shl(axis.index() as u32))
    }

    /// Axes whose limit switch is closed now, of those that the settings name: bit 0 is
    /// axis 1.
    fn closed(&self) -> u8 {
        0
    }

    /// Where the axis is now is 0, and certain. Only for an idle axis.
    fn zero(&mut self, axis: AxisId);

    /// The fastest the board can step one axis, in steps/s, rounded down.
    fn max_rate(&self) -> u32;

    /// Steps that came late since the last `clear_late`, all axes together;
    /// it stays at its largest value rather than begin again.
    fn late(&self) -> u32;

    /// Sets `late` to 0.
    fn clear_late(&mut self);

    /// Moving axes are to stop, as by [`stop`](Machine::stop), once no line has come for
    /// this many ms; 0: no longer. It ends with the first such silence.
    ///
    /// # Errors
    /// [`Refusal::Line`] from a machine that grants none.
    fn lease(&mut self, millis: u16) -> Result<(), Refusal> {
        let _ = millis;
        Err(Refusal::Line)
    }

    /// The settings, to be read and to be changed; `None` for a machine that
    /// has none, which refuses every `$`.
    fn settings(&mut self) -> Option<&mut Settings> {
        None
    }

    /// The settings were changed: it follows them from now on, and keeps them
    /// when the power goes off. Called only while every axis is idle.
    fn set_up(&mut self) {}
}

/// Why a line was answered E. `last=` in the answer to `?` is its name.
///
/// The E of an order that had been spoiled gives the reason of the line that
/// spoiled it, for that one is to be mended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Refusal {
    /// `line`: not a line of this protocol, too long, or garbled.
    Line,
    /// `sum`: the checksum of the line is that of another line.
    Sum,
    /// `range`: a number outside its range.
    Range,
    /// `axis`: the board has no such axis.
    Axis,
    /// `no-axis`: PO selects axis 1, and an A before it had named another.
    NoAxis,
    /// `busy`: the axis has yet to end its travel.
    Busy,
    /// `no-po`: G or E without a PO before it.
    Closed,
    /// `no-travel`: E without a G or g before it; @ for an axis at rest.
    NoTravel,
    /// `killed`: E of an order into which a K came.
    Killed,
    /// `uncertain`: the position is not known.
    Uncertain,
    /// `too-fast`: the steps would follow closer than the board can make them.
    TooFast,
    /// `too-steep`: the ramps of all that moves ask for more than the board can plan in time.
    TooSteep,
    /// `too-slow`: a delay would be longer than the board can wait; t on the way
    /// is below the start speed.
    TooSlow,
    /// `too-gentle`: the ramps would take more than 2^31 steps, or there are none: t on the
    /// way of a travel that was ordered at its start speed.
    TooGentle,
    /// `ramp`: the ramp is steeper or longer than the board can compute.
    Ramp,
    /// `travel`: the board can't count that far.
    Travel,
    /// `no-jerk`: the board has no S-curves, or `law` is 0.
    NoJerk,
    /// `setting`: no setting of the board has this name.
    Setting,
    /// `fault`: the axis is out of order: a limit switch, a driver's fault, the emergency stop.
    Fault,
    /// `other`: a reason that this version has no word for.
    Other,
    /// `stopped`: an axis was stopped, and `safe-start` asks for `!` before an order.
    Stopped,
    /// `limit`: beyond a soft limit.
    Limit,
}

/// The names, as ordinary text and as one that takes no RAM.
macro_rules! names {
    ($($refusal:ident $name:literal)*) => {
        impl Refusal {
            /// Every reason.
            pub const ALL: [Refusal; [$($name),*].len()] = [$(Refusal::$refusal),*];

            /// Its name on the line.
            pub const fn name(self) -> &'static str {
                match self { $(Refusal::$refusal => $name),* }
            }

            fn text(self) -> Text {
                text!(concat!($($name, "\0"),*)).word(self as u8)
            }
        }

        /// `none` and the names, line by line.
        pub(crate) const REASONS: &str = concat!("none\n", $($name, "\n"),*);
    };
}

names! {
    Line "line"
    Sum "sum"
    Range "range"
    Axis "axis"
    NoAxis "no-axis"
    Busy "busy"
    Closed "no-po"
    NoTravel "no-travel"
    Killed "killed"
    Uncertain "uncertain"
    TooFast "too-fast"
    TooSteep "too-steep"
    TooSlow "too-slow"
    TooGentle "too-gentle"
    Ramp "ramp"
    Travel "travel"
    NoJerk "no-jerk"
    Setting "setting"
    Fault "fault"
    Other "other"
    Stopped "stopped"
    Limit "limit"
}

impl Refusal {
    /// The reason with this name; one that is not known is [`Refusal::Other`].
    pub fn named(name: &[u8]) -> Refusal {
        let known = Refusal::ALL.into_iter().find(|known| known.text().is(name));
        known.unwrap_or(Refusal::Other)
    }
}

impl Refusal {
    /// What happened, and what to do about it.
    ///
    /// Apart from the names, so that a chip which never prints them does not
    /// carry them: constants take RAM on an AVR.
    pub const fn words(self) -> &'static str {
        match self {
            Refusal::Line => "not a line of this protocol",
            Refusal::Sum => "the checksum is that of another line: say it again",
            Refusal::Range => "a number outside its range",
            Refusal::Axis => "the board has no such axis",
            Refusal::NoAxis => "PO did not say which axis: name it with A after PO",
            Refusal::Busy => "the axis is still travelling: wait, or stop it with Z",
            Refusal::Closed => "no order is open: begin it with PO",
            Refusal::NoTravel => "there is no travel: send G or g before E, and @ on the way",
            Refusal::Killed => "K abandoned the order: begin again with PO",
            Refusal::Uncertain => "the position is not known: go to a known place and send I",
            Refusal::TooFast => "faster than the board can step: lower the top speed",
            Refusal::TooSteep => {
                "ramps steeper than the board can plan for all moving axes: lower a and d, \
                 or j where it is not 0, or move fewer axes at once"
            }
            Refusal::TooSlow => {
                "slower than the board can wait, or on the way than the start speed: \
                 raise the speeds"
            }
            Refusal::TooGentle => {
                "the ramps are too gentle for that speed, or the travel has none: \
                 raise a and d first, or lower the top speed"
            }
            Refusal::Ramp => "the board can't compute such a ramp: change its length or slope",
            Refusal::Travel => "the board can't count that far: shorten the travel",
            Refusal::NoJerk => {
                "the board has no S-curves, or its setting law is 0: leave the jerk out"
            }
            Refusal::Setting => "the board has no such setting: `$` lists them",
            Refusal::Stopped => {
                "an axis was stopped: look why, then send ! (`stepwright send '!'`)"
            }
            Refusal::Fault => {
                "the axis is out of order: look at its switch, its driver and the emergency stop"
            }
            Refusal::Limit => "beyond a soft limit, or d on the way before one: go less far",
            Refusal::Other => "a reason that this version has no word for",
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.words())
    }
}

impl core::error::Error for Refusal {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_its_own_and_one_word() {
        for refusal in Refusal::ALL {
            assert_eq!(Refusal::named(refusal.name().as_bytes()), refusal);
            assert!(refusal.name().bytes().all(|b| b.is_ascii_lowercase() || b == b'-'));
            assert_ne!(refusal.name(), "none");
        }
        assert_eq!(Refusal::named(b"none"), Refusal::Other);
        assert_eq!(Refusal::named(b""), Refusal::Other);
    }
}
