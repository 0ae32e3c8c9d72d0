//! The calls of a board and its axes, for all faces, as futures that wait for the board alone.

use std::time::Duration;

use stepwright::Speed;
use stepwright_protocol::{
    AxisId, Command, Direction, Distance, MilliSpeed, Order, Refusal, Reply, Script, Selection,
    Stop, Travel,
};

use crate::conversation::{Conversation, LinkError};
use crate::homing::{HomeOrder, SwitchSide};
use crate::motion::{Action, Adrift, Ended, POLL, RestPlace, Sight};
use crate::outcome::{Error, MotionLimits, Outcome};

/// Passes the calls of an axis to a face's macro, which makes a method of each.
macro_rules! axis_calls {
    ($face:ident) => {
        $face! {
            /// The position of the axis, in steps; `None` if it is unknown.
            ///
            /// # Errors
            /// [`Error::Lost`]
            position() -> Option<i64>;
            /// Makes the present position 0.
            ///
            /// # Errors
            /// [`Error::Refused`] while the axis moves; [`Error::Lost`].
            set_zero() -> ();
            /// Moves to a position in steps, and waits.
            ///
            /// # Errors
            /// [`Error::Refused`], [`Error::TooFar`], [`Error::Uncertain`], [`Error::Range`],
            /// [`Error::Moving`]: the call has moved nothing. [`Error::Lost`].
            move_to(position: i64, motion: &MotionLimits) -> Outcome;
            /// Moves by a number of steps, and waits.
            ///
            /// # Errors
            /// As for `move_to`.
            move_by(steps: i64, motion: &MotionLimits) -> Outcome;
            /// Begins to move by a number of steps, and does not wait.
            ///
            /// # Errors
            /// As for `move_to`.
            travel(steps: i64, motion: &MotionLimits) -> ();
            /// Runs for a time, brakes, and waits until the axis rests: [`Outcome::Reached`] says where.
            ///
            /// # Errors
            /// As for `move_to`.
            run(way: Direction, motion: &MotionLimits, time: Duration) -> Outcome;
            /// Waits until the axis rests. `see` is called for every look, 20 times a second, and returns the
            /// action to take. [`Outcome::Reached`] is the end that was ordered, or a new target that this or
            /// another program gave the travel on its way. The end of a travel that another program began is
            /// not known here: there it means that nothing stopped the axis, if the board tells.
            ///
            /// # Errors
            /// [`Error::Lost`]
            wait(see: impl FnMut(&Sight) -> Action) -> Outcome;
            /// Gives the travel in progress another target, a position in steps.
            ///
            /// # Errors
            /// [`Error::Refused`] at rest, or if the board refuses the line; [`Error::TooFar`];
            /// [`Error::BeginUnknown`] for a travel that another program began, except through
            /// [`Board::join`](crate::Board::join); [`Error::Lost`].
            retarget(position: i64) -> ();
            /// Gives the travel in progress another target: this many steps from where it began.
            ///
            /// # Errors
            /// [`Error::Refused`] at rest, or if the board refuses the line; [`Error::Lost`].
            retarget_by(steps: i32) -> ();
            /// Gives the travel in progress another top speed.
            ///
            /// # Errors
            /// As for `retarget`.
            set_top_speed(top: Speed) -> ();
            /// Brakes along the ramp, and waits until the axis rests. The position stays known. The outcome is that
            /// of `wait`: [`Outcome::Reached`] where there was nothing left to stop.
            ///
            /// # Errors
            /// [`Error::Lost`]
            stop() -> Outcome;
            /// Finds 0 by the limit switch of the axis, which the board's settings name: to the switch, away by
            /// `back_off` steps, slowly to the switch again, and away. Returns the position at the end.
            ///
            /// # Errors
            /// [`Error::NoSwitch`], [`Error::NotHomed`], and those of `move_to`.
            home(
                fast: &MotionLimits,
                slow: &MotionLimits,
                back_off: u32,
                within: u32
            ) -> i64;
        }
    };
}
pub(crate) use axis_calls;

