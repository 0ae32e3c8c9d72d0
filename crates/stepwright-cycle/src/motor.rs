//! A motor of a cycle, and its state.

use core::fmt;

/// A motor: the distance of a step, its smallest delay, and its ends.
///
/// stepper_h's `init_stepper` and `init_stepper_ends`. The [`Drive`](stepwright::drive::Drive) and
/// the [`MachineIo`](super::MachineIo) have its pins.
///
/// ```
/// use stepwright_cycle::Motor;
/// // 7.5 µm a step, at most a step a millisecond, on a bed of 300 mm.
/// let x = Motor::new(7_500, 1_000).between(0, 300_000_000);
/// assert_eq!(x.max, Some(300_000_000));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Motor {
    /// Distance of a step in the user's unit, usually nanometres (`distance_per_step`).
    pub distance: u32,
    /// The shortest time from step to step in µs (`step_delay`), at least 1; also the meaning of a
    /// delay of 0.
    pub smallest_delay: u32,
    /// Whether a low DIR means forward (`invert_dir`).
    pub inverted: bool,
    /// The least position; `None`: no bound (`INF`).
    pub min: Option<i64>,
    /// The greatest position; `None`: no bound (`INF`).
    pub max: Option<i64>,
    /// The deceleration in steps/s² with which it brakes at a switch, if that is the
    /// [strategy](super::AtHardEnd); 0: it can't brake.
    pub decel: u32,
}

impl Motor {
    /// A motor without bounds.
    pub const fn new(distance: u32, smallest_delay: u32) -> Motor {
        Motor { distance, smallest_delay, inverted: false, min: None, max: None, decel: 0 }
    }

    /// This motor between two bounds.
    pub const fn between(self, min: i64, max: i64) -> Motor {
        Motor { min: Some(min), max: Some(max), ..self }
    }

    /// This motor with a braking deceleration in steps/s².
    pub const fn braking(self, decel: u32) -> Motor {
        Motor { decel, ..self }
    }

    /// This motor with inverted direction.
    pub const fn inverted(self) -> Motor {
        Motor { inverted: true, ..self }
    }
}

/// One of the two ends of a motor's travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The end with the least positions.
    Min,
    /// The end with the greatest positions.
    Max,
}

/// The effect of a program on positions and bounds (`calibrate_mode_t`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Calibration {
    /// Positions are counted, soft ends apply (`NONE`).
    #[default]
    None,
    /// No soft ends; every step leaves the position at the minimum, 0 if there
    /// is none (`CALIBRATE_START_MIN_POS`).
    StartMin,
    /// No soft ends; positions are counted, and every step sets the maximum
    /// (`CALIBRATE_BOUNDS_MAX_POS`).
    BoundsMax,
}

/// The state of a motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Status {
    /// It takes no part in a cycle, or its cycle has not started.
    #[default]
    Idle,
    /// Its program is being played.
    Running,
    /// Its program is over: complete, or ended by an error or with the cycle.
    Finished,
}

/// The faults of a motor: a set of flags, with stepper_h's numbers.
///
/// ```
/// use stepwright_cycle::Faults;
/// let faults = Faults::SOFT_END_MIN | Faults::STEP_DELAY_SMALL;
/// assert!(faults.has(Faults::SOFT_END_MIN));
/// assert_eq!((faults.bits(), faults.to_string()), (17, "soft-end-min, step-delay-small".into()));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults(u8);

impl Faults {
    /// No fault.
    pub const NONE: Faults = Faults(0);
    /// The next step would go below the minimum.
    pub const SOFT_END_MIN: Faults = Faults(1);
    /// The next step would go beyond the maximum.
    pub const SOFT_END_MAX: Faults = Faults(2);
    /// The switch at the minimum is closed, and the motor was moving towards it.
    pub const HARD_END_MIN: Faults = Faults(4);
    /// The switch at the maximum is closed, and the motor was moving towards it.
    pub const HARD_END_MAX: Faults = Faults(8);
    /// A delay below the motor's smallest.
    pub const STEP_DELAY_SMALL: Faults = Faults(16);

    const NAMES: [(Faults, &'static str); 5] = [
        (Faults::SOFT_END_MIN, "soft-end-min"),
        (Faults::SOFT_END_MAX, "soft-end-max"),
        (Faults::HARD_END_MIN, "hard-end-min"),
        (Faults::HARD_END_MAX, "hard-end-max"),
        (Faults::STEP_DELAY_SMALL, "step-delay-small"),
    ];

    pub(crate) const fn soft(forward: bool) -> Faults {
        if forward { Faults::SOFT_END_MAX } else { Faults::SOFT_END_MIN }
    }

    pub(crate) const fn hard(end: End) -> Faults {
        match end {
            End::Min => Faults::HARD_END_MIN,
            End::Max => Faults::HARD_END_MAX,
        }
    }

    /// A set of these flags; other bits are dropped.
    pub const fn from_bits(bits: u8) -> Faults {
        Faults(bits & 31)
    }

    /// The flags with stepper_h's numbers.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Whether one of `flags` is set.
    pub const fn has(self, flags: Faults) -> bool {
        self.0 & flags.0 != 0
    }

    /// Whether there is no fault.
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }
}

impl core::ops::BitOr for Faults {
    type Output = Faults;
    fn bitor(self, other: Faults) -> Faults {
        Faults(self.0 | other.0)
    }
}

impl core::ops::BitOrAssign for Faults {
    fn bitor_assign(&mut self, other: Faults) {
        self.0 |= other.0;
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_none() {
            return f.write_str("none");
        }
        let mut first = true;
        for (flag, name) in Faults::NAMES {
            if self.has(flag) {
                f.write_str(if core::mem::take(&mut first) { "" } else { ", " })?;
                f.write_str(name)?;
            }
        }
        Ok(())
    }
}
