//! Planned travels: a law, its delays and results, as bytes for arrays.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use serde::Deserialize;
use stepwright::profile::Phase;
use stepwright::{Geometry, Jerk, Rate, Speed};
use stepwright_oracle::Number;
use stepwright_plan::{
    Divide, First, LawChoice, Plan, PlanError, PlanLimits, RampChange, Survey, UNWATCHED, figure,
};
use stepwright_plot::PlotFile;
use stepwright_units::{AccelArg, DistanceArg, JerkArg, MachineUnit, Rounded, SpeedArg};

use crate::units::Scale;

/// The phases in the order of their numbers in an array.
pub const PHASES: [Phase; 5] =
    [Phase::Up, Phase::Cruise, Phase::Down, Phase::JerkUp, Phase::JerkDown];

/// The request as JSON. All values are texts, quantities with their units.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    law: String,
    steps: String,
    timer_hz: String,
    accel: Option<String>,
    decel: Option<String>,
    speed: Option<String>,
    start_speed: Option<String>,
    jerk: Option<String>,
    ramp: Option<String>,
    first: Option<String>,
    divisor: Option<String>,
    changes: Option<Vec<[String; 2]>>,
    knee: Option<String>,
    power: Option<String>,
    breaks: Option<String>,
    c0: Option<String>,
    c_min: Option<String>,
}

/// A law with its values. Each request makes a new plan from it, because a plan may belong to a single thread.
enum Chosen {
    Law(LawChoice, PlanLimits),
    Ramp { rate: Rate, steps: u32, start: Rounded<Speed>, top: Rounded<Speed>, ramp: u16 },
    Fixed { rate: Rate, steps: u32, c0: u32, c_min: u32 },
}

/// A planned travel.
#[pyclass(frozen, module = "stepwright_motion._native")]
pub struct Planned {
    chosen: Chosen,
    geometry: Geometry,
    unit: Option<MachineUnit>,
}

fn wrong(why: impl Display) -> PyErr {
    PyValueError::new_err(why.to_string())
}

fn read<T: FromStr<Err: Display>>(name: &str, text: &str) -> PyResult<T> {
    text.parse().map_err(|why| wrong(format!("{name} = '{text}': {why}")))
}

/// A whole number within a range.
fn whole<T>(name: &str, text: &str, range: RangeInclusive<T>) -> PyResult<T>
where
    T: FromStr + PartialOrd + Display,
{
    let held = text.parse().ok().filter(|value| range.contains(value));
    held.ok_or_else(|| {
        let (least, most) = range.into_inner();
        wrong(format!("{name} is {text}: give a whole number, {least} to {most}"))
    })
}

/// The value with this name.
fn named<T: Copy>(name: &str, text: &str, all: &[(&str, T)]) -> PyResult<T> {
    let found = all.iter().find(|(one, _)| *one == text).map(|(_, value)| *value);
    found.ok_or_else(|| {
        let names: Vec<_> = all.iter().map(|(one, _)| *one).collect();
        wrong(format!("{name} is '{text}': it may be {}", names.join(", ")))
    })
}

