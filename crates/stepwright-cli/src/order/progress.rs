//! The progress of a moving motor on standard error: on a terminal a line that is updated in place
//! and fits the width, elsewhere a line a second.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use console::Term;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use stepwright_host::motion::Sight;
use stepwright_protocol::Command;

use super::keys;
use super::left::Aim;
use super::motion::{Motion, seconds};
use super::terminal;
use crate::{interrupt, say};
use stepwright_host::course::Course;

/// The time over which a speed is measured; longer for a slow motor.
const WINDOW: Duration = Duration::from_millis(200);

/// A slow motor's speed is measured over this many steps, but for at most `LONGEST`.
const STEPS: u64 = 10;
const LONGEST: Duration = Duration::from_secs(4);

/// The time between two lines where they can't be updated in place.
const LINES: Duration = Duration::from_secs(1);

/// The width of a bar in columns.
const BAR: usize = 20;

/// A status line, and notes above it.
pub struct Line {
    bar: Option<ProgressBar>,
    told: Instant,
    last: String,
}

impl Line {
    /// An empty line.
    pub fn new() -> Line {
        let bar = terminal::has_sequences().then(|| {
            let target = ProgressDrawTarget::stderr_with_hz(10);
            let bar = ProgressBar::with_draw_target(None, target);
            match ProgressStyle::with_template("{msg}") {
                Ok(style) => bar.with_style(style),
                Err(_) => bar,
            }
        });
        Line { bar, told: Instant::now(), last: String::new() }
    }

