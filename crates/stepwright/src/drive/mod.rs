//! How a step reaches the motor: pins.

mod port;
mod step_dir;

pub use port::{Port, PortDrive};
pub use step_dir::{Pins, StepDir};

/// A set of axes: bit 0 is the first.
pub type Axes = u8;

/// Turns steps into pins.
///
/// ```text
///            setup        width      ≥ min interval
///   DIR   ──╳────────┐
///   STEP  ───────────┘▔▔▔▔▔▔▔▔▔▔▔└───────────────────┘▔▔▔
///                    begin     end                  begin
/// ```
///
/// Called from the step interrupt. The engine keeps the times: it calls `end`
/// at least the pulse width after `begin`, `direction` at least the hold time
/// after the last `begin` of that axis and at least the set-up time before the
/// next. An implementation MUST NOT block, and MUST leave the pins of other
/// axes alone.
pub trait Drive {
    /// The pulses of these axes begin: a step each.
    fn begin(&mut self, axes: Axes);

    /// The pulses of these axes end. A drive of coils has nothing to do.
    fn end(&mut self, axes: Axes);

    /// From now on `axis` (0 …) steps forward or backward.
    fn direction(&mut self, axis: u8, forward: bool);
}
