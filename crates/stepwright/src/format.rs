//! How entries are held and played: the widths in which an 8-bit chip differs from all others.
//!
//! Both files have the same names. The feature `compact` chooses: entries of 11 bytes, whose
//! waits have 8 bits behind the point, as step interrupts in assembly play them; without it an
//! entry is its run to the last bit, and waits have the width of any counter.

#[cfg(not(feature = "compact"))]
#[path = "format/exact.rs"]
mod chosen;

#[cfg(feature = "compact")]
#[path = "format/compact.rs"]
mod chosen;

pub(crate) use chosen::*;
