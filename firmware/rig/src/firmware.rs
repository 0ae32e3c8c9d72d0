//! The paths of the firmwares that the rig runs.

use std::env;
use std::path::PathBuf;

use anyhow::{Context, Result};

use crate::board::Board;
use crate::elf::Image;

/// The folder with `uno.elf`, `uno-bench.elf`, `mega.elf` and so on.
pub const FOLDER: &str = "STEPWRIGHT_FIRMWARE";

/// The file of a firmware, such as `uno`, `uno-bench`, `mega`, `uno-case1`.
pub fn path(name: &str) -> PathBuf {
    let folder = env::var_os(FOLDER).map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/firmware")),
        PathBuf::from,
    );
    folder.join(name).with_extension("elf")
}

/// Reads a firmware.
///
/// # Errors
/// It is missing; the text says how to build it.
pub fn load(name: &str) -> Result<Image> {
    let (rest, bench) = match name.strip_suffix("-bench") {
        Some(rest) => (rest, " --bench"),
        None => (name, ""),
    };
    let (board, timer) = match rest.split_once("-timer") {
        Some((board, number)) => (board, format!(" --timer {number}")),
        None => (rest, String::new()),
    };
    // One chore builds all programs of a board.
    let board = board.split('-').next().unwrap_or(board);
    Image::read(&path(name)).with_context(|| {
        format!(
            "build it with `cargo xtask firmware {board}{timer}{bench}`; \
             {FOLDER} names the folder if it is not target/firmware"
        )
    })
}

/// The board's own firmware, for tests.
///
/// # Panics
/// It is missing.
pub fn built(board: Board) -> Image {
    load(board.name()).unwrap_or_else(|error| panic!("{error:#}"))
}
