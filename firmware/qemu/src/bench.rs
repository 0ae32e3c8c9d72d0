//! The costs of the controller on a chip of 32 bits: the rows of `bench/cortex-m.json`. Rows that
//! begin with `m4_` are for a Cortex-M4 (`firmware/mps2`), the others for the micro:bit's
//! Cortex-M0.
//!
//! The shipped firmware gets orders over its line, at the pace of the chip; the plugin counts each
//! visit of the step interrupt. At that pace a pulse of 2 µs is over when all other work is done,
//! so no visit waits for one.

use std::env;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSection, ObjectSymbol};
use serde_json::{Value, json};

use crate::boards::{CORTEX_M4, NRF51, Simulated};
use crate::machine::{Machine, Pace, firmware, symbol};

/// One figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The measured quantity, as in the documentation.
    pub name: &'static str,
    /// The moving axes.
    pub axes: u8,
    /// The figure.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
}

/// A visit: instructions and cycles of a Cortex-M0, without the 32 of its entry and its end.
type Visit = (f64, f64);

/// The step interrupt in a board's firmware: its first instruction.
struct Handler {
    board: &'static Simulated,
    entry: u64,
}

impl Handler {
    fn of(board: &'static Simulated, name: &str) -> Result<Handler> {
        // The lowest bit marks Thumb code.
        Ok(Handler { board, entry: symbol(board, "controller", name)?.start & !1 })
    }
}

/// The linked program: bytes of flash, of static RAM, the end of that, and the interrupt.
struct Image {
    flash: u64,
    ram: u64,
    ram_end: u64,
    stack_top: u64,
    handler: Handler,
}

impl Image {
    fn of(elf: &Path) -> Result<Image> {
        let data = fs::read(elf)?;
        let file = object::File::parse(&*data)?;
        let size = |name: &str| file.section_by_name(name).map_or(0, |section| section.size());
        let end = |name: &str| {
            let section = file.section_by_name(name);
            section.map_or(0, |section| section.address() + section.size())
        };
        let symbol = |name: &str| {
            let found = file.symbols().find(|symbol| symbol.name() == Ok(name));
            found.with_context(|| format!("no symbol {name}"))
        };
        let ram = [".data", ".bss", ".uninit"];
        Ok(Image {
            flash: [".vector_table", ".text", ".rodata", ".data"].map(size).iter().sum(),
            ram: ram.map(size).iter().sum(),
            ram_end: ram.map(end).into_iter().max().unwrap_or(0),
            stack_top: symbol("_stack_start")?.address(),
            handler: Handler::of(&NRF51, "TIMER0")?,
        })
    }
}

/// Makes the controller carry out orders. Returns all visits of its step interrupt from the first
/// step on.
fn visits(handler: &Handler, order: &str) -> Result<Vec<Visit>> {
    let out = env::temp_dir().join(format!("stepwright-visits-{}", std::process::id()));
    let Handler { board, entry } = *handler;
    let task = format!("entry={entry},out={}", out.display());
    let mut chip = Machine::watched(board, "controller", Pace::Chip, &task, &[])?;
    carry_out(&mut chip, order)?;
    drop(chip);
    let text = fs::read_to_string(&out)?;
    fs::remove_file(&out)?;
    let visit = |line: &str| {
        let (instructions, cycles) = line.split_once(' ')?;
        Some((instructions.parse().ok()?, cycles.parse().ok()?))
    };
    text.lines().map(|line| visit(line).with_context(|| format!("a visit: {line}"))).collect()
}

/// Sends lines that must all be accepted, and waits for rest; no step may be late.
fn carry_out(chip: &mut Machine, order: &str) -> Result<()> {
    for line in order.split_whitespace() {
        let answer = chip.ask(line)?;
        ensure!(answer == "Y", "{line} of {order}: {answer}, {}", chip.ask("?")?);
    }
    chip.rest()?;
    let health = chip.ask("?")?;
    ensure!(health.contains(" late=0 "), "{health}");
    Ok(())
}