impl Asked {
    fn needed<'a, T>(&self, name: &str, value: &'a Option<T>) -> PyResult<&'a T> {
        value.as_ref().ok_or_else(|| wrong(format!("the law {} needs {name}", self.law)))
    }

    fn speed(&self, name: &str, text: &str, geometry: &Geometry) -> PyResult<Rounded<Speed>> {
        read::<SpeedArg>(name, text)?.resolve(geometry, name).map_err(wrong)
    }

    fn start(&self, geometry: &Geometry) -> PyResult<Rounded<Speed>> {
        self.speed("start_speed", self.start_speed.as_deref().unwrap_or("0"), geometry)
    }

    fn top(&self, geometry: &Geometry) -> PyResult<Rounded<Speed>> {
        self.speed("speed", self.needed("speed", &self.speed)?, geometry)
    }

    fn steps(&self, geometry: &Geometry) -> PyResult<u32> {
        let held = read::<DistanceArg>("steps", &self.steps)?.resolve(geometry, "steps");
        let held = held.map_err(wrong)?;
        let steps = u32::try_from(held.value).ok().filter(|steps| *steps <= i32::MAX as u32);
        steps.ok_or_else(|| wrong(format!("steps {}: a travel has 0 to 2147483647", held.given)))
    }

    fn limits(&self, rate: Rate, geometry: &Geometry) -> PyResult<PlanLimits> {
        let held = |name: &str, text: &str| {
            read::<AccelArg>(name, text)?.resolve(geometry, name).map_err(wrong)
        };
        let accel = held("accel", self.needed("accel", &self.accel)?)?;
        let decel = self.decel.as_deref().map(|text| held("decel", text)).transpose()?;
        let decel = decel.unwrap_or_else(|| accel.clone());
        Ok(PlanLimits {
            rate,
            steps: self.steps(geometry)?,
            accel,
            decel,
            top: self.top(geometry)?,
        })
    }

    fn jerk(&self, geometry: &Geometry) -> PyResult<Rounded<Jerk>> {
        let text = self.needed("jerk", &self.jerk)?;
        read::<JerkArg>("jerk", text)?.resolve(geometry, "jerk").map_err(wrong)
    }

    fn changes(&self, geometry: &Geometry) -> PyResult<Vec<RampChange>> {
        let mut all = Vec::new();
        for [after, accel] in self.changes.iter().flatten() {
            let held = read::<AccelArg>("changes", accel)?.resolve(geometry, "changes");
            all.push((whole("changes", after, 0..=u32::MAX)?, held.map_err(wrong)?));
        }
        all.sort_by_key(|(after, _)| *after);
        if all.windows(2).any(|pair| pair[0].0 == pair[1].0) {
            return Err(wrong("changes: two after the same step"));
        }
        Ok(all)
    }

    /// A delay in ticks.
    fn ticks(&self, name: &str, value: &Option<String>) -> PyResult<u32> {
        whole(name, self.needed(name, value)?, 1..=0x7FFF_FFFF)
    }

    fn chosen(&self, geometry: &Geometry) -> PyResult<Chosen> {
        let rate = whole("timer_hz", &self.timer_hz, Rate::MIN.hz()..=Rate::MAX.hz())?;
        let rate = Rate::from_hz(rate).map_err(wrong)?;
        let first = self.first.as_deref().unwrap_or("0.676");
        let firsts = [("exact", First::Exact), ("0.676", First::Reduced), ("c1", First::C1)];
        let c0 = named("first", first, &firsts)?;
        let divisor = self.divisor.as_deref().unwrap_or("4n+1");
        let divisor = named("divisor", divisor, &[("4n+1", Divide::FourN), ("2n", Divide::TwoN)])?;
        let law = match self.law.as_str() {
            "trapezoid" => LawChoice::Trapezoid { start: self.start(geometry)? },
            "s-curve" => {
                LawChoice::SCurve { start: self.start(geometry)?, jerk: self.jerk(geometry)? }
            }
            "austin"
                if self.divisor.is_some() && self.changes.iter().flatten().next().is_some() =>
            {
                return Err(wrong("the law austin has a divisor or changes, not both"));
            }
            "austin" => LawChoice::Austin { c0, divisor, changes: self.changes(geometry)? },
            "linear-factor" => {
                let knee = read::<f64>("knee", self.knee.as_deref().unwrap_or("0"))?;
                if !(0.0..=0.9).contains(&knee) {
                    return Err(wrong(format!("knee is {knee}: it may be 0 to 0.9")));
                }
                LawChoice::LinearFactor { c0, knee: (knee * 1e3).round() as u16 }
            }
            "power" => {
                let power = whole("power", self.power.as_deref().unwrap_or("4"), 2..=9)?;
                LawChoice::Power { c0, power }
            }
            "piecewise" => {
                let breaks = whole("breaks", self.breaks.as_deref().unwrap_or("7"), 0..=16)?;
                LawChoice::Piecewise { c0, breaks }
            }
            "ramp" => {
                let (start, top) = (self.start(geometry)?, self.top(geometry)?);
                let ramp = whole("ramp", self.needed("ramp", &self.ramp)?, 1..=u16::MAX)?;
                return Ok(Chosen::Ramp { rate, steps: self.steps(geometry)?, start, top, ramp });
            }
            "austin-fixed" => {
                let c0 = self.ticks("c0", &self.c0)?;
                let c_min = self.ticks("c_min", &self.c_min)?;
                return Ok(Chosen::Fixed { rate, steps: self.steps(geometry)?, c0, c_min });
            }
            other => {
                let names = LawChoice::NAMES.join(", ");
                return Err(wrong(format!(
                    "there is no law '{other}': there are {names}, ramp, austin-fixed"
                )));
            }
        };
        Ok(Chosen::Law(law, self.limits(rate, geometry)?))
    }
}

