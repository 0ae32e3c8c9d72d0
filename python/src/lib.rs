//! The native half of the Python package `stepwright_motion`: a board kept by a separate thread, units, and
//! recordings. Users call the Python half in `stepwright_motion/`.
//!
//! ```text
//!   Board, Axis, Move (Python) ─► Kept, Ticket ─► Desk ◄─► thread: Keeper, Session ─► a board
//! ```
//!
//! | module | what |
//! | --- | --- |
//! | `kept` | the classes that Python holds |
//! | `desk` | the desk between Python's threads and the board's |
//! | `ticket` | a given order and its result |
//! | `keeping` | the board's thread |
//! | `track` | the data of a recorder |
//! | `units` | texts with units, as steps |
//! | `machine_file` | the values of `stepwright.toml` |
//! | `plan`, `gcode` | planned travels and jobs |
//! | `run`, `jobs`, `cycles` | runs of files: jobs, paths, cycles |
//!
//! Requests and answers are those of `stepwright serve`, as JSON: one list of requests for HTTP, JavaScript and
//! Python.

#![deny(unsafe_code)]

mod bell;
mod cycles;
mod desk;
mod gcode;
mod jobs;
mod keeping;
mod kept;
mod machine_file;
mod plan;
mod run;
mod ticket;
mod track;
mod units;

use pyo3::prelude::*;

/// The native module of `stepwright_motion`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("VERSION", env!("CARGO_PKG_VERSION"))?;
    module.add("LOST", keeping::LOST)?;
    module.add_class::<kept::Kept>()?;
    module.add_class::<kept::Order>()?;
    module.add_class::<kept::Recorder>()?;
    module.add_class::<units::Scale>()?;
    module.add_class::<plan::Planned>()?;
    module.add_function(wrap_pyfunction!(machine_file::read_machine, module)?)?;
    module.add_function(wrap_pyfunction!(machine_file::read_lease, module)?)?;
    module.add_class::<gcode::Job>()?;
    module.add_class::<run::Run>()?;
    module.add_function(wrap_pyfunction!(jobs::walk, module)?)?;
    module.add_function(wrap_pyfunction!(cycles::play_cycles, module)?)?;
    module.add("PHASES", plan::PHASES.map(|phase| phase.name()))?;
    Ok(())
}
