//! `stepwright home`: finds 0 by a limit switch.
//!
//! ```text
//!   seek ──► I, back off ──► approach slowly ──► I, back off
//!     switch closes: halt      switch closes: halt, 0 is here
//! ```
//!
//! The halt from the speed of the seek may lose steps, so the place that counts is that of
//! the slow approach.

use std::time::Duration;

use serde_json::json;
use stepwright_protocol::{
    AxisId, Command, Direction, Distance, Refusal, Reply, Setting, Stop, Travel, Value,
};

use super::drive::{self, NotBegun};
use super::keys::KeyControl;
use super::motion::{MOTION, Motion};
use super::progress::Progress;
use super::settings;
use super::target::{self, AxisArgs, Format, MotionArgs};
use super::travel::{Way, last_line};
use crate::board::recording::Heading;
use crate::failure::Failure;
use crate::interrupt::{self, While};
use crate::link::serial::Share;
use crate::quantity::{DistanceArg, SpeedArg};
use crate::say;
use crate::session::{LinkError, Session};
use stepwright_sim::Switch;

/// Where the switch of a virtual machine stands.
const VIRTUAL_SWITCH: i64 = -1000;
/// The board takes no order towards a switch until it has stopped bouncing: 250 ms at most.
const OPENS: Duration = Duration::from_millis(300);

/// Find position 0 by the limit switch of an axis
///
/// The axis travels towards its switch, which halts it, backs off, comes back slowly until
/// the switch halts it again, calls that place 0, and backs off once more. The last line on
/// standard output is `position N ready`, where N is the distance from the switch; only then
/// the exit status is 0.
#[derive(clap::Args)]
#[command(after_help = "\
The board must know the switch: `stepwright settings set switches=1` (1 X, 2 Y, 4 Z, added
up). By default the switch ends the travel backward; `switch-forward` says otherwise.

Without --port a virtual machine is homed, whose switch stands 1000 steps behind.

Ctrl-C brakes, and a second Ctrl-C kills. An axis that finds no switch within --within
brakes. With the setting `safe-start` the stops by the switch are acknowledged here.

Examples:
  stepwright home
  stepwright home --port /dev/ttyUSB0
  stepwright home --axis 2 --speed 20mm/s --slow 1mm/s --back-off 2mm --mm-per-rev 8 \\
      --port /dev/ttyUSB0")]
pub struct Args {
    /// Speed towards the switch, the first time
    #[arg(long, value_name = "SPEED", allow_negative_numbers = true, default_value = "500", help_heading = MOTION)]
    speed: SpeedArg,
    /// Speed towards the switch, the second time
    #[arg(long, value_name = "SPEED", allow_negative_numbers = true, default_value = "50", help_heading = MOTION)]
    slow: SpeedArg,
    /// How far to go from the closed switch: steps, or like 2mm
    #[arg(long, value_name = "DISTANCE", default_value = "50", help_heading = MOTION)]
    back_off: DistanceArg,
    /// How far the switch may be: the axis brakes about there
    #[arg(long, value_name = "DISTANCE", default_value = "100000", help_heading = MOTION)]
    within: DistanceArg,
    #[command(flatten)]
    order: MotionArgs,
    #[command(flatten)]
    on: AxisArgs,
}

/// Homes, and says where the axis is.
pub fn run(args: Args) -> Result<(), Failure> {
    // What makes no sense is said before anything moves.
    args.distance(&args.back_off, "--back-off")?;
    args.distance(&args.within, "--within")?;
    args.motion(&args.slow, "--slow", Travel::Endless(Direction::Backward))?;
    args.motion(&args.speed, "--speed", Travel::Endless(Direction::Backward))?;
    interrupt::listen(While::Holding)?;
    let mut session = match args.order.port.port.is_some() {
        true => args.order.port.meet("home", Share::Host)?,
        false => virtual_machine(&args)?,
    };
    let result = home(&mut session, &args);
    let finished = target::finish(&mut session);
    let at = result?;
    match args.order.format {
        Format::Json => say::result(json!({
            "axis": args.on.axis.number(),
            "position": at,
            "state": "ready",
            "board": session.link().name(),
        })),
        Format::Text => say::result(last_line("ready", Some(at), None)),
    }
    finished
}

