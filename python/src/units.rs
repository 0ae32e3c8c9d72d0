//! Converts texts with units to steps, and steps to the unit of an axis.

use std::fmt::Display;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use stepwright::Geometry;
use stepwright_units::{AccelArg, DistanceArg, JerkArg, MachineUnit, MmArg, SpeedArg, TURN};

/// The relation of an axis' steps to turns and millimetres.
#[pyclass(frozen, module = "stepwright_motion._native")]
pub struct Scale {
    pub(crate) geometry: Geometry,
    pub(crate) unit: Option<MachineUnit>,
}

fn wrong(why: impl Display) -> PyErr {
    PyValueError::new_err(why.to_string())
}

fn named(name: &str, text: &str, why: impl Display) -> PyErr {
    PyValueError::new_err(format!("{name} = '{text}': {why}"))
}

#[pymethods]
impl Scale {
    #[new]
    #[pyo3(signature = (steps_per_rev=None, mm_per_rev=None))]
    fn new(steps_per_rev: Option<u32>, mm_per_rev: Option<f64>) -> PyResult<Scale> {
        let mm = mm_per_rev.map(|mm| {
            MmArg::of(mm).ok_or_else(|| {
                wrong(format!("mm_per_rev is {mm}: it may be 0.000001 to 4294.967295 mm"))
            })
        });
        let nm = mm.transpose()?.map(MmArg::nm);
        let geometry = Geometry::new(steps_per_rev.unwrap_or(TURN)).map_err(wrong)?;
        let geometry = match nm {
            Some(nm) => geometry.travelling_nm(nm).map_err(wrong)?,
            None => geometry,
        };
        Ok(Scale { geometry, unit: MachineUnit::of(steps_per_rev, nm) })
    }

    /// The unit of the axis, and its steps.
    #[getter]
    fn unit(&self) -> (&'static str, f64) {
        self.unit.map_or(("steps", 1.0), |unit| (unit.name, unit.steps))
    }

    /// A distance in whole steps.
    fn distance(&self, name: &str, text: &str) -> PyResult<i64> {
        let read: DistanceArg = text.parse().map_err(|why| named(name, text, why))?;
        Ok(read.resolve(&self.geometry, name).map_err(wrong)?.value)
    }

    /// A speed without a sign, in steps/s.
    fn speed(&self, name: &str, text: &str) -> PyResult<f64> {
        let read: SpeedArg = text.parse().map_err(|why| named(name, text, why))?;
        let held = read.resolve(&self.geometry, name).map_err(wrong)?.value;
        Ok(f64::from(held.millisteps()) / 1e3)
    }

    /// An acceleration in steps/s².
    fn accel(&self, name: &str, text: &str) -> PyResult<f64> {
        let read: AccelArg = text.parse().map_err(|why| named(name, text, why))?;
        let held = read.resolve(&self.geometry, name).map_err(wrong)?.value;
        Ok(held.millisteps() as f64 / 1e3)
    }

    /// A jerk in steps/s³.
    fn jerk(&self, name: &str, text: &str) -> PyResult<f64> {
        let read: JerkArg = text.parse().map_err(|why| named(name, text, why))?;
        let held = read.resolve(&self.geometry, name).map_err(wrong)?.value;
        Ok(held.millisteps() as f64 / 1e3)
    }
}
