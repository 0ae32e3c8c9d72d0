//! The representation of entries: the widths in which an 8-bit chip differs from all others.
//!
//! Both files define the same names. The feature `compact` chooses: entries of 11 bytes, whose
//! waits have 8 fractional bits, as step interrupts in assembly play them. Without it an entry
//! equals its run to the last bit, and waits have the width of any counter.

#[cfg(not(feature = "compact"))]
#[path = "format/exact.rs"]
mod chosen;

#[cfg(feature = "compact")]
#[path = "format/compact.rs"]
mod chosen;

pub(crate) use chosen::*;
