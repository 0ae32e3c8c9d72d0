//! The output formats.

use std::io::{self, Write};

use serde_json::{Value, json};

use stepwright_keeper::mcap::McapWriter;
use stepwright_plan::tidy;
use stepwright_sim::vcd::unit;
use stepwright_timed::{Call, Control, Field, Status};

use super::{LoggedDump, TimedCourse, TimedWiring};
use stepwright_plan::sheet::{Cell, Sheet, SheetFormat, quoted};

/// Names of the control's bits, as in the Arduino driver's article.
const CONTROL: [(Control, &str); 7] = [
    (Control::DRV_EN, "DRV_EN"),
    (Control::SPEED_VARIABLE, "SPEED_VARIABLE"),
    (Control::VARIABLE_PWR, "VARIABLE_PWR"),
    (Control::IRQ_TIMING, "IRQ_TIMING"),
    (Control::ENDPOINT_MILLIS, "ENDPOINT_MILLIS"),
    (Control::FASTER, "FASTER"),
    (Control::DIRECTION, "DIRECTION"),
];

/// Names of the status' bits.
const STATUS: [(Status, &str); 7] = [
    (Status::FAULT, "FAULT"),
    (Status::FAULT_CALLED, "FAULT_CALLED"),
    (Status::TIMER_DIV_ERROR, "TIMER_DIV_ERROR"),
    (Status::TIMER_DIV_CALLED, "TIMER_DIV_CALLED"),
    (Status::REACHED, "REACHED"),
    (Status::REACH_CALLED, "REACH_CALLED"),
    (Status::SPIN_FIXED, "SPIN_FIXED"),
];

/// `0xF0 DRV_EN | SPEED_VARIABLE`
fn bits(byte: u8, names: impl Iterator<Item = &'static str>) -> String {
    let names: Vec<_> = names.collect();
    format!("{byte:#04X} {}", names.join(" | ")).trim_end().to_owned()
}

fn control(control: Control) -> String {
    let set = CONTROL.iter().filter(|(bit, _)| control.has(*bit));
    bits(control.bits(), set.map(|(_, name)| *name))
}

fn status(status: Status) -> String {
    let set = STATUS.iter().filter(|(bit, _)| status.has(*bit));
    bits(status.bits(), set.map(|(_, name)| *name))
}

/// The reason of a callback.
pub fn called(call: Call) -> &'static str {
    match call {
        Call::Reached => "position reached",
        Call::Fault => "fault",
    }
}

/// The summary: the order and its result.
pub fn summary(out: &mut impl Write, course: &TimedCourse) -> io::Result<()> {
    let order = &course.order.set_speed;
    let hz = course.hardware.hz();
    let bits = course.hardware.bits();
    let mut sheet = Sheet::new(format!(
        "timed: virtual top {} on a timer of {bits} bits at {hz} Hz",
        order.top
    ));
    sheet.fact("control", "control", control(order.control), "");
    let code = format!("{}: {}", course.code.get(), course.code);
    sheet.fact("code", "result code", code, "");
    sheet.fact("status", "status", status(course.status), "");
    if let Some(made) = course.made {
        sheet.fact("steps", "steps", made as i64, "");
    }
    let (what, clock) = match (course.moving, course.on_board) {
        (true, _) => ("watched for", course.end),
        (false, true) => ("at rest within", course.end),
        (false, false) => ("last step after", course.steps.last().copied().unwrap_or(0)),
    };
    sheet.fact("ms", what, Cell::fixed(course.ms(clock), 3), "ms");
    for (ms, call) in &course.calls {
        sheet.fact("called", "called back", format!("{} at {ms} ms", called(*call)), "");
    }
    sheet.columns = vec![
        ("ms", "from ms"),
        ("steps", "step"),
        ("virtual_top", "virtual top"),
        ("modification", "modification"),
        ("top", "top"),
        ("prescaler", "prescaler"),
        ("speed", "steps/s"),
        ("rpm", "rpm"),
    ];
    for update in &course.updates {
        let speed = update.fitted.nanosteps() as f64 / 1e9;
        sheet.rows.push(vec![
            Cell::fixed(course.ms(update.clock), 3),
            Cell::Whole(update.steps as i64),
            update.top.into(),
            update.modification.into(),
            update.fitted.top().into(),
            update.fitted.prescaler().into(),
            Cell::fixed(speed, 4),
            Cell::fixed(course.rpm(speed), 4),
        ]);
    }
    if course.latched {
        sheet.notes.push(
            "latched: the step after an update lasts the old top at the new prescaler".into(),
        );
    }
    sheet.write(out, SheetFormat::Table)
}

