//! JSON: the summary as one object. Its last member lists the steps or runs, one a line, written as they
//! are computed.

use std::io::{self, Write};

use serde_json::{Value, json};

use crate::tidy;
use stepwright_units::MachineUnit;

use crate::law::{Closeness, Plan, PlanRow, PlanValue};
use crate::runs::{self, RunLine};
use crate::survey::{PhasePart, Survey, Worst};

/// The members of an object in their order. `json!` would lose the order.
type Members = Vec<(&'static str, Value)>;

/// Writes the whole plan.
///
/// # Errors
/// Errors of the writer.
pub fn write(
    out: &mut impl Write,
    plan: &Plan,
    survey: &Survey,
    fit: Option<Closeness>,
    unit: Option<MachineUnit>,
) -> io::Result<()> {
    writeln!(out, "{{")?;
    members(out, summary(plan, survey))?;
    if let Some(unit) = unit {
        members(out, vec![("in_unit", shown(plan, unit))])?;
    }
    list(out, "values", plan.values.iter().map(value))?;
    writeln!(out, ",")?;
    list(out, "phases", survey.parts.iter().map(phase))?;
    writeln!(out, ",")?;
    match fit {
        None => list(out, "rows", plan.rows().map(|row| step(plan, &row)))?,
        Some(fit) => {
            members(out, total(&runs::total(plan, fit)))?;
            list(out, "runs", runs::lines(plan, fit).map(|line| run(&line)))?;
        }
    }
    writeln!(out, "\n}}")
}

fn summary(plan: &Plan, survey: &Survey) -> Members {
    let law = plan.law.as_ref();
    let Worst { ticks, step, checked } = survey.worst;
    vec![
        ("law", json!(plan.name)),
        ("steps", json!(law.pulses())),
        ("timer_hz", json!(plan.rate.hz())),
        ("note", json!(plan.note)),
        ("duration_ticks", json!(survey.duration)),
        ("duration_s", json!(plan.seconds(survey.duration as f64))),
        ("peak_speed", json!(law.peak())),
        ("braking_steps", json!(law.braking())),
        ("largest_error_ticks", json!(ticks)),
        ("largest_error_step", json!(step)),
        ("checked_steps", json!(checked)),
    ]
}

/// The numbers of the summary that count steps, in the unit of the machine.
fn shown(plan: &Plan, unit: MachineUnit) -> Value {
    let law = plan.law.as_ref();
    json!({
        "unit": unit.name,
        "distance": f64::from(law.pulses()) / unit.steps,
        "peak_speed": law.peak() / unit.steps,
        "braking_distance": f64::from(law.braking()) / unit.steps,
    })
}

fn value(value: &PlanValue) -> Members {
    vec![
        ("name", json!(value.name)),
        ("given", json!(value.given)),
        ("held", tidy(json!(value.held))),
        ("unit", json!(value.unit)),
    ]
}

fn phase(part: &PhasePart) -> Members {
    vec![
        ("phase", json!(part.phase.name())),
        ("steps", json!(part.pulses)),
        ("ticks", json!(part.ticks)),
    ]
}

fn step(plan: &Plan, row: &PlanRow) -> Members {
    vec![
        ("step", json!(row.step)),
        ("delay", json!(row.delay)),
        ("time", json!(row.time)),
        ("speed", tidy(json!(plan.speed(row)))),
        ("phase", json!(row.phase.name())),
    ]
}

fn total(total: &runs::RunTotal) -> Members {
    let Worst { ticks, step, checked } = total.worst;
    vec![
        ("runs_count", json!(total.runs)),
        ("runs_bytes", json!(total.bytes)),
        ("runs_error_ticks", json!(ticks)),
        ("runs_error_step", json!(step)),
        ("runs_checked_steps", json!(checked)),
    ]
}

fn run(line: &RunLine) -> Members {
    vec![
        ("run", json!(line.number)),
        ("step", json!(line.step)),
        ("interval", json!(line.interval)),
        ("add", json!(line.add)),
        ("count", json!(line.count)),
        ("time", json!(line.end)),
    ]
}

/// Writes members of the outer object, each on its line.
fn members(out: &mut impl Write, members: Members) -> io::Result<()> {
    members
        .into_iter()
        .try_for_each(|(name, value)| writeln!(out, "  \"{name}\": {},", tidy(value)))
}

/// Writes a member that is a list with one object a line, without a line end after it.
fn list(out: &mut impl Write, name: &str, rows: impl Iterator<Item = Members>) -> io::Result<()> {
    write!(out, "  \"{name}\": [")?;
    for (row, i) in rows.zip(0u64..) {
        write!(out, "{}\n    {{", if i == 0 { "" } else { "," })?;
        for (i, (name, value)) in row.iter().enumerate() {
            write!(out, "{}\"{name}\": {value}", if i == 0 { "" } else { ", " })?;
        }
        write!(out, "}}")?;
    }
    write!(out, "\n  ]")
}
