//! A law that is asked step by step: Austin's ramp.
//!
//! Each interval is computed after the pulse before it has been emitted, and loaded
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

pub mod feed;
pub mod ramp;

pub use feed::Direct;
pub use ramp::Ramp;
