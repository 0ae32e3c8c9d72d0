//! The inputs and outputs around the motors of a cycle: limit switches and enable pins.

use embedded_hal::digital::{InputPin, OutputPin};
use stepwright::drive::Axes;

/// The switches that are closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Switches {
    /// Those at the minimum.
    pub min: Axes,
    /// Those at the maximum.
    pub max: Axes,
}

impl Switches {
    /// No switch is closed.
    pub const NONE: Switches = Switches { min: 0, max: 0 };
}

/// Limit switches and enable pins, if there are any.
///
/// Both are called from the step interrupt and MUST NOT block.
pub trait MachineIo {
    /// The switches that are closed now. An axis without a switch counts as open.
    fn switches(&mut self) -> Switches {
        Switches::default()
    }

    /// Enables the drivers of these axes and disables all others.
    fn enable(&mut self, axes: Axes) {
        let _ = axes;
    }
}

/// No switches, and drivers that are always on.
impl MachineIo for () {}

/// The pins around one motor, each of which may be absent (`NO_PIN`).
#[derive(Debug)]
pub struct MotorIo<E, L> {
    /// Low enables the driver, as on most drivers.
    pub enable: Option<E>,
    /// Low means closed: a switch to ground with a pull-up.
    pub min: Option<L>,
    /// Low means closed.
    pub max: Option<L>,
}

/// The pins around N motors, over `embedded-hal`.
///
/// A pin that reports an error counts as open, because an interrupt cannot report it.
#[derive(Debug)]
pub struct Wires<E, L, const N: usize>(pub [MotorIo<E, L>; N]);

impl<E: OutputPin, L: InputPin, const N: usize> MachineIo for Wires<E, L, N> {
    fn switches(&mut self) -> Switches {
        let closed = |pin: &mut Option<L>| {
            pin.as_mut().is_some_and(|pin| pin.is_low().unwrap_or(false)).into()
        };
        let mut switches = Switches::default();
        for (axis, around) in self.0.iter_mut().enumerate().take(8) {
            let (min, max): (Axes, Axes) = (closed(&mut around.min), closed(&mut around.max));
            switches.min |= min << axis;
            switches.max |= max << axis;
        }
        switches
    }

    fn enable(&mut self, axes: Axes) {
        for (axis, around) in self.0.iter_mut().enumerate().take(8) {
            if let Some(pin) = &mut around.enable {
                let _ = pin.set_state((axes >> axis & 1 == 0).into());
            }
        }
    }
}
