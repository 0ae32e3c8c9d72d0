//! The board's line on a pseudo-terminal.
//!
//! Programs may open and close it at any time. Bytes that the board sends while no program has it
//! open are lost, as on a cable; so are bytes that no program reads for a long time.

use std::io::{self, Write};
use std::thread;
use std::time::Duration;

use super::Board;
use crate::failure::Failure;
use crate::pty::{Pty, SLICE, failed};
use crate::{interrupt, say};
use stepwright_host::link::simulated::Simulated;

/// The most bytes of answers that wait for a reader; the rest is lost.
const WAITING: usize = 64 * 1024;

/// Serves each program that opens the path, until Ctrl-C.
pub fn serve(board: &mut Board) -> Result<(), Failure> {
    let mut pty = Pty::open().map_err(failed)?;
    let mut out = io::stdout().lock();
    // A program may read the path and then close its end of the pipe: keep serving.
    let _ = writeln!(out, "pty {}", pty.path.display()).and_then(|()| out.flush());
    drop(out);
    say::note(format_args!(
        "try it from another terminal: stepwright move 4000 --port {}; Ctrl-C ends the board",
        pty.path.display()
    ));
    let mut waiting: Vec<u8> = Vec::new();
    while !interrupt::asked() {
        let hurry = board.is_fast() && board.board.is_busy();
        let seen = pty
            .wait(!waiting.is_empty(), if hurry { Duration::ZERO } else { SLICE })
            .map_err(failed)?;
        board.receive_since(&seen.bytes);
        waiting.extend(board.board.take_answers());
        waiting.truncate(WAITING);
        if hurry {
            board.pass(SLICE);
        }
        if seen.nobody {
            waiting.clear();
            if !hurry {
                thread::sleep(SLICE);
            }
        } else {
            let sent = pty.write(&waiting).map_err(failed)?;
            waiting.drain(..sent);
        }
    }
    Ok(())
}
