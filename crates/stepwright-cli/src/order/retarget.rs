//! `stepwright retarget`: changes the travel of a moving motor.

use serde_json::json;
use stepwright::Speed;
use stepwright_protocol::{AxisId, Command, Refusal, Reply, Selection, WholeAccel};

use super::look::{self, State};
use super::motion::{MOTION, sendable_accel};
use super::refused;
use super::target::{self, AxisArgs, Format, PortArgs};
use super::travel::Way;
use crate::failure::Failure;
use crate::quantity::{AccelArg, DistanceArg, GeometryArgs, SpeedArg, in_unit};
use crate::say;
use stepwright_host::change::Travels;
use stepwright_host::link::serial::Share;
use stepwright_host::{LinkError, Session};

/// Change the travel that an axis is on: its target, its speed, its ramps
///
/// The motor goes on from its present speed and keeps the new limits. If the target is behind,
/// or too near to stop at, the motor brakes to rest and travels back to it.
#[derive(clap::Args)]
#[command(after_help = "\
DISTANCE counts from where the travel began: after `move 4000`, `retarget 500` ends
where `move 500` would have ended. --to counts from 0, and needs the command that gave the
order to be still running: after `--detach` give a DISTANCE. A run without end gets a target.
The change begins after the steps that are planned already, some 16 to 24 ms.

If the board refuses a part of the change, the status is 1; the parts before it hold.

Examples:
  stepwright run 200 --port /dev/ttyUSB0 --detach
  stepwright retarget --top-speed 400 --port /dev/ttyUSB0
  stepwright retarget 5000 --decel 2000 --port /dev/ttyUSB0
  stepwright retarget --to 12mm --mm-per-rev 8 --port /dev/ttyUSB0")]
#[command(group(clap::ArgGroup::new("what").required(true).multiple(true)))]
pub struct Args {
    /// New target: steps, or like 90deg, 10mm, from where the travel began
    #[arg(allow_negative_numbers = true, group = "what")]
    distance: Option<DistanceArg>,
    /// New target as a position in the same units, counted from the board's position 0. Not
    /// after `--detach`
    #[arg(long, value_name = "POSITION", allow_negative_numbers = true, group = "what")]
    #[arg(conflicts_with = "distance")]
    to: Option<DistanceArg>,
    /// How to write the result
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Speed between the ramps
    #[arg(long, alias = "speed", value_name = "SPEED", allow_negative_numbers = true, group = "what", help_heading = MOTION)]
    top_speed: Option<SpeedArg>,
    /// Acceleration; it also replaces a ramp that was given in steps
    #[arg(long, value_name = "ACCEL", allow_negative_numbers = true, group = "what", help_heading = MOTION)]
    accel: Option<AccelArg>,
    /// Deceleration, likewise
    #[arg(long, value_name = "ACCEL", allow_negative_numbers = true, group = "what", help_heading = MOTION)]
    decel: Option<AccelArg>,
    #[command(flatten)]
    geometry: GeometryArgs,
    #[command(flatten)]
    port: PortArgs,
    #[command(flatten)]
    on: AxisArgs,
}

impl Args {
    /// The lines of the change. The ramps come before the speed and the target, which are to be
    /// reached by them.
    fn lines(&self, began: Option<i64>) -> Result<Vec<Command>, Failure> {
        let geometry = self.geometry.geometry()?;
        let mut lines = Vec::new();
        let slope = |arg: &Option<AccelArg>, name| -> Result<Option<WholeAccel>, Failure> {
            let Some(arg) = arg else { return Ok(None) };
            let held = arg.resolve(&geometry, name)?;
            sendable_accel(name, &held)?;
            let whole = held.value.millisteps().saturating_add(500) / 1000;
            Ok(Some(WholeAccel::clamped(whole as u32)))
        };
        lines.extend(slope(&self.accel, "--accel")?.map(Command::Accel));
        lines.extend(slope(&self.decel, "--decel")?.map(Command::Decel));
        if let Some(top) = &self.top_speed {
            let top: Speed = top.moving(&geometry, "--top-speed")?.value;
            lines.push(Command::top(top).ok_or_else(|| Failure::new("--top-speed is 0"))?);
        }
        if self.distance.is_some() || self.to.is_some() {
            let way = Way::of(self.distance.as_ref(), self.to.as_ref(), &geometry)?;
            lines.push(Command::Retarget(way.steps(began.unwrap_or(0))?));
        }
        Ok(lines)
    }
}

