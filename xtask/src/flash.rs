//! `cargo xtask flash`: writes a firmware to a board with avrdude.

use std::ffi::OsString;
use std::process::Command;

use anyhow::Result;

use crate::firmware::{self, Board, Build};
use crate::program::{CONTROLLER, Program};
use crate::setup;
use crate::workspace::{Workspace, run};

/// Build the firmware of a board and write it there.
#[derive(clap::Args)]
pub struct Flash {
    board: Board,
    /// Where the board is: /dev/ttyACM0, /dev/ttyUSB0, COM3 …
    #[arg(long, value_name = "PORT")]
    port: OsString,
    /// Another program than the controller: see `cargo xtask firmware BOARD --list`.
    #[arg(long, value_name = "NAME", default_value = CONTROLLER)]
    program: String,
    /// A Nano from before 2018, whose boot loader listens at 57600 baud.
    #[arg(long)]
    old_boot_loader: bool,
    /// Build it and say what would be done, but leave the board alone.
    #[arg(long)]
    dry_run: bool,
}

impl Flash {
    /// Builds and writes the firmware.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        let program = Program::named(ws, &self.program)?;
        setup::ensure(firmware::NEEDS)?;
        let build = Build { board: self.board, timer: 1, bench: false };
        let hex = build.make(ws, &program)?.hex;

        let mut avrdude = Command::new("avrdude");
        avrdude.args(programmer(self.board, self.old_boot_loader)).arg("-P").arg(&self.port);
        let mut flash = OsString::from("flash:w:");
        flash.push(hex);
        flash.push(":i");
        avrdude.arg("-U").arg(flash);
        if self.dry_run {
            println!("would run: {}", crate::workspace::line(&avrdude));
            return Ok(());
        }
        setup::ensure(&[setup::AVRDUDE])?;
        run(&mut avrdude)
    }
}

/// avrdude's options for a board's boot loader.
fn programmer(board: Board, old: bool) -> &'static [&'static str] {
    match board {
        Board::Nano if old => &["-p", "m328p", "-c", "arduino", "-b", "57600"],
        Board::Uno | Board::Nano => &["-p", "m328p", "-c", "arduino", "-b", "115200"],
        // -D, because the boot loader can't erase the chip, and need not.
        Board::Mega => &["-p", "m2560", "-c", "wiring", "-b", "115200", "-D"],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values of `boards.txt` of the Arduino AVR boards: `upload.speed` and `upload.protocol`
    /// of uno, nano with its two boot loaders, and mega.
    #[test]
    fn each_boot_loader_has_its_speed() {
        let rate = |board, old| programmer(board, old)[5];
        assert_eq!(rate(Board::Uno, false), "115200");
        assert_eq!(rate(Board::Nano, false), "115200");
        assert_eq!(rate(Board::Nano, true), "57600");
        assert_eq!(rate(Board::Mega, false), "115200");
        assert_eq!(programmer(Board::Mega, false)[3], "wiring");
    }
}
