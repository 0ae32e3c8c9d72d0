//! `stepwright move`: moves an axis by a distance, or to a position.

use serde_json::json;
use stepwright::Geometry;
use stepwright_austin::LawName;
use stepwright_protocol::{AxisId, Distance, Selection, Stop, Travel};

use super::able;
use super::by_law::{self, Goal, LawOrder};
use super::drive::{self, Ended};
use super::law::LawArgs;
use super::lease::LeaseArgs;
use super::motion::{MOTION, Motion, TOP, listed};
use super::screen::Screen;
use super::target::{self, AxisArgs, Format, MotionArgs};
use super::watch;
use crate::failure::Failure;
use crate::interrupt::{self, While};
use crate::quantity::{DistanceArg, Rounded, SpeedArg, in_unit};
use crate::say;
use stepwright_host::motion::{NotBegun, RestPlace};
use stepwright_host::{LinkError, Session};

/// Move an axis by a distance or to a position, on a virtual board or a real one
///
/// The last line on standard output is the position of the axis: `position 4000
/// ready` if it has reached its target, and only then the exit status is 0. Position 0 is
/// where the axis was when the board was switched on, or at the last `zero`.
#[derive(clap::Args)]
#[command(after_help = "\
Without --port a virtual board moves: the real engine with simulated pins, in
real time.

Ctrl-C brakes along the ramp, and the position stays known; a second Ctrl-C
stops dead, and the position is lost. Any other signal that would end the command brakes too,
also a closed terminal's and Ctrl-Z. On a terminal, keys control the moving motor: + and -
change its speed by a tenth of the top speed, s brakes. From another terminal `retarget`
changes the travel. With --lease the board also brakes if this program is killed or the cable
is pulled; the position stays known.

A default ramp takes 0.4 s at any top speed: with --top-speed 20000 alone the motor accelerates
20 times as hard as at 1000. Give --accel to keep the acceleration.

The last line       Status
  position N ready     0    it went all the way
  position N stopped  130   braked by Ctrl-C, another signal or s, at rest at N
  … by its limit switch 1   stopped by something else, at rest at N: the reason
  position uncertain  130   killed by Ctrl-C
                        1   the board was lost, or killed by something else
After a `retarget` from another terminal, `ready` means at rest at the new target. An order
that the board refuses ends with status 1 and without this line, an invalid command line with
status 2.

--vcd writes a Value Change Dump. PulseView imports it with a downsampling factor of 625,
which gives a sample for each tick at 16 MHz; on the command line:
  sigrok-cli -i edges.vcd -I vcd:downsample=625 -P stepper_motor:step=step1:dir=dir1

Examples:
  stepwright move 4000
  stepwright move -4000 --top-speed 300rpm --accel 10000
  stepwright move 90deg --steps-per-rev 3200
  stepwright move --to 25mm --mm-per-rev 40 --port /dev/ttyUSB0
  stepwright move --to 0 --port /dev/ttyUSB0
  stepwright move --to 0 --port /dev/ttyUSB0 --detach
  stepwright move 4000 --fast --plot speed.svg --vcd edges.vcd
  stepwright move 4000 --law linear-factor --accel 2000 --port /dev/ttyUSB0
  stepwright move 1000 --law austin --accel 200 --change 100:500 --fast
  stepwright move 4000 --port /dev/ttyUSB0 --format json")]
#[command(group(clap::ArgGroup::new("way").required(true)))]
pub struct Args {
    /// Distance: steps, or like 90deg, 1.5turns, 10mm; a negative distance moves backward
    #[arg(allow_negative_numbers = true, group = "way")]
    distance: Option<DistanceArg>,
    /// Target position in the same units, counted from the board's position 0
    #[arg(long, value_name = "POSITION", allow_negative_numbers = true, group = "way")]
    to: Option<DistanceArg>,
    /// Speed between the ramps [default: 1000; with --law less if the board can't make that]
    #[arg(long, alias = "speed", value_name = "SPEED", allow_negative_numbers = true, help_heading = MOTION)]
    top_speed: Option<SpeedArg>,
    #[command(flatten)]
    order: MotionArgs,
    #[command(flatten)]
    law: LawArgs,
    #[command(flatten)]
    on: AxisArgs,
    /// Return as soon as the motor moves; `stepwright watch` follows it
    #[arg(long, conflicts_with = "lease", help_heading = "Board")]
    detach: bool,
    #[command(flatten)]
    lease: LeaseArgs,
}

/// The target of a move.
pub enum Way {
    /// A distance from the present position.
    By(Rounded<i64>),
    /// To a position.
    To(Rounded<i64>),
}

impl Way {
    /// To `position` if given, otherwise by `distance`.
    pub fn of(
        distance: Option<&DistanceArg>,
        position: Option<&DistanceArg>,
        geometry: &Geometry,
    ) -> Result<Way, Failure> {
        Ok(match (distance, position) {
            (_, Some(to)) => Way::To(to.resolve(geometry, "--to")?),
            (Some(by), None) => Way::By(by.resolve(geometry, "DISTANCE")?),
            (None, None) => return Err(Failure::usage("neither a distance nor --to")),
        })
    }

