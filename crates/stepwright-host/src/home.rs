//! Homes an axis: the machine of [`homing`](crate::homing) carried on by a conversation.

use stepwright_protocol::{Command, Distance, Order, Refusal, Reply, Travel};

use crate::conversation::{Conversation, LinkError};
use crate::homing::{HomeLeg, HomingAct, HomingEvent, HomingFailure, SwitchHoming, SwitchSide};
use crate::motion::{Action, NotBegun, POLL, Sight};

/// How an axis is homed.
#[derive(Clone, Copy, Debug)]
pub struct HomeOrder {
    /// Its switch.
    pub side: SwitchSide,
    /// How the switch is sought and backed off from. Its travel does not count.
    pub fast: Order,
    /// How the switch is approached, the second time. Its travel does not count.
    pub slow: Order,
    /// How far to back off, in steps.
    pub back_off: u32,
    /// How far the switch may be, in steps.
    pub within: u32,
}

/// What is told of a homing on its way.
#[derive(Clone, Copy, Debug)]
pub enum HomeSight<'a> {
    /// This leg begins here, by this order.
    Begins(HomeLeg, &'a Order, Option<i64>),
    /// A look at the axis.
    Sees(&'a Sight),
    /// The leg has ended.
    Ends,
    /// What a user would like to know.
    Note(&'a str),
}

/// Why an axis was not homed.
#[derive(Debug)]
pub enum NotHomed {
    /// A leg was not begun.
    NotBegun(NotBegun),
    /// The order of a leg can't be said.
    Unsayable(stepwright::OutOfRange),
    /// The machine says so. `leg` is where it was.
    Failed(HomingFailure, HomeLeg),
    /// The conversation has ended between two legs: the axis rests.
    Trouble(LinkError),
    /// It has ended within a leg: the axis may move.
    Adrift(LinkError),
}

impl HomeOrder {
    /// The order of a leg.
    pub fn leg(&self, leg: HomeLeg) -> Order {
        let travel = if leg.is_towards() {
            Travel::Endless(self.side.towards)
        } else {
            let steps = i32::try_from(self.back_off).unwrap_or(i32::MAX);
            Travel::By(Distance::new(self.side.away(steps)))
        };
        let order = if leg == HomeLeg::Approach { self.slow } else { self.fast };
        Order { travel, ..order }
    }
}

impl Conversation {
    /// Homes an axis; where it stands then. `see` is told of it, and what it wishes for after
    /// [`HomeSight::Sees`] is done.
    pub async fn home(
        &mut self,
        order: &HomeOrder,
        mut see: impl FnMut(&mut Conversation, HomeSight) -> Action,
    ) -> Result<i64, NotHomed> {
        let mut homing = SwitchHoming::new(order.side, order.back_off, order.within);
        let mut act = HomingAct::Travel(homing.leg());
        loop {
            let event = match act {
                HomingAct::Travel(leg) => self.home_leg(order, leg, &homing, &mut see).await?,
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

    /// Travels a leg to its end.
    async fn home_leg(
        &mut self,
        order: &HomeOrder,
        leg: HomeLeg,
        homing: &SwitchHoming,
        see: &mut impl FnMut(&mut Conversation, HomeSight) -> Action,
    ) -> Result<HomingEvent, NotHomed> {
        let axis = order.side.axis;
        let order = order.leg(leg);
        let orders = [(axis, order)];
        let lines = stepwright_protocol::Script::new(&orders).map_err(NotHomed::Unsayable)?;
        let lines: Vec<Command> = lines.collect();
        let from = self.rest_position(axis).await.map_err(NotHomed::Trouble)?;
        match self.begin(axis, &order, &lines, from).await {
            Ok(()) => {}
            Err(NotBegun::Refused(_, Some(Refusal::Fault))) if leg.is_towards() => {
                return Ok(HomingEvent::Closed);
            }
            Err(not) => return Err(NotHomed::NotBegun(not)),
        }
        see(self, HomeSight::Begins(leg, &order, from));
        let longest = homing.longest(order.top);
        let until = leg.is_towards().then(|| self.now().saturating_add(longest));
        let watched = self.watch(axis, until, |talk, sight| see(talk, HomeSight::Sees(sight)));
        let watched = watched.await;
        see(self, HomeSight::Ends);
        let sight = watched.map_err(NotHomed::Adrift)?;
        let stop = self.stop_of(axis).await.unwrap_or(None);
        Ok(HomingEvent::Rests { position: sight.position, stop, braked: sight.braking })
    }
}
