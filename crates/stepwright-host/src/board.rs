//! A board, and its axes: orders and their outcomes.

use std::fmt;
use std::time::Duration;

use stepwright::{Accel, Jerk, OutOfRange, Speed};
use stepwright_protocol::{
    AxisId, Command, Direction, Distance, MilliSpeed, Order, Ramp, Refusal, Reply, Script,
    Selection, Stop, Travel,
};

use crate::conversation::LinkError;
use crate::home::{HomeOrder, NotHomed};
use crate::homing::{HomingFailure, SwitchSide};
use crate::link::Link;
use crate::motion::{Action, Adrift, Ended, NotBegun, POLL, RestPlace, Sight};
use crate::session::Session;

/// How an axis moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionLimits {
    /// The speed that the motor jumps to from rest, and stops from: 0 … 1,000,000 steps/s.
    pub start: Speed,
    /// The speed between the ramps: 0.001 … 1,000,000 steps/s.
    pub top: Speed,
    /// Up to it: 1 … 100,000,000 steps/s².
    pub accel: Accel,
    /// Back down.
    pub decel: Accel,
    /// The limit of jerk, for a board that has S-curves.
    pub jerk: Option<Jerk>,
}

impl MotionLimits {
    /// From rest to this speed and back, at this acceleration.
    pub const fn new(top: Speed, accel: Accel) -> MotionLimits {
        MotionLimits { start: Speed::ZERO, top, accel, decel: accel, jerk: None }
    }

    fn order(&self, travel: Travel) -> Order {
        let MotionLimits { start, top, accel, decel, jerk } = *self;
        Order { start, top, up: Ramp::Accel(accel), down: Ramp::Accel(decel), jerk, travel }
    }
}

impl Default for MotionLimits {
    /// 1,000 steps/s, there after 200 steps from a start speed of 50 steps/s.
    fn default() -> MotionLimits {
        const fn speed(steps: u32) -> Speed {
            match Speed::from_steps(steps) {
                Ok(speed) => speed,
                Err(_) => Speed::MAX,
            }
        }
        const ACCEL: Accel = match Accel::from_steps(2_494) {
            Ok(accel) => accel,
            Err(_) => panic!("an acceleration"),
        };
        MotionLimits { start: speed(50), ..MotionLimits::new(speed(1_000), ACCEL) }
    }
}

/// What became of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The axis rests where it was ordered to.
    Reached {
        /// There, in steps.
        at: i64,
    },
    /// It rests elsewhere.
    Stopped {
        /// There, in steps.
        at: i64,
        /// What has stopped it, if the board says so.
        reason: Option<Stop>,
    },
    /// It is not known where it is: a kill, or something like it, has lost steps.
    Uncertain,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Outcome::Reached { at } => write!(f, "reached {at}"),
            Outcome::Stopped { at, reason: Some(stop) } => {
                write!(f, "stopped at {at} by {}", stop.words())
            }
            Outcome::Stopped { at, reason: None } => write!(f, "stopped at {at}"),
            Outcome::Uncertain => f.write_str("position uncertain"),
        }
    }
}

/// Why an order was not carried out, or is not known to have been.
#[derive(Debug)]
pub enum Error {
    /// The port can't be opened.
    #[cfg(feature = "serial")]
    Open(crate::link::serial::OpenError),
    /// The conversation has ended. `moving` if the motor may move all the same.
    Lost {
        /// Why.
        trouble: LinkError,
        /// Whether a motor may be moving.
        moving: bool,
    },
    /// The board has this many axes, and not this one.
    NoAxis {
        /// As many as it has.
        axes: u8,
    },
    /// A number is outside its range.
    Range(OutOfRange),
    /// A travel has at most 2³¹ − 1 steps.
    TooFar {
        /// As many as were asked for.
        steps: i64,
    },
    /// The board refused this line; nothing moves by it.
    Refused {
        /// The line.
        line: Command,
        /// Its reason, if it says so.
        reason: Option<Refusal>,
    },
    /// Every attempt to give the order was spoiled on its way; nothing moves by it.
    Noise,
    /// The axis moves: wait for it, stop it, or change its travel.
    Moving,
    /// Where the axis stands is not known: home it, or call the place 0.
    Uncertain,
    /// The board knows of no limit switch of the axis: the setting `switches` names them.
    NoSwitch,
    /// The axis is not homed.
    NotHomed(HomingFailure),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            #[cfg(feature = "serial")]
            Error::Open(error) => error.fmt(f),
            Error::Lost { trouble, moving: false } => trouble.fmt(f),
            Error::Lost { trouble, moving: true } => write!(f, "{trouble}; a motor may be moving"),
            Error::NoAxis { axes } => write!(f, "no such axis: give 1 to {axes}"),
            Error::Range(range) => range.fmt(f),
            Error::TooFar { steps } => {
                write!(f, "{steps} steps are too far for one travel: at most 2147483647")
            }
            Error::Refused { line, reason: Some(why) } => write!(f, "{line} was refused: {why}"),
            Error::Refused { line, reason: None } => write!(f, "{line} was refused"),
            Error::Noise => f.write_str("every attempt was spoiled by noise; nothing has moved"),
            Error::Moving => {
                f.write_str("the axis moves: wait for it, stop it, or change its travel")
            }
            Error::Uncertain => {
                f.write_str("the position is uncertain: home the axis, or set its position")
            }
            Error::NoSwitch => {
                f.write_str("the board knows of no limit switch of this axis (setting switches)")
            }
            Error::NotHomed(failure) => write!(f, "not homed: {failure}"),
        }
    }
}

