//! Jobs on a board that plays streams, for the user at the terminal.

use std::time::{Duration, Instant};

use stepwright_host::link::serial::Share;
use stepwright_path::AxisPace;
use stepwright_plan::gcode::JobPlan;
use stepwright_play::stream::{
    GREETING, JobWatch, Place, PlayWish, Streamed, StreamedBoard, spelt,
};

use super::play::tell;
use crate::cycle::voice::Aloud;
use crate::failure::Failure;
use crate::order::progress::Line;
use crate::order::target::{self, PortArgs};
use crate::{interrupt, say};

/// The time between two reports on a terminal.
const SHOWN: Duration = Duration::from_millis(100);

/// Opens the port for a command, and waits until nothing moves.
pub fn meet(port: &PortArgs, command: &str) -> Result<StreamedBoard, Failure> {
    let mut session = port.open(command, Share::Alone)?;
    StreamedBoard::wake(&mut session);
    let about = target::met_program(&mut session, GREETING, |_| "stream")?;
    Ok(StreamedBoard::met(session, &about, port.baud, &Aloud)?)
}

/// Watches for Ctrl-C, and shows the progress on the terminal.
struct Terminal<'a> {
    plan: &'a JobPlan,
    line: Line,
    shown: Option<Instant>,
    told: bool,
}

impl JobWatch for Terminal<'_> {
    fn wish(&mut self) -> PlayWish {
        if interrupt::presses() >= 2 {
            return PlayWish::Kill;
        }
        if !interrupt::asked() {
            return PlayWish::Go;
        }
        if !std::mem::replace(&mut self.told, true) {
            self.line.note(interrupt::braking());
        }
        PlayWish::Brake
    }

    fn tell(&mut self, place: &Place) {
        if self.shown.is_none_or(|shown| shown.elapsed() > SHOWN) {
            self.shown = Some(Instant::now());
            tell(&mut self.line, place.seconds, self.plan.time, place.wish == PlayWish::Brake);
        }
    }
}

/// Streams a job that has been planned and admitted.
pub fn stream(
    port: &PortArgs,
    job: Vec<u8>,
    axes: [AxisPace; 3],
    plan: &JobPlan,
) -> Result<Streamed, Failure> {
    let mut board = meet(port, "gcode")?;
    if board.places != [Some(0); 3] {
        let (name, at) = (&board.name, spelt(board.places));
        say::note(format_args!(
            "{name} is at {at}: the job takes that place for the machine's zero"
        ));
    }
    let mut terminal = Terminal { plan, line: Line::new(), shown: None, told: false };
    let streamed = board.play(job, axes, plan, &mut terminal);
    terminal.line.end();
    Ok(streamed?)
}
