//! `stepwright stop` and `stepwright kill`: the orders that must get through.

use std::time::Duration;

use serde_json::json;
use stepwright_protocol::{AxisId, Command, Selection};

use super::drive;
use super::look::{self, State};
use super::target::{self, Format, PortArgs};
use crate::failure::Failure;
use crate::interrupt::{self, While};
use crate::link::serial::Share;
use crate::say;
use crate::session::{LinkError, Session};

/// Brake: ramp down, and keep the position
#[derive(clap::Args)]
#[command(after_help = "\
Brakes every axis, or the one of --axis, waits until it rests, and says where.
Ctrl-C while it waits kills. Works also while another program talks to the board.

Example:
  stepwright stop --port /dev/ttyUSB0")]
pub struct StopArgs {
    /// How to write the result
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    port: PortArgs,
    /// Only this axis of the board, 1 to 8; all of them otherwise
    #[arg(long, value_name = "N", value_parser = target::axis, help_heading = "Board")]
    axis: Option<AxisId>,
}

/// Stop every axis dead; the position of one that moved is lost
#[derive(clap::Args)]
#[command(after_help = "\
Works also while another program talks to the board. An axis that was moving has
lost its position: if it stands at a known place, or to go and find one, call it 0
with `stepwright zero`.

Example:
  stepwright kill --port /dev/ttyUSB0")]
pub struct KillArgs {
    /// How to write the result
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    port: PortArgs,
}

/// One of ours leaves the port this soon after its motor was stopped, or stays, as
/// `stepwright serve` does, and lets others in.
const LEAVES: Duration = Duration::from_secs(1);
/// The most that another program may take to notice that its motor was killed.
const CONFIRM: Duration = Duration::from_secs(5);

/// Brakes, and waits until everything rests.
pub fn stop(args: StopArgs) -> Result<(), Failure> {
    interrupt::listen(While::Waiting)?;
    let mut session = args.port.open("stop", Share::Anyhow)?;
    session.kill_at_once();
    let mut urged = session.urge(Command::Brake, Some(LEAVES));
    if urged.is_ok() && !session.link().is_alone() {
        if let Some(mut guest) = args.port.guest() {
            guest.kill_at_once();
            let stopped = brake_all(&mut guest, args.axis)?;
            // Else it has left meanwhile.
            if matches!(stopped, Ok(_) | Err(LinkError::Killed)) {
                return end(&mut guest, &args, stopped);
            }
        }
        urged = session.urge(Command::Brake, None);
    }
    let stopped = match urged {
        Ok(()) => brake_all(&mut session, args.axis)?,
        Err(trouble) => Err(trouble),
    };
    end(&mut session, &args, stopped)
}

/// Says how it ended.
fn end(
    session: &mut Session,
    args: &StopArgs,
    stopped: Result<Vec<State>, LinkError>,
) -> Result<(), Failure> {
    let name = session.link().name();
    match stopped {
        Ok(states) => {
            tell(args.format, &states);
            look::all_known(&name, &states)
        }
        Err(LinkError::Killed) => {
            kill_now(session, &args.port, args.format)?;
            Err(Failure::interrupted("killed instead of braked"))
        }
        Err(trouble) => Err(unsure(&name, &trouble)),
    }
}

/// Meets the board, and brakes.
fn brake_all(
    session: &mut Session,
    only: Option<AxisId>,
) -> Result<Result<Vec<State>, LinkError>, Failure> {
    let met = session.meet();
    if let (Ok(()), Some(axis)) = (&met, only) {
        target::has_axis(session, axis)?;
    }
    Ok(met.and_then(|()| brake_to_rest(session, only)))
}

fn brake_to_rest(session: &mut Session, only: Option<AxisId>) -> Result<Vec<State>, LinkError> {
    let axes = only.map_or(Selection::All, Selection::One);
    drive::brake(session, axes)?;
    while session.is_busy(axes)? {
        session.pause(drive::POLL)?;
    }
    look::states(session, only)
}

/// Kills, without asking first who is there.
pub fn kill(args: KillArgs) -> Result<(), Failure> {
    interrupt::listen(While::Waiting)?;
    let mut session = args.port.open("kill", Share::Anyhow)?;
    kill_now(&mut session, &args.port, args.format)
}

fn kill_now(session: &mut Session, port: &PortArgs, format: Format) -> Result<(), Failure> {
    let name = session.link().name();
    let urged = session.urge(Command::Kill, Some(LEAVES));
    if urged.is_ok()
        && !session.link().is_alone()
        && let Some(mut guest) = port.guest()
        && guest.kill().is_ok_and(|killed| killed)
        && let Ok(states) = guest.meet().and_then(|()| look::states(&mut guest, None))
    {
        tell(format, &states);
        return Ok(());
    }
    match session.urge(Command::Kill, Some(CONFIRM)).and_then(|()| session.kill()) {
        Ok(true) => {}
        Ok(false) => return Err(unsure(&name, &LinkError::Silent)),
        Err(trouble) => return Err(unsure(&name, &trouble)),
    }
    let states = session.meet().and_then(|()| look::states(session, None));
    let states = states.map_err(|trouble| unsure(&name, &trouble))?;
    tell(format, &states);
    Ok(())
}

/// The failure of a stop that was not confirmed.
fn unsure(name: &str, trouble: &LinkError) -> Failure {
    Failure::new(format!("{name}: {trouble}"))
        .hint("the motor may still be moving: look at it, and switch off its power if it is")
}

/// Says where the axes are; those that rest at 0 are left out, but the first.
fn tell(format: Format, states: &[State]) {
    if format == Format::Json {
        return say::result(json!({ "axes": look::json(states) }));
    }
    let Some((first, others)) = states.split_first() else { return };
    for state in others.iter().filter(|state| state.busy || state.position != Some(0)) {
        say::result(format_args!("axis {} {}", state.axis.number(), state.line()));
    }
    say::result(first.line());
}
