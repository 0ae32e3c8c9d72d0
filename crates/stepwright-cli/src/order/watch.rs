//! `stepwright watch`: follows an axis until it is at rest, and moves nothing.

use std::time::{Duration, Instant};

use serde_json::json;
use stepwright_protocol::{AxisId, Selection, Stop};

use super::drive;
use super::look::{self, OneArgs, State};
use super::target::{self, Format};
use crate::failure::Failure;
use crate::interrupt::{self, Ends, While};
use crate::quantity::{MachineUnit, in_unit};
use crate::say;
use stepwright_host::link::serial::Share;
use stepwright_host::motion::{NotBegun, POLL};
use stepwright_host::{LinkError, Session};

/// The time between two lines with the axis' position.
const LINES: Duration = Duration::from_secs(1);

/// Follow an axis until it rests
///
/// Prints the position on standard error once a second, and at the end `position 4000
/// ready` on standard output.
#[derive(clap::Args)]
#[command(after_help = "\
It moves and stops nothing: Ctrl-C ends the watching alone. It also works while another
stepwright uses the port, and then asks through that one.

Examples:
  stepwright move --to 90deg --port /dev/ttyUSB0 --detach
  stepwright watch --port /dev/ttyUSB0")]
pub struct Args {
    #[command(flatten)]
    one: OneArgs,
}

/// Watches the axis, and prints its final position.
pub fn run(args: Args) -> Result<(), Failure> {
    let args = args.one;
    interrupt::listen(While::Waiting)?;
    let mut session = meet(&args)?;
    let state = loop {
        match follow(&mut session, &args) {
            Ok(state) => break state,
            Err(LinkError::Killed | LinkError::Ended) => {
                return Err(Failure::interrupted("not watched to its end; nothing was stopped"));
            }
            // The stepwright through which the board was reached has ended.
            Err(LinkError::Gone(_)) => session = meet(&args)?,
            Err(trouble) => return Err(target::lost(&session.link().name(), &trouble)),
        }
    };
    tell(&mut session, args.format, args.unit(), &state);
    look::all_known(&session.link().name(), &[state])
}

fn meet(args: &OneArgs) -> Result<Session, Failure> {
    let mut session = args.port.meet("watch", Share::Guest)?;
    target::has_axis(&session, args.on.axis)?;
    session.set_guard(interrupt::guard(Ends::ByKilling));
    Ok(session)
}

/// Polls the axis until it is at rest.
fn follow(session: &mut Session, args: &OneArgs) -> Result<State, LinkError> {
    let one = Selection::One(args.on.axis);
    let (mut told, mut seen) = (Instant::now(), None);
    while session.is_busy(one)? {
        let (now, position) = (session.now(), session.position(args.on.axis)?);
        if told.elapsed() >= LINES {
            told = Instant::now();
            let speed = seen.zip(position).map(|((then, from), at): ((Duration, i64), i64)| {
                let time = now.saturating_sub(then).as_secs_f64().max(0.001);
                format!("  {:.0} steps/s", at.abs_diff(from) as f64 / time)
            });
            let at = position.map_or("uncertain".to_owned(), |at| at.to_string());
            say::note(format_args!("position {at}{}", speed.unwrap_or_default()));
            seen = position.map(|at| (now, at));
        } else if seen.is_none() {
            seen = position.map(|at| (now, at));
        }
        session.pause(POLL)?;
    }
    let states = look::states(session, Some(args.on.axis))?;
    states.into_iter().next().ok_or(LinkError::Silent)
}

/// Prints the state of an axis, also in its unit.
pub fn tell(session: &mut Session, format: Format, unit: Option<MachineUnit>, state: &State) {
    match format {
        Format::Json => {
            let told = json!({
                "axis": state.axis.number(),
                "position": state.position,
                "state": state.word(),
                "stop": state.stop.map(Stop::name),
                "board": session.link().name(),
            });
            say::json(in_unit(unit, told, &["position"]));
        }
        Format::Text => say::result(state.line_in(unit, state.stop)),
    }
}

/// Prints the position of a detached axis.
pub fn left(
    session: &mut Session,
    axis: AxisId,
    format: Format,
    unit: Option<MachineUnit>,
) -> Result<(), Failure> {
    let states = look::states(session, Some(axis)).map_err(|trouble| {
        drive::not_begun(session, NotBegun::Trouble { trouble, moving: true })
    })?;
    for state in &states {
        tell(session, format, unit, state);
    }
    say::note(format_args!("see it with: stepwright watch --port {}", session.link().name()));
    look::all_known(&session.link().name(), &states)
}
