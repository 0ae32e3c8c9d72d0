//! The outputs for the spindle or the laser: what they are now, and, on a fed board, at a step ahead.

use stepwright_gcode::SpindleMode;
use stepwright_path::decimal;

use crate::machine::{GrblMachine, Outputs};
use crate::session::Grbl;
use crate::state::{After, State};

impl<M: GrblMachine> Grbl<M> {
    /// Sets the outputs for the spindle or the laser.
    pub(crate) fn switch(&mut self) {
        let (mode, s) = match self.settings.is_on(32) {
            true => self.laser(),
            false => (self.spindle.mode, decimal(self.spindle.speed)),
        };
        let mut next = Outputs { spindle: mode, power: self.power(s), ..self.outputs };
        if self.spindle_rests() || mode == SpindleMode::Off {
            (next.spindle, next.power) = (SpindleMode::Off, 0.0);
        }
        if self.door_stops() && self.cooled.is_none() {
            self.cooled = Some((next.flood, next.mist));
            (next.flood, next.mist) = (false, false);
        } else if self.state != State::Door
            && let Some(on) = self.cooled.take()
        {
            (next.flood, next.mist) = on;
        }
        if next != self.outputs {
            self.outputs = next;
            self.machine.switch(self.now, next);
        }
    }

    /// Whether an end of all orders, a door, a sleep or an override stops the spindle.
    fn spindle_rests(&self) -> bool {
        let stops = self.state == State::Sleep || self.door_stops();
        stops || self.spindle_rests || self.after.is_some_and(After::ends)
    }

    /// Whether a door stops the spindle and the coolant: a laser at once, all else when the axes rest.
    fn door_stops(&self) -> bool {
        let rests = || self.motion.is_over() || self.motion.is_held(self.now);
        self.state == State::Door && (self.settings.is_on(32) || rests())
    }

    /// S after its override, within `$31` and `$30`.
    fn power(&self, s: f64) -> f64 {
        let (least, most) = (self.settings.get(31), self.settings.get(30));
        let scaled = s * f64::from(self.overrides.spindle) / 100.0;
        if scaled > 0.0 { scaled.clamp(least, most.max(least)) } else { 0.0 }
    }

    /// The power of a fed board's laser at the last planned step, at this time of the path: 255 at `$30`.
    pub(crate) fn planned_power(&self, time: f64) -> u8 {
        let burns = self.settings.is_on(32) && !self.spindle_rests();
        let laser = if burns { self.motion.planned_laser(time) } else { None };
        let s = laser.map_or(0.0, |(laser, speed)| self.power(laser.s(speed)));
        // `as` clamps, and makes 0 of 0/0.
        (255.0 * s / self.settings.get(30)).round() as u8
    }

    /// The laser's present rule and S: off in rapids and at rest.
    fn laser(&self) -> (SpindleMode, f64) {
        let Some(laser) = self.motion.laser() else { return (SpindleMode::Off, 0.0) };
        let speed = self.motion.speed(self.now);
        (laser.mode(), if speed > 0.0 { laser.s(speed) } else { 0.0 })
    }
}
