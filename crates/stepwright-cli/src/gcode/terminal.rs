//! The terminal that follows the run of a job, on the virtual board or on a real one.

use std::time::{Duration, Instant};

use stepwright_plan::gcode::JobPlan;
use stepwright_play::stream::{JobWatch, Place, PlayWish};

use crate::interrupt;
use crate::order::motion::seconds;
use crate::order::progress::Line;

/// The time between two reports.
const SHOWN: Duration = Duration::from_millis(100);

/// Watches for Ctrl-C, and shows the progress on the terminal.
pub struct Terminal<'a> {
    plan: &'a JobPlan,
    line: Line,
    shown: Option<Instant>,
    told: bool,
}

impl Terminal<'_> {
    /// A terminal that follows a job with this plan.
    pub fn new(plan: &JobPlan) -> Terminal<'_> {
        Terminal { plan, line: Line::new(), shown: None, told: false }
    }
}

impl Drop for Terminal<'_> {
    fn drop(&mut self) {
        self.line.end();
    }
}

impl JobWatch for Terminal<'_> {
    fn wish(&mut self) -> PlayWish {
        if interrupt::presses() >= 2 {
            return PlayWish::Kill;
        }
        if !interrupt::asked() {
            return PlayWish::Go;
        }
        if !std::mem::replace(&mut self.told, true) {
            self.line.note(interrupt::braking());
        }
        PlayWish::Brake
    }

    fn tell(&mut self, place: &Place) {
        if self.shown.is_none_or(|shown| shown.elapsed() > SHOWN) {
            self.shown = Some(Instant::now());
            tell(&mut self.line, place.seconds, self.plan.time, place.wish == PlayWish::Brake);
        }
    }
}

/// Shows the progress, and the exact time that is left.
fn tell(line: &mut Line, now: f64, all: f64, braked: bool) {
    let plain = progress(now, all, braked);
    let long = format!("{plain} of {}", seconds(all));
    line.show(&[&long, &plain], &plain, false);
}

/// The text of the progress. A board ends some ms after the plan; no time is left then.
fn progress(now: f64, all: f64, braked: bool) -> String {
    let left = (all - now).max(0.0);
    let left = if braked { "braking".into() } else { format!("{} left", seconds(left)) };
    let part = if all > 0.0 { (now / all * 100.0).clamp(0.0, 100.0) } else { 100.0 };
    format!("{part:.0} %  {left}")
}

#[cfg(test)]
mod tests {
    use super::progress;

    #[test]
    fn no_time_is_left_behind_the_end() {
        assert_eq!(progress(1.0, 2.0, false), "50 %  1.000 s left");
        assert_eq!(progress(2.022, 2.0, false), "100 %  0.000 s left");
        assert_eq!(progress(1.0, 2.0, true), "50 %  braking");
    }
}
