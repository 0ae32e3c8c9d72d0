//! `stepwright home`: finds position 0 with a limit switch, by [`homing`].

use stepwright_protocol::{AxisId, Command, Direction, Distance, Setting, Travel, Value};

use super::motion::{MOTION, Motion};
use super::screen::Screen;
use super::settings;
use super::target::{self, AxisArgs, Format, MotionArgs};
use super::travel::{Way, no_position, print_rest};
use super::{drive, homing};
use crate::board::recording::Heading;
use crate::failure::Failure;
use crate::interrupt::{self, While};
use crate::quantity::{DistanceArg, SpeedArg};
use crate::say;
use stepwright_host::home::{HomeSight, NotHomed};
use stepwright_host::homing::{HomeLeg, HomeOrder, SwitchSide};
use stepwright_host::link::serial::Share;
use stepwright_host::motion::{Action, NotBegun};
use stepwright_host::{LinkError, Session};
use stepwright_sim::Switch;

/// The position of a virtual machine's switch.
const VIRTUAL_SWITCH: i64 = -1000;

/// The greatest distance to a virtual machine's switch.
const VIRTUAL_WITHIN: i32 = 2000;

/// Find position 0 with the limit switch of an axis
///
/// The axis moves towards its switch until the switch stops it, backs off, approaches again
/// slowly, takes the place where the switch stops it as 0, and backs off once more. The last
/// line on standard output is `position N ready`, where N is the distance from the switch; only
/// then the exit status is 0.
#[derive(clap::Args)]
#[command(after_help = "\
The board must know the switch: `stepwright settings set switches=1` (1 X, 2 Y, 4 Z, added
up). The switch is at the backward end, unless the setting `switch-forward` has the axis.

Without --port a virtual board is homed, with a switch 1000 steps backward of its position.

With --port, --within is required: a little more than the axis can travel. An axis that finds
no switch within this distance stops, and does not push against its end for ever. If soft limits
or `home-first` make the board refuse this distance, the command runs the axis without a target
and brakes it to end there; it may go further by what it travels while a line is sent to the
board. Ctrl-C brakes, and a second Ctrl-C kills. With the setting `safe-start` the command
acknowledges the stops by the switch.

Examples:
  stepwright home
  stepwright home --within 3000 --port /dev/ttyUSB0
  stepwright home --axis 2 --within 300mm --speed 20mm/s --slow 1mm/s --back-off 2mm \\
      --mm-per-rev 8 --port /dev/ttyUSB0")]
pub struct Args {
    /// Speed towards the switch, the first time
    #[arg(long, value_name = "SPEED", allow_negative_numbers = true, default_value = "500", help_heading = MOTION)]
    speed: SpeedArg,
    /// Speed towards the switch, the second time
    #[arg(long, value_name = "SPEED", allow_negative_numbers = true, default_value = "50", help_heading = MOTION)]
    slow: SpeedArg,
    /// Distance to back off from the closed switch: steps, or like 2mm
    #[arg(long, value_name = "DISTANCE", default_value = "50", help_heading = MOTION)]
    back_off: DistanceArg,
    /// Greatest distance to the switch: the axis stops there if no switch has stopped it [on a
    /// virtual board: 2000]
    #[arg(long, value_name = "DISTANCE", help_heading = MOTION)]
    within: Option<DistanceArg>,
    #[command(flatten)]
    order: MotionArgs,
    #[command(flatten)]
    on: AxisArgs,
}

/// Homes the axis, and prints its position.
pub fn run(args: Args) -> Result<(), Failure> {
    // Invalid options are refused before anything moves.
    let (back_off, within) = (args.distance(&args.back_off, "--back-off")?, args.within()?);
    if back_off >= within {
        let what = format!("--back-off {back_off} is not less than --within {within}");
        return Err(Failure::usage(what).hint("the axis would not find its switch again"));
    }
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
    print_rest(&args.order, &session, args.on.axis, at);
    finished
}

