//! Checks that a board can carry out an order that not every board can. A refusal comes before
//! anything moves.

use stepwright_host::Session;
use stepwright_host::settings::NoCurves;
use stepwright_protocol::Order;

use super::target;
use crate::failure::Failure;

/// Checks that the board has S-curves, if the order has a jerk.
pub fn to_bend(session: &mut Session, order: &Order) -> Result<(), Failure> {
    let missing = session.no_curves(order).map_err(target::trouble(session))?;
    let name = session.name();
    match missing {
        None => Ok(()),
        Some(NoCurves::Board) => Err(Failure::new(format!(
            "{name} has no S-curves, which --jerk asks for"
        ))
        .hint(
            "leave --jerk out: an Uno and a Nano have none; on another board `stepwright flash` \
                 writes a controller that has them",
        )),
        Some(NoCurves::Law) => {
            Err(Failure::new(format!("the setting law of {name} is 0: it would ignore --jerk"))
                .hint(format!(
                    "`stepwright settings set law=1 --port {name}`, or leave --jerk out"
                )))
        }
    }
}
