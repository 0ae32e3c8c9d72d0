//! Checks that the files of a command line are all different, so that no file is overwritten.

use std::fs;
use std::path::{Path, PathBuf};

use clap::ArgMatches;

use crate::failure::Failure;

/// Arguments that name a file to read: the clap id and the spelling for messages.
const READ: [(&str, &str); 2] = [("file", "FILE"), ("machine", "--machine")];

/// Arguments that name a file to write.
const WRITTEN: [(&str, &str); 4] =
    [("plot", "--plot"), ("xy", "--xy"), ("vcd", "--vcd"), ("mcap", "--mcap")];

/// Refuses a command line in which a file to write is named twice, or is also read. Devices and
/// pipes store nothing and may be named twice.
pub fn apart(matches: &ArgMatches) -> Result<(), Failure> {
    let mut command = matches;
    while let Some((_, deeper)) = command.subcommand() {
        command = deeper;
    }
    let mut named: Vec<(&str, PathBuf)> = Vec::new();
    for (id, option) in READ.into_iter().chain(WRITTEN) {
        // clap returns an error for an id that the command does not have.
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

/// The canonical path of a regular file that exists or will be created. `None` for devices and
/// pipes.
fn place(typed: &Path) -> Option<PathBuf> {
    if let Ok(there) = fs::canonicalize(typed) {
        return there.is_file().then_some(there);
    }
    let folder = typed.parent().filter(|folder| *folder != Path::new(""));
    let folder = fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()?;
    Some(folder.join(typed.file_name()?))
}
