//! Figures of the firmware, measured on the simulated chip.
//!
//! | module | what |
//! | --- | --- |
//! | `table` | rows, their bounds, the stored file |
//! | `job` | a travel on a chip that is watched |
//! | `rates` | the highest rates without a late step |
//! | `cycles` | cycles of steps, of planning, with interrupts off |
//! | `accuracy` | how near edges come to the ideal |
//!
//! All rates and cycles are those of the bench build: it spends the 4 cycles
//! of an interrupt's entry that simavr leaves out, and lifts the refusal of
//! what is too fast. Sizes are those of the ordinary build.

mod accuracy;
mod cycles;
mod job;
mod rates;
mod table;

use std::sync::Mutex;

use anyhow::Result;

use crate::board::Board;
use crate::elf::Image;
use crate::firmware;

pub use table::{Row, Table};

/// The firmwares of one board.
#[derive(Clone, Debug)]
struct Subject {
    board: Board,
    bench: Image,
    plain: Image,
    /// Rates of an earlier run, to begin the search with.
    known: Table,
}

/// One measurement: some rows.
type Measure = fn(&Subject) -> Result<Vec<Row>>;

/// Those that say something soon come first.
const MEASURES: &[Measure] = &[
    cycles::sizes,
    cycles::isolated,
    accuracy::alone,
    cycles::three_axes,
    accuracy::with_traffic,
    rates::one,
    rates::three,
    rates::two,
    rates::constant,
];

/// Measures everything.
///
/// # Errors
/// A firmware is missing, or does not do what it is told.
pub fn measure(board: Board, known: Table) -> Result<Table> {
    let bench = firmware::load(&format!("{board}-bench"))?;
    let plain = firmware::load(board.name())?;
    let subject = Subject { board, bench, plain, known };
    let next = Mutex::new(MEASURES.iter());
    let rows = Mutex::new(Vec::new());
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let Some(measure) = next.lock().expect("no panic").next() else { return };
                    let result = measure(&subject);
                    match &result {
                        Ok(rows) => rows.iter().for_each(|row| eprintln!("{row}")),
                        Err(error) => eprintln!("{error:#}"),
                    }
                    rows.lock().expect("no panic").push(result);
                }
            });
        }
    });
    // What failed has been said, and its rows are complained of as missing.
    let measured = rows.into_inner().expect("no panic").into_iter();
    Ok(Table::new(measured.flatten().flatten().collect()))
}