impl Planned {
    fn plan(&self) -> Result<Plan, PlanError> {
        match &self.chosen {
            Chosen::Law(law, limits) => law.plan(limits, &self.geometry, UNWATCHED),
            Chosen::Ramp { rate, steps, start, top, ramp } => {
                Plan::ramp(*rate, &self.geometry, *steps, start, top, *ramp)
            }
            Chosen::Fixed { rate, steps, c0, c_min } => {
                Plan::austin_fixed(*rate, &self.geometry, *steps, (*c0, *c_min), UNWATCHED)
            }
        }
    }

    /// Calls `part` with the plan, without blocking other threads.
    fn with<T: Send>(&self, py: Python<'_>, part: impl FnOnce(&Plan) -> T + Send) -> PyResult<T> {
        py.detach(|| self.plan().map(|plan| part(&plan))).map_err(wrong)
    }
}

/// An array of `count` numbers with `SIZE` bytes each.
fn filled<'py, const SIZE: usize>(
    py: Python<'py>,
    count: usize,
    values: impl Iterator<Item = [u8; SIZE]>,
) -> PyResult<Bound<'py, PyByteArray>> {
    PyByteArray::new_with(py, count * SIZE, |bytes| {
        for (place, value) in bytes.as_chunks_mut::<SIZE>().0.iter_mut().zip(values) {
            *place = value;
        }
        Ok(())
    })
}

#[pymethods]
impl Planned {
    #[new]
    fn new(asked: &str, scale: &Scale) -> PyResult<Planned> {
        let asked: Asked = serde_json::from_str(asked).map_err(wrong)?;
        let (geometry, unit) = (scale.geometry, scale.unit);
        let planned = Planned { chosen: asked.chosen(&geometry)?, geometry, unit };
        planned.plan().map_err(wrong)?;
        Ok(planned)
    }

    /// The number of pulses, ticks per second, the highest speed in steps/s, and the steps of braking.
    fn facts(&self) -> PyResult<(u32, u32, f64, u32)> {
        let plan = self.plan().map_err(wrong)?;
        Ok((plan.law.pulses(), plan.rate.hz(), plan.law.peak(), plan.law.braking()))
    }

    /// The duration in s, and the largest error of a step in ticks.
    fn survey(&self, py: Python<'_>) -> PyResult<(f64, f64)> {
        self.with(py, |plan| {
            let survey = Survey::of(plan, UNWATCHED);
            (plan.seconds(survey.duration as f64), survey.worst.ticks)
        })
    }

    /// The delay before each pulse in ticks, u32.
    fn delays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyByteArray>> {
        let plan = self.plan().map_err(wrong)?;
        let delays = plan.law.delays().map(u32::to_ne_bytes);
        filled(py, plan.law.pulses() as usize, delays)
    }

    /// The sum of all delays in ticks. For benchmarks: it takes the core's time for a plan, without an array.
    fn walk(&self, py: Python<'_>) -> PyResult<u64> {
        self.with(py, |plan| plan.law.delays().map(u64::from).sum())
    }

    /// The speed in the row of each pulse, in steps/s.
    fn speeds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyByteArray>> {
        let plan = self.plan().map_err(wrong)?;
        let speeds = plan.rows().map(|row| plan.speed(&row).to_ne_bytes());
        filled(py, plan.law.pulses() as usize, speeds)
    }

    /// The phase of each pulse, as an index of `PHASES`.
    fn phases<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyByteArray>> {
        let plan = self.plan().map_err(wrong)?;
        let place = |phase| PHASES.iter().position(|one| *one == phase).unwrap_or(0) as u8;
        filled(py, plan.law.pulses() as usize, plan.rows().map(|row| [place(row.phase)]))
    }

    /// The time of each pulse by the law in s after the first, not rounded to whole ticks.
    fn ideal<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyByteArray>> {
        let plan = self.plan().map_err(wrong)?;
        let pulses = plan.law.pulses();
        let seconds = (0..pulses).map(|n| plan.seconds(plan.law.ideal(n).to_f64()).to_ne_bytes());
        filled(py, pulses as usize, seconds)
    }

    /// The figure as svg.
    fn svg(&self, py: Python<'_>) -> PyResult<String> {
        let unit = self.unit;
        self.with(py, |plan| figure::draw(plan, &Survey::of(plan, UNWATCHED), unit).svg())
    }

    /// Saves the figure to a file: .svg, .png or .html.
    fn save(&self, py: Python<'_>, path: &str) -> PyResult<()> {
        let (unit, file) = (self.unit, read::<PlotFile>("path", path)?);
        let draw = |plan: &Plan| file.save(&figure::draw(plan, &Survey::of(plan, UNWATCHED), unit));
        self.with(py, draw)?.map_err(|error| PyOSError::new_err(error.to_string()))
    }
}
