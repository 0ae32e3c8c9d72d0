//! Starts a motor, watches it, stops it: the part that must not go wrong.
//!
//! ```text
//!   begin ──► watch ──────────────────────────► at rest: where?
//!     │         │ Action::Stop   │ LinkError::Killed
//!     ▼         ▼              ▼
//!   refused   Z, watch on    K: position uncertain
//! ```

use std::time::Duration;

use stepwright_protocol::{AxisId, Command, Info, Order, Refusal, Reply, Selection, Travel};

use crate::conversation::{Conversation, LinkError, Played};

/// Between two looks at a moving motor.
pub const POLL: Duration = Duration::from_millis(50);

/// How often an order is said whose lines were lost or damaged.
pub const TRIES: usize = 5;

/// Why a motor was not started.
#[derive(Debug)]
pub enum NotBegun {
    /// The board refused this line, for this reason if it can tell.
    Refused(Command, Option<Refusal>),
    /// The line to the board failed. `moving` if the motor may move all the
    /// same.
    Trouble {
        /// What happened.
        trouble: LinkError,
        /// Whether the order may have been carried out.
        moving: bool,
    },
    /// Every attempt was spoiled on its way.
    Noise,
}

impl NotBegun {
    /// The line failed before anything could move.
    pub fn safe(trouble: LinkError) -> NotBegun {
        NotBegun::Trouble { trouble, moving: false }
    }

    /// The line failed, and the order may have been carried out.
    pub fn unsure(trouble: LinkError) -> NotBegun {
        NotBegun::Trouble { trouble, moving: true }
    }
}

/// An axis that is to begin a travel.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Which.
    pub axis: AxisId,
    /// Where it stands, in steps, if that is known.
    pub from: Option<i64>,
    /// What it is ordered.
    pub order: Order,
}

/// What a look at the motor shows.
#[derive(Clone, Debug)]
pub struct Sight {
    /// Where it is, in steps; `None` if uncertain.
    pub position: Option<i64>,
    /// The time of the line's clock.
    pub time: Duration,
    /// Whether it moves.
    pub moving: bool,
    /// Whether it is being braked.
    pub braking: bool,
    /// The line that was wished for last, and what the board has said of it: `Ok` if it was taken.
    pub said: Option<(Command, Result<(), Option<Refusal>>)>,
}

/// What is wished for between two looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Nothing: it goes on.
    GoOn,
    /// A soft stop.
    Stop,
    /// A line that changes the motion, harmless twice.
    Say(Command),
}

/// Where an axis ended up, and whether that is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RestPlace {
    /// At rest, here.
    At(i64),
    /// At rest or not, somewhere.
    Uncertain,
}

/// What became of a watched axis.
#[derive(Debug)]
pub struct Ended {
    /// Where.
    pub end: RestPlace,
    /// Whether it was braked before it was done.
    pub braked: bool,
    /// Why it is not as it should be.
    pub adrift: Option<Adrift>,
}

/// Why it is not known where an axis is.
#[derive(Debug)]
pub enum Adrift {
    /// Something has killed the motion.
    Uncertain,
    /// It was killed here, and may have lost steps.
    Killed,
    /// It was to be killed here, and the board did not confirm that.
    Unconfirmed,
    /// The board was lost while the axis moved.
    Lost(LinkError),
}

impl Conversation {
    /// Starts an axis that stands at `from`, by the lines of this order: as
    /// [`begin_together`](Conversation::begin_together) does.
    pub async fn begin(
        &mut self,
        axis: AxisId,
        order: &Order,
        lines: &[Command],
        from: Option<i64>,
    ) -> Result<(), NotBegun> {
        self.begin_together(&[Start { axis, from, order: *order }], lines).await
    }

    /// Starts axes that stand still, by the lines of their orders: all of them, or none.
    ///
    /// Orders that were lost on their way are said again, but only once the board
    /// has shown that nothing came of them: it is ready, no axis has moved, and
    /// getting in step has spoiled what may stand in it.
    pub async fn begin_together(
        &mut self,
        starts: &[Start],
        lines: &[Command],
    ) -> Result<(), NotBegun> {
        starts.iter().for_each(|start| self.begins(start.axis, start.from));
        let first = starts.first().map_or(AxisId::FIRST, |start| start.axis);
        let mut not = NotBegun::Noise;
        for _ in 0..TRIES {
            // PO is refused while the axis that is selected is busy, whichever.
            self.select(Selection::One(first)).await.map_err(NotBegun::safe)?;
            // An E with a checksum is of this line, and needs no count to tell.
            let before = match self.has_sums() {
                true => None,
                false => self.ask_info().await.map_err(NotBegun::safe)?,
            };
            match self.play(lines).await {
                Ok(Played::Accepted) => return Ok(()),
                // Noise may have made it another line, so it is said again; if it
                // was not noise, that changes nothing.
                Ok(Played::Refused(line)) => {
                    let after = self.ask_info().await.map_err(NotBegun::safe)?;
                    not = refusal(line, self.has_sums(), before, after);
                }
                Ok(Played::Unanswered(line)) => {
                    let last = line == Command::Execute;
                    let trouble = |trouble| NotBegun::Trouble { trouble, moving: last };
                    self.resync().await.map_err(trouble)?;
                    if last && self.have_begun(starts).await.map_err(trouble)? {
                        return Ok(());
                    }
                }
                Err(trouble) => return Err(NotBegun::unsure(trouble)),
            }
        }
        Err(not)
    }

