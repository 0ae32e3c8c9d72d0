//! A limit switch on a virtual machine: `1:-300`.

#[cfg(feature = "std")]
use std::str::FromStr;

#[cfg(feature = "std")]
use crate::AXES;
use stepwright_protocol::AxisId;

/// A switch to ground that the carriage of an axis closes at a place and beyond.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Switch {
    /// Which axis.
    pub axis: AxisId,
    /// Closed from here on, away from 0: in steps from where the shaft was at power-up.
    pub at: i64,
}

impl Switch {
    /// Whether it is closed with the shaft there.
    pub fn is_closed(&self, shaft: i64) -> bool {
        if self.at < 0 { shaft <= self.at } else { shaft >= self.at }
    }
}

#[cfg(feature = "std")]
impl FromStr for Switch {
    type Err = String;

    fn from_str(text: &str) -> Result<Switch, String> {
        let wrong = || "an axis and a place in steps, not 0, like 1:-300".to_owned();
        let (axis, at) = text.split_once(':').ok_or_else(wrong)?;
        let axis = axis.parse().ok().and_then(AxisId::numbered).ok_or_else(wrong)?;
        if axis.index() >= AXES {
            return Err(format!("a virtual board has axes 1 to {AXES}"));
        }
        let at = at.parse().ok().filter(|at| *at != 0).ok_or_else(wrong)?;
        Ok(Switch { axis, at })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_at_its_place_and_beyond() {
        let behind: Switch = "1:-300".parse().unwrap();
        assert_eq!(
            [-301, -300, -299, 0].map(|at| behind.is_closed(at)),
            [true, true, false, false]
        );
        let ahead: Switch = "3:+20".parse().unwrap();
        assert_eq!([0, 19, 20, 21].map(|at| ahead.is_closed(at)), [false, false, true, true]);
        for wrong in ["", "1", "1:", "1:0", "0:5", "4:5", "x:5", "1:5mm"] {
            assert!(wrong.parse::<Switch>().is_err(), "{wrong}");
        }
    }
}
