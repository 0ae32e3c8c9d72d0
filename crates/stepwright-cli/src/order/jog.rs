//! `stepwright jog`: a motor runs while a key is held.

use std::io::{self, Write};
use std::time::Duration;

use stepwright_protocol::{
    AxisId, Command, Direction, Distance, MilliSpeed, Reply, Selection, Travel,
};

use super::drive;
use super::held::{ASK_RELEASES, Decoder, Hold, Key, NO_RELEASES};
use super::keys;
use super::lease::{self, LeaseArgs};
use super::motion::{MOTION, Motion};
use super::progress::Line;
use super::target::{self, AxisArgs, Format, MotionArgs};
use super::terminal::{self, Keys};
use super::travel::{Way, last_line, print_rest, start_position};
use crate::board::recording::Heading;
use crate::failure::Failure;
use crate::interrupt::{self, While};
use crate::quantity::{DistanceArg, SpeedArg};
use crate::say;
use stepwright_host::motion::{NotBegun, RestPlace};
use stepwright_host::{LinkError, Session};

/// Run an axis while an arrow key is held
///
/// The motor follows its ramps, so it still brakes for a moment after the key is released. The
/// last line on standard output is its position.
#[derive(clap::Args)]
#[command(mut_arg("lease", |arg| arg.help("\
    Have the board brake if it receives nothing from this command for this time: 500ms, 2s; from \
    200ms to 60s [default: 500ms, if the board grants leases]")))]
#[command(after_help = "\
Keys:
  → ↑   forward while held        . ,    one --step forward, backward
  ← ↓   backward while held       + -    faster, slower by a tenth
  space stop                      0      set this position to 0
  q     end

Most terminals don't report a released key, but repeat a held one: the motor brakes
0.7 s after a single press, 0.25 s after the last repeat. In kitty, foot, WezTerm,
Ghostty and others, and on Windows, it brakes when the key is released.

Ctrl-C brakes and ends, a second one kills. The board brakes by itself if it receives
nothing from this command for the time of --lease, also if the command is killed or the
cable is pulled. A board that grants no lease brakes after its setting timeout-ms; without
that it does not brake.

Examples:
  stepwright jog
  stepwright jog --port /dev/ttyUSB0 --top-speed 10mm/s --step 0.1mm --mm-per-rev 8")]
pub struct Args {
    /// Distance of the keys . and ,: steps, or like 0.1mm, 1deg
    #[arg(long, value_name = "DISTANCE", default_value = "1", allow_negative_numbers = true)]
    step: DistanceArg,
    /// Speed while a key is held
    #[arg(long, alias = "speed", value_name = "SPEED", allow_negative_numbers = true, default_value = "1000", help_heading = MOTION)]
    top_speed: SpeedArg,
    #[command(flatten)]
    order: MotionArgs,
    #[command(flatten)]
    on: AxisArgs,
    #[command(flatten)]
    lease: LeaseArgs,
}

/// The keys, for the user.
const HELP: &str =
    "keys: arrows run while held; . , a step; + - faster, slower; space stop; 0 zero; q end";

/// The time between two polls of the keys and the motor.
const POLL: Duration = Duration::from_millis(20);

impl Args {
    fn motion(&self, top: &SpeedArg, travel: Travel) -> Result<Motion, Failure> {
        self.order.ramps.motion(self.on.axis, top, "--top-speed", travel)
    }
}

/// Jogs, and prints the final position.
pub fn run(args: Args) -> Result<(), Failure> {
    let step = Way::of(Some(&args.step), None, &args.order.ramps.geometry()?)?.steps(0)?;
    if step.get() < 1 {
        return Err(Failure::usage(format!("--step {}: 1 step or more", step.get())));
    }
    let motion = args.motion(&args.top_speed, Travel::Endless(Direction::Forward))?;
    if args.order.virt.fast {
        return Err(Failure::usage("a jog is as fast as your fingers: leave --fast out"));
    }
    if !terminal::is_there() {
        return Err(Failure::new("a jog needs a terminal: its keys are read there")
            .hint("without one: `stepwright run ±SPEED --for TIME`, or `stepwright move`"));
    }
    interrupt::listen(While::Holding)?;
    let heading =
        Heading { title: "Jog".to_owned(), unit: args.order.ramps.unit(), ..Heading::default() };
    let mut session = args.order.port.or_virtual(&args.order.virt, "jog", heading)?;
    let result = jog(&mut session, &args, step.get(), motion);
    let finished = target::finish(&mut session);
    let at = result?;
    print_rest(&args.order, &session, args.on.axis, at);
    finished
}

