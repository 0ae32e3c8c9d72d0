//! A motor that runs against a hard stop.

use crate::edge::{Edge, Pin, Recorder};

/// A stepper motor whose travel ends at a hard stop: the field turns on, and the rotor can't follow.
///
/// ```text
///   field   ─────╲
///   rotor   ──────╲____╱╲____╱╲___   pressed against the stop, half an electrical period
///   stop    ············              behind the field at most; then it slips back by a period
/// ```
///
/// The rotor is where the field holds it, or at the stop. It has neither mass nor friction: a real rotor slips
/// no later, and bounces further.
///
/// It takes steps, or the edges of an axis as a [`Recorder`]:
///
/// ```
/// use stepwright::Axis;
/// use stepwright_sim::{Description, HardStop, Queues, virtual_steppers};
/// let mut queues = Queues::default();
/// // 100 steps in front of a stop; 16 microsteps, so 64 steps a period.
/// let stop = HardStop::below(0, 100, 64).of_axis(0);
/// let mut motors = virtual_steppers(&mut queues, Description::uno(), stop);
/// motors.move_by(Axis::X, -1_000)?;
/// while motors.is_moving(Axis::X) {
///     motors.poll();
///     motors.engine().pass(16_000);
/// }
/// let stop = motors.engine().recorder();
/// // Ordered to 900 steps behind the stop. It stands at most half a period in front.
/// assert!((0..=32).contains(&stop.rotor()) && stop.slips() == 14);
/// # Ok::<(), stepwright::MoveError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct HardStop {
    /// The position of the stop, and whether it is above the rotor.
    stop: i64,
    above: bool,
    /// Where the field would hold the rotor without the stop.
    held: i64,
    period: i64,
    slips: u32,
    axis: u8,
    /// The level of DIR.
    forward: bool,
}

impl HardStop {
    /// A rotor at this position in steps, with the stop below it. `period` is the number of steps of an
    /// electrical period, which is four full steps; at least 2.
    pub const fn below(stop: i64, rotor: i64, period: u32) -> HardStop {
        let period = if period < 2 { 2 } else { period as i64 };
        HardStop { stop, above: false, held: rotor, period, slips: 0, axis: 0, forward: false }
    }

    /// The same with the stop above.
    pub const fn above(stop: i64, rotor: i64, period: u32) -> HardStop {
        HardStop { above: true, ..HardStop::below(stop, rotor, period) }
    }

    /// The same for this axis, whose edges it records.
    pub const fn of_axis(self, axis: u8) -> HardStop {
        HardStop { axis, ..self }
    }

    /// Makes a step of the field.
    pub fn step(&mut self, forward: bool) {
        self.held += if forward { 1 } else { -1 };
        if 2 * self.lag() > self.period {
            self.held += if self.above { -self.period } else { self.period };
            self.slips = self.slips.saturating_add(1);
        }
    }

    /// By how much the field is beyond the stop, which is the lag of the rotor: 0 where the rotor is free, half
    /// a period at most.
    pub fn lag(&self) -> i64 {
        let beyond = if self.above { self.held - self.stop } else { self.stop - self.held };
        beyond.max(0)
    }

    /// The position of the rotor, in steps.
    pub fn rotor(&self) -> i64 {
        if self.lag() > 0 { self.stop } else { self.held }
    }

    /// How often the rotor has slipped by a period.
    pub fn slips(&self) -> u32 {
        self.slips
    }
}

impl Recorder for HardStop {
    fn edge(&mut self, edge: Edge) {
        match edge.pin {
            _ if edge.axis != self.axis => {}
            Pin::Direction => self.forward = edge.level,
            Pin::Step if edge.level => self.step(self.forward),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Up to the stop the rotor follows. Then it stays at the stop, slips, and on the way back has lost whole
    /// periods.
    #[test]
    fn a_rotor_passes_no_stop_and_loses_whole_periods() {
        for above in [false, true] {
            let mut motor = HardStop::below(0, 50, 16);
            if above {
                motor = HardStop::above(0, -50, 16);
            }
            let mut told = motor.rotor();
            for n in 0..500 {
                motor.step(above);
                told += if above { 1 } else { -1 };
                let away = if above { -motor.rotor() } else { motor.rotor() };
                assert!((0..=50).contains(&away) && motor.lag() <= 8, "{n}: {motor:?}");
                assert!(n >= 50 || motor.rotor() == told);
            }
            for _ in 0..100 {
                motor.step(!above);
                told += if above { -1 } else { 1 };
            }
            let lost = (motor.rotor() - told).abs();
            assert!(lost % 16 == 0 && lost == 16 * i64::from(motor.slips()), "{lost}");
        }
    }
}
