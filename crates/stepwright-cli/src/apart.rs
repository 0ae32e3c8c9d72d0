//! The files of a command line are different ones: none that is read or written is written over.

use std::fs;
use std::path::{Path, PathBuf};

use clap::ArgMatches;

use crate::failure::Failure;

/// What names a file that is read.
const READ: [(&str, &str); 2] = [("file", "FILE"), ("machine", "--machine")];

/// What names a file that is written.
const WRITTEN: [(&str, &str); 4] =
    [("plot", "--plot"), ("xy", "--xy"), ("vcd", "--vcd"), ("mcap", "--mcap")];

/// Refuses a command line by which a file would be written over another one that it names. Devices
/// and pipes keep nothing: they may be named twice.
pub fn apart(matches: &ArgMatches) -> Result<(), Failure> {
    let mut command = matches;
    while let Some((_, deeper)) = command.subcommand() {
        command = deeper;
    }
    let mut named: Vec<(&str, PathBuf)> = Vec::new();
    for (id, option) in READ.into_iter().chain(WRITTEN) {
        // An id that the command has not is an error to clap.
        let Ok(Some(mut values)) = command.try_get_raw(id) else { continue };
        let Some(typed) = values.next().map(Path::new) else { continue };
        let Some(place) = place(typed) else { continue };
        let other = named.iter().find(|(_, path)| *path == place);
        if let (Some((other, _)), true) = (other, WRITTEN.contains(&(id, option))) {
            let what = format!("{other} and {option} are the same file: {}", typed.display());
            return Err(Failure::usage(what).hint(format!("give {option} another name")));
        }
        named.push((option, place));
    }
    Ok(())
}

/// Where a file is, or will be, whatever its path looks like.
fn place(typed: &Path) -> Option<PathBuf> {
    if let Ok(there) = fs::canonicalize(typed) {
        return there.is_file().then_some(there);
    }
    let folder = typed.parent().filter(|folder| *folder != Path::new(""));
    let folder = fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()?;
    Some(folder.join(typed.file_name()?))
}
