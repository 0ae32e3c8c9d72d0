//! Homes an axis: runs the state machine of [`homing`](crate::homing) in a conversation.

use stepwright_protocol::{AxisId, Command, Order, Refusal, Reply, Stop};

use crate::conversation::{Conversation, LinkError};
use crate::homing::{
    BegunLeg, HomeLeg, HomeOrder, HomingAct, HomingEvent, HomingFailure, SwitchHoming,
};
use crate::motion::{Action, NotBegun, POLL, Sight};

/// An event of a homing in progress.
#[derive(Clone, Copy, Debug)]
pub enum HomeSight<'a> {
    /// This leg begins, with this order, at this position.
    Begins(HomeLeg, &'a Order, Option<i64>),
    /// A look at the axis.
    Sees(&'a Sight),
    /// The leg has ended.
    Ends,
    /// A note for the user.
    Note(&'a str),
}

/// Why an axis was not homed.
#[derive(Debug)]
pub enum NotHomed {
    /// A leg was not begun.
    NotBegun(NotBegun),
    /// An order of a leg can't be sent.
    Unsayable(stepwright::OutOfRange),
    /// The state machine failed, in this leg.
    Failed(HomingFailure, HomeLeg),
    /// The conversation ended between two legs: the axis rests.
    Trouble(LinkError),
    /// The conversation ended within a leg: the axis may move.
    Adrift(LinkError),
}

impl Conversation {
    /// Homes an axis, and returns its position at the end. `see` is called for each event; the action that it
    /// returns after [`HomeSight::Sees`] is carried out.
    pub async fn home(
        &mut self,
        order: &HomeOrder,
        mut see: impl FnMut(&mut Conversation, HomeSight) -> Action,
    ) -> Result<i64, NotHomed> {
        let mut homing = SwitchHoming::new(*order);
        let axis = order.side.axis;
        let mut act = HomingAct::Travel(homing.leg());
        loop {
            let event = match act {
                HomingAct::Travel(leg) => self.home_leg(axis, leg, &mut homing, &mut see).await?,
                HomingAct::Say(line) => {
                    let reply = self.ask(line).await.map_err(NotHomed::Trouble)?;
                    HomingEvent::Said(reply == Reply::Yes)
                }
                HomingAct::Wait => {
                    self.pause(POLL).await.map_err(NotHomed::Trouble)?;
                    HomingEvent::Waited
                }
                HomingAct::Done(at) => return Ok(at),
            };
            let leg = homing.leg();
            let next = homing.next(event, self.now());
            act = next.map_err(|failure| NotHomed::Failed(failure, leg))?;
            if let Some(note) = homing.take_note() {
                see(self, HomeSight::Note(&note));
            }
        }
    }

    /// Runs a leg to its end.
    async fn home_leg(
        &mut self,
        axis: AxisId,
        leg: HomeLeg,
        homing: &mut SwitchHoming,
        see: &mut impl FnMut(&mut Conversation, HomeSight) -> Action,
    ) -> Result<HomingEvent, NotHomed> {
        let from = self.rest_position(axis).await.map_err(NotHomed::Trouble)?;
        let BegunLeg { order, brakes } = homing.begin(from);
        let orders = [(axis, order)];
        let lines = stepwright_protocol::Script::new(&orders).map_err(NotHomed::Unsayable)?;
        let lines: Vec<Command> = lines.collect();
        match self.begin(axis, &order, &lines, from).await {
            Ok(()) => {}
            Err(NotBegun::Refused(_, Some(Refusal::Fault))) if leg.is_towards() => {
                return Ok(HomingEvent::Closed);
            }
            Err(not) => return Err(NotHomed::NotBegun(not)),
        }
        see(self, HomeSight::Begins(leg, &order, from));
        let until = brakes.map(|brakes| self.now().saturating_add(brakes));
        let mut unwanted = false;
        let watched = self.watch(axis, until, |talk, sight| {
            let wish = see(talk, HomeSight::Sees(sight));
            unwanted |= wish == Action::Stop;
            wish
        });
        let watched = watched.await;
        see(self, HomeSight::Ends);
        let sight = watched.map_err(NotHomed::Adrift)?;
        // No leg follows a requested stop, whatever has stopped this leg.
        let stop = match unwanted {
            true => Some(Stop::Soft),
            false => self.stop_of(axis).await.unwrap_or(None),
        };
        let braked = sight.braking && !unwanted;
        Ok(HomingEvent::Rests { position: sight.position, stop, braked })
    }
}
