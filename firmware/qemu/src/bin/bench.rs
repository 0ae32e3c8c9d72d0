//! Measures the controller on a Cortex-M0 and on a Cortex-M4: `bench FILE [--check]`.

use std::env;
use std::path::PathBuf;

use anyhow::{Context, Result};
use stepwright_qemu::bench::{keep, measure};

fn main() -> Result<()> {
    let words: Vec<_> = env::args().skip(1).collect();
    let file = PathBuf::from(words.first().context("a file")?);
    let rows = measure()?;
    println!("{:<20}{:>5}{:>10}  unit", "row", "axes", "value");
    for row in &rows {
        println!("{:<20}{:>5}{:>10}  {}", row.name, row.axes, row.value, row.unit);
    }
    keep(&rows, &file, words.get(1).is_some_and(|word| word == "--check"))
}