    /// The steps to go from `from`.
    pub fn steps(&self, from: i64) -> Result<Distance, Failure> {
        let held = self.given();
        let steps = match self {
            Way::By(held) => held.value,
            Way::To(held) => held.value.saturating_sub(from),
        };
        let fits = i32::try_from(steps).ok().map(Distance::new);
        fits.ok_or_else(|| {
            let away = match self {
                Way::By(_) => "are".to_owned(),
                Way::To(_) => format!("from {from} are {steps} steps,"),
            };
            Failure::usage(format!("{held} {away} too far for one travel"))
                .hint("a travel has at most 2147483647 steps forward, 2147483648 backward")
        })
    }

    /// The value as typed, and as it is used.
    pub fn given(&self) -> &Rounded<i64> {
        let (Way::By(held) | Way::To(held)) = self;
        held
    }

    /// The value as text, if it was not typed in steps.
    fn show(&self) -> Option<String> {
        let (name, held) = match self {
            Way::By(held) => ("distance", held),
            Way::To(held) => ("target", held),
        };
        held.converted().then(|| format!("  {name:<12}{held}"))
    }
}

impl Args {
    fn by_law(&self, law: LawName, way: &Way) -> Result<(), Failure> {
        if self.detach || self.lease.is_asked() {
            return Err(by_law::watched());
        }
        let goal = match way {
            Way::By(held) => Goal::By(held.value),
            Way::To(held) => Goal::To(held.value),
        };
        let (top, format) = (self.top_speed.as_ref(), self.order.format);
        let (options, ramps) = (&self.law, &self.order.ramps);
        let order = LawOrder { law, options, ramps, top, goal, time: None, format };
        order.run(self.on.axis, &self.order.port, &self.order.virt)
    }

    fn motion(&self, steps: Distance) -> Result<Motion, Failure> {
        let top = self.top_speed.clone().unwrap_or_else(|| SpeedArg::of_steps(TOP));
        self.order.ramps.motion(self.on.axis, &top, "--top-speed", Travel::By(steps))
    }
}

/// Moves the axis, and prints its position.
pub fn run(args: Args) -> Result<(), Failure> {
    let way = Way::of(args.distance.as_ref(), args.to.as_ref(), &args.order.ramps.geometry()?)?;
    if let Some(law) = args.law.austin(&args.order.ramps)? {
        return args.by_law(law, &way);
    }
    if args.detach {
        args.order.port.stays()?;
    }
    // A virtual board begins at 0.
    let steps = way.steps(0)?;
    let motion = args.motion(steps)?;
    interrupt::listen(While::Holding)?;
    let title = format!("Axis {} by {:+} steps", args.on.axis.number(), steps.get());
    let mut session =
        args.order.port.or_virtual(&args.order.virt, "move", motion.heading(title))?;
    let result = travel_on(&mut session, &args, &way);
    // The recordings are also written after an error.
    let finished = target::finish(&mut session);
    result.and(finished)
}

fn travel_on(session: &mut Session, args: &Args, way: &Way) -> Result<(), Failure> {
    target::has_axis(session, args.on.axis)?;
    let from = start_position(session, args.on.axis)?;
    let steps = way.steps(from)?;
    let motion = &args.motion(steps)?;
    able::to_bend(session, &motion.order)?;
    let mut lines = motion.lines()?;
    args.lease.before(session, &mut lines)?;
    let late_before = session.info().map(|info| info.late);
    let begun = session.now();
    let start = session.begin(args.on.axis, &motion.order, &lines, Some(from));
    if args.order.format == Format::Text && drive::has_plan(&start) {
        let (axis, by, name) = (args.on.axis.number(), steps.get(), session.link().name());
        say::result(format_args!("axis {axis} by {by:+} steps on {name}"));
        way.show().iter().for_each(say::result);
        motion.show().iter().for_each(say::result);
        say::result(format_args!("  {:<12}{}", "lines", listed(&lines)));
    }
    let ended = match start {
        Ok(()) if args.detach && !interrupt::asked() => {
            return watch::left(session, args.on.axis, args.order.format, motion.unit);
        }
        Ok(()) => {
            let mut screen = Screen::of(session.talk(), motion, from);
            let watched = session.watch(args.on.axis, None, |talk, sight| screen.see(talk, sight));
            screen.end();
            drive::conclude(session, args.on.axis, watched)
        }
        Err(NotBegun::Trouble { trouble: LinkError::Killed, .. }) => {
            drive::conclude(session, args.on.axis, Err(LinkError::Killed))
        }
        Err(not) => {
            let unsure = matches!(not, NotBegun::Trouble { moving: true, .. });
            let failure = drive::order_not_begun(session, not, &motion.order);
            if !unsure {
                return Err(failure);
            }
            Ended { end: RestPlace::Uncertain, braked: false, failure: Some(failure) }
        }
    };
    if ended.failure.is_none() {
        args.lease.give_back(session);
    }
    let ordered = from.saturating_add(steps.get().into());
    let target = session.new_target(args.on.axis).unwrap_or(ordered);
    let late = late(session, late_before);
    let took = session.now().saturating_sub(begun).as_secs_f64();
    let (state, position) = match ended.end {
        RestPlace::At(at) if at == target => ("ready", Some(at)),
        RestPlace::At(at) => ("stopped", Some(at)),
        RestPlace::Uncertain => ("uncertain", None),
    };
    // The reason, if something else than this command stopped the axis.
    let why =
        if state == "stopped" && !ended.braked { session.stop_of(args.on.axis) } else { None };
    match args.order.format {
        Format::Json => say::json(in_unit(
            motion.unit,
            json!({
                "axis": args.on.axis.number(),
                "from": from,
                "steps": steps.get(),
                "target": target,
                "position": position,
                "state": state,
                "stop": why.map(Stop::name),
                "seconds": took,
                "late": late,
                "board": session.link().name(),
                "motion": motion.json(),
                "lines": lines.iter().map(ToString::to_string).collect::<Vec<_>>(),
            }),
            &["from", "steps", "target", "position"],
        )),
        Format::Text => say::result(last_line(state, position, why)),
    }
    match (ended.failure, ended.end) {
        (Some(failure), _) => Err(failure),
        (None, RestPlace::At(at)) if at != target && session.was_changed() && why.is_none() => {
            Err(Failure::new(format!("the axis rests at {at}, not at {target} as ordered"))
                .hint("another terminal has changed the travel"))
        }
        (None, RestPlace::At(at)) if at != target => Err(short(at, target, ended.braked, why)),
        (None, _) => Ok(()),
    }
}

