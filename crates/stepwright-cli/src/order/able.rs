//! What an order asks of a board that not every board can do: refused before anything
//! moves, with the one reason.

use stepwright_protocol::{Ability, Command, Order, Reply, Setting};

use super::target;
use crate::failure::Failure;
use stepwright_host::Session;

/// That the board bends ramps, if the order has a jerk.
pub fn to_bend(session: &mut Session, order: &Order) -> Result<(), Failure> {
    if order.jerk.is_none() {
        return Ok(());
    }
    let name = session.link().name();
    let can = match session.info() {
        None => Some(false),
        // A board that does not say is asked: it refuses what it can't.
        Some(info) => info.can.map(|can| can.has(Ability::Jerk)),
    };
    if can == Some(false) {
        return Err(Failure::new(format!("{name} has no S-curves, which --jerk asks for")).hint(
            "leave --jerk out, or `stepwright flash` the board: every controller of today has them",
        ));
    }
    // A board without settings answers E: it follows the jerk.
    let law = session.ask(Command::Setting(Setting::Law)).map_err(target::trouble(session))?;
    match law {
        Reply::Setting(value) if value.setting() == Setting::Law && value.number() == 0 => {
            Err(Failure::new(format!("the setting law of {name} is 0: it would ignore --jerk"))
                .hint(format!(
                    "`stepwright settings set law=1 --port {name}`, or leave --jerk out"
                )))
        }
        _ => Ok(()),
    }
}
