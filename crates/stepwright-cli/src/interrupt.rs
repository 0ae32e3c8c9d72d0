//! Ctrl-C: the first press asks for an orderly end, the second for a hard one.
//!
//! A request to end from elsewhere (SIGTERM, a terminal that is closed) counts
//! as a press: a motor is braked, not left running.

use std::process;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::failure::Failure;
use crate::order::keys;

static PRESSES: AtomicUsize = AtomicUsize::new(0);

/// Exit status of what Ctrl-C ended, as shells have it: 128 + SIGINT.
pub const STATUS: u8 = 130;

/// Whoever presses so often is not being heard: the process ends as it is.
const ENOUGH: usize = 4;

/// Begins to count. From now on Ctrl-C alone no longer ends the process.
pub fn listen() -> Result<(), Failure> {
    ctrlc::set_handler(|| {
        if PRESSES.fetch_add(1, Ordering::Relaxed) + 1 >= ENOUGH {
            keys::restore();
            process::exit(STATUS.into());
        }
    })
    .map_err(|error| Failure::new(format!("can't listen for Ctrl-C: {error}")))
}

/// How often Ctrl-C was pressed.
pub fn presses() -> usize {
    PRESSES.load(Ordering::Relaxed)
}
