//! Flashes a Raspberry Pi Pico, whose boot loader is a drive.

use serde_json::json;
use stepwright_flash::drive::{BootDrive, DriveError};
use stepwright_flash::{FlashProgram, PicoFirmware};

use super::Args;
use crate::failure::Failure;
use crate::order::progress::Line;
use crate::order::target::Format;
use crate::say;

/// How to make the drive appear.
const BOOTSEL: &str = "hold BOOTSEL while you plug the Pico in: it is a drive RPI-RP2 then";

/// Copies the firmware, and prints what was copied.
pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let program = args.program.name();
    let firmware = PicoFirmware::of(args.program).ok_or_else(|| {
        let there: Vec<_> = PicoFirmware::programs().map(FlashProgram::name).collect();
        Failure::usage(format!("there is no program {program} for a pico"))
            .hint(format!("--program is one of {}", there.join(", ")))
    })?;
    if args.port.is_some() {
        return Err(Failure::usage(
            "a Pico is written through its drive, and --port is a serial port's",
        )
        .hint("leave --port out; --drive PATH says which drive, if there are several"));
    }
    let (bytes, hash) = (firmware.bytes().len(), firmware.hash());
    if args.format == Format::Text {
        say::result(format_args!("image       pico {program}, {bytes} bytes, SHA-256 {hash}"));
    }
    let found = match &args.drive {
        Some(path) => BootDrive::at(path),
        None => BootDrive::find(),
    };
    let found = found.map_err(explain);
    // A dry run needs no board.
    let drive = if args.dry_run { found.ok() } else { Some(found?) };
    if let Some(drive) = drive.as_ref().filter(|_| !args.dry_run) {
        let mut line = Line::new();
        let all = firmware.uf2().len();
        let written = firmware.write(drive, |done| {
            let text = format!("writing {} %", 100 * done / all);
            line.show(&[&text], &text, false);
        });
        line.end();
        written.map_err(explain)?;
    }
    let path = drive.map(|drive| drive.path().display().to_string());
    match args.format {
        Format::Json => say::json(json!({
            "board": "pico",
            "program": program,
            "bytes": bytes,
            "sha256": hash,
            "drive": path,
            "by": "stepwright",
            "state": if args.dry_run { "dry-run" } else { "written" },
        })),
        Format::Text if args.dry_run => match path {
            Some(path) => say::result(format_args!("dry run     would copy it to {path}")),
            None => say::result(format_args!(
                "dry run     would copy it to a drive; none is there: {BOOTSEL}"
            )),
        },
        Format::Text => {
            let path = path.unwrap_or_default();
            say::result(format_args!("written     to {path}, and the board has restarted"));
            let seen = super::seen_with(args.program, "PATH");
            say::note(format_args!("try it with: stepwright ports, then {seen}"));
        }
    }
    Ok(())
}

/// The failure for an error of a drive, with a hint.
fn explain(error: DriveError) -> Failure {
    let hint = match &error {
        DriveError::None | DriveError::NoBootLoader(_) => {
            format!("{BOOTSEL}; --drive PATH says where, if it is mounted elsewhere")
        }
        DriveError::Several(_) => "--drive PATH says which".into(),
        DriveError::Other(..) => "nothing was written. The firmware is for an RP2040 alone".into(),
        DriveError::File(..) | DriveError::Differs(..) => {
            format!("{BOOTSEL}, and write it again")
        }
        DriveError::NotTaken(_) => {
            format!("is it a Pico's own drive, or a copy of one? {BOOTSEL}, and write it again")
        }
    };
    let failure = match &error {
        DriveError::Several(_) => Failure::usage(error.to_string()),
        _ => Failure::new(error.to_string()),
    };
    failure.hint(hint)
}
