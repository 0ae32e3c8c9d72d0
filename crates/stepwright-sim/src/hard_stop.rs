//! A motor that runs against something hard.

use crate::edge::{Edge, Pin, Recorder};

/// A stepper motor whose way ends at a stop: the field turns on, the rotor can't.
///
/// ```text
///   field   ─────╲
///   rotor   ──────╲____╱╲____╱╲___   pressed against the stop, half an electrical period
///   stop    ············              behind the field at most; then it slips back by a period
/// ```
///
/// The rotor stands where the field holds it, or at the stop. It has neither mass nor friction, so a
/// real one slips no later, and bounces further.
///
/// It is told steps, or takes down the edges of an axis as a [`Recorder`]:
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
    /// Where the rotor can't pass, and whether that is above it.
    stop: i64,
    above: bool,
    /// Where the field holds the rotor, if the stop lets it.
    held: i64,
    period: i64,
    slips: u32,
    axis: u8,
    /// The level of DIR.
    forward: bool,
}

impl HardStop {
    /// A rotor at a position in steps, with the stop below it; steps that an electrical period has:
    /// four full steps. At least 2.
    pub const fn below(stop: i64, rotor: i64, period: u32) -> HardStop {
        let period = if period < 2 { 2 } else { period as i64 };
        HardStop { stop, above: false, held: rotor, period, slips: 0, axis: 0, forward: false }
    }

    /// Likewise with the stop above it.
    pub const fn above(stop: i64, rotor: i64, period: u32) -> HardStop {
        HardStop { above: true, ..HardStop::below(stop, rotor, period) }
    }

    /// That of this axis, of whose edges it takes note.
    pub const fn of_axis(self, axis: u8) -> HardStop {
        HardStop { axis, ..self }
    }

    /// The motor is told to step.
    pub fn step(&mut self, forward: bool) {
        self.held += if forward { 1 } else { -1 };
        if 2 * self.lag() > self.period {
            self.held += if self.above { -self.period } else { self.period };
            self.slips = self.slips.saturating_add(1);
        }
    }

    /// How far the field is beyond the stop: by that the rotor lags. 0 where it runs free; half a
    /// period at most.
    pub fn lag(&self) -> i64 {
        let beyond = if self.above { self.held - self.stop } else { self.stop - self.held };
        beyond.max(0)
    }

    /// Where the rotor is, in steps.
    pub fn rotor(&self) -> i64 {
        if self.lag() > 0 { self.stop } else { self.held }
    }

    /// How often it has slipped by a period.
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

    /// Up to the stop it is where it is told; then it stands there, slips, and comes back by what it
    /// has lost: whole periods.
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
