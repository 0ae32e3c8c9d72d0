//! Plans travels of stepper motors: every step of a ramp law, before anything moves.
//!
//! ```
//! use stepwright::{Accel, Geometry, Rate, Speed};
//! use stepwright_plan::{LawChoice, PlanLimits, Survey, UNWATCHED};
//! use stepwright_units::Rounded;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let accel = Rounded::of(Accel::from_steps(2000)?, "/s²");
//! let limits = PlanLimits {
//!     rate: Rate::MHZ,
//!     steps: 1000,
//!     decel: accel.clone(),
//!     accel,
//!     top: Rounded::of(Speed::from_steps(1000)?, "/s"),
//! };
//! let law = LawChoice::Trapezoid { start: Rounded::of(Speed::ZERO, "/s") };
//! let plan = law.plan(&limits, &Geometry::new(200)?, UNWATCHED)?;
//! let survey = Survey::of(&plan, UNWATCHED);
//! assert_eq!(plan.rows().count(), 1000);
//! assert!(survey.worst.ticks <= 1.0); // of a tick, against the ideal
//! # Ok(())
//! # }
//! ```
//!
//! ```text
//!   LawChoice ─► Plan ─► Survey ─► text, csv, json   rows, runs, phases
//!   PlanLimits            │
//!                         └─► figure                 svg, png, html
//! ```
//!
//! | module | what |
//! | --- | --- |
//! | `law` | the interface of a ramp law for the outputs |
//! | `laws` | the laws, one file each |
//! | [`survey`] | one walk over the pulses: duration, error, phases, samples |
//! | [`runs`] | the runs for a board |
//! | [`text`], [`csv`], [`json`], [`figure`] | the formats |
//! | [`compare`] | a comparison of several laws |
//! | [`figures`] | the figures of Austin's article, by its [`equations`] |
//! | [`calc`] | calculators: timers, belts, delays, drivers |
//! | [`gcode`] | a G-code job: extents, distances, its time, its steps |
//! | [`sheet`] | facts and a table, as text, CSV or JSON |
//!
//! Delays are measured against `stepwright-oracle`, which shares no code with the core.

#![warn(missing_docs)]
#![forbid(unsafe_code)]

mod asked;
pub mod calc;
pub mod compare;
pub mod csv;
pub mod equations;
mod error;
pub mod figure;
pub mod figures;
pub mod gcode;
pub mod json;
mod law;
mod laws;
pub mod runs;
pub mod sheet;
pub mod survey;
pub mod text;
mod tidy;
mod watch;

pub use asked::{Divide, First, PlanLimits};
pub use compare::Comparison;
pub use error::PlanError;
pub use law::{Closeness, Plan, PlanRow, PlanRows, PlanValue, PlannedLaw, Span};
pub use laws::LawChoice;
pub use laws::change::RampChange;
pub use survey::Survey;
pub use tidy::tidy;
pub use watch::{UNWATCHED, Watch};