    /// Prints a note above the line.
    pub fn note(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| say::note(text)),
            None => say::note(text),
        }
    }

    /// Shows the first of these texts that fits; the longest comes first. Where lines can't be
    /// updated in place, prints `plain` once a second, or at once if it is `news`.
    pub fn show(&mut self, wordings: &[&str], plain: &str, news: bool) {
        let Some(bar) = &self.bar else {
            let due = self.told.elapsed() >= LINES;
            if (due || news) && self.last != plain {
                plain.clone_into(&mut self.last);
                self.told = Instant::now();
                say::note(plain);
            }
            return;
        };
        // The last column stays free: some terminals wrap the line there.
        let width = Term::stderr().size_checked().map_or(79, |(_, columns)| columns.max(2) - 1);
        bar.set_message(fitting(wordings, width.into()));
    }

    /// Clears the line away.
    pub fn end(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// The first text that fits, else the start of the last one.
fn fitting(wordings: &[&str], width: usize) -> String {
    let fits = |text: &&&str| text.chars().count() <= width;
    match (wordings.iter().find(fits), wordings.last()) {
        (Some(text), _) => (*text).to_owned(),
        (None, Some(last)) => last.chars().take(width).collect(),
        (None, None) => String::new(),
    }
}

/// Measures a speed by the times of steps.
struct Pace {
    last: i64,
    /// When the position was first seen at its last values.
    steps: VecDeque<(Duration, i64)>,
}

impl Pace {
    /// A motor that rests at `from`.
    fn new(from: i64) -> Pace {
        Pace { last: from, steps: VecDeque::new() }
    }

    /// The speed over the last moment in steps/s, positive forward; `None` before the second step.
    fn see(&mut self, time: Duration, position: i64) -> Option<f64> {
        if position != self.last {
            self.last = position;
            self.steps.push_back((time, position));
        }
        let (begun, end) = *self.steps.back()?;
        // Drops the oldest steps while the others suffice for a measurement.
        while let Some((then, there)) = self.steps.get(1) {
            let past = begun.saturating_sub(*then);
            let enough = past >= WINDOW && end.abs_diff(*there) >= STEPS;
            if !enough && past < LONGEST {
                break;
            }
            self.steps.pop_front();
        }
        let (then, there) = *self.steps.front()?;
        let past = begun.saturating_sub(then).as_secs_f64();
        let measured = (past > 0.0).then(|| end.saturating_sub(there) as f64 / past)?;
        // No faster than a step since the last one.
        let most = 1.0 / time.saturating_sub(begun).as_secs_f64();
        Some(measured.clamp(-most, most))
    }
}

/// The progress of a motion.
pub struct Progress {
    line: Line,
    /// The motion in closed form, until it is changed.
    course: Option<Course>,
    aim: Aim,
    from: i64,
    pace: Pace,
    braking: bool,
}

impl Progress {
    /// The progress of a motion that begins at `from`. If `keys`, prints the keys.
    pub fn new(motion: &Motion, from: i64, keys: bool) -> Progress {
        let line = Line::new();
        if keys {
            line.note(keys::HELP);
        }
        Progress {
            line,
            course: motion.course(),
            aim: Aim::of(&motion.order, from),
            from,
            pace: Pace::new(from),
            braking: false,
        }
    }

    /// Shows what was seen of the motor. `told` is a note for the user, and `change` a line that
    /// has changed the motion.
    pub fn see(&mut self, sight: &Sight, told: Option<&str>, change: Option<Command>) {
        if sight.braking && !self.braking {
            self.braking = true;
            self.line.note(interrupt::braking());
        }
        if let Some(text) = told {
            self.line.note(text);
        }
        if let Some(line) = change {
            // The closed form holds no longer.
            self.course = None;
            self.aim.change(line);
        }
        let Some(position) = sight.position else { return };
        let measured = self.pace.see(sight.time, position);
        let speed = self.lawful(position).filter(|_| !self.braking).or(measured);
        self.tell(position, speed);
    }

    fn tell(&mut self, position: i64, speed: Option<f64>) {
        let done = position.abs_diff(self.from);
        let left = match self.left(position, speed.unwrap_or(0.0)) {
            _ if self.braking => "  braking".to_owned(),
            Some(left) if left < 100.0 => format!("  {left:.1} s left"),
            Some(left) => format!("  {} left", seconds(left)),
            None => String::new(),
        };
        let speed = speed.map(|speed| match speed.abs() {
            size if size < 10.0 && size > 0.0 => {
                format!("{size:.3}").trim_end_matches('0').trim_end_matches('.').to_owned()
            }
            size => format!("{size:.0}"),
        });
        let said = speed.as_ref().map_or(String::new(), |speed| format!("  {speed} steps/s"));
        let plain = format!("position {position}{said}{left}");
        let whole = self.aim.whole().filter(|whole| *whole > 0.0 && !self.braking);
        let long = match whole {
            Some(whole) => format!("{}  {plain}", bar(done as f64 / whole)),
            None => plain.clone(),
        };
        let left = left.trim_end_matches(" left");
        let said = speed.map_or(String::new(), |speed| format!("  {speed}/s"));
        let short = format!("{position}{said}{left}");
        let shorter = format!("{position}{left}");
        let wordings: [&str; 5] = [&long, &plain, &short, &shorter, &position.to_string()];
        self.line.show(&wordings, &plain, false);
    }

    /// The speed by the motion's law in steps/s, until the motion is changed.
    fn lawful(&self, position: i64) -> Option<f64> {
        let course = self.course.as_ref()?;
        let next = u32::try_from(position.abs_diff(self.from)).ok()?;
        let before = next.checked_sub(1).filter(|_| next < course.pulses())?;
        let time = course.seconds(next) - course.seconds(before);
        (time > 0.0).then(|| 1.0 / time)
    }

    /// The seconds until the end: by the law of the motion, or by the speed once the motion was
    /// changed.
    fn left(&self, position: i64, speed: f64) -> Option<f64> {
        let Some(course) = &self.course else { return self.aim.seconds(position as f64, speed) };
        let last = course.pulses().checked_sub(1)?;
        let done = position.abs_diff(self.from);
        let pulse = u32::try_from(done.saturating_sub(1)).unwrap_or(last).min(last);
        Some(course.seconds(last) - course.seconds(pulse))
    }

    /// Prints a note.
    pub fn note(&self, text: &str) {
        self.line.note(text);
    }

    /// Clears the line away.
    pub fn end(self) {
        self.line.end();
    }
}

/// A part of a whole, as a bar and a number: `━━━━────  50 %`.
fn bar(part: f64) -> String {
    let part = part.clamp(0.0, 1.0);
    let full = (part * BAR as f64) as usize;
    format!("{}{}  {:>3.0} %", "━".repeat(full), "─".repeat(BAR - full), (part * 100.0).floor())
}

#[cfg(test)]
mod tests {
    use super::{Pace, bar, fitting};
    use std::time::Duration;

    /// Looked at every 20 ms, also slower than a step/s, and as it slows down.
    #[test]
    fn a_speed_is_measured_from_step_to_step() {
        for (speed, seconds) in [(0.1, 60), (0.3, 20), (1.7, 10), (47.0, 5), (3_000.0, 2)] {
            for way in [1.0, -1.0] {
                let (mut pace, mut seen) = (Pace::new(70), 0);
                for n in 0..seconds * 50 {
                    // The first pulse is at the beginning.
                    let (time, since) = (f64::from(n) / 50.0, f64::from(n) / 50.0 - 0.013);
                    let gone = if since < 0.0 { 0.0 } else { (since * speed).floor() + 1.0 };
                    let position = 70 + (way * gone) as i64;
                    let told = pace.see(Duration::from_secs_f64(time), position);
                    assert!(told.is_none() || gone > 1.0, "{speed} at {time}: {told:?}");
                    if let Some(told) = told.filter(|_| since > 0.3) {
                        let off = (told * way / speed - 1.0).abs();
                        assert!(off < 0.1, "{speed} at {time}: {told}");
                        seen += 1;
                    }
                }
                assert!(seen > 50, "{speed}: {seen}");
            }
        }
        let mut pace = Pace::new(0);
        for step in 0..4 {
            pace.see(Duration::from_millis(20 * step), step as i64);
        }
        let halted = pace.see(Duration::from_millis(2060), 3).unwrap();
        assert!((0.0..=0.5).contains(&halted), "{halted}");
    }

    #[test]
    fn what_is_shown_fits() {
        let wordings = ["━━──  50 %  position 12345  1000 steps/s", "12345  1000/s", "12345"];
        assert_eq!(fitting(&wordings, 79), wordings[0]);
        assert_eq!(fitting(&wordings, 40), wordings[0]);
        assert_eq!(fitting(&wordings, 39), wordings[1]);
        assert_eq!(fitting(&wordings, 5), "12345");
        assert_eq!(fitting(&wordings, 3), "123");
    }

    #[test]
    fn a_bar_is_as_full_as_its_number() {
        assert_eq!(bar(0.0), format!("{}    0 %", "─".repeat(20)));
        assert_eq!(bar(0.999), format!("{}─   99 %", "━".repeat(19)));
        assert_eq!(bar(7.0), format!("{}  100 %", "━".repeat(20)));
    }
}
