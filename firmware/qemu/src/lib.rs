//! Runs the firmware for chips of 32 bits, on boards that QEMU simulates.
//!
//! ```text
//!   lines ─► QEMU's UART ─► controller ─► pins ─► trace ┐
//!                                          plugin ──────┴─► log ─► edges, with their times
//! ```
//!
//! [`Machine`] runs the shipped firmware on a board of [`boards`]; nothing in it depends on being
//! observed. QEMU's trace or an address shows what is written to the pins, the plugin (`plugin/`)
//! shows at which instruction: with `-icount` that is the time. QEMU counts instructions, not
//! cycles: all of them take the same time, [`Pace`].
//!
//! `cargo xtask test --only qemu` builds everything, and runs the tests.

pub mod bench;
pub mod boards;
pub mod edges;
pub mod machine;
pub mod paced;
pub mod virtual_board;

pub use boards::Simulated;
pub use edges::Edge;
pub use machine::{Machine, Pace};
pub use paced::Paced;
