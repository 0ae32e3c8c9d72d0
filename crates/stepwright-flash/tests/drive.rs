//! A Pico's drive, played by a folder: it takes a file as the boot loader does, and is gone.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use stepwright_flash::drive::{BootDrive, DriveError};
use stepwright_flash::{FlashProgram, PicoFirmware};

const INFO: &str = "UF2 Bootloader v3.0\r\nModel: Raspberry Pi RP2\r\nBoard-ID: RPI-RP2\r\n";

fn pico() -> PicoFirmware {
    PicoFirmware::of(FlashProgram::Stream).unwrap()
}

fn drive(info: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("INFO_UF2.TXT"), info).unwrap();
    folder
}

/// What a boot loader makes of a file: the flash from 0x1000_0000 on, once all its blocks are there.
fn flashed(path: &Path) -> Option<Vec<u8>> {
    let file = fs::read(path.join("STEPWRIGHT.UF2")).ok()?;
    let (mut flash, mut all) = (Vec::new(), usize::MAX);
    let blocks = file.chunks_exact(512);
    let count = blocks.len();
    for block in blocks {
        let number = |n: usize| u32::from_le_bytes(block[4 * n..4 * n + 4].try_into().unwrap());
        assert_eq!([number(0), number(1), number(127)], [0x0A324655, 0x9E5D5157, 0x0AB16F30]);
        assert_eq!([number(2), number(4), number(7)], [0x2000, 256, 0xE48BFF56]);
        let at = (number(3) - 0x1000_0000) as usize;
        assert_eq!(at, 256 * number(5) as usize);
        flash.resize(flash.len().max(at + 256), 0xFF);
        flash[at..at + 256].copy_from_slice(&block[32..288]);
        all = number(6) as usize;
    }
    (count == all).then_some(flash)
}

/// Waits for the file, and restarts.
fn boot_loader(path: PathBuf) -> thread::JoinHandle<Vec<u8>> {
    thread::spawn(move || {
        loop {
            if let Some(flash) = flashed(&path) {
                fs::remove_file(path.join("INFO_UF2.TXT")).unwrap();
                return flash;
            }
            thread::sleep(Duration::from_millis(5));
        }
    })
}

#[test]
fn the_flash_is_the_image_and_the_board_restarts() {
    let folder = drive(INFO);
    let board = boot_loader(folder.path().into());
    let mut done = 0;
    pico().write(&BootDrive::at(folder.path()).unwrap(), |bytes| done = bytes).unwrap();
    let flash = board.join().unwrap();
    let bytes = pico().bytes();
    assert_eq!(done, bytes.len().div_ceil(256) * 512);
    assert_eq!(flash[..bytes.len()], *bytes);
    assert!(flash[bytes.len()..].iter().all(|byte| *byte == 0));
}

/// The image begins with a boot stage whose last four bytes are its CRC, and with a stack and a start.
#[test]
fn the_image_is_a_program_that_the_chip_begins() {
    let bytes = pico().bytes();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    // By the RP2040's datasheet, "Checksum": polynomial 0x04C11DB7, begun with ones, nothing reflected.
    let crc = bytes[..252].iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte) << 24, |crc, _| {
            crc << 1 ^ if crc >> 31 != 0 { 0x04C1_1DB7 } else { 0 }
        })
    });
    assert_eq!(crc, word(252));
    assert!((0x2000_0000..=0x2004_2000).contains(&word(256)), "its stack: {:#x}", word(256));
    let start = word(260);
    assert!(start & 1 == 1 && (0x1000_0100..0x1020_0000).contains(&start), "{start:#x}");
}

#[test]
fn what_is_no_picos_drive_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let error = BootDrive::at(folder.path()).unwrap_err();
    assert!(error.to_string().ends_with("no boot loader's drive: there is no INFO_UF2.TXT"));
    let other = drive("UF2 Bootloader v1.0\r\nModel: Raspberry Pi RP2350\r\nBoard-ID: RP2350\r\n");
    let error = BootDrive::at(other.path()).unwrap_err();
    assert!(error.to_string().ends_with("is no Pico's drive: Board-ID: RP2350"), "{error}");
    let empty = drive("");
    assert!(matches!(BootDrive::at(empty.path()), Err(DriveError::Other(..))));
}

#[test]
fn one_drive_is_found_and_several_are_asked_about() {
    let (one, two, none) = (drive(INFO), drive(INFO), tempfile::tempdir().unwrap());
    let paths = |folders: &[&tempfile::TempDir]| -> Vec<PathBuf> {
        folders.iter().map(|folder| folder.path().into()).collect()
    };
    let found = BootDrive::find_among(&paths(&[&none, &one])).unwrap();
    assert_eq!(found.path(), one.path());
    let several = BootDrive::find_among(&paths(&[&one, &none, &two])).unwrap_err();
    assert!(matches!(&several, DriveError::Several(all) if all.len() == 2), "{several}");
    assert!(matches!(BootDrive::find_among(&paths(&[&none])), Err(DriveError::None)));
}

#[test]
fn a_drive_that_vanishes_in_the_middle_has_not_taken_it() {
    let folder = drive(INFO);
    let info = folder.path().join("INFO_UF2.TXT");
    let unplug = |_| drop(fs::remove_file(&info));
    let written = pico().write(&BootDrive::at(folder.path()).unwrap(), unplug);
    assert!(matches!(written, Err(DriveError::File(..))), "{written:?}");
}

#[test]
fn a_drive_that_stays_has_not_taken_it() {
    let folder = drive(INFO);
    let there = BootDrive::at(folder.path()).unwrap();
    let write = |patience| there.write(&[7; 1024], Duration::from_millis(patience), |_| ());
    assert!(matches!(write(100), Err(DriveError::NotTaken(_))));
    // Something else has changed it meanwhile.
    let file = folder.path().join("STEPWRIGHT.UF2");
    fs::remove_file(&file).unwrap();
    let spoiler = thread::spawn(move || {
        while fs::metadata(&file).map_or(0, |data| data.len()) < 1024 {
            thread::sleep(Duration::from_millis(5));
        }
        let mut bytes = vec![7; 1024];
        bytes[600] = 8;
        fs::write(&file, bytes).unwrap();
    });
    let error = write(1_500).unwrap_err();
    spoiler.join().unwrap();
    assert!(matches!(error, DriveError::Differs(_, 600)), "{error}");
}

#[test]
fn a_drive_that_takes_no_file_says_so() {
    let folder = drive(INFO);
    // A folder in the file's place.
    fs::create_dir(folder.path().join("STEPWRIGHT.UF2")).unwrap();
    let there = BootDrive::at(folder.path()).unwrap();
    let error = pico().write(&there, |_| ()).unwrap_err();
    assert!(error.to_string().starts_with("can't write "), "{error}");
}