/// Follows the keys until the end. Returns the axis' position.
fn jog(session: &mut Session, args: &Args, step: i32, motion: Motion) -> Result<i64, Failure> {
    target::has_axis(session, args.on.axis)?;
    let lease = args.lease.or_hands(session)?;
    let at = start_position(session, args.on.axis)?;
    let top = motion.order.top.millisteps();
    let Some(keys) = Keys::listen() else {
        return Err(Failure::new("the terminal gives no keys")
            .hint("is the command in the background? `fg` brings it back"));
    };
    let _releases = Releases::ask();
    let line = Line::new();
    line.note(HELP);
    if lease.is_none() && args.order.port.port.is_some() {
        line.note(
            "this board grants no lease: if the cable is pulled it brakes by its setting \
             timeout-ms, and goes on where that is 0",
        );
    }
    let mut jog = Jog {
        axis: args.on.axis,
        lines_before: lease.map(Command::Lease).into_iter().collect(),
        step,
        top,
        line,
        hold: Hold::new(),
        steps_due: 0,
        moving: None,
        moved: true,
        at,
        leaving: false,
    };
    let followed = jog.follow(session, args, &keys);
    jog.line.end();
    let moving = jog.moving.is_some();
    let ended = match followed {
        Ok(at) => {
            if lease.is_some() {
                lease::give_back(session);
            }
            return Ok(at);
        }
        Err(Stopped::Failure(failure)) => return Err(failure),
        Err(Stopped::Trouble(trouble)) if !moving => {
            return Err(target::lost(&session.link().name(), &trouble));
        }
        Err(Stopped::Trouble(trouble)) => drive::conclude(session, args.on.axis, Err(trouble)),
    };
    if let (RestPlace::Uncertain, Format::Text) = (ended.end, args.order.format) {
        say::result(last_line("uncertain", None, None));
    }
    Err(ended.failure.unwrap_or_else(|| Failure::interrupted("interrupted while it moved")))
}

/// Makes the terminal report released keys, until this is dropped.
struct Releases;

impl Releases {
    fn ask() -> Releases {
        say_raw(ASK_RELEASES);
        Releases
    }
}

impl Drop for Releases {
    fn drop(&mut self) {
        say_raw(NO_RELEASES);
    }
}

/// Sends a sequence to the terminal. Errors are ignored: no motor waits for it. A console of Windows reports
/// releases unasked.
fn say_raw(word: &str) {
    if cfg!(unix) && terminal::has_sequences() {
        let mut err = io::stderr().lock();
        let _ = err.write_all(word.as_bytes()).and_then(|()| err.flush());
    }
}

/// Why the jog ended.
enum Stopped {
    Trouble(LinkError),
    Failure(Failure),
}

impl From<LinkError> for Stopped {
    fn from(trouble: LinkError) -> Stopped {
        Stopped::Trouble(trouble)
    }
}

/// An order in execution.
struct Moving {
    /// The direction whose key must stay held; `None` for a step.
    way: Option<Direction>,
    braking: bool,
}

/// The state of a jog.
struct Jog {
    axis: AxisId,
    /// The commands before each order: the lease.
    lines_before: Vec<Command>,
    step: i32,
    /// The top speed in 0.001 steps/s.
    top: u32,
    line: Line,
    hold: Hold,
    /// Steps that were requested and not begun, positive forward.
    steps_due: i32,
    moving: Option<Moving>,
    /// Whether the axis moved at the last poll.
    moved: bool,
    at: i64,
    leaving: bool,
}

impl Jog {
    /// Follows the keys. Returns the final position of the axis.
    fn follow(&mut self, session: &mut Session, args: &Args, keys: &Keys) -> Result<i64, Stopped> {
        let mut decoder = Decoder::default();
        loop {
            while let Some(byte) = keys.next() {
                if let Some(key) = decoder.take(byte) {
                    self.key(session, key)?;
                }
            }
            self.leaving |= interrupt::asked() || keys.are_gone();
            let wanted = self.hold.wanted(session.now()).filter(|_| !self.leaving);
            match &self.moving {
                None if self.leaving => return Ok(self.at),
                None if wanted.is_some() => {
                    let travel = wanted.map(Travel::Endless);
                    self.begin(session, args, travel, wanted)?;
                }
                None if self.steps_due != 0 => {
                    let by = Distance::new(self.steps_due);
                    self.steps_due = 0;
                    self.begin(session, args, Some(Travel::By(by)), None)?;
                }
                None => {}
                Some(moving) => {
                    let let_go = moving.way.is_some() && moving.way != wanted;
                    if (let_go || self.leaving) && !moving.braking {
                        self.stop(session)?;
                    }
                }
            }
            self.look(session)?;
            session.pause(POLL)?;
        }
    }

