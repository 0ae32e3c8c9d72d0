//! The interface between the slave and a controller.

use core::fmt;
use core::task::Poll;

use crate::flash::{Text, text};
use stepwright::{Change, Order};

use crate::{AxisId, Settings};

/// The controller behind the line: axes that travel, stop and know their positions.
///
/// The slave checks the grammar, the ranges, that an axis exists and is idle, and that an order
/// keeps to the limits of the settings. The machine decides whether it can carry out an order. All
/// calls come from the foreground, from inside [`Slave::receive`](crate::Slave::receive),
/// [`Slave::work`](crate::Slave::work) and [`Slave::next_byte`](crate::Slave::next_byte), and none
/// may wait for a motion: when `commit` is ready, an order has begun, not ended.
///
/// An implementation MUST keep these promises:
/// - Only `commit` starts a motion.
/// - `axes` never changes, and every axis below it is accepted everywhere. The slave never names
///   another axis.
/// - After `commit` was ready with `Ok`, `busy` is true for each axis of the order until its last
///   step has been emitted, whether the travel ran to its end, was stopped, or was killed. For a
///   travel of 0 steps it never is.
/// - A position is the number of steps emitted since it was last set to 0. It is `None` from the
///   moment it may be wrong until `zero`.
pub trait Machine {
    /// The number of axes: 1 … 8. The slave ignores axes beyond its own `AXES`.
    fn axes(&self) -> u8;

    /// Whether the axis moves, or will move.
    fn busy(&self, axis: AxisId) -> bool;

    /// Accepts a travel of one axis. The slave names each axis at most once, in the order of their
    /// numbers, and then calls `commit`, or `cancel` after any error.
    ///
    /// # Errors
    /// The reason why the travel is impossible; [`Refusal::Busy`] for a busy axis.
    fn prepare(&mut self, axis: AxisId, order: &Order) -> Result<(), Refusal>;

    /// Does a piece of starting all prepared travels together. The slave calls it until it is
    /// ready: then all have started, or none. Between the pieces `stop`, `kill` and `cancel` may be
    /// called, and the ordered axes are not yet busy. A machine that needs only one piece is ready
    /// at once.
    ///
    /// # Errors
    /// The reason. Then no axis has moved or will move, and after `cancel`, which follows, the
    /// state is as it was before the first `prepare`.
    fn commit(&mut self) -> Poll<Result<(), Refusal>>;

    /// Discards the prepared travels, of which there may be none.
    fn cancel(&mut self);

    /// Ramps the axis down from its present speed; its position stays known. An axis that is
    /// already ramping down continues.
    fn stop(&mut self, axis: AxisId);

    /// Changes the travels in progress of these axes, all or none; bit 0 is axis 1. The slave names
    /// only axes that are busy.
    ///
    /// # Errors
    /// The reason; then all of the travels continue unchanged. A machine that can't change a travel
    /// returns [`Refusal::Busy`].
    fn change(&mut self, axes: u8, change: Change) -> Result<(), Refusal> {
        let _ = (axes, change);
        Err(Refusal::Busy)
    }

    /// Stops every axis at once. Axes that were busy are idle when this returns, and their position
    /// is unknown; the other axes keep theirs.
    fn kill(&mut self);

    /// The position in steps from 0, + clockwise, also during motion; `None` if uncertain.
    fn position(&self, axis: AxisId) -> Option<i64>;

    /// The axes whose position is not known: bit 0 is axis 1. Bits of axes that don't exist may be
    /// set.
    fn uncertain(&self) -> u8 {
        let unknown = AxisId::first(self.axes()).filter(|axis| self.position(*axis).is_none());
        unknown.fold(0, |mask, axis| mask | 1u8.wrapping_shl(axis.index() as u32))
    }

    /// The axes in the setting `switches` whose limit switch is closed now: bit 0 is axis 1.
    fn closed(&self) -> u8 {
        0
    }

    /// Sets the present position of the axis to 0, and certain. Only for an idle axis.
    fn zero(&mut self, axis: AxisId);

