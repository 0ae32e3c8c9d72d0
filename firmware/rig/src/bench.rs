//! Figures of the firmware, measured on the simulated chip.
//!
//! | module | content |
//! | --- | --- |
//! | `table` | rows, and the stored file |
//! | `bounds` | the bounds of the rows, and those that are not met yet |
//! | `job` | a travel on an observed chip |
//! | `rates` | the highest rates without a late step |
//! | `steep` | the steepest ramps without a late step |
//! | `behind` | cycles of steps that are already due |
//! | `cycles` | cycles of steps, of planning, with interrupts off |
//! | `accuracy` | the distance of edges from the ideal |
//!
//! All rates and cycles are those of the bench build: it spends the 4 cycles of an interrupt's
//! entry that simavr omits, and does not refuse what is too fast. Sizes are those of the ordinary
//! build.

mod accuracy;
mod behind;
mod bounds;
mod cycles;
mod job;
mod rates;
mod steep;
mod table;

use std::sync::Mutex;

use anyhow::{Result, ensure};

use crate::board::Board;
use crate::elf::Image;
use crate::firmware;

pub use table::{Row, Table};

/// Where the intervals are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// In the foreground, ahead of time.
    Queued,
    /// In the step interrupt, which reads the motors' programs: a motor cycle.
    Cycle,
}

impl Way {
    const fn name(self) -> &'static str {
        match self {
            Way::Queued => "queued",
            Way::Cycle => "cycle",
        }
    }
}

/// A firmware.
#[derive(Clone, Debug)]
struct Builds {
    /// For measurements of time.
    bench: Image,
    /// As flashed.
    plain: Image,
}

/// The firmwares of one board.
#[derive(Clone, Debug)]
struct Subject {
    board: Board,
    queued: Builds,
    cycle: Builds,
    /// Rates of an earlier run, at which the search begins.
    known: Table,
    /// The figures are only compared with those: if a rate is still kept, no higher one is searched
    /// for.
    compare: bool,
}

/// A measurement, and the names of its rows.
type Measure = (fn(&Subject) -> Result<Vec<Row>>, &'static [&'static str]);

/// The quick ones come first.
const MEASURES: &[Measure] = &[
    (cycles::sizes, &["flash", "ram"]),
    (cycles::isolated, &["isolated", "isolated_ramp", "reload"]),
    (accuracy::alone, &["interval_rms", "accel_peak", "accel_peak_deadlines"]),
    (cycles::three_axes, &["planning_burst", "order_burst", "interrupts_off", "stack"]),
    (steep::rows, &["steepest"]),
    (accuracy::with_traffic, &["edge_error_median", "edge_error_99", "edge_error_worst"]),
    (behind::rows, &["back_to_back_constant", "back_to_back_ramp"]),
    (cycles::motor_cycle, &["cycle_step"]),
    (rates::three, &["rate_ramps", "three"]),
    (rates::one, &["rate_ramps", "one"]),
    (rates::constant_three, &["rate_constant"]),
    (rates::two, &["rate_ramps", "two"]),
    (rates::constant_one, &["rate_constant"]),
];

/// Measures everything, or only the measurement with the row `only`. To `compare` with `known`, it
/// does not search above a rate that is still kept: the figure is as good as the stored one.
///
/// # Errors
/// A firmware is missing, or there is no such row. Failures of the firmware are printed, and their
/// rows are missing from the table.
pub fn measure(board: Board, known: Table, compare: bool, only: Option<&str>) -> Result<Table> {
    let wanted = |measure: &&Measure| only.is_none_or(|name| measure.1.contains(&name));
    let measures: Vec<_> = MEASURES.iter().filter(wanted).collect();
    ensure!(!measures.is_empty(), "there is no row {}", only.unwrap_or_default());
    let builds = |name: &str| {
        let bench = firmware::load(&format!("{name}-bench"))?;
        anyhow::Ok(Builds { bench, plain: firmware::load(name)? })
    };
    let queued = builds(board.name())?;
    let cycle = builds(&format!("{board}-cycle"))?;
    let subject = Subject { board, queued, cycle, known, compare };
    let next = Mutex::new(measures.into_iter());
    let rows = Mutex::new(Vec::new());
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let Some((measure, names)) = next.lock().expect("no panic").next() else {
                        return;
                    };
                    let result = measure(&subject);
                    match &result {
                        Ok(rows) => rows.iter().for_each(|row| eprintln!("{row}")),
                        Err(error) => eprintln!("{}: {error:#}", names.join(", ")),
                    }
                    rows.lock().expect("no panic").push(result);
                }
            });
        }
    });
    // Failures have been printed, and their rows will be reported as missing.
    let measured = rows.into_inner().expect("no panic").into_iter();
    Ok(Table::new(measured.flatten().flatten().collect()))
}
