//! `stepwright stop` and `stepwright kill`: the orders that must get through.

use serde_json::json;
use stepwright_protocol::{AxisId, Selection};

use super::drive;
use super::look::{self, State};
use super::target::{self, Format, PortArgs};
use crate::failure::Failure;
use crate::link::serial::Share;
use crate::talk::{Talk, Trouble};
use crate::{interrupt, say};

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
lost its position: go to a known place and call it 0 with `stepwright zero`.

Example:
  stepwright kill --port /dev/ttyUSB0")]
pub struct KillArgs {
    /// How to write the result
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    port: PortArgs,
}

/// Brakes, and waits until everything rests.
pub fn stop(args: StopArgs) -> Result<(), Failure> {
    interrupt::listen()?;
    let mut talk = args.port.meet("stop", Share::Anyhow)?;
    if let Some(axis) = args.axis {
        target::has_axis(&talk, axis)?;
    }
    let axes = args.axis.map_or(Selection::All, Selection::One);
    match brake_to_rest(&mut talk, axes) {
        Err(Trouble::Killed) => {}
        Err(trouble) => return Err(unsure(&talk_name(&mut talk), &trouble)),
        Ok(()) => {
            let states = look::states(&mut talk, args.axis).map_err(target::trouble(&mut talk))?;
            tell(args.format, &states, true);
            return look::all_known(&talk_name(&mut talk), &states);
        }
    }
    let killed = kill_now(&mut talk, args.format);
    killed.and(Err(Failure::interrupted("killed instead of braked")))
}

fn brake_to_rest(talk: &mut Talk, axes: Selection) -> Result<(), Trouble> {
    drive::brake(talk, axes)?;
    while talk.is_busy(axes)? {
        if interrupt::presses() > 0 {
            return Err(Trouble::Killed);
        }
        talk.pause(drive::POLL)?;
    }
    // As a master finds it that knows of one axis only.
    talk.select(Selection::FIRST)
}

/// Kills, without asking first who is there.
pub fn kill(args: KillArgs) -> Result<(), Failure> {
    interrupt::listen()?;
    let mut talk = args.port.open("kill", Share::Anyhow)?;
    kill_now(&mut talk, args.format)
}

fn kill_now(talk: &mut Talk, format: Format) -> Result<(), Failure> {
    let name = talk_name(talk);
    match talk.kill() {
        Ok(true) => {}
        Ok(false) => return Err(unsure(&name, &Trouble::Silent)),
        Err(trouble) => return Err(unsure(&name, &trouble)),
    }
    let states = talk.meet().and_then(|()| look::states(talk, None));
    let states = states.map_err(|trouble| unsure(&name, &trouble))?;
    tell(format, &states, false);
    Ok(())
}

fn talk_name(talk: &mut Talk) -> String {
    talk.link().name()
}

/// The failure of a stop that was not confirmed.
fn unsure(name: &str, trouble: &Trouble) -> Failure {
    Failure::new(format!("{name}: {trouble}"))
        .hint("the motor may still be moving: look at it, and switch off its power if it is")
}

/// Says where the axes are; those that lie at 0 are left out, but axis 1.
fn tell(format: Format, states: &[State], all: bool) {
    if format == Format::Json {
        return say::result(json!({ "axes": look::json(states) }));
    }
    let (first, others) = match states.split_first() {
        Some((first, others)) if states.len() > 1 => (first, others),
        Some((only, _)) => return say::result(only.line()),
        None => return,
    };
    let worth = |state: &&State| (all && state.busy) || state.position != Some(0);
    for state in others.iter().filter(worth) {
        say::result(format_args!("axis {} {}", state.axis.number(), state.line()));
    }
    say::result(first.line());
}
