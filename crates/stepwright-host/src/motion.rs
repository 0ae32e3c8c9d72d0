//! Starts, watches and stops a motor: the part that must not go wrong.
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

/// The time between two looks at a moving motor.
pub const POLL: Duration = Duration::from_millis(50);

/// How often an order is said if its lines were lost or damaged.
pub const TRIES: usize = 5;

/// Why a motor was not started.
#[derive(Debug)]
pub enum NotBegun {
    /// The board refused this line, for this reason if it tells one.
    Refused(Command, Option<Refusal>),
    /// The link to the board failed.
    Trouble {
        /// The failure.
        trouble: LinkError,
        /// Whether the order may have been carried out: the motor may be moving.
        moving: bool,
    },
    /// Noise spoiled every attempt.
    Noise,
}

impl NotBegun {
    /// The link failed before anything could move.
    pub fn safe(trouble: LinkError) -> NotBegun {
        NotBegun::Trouble { trouble, moving: false }
    }

    /// The link failed, and the order may have been carried out.
    pub fn unsure(trouble: LinkError) -> NotBegun {
        NotBegun::Trouble { trouble, moving: true }
    }
}

/// An axis and the travel that it is to begin.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// The axis.
    pub axis: AxisId,
    /// The position at rest, in steps, if it is known.
    pub from: Option<i64>,
    /// The order.
    pub order: Order,
}

/// A look at the motor.
#[derive(Clone, Debug)]
pub struct Sight {
    /// The position, in steps; `None` if it is uncertain.
    pub position: Option<i64>,
    /// The time of the line's clock.
    pub time: Duration,
    /// Whether the axis moves.
    pub moving: bool,
    /// Whether the axis is being braked.
    pub braking: bool,
    /// The last line that was requested, and the board's answer: `Ok` if it was taken.
    pub said: Option<(Command, Result<(), Option<Refusal>>)>,
}

/// What to do between two looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Nothing: the motion goes on.
    GoOn,
    /// A soft stop.
    Stop,
    /// Say a line that changes the motion and is harmless twice.
    Say(Command),
}

/// The position of an axis at the end, if it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RestPlace {
    /// At rest, at this position.
    At(i64),
    /// Unknown, at rest or not.
    Uncertain,
}

/// The end of a watched axis.
#[derive(Debug)]
pub struct Ended {
    /// The position.
    pub end: RestPlace,
    /// Whether the axis was braked before its travel was done.
    pub braked: bool,
    /// The reason, if the end is not certain.
    pub adrift: Option<Adrift>,
}

/// Why the position of an axis is unknown.
#[derive(Debug)]
pub enum Adrift {
    /// The motion was killed elsewhere.
    Uncertain,
    /// The motion was killed here, and may have lost steps.
    Killed,
    /// A kill was sent, and the board did not confirm it.
    Unconfirmed,
    /// The link was lost while the axis moved.
    Lost(LinkError),
}

impl Conversation {
    /// Starts an axis that rests at `from`, by the lines of this order, as
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

    /// Starts axes that rest, by the lines of their orders: all of them, or none.
    ///
    /// Repeats lost orders, but only once the board has shown that they had no effect: it is ready, no axis has
    /// moved, and getting in step has spoiled what it may have received. An axis with an unknown position shows
    /// nothing once it rests: the order is not repeated then.
    pub async fn begin_together(
        &mut self,
        starts: &[Start],
        lines: &[Command],
    ) -> Result<(), NotBegun> {
        for start in starts {
            self.begins(start.axis, start.from);
            if let Travel::By(steps) = start.order.travel {
                self.travels.goes(start.axis, steps.get());
            }
        }
        let first = starts.first().map_or(AxisId::FIRST, |start| start.axis);
        let mut not = NotBegun::Noise;
        for _ in 0..TRIES {
            // PO is refused while any selected axis is busy.
            self.select(Selection::One(first)).await.map_err(NotBegun::safe)?;
            // An E with a checksum answers this line, without a count of refusals.
            let before = match self.has_sums() {
                true => None,
                false => self.ask_info().await.map_err(NotBegun::safe)?,
            };
            match self.play(lines).await {
                Ok(Played::Accepted) => return Ok(()),
                // Noise may have made it another line, so the order is repeated. Without noise it is refused
                // again.
                Ok(Played::Refused(line)) => {
                    let after = self.ask_info().await.map_err(NotBegun::safe)?;
                    not = refusal(line, self.has_sums(), before, after);
                }
                Ok(Played::Unanswered(line)) => {
                    let last = line == Command::Execute;
                    let trouble = |trouble| NotBegun::Trouble { trouble, moving: last };
                    self.resync().await.map_err(trouble)?;
                    let begun = match last {
                        true => self.have_begun(starts).await.map_err(trouble)?,
                        false => Some(false),
                    };
                    match begun {
                        Some(true) => return Ok(()),
                        Some(false) => {}
                        None => return Err(NotBegun::unsure(LinkError::Silent)),
                    }
                }
                Err(trouble) => return Err(NotBegun::unsure(trouble)),
            }
        }
        Err(not)
    }

    /// Whether the axes have started, after an E without an answer. It starts all of them, or none. `None`:
    /// they rest, and have no position that could tell.
    async fn have_begun(&mut self, starts: &[Start]) -> Result<Option<bool>, LinkError> {
        // A travel of no steps leaves no trace, and need not be repeated.
        let none = |travel| matches!(travel, Travel::By(distance) if distance.get() == 0);
        let (mut begun, mut told) = (true, false);
        for Start { axis, from, order } in starts {
            let moves = self.is_busy(Selection::One(*axis)).await?;
            if moves || self.rest_position(*axis).await? != *from {
                return Ok(Some(true));
            }
            begun &= none(order.travel);
            told |= from.is_some() && !none(order.travel);
        }
        Ok((begun || told).then_some(begun))
    }

    /// Watches an axis until it rests. `see` is called for every look, and returns the action. Brakes the axis
    /// at `until`. Returns the last look, with the position at rest, `None` if it is uncertain, and whether the
    /// axis was braked.
    pub async fn watch(
        &mut self,
        axis: AxisId,
        until: Option<Duration>,
        mut see: impl FnMut(&mut Conversation, &Sight) -> Action,
    ) -> Result<Sight, LinkError> {
        let one = Selection::One(axis);
        let (mut braking, mut said) = (false, None);
        loop {
            // First whether the axis rests, then the position: in the other order it might move on in between.
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

    /// The end of a watched axis. If the watching ended with a kill, kills everything here.
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
                    // It had come to rest before K took effect.
                    Ok(Some(at)) => Ended { end: RestPlace::At(at), braked: true, adrift: None },
                    _ => uncertain(Adrift::Killed),
                },
                _ => uncertain(Adrift::Unconfirmed),
            },
            Err(trouble) => uncertain(Adrift::Lost(trouble)),
        }
    }
}

/// What an answer E means, from the board's `?` before and after.
fn refusal(line: Command, sums: bool, before: Option<Info>, after: Option<Info>) -> NotBegun {
    let Some(after) = after else { return NotBegun::Refused(line, None) };
    // Our lines are valid; only noise makes them invalid, or empty, and the board does not count empty lines.
    let counted = before.is_none_or(|before| before.refused != after.refused);
    match after.last {
        // With a right checksum the board has understood the line and does not know it, as for a guest.
        Some(Refusal::Line) if !sums => NotBegun::Noise,
        Some(Refusal::Sum) => NotBegun::Noise,
        Some(why) if counted => NotBegun::Refused(line, Some(why)),
        _ => NotBegun::Noise,
    }
}