impl std::error::Error for Error {}

impl From<OutOfRange> for Error {
    fn from(range: OutOfRange) -> Error {
        Error::Range(range)
    }
}

/// Nobody can tell whether a motor moves.
impl From<LinkError> for Error {
    fn from(trouble: LinkError) -> Error {
        Error::Lost { trouble, moving: true }
    }
}

impl From<NotBegun> for Error {
    fn from(not: NotBegun) -> Error {
        match not {
            NotBegun::Refused(line, reason) => Error::Refused { line, reason },
            NotBegun::Trouble { trouble, moving } => Error::Lost { trouble, moving },
            NotBegun::Noise => Error::Noise,
        }
    }
}

impl From<NotHomed> for Error {
    fn from(not: NotHomed) -> Error {
        match not {
            NotHomed::NotBegun(not) => not.into(),
            NotHomed::Unsayable(range) => Error::Range(range),
            NotHomed::Failed(failure, _) => Error::NotHomed(failure),
            NotHomed::Trouble(trouble) => Error::Lost { trouble, moving: false },
            NotHomed::Adrift(trouble) => Error::Lost { trouble, moving: true },
        }
    }
}

/// A board that was met. When it is dropped its motors go on; [`stop`](Board::stop) brakes them.
pub struct Board {
    session: Session,
}

impl Board {
    /// The board on a serial port, at 115,200 baud. Other programs of this user may ask it, and
    /// change its travels, while this one waits for them.
    ///
    /// # Errors
    /// [`Error::Open`]; [`Error::Lost`] if no board answers within 4 s.
    #[cfg(feature = "serial")]
    pub fn open(path: impl AsRef<std::path::Path>) -> Result<Board, Error> {
        use crate::link::serial::{SerialLink, Share};
        let path = path.as_ref();
        let link = SerialLink::open(path, 115_200, Share::Host, |path| {
            #[cfg(unix)]
            return crate::link::lease::let_run_out(path, |_| (), || false);
            #[cfg(not(unix))]
            return path.exists();
        });
        let mut session = Session::new(Box::new(link.map_err(Error::Open)?));
        #[cfg(unix)]
        if let Some(host) = crate::link::host::Host::open(path) {
            session.serve(Box::new(host));
        }
        Board::of(session)
    }

    /// The board on a port that another program of this user holds, through that program. It
    /// answers questions, changes travels and stops; orders and settings it refuses.
    ///
    /// # Errors
    /// [`Error::Open`] if nobody who holds the port lets others in; [`Error::Lost`].
    #[cfg(all(unix, feature = "serial"))]
    pub fn join(path: impl AsRef<std::path::Path>) -> Result<Board, Error> {
        use crate::link::guest::{GuestLink, PATIENCE};
        use crate::link::serial::OpenError;
        let link = GuestLink::open(path.as_ref(), PATIENCE);
        let nobody = || Error::Open(OpenError::Io(std::io::ErrorKind::NotFound.into()));
        Board::on(Box::new(link.ok_or_else(nobody)?))
    }

    /// A virtual Uno in this process: the engine of the chip with simulated pins. Its time passes
    /// as ours does, or, if it is `fast`, as fast as it can be simulated.
    ///
    /// # Errors
    /// None that a whole process has seen.
    #[cfg(feature = "virtual")]
    pub fn virtual_uno(fast: bool) -> Result<Board, Error> {
        use crate::link::simulated::{VirtualLink, VirtualUno};
        Board::on(Box::new(VirtualLink::new(VirtualUno::new(), fast)))
    }

    /// The board at the other end of a line.
    ///
    /// # Errors
    /// [`Error::Lost`] if no board answers within 4 s.
    pub fn on(link: Box<dyn Link>) -> Result<Board, Error> {
        Board::of(Session::new(link))
    }