/// The axis of this number, 1 for X, if the board has it.
pub(crate) fn axis(talk: &Conversation, number: u8) -> Result<AxisId, Error> {
    let axes = talk.info().map_or(1, |info| info.axes);
    AxisId::numbered(number).filter(|_| number <= axes).ok_or(Error::NoAxis { axes })
}

/// Brakes every axis along its ramp, and waits until all rest.
pub(crate) async fn stop_all(talk: &mut Conversation) -> Result<(), Error> {
    talk.stop(Selection::All).await?;
    while talk.is_busy(Selection::All).await? {
        talk.pause(POLL).await?;
    }
    Ok(())
}

/// Kills every axis.
pub(crate) async fn kill_all(talk: &mut Conversation) -> Result<(), Error> {
    match talk.kill().await? {
        true => Ok(()),
        false => Err(LinkError::Silent.into()),
    }
}

/// An axis in a conversation.
pub(crate) struct AxisCalls<'t> {
    pub talk: &'t mut Conversation,
    pub id: AxisId,
}

impl AxisCalls<'_> {
    pub async fn position(&mut self) -> Result<Option<i64>, Error> {
        Ok(self.talk.position(self.id).await?)
    }

    pub async fn set_zero(&mut self) -> Result<(), Error> {
        let line = Command::Zero(self.id);
        match self.talk.ask(line).await? {
            Reply::Yes => Ok(()),
            _ => Err(self.refused(line).await?),
        }
    }

    pub async fn move_to(
        &mut self,
        position: i64,
        motion: &MotionLimits,
    ) -> Result<Outcome, Error> {
        let from = self.stand().await?;
        self.travel(position.saturating_sub(from), motion).await?;
        self.wait(|_| Action::GoOn).await
    }

    pub async fn move_by(&mut self, steps: i64, motion: &MotionLimits) -> Result<Outcome, Error> {
        let from = self.stand().await?;
        self.move_to(from.saturating_add(steps), motion).await
    }

    pub async fn travel(&mut self, steps: i64, motion: &MotionLimits) -> Result<(), Error> {
        let distance = i32::try_from(steps).map_err(|_| Error::TooFar { steps })?;
        self.begin(motion.order(Travel::By(Distance::new(distance)))).await
    }

    pub async fn run(
        &mut self,
        way: Direction,
        motion: &MotionLimits,
        time: Duration,
    ) -> Result<Outcome, Error> {
        self.begin(motion.order(Travel::Endless(way))).await?;
        let until = self.talk.now().saturating_add(time);
        let watched = self.talk.watch(self.id, Some(until), |_, _| Action::GoOn).await;
        let over = matches!(watched, Ok(Sight { braking: true, .. }));
        let outcome = self.conclude(watched, None).await?;
        Ok(match outcome {
            // A limit switch may have stopped the axis before the end of the ramp.
            Outcome::Stopped { at, reason: None | Some(Stop::Soft) } if over => {
                Outcome::Reached { at }
            }
            outcome => outcome,
        })
    }

    pub async fn wait(&mut self, mut see: impl FnMut(&Sight) -> Action) -> Result<Outcome, Error> {
        let watched = self.talk.watch(self.id, None, |_, sight| see(sight)).await;
        let end = self.talk.travels.end(self.id);
        let outcome = self.conclude(watched, end).await?;
        let tells = self.talk.info().is_some_and(|info| info.stops.is_some());
        Ok(match outcome {
            Outcome::Stopped { at, reason: None } if end.is_none() && tells => {
                Outcome::Reached { at }
            }
            outcome => outcome,
        })
    }

    pub async fn retarget(&mut self, position: i64) -> Result<(), Error> {
        self.must_move(Command::Retarget(Distance::new(0))).await?;
        let from = match self.talk.travels.from(self.id) {
            Some(from) => from,
            None => self.talk.began(self.id).await?.ok_or(Error::BeginUnknown)?,
        };
        let steps = position.saturating_sub(from);
        self.retarget_by(i32::try_from(steps).map_err(|_| Error::TooFar { steps })?).await
    }

    pub async fn retarget_by(&mut self, steps: i32) -> Result<(), Error> {
        self.change(Command::Retarget(Distance::new(steps))).await
    }

    pub async fn set_top_speed(&mut self, top: Speed) -> Result<(), Error> {
        let milli = Command::Milli(MilliSpeed::clamped(top.millisteps()));
        self.change(Command::top(top).unwrap_or(milli)).await
    }

    pub async fn stop(&mut self) -> Result<Outcome, Error> {
        self.talk.stop(Selection::One(self.id)).await?;
        self.wait(|_| Action::GoOn).await
    }

    pub async fn home(
        &mut self,
        fast: &MotionLimits,
        slow: &MotionLimits,
        back_off: u32,
        within: u32,
    ) -> Result<i64, Error> {
        let Reply::Settings(listed) = self.talk.ask(Command::Settings).await? else {
            return Err(Error::NoSwitch);
        };
        let side = SwitchSide::of(self.id, &listed).map_err(|_| Error::NoSwitch)?;
        let any = Travel::By(Distance::new(0));
        let (fast, slow) = (fast.order(any), slow.order(any));
        let order = HomeOrder { side, fast, slow, back_off, within };
        Ok(self.talk.home(&order, |_, _| Action::GoOn).await?)
    }

    /// The position of the axis at rest.
    async fn stand(&mut self) -> Result<i64, Error> {
        if self.talk.is_busy(Selection::One(self.id)).await? {
            return Err(Error::Moving);
        }
        self.talk.rest_position(self.id).await?.ok_or(Error::Uncertain)
    }

    async fn begin(&mut self, order: Order) -> Result<(), Error> {
        let orders = [(self.id, order)];
        let lines: Vec<_> = Script::new(&orders)?.collect();
        let from = self.stand().await?;
        Ok(self.talk.begin(self.id, &order, &lines, Some(from)).await?)
    }

    /// Says a line that changes the travel in progress. At rest the board would keep the change for later.
    async fn change(&mut self, line: Command) -> Result<(), Error> {
        self.must_move(line).await?;
        let one = Selection::One(self.id);
        match self.talk.ask_of(one, line).await? {
            Reply::Yes => {
                self.talk.has_changed(one, line);
                Ok(())
            }
            _ => Err(self.refused(line).await?),
        }
    }

    async fn must_move(&mut self, line: Command) -> Result<(), Error> {
        match self.talk.is_busy(Selection::One(self.id)).await? {
            true => Ok(()),
            false => Err(Error::Refused { line, reason: Some(Refusal::NoTravel) }),
        }
    }

    async fn refused(&mut self, line: Command) -> Result<Error, LinkError> {
        Ok(Error::Refused { line, reason: self.talk.why().await? })
    }

    /// The outcome of a watched motion. Kills first if the watching ended with that.
    pub async fn conclude(
        &mut self,
        watched: Result<Sight, LinkError>,
        target: Option<i64>,
    ) -> Result<Outcome, Error> {
        let Ended { end, adrift, .. } = self.talk.conclude(self.id, watched).await;
        match (end, adrift) {
            (_, Some(Adrift::Lost(trouble))) => Err(trouble.into()),
            (_, Some(Adrift::Unconfirmed)) => Err(LinkError::Silent.into()),
            (RestPlace::At(at), _) if target == Some(at) => Ok(Outcome::Reached { at }),
            (RestPlace::At(at), _) => {
                let reason = self.talk.stop_of(self.id).await.unwrap_or(None);
                Ok(Outcome::Stopped { at, reason })
            }
            (RestPlace::Uncertain, _) => Ok(Outcome::Uncertain),
        }
    }
}
