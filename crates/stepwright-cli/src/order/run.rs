//! `stepwright run`: runs a motor until it is stopped.

use std::time::Duration;

use serde_json::json;
use stepwright_protocol::{Direction, Selection, Stop, Travel};

use super::able;
use super::by_law::{self, Goal, LawOrder};
use super::drive;
use super::law::LawArgs;
use super::lease::LeaseArgs;
use super::look::State;
use super::motion::{Motion, listed};
use super::screen::Screen;
use super::target::{self, AxisArgs, Format, MotionArgs};
use super::travel::{last_line, start_position};
use super::watch;
use crate::failure::Failure;
use crate::interrupt::{self, While};
use crate::quantity::{SignedSpeedArg, in_unit};
use crate::say;
use stepwright_host::motion::{NotBegun, RestPlace};
use stepwright_host::{LinkError, Session};
use stepwright_machine::time;

/// Run an axis at a speed until it is stopped
#[derive(clap::Args)]
#[command(after_help = "\
The command stays while the motor runs. At Ctrl-C, at any other signal or after the time of
--for it brakes, prints `position N ready`, and ends with status 0; if it brakes before the
time of --for is over, with 130. A second Ctrl-C stops dead: `position uncertain`, status 130.
On a terminal, keys control the motor: + and - change its speed by a tenth, s brakes. With
--lease the board also brakes if this program is killed or the cable is pulled.

With --detach the command returns as soon as the motor runs, and no longer watches it;
`stepwright stop` brakes it.

Examples:
  stepwright run 200
  stepwright run 400 --law austin --accel 500 --for 3s
  stepwright run -120rpm --for 3s --plot speed.svg
  stepwright run +200 --port /dev/ttyUSB0
  stepwright run +200 --port /dev/ttyUSB0 --detach
  stepwright stop --port /dev/ttyUSB0")]
pub struct Args {
    /// Speed; a negative speed runs backward
    #[arg(allow_hyphen_values = true, value_name = "±SPEED", required_unless_present = "named")]
    speed: Option<SignedSpeedArg>,
    /// The same, as the other commands have it
    #[arg(id = "named", long = "speed", allow_hyphen_values = true, hide = true)]
    #[arg(value_name = "±SPEED", conflicts_with = "speed")]
    named: Option<SignedSpeedArg>,
    /// Brake after this time: 3s, 500ms, 2min
    #[arg(long = "for", value_name = "TIME", value_parser = time)]
    time: Option<Duration>,
    #[command(flatten)]
    order: MotionArgs,
    #[command(flatten)]
    law: LawArgs,
    #[command(flatten)]
    on: AxisArgs,
    /// Return as soon as the motor runs; `stepwright stop` brakes it
    #[arg(long, conflicts_with_all = ["lease", "time"], help_heading = "Board")]
    detach: bool,
    #[command(flatten)]
    lease: LeaseArgs,
}

/// Runs the motor, and watches it unless it is detached.
pub fn run(args: Args) -> Result<(), Failure> {
    let Some(speed) = args.speed.as_ref().or(args.named.as_ref()) else {
        return Err(Failure::usage("no speed").hint("give one: `stepwright run 200`"));
    };
    let forward = speed.forward;
    if args.order.virt.fast && args.time.is_none() {
        return Err(Failure::usage("with --fast a run has no end that anyone could wait for")
            .hint("give --for TIME, or leave --fast out"));
    }
    if let Some(law) = args.law.austin(&args.order.ramps)? {
        if args.detach || args.lease.is_asked() {
            return Err(by_law::watched());
        }
        let (options, ramps, goal) = (&args.law, &args.order.ramps, Goal::Endless(forward));
        let (top, time, format) = (Some(&speed.speed), args.time, args.order.format);
        let order = LawOrder { law, options, ramps, top, goal, time, format };
        return order.run(args.on.axis, &args.order.port, &args.order.virt);
    }
    if args.detach {
        args.order.port.stays()?;
    }
    let direction = if forward { Direction::Forward } else { Direction::Backward };
    let travel = Travel::Endless(direction);
    let motion = args.order.ramps.motion(args.on.axis, &speed.speed, "the speed", travel)?;
    interrupt::listen(While::Holding)?;
    let title = format!("Axis {} until it is stopped", args.on.axis.number());
    let mut session = args.order.port.or_virtual(&args.order.virt, "run", motion.heading(title))?;
    let result = run_on(&mut session, &args, &motion, forward);
    let finished = target::finish(&mut session);
    result.and(finished)
}

