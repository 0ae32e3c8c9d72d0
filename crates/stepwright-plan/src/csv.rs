//! Comma-separated values, written as they are computed: nothing is collected.

use std::io::{self, Write};

use crate::law::{Closeness, Plan};
use crate::runs;

/// Writes every step, or every run if a fit is given.
///
/// # Errors
/// Errors of the writer.
pub fn write(out: &mut impl Write, plan: &Plan, fit: Option<Closeness>) -> io::Result<()> {
    match fit {
        None => steps(out, plan),
        Some(fit) => list(out, plan, fit),
    }
}

fn steps(out: &mut impl Write, plan: &Plan) -> io::Result<()> {
    writeln!(out, "step,delay,time,speed,phase")?;
    for row in plan.rows() {
        let speed = plan.speed(&row);
        writeln!(out, "{},{},{},{speed},{}", row.step, row.delay, row.time, row.phase.name())?;
    }
    Ok(())
}

fn list(out: &mut impl Write, plan: &Plan, fit: Closeness) -> io::Result<()> {
    writeln!(out, "run,step,interval,add,count,time")?;
    for line in runs::lines(plan, fit) {
        let runs::RunLine { number, step, interval, add, count, end } = line;
        writeln!(out, "{number},{step},{interval},{add},{count},{end}")?;
    }
    Ok(())
}
