//! Output for people: the summary, and the steps or runs in columns.

use std::fmt::Display;
use std::io::{self, Write};

use crate::law::{Closeness, Plan};
use crate::runs;
use crate::survey::{Survey, Worst};
use stepwright_plot::time_unit;

/// The number of runs that the summary lists; `--format table` lists all.
const FEW: usize = 20;

/// Writes the values as understood, and the results.
///
/// # Errors
/// Errors of the writer.
pub fn summary(
    out: &mut impl Write,
    plan: &Plan,
    survey: &Survey,
    fit: Option<Closeness>,
) -> io::Result<()> {
    let law = plan.law.as_ref();
    let (steps, hz) = (law.pulses(), plan.rate.hz());
    writeln!(out, "{}: {} on a timer of {hz} Hz\n", plan.name, counted(steps))?;
    for value in &plan.values {
        field(out, value.name, &value.shown)?;
    }
    if let Some(note) = &plan.note {
        writeln!(out, "  ({note})")?;
    }
    writeln!(out)?;
    let seconds = plan.seconds(survey.duration as f64);
    let duration = lasting(seconds, 6);
    field(out, "duration", format_args!("{duration} ({} ticks)", survey.duration))?;
    let short = match plan.short_of() {
        Some(top) => format!(", short of {}: {}", trimmed(top, 3), law.short()),
        None => String::new(),
    };
    field(out, "peak speed", peak(plan) + &short)?;
    field(out, "braking distance", counted(law.braking()))?;
    field(out, "largest error", error(plan, &survey.worst))?;

    if steps > 0 {
        writeln!(out, "\n  {:<10}{:>10}{:>20}", "phase", "steps", "time")?;
    }
    for part in &survey.parts {
        let seconds = plan.seconds(part.ticks as f64);
        writeln!(out, "  {:<10}{:>10}{seconds:>18.6} s", part.phase.name(), part.pulses)?;
    }
    let Some(fit) = fit else { return Ok(()) };

    let total = runs::total(plan, fit);
    writeln!(out)?;
    field(out, "runs", format_args!("{} in {} bytes", total.runs, total.bytes))?;
    field(out, "error of the runs", error(plan, &total.worst))?;
    writeln!(out)?;
    header(out)?;
    for line in runs::lines(plan, fit).take(FEW) {
        columns(out, &line)?;
    }
    match total.runs.saturating_sub(FEW as u64) {
        0 => Ok(()),
        more => writeln!(out, "  … and {more} more: --format table lists them all"),
    }
}

fn field(out: &mut impl Write, name: &str, value: impl Display) -> io::Result<()> {
    writeln!(out, "  {name:<18}{value}")
}

/// `1 step`, `200 steps`
pub fn counted(steps: u32) -> String {
    format!("{steps} step{}", if steps == 1 { "" } else { "s" })
}

/// `400 steps/s (120 rpm)`
pub fn peak(plan: &Plan) -> String {
    let peak = plan.law.peak();
    let rpm = peak * 60.0 / f64::from(plan.steps_per_turn);
    format!("{} steps/s ({} rpm)", trimmed(peak, 3), trimmed(rpm, 2))
}

/// `4.361 s`, `103621.514 s = 28.784 h`
pub fn lasting(seconds: f64, decimals: usize) -> String {
    let (unit, per_second) = time_unit(seconds);
    match per_second < 1.0 {
        true => format!("{seconds:.decimals$} s = {} {unit}", trimmed(seconds * per_second, 2)),
        false => format!("{seconds:.decimals$} s"),
    }
}

/// The value with at most this many decimals.
pub fn trimmed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

fn error(plan: &Plan, worst: &Worst) -> String {
    let Worst { ticks, step, checked } = *worst;
    if step == 0 {
        return "none: nothing moves".into();
    }
    let all = match checked == plan.law.pulses() {
        true => "every step checked".to_owned(),
        false => format!("{checked} steps checked"),
    };
    let micros = plan.seconds(ticks) * 1e6;
    format!("{ticks:.3} ticks ({micros:.3} µs) at step {step}, {all}")
}

/// Writes every step, or every run, in columns.
///
/// # Errors
/// Errors of the writer.
pub fn table(
    out: &mut impl Write,
    plan: &Plan,
    survey: &Survey,
    fit: Option<Closeness>,
) -> io::Result<()> {
    if let Some(fit) = fit {
        header(out)?;
        return runs::lines(plan, fit).try_for_each(|line| columns(out, &line));
    }
    let wide = survey.duration.to_string().len().max("time".len()) + 2;
    writeln!(
        out,
        "{:>10}{:>12}{:>wide$}{:>14}{:>14}  phase",
        "step", "delay", "time", "seconds", "steps/s"
    )?;
    for row in plan.rows() {
        let (seconds, speed) = (plan.seconds(row.time as f64), plan.speed(&row));
        writeln!(
            out,
            "{:>10}{:>12}{:>wide$}{seconds:>14.6}{speed:>14.3}  {}",
            row.step,
            row.delay,
            row.time,
            row.phase.name()
        )?;
    }
    Ok(())
}

fn header(out: &mut impl Write) -> io::Result<()> {
    writeln!(
        out,
        "{:>8}{:>12}{:>18}{:>14}{:>8}{:>20}",
        "run", "from step", "interval", "add", "count", "until"
    )
}

fn columns(out: &mut impl Write, line: &runs::RunLine) -> io::Result<()> {
    let runs::RunLine { number, step, interval, add, count, end } = *line;
    writeln!(out, "{number:>8}{step:>12}{interval:>18.4}{add:>14.4}{count:>8}{end:>20.4}")
}