    /// The fastest rate at which the board can step one axis, in steps/s, rounded down.
    fn max_rate(&self) -> u32;

    /// The late steps of all axes together since the last `clear_late`. The count saturates.
    fn late(&self) -> u32;

    /// Sets `late` to 0.
    fn clear_late(&mut self);

    /// Requests that moving axes stop, as by [`stop`](Machine::stop), once no line has come for
    /// this many ms; 0 withdraws the request. It ends with the first such silence.
    ///
    /// # Errors
    /// [`Refusal::Line`] from a machine that grants no lease.
    fn lease(&mut self, millis: u16) -> Result<(), Refusal> {
        let _ = millis;
        Err(Refusal::Line)
    }

    /// The settings, to read and to change; `None` for a machine without settings, whose slave
    /// refuses every `$`.
    fn settings(&mut self) -> Option<&mut Settings> {
        None
    }

    /// The settings were changed: the machine follows them from now on, and stores them so that
    /// they outlast a loss of power. Called only while every axis is idle.
    fn set_up(&mut self) {}
}

/// Why a line was answered E. `last=` in the answer to `?` is its name.
///
/// The E of a spoiled order has the reason of the line that spoiled it, because that line is the
/// one to correct.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Refusal {
    /// `line`: not a line of this protocol, too long, or garbled.
    Line,
    /// `sum`: the checksum does not match the line.
    Sum,
    /// `range`: a number outside its range.
    Range,
    /// `axis`: the board has no such axis.
    Axis,
    /// `no-axis`: PO selects axis 1, but an A before it had named another axis.
    NoAxis,
    /// `busy`: the axis has not ended its travel.
    Busy,
    /// `no-po`: G or E without a PO before it.
    Closed,
    /// `no-travel`: E without a G or g before it; @ for an axis at rest.
    NoTravel,
    /// `killed`: E of an order during which a K came.
    Killed,
    /// `uncertain`: the position is not known.
    Uncertain,
    /// `too-fast`: the steps would follow closer than the board can make them.
    TooFast,
    /// `too-steep`: the board can't plan the ramps of all moving axes in time.
    TooSteep,
    /// `too-slow`: a delay would be longer than the board can wait; t on the way
    /// is below the start speed.
    TooSlow,
    /// `too-gentle`: the ramps would take more than 2^31 steps, or there are none: t during a
    /// travel that was ordered at its start speed.
    TooGentle,
    /// `ramp`: the ramp is steeper or longer than the board can compute.
    Ramp,
    /// `travel`: the board can't count that far.
    Travel,
    /// `no-jerk`: the board has no S-curves, or `law` is 0.
    NoJerk,
    /// `setting`: no setting of the board has this name.
    Setting,
    /// `fault`: the axis is out of order because of a limit switch, a driver's fault or the
    /// emergency stop.
    Fault,
    /// `other`: a reason that this version does not know.
    Other,
    /// `stopped`: an axis was stopped, and `safe-start` asks for `!` before an order.
    Stopped,
    /// `limit`: the target is beyond a soft limit.
    Limit,
}

/// Makes the names, as an ordinary text and as a text that takes no RAM.
macro_rules! names {
    ($($refusal:ident $name:literal)*) => {
        impl Refusal {
            /// Every reason.
            pub const ALL: [Refusal; [$($name),*].len()] = [$(Refusal::$refusal),*];

            /// The name on the line.
            pub const fn name(self) -> &'static str {
                match self { $(Refusal::$refusal => $name),* }
            }

            fn text(self) -> Text {
                text!(concat!($($name, "\0"),*)).word(self as u8)
            }
        }

        /// `none` and the names, one per line.
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
    /// The reason with this name; [`Refusal::Other`] for an unknown name.
    pub fn named(name: &[u8]) -> Refusal {
        let known = Refusal::ALL.into_iter().find(|known| known.text().is(name));
        known.unwrap_or(Refusal::Other)
    }
}

impl Refusal {
    /// A description of the reason and of the remedy.
    ///
    /// The descriptions are apart from the names so that a chip which never prints them does not
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
