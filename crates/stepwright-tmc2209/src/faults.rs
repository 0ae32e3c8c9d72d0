//! Faults that the driver reports.

use core::fmt;

use tmc2209::reg;

/// A fault, present or remembered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum DriverFault {
    /// The driver has lost its settings: it was without power.
    Reset,
    /// The charge pump's voltage is too low: the driver is off.
    ChargePump,
    /// Overheated: the driver is off until it has cooled down.
    Overheated,
    /// Nearly overheated: 120 °C. The driver goes on.
    Hot,
    /// Coil A is shorted to ground: the driver is off.
    ShortToGroundA,
    /// Coil B is shorted to ground: the driver is off.
    ShortToGroundB,
    /// Coil A is shorted to the supply, or the low-side transistor is overloaded: the driver is
    /// off.
    ShortToSupplyA,
    /// Coil B is shorted to the supply, or the low-side transistor is overloaded: the driver is
    /// off.
    ShortToSupplyB,
    /// Coil A may not be connected. A hint: reliable at low speeds only.
    OpenLoadA,
    /// Coil B may not be connected. A hint, like `OpenLoadA`.
    OpenLoadB,
    /// The driver was off because of one of the errors above.
    SwitchedOff,
}

impl DriverFault {
    const ALL: [DriverFault; 11] = [
        DriverFault::Reset,
        DriverFault::ChargePump,
        DriverFault::Overheated,
        DriverFault::Hot,
        DriverFault::ShortToGroundA,
        DriverFault::ShortToGroundB,
        DriverFault::ShortToSupplyA,
        DriverFault::ShortToSupplyB,
        DriverFault::OpenLoadA,
        DriverFault::OpenLoadB,
        DriverFault::SwitchedOff,
    ];

    /// Whether the motor has lost its position through this fault: the driver is off, or was.
    pub const fn lets_go(self) -> bool {
        !matches!(self, DriverFault::Hot | DriverFault::OpenLoadA | DriverFault::OpenLoadB)
    }
}

impl fmt::Display for DriverFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            DriverFault::Reset => "it has lost its settings",
            DriverFault::ChargePump => "the charge pump's voltage is too low",
            DriverFault::Overheated => "overheated",
            DriverFault::Hot => "nearly overheated",
            DriverFault::ShortToGroundA => "coil A shorted to ground",
            DriverFault::ShortToGroundB => "coil B shorted to ground",
            DriverFault::ShortToSupplyA => "coil A shorted to the supply",
            DriverFault::ShortToSupplyB => "coil B shorted to the supply",
            DriverFault::OpenLoadA => "coil A perhaps not connected",
            DriverFault::OpenLoadB => "coil B perhaps not connected",
            DriverFault::SwitchedOff => "switched off by an error",
        })
    }
}

/// The faults of a driver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriverFaults(u16);

impl DriverFaults {
    pub(crate) fn of(state: reg::GSTAT, status: reg::DRV_STATUS) -> DriverFaults {
        let mut faults = DriverFaults::default();
        for (fault, is) in [
            (DriverFault::Reset, state.reset()),
            (DriverFault::SwitchedOff, state.drv_err()),
            (DriverFault::ChargePump, state.uv_cp()),
            (DriverFault::Hot, status.otpw()),
            (DriverFault::Overheated, status.ot()),
            (DriverFault::ShortToGroundA, status.s2ga()),
            (DriverFault::ShortToGroundB, status.s2gb()),
            (DriverFault::ShortToSupplyA, status.s2vsa()),
            (DriverFault::ShortToSupplyB, status.s2vsb()),
            (DriverFault::OpenLoadA, status.ola()),
            (DriverFault::OpenLoadB, status.olb()),
        ] {
            if is {
                faults.0 |= 1 << fault as u8;
            }
        }
        faults
    }

    /// Whether this fault is among them.
    pub const fn has(self, fault: DriverFault) -> bool {
        self.0 >> fault as u8 & 1 != 0
    }

    /// Whether there are no faults.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether the driver is off, or was.
    pub fn lets_go(self) -> bool {
        self.iter().any(DriverFault::lets_go)
    }

    /// The faults, one after another.
    pub fn iter(self) -> impl Iterator<Item = DriverFault> {
        DriverFault::ALL.into_iter().filter(move |fault| self.has(*fault))
    }
}

/// The faults separated by commas, or "none".
impl fmt::Display for DriverFaults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return f.write_str("none");
        }
        for (n, fault) in self.iter().enumerate() {
            write!(f, "{}{fault}", if n > 0 { ", " } else { "" })?;
        }
        Ok(())
    }
}