    /// Carries out a key. The loop in `follow` carries out the arrows.
    fn key(&mut self, session: &mut Session, key: Key) -> Result<(), LinkError> {
        let now = session.now();
        match key {
            Key::Down(way) => self.hold.down(way, now),
            Key::Up(way) => self.hold.up(way),
            Key::Sign(b'.' | b'>') => self.steps_due = self.steps_due.saturating_add(self.step),
            Key::Sign(b',' | b'<') => self.steps_due = self.steps_due.saturating_sub(self.step),
            Key::Sign(b'+' | b'=') => {
                self.change_top(session, self.top.saturating_add(keys::part(self.top)))?;
            }
            Key::Sign(b'-' | b'_') => {
                self.change_top(session, self.top.saturating_sub(keys::part(self.top)))?;
            }
            Key::Sign(b' ' | b's' | b'S') => {
                self.hold.spend(now);
                self.steps_due = 0;
                if self.moving.as_ref().is_some_and(|moving| !moving.braking) {
                    self.stop(session)?;
                }
            }
            Key::Sign(b'0') if self.moving.is_some() => self.line.note("it moves: 0 at rest"),
            Key::Sign(b'0') => {
                let zeroed = session.ask(Command::Zero(self.axis))? == Reply::Yes;
                self.line.note(if zeroed { "this place is 0" } else { "the board refused 0" });
                if zeroed {
                    (self.at, self.moved) = (0, true);
                }
            }
            Key::Sign(b'q' | b'Q') => self.leaving = true,
            Key::Sign(_) | Key::Other => self.line.note(HELP),
        }
        Ok(())
    }

    /// Sets the top speed, in 0.001 steps/s, of the order in execution and of further ones.
    fn change_top(&mut self, session: &mut Session, top: u32) -> Result<(), LinkError> {
        let top = MilliSpeed::clamped(top);
        let runs = self.moving.as_ref().is_some_and(|moving| !moving.braking);
        if runs {
            let command = keys::changed_top(top.get());
            if session.ask_of(Selection::One(self.axis), command)? != Reply::Yes {
                let why = session.why()?.map_or(String::new(), |why| format!(": {why}"));
                self.line.note(&format!("the board refused {command}{why}"));
                return Ok(());
            }
        }
        self.top = top.get();
        self.line.note(&format!("top speed {} steps/s", keys::shown(self.top)));
        Ok(())
    }

    /// Starts an order. If the board refuses it, prints the refusal and spends its key.
    fn begin(
        &mut self,
        session: &mut Session,
        args: &Args,
        travel: Option<Travel>,
        way: Option<Direction>,
    ) -> Result<(), Stopped> {
        let Some(travel) = travel else { return Ok(()) };
        let top = keys::shown(self.top).to_string();
        let top = top.parse().map_err(|_| Stopped::Failure(Failure::new("no speed")))?;
        let motion = args.motion(&top, travel).map_err(Stopped::Failure)?;
        let mut lines = self.lines_before.clone();
        lines.extend(motion.lines().map_err(Stopped::Failure)?);
        match session.begin(self.axis, &motion.order, &lines, Some(self.at)) {
            Ok(()) => self.moving = Some(Moving { way, braking: false }),
            Err(NotBegun::Trouble { trouble, moving }) => {
                self.moving = moving.then_some(Moving { way, braking: false });
                return Err(Stopped::Trouble(trouble));
            }
            Err(not) => {
                self.hold.spend(session.now());
                self.line.note(drive::not_begun(session, not).message());
            }
        }
        Ok(())
    }

    fn stop(&mut self, session: &mut Session) -> Result<(), LinkError> {
        session.stop(Selection::One(self.axis))?;
        if let Some(moving) = &mut self.moving {
            moving.braking = true;
        }
        if self.leaving {
            self.line.note(interrupt::braking());
        }
        Ok(())
    }

    /// Polls the axis, and shows its position.
    fn look(&mut self, session: &mut Session) -> Result<(), Stopped> {
        let mut word = "ready";
        if let Some(moving) = &self.moving {
            let busy = session.is_busy(Selection::One(self.axis))?;
            let at = if busy {
                session.position(self.axis)?
            } else {
                session.rest_position(self.axis)?
            };
            let Some(at) = at else {
                self.moving = None;
                return Err(Stopped::Failure(
                    Failure::new("the position is uncertain: something has killed the motion")
                        .hint("if it stands at a known place, call it 0: `stepwright zero`"),
                ));
            };
            self.at = at;
            word = if busy { "busy" } else { "ready" };
            if !busy {
                let by_itself = moving.way.is_some() && !moving.braking;
                self.moving = None;
                if by_itself {
                    self.hold.spend(session.now());
                    let stop = session.stop_of(self.axis);
                    let by = stop.map_or("something else", |stop| stop.words());
                    self.line.note(&format!("stopped by {by}"));
                }
            }
        }
        let state = format!("position {} {word}", self.at);
        let moves = self.moving.is_some();
        self.line.show(&[&state, &self.at.to_string()], &state, self.moved && !moves);
        self.moved = moves;
        Ok(())
    }
}