fn run_on(
    session: &mut Session,
    args: &Args,
    motion: &Motion,
    forward: bool,
) -> Result<(), Failure> {
    target::has_axis(session, args.on.axis)?;
    able::to_bend(session, &motion.order)?;
    let mut lines = motion.lines()?;
    args.lease.before(session, &mut lines)?;
    let from = start_position(session, args.on.axis)?;
    let mut cut = None;
    let start = session.begin(args.on.axis, &motion.order, &lines, Some(from));
    if args.order.format == Format::Text && drive::has_plan(&start) {
        let way = if forward { "forward" } else { "backward" };
        let (axis, name) = (args.on.axis.number(), session.link().name());
        say::result(format_args!("axis {axis} {way} without end on {name}"));
        motion.show().iter().for_each(say::result);
        say::result(format_args!("  {:<12}{}", "lines", listed(&lines)));
    }
    let watched = match start {
        Ok(()) if args.detach && !interrupt::asked() => return left_alone(session, args),
        Ok(()) => {
            if args.time.is_none() {
                say::note("running; Ctrl-C brakes");
            }
            let until = args.time.map(|time| session.now() + time);
            let mut screen = Screen::of(session.talk(), motion, from);
            let watched = session.watch(args.on.axis, until, |talk, sight| screen.see(talk, sight));
            cut = screen.end();
            watched
        }
        Err(NotBegun::Trouble { trouble: LinkError::Killed, .. }) => Err(LinkError::Killed),
        Err(not) => {
            if matches!(not, NotBegun::Trouble { moving: true, .. }) {
                tell(session, args, "uncertain", None, None);
            }
            return Err(drive::order_not_begun(session, not, &motion.order));
        }
    };
    let ended = drive::conclude(session, args.on.axis, watched);
    if ended.failure.is_none() {
        args.lease.give_back(session);
    }
    // A switch may have stopped the axis before the end of the ramp.
    let halted = match ended.end {
        RestPlace::At(_) if ended.braked => session.stop_of(args.on.axis),
        _ => None,
    };
    let braked = ended.braked && halted.is_none_or(|why| why == Stop::Soft);
    let (state, position) = match ended.end {
        RestPlace::At(at) if braked || session.new_target(args.on.axis) == Some(at) => {
            ("ready", Some(at))
        }
        RestPlace::At(at) => ("stopped", Some(at)),
        RestPlace::Uncertain => ("uncertain", None),
    };
    let why = if state == "stopped" { session.stop_of(args.on.axis) } else { None };
    tell(session, args, state, position, why);
    match ended.failure {
        Some(failure) => Err(failure),
        None if state == "stopped" => Err(stopped(why)),
        None if args.time.is_some() && ended.braked && cut.unwrap_or_else(interrupt::asked) => {
            Err(Failure::interrupted("braked before the time of --for was over"))
        }
        None => Ok(()),
    }
}

/// Reports a detached motor that runs.
fn left_alone(session: &mut Session, args: &Args) -> Result<(), Failure> {
    let running = session.is_busy(Selection::One(args.on.axis)).and_then(|busy| {
        let position = session.position(args.on.axis)?;
        Ok((busy, position))
    });
    let (busy, position) = running.map_err(|trouble| {
        drive::not_begun(session, NotBegun::Trouble { trouble, moving: true })
    })?;
    if !busy {
        let why = session.stop_of(args.on.axis);
        tell(session, args, "stopped", position, why);
        return Err(stopped(why));
    }
    let state = State { axis: args.on.axis, busy, position, stop: None };
    watch::tell(session, args.order.format, args.order.ramps.unit(), &state);
    say::note(format_args!("stop it with: stepwright stop --port {}", session.link().name()));
    Ok(())
}

/// The failure if something else has stopped the axis.
fn stopped(why: Option<Stop>) -> Failure {
    match why {
        Some(stop) => Failure::new(format!("the axis was stopped by {}", stop.words())),
        None => Failure::new("something else has stopped the axis")
            .hint("did another master, a switch or a reset?"),
    }
}

fn tell(session: &mut Session, args: &Args, state: &str, position: Option<i64>, why: Option<Stop>) {
    match args.order.format {
        Format::Json => say::json(in_unit(
            args.order.ramps.unit(),
            json!({
                "axis": args.on.axis.number(),
                "position": position,
                "state": state,
                "stop": why.map(Stop::name),
                "board": session.link().name(),
            }),
            &["position"],
        )),
        Format::Text => say::result(last_line(state, position, why)),
    }
}

#[cfg(test)]
mod tests {
    use super::time;
    use std::time::Duration;

    #[test]
    fn times_have_units() {
        for (text, millis) in [("3s", 3000), ("3", 3000), ("500ms", 500), ("1.5 min", 90_000)] {
            assert_eq!(time(text), Ok(Duration::from_millis(millis)), "{text}");
        }
        for wrong in ["", "s", "-3s", "3x", "1.2.3s", "99999999999999999999h"] {
            assert!(time(wrong).is_err(), "{wrong}");
        }
    }
}