/// A virtual board with a switch on its machine, which it knows.
fn virtual_machine(args: &Args) -> Result<Session, Failure> {
    let heading = Heading { title: "Homing".to_owned(), notes: Vec::new() };
    let switch = Switch { axis: args.on.axis, at: VIRTUAL_SWITCH };
    let mut session = args.order.virt.board(heading, &[switch])?;
    target::has_axis(&session, args.on.axis)?;
    let known = Value::new(Setting::Switches, u32::from(args.bit()));
    known.map_or(Ok(()), |value| settings::order(&mut session, Command::Set(value)))?;
    Ok(session)
}

impl Args {
    fn bit(&self) -> u8 {
        1u8.checked_shl(self.on.axis.index() as u32).unwrap_or(0)
    }

    fn motion(&self, speed: &SpeedArg, name: &str, travel: Travel) -> Result<Motion, Failure> {
        self.order.ramps.motion(self.on.axis, speed, name, travel)
    }

    /// A distance of 1 step or more.
    fn distance(&self, distance: &DistanceArg, name: &str) -> Result<i32, Failure> {
        let held = distance.resolve(&self.order.ramps.geometry()?, name)?;
        let steps = Way::By(held).steps(0)?.get();
        if steps < 1 {
            return Err(Failure::usage(format!("{name} {steps}: a distance of 1 step or more")));
        }
        Ok(steps)
    }

    /// The way towards the switch, by the settings of the board.
    fn towards(&self, session: &mut Session) -> Result<(Direction, bool), Failure> {
        let listed = settings::ask(session)?;
        let number = |setting| listed.get(setting).map_or(0, |value| value.number());
        let bit = u32::from(self.bit());
        if number(Setting::Switches) & bit == 0 {
            let name = session.link().name();
            let axis = self.on.axis.number();
            return Err(Failure::new(format!("{name} knows of no limit switch of axis {axis}"))
                .hint(format!(
                    "if there is one: `stepwright settings set --port {name} switches={}` \
                     (1 X, 2 Y, 4 Z, added up)",
                    number(Setting::Switches) | bit
                )));
        }
        let forward = number(Setting::SwitchForward) & bit != 0;
        let direction = if forward { Direction::Forward } else { Direction::Backward };
        Ok((direction, number(Setting::SafeStart) != 0))
    }
}

/// How a way to the switch has ended.
enum Found {
    /// The switch has halted the axis, here if that is known.
    Halted(Option<i64>),
    /// It was closed before: nothing has moved.
    Closed,
}

/// Homes the axis; where it is then.
fn home(session: &mut Session, args: &Args) -> Result<i64, Failure> {
    target::has_axis(session, args.on.axis)?;
    let (direction, safe_start) = args.towards(session)?;
    let (way, back) = match direction {
        Direction::Forward => ("forward", -1),
        Direction::Backward => ("backward", 1),
    };
    let back_off = back * args.distance(&args.back_off, "--back-off")?;
    let (axis, name) = (args.on.axis.number(), session.link().name());
    tell(args, format!("axis {axis} {way} to its switch on {name}"));
    let seek = args.motion(&args.speed, "--speed", Travel::Endless(direction))?;
    match to_switch(session, args, &seek, safe_start)? {
        Found::Halted(Some(at)) => tell(args, format!("switch closed at {at}")),
        Found::Halted(None) => tell(args, "switch closed".to_owned()),
        Found::Closed => tell(args, "the switch is closed already".to_owned()),
    }
    away(session, args, back_off)?;
    let approach = args.motion(&args.slow, "--slow", Travel::Endless(direction))?;
    let end = session.now() + OPENS;
    loop {
        match to_switch(session, args, &approach, safe_start)? {
            Found::Halted(_) => break,
            Found::Closed if session.now() < end => {
                session.pause(drive::POLL).map_err(lost(session))?
            }
            Found::Closed => {
                let steps = back_off.abs();
                return Err(Failure::new(format!(
                    "the switch of axis {axis} is closed still, {steps} steps away from it"
                ))
                .hint("a longer --back-off, or look at the switch, its wiring and switch-high"));
            }
        }
    }
    tell(args, "switch closed slowly: that is 0".to_owned());
    away(session, args, back_off)
}

