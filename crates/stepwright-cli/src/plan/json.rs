//! JSON: the summary as one object, whose last member lists the steps or runs,
//! one a line and written as they come.

use std::io::{self, Write};

use serde_json::{Value, json};
use stepwright::profile::Fit;

use super::law::Plan;
use super::runs;
use super::survey::{Survey, Worst};

/// The whole plan.
pub fn write(
    out: &mut impl Write,
    plan: &Plan,
    survey: &Survey,
    fit: Option<Fit>,
) -> io::Result<()> {
    let law = plan.law.as_ref();
    let rate = plan.rate.hz();
    let values: Vec<_> = plan
        .values
        .iter()
        .map(|v| json!({ "name": v.name, "given": v.given, "held": v.held, "unit": v.unit }))
        .collect();
    let phases: Vec<_> = survey
        .parts
        .iter()
        .map(
            |part| json!({ "phase": part.phase.name(), "steps": part.pulses, "ticks": part.ticks }),
        )
        .collect();
    let mut members = vec![
        ("law", json!(plan.name)),
        ("steps", json!(law.pulses())),
        ("timer_hz", json!(rate)),
        ("values", json!(values)),
        ("note", json!(plan.note)),
        ("duration_ticks", json!(survey.duration)),
        ("duration_s", json!(plan.seconds(survey.duration as f64))),
        ("peak_speed", json!(law.peak())),
        ("braking_steps", json!(law.braking())),
        ("largest_error", error(&survey.worst)),
        ("phases", json!(phases)),
    ];
    if let Some(fit) = fit {
        let total = runs::total(plan, fit);
        members.push((
            "runs_total",
            json!({ "runs": total.runs, "bytes": total.bytes, "largest_error": error(&total.worst) }),
        ));
    }
    writeln!(out, "{{")?;
    for (name, value) in members {
        writeln!(out, "  \"{name}\": {value},")?;
    }
    match fit {
        None => rows(
            out,
            "rows",
            plan.rows().map(|row| {
                json!({
                    "step": row.step,
                    "delay": row.delay,
                    "time": row.time,
                    "speed": plan.speed(&row),
                    "phase": row.phase.name(),
                })
            }),
        )?,
        Some(fit) => rows(
            out,
            "runs",
            runs::lines(plan, fit).map(|line| {
                json!({
                    "step": line.step,
                    "interval": line.interval,
                    "add": line.add,
                    "count": line.count,
                    "time": line.end,
                })
            }),
        )?,
    }
    writeln!(out, "}}")
}

fn error(worst: &Worst) -> Value {
    json!({ "ticks": worst.ticks, "step": worst.step, "checked": worst.checked })
}

/// The last member: an array with one object a line.
fn rows(out: &mut impl Write, name: &str, rows: impl Iterator<Item = Value>) -> io::Result<()> {
    write!(out, "  \"{name}\": [")?;
    for (row, i) in rows.zip(0u64..) {
        write!(out, "{}\n    {row}", if i == 0 { "" } else { "," })?;
    }
    writeln!(out, "\n  ]")
}
