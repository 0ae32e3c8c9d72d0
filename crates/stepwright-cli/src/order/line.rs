//! `stepwright line`: several axes along a straight line, together.

use std::time::{Duration, Instant};

use serde_json::json;
use stepwright_protocol::{AxisId, Command, Distance, MAX_AXES, Order, Script, Selection, Travel};

use super::able;
use super::drive;
use super::motion::{MOTION, Motion, listed, longest_wait, seconds};
use super::target::{self, Format, MotionArgs};
use super::travel::{Way, start_position};
use crate::failure::Failure;
use crate::interrupt::{self, While};
use crate::machine::{MachineArgs, MachineAxes};
use crate::quantity::{DistanceArg, GeometryArgs, MachineUnit, SpeedArg, in_units};
use crate::say;
use stepwright_host::line::{NEAR, NOTABLE, NoLine, apart, furthest, off, shares};
use stepwright_host::motion::{NotBegun, POLL, Start};
use stepwright_host::{LinkError, Session};

/// The time between two lines with the axes' positions.
const LINES: Duration = Duration::from_secs(1);

/// Move several axes along a straight line: all begin together and end together
///
/// Speeds and ramps are those of the axis with the longest distance; those of the other axes
/// are scaled down. The last line on standard output is the positions: `position 2000 -500
/// ready` if all axes have reached their targets, and only then the exit status is 0.
#[derive(clap::Args)]
#[command(after_help = "\
The first number is for axis 1, the second for axis 2, and so on; 0 leaves an axis where
it is. A board takes start speeds, accelerations and jerks as whole numbers: the ramps of an
axis with a small share differ a little from the line, and its top speed makes up for it. If the
axes still end at different times, the command says by how much. The default ramp of two axes
is at most 120,000 steps/s², of three 40,000, with --jerk 3,900 and 1,200.

After a `retarget` from another terminal an axis leaves the line, and moves to its new target
by itself.

Ctrl-C brakes every axis, each along its own ramp, close to the line; a
second Ctrl-C stops dead, and the positions are lost.

Examples:
  stepwright line 2000 -500
  stepwright line 25mm -10mm --mm-per-rev 40
  stepwright line --to 0 0 --port /dev/ttyUSB0
  stepwright line 20000 6666 2666 --top-speed 15000 --accel 40000 --fast
  stepwright line 2000 0 500 --port /dev/ttyUSB0 --format json")]
#[command(group(clap::ArgGroup::new("way").required(true)))]
pub struct Args {
    /// Distance of each axis: steps, or like 90deg, 10mm; a negative distance moves backward
    #[arg(num_args = 1..=usize::from(MAX_AXES), allow_negative_numbers = true, group = "way")]
    distance: Vec<DistanceArg>,
    /// Target position of each axis, in the same units
    #[arg(long, value_name = "POSITION", num_args = 1..=usize::from(MAX_AXES), group = "way")]
    #[arg(allow_negative_numbers = true)]
    to: Vec<DistanceArg>,
    /// Speed between the ramps, of the axis with the longest distance
    #[arg(long, alias = "speed", value_name = "SPEED", allow_negative_numbers = true, default_value = "1000", help_heading = MOTION)]
    top_speed: SpeedArg,
    #[command(flatten)]
    order: MotionArgs,
}

/// Moves the axes, and prints their positions.
pub fn run(args: Args, machine: &MachineArgs) -> Result<(), Failure> {
    let file = MachineAxes::quiet(machine)?;
    let count = args.distance.len().max(args.to.len());
    let axes: Vec<AxisId> = AxisId::first(count as u8).collect();
    let built = axes.iter().map(|axis| file.geometry(*axis, args.order.ramps.built()));
    let built: Vec<GeometryArgs> = built.collect();
    let to = args.to.iter().zip(&built);
    let to = to.map(|(to, built)| Way::of(None, Some(to), &built.geometry()?));
    let ways: Vec<Way> = args
        .distance
        .iter()
        .zip(&built)
        .map(|(by, built)| Way::of(Some(by), None, &built.geometry()?))
        .chain(to)
        .collect::<Result<_, _>>()?;
    // A virtual board begins at 0.
    let line = Line::of(&args, &ways, &built, &vec![0; axes.len()])?;
    interrupt::listen(While::Holding)?;
    let title = format!("A line of {} steps", numbers(line.steps()));
    let mut heading = line.motion.heading(title);
    // The unit that all axes share, or steps.
    heading.unit = heading.unit.filter(|unit| units(&built).all(|other| other == Some(*unit)));
    let mut session = args.order.port.or_virtual(&args.order.virt, "line", heading)?;
    let result = go(&mut session, &args, &axes, &ways, &built);
    let finished = target::finish(&mut session);
    result.and(finished)
}