    /// Nothing moves by us yet.
    fn of(mut session: Session) -> Result<Board, Error> {
        session.meet().map_err(|trouble| Error::Lost { trouble, moving: false })?;
        Ok(Board { session })
    }

    /// An axis by its number: 1 is X.
    ///
    /// # Errors
    /// [`Error::NoAxis`]
    pub fn axis(&mut self, number: u8) -> Result<Axis<'_>, Error> {
        let axes = self.session.info().map_or(1, |info| info.axes);
        let id = AxisId::numbered(number).filter(|_| number <= axes);
        let id = id.ok_or(Error::NoAxis { axes })?;
        Ok(Axis { session: &mut self.session, id })
    }

    /// Brakes every axis along its ramp, and waits until all rest. The positions stay known.
    ///
    /// # Errors
    /// [`Error::Lost`]
    pub fn stop(&mut self) -> Result<(), Error> {
        self.session.stop(Selection::All)?;
        while self.session.is_busy(Selection::All)? {
            self.session.pause(POLL)?;
        }
        Ok(())
    }

    /// Stops every axis at once: the position of one that moves becomes unknown.
    ///
    /// # Errors
    /// [`Error::Lost`] if the board does not confirm it: switch its power off.
    pub fn kill(&mut self) -> Result<(), Error> {
        match self.session.kill() {
            Ok(true) => Ok(()),
            Ok(false) => Err(LinkError::Silent.into()),
            Err(trouble) => Err(trouble.into()),
        }
    }

    /// The conversation, for what has no word here: settings, questions.
    pub fn session(&mut self) -> &mut Session {
        &mut self.session
    }
}

/// An axis of a board.
pub struct Axis<'b> {
    session: &'b mut Session,
    id: AxisId,
}

