//! Why a board refused a line, and the remedy.

use stepwright_host::motion::NotBegun;
use stepwright_host::settings::{STEEPEST, behind};
use stepwright_host::{Conversation, LinkError};
use stepwright_protocol::{Command, Refusal};

use crate::Declined;
use crate::keeper::{Keeper, KeeperDesk};
use crate::orders::Undone;

/// The remedy, where no setting causes the refusal.
fn remedy(why: Refusal, max: Option<u32>) -> Option<String> {
    Some(match why {
        Refusal::TooFast => {
            let max = max.map_or_else(String::new, |max| format!(" {max} steps/s"));
            format!("one axis alone makes at most{max} here, several together less")
        }
        Refusal::TooSteep => STEEPEST.into(),
        Refusal::TooSlow => "a start speed of a step/s or more, not below the top speed, leaves \
                             the ramp out"
            .into(),
        Refusal::TooGentle => "give a steeper ramp, or a lower top speed".into(),
        Refusal::Ramp => "give another acceleration".into(),
        Refusal::NoJerk => "the board has no S-curves: leave the jerk out".into(),
        Refusal::Fault => "an input holds the axis: its limit switch, the emergency stop or the \
                           driver; the way back from a switch is free"
            .into(),
        Refusal::Busy => "wait, or stop it".into(),
        _ => return None,
    })
}

impl<D: KeeperDesk> Keeper<D> {
    /// The board's refusal of this line.
    pub(crate) async fn refused(
        &self,
        talk: &mut Conversation,
        line: Command,
    ) -> Result<Undone, LinkError> {
        let why = talk.why().await?;
        let declined = self.declined(talk, line, why).await?;
        Ok(Undone::Declined(match line {
            Command::Set(_) => declined.remedy("settings change while every axis rests"),
            Command::Zero(_) if why.is_none() => declined.remedy("is the axis still travelling?"),
            _ => declined,
        }))
    }

    /// Why an order that has moved nothing was not begun.
    pub(crate) async fn not_begun(&self, talk: &mut Conversation, not: NotBegun) -> Undone {
        let name = &self.board.name;
        match not {
            NotBegun::Refused(line, why) => match self.declined(talk, line, why).await {
                Ok(declined) => Undone::Declined(declined),
                Err(trouble) => Undone::Lost(trouble),
            },
            NotBegun::Trouble { trouble, .. } => Undone::Lost(trouble),
            NotBegun::Noise => Undone::Declined(
                Declined::refused(format!(
                    "{name}: every attempt to give the order was spoiled by noise"
                ))
                .remedy("nothing has moved; look at the cable and its ground"),
            ),
        }
    }

    async fn declined(
        &self,
        talk: &mut Conversation,
        line: Command,
        why: Option<Refusal>,
    ) -> Result<Declined, LinkError> {
        let name = &self.board.name;
        let Some(why) = why else {
            return Ok(Declined::refused(format!("{name} refused {line}")));
        };
        let declined = Declined::refused(format!("{name} refused {line}: {why}"));
        let settings = match behind(why) {
            [] => None,
            settings => talk.changed_settings().await?.words(settings),
        };
        let remedy = match settings {
            Some(words) => Some(format!("by its settings {words}: ask for less, or change them")),
            None => remedy(why, talk.info().map(|info| info.max)),
        };
        Ok(match remedy {
            Some(remedy) => declined.remedy(remedy),
            None => declined,
        })
    }
}