/// The unit of each axis.
fn units(built: &[GeometryArgs]) -> impl Iterator<Item = Option<MachineUnit>> {
    built.iter().map(GeometryArgs::unit)
}

/// The orders of a line.
struct Line {
    /// The steps of each axis.
    steps: Vec<Distance>,
    /// The motion of the axis that goes furthest.
    motion: Motion,
    /// The order of each axis that moves.
    orders: Vec<(AxisId, Order)>,
}

impl Line {
    fn of(
        args: &Args,
        ways: &[Way],
        built: &[GeometryArgs],
        from: &[i64],
    ) -> Result<Line, Failure> {
        let steps = ways.iter().zip(from).map(|(way, from)| way.steps(*from));
        let steps = steps.collect::<Result<Vec<_>, _>>()?;
        let lead = furthest(&steps);
        let (lead, way) = lead.ok_or_else(|| Failure::usage("no axis moves"))?;
        let built = built.get(lead.index()).unwrap_or(args.order.ramps.built()).clone();
        let moving = steps.iter().filter(|way| way.get() != 0).count();
        let ramps = args.order.ramps.on(built, moving);
        let motion = ramps.motion(lead, &args.top_speed, "--top-speed", Travel::By(way))?;
        let orders = shares((lead, motion.order), &steps).map_err(unshared)?;
        Ok(Line { steps, motion, orders })
    }

    fn steps(&self) -> impl Iterator<Item = i64> {
        self.steps.iter().map(|way| way.get().into())
    }
}

/// The failure for a line that can't be ordered, with a hint.
fn unshared(why: NoLine) -> Failure {
    let failure = Failure::new(why.to_string());
    match why {
        NoLine::Whole(_) => failure,
        NoLine::Share { why, least, .. } => failure.hint(match why.what {
            "jerk" => {
                format!("a board takes whole steps/s³, 1 or more: give --jerk {least} or more")
            }
            _ => format!(
                "a board takes whole steps/s², 1 or more: give --accel {least} or more, and no \
                 smaller --decel"
            ),
        }),
    }
}

fn go(
    session: &mut Session,
    args: &Args,
    axes: &[AxisId],
    ways: &[Way],
    built: &[GeometryArgs],
) -> Result<(), Failure> {
    if let Some(last) = axes.last() {
        target::has_axis(session, *last).map_err(|failure| {
            let there = session.info().map_or(1, |info| info.axes);
            failure.hint(format!("a line has a number for each axis: {there} at most here"))
        })?;
    }
    let mut from = Vec::new();
    for axis in axes {
        from.push(start_position(session, *axis)?);
    }
    let line = Line::of(args, ways, built, &from)?;
    let Line { motion, orders, .. } = &line;
    able::to_bend(session, &motion.order)?;
    let lines: Vec<Command> = Script::new(orders)?.collect();
    let apart = apart(orders);
    let begun = session.now();
    let starts: Vec<_> = orders
        .iter()
        .map(|(axis, order)| Start {
            axis: *axis,
            from: from.get(axis.index()).copied(),
            order: *order,
        })
        .collect();
    let start = session.begin_together(&starts, &lines);
    if args.order.format == Format::Text && drive::has_plan(&start) {
        let steps = numbers(line.steps());
        let mixed = ways.iter().any(|way| way.given().converted());
        say::result(format_args!("line of {steps} steps on {}", session.link().name()));
        ways.iter().zip(axes).filter(|_| mixed).for_each(|(way, axis)| {
            say::result(format_args!("  {:<12}{}", format!("axis {}", axis.number()), way.given()));
        });
        motion.show().iter().for_each(say::result);
        if !lines.is_empty() {
            say::result(format_args!("  {:<12}{}", "lines", listed(&lines)));
        }
    }
    if apart > NOTABLE && drive::has_plan(&start) {
        say::note(format_args!("the axes end within {} of each other", seconds(apart)));
    }
    let off = off(orders);
    if off > NEAR && drive::has_plan(&start) {
        say::note(format_args!(
            "the axes leave the line by up to {off:.0} steps: their accelerations are rounded; \
             higher ones keep closer"
        ));
    }
    if let Err(not) = start {
        return Err(match not {
            // Axes that may have begun by then are killed as well.
            NotBegun::Trouble { trouble: LinkError::Killed, .. } => {
                lost(session, &LinkError::Killed)
            }
            not => {
                let wait = |(_, order): &&(_, Order)| longest_wait(order);
                let slow = orders.iter().max_by(|a, b| wait(a).total_cmp(&wait(b)));
                let slow = slow.map_or(&motion.order, |(_, order)| order);
                drive::order_not_begun(session, not, slow)
            }
        });
    }
    let watched = watch(session, axes);
    let took = session.now().saturating_sub(begun).as_secs_f64();
    let (braked, at) = match watched {
        Ok(watched) => watched,
        Err(trouble) => {
            if args.order.format == Format::Text {
                say::result("position uncertain");
            }
            return Err(lost(session, &trouble));
        }
    };
    // Another terminal may have retargeted an axis.
    let ordered = from.iter().zip(line.steps()).map(|(from, by)| from.saturating_add(by));
    let targets = axes.iter().zip(ordered);
    let targets: Vec<i64> =
        targets.map(|(axis, to)| session.new_target(*axis).unwrap_or(to)).collect();
    let known: Option<Vec<i64>> = at.iter().copied().collect();
    let state = match &known {
        Some(at) if *at == targets => "ready",
        Some(_) => "stopped",
        None => "uncertain",
    };
    match args.order.format {
        Format::Json => say::json(in_units(
            &units(built).collect::<Vec<_>>(),
            json!({
                "from": from,
                "steps": line.steps().collect::<Vec<_>>(),
                "target": targets,
                "position": at,
                "state": state,
                "seconds": took,
                "apart": apart,
                "board": session.link().name(),
                "motion": motion.json(),
                "lines": lines.iter().map(ToString::to_string).collect::<Vec<_>>(),
            }),
            &["from", "steps", "target", "position"],
        )),
        Format::Text => match &known {
            Some(at) => {
                let at: Vec<_> = at.iter().map(i64::to_string).collect();
                say::result(format_args!("position {} {state}", at.join(" ")));
            }
            None => say::result("position uncertain"),
        },
    }
    match state {
        "ready" => Ok(()),
        "stopped" if braked => Err(Failure::interrupted("braked before the end of the line")
            .hint("the positions are known")),
        "stopped" => Err(stopped(session, axes)),
        _ => Err(Failure::new("a position is uncertain: something has killed the motion")
            .hint("if it stands at a known place, or to go and find one: `stepwright zero`")),
    }
}

