//! The output about cycles, on a virtual or a real board.

use std::ops::Range;

use serde_json::{Value, json};

use stepwright_cycle::{CycleError, Faults, Motor, Refusal, Status};
use stepwright_plan::tidy;

use super::PlayText;
use crate::{PlayError, PlayFormat, PlayVoice, micros};
use stepwright_cyclefile::CyclePlan;

/// The results of cycles, and their output.
pub(super) struct Told<'p> {
    pub plan: &'p CyclePlan,
    pub text: &'p PlayText,
    pub format: PlayFormat,
    pub voice: &'p dyn PlayVoice,
    cycles: Vec<Value>,
    /// For all cycles: late steps, and the handler's longest time in µs.
    pub late: u32,
    longest: u32,
}

/// The end of a cycle.
pub(super) struct Ending {
    pub seconds: f64,
    pub error: Option<CycleError>,
    pub late: u32,
    pub longest: u32,
    /// The motors that stopped before the end.
    pub stopped: Vec<(u8, Faults)>,
}

/// The final state of a motor.
pub(super) struct Ended {
    pub position: i64,
    pub status: Status,
    pub faults: Faults,
    pub known: Option<Motor>,
}

impl<'p> Told<'p> {
    pub fn new(
        plan: &'p CyclePlan,
        text: &'p PlayText,
        format: PlayFormat,
        voice: &'p dyn PlayVoice,
    ) -> Told<'p> {
        Told { plan, text, format, voice, cycles: Vec::new(), late: 0, longest: 0 }
    }

    /// The name of a motor in the file.
    pub fn name(&self, motor: u8) -> &'p str {
        self.plan.names.get(usize::from(motor)).map_or("", String::as_str)
    }

    /// Prints the positions of all motors.
    pub fn list(&self, positions: &[i64]) {
        if self.format == PlayFormat::List {
            let each = self.plan.names.iter().zip(positions);
            let each: Vec<_> = each.map(|(name, at)| format!("{name}.pos={at}")).collect();
            self.voice.result(&each.join(", "));
        }
    }

    /// Notes a failed cycle for json: the error, its line in the file, and the motor. A refused
    /// cycle took no time.
    pub fn note(&mut self, n: usize, failure: &PlayError) {
        let what = failure.place.as_ref().map_or(&failure.message, |place| &place.what);
        if self.cycles.len() <= n {
            self.cycles.push(json!({ "seconds": 0.0, "error": what }));
        }
        if let Some(error) = self.cycles.get_mut(n).map(|cycle| &mut cycle["error"])
            && error.is_null()
        {
            *error = json!(what);
        }
        if let (Some(place), Some(cycle)) = (&failure.place, self.cycles.get_mut(n)) {
            cycle["line"] = json!(place.line);
            cycle["motor"] = json!(place.motor);
        }
    }

    /// Notes a cycle without a motion.
    pub fn nothing(&mut self, number: usize) {
        self.cycles.push(json!({ "seconds": 0.0, "error": null }));
        if self.format == PlayFormat::List {
            self.voice
                .note(&format_args!("cycle {number}: the motors stand at the end of it already"));
        }
    }

    /// Notes a homed motor.
    pub fn home(&mut self, number: usize, motor: u8, seconds: f64) {
        self.cycles.push(json!({ "seconds": seconds, "error": null }));
        if self.format == PlayFormat::List {
            let name = self.name(motor);
            self.voice.note(&format_args!("cycle {number}: {name} is home after {seconds:.3} s"));
        }
    }

    /// The error for a cycle that did not start, with the name of the motor in the file.
    pub fn refused(&self, refusal: Refusal, at: Range<usize>) -> PlayError {
        let name = refusal.motor().map_or("", |motor| self.name(motor));
        let failure = self.text.blame(at, refusal.named(name));
        if name.is_empty() { failure } else { failure.motor(name) }
    }

    /// The error for a cancelled cycle.
    pub fn cancelled(
        &self,
        number: usize,
        seconds: f64,
        error: CycleError,
        faults: impl FnOnce(u8) -> Faults,
        spans: &[(u8, Range<usize>)],
        at: Range<usize>,
    ) -> PlayError {
        match error {
            CycleError::MotorError { motor } => {
                let faults = faults(motor);
                let name = self.name(motor);
                let span = spans.iter().find(|(known, _)| *known == motor);
                let span = span.map_or(at, |(_, span)| span.clone());
                let what =
                    format!("cycle {number} was cancelled after {seconds:.3} s: {name}: {faults}");
                let end = match faults.has(Faults::HARD_END_MIN | Faults::HARD_END_MAX) {
                    true => "hard-end",
                    false if faults.has(Faults::STEP_DELAY_SMALL) => "small-delay",
                    false => "soft-end",
                };
                self.text.blame(span, what).motor(name).hint(format!(
                    "with {end} = \"stop-motor\" under [strategies] the others go on"
                ))
            }
            error => {
                let what = format!("cycle {number} was cancelled after {seconds:.3} s: {error}");
                self.text.blame(at, what)
            }
        }
    }

    /// The error for a cycle that has not ended by itself.
    pub fn endless(&self, number: usize, limit: u64, at: Range<usize>) -> PlayError {
        let what = format!("cycle {number} has not ended after {limit} s");
        self.text.blame(at, what).hint("give finish-s, or a longer --limit")
    }

    /// Notes the end of a cycle, for json and standard error.
    pub fn ended(&mut self, number: usize, ending: &Ending) {
        let Ending { seconds, error, late, longest, stopped } = ending;
        for (motor, faults) in stopped {
            if error.is_none() && self.format != PlayFormat::Silent {
                self.voice
                    .note(&format_args!("cycle {number}: {} stopped: {faults}", self.name(*motor)));
            }
        }
        let error = error.map(|error| match error {
            CycleError::MotorError { motor } => format!("an error of {}", self.name(motor)),
            CycleError::TimingExceeded => error.to_string(),
        });
        if error.is_none() && self.format == PlayFormat::List {
            self.voice.note(&format_args!(
                "cycle {number}: {seconds:.3} s, {late} steps late, the handler took {longest} µs \
                 at most"
            ));
        }
        self.late = self.late.saturating_add(*late);
        self.longest = self.longest.max(*longest);
        let cycle = json!({
            "seconds": seconds,
            "late": late,
            "longest_us": longest,
            "error": error,
        });
        self.cycles.push(cycle);
    }

    /// The result of all cycles as JSON.
    pub fn json(&self, seconds: f64, motors: &[Ended]) -> String {
        let motors: Vec<_> = (self.plan.names.iter().zip(motors))
            .map(|(name, motor)| {
                let status = match motor.status {
                    Status::Idle => "idle",
                    Status::Running => "running",
                    Status::Finished => "finished",
                };
                json!({
                    "name": name,
                    "position": motor.position,
                    "status": status,
                    "faults": motor.faults.bits(),
                    "min": motor.known.and_then(|m| m.min),
                    "max": motor.known.and_then(|m| m.max),
                })
            })
            .collect();
        let all = json!({
            "unit": self.plan.unit,
            "seconds": seconds,
            "late": self.late,
            "longest_us": self.longest,
            "cycles": self.cycles,
            "motors": motors,
        });
        format!("{:#}", tidy(all))
    }

    /// Ticks as a time in µs, as exact as the timer.
    pub fn micros(&self, ticks: u64) -> String {
        micros(ticks, self.plan.rate)
    }

    /// Converts µs to ticks.
    pub fn ticks(&self, us: u64) -> u64 {
        (u128::from(us) * u128::from(self.plan.rate.hz()) / 1_000_000) as u64
    }

    /// Converts ticks to seconds.
    pub fn seconds(&self, ticks: u64) -> f64 {
        ticks as f64 / f64::from(self.plan.rate.hz())
    }
}
