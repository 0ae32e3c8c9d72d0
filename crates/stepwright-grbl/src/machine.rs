//! What is moved: pins out, switches in.

use stepwright_gcode::SpindleMode;

/// Switches and buttons, as they are now.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    /// The limit switch of each axis is closed.
    pub limit: [bool; 3],
    /// The probe has contact.
    pub probe: bool,
    /// The safety door is open.
    pub door: bool,
}

/// What is switched, besides the motors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outputs {
    /// How the spindle turns; of a laser, by which rule its power goes.
    pub spindle: SpindleMode,
    /// Revolutions a minute, or the laser's power in its unit, as it is now.
    pub power: f64,
    /// Flood coolant.
    pub flood: bool,
    /// Mist coolant.
    pub mist: bool,
}

/// A machine of three axes.
///
/// Times are in seconds, of the clock by which [`Grbl`](crate::Grbl) is called. They never go back.
pub trait GrblMachine {
    /// An axis, 0 to 2, makes a step at `time`.
    fn step(&mut self, time: f64, axis: usize, forward: bool);

    /// The switches, after the last step.
    fn inputs(&mut self) -> Inputs;

    /// What is switched from `time` on.
    fn switch(&mut self, time: f64, outputs: Outputs);
}

/// A virtual machine: it has switches at places, and counts its steps.
///
/// A place is in steps from where it was switched on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VirtualMill {
    /// Where each axis is.
    pub at: [i64; 3],
    /// Each axis closes its limit switch from here on downwards, and from there on upwards.
    pub limits: [[Option<i64>; 2]; 3],
    /// The probe has contact where Z is here or below.
    pub probe: Option<i64>,
    /// The door is open.
    pub door: bool,
    /// What is switched.
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
