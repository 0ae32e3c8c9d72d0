//! From turns and millimetres to steps.

use super::{Accel, OutOfRange, Speed};

/// How a motor's steps relate to physical units: the steps (microsteps included) per turn of its
/// shaft, and the distance that the load travels in a turn.
///
/// ```
/// use stepwright::{Geometry, Turn};
/// let axis = Geometry::new(200).unwrap().travelling_nm(40_000_000).unwrap();
/// assert_eq!(axis.speed(120_000, Turn::Rpm).unwrap().to_string(), "400");
/// assert_eq!(axis.speed(50_000, Turn::Millimetre).unwrap().to_string(), "250");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Geometry {
    steps_per_turn: u32,
    nm_per_turn: u32,
}

/// A unit that a [`Geometry`] converts to steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// Steps per second (squared).
    Step,
    /// Turns per minute: speeds only; as an acceleration, turns per minute
    /// per second.
    Rpm,
    /// Whole turns per second (squared).
    Turn,
    /// Degrees per second (squared).
    Degree,
    /// Radians per second (squared).
    Radian,
    /// Millimetres per second (squared); needs a distance per turn.
    Millimetre,
}

/// 2π · 10⁹, rounded: the error is below 2⁻³⁴ of the value.
const TAU_NANO: u128 = 6_283_185_307;

impl Geometry {
    /// A motor of `steps_per_turn` steps: 200 for 1.8°, 3200 with 1/16 steps.
    ///
    /// # Errors
    /// [`OutOfRange`] unless 1 ≤ `steps_per_turn` ≤ 10,000,000.
    pub const fn new(steps_per_turn: u32) -> Result<Geometry, OutOfRange> {
        if steps_per_turn == 0 || steps_per_turn > 10_000_000 {
            return Err(OutOfRange {
                what: "steps per turn",
                min: 1,
                max: 10_000_000,
                unit: "steps",
            });
        }
        Ok(Geometry { steps_per_turn, nm_per_turn: 0 })
    }

    /// The same motor with a belt or a screw: `nm` nanometres per turn (40 mm = 40,000,000).
    ///
    /// # Errors
    /// [`OutOfRange`] for 0.
    pub const fn travelling_nm(self, nm: u32) -> Result<Geometry, OutOfRange> {
        if nm == 0 {
            return Err(OutOfRange {
                what: "distance per turn",
                min: 1,
                max: u32::MAX as u64,
                unit: "nm",
            });
        }
        Ok(Geometry { nm_per_turn: nm, ..self })
    }

    /// Steps per turn.
    pub const fn steps_per_turn(self) -> u32 {
        self.steps_per_turn
    }

    /// Nanometres per turn, if set.
    pub const fn nm_per_turn(self) -> Option<u32> {
        if self.nm_per_turn == 0 { None } else { Some(self.nm_per_turn) }
    }

    /// `milli` thousandths of `unit` per second as a speed, to the nearest
    /// 0.001 steps/s.
    ///
    /// # Errors
    /// [`OutOfRange`] when it exceeds 1,000,000 steps/s, or for millimetres
    /// without a distance per turn.
    pub fn speed(self, milli: u64, unit: Turn) -> Result<Speed, OutOfRange> {
        let v = self.millisteps(milli, unit)?;
        Speed::from_millisteps(u32::try_from(v).unwrap_or(u32::MAX))
    }

    /// `milli` thousandths of `unit` per second squared as an acceleration,
    /// to the nearest 0.001 steps/s².
    ///
    /// # Errors
    /// [`OutOfRange`] outside 0.001 … 100,000,000 steps/s², or for
    /// millimetres without a distance per turn.
    pub fn accel(self, milli: u64, unit: Turn) -> Result<Accel, OutOfRange> {
        Accel::from_millisteps(self.millisteps(milli, unit)?)
    }

    /// Thousandths of `unit` in thousandths of a step, rounded to nearest.
    fn millisteps(self, milli: u64, unit: Turn) -> Result<u64, OutOfRange> {
        let steps = u128::from(self.steps_per_turn);
        let (up, down) = match unit {
            Turn::Step => (1, 1),
            Turn::Rpm => (steps, 60),
            Turn::Turn => (steps, 1),
            Turn::Degree => (steps, 360),
            Turn::Radian => (steps * 1_000_000_000, TAU_NANO),
            Turn::Millimetre if self.nm_per_turn != 0 => {
                (steps * 1_000_000, u128::from(self.nm_per_turn))
            }
            Turn::Millimetre => {
                return Err(OutOfRange {
                    what: "distance per turn (needed for millimetres)",
                    min: 1,
                    max: u64::from(u32::MAX),
                    unit: "nm",
                });
            }
        };
        let value = (u128::from(milli) * up + down / 2) / down;
        Ok(u64::try_from(value).unwrap_or(u64::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motor() -> Geometry {
        Geometry::new(200).unwrap().travelling_nm(40_000_000).unwrap()
    }

    /// Austin: 120 rpm and 300 rpm of a 1.8° motor are 2500 and 1000
    /// counts of a 1 MHz timer; 4π rad/s² are 400 steps/s².
    #[test]
    fn the_units_of_austin() {
        assert_eq!(motor().speed(120_000, Turn::Rpm).unwrap().millisteps(), 400_000);
        assert_eq!(motor().speed(300_000, Turn::Rpm).unwrap().millisteps(), 1_000_000);
        assert_eq!(motor().speed(10_000, Turn::Radian).unwrap().millisteps(), 318_310);
        assert_eq!(motor().accel(12_566, Turn::Radian).unwrap().millisteps(), 399_988);
    }

    #[test]
    fn degrees_turns_and_millimetres() {
        assert_eq!(motor().speed(1_800, Turn::Degree).unwrap().millisteps(), 1_000);
        assert_eq!(motor().speed(1_500, Turn::Turn).unwrap().millisteps(), 300_000);
        assert_eq!(motor().accel(2_000, Turn::Millimetre).unwrap().millisteps(), 10_000);
        assert!(Geometry::new(200).unwrap().speed(1, Turn::Millimetre).is_err());
    }

    #[test]
    fn nothing_overflows() {
        let g = Geometry::new(10_000_000).unwrap().travelling_nm(1).unwrap();
        for unit in
            [Turn::Step, Turn::Rpm, Turn::Turn, Turn::Degree, Turn::Radian, Turn::Millimetre]
        {
            assert!(g.speed(u64::MAX, unit).is_err());
            assert!(g.accel(u64::MAX, unit).is_err());
        }
    }
}
