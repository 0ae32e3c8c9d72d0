//! What is said of a cycle, wherever it is played.

use std::ops::Range;

use serde_json::{Value, json};

use stepwright_cycle::{CycleError, Faults, Motor, Refusal, Status};
use stepwright_plan::tidy;

use super::PlayText;
use crate::{PlayError, PlayFormat, PlayVoice, micros};
use stepwright_cyclefile::CyclePlan;

/// What became of each cycle, and how it is said.
pub(super) struct Told<'p> {
    pub plan: &'p CyclePlan,
    pub text: &'p PlayText,
    pub format: PlayFormat,
    pub voice: &'p dyn PlayVoice,
    cycles: Vec<Value>,
    /// Of all cycles: steps that came late, and the handler's longest time in µs.
    pub late: u32,
    longest: u32,
}

/// How a cycle ended.
pub(super) struct Ending {
    pub seconds: f64,
    pub error: Option<CycleError>,
    pub late: u32,
    pub longest: u32,
    /// Motors that stopped on the way.
    pub stopped: Vec<(u8, Faults)>,
}

/// How a motor is in the end.
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

    /// What the file calls a motor.
    pub fn name(&self, motor: u8) -> &'p str {
        self.plan.names.get(usize::from(motor)).map_or("", String::as_str)
    }

    /// Positions of all.
    pub fn list(&self, positions: &[i64]) {
        if self.format == PlayFormat::List {
            let each = self.plan.names.iter().zip(positions);
            let each: Vec<_> = each.map(|(name, at)| format!("{name}.pos={at}")).collect();
            self.voice.result(&each.join(", "));
        }
    }

    /// A cycle that failed, for json: what is wrong, in which line of the file, with which
    /// motor. One that was refused took no time.
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

    /// A cycle in which nothing had to move.
    pub fn nothing(&mut self, number: usize) {
        self.cycles.push(json!({ "seconds": 0.0, "error": null }));
        if self.format == PlayFormat::List {
            self.voice
                .note(&format_args!("cycle {number}: the motors stand at the end of it already"));
        }
    }

    /// A motor is home.
    pub fn home(&mut self, number: usize, motor: u8, seconds: f64) {
        self.cycles.push(json!({ "seconds": seconds, "error": null }));
        if self.format == PlayFormat::List {
            let name = self.name(motor);
            self.voice.note(&format_args!("cycle {number}: {name} is home after {seconds:.3} s"));
        }
    }

    /// Why a cycle did not start: the motor by its name in the file.
    pub fn refused(&self, refusal: Refusal, at: Range<usize>) -> PlayError {
        let name = refusal.motor().map_or("", |motor| self.name(motor));
        let failure = self.text.blame(at, refusal.named(name));
        if name.is_empty() { failure } else { failure.motor(name) }
    }

    /// Why a cycle was cancelled.
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

    /// A cycle that has not ended by itself.
    pub fn endless(&self, number: usize, limit: u64, at: Range<usize>) -> PlayError {
        let what = format!("cycle {number} has not ended after {limit} s");
        self.text.blame(at, what).hint("give finish-s, or a longer --limit")
    }

    /// What became of a cycle, for json and standard error.
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

    /// What became of all of it.
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

    /// A time in µs, as exact as the timer is.
    pub fn micros(&self, ticks: u64) -> String {
        micros(ticks, self.plan.rate)
    }

    /// Ticks of this many µs.
    pub fn ticks(&self, us: u64) -> u64 {
        (u128::from(us) * u128::from(self.plan.rate.hz()) / 1_000_000) as u64
    }

    /// Seconds of this many ticks.
    pub fn seconds(&self, ticks: u64) -> f64 {
        ticks as f64 / f64::from(self.plan.rate.hz())
    }
}
