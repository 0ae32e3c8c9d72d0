//! What the machine is doing, and what comes next.

/// What the machine is doing, by grbl's names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    Idle,
    Run,
    Jog,
    /// Braking, or standing, until it is resumed.
    Hold,
    /// Likewise, for the door.
    Door,
    Home,
    /// Nothing moves before it is unlocked, or, if `critical`, reset.
    Alarm {
        critical: bool,
    },
    Check,
    Sleep,
}

/// What comes once a brake has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum After {
    Reset,
    Alarm(u8),
    /// The rest of a jog is dropped.
    Jog,
    /// Likewise, and the door is open.
    Door,
    /// The door's or a sleep's spindle stops.
    Sleep,
}

impl After {
    /// A reset is more than an alarm, and an alarm more than what else ends a move.
    pub(crate) fn rank(self) -> u8 {
        match self {
            After::Reset => 3,
            After::Alarm(_) => 2,
            After::Door | After::Sleep => 1,
            After::Jog => 0,
        }
    }
}
