//! Drives: how a step reaches the motor's pins.
//!
//! | driver | type | what it writes |
//! | --- | --- | --- |
//! | step and direction | [`StepDir`], [`PortDrive`] | a pulse |
//! | motor shield (L298) | [`Coils`], pins by [`Shield`] | two direction lines |
//! | unipolar (ULN2003 and its like) | [`Coils`], pins by [`Arduino::same_port`] | four phases |
//! | bridges with an input a line | [`Coils`] or [`CoilPins`] | four inputs, half steps |
//! | L6219 | [`CoilPins`] or [`Coils`] | two phases, four currents |
//!
//! The levels of the windings in each step are a table: [`sequence`].

mod arduino;
mod coil_pins;
mod coils;
mod port;
pub mod sequence;
mod shield;
mod step_dir;

pub use arduino::{Arduino, BoardPin, PinFault, PortPin};
pub use coil_pins::CoilPins;
pub use coils::Coils;
pub use port::{Port, PortDrive};
pub use sequence::{BadSequence, Sequence};
pub use shield::Shield;
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
/// Called from the step interrupt. The engine keeps the times: it calls `end` at least the pulse
/// width after `begin`, and `direction` at least the hold time after the last `begin` of that axis
/// and at least the set-up time before the next. An implementation MUST NOT block, and MUST NOT
/// change the pins of other axes.
pub trait Drive {
    /// Begins the pulses of these axes: one step each.
    fn begin(&mut self, axes: Axes);

    /// Ends the pulses of these axes. A drive of coils has nothing to do.
    fn end(&mut self, axes: Axes);

    /// Sets the direction in which `axis` (0 …) steps from now on.
    fn direction(&mut self, axis: u8, forward: bool);
}
