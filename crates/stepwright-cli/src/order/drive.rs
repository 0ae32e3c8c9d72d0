//! The end of an axis' motion, as a failure of the command with its exit status.

use stepwright_host::motion::{Adrift, NotBegun, RestPlace, Sight};
use stepwright_host::{LinkError, Session};
use stepwright_protocol::{AxisId, Order, Refusal};

use super::refused;
use crate::failure::Failure;
use crate::interrupt;

/// The end of a watched motion.
#[derive(Debug)]
pub struct Ended {
    /// The position at rest.
    pub end: RestPlace,
    /// Whether the axis was braked before the end of its order.
    pub braked: bool,
    /// The failure, if the motion did not end as ordered.
    pub failure: Option<Failure>,
}

/// Concludes the watch of an axis. After a second Ctrl-C, kills all axes.
pub fn conclude(session: &mut Session, axis: AxisId, watched: Result<Sight, LinkError>) -> Ended {
    let ended = session.conclude(axis, watched);
    let failure = ended.adrift.map(|adrift| failure(session, &adrift));
    Ended { end: ended.end, braked: ended.braked, failure }
}

fn failure(session: &Session, adrift: &Adrift) -> Failure {
    let known = "if it stands at a known place, or to go and find one: `stepwright zero`";
    match adrift {
        Adrift::Uncertain => {
            Failure::new("the position is uncertain: something has killed the motion").hint(known)
        }
        Adrift::Killed => Failure::interrupted("killed: the motor may have lost steps").hint(known),
        Adrift::Unconfirmed => lost(
            session,
            "the board did not confirm K: the motor may still be moving",
            "switch off the motor's power",
        ),
        Adrift::Lost(trouble) => {
            let what = format!("lost the board on its way: {trouble}");
            lost(session, &what, "the motor may still be moving: look at it")
        }
    }
}

fn lost(session: &Session, what: &str, todo: &str) -> Failure {
    let name = session.name();
    let look = format!("{todo}; then `stepwright status --port {name}`");
    let failure = Failure::new(format!("{name}: {what}")).hint(look);
    if interrupt::asked() { failure.status(interrupt::STATUS) } else { failure }
}

/// Whether the plan shall be shown. The refusal of a plan that is too slow has its numbers.
pub fn has_plan(start: &Result<(), NotBegun>) -> bool {
    !matches!(start, Err(NotBegun::Refused(_, Some(Refusal::TooSlow))))
}

/// The failure if this order was not begun.
pub fn order_not_begun(session: &mut Session, not: NotBegun, order: &Order) -> Failure {
    match not {
        NotBegun::Refused(_, Some(Refusal::TooSlow)) => refused::as_slow(&session.name(), order),
        not => not_begun(session, not),
    }
}

/// The failure if an order was not begun.
pub fn not_begun(session: &mut Session, not: NotBegun) -> Failure {
    let name = session.name();
    match not {
        NotBegun::Refused(line, Some(why)) => refused::by(session, &line, why),
        NotBegun::Refused(line, None) => Failure::new(format!("{name} refused {line}"))
            .hint("it does not say why; is it still travelling, is the speed too high for it?"),
        NotBegun::Trouble { trouble, moving: false } => super::target::lost(&name, &trouble),
        NotBegun::Trouble { trouble, moving: true } => {
            let what = format!("lost the board while giving the order: {trouble}");
            lost(session, &what, "the motor may be moving: look at it")
        }
        NotBegun::Noise => {
            Failure::new(format!("{name}: every attempt to give the order was spoiled by noise"))
                .hint("nothing has moved. Look at the cable, its ground, and --baud")
        }
    }
}
