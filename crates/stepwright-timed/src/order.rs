//! Orders to the timed driver, and its answers.

use crate::fit::{Fitted, Misfit};
use core::fmt;
use core::ops::BitOr;

/// The control byte: the Arduino driver's bits, together by `|`.
///
/// The logs print 0xF0 for `DRV_EN | SPEED_VARIABLE | VARIABLE_PWR | IRQ_TIMING` and 0xF2 with
/// `FASTER`. The article does not say which of the upper four bits is which, nor the values of the
/// three lower ones except `FASTER`; these are our choice.
///
/// ```
/// use stepwright_timed::Control;
/// let control = Control::DRV_EN | Control::SPEED_VARIABLE | Control::FASTER;
/// assert!(control.has(Control::FASTER) && !control.has(Control::IRQ_TIMING));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Control(u8);

impl Control {
    /// No bit set: the outputs are off.
    pub const OFF: Control = Control(0);
    /// Plays the motor's pattern backward.
    pub const DIRECTION: Control = Control(0x01);
    /// Each update subtracts the modification from the virtual top: faster.
    pub const FASTER: Control = Control(0x02);
    /// Each update adds the modification; the default, so no bit.
    pub const SLOWER: Control = Control(0);
    /// The limit is in milliseconds from the call, not in steps.
    pub const ENDPOINT_MILLIS: Control = Control(0x04);
    /// The step interrupt times the updates; without it the caller's
    /// [`update_check`](super::Driver::update_check) does.
    pub const IRQ_TIMING: Control = Control(0x10);
    /// The modification doubles (slower) or halves (faster) with each update.
    pub const VARIABLE_PWR: Control = Control(0x20);
    /// The speed changes; without it the modification's arguments are ignored.
    pub const SPEED_VARIABLE: Control = Control(0x40);
    /// The drivers are on; without it they are off and everything else is ignored.
    pub const DRV_EN: Control = Control(0x80);

    /// The byte.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// The control byte of these bits; all bits have a meaning except bit 3, which is dropped.
    pub const fn from_bits(bits: u8) -> Control {
        Control(bits & 0xF7)
    }

    /// Whether all bits of `other` are set.
    pub const fn has(self, other: Control) -> bool {
        self.0 & other.0 == other.0
    }

    /// The bits of both, for constants, where `|` can't be used.
    pub const fn and(self, other: Control) -> Control {
        Control(self.0 | other.0)
    }
}

impl BitOr for Control {
    type Output = Control;
    fn bitor(self, other: Control) -> Control {
        self.and(other)
    }
}

/// The arguments of `motorSetSpeed`, in its order.
///
/// ```
/// use stepwright_timed::{Control, SetSpeed};
/// // 250 steps/s at 16 MHz, and a stop after 20,000 steps.
/// let order = SetSpeed { limit: 20_000, ..SetSpeed::fixed(Control::DRV_EN, 64_000) };
/// assert_eq!(SetSpeed::STOP.top, 0);
/// # let _ = order;
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SetSpeed {
    /// The control byte, which says how the other fields are used.
    pub control: Control,
    /// The virtual top: clocks between two steps. 0 stops.
    pub top: u32,
    /// Steps, or milliseconds with [`Control::ENDPOINT_MILLIS`]; 0: endless.
    pub limit: u32,
    /// The change of the virtual top in an update.
    pub modification: u32,
    /// Milliseconds from one update to the next.
    pub update_ms: u16,
    /// The most updates.
    pub mod_counts: u16,
}

impl SetSpeed {
    /// No arguments: the motor stops and the outputs are off.
    pub const STOP: SetSpeed = SetSpeed::fixed(Control::OFF, 0);

    /// A fixed speed without an end.
    pub const fn fixed(control: Control, top: u32) -> SetSpeed {
        SetSpeed { control, top, limit: 0, modification: 0, update_ms: 0, mod_counts: 0 }
    }
}

/// The result of a [`SetSpeed`]: 0 is success, above 0 a warning, below 0 an error.
///
/// The article leaves the codes open; these are our choice. After an error only the status has
/// changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Code(i8);

