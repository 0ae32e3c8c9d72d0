//! The unit of a machine, beside steps, in which results and plots are shown.

/// A unit, and its size in steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineUnit {
    /// `mm` or `deg`
    pub name: &'static str,
    /// The number of steps in one unit.
    pub steps: f64,
}

/// Steps per turn if they are unknown.
pub const TURN: u32 = 200;

impl MachineUnit {
    /// The unit of a machine with this many steps and nanometres per turn: millimetres if they are
    /// known, degrees if only the steps are, none if neither is.
    pub fn of(steps_per_rev: Option<u32>, nm_per_rev: Option<u32>) -> Option<MachineUnit> {
        let turn = f64::from(steps_per_rev.unwrap_or(TURN));
        match (steps_per_rev, nm_per_rev) {
            (_, Some(nm)) => Some(MachineUnit { name: "mm", steps: turn * 1e6 / f64::from(nm) }),
            (Some(_), None) => Some(MachineUnit { name: "deg", steps: turn / 360.0 }),
            (None, None) => None,
        }
    }

    /// A position as text, with enough digits to tell two steps apart: `10.0025 mm`.
    pub fn shown(self, steps: i64) -> String {
        let decimals = self.steps.log10().ceil().max(0.0) as usize + 1;
        let text = format!("{:.decimals$}", steps as f64 / self.steps);
        let text = text.trim_end_matches('0').trim_end_matches('.');
        format!("{} {}", if text == "-0" { "0" } else { text }, self.name)
    }

    /// The size of the unit, above a plot: `1 mm is 400 steps`.
    pub fn note(self) -> String {
        let steps = format!("{:.4}", self.steps);
        let steps = steps.trim_end_matches('0').trim_end_matches('.');
        format!("1 {} is {steps} steps", self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_counts_in_millimetres_or_else_in_degrees() {
        let unit = |steps, nm| MachineUnit::of(steps, nm).map(|unit| (unit.name, unit.steps));
        assert_eq!(unit(Some(3200), Some(8_000_000)), Some(("mm", 400.0)));
        assert_eq!(unit(None, Some(40_000_000)), Some(("mm", 5.0)));
        assert_eq!(unit(Some(720), None), Some(("deg", 2.0)));
        assert_eq!(unit(None, None), None);
    }

    #[test]
    fn a_step_can_be_seen() {
        let mm = MachineUnit { name: "mm", steps: 400.0 };
        for (steps, text) in
            [(4000, "10 mm"), (-4001, "-10.0025 mm"), (0, "0 mm"), (1, "0.0025 mm")]
        {
            assert_eq!(mm.shown(steps), text);
        }
        assert_eq!(MachineUnit { name: "deg", steps: 1.0 / 1.8 }.shown(1), "1.8 deg");
        assert_eq!(mm.note(), "1 mm is 400 steps");
    }
}
