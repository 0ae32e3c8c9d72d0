//! The board's line on standard input and output.

use std::io::{self, IsTerminal, Write};
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use super::Board;
use crate::failure::Failure;
use crate::{files, interrupt, say};
use stepwright_host::link::simulated::Simulated;

/// The interval of the checks for Ctrl-C, and the longest time that passes at once.
const SLICE: Duration = Duration::from_millis(10);

/// Carries out the input until it ends, then runs to rest.
pub fn serve(board: &mut Board) -> Result<(), Failure> {
    let typed = io::stdin().is_terminal();
    if typed {
        say::note(
            "a virtual board: type lines of the serial protocol, like PO, S5, T100, R200, \
             G+4000, E, F, V1; Ctrl-D ends",
        );
    }
    // The time of a script passes by its bytes; that of a person's input does not.
    let by_bytes = board.is_fast() && !typed;
    let input = files::standard_input();
    let mut answers = Answers::new();
    let mut last = b'\r';
    loop {
        if interrupt::asked() {
            return Ok(());
        }
        match input.recv_timeout(SLICE) {
            Ok(bytes) => {
                let bytes = bytes
                    .map_err(|error| Failure::new(format!("can't read standard input: {error}")))?;
                for byte in bytes {
                    // At a terminal the Enter key sends LF.
                    let byte = if typed && byte == b'\n' { b'\r' } else { byte };
                    board.receive(byte);
                    answers.receive(board)?;
                    last = if byte == b'\n' { last } else { byte };
                }
            }
            Err(RecvTimeoutError::Timeout) if by_bytes => {}
            Err(RecvTimeoutError::Timeout) => pass(board),
            Err(RecvTimeoutError::Disconnected) => break,
        }
        answers.flush()?;
    }
    rest(board)?;
    if last != b'\r' {
        return Err(Failure::new("the input ends within a line, which was not carried out")
            .hint("end every line with CR (\\r); a line feed is skipped"));
    }
    Ok(())
}

/// Lets time pass while there is no input.
fn pass(board: &mut Board) {
    if !board.is_fast() {
        board.catch_up();
    } else if board.board.is_busy() {
        board.pass(SLICE);
    }
}

/// Runs until all axes are at rest. Brakes axes that run without end.
fn rest(board: &mut Board) -> Result<(), Failure> {
    let endless = board.board.is_endless();
    if endless {
        say::note("at the end of the input a motor runs without end: braking it");
        board.board.stop();
    }
    while board.board.is_busy() && !interrupt::asked() {
        board.pass(SLICE);
    }
    if endless {
        return Err(Failure::new("the input left a motor running without end")
            .hint("end a script that has a g with Z"));
    }
    Ok(())
}

/// Writes the board's answers to standard output: unchanged, or with line feeds at a terminal.
struct Answers {
    out: io::Stdout,
    read: bool,
}

impl Answers {
    fn new() -> Answers {
        let out = io::stdout();
        let read = out.is_terminal();
        Answers { out, read }
    }

    fn receive(&mut self, board: &mut Board) -> Result<(), Failure> {
        for byte in board.board.take_answers() {
            let bytes: &[u8] = if self.read && byte == b'\r' { b"\r\n" } else { &[byte] };
            self.out.write_all(bytes).map_err(closed)?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), Failure> {
        self.out.flush().map_err(closed)
    }
}

fn closed(error: io::Error) -> Failure {
    Failure::new(format!("can't write answers to standard output: {error}"))
}
