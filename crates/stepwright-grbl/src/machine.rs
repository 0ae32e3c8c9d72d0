//! The interface to a machine: steps and outputs, and its switches.

use stepwright_gcode::SpindleMode;

/// The present state of switches and buttons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    /// Whether the limit switch of each axis is closed.
    pub limit: [bool; 3],
    /// Whether the probe has contact.
    pub probe: bool,
    /// Whether the safety door is open.
    pub door: bool,
}

/// The outputs besides the motors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outputs {
    /// The mode of the spindle; for a laser, the rule for its power.
    pub spindle: SpindleMode,
    /// The present speed in revolutions per minute, or the laser's power in its unit.
    pub power: f64,
    /// Flood coolant.
    pub flood: bool,
    /// Mist coolant.
    pub mist: bool,
}

/// A machine of three axes.
///
/// Times are in seconds of the clock with which [`Grbl`](crate::Grbl) is called. They never go
/// back.
pub trait GrblMachine {
    /// Makes a step of an axis, 0 to 2, at `time`.
    fn step(&mut self, time: f64, axis: usize, forward: bool);

    /// The state of the switches after the last step.
    fn inputs(&mut self) -> Inputs;

    /// Sets the outputs from `time` on.
    fn switch(&mut self, time: f64, outputs: Outputs);
}

/// A virtual machine with switches, which counts its steps.
///
/// Positions are in steps from the position at power-up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VirtualMill {
    /// The position of each axis.
    pub at: [i64; 3],
    /// Each axis closes its limit switch at the first position and below, and at the second one and
    /// above.
    pub limits: [[Option<i64>; 2]; 3],
    /// The probe has contact at this position of Z and below.
    pub probe: Option<i64>,
    /// Whether the door is open.
    pub door: bool,
    /// The present outputs.
    pub outputs: Outputs,
}

impl GrblMachine for VirtualMill {
    fn step(&mut self, _: f64, axis: usize, forward: bool) {
        if let Some(at) = self.at.get_mut(axis) {
            *at += if forward { 1 } else { -1 };
        }
    }

    fn inputs(&mut self) -> Inputs {
        let limit = [0, 1, 2].map(|axis| {
            let ([low, high], at) = (self.limits[axis], self.at[axis]);
            low.is_some_and(|low| at <= low) || high.is_some_and(|high| at >= high)
        });
        let probe = self.probe.is_some_and(|probe| self.at[2] <= probe);
        Inputs { limit, probe, door: self.door }
    }

    fn switch(&mut self, _: f64, outputs: Outputs) {
        self.outputs = outputs;
    }
}
