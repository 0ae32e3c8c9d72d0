//! A board whose boot loader is a drive: a Raspberry Pi Pico that was plugged in with BOOTSEL held.
//!
//! A UF2 file that is copied there goes into the flash; with its last block the board restarts, and the
//! drive is gone. By the RP2040's datasheet, "USB Mass Storage Interface".

use std::fmt;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use crate::uf2::BLOCK;

/// What says which board a drive is.
const INFO: &str = "INFO_UF2.TXT";

/// The line of it that a Pico has.
const PICO: &str = "Board-ID: RPI-RP2";

/// The name of the file on the drive.
const FILE: &str = "STEPWRIGHT.UF2";

/// The drive of a Pico in its boot loader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BootDrive {
    path: PathBuf,
}

/// Why nothing was written, or not all.
#[derive(Debug)]
pub enum DriveError {
    /// No drive is a Pico's.
    None,
    /// Several are.
    Several(Vec<PathBuf>),
    /// There is no `INFO_UF2.TXT`, so it is no boot loader's drive.
    NoBootLoader(PathBuf),
    /// It is another board's: what its `INFO_UF2.TXT` says.
    Other(PathBuf, String),
    /// The file could not be written.
    File(PathBuf, io::Error),
    /// What was read back differs, from this byte on.
    Differs(PathBuf, usize),
    /// The file is on the drive, and the board has not restarted.
    NotTaken(PathBuf),
}

impl fmt::Display for DriveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DriveError::None => f.write_str("there is no drive of a Pico in its boot loader"),
            DriveError::Several(paths) => {
                write!(f, "there are {} drives of Picos:", paths.len())?;
                paths.iter().try_for_each(|path| write!(f, " {}", path.display()))
            }
            DriveError::NoBootLoader(path) => {
                write!(f, "{} is no boot loader's drive: there is no {INFO}", path.display())
            }
            DriveError::Other(path, board) => {
                write!(f, "{} is no Pico's drive: {board}", path.display())
            }
            DriveError::File(path, error) => write!(f, "can't write {}: {error}", path.display()),
            DriveError::Differs(path, at) => {
                write!(f, "{} differs from what was written from byte {at} on", path.display())
            }
            DriveError::NotTaken(path) => {
                write!(f, "{} has the firmware, and the board does not restart", path.display())
            }
        }
    }
}

impl std::error::Error for DriveError {}

impl BootDrive {
    /// The drive at a path.
    ///
    /// # Errors
    /// [`NoBootLoader`](DriveError::NoBootLoader), [`Other`](DriveError::Other): it is no Pico's.
    pub fn at(path: &Path) -> Result<BootDrive, DriveError> {
        let info =
            fs::read(path.join(INFO)).map_err(|_| DriveError::NoBootLoader(path.to_path_buf()))?;
        let info = String::from_utf8_lossy(&info);
        if info.lines().any(|line| line.trim() == PICO) {
            return Ok(BootDrive { path: path.to_path_buf() });
        }
        let board = info.lines().find(|line| line.starts_with("Board-ID"));
        let board = board.or(info.lines().next()).unwrap_or("its file is empty").trim();
        Err(DriveError::Other(path.to_path_buf(), board.to_string()))
    }

    /// The one drive of a Pico that this computer has mounted.
    ///
    /// # Errors
    /// [`None`](DriveError::None), [`Several`](DriveError::Several).
    pub fn find() -> Result<BootDrive, DriveError> {
        BootDrive::find_among(&places())
    }

    /// Likewise, among these.
    ///
    /// # Errors
    /// As [`find`](BootDrive::find).
    pub fn find_among(places: &[PathBuf]) -> Result<BootDrive, DriveError> {
        let mut drives: Vec<_> =
            places.iter().filter_map(|path| BootDrive::at(path).ok()).collect();
        match drives.pop() {
            None => Err(DriveError::None),
            Some(drive) if drives.is_empty() => Ok(drive),
            Some(drive) => {
                drives.push(drive);
                Err(DriveError::Several(drives.into_iter().map(|drive| drive.path).collect()))
            }
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Copies a UF2 file there, and waits until the board has taken it: it restarts, and its drive is
    /// gone. `done` gets the bytes written.
    ///
    /// # Errors
    /// [`File`](DriveError::File); [`Differs`](DriveError::Differs) and
    /// [`NotTaken`](DriveError::NotTaken) if the drive is still there after `patience`: a Pico takes
    /// a second.
    pub fn write(
        &self,
        uf2: &[u8],
        patience: Duration,
        mut done: impl FnMut(usize),
    ) -> Result<(), DriveError> {
        let path = self.path.join(FILE);
        let wrong = |error| DriveError::File(path.clone(), error);
        let mut file = File::create(&path).map_err(wrong)?;
        let mut written = 0;
        for block in uf2.chunks(32 * BLOCK) {
            file.write_all(block).map_err(wrong)?;
            written += block.len();
            done(written);
        }
        // With the last block the board restarts, whatever the computer has yet to say to its drive.
        let synced = file.sync_all();
        drop(file);
        let end = Instant::now() + patience;
        while self.is_there() {
            if Instant::now() >= end {
                synced.map_err(wrong)?;
                return Err(self.kept(&path, uf2));
            }
            thread::sleep(Duration::from_millis(50));
        }
        Ok(())
    }

    fn is_there(&self) -> bool {
        BootDrive::at(&self.path).is_ok()
    }

    /// What is wrong with a file that the drive has kept.
    fn kept(&self, path: &Path, uf2: &[u8]) -> DriveError {
        let kept = match fs::read(path) {
            Ok(kept) => kept,
            Err(error) => return DriveError::File(path.to_path_buf(), error),
        };
        let common = kept.iter().zip(uf2).take_while(|(is, right)| is == right).count();
        if common == uf2.len() && kept.len() == uf2.len() {
            return DriveError::NotTaken(self.path.clone());
        }
        DriveError::Differs(path.to_path_buf(), common)
    }
}

/// Where systems mount drives.
fn places() -> Vec<PathBuf> {
    if cfg!(windows) {
        return (b'D'..=b'Z').map(|letter| format!("{}:\\", char::from(letter)).into()).collect();
    }
    let inside = |folder: &Path| -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).collect()
    };
    // Of each user there, and of none.
    let mut all = Vec::new();
    for folder in ["/media", "/run/media", "/Volumes", "/mnt"] {
        for path in inside(Path::new(folder)) {
            all.extend(inside(&path));
            all.push(path);
        }
    }
    all
}
