#![cfg_attr(target_family = "wasm", no_std)]
//! The ramp laws for a web page: the core itself plans a travel, in the page.
//!
//! ```text
//!  numbers ─► PlanOrder ─► law of the core ─► Planner walks every pulse ─► curves, figures
//!  (typed     checked      delays in ticks    keeps at most MOST_POINTS    (typed arrays)
//!   array)    at the edge
//! ```
//!
//! | module | what |
//! | --- | --- |
//! | [`order`] | the numbers of a travel, and their ranges |
//! | [`planner`] | one law's pulses: curves and figures |
//! | [`ideal`] | constant acceleration and limited jerk as formulas, in `f64` |
//! | [`door`] | the functions that a page calls |
//!
//! As WebAssembly it imports nothing. Its panic handler is a function that would have to be imported, so a
//! build without imports has no code that panics: `cargo xtask wasm` checks that.
//!
//! ```
//! use stepwright_wasm::{PlanLaw, PlanOrder, Planner};
//!
//! let order = PlanOrder::check(&PlanOrder::EXAMPLE)?;
//! let mut planner = Planner::new();
//! planner.plan(PlanLaw::Trapezoid, &order)?;
//! assert_eq!(planner.figures().pulses, 4000.0);
//! # Ok::<(), stepwright_wasm::PlanRefusal>(())
//! ```

pub mod door;
pub mod ideal;
mod laws;
pub mod order;
pub mod planner;

pub use order::{PlanField, PlanLaw, PlanOrder, PlanRefusal};
pub use planner::{Figures, Planner};
