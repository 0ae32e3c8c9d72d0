//! Text files: reading with a size limit, and replacing as a whole or not at all; standard input as
//! it comes.

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::Path;
use std::sync::mpsc::{self, Receiver};
use std::thread;

use crate::failure::Failure;

/// Reads a file of at most `most` bytes.
pub fn read(path: &Path, most: usize) -> Result<String, Failure> {
    let file = File::open(path).map_err(|error| Failure::file("read", path, &error))?;
    read_from(file, path, most)
}

/// Reads at most `most` bytes of text; longer input is an error, and is not read further. A byte
/// order mark before the text is left out.
pub fn read_from(from: impl Read, path: &Path, most: usize) -> Result<String, Failure> {
    let mut bytes = Vec::new();
    let limit = most as u64 + 1;
    from.take(limit)
        .read_to_end(&mut bytes)
        .map_err(|error| Failure::file("read", path, &error))?;
    if bytes.len() > most {
        let what = format!("can't read {}: it has more than {most} bytes", path.display());
        return Err(Failure::new(what).hint("is it the file that you mean?"));
    }
    if bytes.starts_with("\u{feff}".as_bytes()) {
        bytes.drain(..'\u{feff}'.len_utf8());
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count() + 1;
        let what = format!("can't read {}: line {line} is not text in UTF-8", path.display());
        Failure::new(what).hint(match error.as_bytes() {
            [0xFF, 0xFE, ..] => "it is UTF-16, as Windows PowerShell's > writes: save it as UTF-8",
            _ => "is it the file that you mean?",
        })
    })
}

/// Replaces a file atomically: after a failure it is either the old or the new one, complete.
/// Writes a temporary file in the same folder, then renames it. The permissions are kept, and a
/// link stays a link.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    replace_file(path, bytes).map_err(|error| Failure::file("write", path, &error))
}

fn replace_file(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let before = fs::metadata(&target).ok();
    if before.as_ref().is_some_and(|before| !before.is_file()) {
        // A terminal or a pipe has no old content to protect.
        return fs::write(path, bytes);
    }
    let folder = match target.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".stepwright-");
    // The default permissions of a new file; those of an old file are set below.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    fs::metadata(folder)?;
    // The errors of `tempfile` name the temporary file, which the user does not know.
    let new = builder.tempfile_in(folder);
    let mut new = new.map_err(|error| io::Error::from(error.kind()))?;
    new.as_file_mut().write_all(bytes)?;
    if let Some(before) = before {
        if before.permissions().readonly() {
            return Err(io::ErrorKind::PermissionDenied.into());
        }
        new.as_file().set_permissions(before.permissions())?;
    }
    new.as_file().sync_all()?;
    new.persist(&target).map_err(|failed| failed.error)?;
    // Also syncs the folder, which has the file's name.
    #[cfg(unix)]
    File::open(folder)?.sync_all()?;
    Ok(())
}

/// Reads standard input on a separate thread, because a read can't have a time limit on every
/// system. The channel closes at the end of the input, or after an error.
pub fn standard_input() -> Receiver<io::Result<Vec<u8>>> {
    let (tell, hear) = mpsc::sync_channel(16);
    thread::spawn(move || {
        let mut input = io::stdin().lock();
        let mut buffer = [0; 1024];
        loop {
            let got = match input.read(&mut buffer) {
                Ok(0) => return,
                Ok(count) => Ok(buffer.iter().take(count).copied().collect()),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => Err(error),
            };
            let failed = got.is_err();
            if tell.send(got).is_err() || failed {
                return;
            }
        }
    });
    hear
}