/// Travels to the switch.
fn to_switch(
    session: &mut Session,
    args: &Args,
    motion: &Motion,
    safe_start: bool,
) -> Result<Found, Failure> {
    let within = f64::from(args.distance(&args.within, "--within")?);
    let speed = f64::from(motion.order.top.millisteps()) / 1000.0;
    let longest = Duration::try_from_secs_f64(within / speed).unwrap_or(Duration::MAX);
    let sight = match watch(session, args, motion, Some(session.now().saturating_add(longest))) {
        Ok(sight) => sight,
        Err(NotBegun::Refused(_, Some(Refusal::Fault))) => return Ok(Found::Closed),
        Err(not) => return Err(failed(session, args.on.axis, not)),
    };
    if sight.braking {
        if interrupt::asked() {
            return Err(Failure::interrupted("braked before the switch was found"));
        }
        let axis = args.on.axis.number();
        return Err(Failure::new(format!("no switch of axis {axis} within {within} steps"))
            .hint("is it wired, and on this side (switch-forward)? Else a longer --within"));
    }
    match session.stop_of(args.on.axis) {
        Some(Stop::Switch) if safe_start => {
            session.ask(Command::Clear).map_err(lost(session))?;
            Ok(Found::Halted(sight.position))
        }
        Some(Stop::Switch) => Ok(Found::Halted(sight.position)),
        Some(stop) => Err(Failure::new(format!("stopped by {}", stop.words()))),
        None => Err(Failure::new("the axis rests, and its switch has not stopped it")
            .hint("did another master or a reset stop it?")),
    }
}

/// Calls this place 0 and goes away from the switch; where to.
fn away(session: &mut Session, args: &Args, back_off: i32) -> Result<i64, Failure> {
    if session.ask(Command::Zero(args.on.axis)).map_err(lost(session))? != Reply::Yes {
        return Err(Failure::new(format!("{} refused to zero the axis", session.link().name())));
    }
    let steps = Distance::new(back_off);
    let motion = args.motion(&args.speed, "--speed", Travel::By(steps))?;
    let sight = match watch(session, args, &motion, None) {
        Ok(sight) => sight,
        Err(not) => return Err(failed(session, args.on.axis, not)),
    };
    match sight.position {
        Some(at) if at == i64::from(back_off) => Ok(at),
        _ if interrupt::asked() => Err(Failure::interrupted("braked while backing off")),
        _ => Err(Failure::new("the axis did not get away from its switch")
            .hint("`stepwright status` may say what stopped it")),
    }
}

/// Starts a travel and watches it to its end.
fn watch(
    session: &mut Session,
    args: &Args,
    motion: &Motion,
    until: Option<Duration>,
) -> Result<drive::Sight, NotBegun> {
    let unsure = |trouble| NotBegun::Trouble { trouble, moving: true };
    let safe = |trouble| NotBegun::Trouble { trouble, moving: false };
    if interrupt::asked() {
        return Err(safe(LinkError::Killed));
    }
    let from = session.rest_position(args.on.axis).map_err(safe)?;
    let lines = motion.lines().map_err(|_| NotBegun::Noise)?;
    drive::begin(session, args.on.axis, &motion.order, &lines, from)?;
    let mut hand = KeyControl::on(session, &motion.order);
    let mut progress = Progress::new(motion, from.unwrap_or(0), hand.listens());
    let watched =
        drive::watch(session, args.on.axis, until, &mut hand, |sight| progress.see(sight));
    drop(hand);
    progress.end();
    watched.map_err(unsure)
}

/// The failure of a travel; after a second Ctrl-C everything is killed here.
fn failed(session: &mut Session, axis: AxisId, not: NotBegun) -> Failure {
    match not {
        NotBegun::Trouble { trouble, moving: true } => {
            let ended = drive::conclude(session, axis, Err(trouble));
            ended.failure.unwrap_or_else(|| Failure::interrupted("stopped before 0 was found"))
        }
        NotBegun::Trouble { trouble: LinkError::Killed, .. } => {
            Failure::interrupted("interrupted before 0 was found")
        }
        not => drive::not_begun(session, not),
    }
}

fn lost(session: &mut Session) -> impl FnOnce(LinkError) -> Failure + use<> {
    let name = session.link().name();
    move |trouble| target::lost(&name, &trouble)
}

fn tell(args: &Args, text: String) {
    if args.order.format == Format::Text {
        say::result(text);
    }
}
