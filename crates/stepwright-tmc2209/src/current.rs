//! The chip's current steps in milliamperes.
//!
//! ```text
//!           CS + 1     V_FS            1
//!   I_rms = ────── · ───────────── · ───     V_FS: 325 mV, or 180 mV with vsense
//!             32     R + 20 mΩ       √2      data sheet, "Selecting sense resistors"
//! ```

use stepwright::OutOfRange;

/// 10⁶·√2
const ROOT: u64 = 1_414_214;

/// The full-scale voltages in mV at low and at high sensitivity.
const FULL_SCALE: [u64; 2] = [325, 180];

/// The current scale of a chip with a given sense resistor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Scale {
    /// The sense resistor plus the chip's own resistance, in mΩ.
    ohm: u64,
    pub(crate) sensitive: bool,
}

impl Scale {
    /// The scale for a maximum current: high sensitivity, which has finer steps, if it reaches that
    /// current.
    pub(crate) fn reaching(milliamps: u16, sense_milliohms: u16) -> Scale {
        let ohm = u64::from(sense_milliohms) + 20;
        let fine = Scale { ohm, sensitive: true };
        if milliamps <= fine.most() { fine } else { Scale { sensitive: false, ..fine } }
    }

    /// (CS + 1) · 10⁹ · V_FS for a current in mA, with V_FS in mV.
    fn product(self, milliamps: u16) -> u64 {
        32 * ROOT * u64::from(milliamps) * self.ohm
    }

    fn full_scale(self) -> u64 {
        let [coarse, fine] = FULL_SCALE;
        1_000_000_000 * if self.sensitive { fine } else { coarse }
    }

    /// The highest current in mA.
    pub(crate) fn most(self) -> u16 {
        let most = 32 * self.full_scale() / (32 * ROOT * self.ohm);
        u16::try_from(most).unwrap_or(u16::MAX)
    }

    /// CS for a current, rounded down to a step.
    ///
    /// # Errors
    /// The current is above the highest, or below the lowest, which is 1/32 of the highest.
    pub(crate) fn steps(self, milliamps: u16) -> Result<u8, OutOfRange> {
        let steps = self.product(milliamps) / self.full_scale();
        match u8::try_from(steps) {
            Ok(steps @ 1..=32) if milliamps <= self.most() => Ok(steps - 1),
            _ => {
                let max = self.most();
                let min = u64::from(max / 32 + 1);
                Err(OutOfRange { what: "current", min, max: max.into(), unit: "mA" })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table of the data sheet, revision 1.09, section 8: the highest current for each sense
    /// resistor, in 10 mA.
    #[test]
    fn the_highest_currents_are_those_of_the_data_sheet() {
        for (milliohms, most) in [
            (1_000, 23),
            (820, 27),
            (750, 30),
            (680, 33),
            (500, 44),
            (470, 47),
            (390, 56),
            (330, 66),
            (270, 79),
            (220, 96),
            (180, 115),
            (150, 135),
            (120, 164),
            (100, 192),
        ] {
            let coarse = Scale { ohm: milliohms + 20, sensitive: false };
            let off = coarse.most().abs_diff(10 * most);
            assert!(off <= 6, "{milliohms} mΩ: {} mA, not {most}0", coarse.most());
            assert_eq!(coarse.steps(coarse.most()).map(|steps| steps >= 30), Ok(true));
        }
    }

    /// The current that is set is never above the requested one, and less than a step below it.
    #[test]
    fn a_current_is_rounded_down_to_a_step() {
        for milliohms in [75, 110, 150, 220] {
            for milliamps in (50..1_900).step_by(7) {
                let scale = Scale::reaching(milliamps, milliohms);
                let Ok(steps) = scale.steps(milliamps) else { continue };
                let full = if scale.sensitive { 0.180 } else { 0.325 };
                let one = full / 32.0 / (f64::from(milliohms) / 1e3 + 0.02) / 2f64.sqrt() * 1e3;
                let real = f64::from(steps + 1) * one;
                let asked = f64::from(milliamps);
                assert!(real <= asked + 0.01 && real > asked - one - 0.01, "{asked}: {real} mA");
            }
        }
    }

    #[test]
    fn what_it_cannot_drive_is_refused() {
        let scale = Scale::reaching(2_000, 110);
        let error = scale.steps(2_000).unwrap_err();
        assert_eq!(error.max, 1_767);
        assert!(scale.steps(1_767).is_ok() && scale.steps(20).is_err());
    }
}