/// The median.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut all: Vec<f64> = values.collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Steps at one speed, from the first to the last; or a ramp up, and one down.
struct Case {
    /// The names of its rows: instructions and cycles of a Cortex-M0, instructions of a Cortex-M4.
    names: [&'static str; 3],
    axes: u8,
    order: &'static str,
    steps: f64,
}

const STEADY: [&str; 3] = ["steady_step", "steady_step_cycles", "m4_steady_step"];
const RAMP: [&str; 3] = ["ramp_step", "ramp_step_cycles", "m4_ramp_step"];

const CASES: [Case; 4] = [
    Case { names: STEADY, axes: 1, order: "PO s4000 t4000 a1000 d1000 G+2000 E", steps: 2_000.0 },
    Case { names: RAMP, axes: 1, order: "PO s0 t9000 a20000 d20000 G+3000 E", steps: 3_000.0 },
    Case {
        names: STEADY,
        axes: 3,
        order: "PO s2000 t2000 a1000 d1000 G+1500 A2 s1900 t1900 a1000 d1000 G+1400 \
                A3 s1790 t1790 a1000 d1000 G+1300 E",
        steps: 4_200.0,
    },
    Case {
        names: RAMP,
        axes: 3,
        order: "PO s0 t3000 a5000 d5000 G+1500 A2 s0 t2900 a4900 d4900 G+1400 \
                A3 s0 t2800 a4800 d4800 G+1300 E",
        steps: 4_200.0,
    },
];

/// The cost of a step, and the longest visit.
struct Seen {
    instructions: f64,
    cycles: f64,
    worst: f64,
}

impl Seen {
    fn of(handler: &Handler, case: &Case) -> Result<Seen> {
        let visits = visits(handler, case.order)?;
        ensure!(!visits.is_empty(), "{}: no visit of {}", handler.board.name, case.order);
        let [instructions, cycles] = if case.axes == 1 {
            // With one axis a visit is a step.
            [median(visits.iter().map(|visit| visit.0)), median(visits.iter().map(|v| v.1 + 32.0))]
        } else {
            let sum = |of: fn(&Visit) -> f64| visits.iter().map(of).sum::<f64>() / case.steps;
            [sum(|visit| visit.0), sum(|visit| visit.1 + 32.0)]
        };
        let worst = visits.iter().map(|visit| visit.0).fold(0.0, f64::max);
        Ok(Seen { instructions, cycles, worst })
    }
}

/// Measures all rows.
///
/// # Errors
/// A required file is missing, or a travel is not as expected.
pub fn measure() -> Result<Vec<Row>> {
    let image = Image::of(&firmware(&NRF51, "controller")?)?;
    let mut rows = Vec::new();
    let mut row = |name, axes, value: f64, unit| {
        // One decimal, so that the file is readable.
        rows.push(Row { name, axes, value: (value * 10.0).round() / 10.0, unit });
    };
    let mut worst = [0f64; 4];
    for case in &CASES {
        let seen = Seen::of(&image.handler, case)?;
        row(case.names[0], case.axes, seen.instructions, "instructions");
        row(case.names[1], case.axes, seen.cycles, "cycles");
        let most = &mut worst[usize::from(case.axes)];
        *most = most.max(seen.worst);
    }
    row("worst_visit", 1, worst[1], "instructions");
    row("worst_visit", 3, worst[3], "instructions");
    row("flash", 3, image.flash as f64, "bytes");
    row("ram", 3, image.ram as f64, "bytes");
    row("stack", 3, stack(&image)? as f64, "bytes");
    let handler = Handler::of(&CORTEX_M4, "DUALTIMER")?;
    let mut worst = [0f64; 4];
    for case in &CASES {
        let seen = Seen::of(&handler, case)?;
        row(case.names[2], case.axes, seen.instructions, "instructions");
        let most = &mut worst[usize::from(case.axes)];
        *most = most.max(seen.worst);
    }
    row("m4_worst_visit", 1, worst[1], "instructions");
    row("m4_worst_visit", 3, worst[3], "instructions");
    Ok(rows)
}

/// The bound of the stack, in bytes.
const STACK: f64 = 2048.0;

/// Orders of three axes that start, move, and stop; and how often they are given to find the
/// deepest stack. It is deep where interrupts nest, which is random.
const STACKED: [&str; 2] = [
    "PO s0 t3000 a900 d900 j9000 G+900 A2 s0 t2900 a900 d900 G+800 A3 s0 t2800 a900 d900 G-700 E",
    "A1 PO s0 t900 a900 d900 j9000 g+ A2 s0 t900 a900 d900 g- E A1 t700 d500 @-300 A2 a400 t900 A0 Z",
];
const ROUNDS: usize = 10;

/// The deepest stack of three axes that start, move, are queried and stopped.
fn stack(image: &Image) -> Result<u64> {
    let out = env::temp_dir().join(format!("stepwright-stack-{}", std::process::id()));
    let task = format!("stack={},out={}", image.ram_end, out.display());
    let mut chip = Machine::watched(&NRF51, "controller", Pace::Chip, &task, &[])?;
    for order in STACKED.into_iter().cycle().take(ROUNDS * STACKED.len()) {
        carry_out(&mut chip, order)?;
    }
    chip.ask("$")?;
    drop(chip);
    let text = fs::read_to_string(&out)?;
    fs::remove_file(&out)?;
    let lowest: u64 = text.lines().last().context("no store")?.parse()?;
    Ok(image.stack_top - lowest)
}

/// Stores the rows in a file, or compares them with those in it: with `check` it fails if a row is
/// more than 2 % worse, or a different one. The stack, which differs from run to run, is compared
/// with its bound.
///
/// # Errors
/// A worse row, or the file can't be read or written.
pub fn keep(rows: &[Row], file: &Path, check: bool) -> Result<()> {
    let json = |row: &Row| json!({"name": row.name, "axes": row.axes, "value": row.value, "unit": row.unit});
    if !check {
        let lines: Vec<_> = rows.iter().map(|row| format!("  {}", json(row))).collect();
        return Ok(fs::write(file, format!("[\n{}\n]\n", lines.join(",\n")))?);
    }
    let text = fs::read_to_string(file).with_context(|| file.display().to_string())?;
    let stored: Vec<Value> = serde_json::from_str(&text)?;
    ensure!(
        stored.len() == rows.len(),
        "{} rows are stored, {} measured",
        stored.len(),
        rows.len()
    );
    let mut worse = 0;
    for (row, stored) in rows.iter().zip(&stored) {
        ensure!(stored["name"] == row.name && stored["axes"] == row.axes, "another row: {stored}");
        let before = stored["value"].as_f64().context("a value")?;
        let most = if row.name == "stack" { STACK } else { before * 1.02 };
        if row.value > most {
            println!("{} of {}: {} {}, stored {before}", row.name, row.axes, row.value, row.unit);
            worse += 1;
        }
    }
    if worse > 0 { bail!("{worse} figures are worse than the stored ones") } else { Ok(()) }
}
