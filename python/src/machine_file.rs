//! Machine files for Python.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use stepwright_machine::{Machine, Values, lease};

/// Keys with their values as texts.
type Texts = Vec<(&'static str, String)>;

fn texts(values: Values) -> Texts {
    values.into_iter().map(|(key, text)| (key.name, text)).collect()
}

/// The values of a machine file: those of the board, and those of each axis by its number.
#[pyfunction]
pub fn read_machine(text: &str) -> PyResult<(Texts, Vec<(u8, Texts)>)> {
    let machine = Machine::parse(text);
    let machine = machine.map_err(|misread| PyValueError::new_err(misread.to_string()))?;
    let axes = machine.axes().iter().map(|(axis, values)| (axis.number(), texts(values.clone())));
    Ok((texts(machine.board()), axes.collect()))
}

/// The time of a lease in s: 0.5 for `500ms`.
#[pyfunction]
pub fn read_lease(text: &str) -> PyResult<f64> {
    let lease = lease(text).map_err(PyValueError::new_err)?;
    Ok(f64::from(lease.get()) / 1e3)
}
