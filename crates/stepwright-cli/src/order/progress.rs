//! What the user sees of a moving motor: on a terminal a line that renews
//! itself, elsewhere a line a second, both on standard error.

use std::collections::VecDeque;
use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use stepwright_protocol::{Distance, Travel};

use super::course::Course;
use super::drive::Sight;
use super::keys;
use super::motion::{Motion, seconds};
use crate::{interrupt, say};

/// The speed is measured over so long.
const WINDOW: Duration = Duration::from_millis(500);

/// Between two lines where there is no terminal.
const LINES: Duration = Duration::from_secs(1);

/// A moving motor, told to the user.
pub struct Progress {
    bar: Option<ProgressBar>,
    course: Option<Course>,
    from: i64,
    sights: VecDeque<(Duration, i64)>,
    told: Instant,
    braking: bool,
}

impl Progress {
    /// Of a motion that begins at `from`, and says which keys there are.
    pub fn new(motion: &Motion, from: i64, keys: bool) -> Progress {
        let steps = match motion.order.travel {
            Travel::By(distance) => Some(distance),
            Travel::Endless(_) => None,
        };
        let bar = io::stderr().is_terminal().then(|| bar(steps));
        let course = motion.course();
        let sights = VecDeque::new();
        let progress = Progress { bar, course, from, sights, told: Instant::now(), braking: false };
        if keys {
            progress.note(keys::HELP);
        }
        progress
    }

    /// Tells a look at the motor.
    pub fn see(&mut self, sight: Sight) {
        if sight.braking && !self.braking {
            self.braking = true;
            self.note(interrupt::braking());
        }
        if let Some(text) = &sight.told {
            self.note(text);
            // It is another motion now.
            self.course = None;
        }
        let Some(position) = sight.position else { return };
        let speed = self.speed(sight.time, position);
        let done = position.abs_diff(self.from);
        if let Some(bar) = &self.bar {
            bar.set_position(done);
            bar.set_message(self.line(position, done, speed));
        } else if self.told.elapsed() >= LINES {
            self.told = Instant::now();
            say::note(self.line(position, done, speed));
        }
    }

    /// Something that the user should know, above the line.
    fn note(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| say::note(text)),
            None => say::note(text),
        }
    }

    /// Steps per second, measured.
    fn speed(&mut self, time: Duration, position: i64) -> f64 {
        self.sights.push_back((time, position));
        while self.sights.get(1).is_some_and(|(then, _)| time.saturating_sub(*then) >= WINDOW) {
            self.sights.pop_front();
        }
        let (then, there) = self.sights.front().copied().unwrap_or((time, position));
        let time = time.saturating_sub(then).as_secs_f64();
        if time > 0.0 { position.abs_diff(there) as f64 / time } else { 0.0 }
    }

    fn line(&self, position: i64, done: u64, speed: f64) -> String {
        let left = match self.left(done) {
            _ if self.braking => "  braking".to_owned(),
            Some(left) if left < 100.0 => format!("  {left:.1} s left"),
            Some(left) => format!("  {} left", seconds(left)),
            None => String::new(),
        };
        format!("position {position}  {speed:.0} steps/s{left}")
    }

    /// Seconds until the end, by the law of the motion.
    fn left(&self, done: u64) -> Option<f64> {
        let course = self.course.as_ref()?;
        let last = course.pulses().checked_sub(1)?;
        let pulse = u32::try_from(done.saturating_sub(1)).unwrap_or(last).min(last);
        Some(course.seconds(last) - course.seconds(pulse))
    }

    /// Clears the line away.
    pub fn end(self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

fn bar(steps: Option<Distance>) -> ProgressBar {
    let target = ProgressDrawTarget::stderr_with_hz(10);
    let (bar, template) = match steps {
        Some(steps) => {
            let bar =
                ProgressBar::with_draw_target(Some(steps.get().unsigned_abs().into()), target);
            (bar, "{bar:30} {percent:>3} %  {msg}")
        }
        None => (ProgressBar::with_draw_target(None, target), "{spinner} {msg}"),
    };
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
