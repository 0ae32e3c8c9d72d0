//! Jobs on a board that plays streams.

use stepwright_host::link::serial::Share;
use stepwright_path::AxisPace;
use stepwright_plan::gcode::JobPlan;
use stepwright_play::stream::{GREETING, Streamed, StreamedBoard, spelt};

use super::terminal::Terminal;
use crate::cycle::voice::Aloud;
use crate::failure::Failure;
use crate::order::target::{self, PortArgs};
use crate::say;

/// Opens the port for a command, and waits until nothing moves.
pub fn meet(port: &PortArgs, command: &str) -> Result<StreamedBoard, Failure> {
    let mut session = port.open(command, Share::Alone)?;
    StreamedBoard::wake(&mut session);
    let about = target::met_program(&mut session, GREETING, |_| "stream")?;
    Ok(StreamedBoard::met(session, &about, port.baud, &Aloud)?)
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
    Ok(board.play(job, axes, plan, &mut Terminal::new(plan))?)
}