/// Every step in columns.
pub fn table(out: &mut impl Write, course: &TimedCourse) -> io::Result<()> {
    let heads = ("step", "clock", "ms", "delay", "steps/s", "phase");
    let (a, b, c, d, e, f) = heads;
    writeln!(out, "{a:>10}{b:>14}{c:>14}{d:>12}{e:>14}{f:>7}")?;
    for row in course.rows() {
        let (ms, speed) = (course.ms(row.clock), row.speed);
        let (step, clock, delay, phase) = (row.step, row.clock, row.delay, row.phase);
        writeln!(out, "{step:>10}{clock:>14}{ms:>14.4}{delay:>12}{speed:>14.3}{phase:>7}")?;
    }
    Ok(())
}

/// Every step; times in clocks. With a drive the level of each of its pins after the step.
pub fn csv(out: &mut impl Write, course: &TimedCourse, wiring: &TimedWiring) -> io::Result<()> {
    write!(out, "step,time,delay,speed,phase")?;
    wiring.signals.iter().try_for_each(|signal| write!(out, ",{}", quoted(&signal.name)))?;
    writeln!(out)?;
    let mut changes = course.changes.iter().peekable();
    let mut pins = None;
    for row in course.rows() {
        let (step, clock, delay, speed, phase) =
            (row.step, row.clock, row.delay, row.speed, row.phase);
        write!(out, "{step},{clock},{delay},{speed},{phase}")?;
        while let Some(change) = changes.next_if(|change| change.time <= clock) {
            pins = Some(change);
        }
        if let Some(change) = pins {
            let levels = wiring.signals.iter().map(|signal| u8::from(signal.is_high(change)));
            levels.into_iter().try_for_each(|level| write!(out, ",{level}"))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// The changes of the pins, from the call on: clock, index of the signal, level.
fn edges(course: &TimedCourse, wiring: &TimedWiring) -> impl Iterator<Item = (u64, usize, bool)> {
    let mut before: Vec<Option<bool>> = vec![None; wiring.signals.len()];
    course.changes.iter().flat_map(move |change| {
        let levels = wiring.signals.iter().map(|signal| signal.is_high(change));
        let changed = levels.zip(&mut before).enumerate().filter_map(|(place, (high, before))| {
            (before.replace(high) != Some(high)).then_some((change.time, place, high))
        });
        changed.collect::<Vec<_>>()
    })
}

/// The pins' edges as MCAP, in ns from the call on, rounded down.
pub fn mcap(out: impl Write, course: &TimedCourse, wiring: &TimedWiring) -> io::Result<()> {
    let names: Vec<_> = wiring.signals.iter().map(|one| one.name.replace(' ', "_")).collect();
    let words = "the pins of the timed driver's virtual board";
    let mut file = McapWriter::new(out, names.iter().map(String::as_str), [], words)?;
    let hz = u128::from(course.hardware.hz());
    for (clock, place, high) in edges(course, wiring) {
        file.level(place, (u128::from(clock) * 1_000_000_000 / hz) as u64, high)?;
    }
    file.finish().map(drop)
}

/// The pins' edges as a Value Change Dump, from the call on.
pub fn vcd(out: &mut impl Write, course: &TimedCourse, wiring: &TimedWiring) -> io::Result<()> {
    writeln!(out, "$version stepwright {} $end", env!("CARGO_PKG_VERSION"))?;
    let hz = course.hardware.hz();
    let (units, name) = unit(hz.into());
    writeln!(out, "$timescale {name} $end\n$scope module timed $end")?;
    // One letter for each signal: there are at most eight outputs, plus enables and brakes.
    for (letter, signal) in ('a'..).zip(&wiring.signals) {
        writeln!(out, "$var wire 1 {letter} {} $end", signal.name.replace(' ', "_"))?;
    }
    writeln!(out, "$upscope $end\n$enddefinitions $end")?;
    let at = |clock: u64| u128::from(clock) * units / u128::from(hz);
    let mut told = None;
    for (time, place, high) in edges(course, wiring) {
        if told.replace(time) != Some(time) {
            writeln!(out, "#{}", at(time))?;
        }
        let letter = ('a'..).nth(place).unwrap_or('z');
        writeln!(out, "{}{letter}", u8::from(high))?;
    }
    writeln!(out, "#{}", at(course.end))
}

/// The article's dumps in the format of its serial monitor: each line begins with the time after
/// the call.
pub fn dumps(out: &mut impl Write, course: &TimedCourse) -> io::Result<()> {
    for LoggedDump { ms, dump } in &course.dumps {
        let whole = ms.round() as u64;
        let (hours, minutes) = (whole / 3_600_000, whole / 60_000 % 60);
        let (seconds, millis) = (whole / 1000 % 60, whole % 1000);
        for (name, field) in dump.fields() {
            write!(out, "{hours:02}:{minutes:02}:{seconds:02}.{millis:03} -> ")?;
            writeln!(out, "{name}: {field}")?;
        }
    }
    Ok(())
}

/// The dumps as CSV, one a line.
pub fn dumps_csv(out: &mut impl Write, course: &TimedCourse) -> io::Result<()> {
    write!(out, "ms")?;
    let names = stepwright_timed::Dump::default().fields();
    names.iter().try_for_each(|(name, _)| write!(out, ",{name}"))?;
    writeln!(out)?;
    for LoggedDump { ms, dump } in &course.dumps {
        write!(out, "{ms}")?;
        dump.fields().iter().try_for_each(|(_, field)| write!(out, ",{field}"))?;
        writeln!(out)?;
    }
    Ok(())
}

fn field(field: Field) -> Value {
    match field {
        Field::Hex(byte) => json!(byte),
        Field::Number(number) => json!(number),
    }
}

/// The whole result as one JSON object; steps as clocks.
pub fn json(out: &mut impl Write, course: &TimedCourse) -> io::Result<()> {
    let order = &course.order.set_speed;
    let updates = course.updates.iter().map(|update| {
        json!({
            "time": update.clock,
            "steps": update.steps,
            "virtual_top": update.top,
            "modification": update.modification,
            "top": update.fitted.top(),
            "prescaler": update.fitted.prescaler(),
            "speed": update.fitted.nanosteps() as f64 / 1e9,
        })
    });
    let dumps = course.dumps.iter().map(|LoggedDump { ms, dump }| {
        let fields = dump.fields().map(|(name, value)| (name.to_owned(), field(value)));
        let mut members: serde_json::Map<_, _> = fields.into_iter().collect();
        members.insert("ms".into(), json!(ms));
        Value::Object(members)
    });
    let all = json!({
        "control": order.control.bits(),
        "virtual_top": order.top,
        "limit": order.limit,
        "timer_hz": course.hardware.hz(),
        "code": course.code.get(),
        "status": course.status.bits(),
        "moving": course.moving,
        "end": course.end,
        "calls": course.calls.iter().map(|(ms, call)| {
            json!({ "ms": ms, "call": called(*call) })
        }).collect::<Vec<_>>(),
        "updates": updates.collect::<Vec<_>>(),
        "dumps": dumps.collect::<Vec<_>>(),
        "made": course.made,
        "steps": course.steps,
    });
    writeln!(out, "{}", tidy(all))
}