impl Axis<'_> {
    /// Where it is, in steps; `None` if that is not known.
    ///
    /// # Errors
    /// [`Error::Lost`]
    pub fn position(&mut self) -> Result<Option<i64>, Error> {
        Ok(self.session.position(self.id)?)
    }

    /// Calls the place where it stands 0.
    ///
    /// # Errors
    /// [`Error::Refused`] while it moves; [`Error::Lost`].
    pub fn set_zero(&mut self) -> Result<(), Error> {
        self.say(Command::Zero(self.id))
    }

    /// Moves to a position in steps, and waits.
    ///
    /// # Errors
    /// [`Error::Refused`], [`Error::TooFar`], [`Error::Uncertain`], [`Error::Range`],
    /// [`Error::Moving`]: nothing moves by it. [`Error::Lost`].
    pub fn move_to(&mut self, position: i64, motion: &MotionLimits) -> Result<Outcome, Error> {
        let from = self.stand()?;
        self.travel(position.saturating_sub(from), motion)?;
        self.wait(position, |_| Action::GoOn)
    }

    /// Moves by a number of steps, and waits.
    ///
    /// # Errors
    /// Those of [`move_to`](Axis::move_to).
    pub fn move_by(&mut self, steps: i64, motion: &MotionLimits) -> Result<Outcome, Error> {
        let from = self.stand()?;
        self.move_to(from.saturating_add(steps), motion)
    }

    /// Begins to move by a number of steps, and does not wait.
    ///
    /// # Errors
    /// Those of [`move_to`](Axis::move_to).
    pub fn travel(&mut self, steps: i64, motion: &MotionLimits) -> Result<(), Error> {
        let distance = i32::try_from(steps).map_err(|_| Error::TooFar { steps })?;
        self.begin(motion.order(Travel::By(Distance::new(distance))))
    }

    /// Runs for a time, brakes, and waits until it rests: [`Outcome::Reached`] says where.
    ///
    /// # Errors
    /// Those of [`move_to`](Axis::move_to).
    pub fn run(
        &mut self,
        way: Direction,
        motion: &MotionLimits,
        time: Duration,
    ) -> Result<Outcome, Error> {
        self.begin(motion.order(Travel::Endless(way)))?;
        let until = self.session.now().saturating_add(time);
        let watched = self.session.watch(self.id, Some(until), |_, _| Action::GoOn);
        let over = matches!(watched, Ok(Sight { braking: true, .. }));
        let outcome = self.conclude(watched, None)?;
        Ok(match outcome {
            Outcome::Stopped { at, .. } if over => Outcome::Reached { at },
            outcome => outcome,
        })
    }

    /// Waits until it rests. `see` is told of every look, 20 a second, and says what is wished
    /// for. `target` is where it is expected.
    ///
    /// # Errors
    /// [`Error::Lost`]
    pub fn wait(
        &mut self,
        target: i64,
        mut see: impl FnMut(&Sight) -> Action,
    ) -> Result<Outcome, Error> {
        let watched = self.session.watch(self.id, None, |_, sight| see(sight));
        let target = self.session.new_target(self.id).unwrap_or(target);
        self.conclude(watched, Some(target))
    }

    /// Sends the travel in progress elsewhere: this many steps from where it began.
    ///
    /// # Errors
    /// [`Error::Refused`] at rest, or where the board refuses it; [`Error::Lost`].
    pub fn retarget(&mut self, steps: i32) -> Result<(), Error> {
        self.change(Command::Retarget(Distance::new(steps)))
    }

    /// Gives the travel in progress another top speed.
    ///
    /// # Errors
    /// Those of [`retarget`](Axis::retarget).
    pub fn set_top_speed(&mut self, top: Speed) -> Result<(), Error> {
        let milli = Command::Milli(MilliSpeed::clamped(top.millisteps()));
        self.change(Command::top(top).unwrap_or(milli))
    }

    /// Brakes along the ramp, and waits until it rests. The position stays known.
    ///
    /// # Errors
    /// [`Error::Lost`]
    pub fn stop(&mut self) -> Result<Outcome, Error> {
        self.session.stop(Selection::One(self.id))?;
        let watched = self.session.watch(self.id, None, |_, _| Action::GoOn);
        self.conclude(watched, None)
    }

    /// Finds 0 by its limit switch, which the settings of the board name: to it, away from it by
    /// `back_off` steps, slowly to it again, and away. Where it stands then.
    ///
    /// # Errors
    /// [`Error::NoSwitch`], [`Error::NotHomed`], and those of [`move_to`](Axis::move_to).
    pub fn home(
        &mut self,
        fast: &MotionLimits,
        slow: &MotionLimits,
        back_off: u32,
        within: u32,
    ) -> Result<i64, Error> {
        let Reply::Settings(listed) = self.session.ask(Command::Settings)? else {
            return Err(Error::NoSwitch);
        };
        let side = SwitchSide::of(self.id, &listed).map_err(|_| Error::NoSwitch)?;
        let any = Travel::By(Distance::new(0));
        let (fast, slow) = (fast.order(any), slow.order(any));
        let order = HomeOrder { side, fast, slow, back_off, within };
        let homed = self.session.wait(async |talk| talk.home(&order, |_, _| Action::GoOn).await);
        Ok(homed??)
    }

    /// Where it stands.
    fn stand(&mut self) -> Result<i64, Error> {
        if self.session.is_busy(Selection::One(self.id))? {
            return Err(Error::Moving);
        }
        self.session.rest_position(self.id)?.ok_or(Error::Uncertain)
    }

    fn begin(&mut self, order: Order) -> Result<(), Error> {
        let orders = [(self.id, order)];
        let lines: Vec<_> = Script::new(&orders)?.collect();
        let from = self.stand()?;
        Ok(self.session.begin(self.id, &order, &lines, Some(from))?)
    }

    /// Says a line that changes the travel in progress. At rest the board would keep it.
    fn change(&mut self, line: Command) -> Result<(), Error> {
        let one = Selection::One(self.id);
        if !self.session.is_busy(one)? {
            return Err(Error::Refused { line, reason: Some(Refusal::NoTravel) });
        }
        match self.session.ask_of(one, line)? {
            Reply::Yes => Ok(()),
            _ => Err(Error::Refused { line, reason: self.session.why()? }),
        }
    }

    /// Says a line that is harmless twice.
    fn say(&mut self, line: Command) -> Result<(), Error> {
        match self.session.ask(line)? {
            Reply::Yes => Ok(()),
            _ => Err(Error::Refused { line, reason: self.session.why()? }),
        }
    }

    fn conclude(
        &mut self,
        watched: Result<Sight, LinkError>,
        target: Option<i64>,
    ) -> Result<Outcome, Error> {
        let Ended { end, adrift, .. } = self.session.conclude(self.id, watched);
        match (end, adrift) {
            (_, Some(Adrift::Lost(trouble))) => Err(trouble.into()),
            (_, Some(Adrift::Unconfirmed)) => Err(LinkError::Silent.into()),
            (RestPlace::At(at), _) if target == Some(at) => Ok(Outcome::Reached { at }),
            (RestPlace::At(at), _) => {
                Ok(Outcome::Stopped { at, reason: self.session.stop_of(self.id) })
            }
            (RestPlace::Uncertain, _) => Ok(Outcome::Uncertain),
        }
    }
}
