//! Changes of a travel on its way, by this program or by another one through the program that holds the port.

use std::fmt;

use stepwright_protocol::{AxisId, Command, MAX_AXES, Selection};

/// Where travels began, which `@` counts from, and their targets.
#[derive(Default)]
pub struct Travels([Option<Going>; MAX_AXES as usize]);

#[derive(Clone, Copy)]
struct Going {
    from: i64,
    /// The end that was ordered; `None` for an endless travel.
    end: Option<i64>,
    target: Option<i64>,
}

impl Travels {
    /// Notes that an axis begins a travel at this position.
    pub fn begins(&mut self, axis: AxisId, from: Option<i64>) {
        if let Some(slot) = self.0.get_mut(axis.index()) {
            *slot = from.map(|from| Going { from, end: None, target: None });
        }
    }

    /// Notes that the travel that an axis begins has this many steps.
    pub fn goes(&mut self, axis: AxisId, steps: i32) {
        if let Some(Some(going)) = self.0.get_mut(axis.index()) {
            going.end = Some(going.from.saturating_add(steps.into()));
        }
    }

    /// Where the travel of an axis ends if nothing stops it, if it is known.
    pub fn end(&self, axis: AxisId) -> Option<i64> {
        let going = self.going(axis)?;
        going.target.or(going.end)
    }

    /// Where the travel of an axis began.
    pub fn from(&self, axis: AxisId) -> Option<i64> {
        Some(self.going(axis)?.from)
    }

    /// The new target of a travel, if it was retargeted.
    pub fn target(&self, axis: AxisId) -> Option<i64> {
        self.going(axis)?.target
    }

    fn going(&self, axis: AxisId) -> Option<Going> {
        *self.0.get(axis.index())?
    }

    /// Notes a line that the board accepted for these axes. Returns the change.
    pub fn change(&mut self, axes: Selection, command: Command) -> Change {
        for axis in AxisId::first(MAX_AXES).filter(|axis| axes.contains(*axis)) {
            if let (Some(Some(going)), Command::Retarget(by)) =
                (self.0.get_mut(axis.index()), command)
            {
                going.target = Some(going.from.saturating_add(by.get().into()));
            }
        }
        let target = match (axes, command) {
            (Selection::One(axis), Command::Retarget(_)) => self.target(axis),
            _ => None,
        };
        Change { axes, command, target }
    }
}

/// A line that has changed motions. Displays as words.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    /// The changed axes.
    pub axes: Selection,
    /// The line.
    pub command: Command,
    /// The new target position of a single axis, if it is known. Of several axes each has its own:
    /// [`new_target`](crate::Conversation::new_target).
    pub target: Option<i64>,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.command, self.target) {
            (Command::Retarget(_), Some(target)) => write!(f, "target {target}"),
            (Command::Retarget(by), None) => {
                write!(f, "target {:+} steps from where the travel began", by.get())
            }
            (Command::Top(top), _) => write!(f, "top speed {} steps/s", top.get()),
            (Command::Milli(top), _) => {
                write!(f, "top speed {} steps/s", f64::from(top.get()) / 1000.0)
            }
            (Command::Accel(accel), _) => write!(f, "acceleration {} steps/s²", accel.get()),
            (Command::Decel(decel), _) => write!(f, "deceleration {} steps/s²", decel.get()),
            (Command::Stop, _) => f.write_str("stop"),
            (Command::Kill, _) => f.write_str("kill"),
            (other, _) => write!(f, "{other}"),
        }
    }
}