    /// After an E without an answer: has it started the axes? It starts all, or none.
    async fn have_begun(&mut self, starts: &[Start]) -> Result<bool, LinkError> {
        for Start { axis, from, .. } in starts {
            let moves = self.is_busy(Selection::One(*axis)).await?;
            if moves || self.rest_position(*axis).await? != *from {
                return Ok(true);
            }
        }
        // A travel of no steps leaves no trace, nor does it need any.
        let none = |travel| matches!(travel, Travel::By(distance) if distance.get() == 0);
        Ok(starts.iter().all(|start| none(start.order.travel)))
    }

    /// Watches an axis until it rests. `see` is told of every look, and says what is wished for.
    /// The last look: where it rests, or `None` if that is uncertain; and whether it was braked.
    pub async fn watch(
        &mut self,
        axis: AxisId,
        until: Option<Duration>,
        mut see: impl FnMut(&mut Conversation, &Sight) -> Action,
    ) -> Result<Sight, LinkError> {
        let one = Selection::One(axis);
        let (mut braking, mut said) = (false, None);
        loop {
            // First whether it rests, then where: the other way round it might
            // move on in between.
            let moving = self.is_busy(one).await?;
            let position = match moving {
                true => self.position(axis).await?,
                false => self.rest_position(axis).await?,
            };
            let sight = Sight { position, time: self.now(), moving, braking, said: said.take() };
            let wish = see(self, &sight);
            if !moving {
                return Ok(sight);
            }
            let over = until.is_some_and(|until| self.now() >= until);
            match wish {
                _ if braking => {}
                Action::GoOn if !over => {}
                Action::Say(line) if !over => {
                    let taken = self.ask_of(one, line).await? == Reply::Yes;
                    if taken {
                        self.has_changed(one, line);
                    }
                    said = Some((line, if taken { Ok(()) } else { Err(self.why().await?) }));
                    continue;
                }
                _ => {
                    self.stop(one).await?;
                    braking = true;
                    continue;
                }
            }
            let left = until.filter(|_| !braking).map(|until| until.saturating_sub(self.now()));
            self.pause(left.map_or(POLL, |left| left.min(POLL))).await?;
        }
    }

    /// Stops these axes along their ramps.
    pub async fn stop(&mut self, axes: Selection) -> Result<(), LinkError> {
        for _ in 0..TRIES {
            // E: the line was damaged.
            if self.ask_of(axes, Command::Stop).await? == Reply::Yes {
                return Ok(());
            }
        }
        Err(LinkError::Silent)
    }

    /// What became of a watched axis, whatever happened: if it was to be killed, everything is
    /// killed here.
    pub async fn conclude(&mut self, axis: AxisId, watched: Result<Sight, LinkError>) -> Ended {
        let uncertain =
            |adrift| Ended { end: RestPlace::Uncertain, braked: false, adrift: Some(adrift) };
        match watched {
            Ok(Sight { position: Some(at), braking, .. }) => {
                Ended { end: RestPlace::At(at), braked: braking, adrift: None }
            }
            Ok(Sight { position: None, .. }) => uncertain(Adrift::Uncertain),
            Err(LinkError::Killed) => match self.kill().await {
                Ok(true) => match self.rest_position(axis).await {
                    // It had come to rest before K could do harm.
                    Ok(Some(at)) => Ended { end: RestPlace::At(at), braked: true, adrift: None },
                    _ => uncertain(Adrift::Killed),
                },
                _ => uncertain(Adrift::Unconfirmed),
            },
            Err(trouble) => uncertain(Adrift::Lost(trouble)),
        }
    }
}

/// What an E means, by what the board said of itself before and after.
fn refusal(line: Command, sums: bool, before: Option<Info>, after: Option<Info>) -> NotBegun {
    let Some(after) = after else { return NotBegun::Refused(line, None) };
    // Our lines are lines, until noise makes them bad ones, or empty ones,
    // which aren't counted.
    let counted = before.is_none_or(|before| before.refused != after.refused);
    match after.last {
        // With its checksum it is our line that is none, as of one who is a guest.
        Some(Refusal::Line) if !sums => NotBegun::Noise,
        Some(Refusal::Sum) => NotBegun::Noise,
        Some(why) if counted => NotBegun::Refused(line, Some(why)),
        _ => NotBegun::Noise,
    }
}
