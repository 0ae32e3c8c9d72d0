//! The article's debug dump.

use super::order::{Control, Status};
use core::fmt;

/// The fields that the Arduino driver prints, with their names there.
///
/// ```
/// use stepwright_timed::Dump;
/// let text = Dump { top: 15_000, time: 1_009, ..Dump::default() }.to_string();
/// assert!(text.starts_with("motor_ctrl_irq: 0x00\nmotor_timer_top32virt_irq: 15000\n"));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dump {
    /// `motor_ctrl_irq`
    pub control: Control,
    /// `motor_timer_top32virt_irq`
    pub top: u32,
    /// `motor_timer_modify_irq`
    pub modification: u32,
    /// `motor_step_count_limit_irq`: the steps left.
    pub steps_left: u32,
    /// `motor_time_irq`: milliseconds of the caller's clock when the last update was due.
    pub time: u32,
    /// `motor_stat_irq`
    pub status: Status,
    /// `motor_update_time_irq`
    pub update_ms: u16,
    /// `motor_millis_endtime_irq`: on the caller's clock.
    pub end: u32,
    /// `motor_modCounts_irq`: the updates left.
    pub counts: u16,
    /// `motor_pattern_irq`
    pub pattern: u8,
}

/// A value of the dump, as the article prints it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// `0xF0`
    Hex(u8),
    /// `15000`
    Number(u32),
}

impl Dump {
    /// Names and values in the article's order.
    pub fn fields(&self) -> [(&'static str, Field); 10] {
        use Field::{Hex, Number};
        [
            ("motor_ctrl_irq", Hex(self.control.bits())),
            ("motor_timer_top32virt_irq", Number(self.top)),
            ("motor_timer_modify_irq", Number(self.modification)),
            ("motor_step_count_limit_irq", Number(self.steps_left)),
            ("motor_time_irq", Number(self.time)),
            ("motor_stat_irq", Hex(self.status.bits())),
            ("motor_update_time_irq", Number(self.update_ms.into())),
            ("motor_millis_endtime_irq", Number(self.end)),
            ("motor_modCounts_irq", Number(self.counts.into())),
            ("motor_pattern_irq", Number(self.pattern.into())),
        ]
    }
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Field::Hex(byte) => write!(f, "{byte:#04X}"),
            Field::Number(number) => write!(f, "{number}"),
        }
    }
}

/// One field per line, each with its line end.
impl fmt::Display for Dump {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fields().iter().try_for_each(|(name, field)| writeln!(f, "{name}: {field}"))
    }
}
