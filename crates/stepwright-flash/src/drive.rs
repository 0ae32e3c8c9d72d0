//! A board whose boot loader is a drive: a Raspberry Pi Pico that was plugged in with BOOTSEL held.
//!
//! A UF2 file that is copied to the drive is written to the flash. After its last block the board
//! restarts, and the drive disappears. See the RP2040's datasheet, "USB Mass Storage Interface".

use std::fmt;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use crate::uf2::BLOCK;

/// The file that identifies the board of a drive.
const INFO: &str = "INFO_UF2.TXT";

/// The line of [`INFO`] that identifies a Pico.
const PICO: &str = "Board-ID: RPI-RP2";

/// The name of the file on the drive.
const FILE: &str = "STEPWRIGHT.UF2";

/// The drive of a Pico in its boot loader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BootDrive {
    path: PathBuf,
}

/// The error of a firmware that was not written, or not completely.
#[derive(Debug)]
pub enum DriveError {
    /// There is no drive of a Pico.
    None,
    /// There are several drives of Picos.
    Several(Vec<PathBuf>),
    /// The drive has no `INFO_UF2.TXT`, so it is not that of a boot loader.
    NoBootLoader(PathBuf),
    /// The drive of another board, with the identification from its `INFO_UF2.TXT`.
    Other(PathBuf, String),
    /// The file could not be written.
    File(PathBuf, io::Error),
    /// The file that was read back differs, from this byte on.
    Differs(PathBuf, usize),
    /// The file is on the drive, but the board has not restarted.
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
    /// [`NoBootLoader`](DriveError::NoBootLoader), [`Other`](DriveError::Other): the drive is not a
    /// Pico's.
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

    /// Like [`find`](BootDrive::find), among these paths.
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

    /// The path of the drive.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Copies a UF2 file to the drive, and waits until the board has taken it: it restarts, and the
    /// drive disappears. Calls `done` with the number of bytes written.
    ///
    /// # Errors
    /// [`File`](DriveError::File), also if the drive vanishes before its last blocks; [`Differs`](DriveError::Differs) or
    /// [`NotTaken`](DriveError::NotTaken) if the drive is still there after `patience`. A Pico
    /// takes a second.
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
            // A board that vanishes before its last blocks has not taken them. The system keeps blocks for a while.
            if written != 0 && written + block.len() == uf2.len() {
                let synced = file.sync_all();
                if !self.is_there() {
                    return Err(wrong(synced.err().unwrap_or(io::ErrorKind::NotConnected.into())));
                }
            }
            file.write_all(block).map_err(wrong)?;
            written += block.len();
            done(written);
        }
        // After the last block the board restarts, even if the computer still has data for its
        // drive.
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

    /// The error of a file that is still on the drive.
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

/// The paths at which systems mount drives.
fn places() -> Vec<PathBuf> {
    if cfg!(windows) {
        return (b'D'..=b'Z').map(|letter| format!("{}:\\", char::from(letter)).into()).collect();
    }
    let inside = |folder: &Path| -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).collect()
    };
    // Both with and without a folder for each user.
    let mut all = Vec::new();
    for folder in ["/media", "/run/media", "/Volumes", "/mnt"] {
        for path in inside(Path::new(folder)) {
            all.extend(inside(&path));
            all.push(path);
        }
    }
    all
}