impl Code {
    /// Success.
    pub const FINE: Code = Code(0);
    /// A variable speed without a modification, an interval or a count of updates: the speed does
    /// not change.
    pub const WARN_NO_UPDATES: Code = Code(1);
    /// The updates leave the valid range before all are made, unless the end comes first: there the
    /// driver faults and keeps the last valid speed.
    pub const WARN_RANGE: Code = Code(2);
    /// The virtual top is shorter than the step interrupt takes (640).
    pub const TOO_FAST: Code = Code(-1);
    /// The virtual top does not fit the timer (above 0x3FFFFFF): `TIMER_DIV_ERROR`.
    pub const TOO_SLOW: Code = Code(-2);
    /// `update_ms` is beyond 2³¹ clocks of this timer.
    pub const UPDATE_TOO_LONG: Code = Code(-3);
    /// No pins are set: an order over the line before the row `:W`.
    pub const NOT_WIRED: Code = Code(-4);

    /// A code in the answer of a board.
    pub const fn new(number: i8) -> Code {
        Code(number)
    }

    /// The number.
    pub const fn get(self) -> i8 {
        self.0
    }

    /// Whether the order was refused.
    pub const fn is_error(self) -> bool {
        self.0 < 0
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match *self {
            Code::FINE => "fine",
            Code::WARN_NO_UPDATES => {
                "the speed stays as it is: give a modification, an interval and a count of updates"
            }
            Code::WARN_RANGE => {
                "the updates lead out of the valid range; from there on the speed stays as it is, \
                 unless the end comes first: give fewer updates or a smaller modification"
            }
            Code::TOO_FAST => "too fast: the virtual top must be 640 at least; lower the speed",
            Code::TOO_SLOW => {
                "too slow for this timer: the virtual top may be 67108863 at most; raise the speed"
            }
            Code::NOT_WIRED => "no pin is driven; say which by the line W first",
            _ => "the interval between updates is too long for this clock; give a shorter one",
        })
    }
}

/// The status byte: the Arduino driver's bits. Their values are our choice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status(u8);

impl Status {
    /// Moving at a variable speed, or at rest.
    pub const NONE: Status = Status(0);
    /// A top out of range: refused, or an update that was not made.
    pub const FAULT: Status = Status(0x01);
    /// The fault callback was called: once per set-speed call.
    pub const FAULT_CALLED: Status = Status(0x02);
    /// The virtual top does not fit the timer.
    pub const TIMER_DIV_ERROR: Status = Status(0x04);
    /// The callback for that was called.
    pub const TIMER_DIV_CALLED: Status = Status(0x08);
    /// The end was reached; the motor has stopped.
    pub const REACHED: Status = Status(0x10);
    /// The callback for that was called.
    pub const REACH_CALLED: Status = Status(0x20);
    /// The motor turns at a fixed speed.
    pub const SPIN_FIXED: Status = Status(0x40);

    /// The byte.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// The status of these bits; bits without a name are dropped.
    pub const fn from_bits(bits: u8) -> Status {
        Status(bits & 0x7F)
    }

    /// Whether all bits of `other` are set.
    pub const fn has(self, other: Status) -> bool {
        self.0 & other.0 == other.0
    }

    /// The status with the bits of `other` added.
    pub const fn and(self, other: Status) -> Status {
        Status(self.0 | other.0)
    }

    /// The status with the bits of `other` removed.
    pub const fn without(self, other: Status) -> Status {
        Status(self.0 & !other.0)
    }

    /// Records the result of an update after which `counts` are left, and returns whether there
    /// will be another.
    pub(crate) fn note(&mut self, updated: &Result<Fitted, Misfit>, counts: u16) -> bool {
        match updated {
            Ok(_) if counts > 0 => return true,
            Ok(_) => {}
            Err(misfit) => *self = self.and(Status::of(*misfit)),
        }
        *self = self.and(Status::SPIN_FIXED);
        false
    }

    pub(crate) const fn of(misfit: Misfit) -> Status {
        match misfit {
            Misfit::TooFast { .. } => Status::FAULT,
            Misfit::TooSlow { .. } => Status::FAULT.and(Status::TIMER_DIV_ERROR),
        }
    }
}

/// The reason for a callback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// The motor has reached its end: `motorCallBackPositionReached`.
    Reached,
    /// A fault: `motorCallBackFault`.
    Fault,
}
