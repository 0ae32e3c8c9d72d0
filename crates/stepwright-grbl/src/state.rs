//! The state of the machine, and the action after a brake.

/// The state of the machine, by grbl's names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    Idle,
    Run,
    Jog,
    /// Braking or at rest, until it is resumed.
    Hold,
    /// Like `Hold`, for the door.
    Door,
    Home,
    /// No motion until it is unlocked, or, if `critical`, reset.
    Alarm {
        critical: bool,
    },
    Check,
    Sleep,
}

/// The action after a brake has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum After {
    /// Drops everything, and sleeps.
    End,
    Reset,
    Alarm(u8),
    /// Drops the rest of a jog.
    Jog,
    /// Drops the rest of a jog; the door is open.
    Door,
    /// Stops the spindle for the door or for a sleep.
    Sleep,
}

impl After {
    /// Whether it drops all orders: the outputs are off while it brakes, too.
    pub(crate) fn ends(self) -> bool {
        matches!(self, After::End | After::Reset | After::Alarm(_))
    }

    /// The priority: the end precedes a reset, a reset precedes an alarm, and an alarm precedes all else.
    pub(crate) fn rank(self) -> u8 {
        match self {
            After::End => 4,
            After::Reset => 3,
            After::Alarm(_) => 2,
            After::Door | After::Sleep => 1,
            After::Jog => 0,
        }
    }
}