/// The late steps of the motion, if the board counts them. Prints a note if there are any.
fn late(session: &mut Session, before: Option<u32>) -> Option<u32> {
    let late = session.ask_info().ok()??.late.saturating_sub(before?);
    if late > 0 {
        say::note(format_args!("{late} steps came late: the board is too slow for this speed"));
    }
    Some(late)
}

/// The line with an axis' position, and the reason if something has stopped it.
pub fn last_line(state: &str, position: Option<i64>, why: Option<Stop>) -> String {
    match (position, why) {
        (Some(at), None) => format!("position {at} {state}"),
        (Some(at), Some(stop)) => format!("position {at} {state} by {}", stop.words()),
        (None, _) => "position uncertain".to_owned(),
    }
}

/// Prints the position of an axis at rest.
pub fn print_rest(order: &MotionArgs, session: &Session, axis: AxisId, at: i64) {
    match order.format {
        Format::Json => say::json(in_unit(
            order.ramps.unit(),
            json!({
                "axis": axis.number(),
                "position": at,
                "state": "ready",
                "board": session.name(),
            }),
            &["position"],
        )),
        Format::Text => say::result(last_line("ready", Some(at), None)),
    }
}

/// The position of the axis before it moves.
pub fn start_position(session: &mut Session, axis: AxisId) -> Result<i64, Failure> {
    if interrupt::asked() {
        return Err(Failure::interrupted("interrupted before anything moved"));
    }
    let position = match session.rest_position(axis) {
        Ok(position) => position,
        Err(trouble) => return Err(no_position(session, axis, &trouble)),
    };
    position.ok_or_else(|| {
        let name = session.link().name();
        Failure::new(format!("{name}: the position of axis {} is uncertain", axis.number())).hint(
            format!(
                "a kill has lost it. If it stands at a known place, or to go and find one, \
                 call it 0: `stepwright zero --axis {} --port {name}`",
                axis.number()
            ),
        )
    })
}

/// The failure for an axis that does not give the same position twice: it moves, or the board is lost.
pub fn no_position(session: &mut Session, axis: AxisId, trouble: &LinkError) -> Failure {
    let name = session.link().name();
    match trouble {
        LinkError::Silent if session.is_busy(Selection::One(axis)).unwrap_or(false) => {
            let axis = axis.number();
            let place = format!("--axis {axis} --port {name}");
            Failure::new(format!("{name}: axis {axis} is on its way"))
                .hint(format!("`stepwright watch {place}` waits, `stepwright stop {place}` brakes"))
        }
        trouble => target::lost(&name, trouble),
    }
}

/// The failure for an axis that is at rest before its target.
pub fn short(at: i64, target: i64, braked: bool, why: Option<Stop>) -> Failure {
    let left = target.abs_diff(at);
    if braked {
        Failure::interrupted(format!("braked at {at}, {left} steps before {target}"))
            .hint(format!("the position is known: {:+} steps would be the rest", target - at))
    } else if let Some(stop) = why {
        let words = stop.words();
        Failure::new(format!("stopped at {at}, {left} steps before {target}, by {words}"))
            .hint(format!("the position is known: {:+} steps would be the rest", target - at))
    } else {
        Failure::new(format!("the axis rests at {at}, not at {target} as ordered"))
            .hint("did another master, a switch or a reset stop it, or noise change a digit?")
    }
}
