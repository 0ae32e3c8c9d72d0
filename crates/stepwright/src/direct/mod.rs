//! The law in the interrupt itself: Austin's ramp, a step at a time.
//!
//! Nothing in the foreground can hold up a motor that is fed like this: each
//! interval is computed after the pulse before it has been emitted, and loaded
//! one step later. The price is a division a step.
//!
//! ```text
//!   STEP    ┌───┐             ┌───┐
//!        ───┘   └─────────────┘   └──────
//!           │ load c(n)       │ load c(n+1)
//!           └── compute c(n+1)└── compute c(n+2)
//! ```
//!
//! | file | what |
//! | --- | --- |
//! | [`ramp`] | the law |
//! | [`feed`] | the law as a feed of the engine |
//! | [`motors`] | the foreground's half: orders, refusals, braking |
//! | `short` | on an AVR: all of that for one axis in assembly, 320 cycles a step |

pub mod feed;
pub mod motors;
pub mod ramp;
#[cfg(target_arch = "avr")]
mod short;
#[cfg(target_arch = "avr")]
mod short_text;

pub use feed::Direct;
pub use motors::{Motors, Steering};
pub use ramp::Ramp;
