//! Reads machine files. `stepwright-machine` defines their content.

use std::fs;
use std::path::Path;

pub use stepwright_machine::{About, Key, Machine, Values, readable};

use crate::failure::Failure;
use crate::files;

/// The largest size of a machine file, in bytes.
const MOST: usize = 100_000;

/// The text of a machine file. Pipes are refused, since reading one could wait without end.
pub fn text(path: &Path) -> Result<String, Failure> {
    let about = fs::metadata(path).map_err(|error| Failure::file("read", path, &error))?;
    if !about.is_file() {
        let what = format!("can't read {}: it is no regular file", path.display());
        return Err(Failure::new(what).hint("a machine file is a text file on a disk"));
    }
    files::read(path, MOST)
}

/// Parses this text. `path` is for the message.
pub fn parse(text: &str, path: &Path) -> Result<Machine, Failure> {
    Machine::parse(text).map_err(|misread| {
        let (line, why) = (misread.line, misread.why);
        Failure::new(format!("{}:{line}: {why}", path.display()))
            .hint("`stepwright init --help` says what a machine file has")
            .at(why, line)
    })
}