/// Changes the travel, and prints the axis' position.
pub fn run(args: Args) -> Result<(), Failure> {
    // Invalid options are refused before anything is requested.
    args.lines(None)?;
    let mut session = args.port.meet("retarget", Share::Guest)?;
    target::has_axis(&session, args.on.axis)?;
    let began = began(&mut session, &args)?;
    let lines = args.lines(began)?;
    let told = tell(&mut session, args.on.axis, &lines).map_err(target::trouble(&mut session))?;
    let states =
        look::states(&mut session, Some(args.on.axis)).map_err(target::trouble(&mut session))?;
    let name = session.link().name();
    if let Some((line, why)) = told {
        return Err(refusal(&mut session, args.on.axis, line, why));
    }
    for state in &states {
        show(&args, &name, &lines, began, state);
    }
    look::all_known(&name, &states)
}

/// The start of the travel. The program that gave the order knows it; the board does not report it.
fn began(session: &mut Session, args: &Args) -> Result<Option<i64>, Failure> {
    let axis = args.on.axis;
    let held = args.port.guest().is_some();
    let moves = session.is_busy(Selection::One(axis)).map_err(target::trouble(session))?;
    let began = match held && moves {
        true => session.began(axis).map_err(target::trouble(session))?,
        false => None,
    };
    if args.to.is_some() && moves && began.is_none() {
        return Err(Failure::new(
            "where the travel began is not known: no command has stayed with it",
        )
        .hint("after --detach give how far from there: `stepwright retarget DISTANCE`"));
    }
    Ok(began)
}

/// Sends the lines; a repeated line is harmless. Returns the line that was refused, and the reason.
fn tell(
    session: &mut Session,
    axis: AxisId,
    lines: &[Command],
) -> Result<Option<(Command, Option<Refusal>)>, LinkError> {
    let one = Selection::One(axis);
    for &line in lines {
        // At rest the board would keep the values for later orders.
        if !session.is_busy(one)? {
            return Ok(Some((line, Some(Refusal::NoTravel))));
        }
        if session.ask_of(one, line)? != Reply::Yes {
            return Ok(Some((line, session.why()?)));
        }
    }
    Ok(None)
}

fn refusal(session: &mut Session, axis: AxisId, line: Command, why: Option<Refusal>) -> Failure {
    let name = session.name();
    match why {
        Some(Refusal::NoTravel) => {
            let axis = axis.number();
            Failure::new(format!("{name}: axis {axis} is at rest, there is no travel to change"))
                .hint("`stepwright move` and `stepwright run` begin one")
        }
        Some(why) => refused::by(session, &line, why),
        None => Failure::new(format!("{name} refused {line}")).hint(
            "a board that knows only the Nano slave's lines can't change a travel in progress",
        ),
    }
}

fn show(args: &Args, name: &str, lines: &[Command], began: Option<i64>, state: &State) {
    let unit = args.geometry.unit();
    match args.format {
        Format::Json => {
            let told = json!({
                "axis": args.on.axis.number(),
                "position": state.position,
                "state": state.word(),
                "board": name,
                "lines": lines.iter().map(ToString::to_string).collect::<Vec<_>>(),
            });
            say::json(in_unit(unit, told, &["position"]));
        }
        Format::Text => {
            let mut travels = Travels::default();
            travels.begins(args.on.axis, began);
            let axis = Selection::One(args.on.axis);
            let words = lines.iter().map(|line| travels.change(axis, *line).to_string());
            let words = words.collect::<Vec<_>>().join(", ");
            say::result(format_args!("axis {} on {name}: {words}", args.on.axis.number()));
            say::result(state.line_in(unit, None));
        }
    }
}
