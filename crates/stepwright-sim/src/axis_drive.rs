//! The drive of a motor on a virtual board: `1:unipolar-half`.

use std::str::FromStr;

use stepwright::drive::Sequence;
use stepwright::drive::sequence::{
    BRIDGE_FULL, BRIDGE_HALF, BRIDGE_WAVE, SHIELD, UNIPOLAR_FULL, UNIPOLAR_HALF, UNIPOLAR_WAVE,
};
use stepwright_protocol::AxisId;

use crate::{AXES, Description};

/// Drives with a line for each end of a winding, by their names in `stepwright timed --drive`.
const NAMES: [(&str, Sequence); 7] = [
    ("unipolar", UNIPOLAR_FULL),
    ("unipolar-wave", UNIPOLAR_WAVE),
    ("unipolar-half", UNIPOLAR_HALF),
    ("bridge", BRIDGE_FULL),
    ("bridge-wave", BRIDGE_WAVE),
    ("bridge-half", BRIDGE_HALF),
    ("shield", SHIELD),
];

/// An axis with windings in place of STEP and DIR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisDrive {
    /// The axis.
    pub axis: AxisId,
    /// The levels of its lines.
    pub sequence: Sequence,
}

impl Description {
    /// The same board with these motors on coils. The last drive of an axis counts.
    pub fn with_drives(mut self, drives: &[AxisDrive]) -> Description {
        for AxisDrive { axis, sequence } in drives {
            if let Some(coils) = self.coils.get_mut(axis.index()) {
                *coils = Some(*sequence);
            }
        }
        self
    }
}

impl FromStr for AxisDrive {
    type Err = String;

    fn from_str(text: &str) -> Result<AxisDrive, String> {
        let wrong = || {
            let names: Vec<_> = NAMES.iter().map(|(name, _)| *name).collect();
            format!("an axis and a drive, like 1:bridge-half; there is {}", names.join(", "))
        };
        let (axis, drive) = text.split_once(':').ok_or_else(wrong)?;
        let axis = axis.parse().ok().and_then(AxisId::numbered).ok_or_else(wrong)?;
        if axis.index() >= AXES {
            return Err(format!("a virtual board has axes 1 to {AXES}"));
        }
        let (_, sequence) = NAMES.iter().find(|(name, _)| *name == drive).ok_or_else(wrong)?;
        Ok(AxisDrive { axis, sequence: *sequence })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_and_a_drive() {
        let half: AxisDrive = "2:bridge-half".parse().unwrap();
        assert_eq!((half.axis.number(), half.sequence), (2, BRIDGE_HALF));
        for wrong in ["", "bridge", "1:", "0:bridge", "4:bridge", "1:servo", "1:unipolar:D4"] {
            assert!(wrong.parse::<AxisDrive>().is_err(), "{wrong}");
        }
    }
}