/// A virtual board with a limit switch that is set in its settings.
fn virtual_machine(args: &Args) -> Result<Session, Failure> {
    let title = format!("Axis {} homing", args.on.axis.number());
    let heading = Heading { title, unit: args.order.ramps.unit(), ..Heading::default() };
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

    /// The greatest distance to the switch, in steps.
    fn within(&self) -> Result<i32, Failure> {
        match &self.within {
            Some(within) => self.distance(within, "--within"),
            None if self.order.port.port.is_none() => Ok(VIRTUAL_WITHIN),
            None => Err(Failure::usage("home needs --within: how far the switch may be").hint(
                "give a little more than the axis can travel, like --within 300mm, or write \
                 home-within = \"300mm\" into the machine file",
            )),
        }
    }

    /// The side of the axis' switch, by the settings of the board.
    fn side(&self, session: &mut Session) -> Result<SwitchSide, Failure> {
        let listed = settings::ask(session)?;
        SwitchSide::of(self.on.axis, &listed).map_err(|switches| {
            let (name, axis) = (session.link().name(), self.on.axis.number());
            let what = format!("{name} knows of no limit switch of axis {axis}");
            Failure::new(what).hint(format!(
                "if there is one: `stepwright settings set --port {name} switches={switches}` \
                 (1 X, 2 Y, 4 Z, added up)"
            ))
        })
    }
}

/// Homes the axis. Returns its position.
fn home(session: &mut Session, args: &Args) -> Result<i64, Failure> {
    target::has_axis(session, args.on.axis)?;
    let side = args.side(session)?;
    let way = match side.towards {
        Direction::Forward => "forward",
        Direction::Backward => "backward",
    };
    let (axis, name) = (args.on.axis.number(), session.link().name());
    tell(args, format!("axis {axis} {way} to its switch on {name}"));
    let back_off = args.distance(&args.back_off, "--back-off")?.unsigned_abs();
    let within = args.within()?.unsigned_abs();
    let any = Travel::By(Distance::new(0));
    let fast = args.motion(&args.speed, "--speed", any)?;
    let slow = args.motion(&args.slow, "--slow", any)?;
    let order = HomeOrder { side, fast: fast.order, slow: slow.order, back_off, within };
    if interrupt::asked() {
        return Err(Failure::interrupted("interrupted before 0 was found"));
    }
    let mut screen = None;
    let homed = session.wait(async |talk| {
        talk.home(&order, |talk, sight| match sight {
            HomeSight::Begins(leg, order, from) => {
                let motion = if leg == HomeLeg::Approach { &slow } else { &fast };
                let motion = motion.with_travel(order.travel);
                screen = Some(Screen::of(talk, &motion, from.unwrap_or(0)));
                Action::GoOn
            }
            HomeSight::Sees(sight) => match &mut screen {
                Some(screen) => screen.see(talk, sight),
                None => Action::GoOn,
            },
            HomeSight::Ends => {
                screen.take().map(Screen::end);
                Action::GoOn
            }
            HomeSight::Note(note) => {
                tell(args, note.to_owned());
                Action::GoOn
            }
        })
        .await
    });
    screen.take().map(Screen::end);
    match homed {
        Ok(Ok(at)) => Ok(at),
        Ok(Err(not)) => Err(failed(session, args.on.axis, not)),
        Err(trouble) => Err(failed(session, args.on.axis, NotHomed::Adrift(trouble))),
    }
}

/// The failure of a homing. After a second Ctrl-C, kills all axes.
fn failed(session: &mut Session, axis: AxisId, not: NotHomed) -> Failure {
    match not {
        NotHomed::Failed(failure, leg) => match leg.is_towards() {
            _ if !interrupt::asked() => homing::failure(failure),
            true => Failure::interrupted("braked before the switch was found"),
            false => Failure::interrupted("braked while backing off"),
        },
        NotHomed::Adrift(trouble)
        | NotHomed::NotBegun(NotBegun::Trouble { trouble, moving: true }) => {
            let ended = drive::conclude(session, axis, Err(trouble));
            ended.failure.unwrap_or_else(|| Failure::interrupted("stopped before 0 was found"))
        }
        NotHomed::Trouble(LinkError::Killed)
        | NotHomed::NotBegun(NotBegun::Trouble { trouble: LinkError::Killed, .. }) => {
            Failure::interrupted("interrupted before 0 was found")
        }
        NotHomed::Trouble(trouble) => no_position(session, axis, &trouble),
        NotHomed::NotBegun(not) => drive::not_begun(session, not),
        NotHomed::Unsayable(range) => Failure::from(range),
    }
}

fn tell(args: &Args, text: String) {
    if args.order.format == Format::Text {
        say::result(text);
    }
}
