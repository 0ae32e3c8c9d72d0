//! `stepwright stop` and `stepwright kill`: orders that also work while another program has the
//! port.

use std::time::{Duration, Instant};

use serde_json::json;
use stepwright_protocol::{AxisId, Command, MAX_AXES, Selection};

use super::look::{self, State};
use super::target::{self, Format, PortArgs};
use crate::failure::Failure;
use crate::interrupt::{self, Ends, While};
use crate::say;
use stepwright_host::link::serial::Share;
use stepwright_host::motion::POLL;
use stepwright_host::programs::{places, wait_for_rest};
use stepwright_host::{LinkError, Session};

/// Brake: ramp down, and keep the position
#[derive(clap::Args)]
#[command(after_help = "\
Brakes every axis, or that of --axis, waits until it rests, and prints its position:
`axis 1 position 4000 ready`, a line for each; `position 4000 ready` with --axis.
Ctrl-C while it waits kills. It also works while another program uses the port, but not on
Windows.

With --axis the other axes go on if the board answers, or the stepwright that has the port.
If neither does, other axes may be braked too.

Examples:
  stepwright stop --port /dev/ttyUSB0
  stepwright stop --axis 2 --port /dev/ttyUSB0")]
pub struct StopArgs {
    /// How to write the result
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    port: PortArgs,
    /// Axis to brake, 1 to 8 [default: all]
    #[arg(long, value_name = "N", value_parser = target::axis, help_heading = "Board")]
    axis: Option<AxisId>,
}

/// Stop all axes at once; the position of one that moved becomes unknown
#[derive(clap::Args)]
#[command(after_help = "\
It also works while another program uses the port, but not on Windows. An axis that was
moving has lost its position. `stepwright zero` sets it to 0: where the axis stands at a known place, or to be
able to move it to one.

Example:
  stepwright kill --port /dev/ttyUSB0")]
pub struct KillArgs {
    /// How to write the result
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    port: PortArgs,
}

/// A stepwright leaves the port this soon after its motor was stopped, or it stays and lets others
/// in, as `stepwright serve` does.
const LEAVES: Duration = Duration::from_secs(1);
/// The longest time that another program may take to notice that its motor was stopped.
const CONFIRM: Duration = Duration::from_secs(5);

/// The longest time that a program that lets nobody in holds the port to ask a single question.
const TURN: Duration = Duration::from_millis(500);

/// How long a board with another program may take to come to rest.
const REST: Duration = Duration::from_secs(120);

/// The hint if it is not known whether the motor is at rest.
const LOOK: &str = "the motor may still be moving: look at it, and switch off its power if it is";

/// Brakes, and waits until all axes are at rest.
pub fn stop(args: StopArgs) -> Result<(), Failure> {
    interrupt::listen(While::Waiting)?;
    let mut session = args.port.open("stop", Share::Anyhow)?;
    session.set_guard(interrupt::guard(Ends::ByKilling));
    if args.axis.is_some()
        && let Some(ended) = stop_one(&mut session, &args)
    {
        return ended;
    }
    let mut urged = session.urge(Command::Stop, LEAVES);
    if urged.is_ok() && !session.link().is_alone() {
        if let Some(guest) = host(&args.port) {
            if let Some(ended) = stop_through(guest, &args) {
                return ended;
            }
        } else {
            urged = session.urge(Command::Stop, CONFIRM);
        }
    }
    let stopped = match urged {
        Ok(()) => brake_all(&mut session, args.axis)?,
        Err(trouble) => Err(trouble),
    };
    if let (Ok(states), None) = (&stopped, args.axis) {
        settle(&mut session, &args.port, states);
    }
    end(&mut session, &args, stopped)
}

/// Brakes one axis only; a bare Z would brake the axis that is selected. `None` if nobody answers:
/// neither the board, on a free port, nor the stepwright that has the port.
fn stop_one(session: &mut Session, args: &StopArgs) -> Option<Result<(), Failure>> {
    let begin = Instant::now();
    loop {
        if session.link().is_alone() {
            return match answers(session).then(|| session.meet())? {
                Err(LinkError::Silent | LinkError::Program(_)) => None,
                Err(trouble) => Some(end(session, args, Err(trouble))),
                Ok(()) => Some(
                    brake_all(session, args.axis).and_then(|stopped| end(session, args, stopped)),
                ),
            };
        }
        if let Some(ended) = host(&args.port).and_then(|guest| stop_through(guest, args)) {
            return Some(ended);
        }
        if begin.elapsed() >= TURN {
            return None;
        }
        session.link().rest(POLL);
    }
}