/// The failure if an axis is not at its target: the first axis that was stopped, and the reason.
fn stopped(session: &mut Session, axes: &[AxisId]) -> Failure {
    let why = axes.iter().find_map(|axis| Some((axis.number(), session.stop_of(*axis)?)));
    match why {
        Some((axis, stop)) => Failure::new(format!("axis {axis} was stopped by {}", stop.words()))
            .hint("the positions are known"),
        None if session.was_changed() => {
            Failure::new("the axes don't rest where they were ordered to")
                .hint("another terminal has changed a travel")
        }
        None => Failure::new("the axes don't rest where they were ordered to")
            .hint("did another master, a switch or a reset stop them, or noise change a digit?"),
    }
}

/// Waits until all axes are at rest. Returns whether they were braked, and each position, if known.
fn watch(session: &mut Session, axes: &[AxisId]) -> Result<(bool, Vec<Option<i64>>), LinkError> {
    let (mut braked, mut told) = (false, Instant::now());
    while session.is_busy(Selection::All)? {
        if !braked && interrupt::asked() {
            session.stop(Selection::All)?;
            braked = true;
            say::note(interrupt::braking());
        }
        while let Some(change) = session.next_change() {
            say::note(match change.axes {
                Selection::One(axis) => {
                    format!("another terminal, axis {}: {change}", axis.number())
                }
                Selection::All => format!("another terminal: {change}"),
            });
        }
        if told.elapsed() >= LINES {
            told = Instant::now();
            let at =
                axes.iter().map(|axis| session.position(*axis)).collect::<Result<Vec<_>, _>>()?;
            let at: Vec<_> = at.into_iter().flatten().map(|at| at.to_string()).collect();
            say::note(format_args!("position {}", at.join(" ")));
        }
        session.pause(POLL)?;
    }
    let at = axes.iter().map(|axis| session.rest_position(*axis)).collect::<Result<_, _>>()?;
    Ok((braked, at))
}

/// The failure of a watch. After a second Ctrl-C, kills all axes.
fn lost(session: &mut Session, trouble: &LinkError) -> Failure {
    let look =
        "the motors may still be moving: look at them, and switch off their power if they are";
    if let LinkError::Killed = trouble {
        return match session.kill() {
            Ok(true) => Failure::interrupted("killed: the motors may have lost steps")
                .hint("if one stands at a known place, or to go and find one: `stepwright zero`"),
            _ => Failure::interrupted("the board did not confirm K").hint(look),
        };
    }
    Failure::new(format!("{}: {trouble}", session.link().name())).hint(look)
}

/// Numbers with their signs, separated by spaces.
fn numbers(all: impl Iterator<Item = i64>) -> String {
    all.map(|n| format!("{n:+}")).collect::<Vec<_>>().join(" ")
}