/// Brakes through the stepwright that has the port; `None` if it has released the port meanwhile.
fn stop_through(mut guest: Session, args: &StopArgs) -> Option<Result<(), Failure>> {
    guest.set_guard(interrupt::guard(Ends::ByKilling));
    match brake_all(&mut guest, args.axis) {
        Ok(stopped @ (Ok(_) | Err(LinkError::Killed | LinkError::Ended))) => {
            Some(end(&mut guest, args, stopped))
        }
        Ok(Err(_)) => None,
        Err(failure) => Some(Err(failure)),
    }
}

/// Ends a lease that a dead holder of the port has left on the board, once all axes are at rest:
/// the next program need not wait for it.
fn settle(session: &mut Session, port: &PortArgs, states: &[State]) {
    #[cfg(unix)]
    if let Some(path) = &port.port
        && session.link().is_alone()
        && states.iter().all(|state| !state.busy)
    {
        stepwright_host::link::lease::give_back(path, session);
    }
    #[cfg(not(unix))]
    let _ = (session, port, states);
}

/// Prints the result.
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
        Err(LinkError::Ended) => Err(Failure::interrupted(format!(
            "{name}: told to brake, and not waited for until it rested"
        ))
        .hint(LOOK)),
        Err(trouble) => Err(unsure(&name, &trouble)),
    }
}

/// The board through the stepwright that has the port, if it lets others in and answers. It may be
/// suspended.
fn host(port: &PortArgs) -> Option<Session> {
    let mut guest = port.guest()?;
    answers(&mut guest).then_some(guest)
}

/// Whether a board answers.
fn answers(session: &mut Session) -> bool {
    (0..2).any(|_| matches!(session.once(Command::Status), Ok(Some(_))))
}

/// Connects to the board, and brakes.
fn brake_all(
    session: &mut Session,
    only: Option<AxisId>,
) -> Result<Result<Vec<State>, LinkError>, Failure> {
    let met = session.meet();
    if let (Ok(()), Some(axis)) = (&met, only) {
        target::has_axis(session, axis)?;
    }
    Ok(match met {
        Err(LinkError::Program(_)) => rest_of_another(session),
        met => met.and_then(|()| brake_to_rest(session, only)),
    })
}

/// The axes of a board with another program, once they are at rest: the same line brakes all of
/// them.
fn rest_of_another(session: &mut Session) -> Result<Vec<State>, LinkError> {
    if !wait_for_rest(session, REST, || true)? {
        return Err(LinkError::Ended);
    }
    let places = places(session, MAX_AXES)?;
    let state = |(axis, position)| State { axis, busy: false, position, stop: None };
    Ok(AxisId::first(MAX_AXES).zip(places).map(state).collect())
}

fn brake_to_rest(session: &mut Session, only: Option<AxisId>) -> Result<Vec<State>, LinkError> {
    let axes = only.map_or(Selection::All, Selection::One);
    session.stop(axes)?;
    while session.is_busy(axes)? {
        session.pause(POLL)?;
    }
    look::states(session, only)
}

/// Kills, without first asking which board it is.
pub fn kill(args: KillArgs) -> Result<(), Failure> {
    interrupt::listen(While::Waiting)?;
    let mut session = args.port.open("kill", Share::Anyhow)?;
    kill_now(&mut session, &args.port, args.format)
}

fn kill_now(session: &mut Session, port: &PortArgs, format: Format) -> Result<(), Failure> {
    let name = session.link().name();
    let urged = session.urge(Command::Kill, LEAVES);
    if urged.is_ok()
        && !session.link().is_alone()
        && let Some(mut guest) = host(port)
        && guest.kill().is_ok_and(|killed| killed)
        && let Ok(states) = guest.meet().and_then(|()| look::states(&mut guest, None))
    {
        tell(format, &states);
        return Ok(());
    }
    match session.urge(Command::Kill, CONFIRM).and_then(|()| session.kill()) {
        Ok(true) => {}
        Ok(false) => return Err(unsure(&name, &LinkError::Silent)),
        Err(trouble) => return Err(unsure(&name, &trouble)),
    }
    let states = match session.meet() {
        Err(LinkError::Program(_)) => rest_of_another(session),
        met => met.and_then(|()| look::states(session, None)),
    };
    let states = states.map_err(|trouble| unsure(&name, &trouble))?;
    settle(session, port, &states);
    tell(format, &states);
    Ok(())
}

/// The failure of a stop that was not confirmed.
fn unsure(name: &str, trouble: &LinkError) -> Failure {
    Failure::new(format!("{name}: {trouble}")).hint(LOOK)
}

/// Prints the axes' positions: `position 4000 ready` for one, `axis 2 position 4000 ready` for each
/// of several.
fn tell(format: Format, states: &[State]) {
    if format == Format::Json {
        return say::json(json!({ "axes": look::json(states) }));
    }
    if let [one] = states {
        return say::result(one.line());
    }
    for state in states {
        say::result(format_args!("axis {} {}", state.axis.number(), state.line()));
    }
}
