//! Starts a motor, watches it, stops it: the part that must not go wrong.
//!
//! ```text
//!   begin ──► watch ──────────────────────────► at rest: where?
//!     │         │ Ctrl-C      │ Ctrl-C again
//!     ▼         ▼             ▼
//!   refused   Z, watch on    K: position uncertain
//! ```

use std::time::Duration;

use stepwright_protocol::{AxisId, Command, Info, Order, Refusal, Reply, Selection, Travel};

use super::keys::{Act, KeyControl};
use super::refused;
use crate::failure::Failure;
use crate::interrupt;
use crate::session::{LinkError, Played, Session};

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
    fn safe(trouble: LinkError) -> NotBegun {
        NotBegun::Trouble { trouble, moving: false }
    }

    fn unsure(trouble: LinkError) -> NotBegun {
        NotBegun::Trouble { trouble, moving: true }
    }
}

/// Starts an axis that stands at `from`.
///
/// An order that was lost on its way is said again, but only once the board
/// has shown that nothing came of it: it is ready, the axis has not moved, and
/// getting in step has spoiled what may stand in it.
pub fn begin(
    session: &mut Session,
    axis: AxisId,
    order: &Order,
    lines: &[Command],
    from: Option<i64>,
) -> Result<(), NotBegun> {
    session.begins(axis, from);
    let mut not = NotBegun::Noise;
    for _ in 0..TRIES {
        // PO is refused while the axis that is selected is busy, whichever.
        session.select(Selection::One(axis)).map_err(NotBegun::safe)?;
        // An E with a checksum is of this line, and needs no count to tell.
        let before =
            if session.has_sums() { None } else { session.ask_info().map_err(NotBegun::safe)? };
        match session.play(lines.iter().copied()) {
            Ok(Played::Accepted) => return Ok(()),
            // Noise may have made it another line, so it is said again; if it
            // was not noise, that changes nothing.
            Ok(Played::Refused(line)) => {
                let after = session.ask_info().map_err(NotBegun::safe)?;
                not = refusal(line, before, after);
            }
            Ok(Played::Unanswered(line)) => {
                let last = line == Command::Execute;
                let trouble = |trouble| NotBegun::Trouble { trouble, moving: last };
                session.resync().map_err(trouble)?;
                if last && has_begun(session, axis, order, from).map_err(trouble)? {
                    return Ok(());
                }
            }
            Err(trouble) => return Err(NotBegun::unsure(trouble)),
        }
    }
    Err(not)
}

/// What an E means, by what the board said of itself before and after.
fn refusal(line: Command, before: Option<Info>, after: Option<Info>) -> NotBegun {
    let Some(after) = after else { return NotBegun::Refused(line, None) };
    // Our lines are lines, until noise makes them bad ones, or empty ones,
    // which aren't counted.
    let counted = before.is_none_or(|before| before.refused != after.refused);
    match after.last {
        Some(Refusal::Line | Refusal::Sum) => NotBegun::Noise,
        Some(why) if counted => NotBegun::Refused(line, Some(why)),
        _ => NotBegun::Noise,
    }
}

/// After an E without an answer: has it started the axis?
fn has_begun(
    session: &mut Session,
    axis: AxisId,
    order: &Order,
    from: Option<i64>,
) -> Result<bool, LinkError> {
    if session.is_busy(Selection::One(axis))? || session.rest_position(axis)? != from {
        return Ok(true);
    }
    // A travel of no steps leaves no trace, nor does it need any.
    Ok(matches!(order.travel, Travel::By(distance) if distance.get() == 0))
}

/// What a look at the motor shows.
#[derive(Clone, Debug)]
pub struct Sight {
    /// Where it is; `None` if uncertain.
    pub position: Option<i64>,
    /// The time of the line's clock.
    pub time: Duration,
    /// Whether it is being braked.
    pub braking: bool,
    /// What a key, or another terminal, has come to, for the user.
    pub told: Option<String>,
    /// The line that has changed the motion.
    pub change: Option<Command>,
}

/// Watches an axis until it rests, with a hand on it. Ctrl-C, or the time
/// `until`, brakes it.
/// Where it rests, or `None` if that is uncertain; and whether it was braked.
pub fn watch(
    session: &mut Session,
    axis: AxisId,
    until: Option<Duration>,
    hand: &mut KeyControl,
    mut see: impl FnMut(Sight),
) -> Result<Sight, LinkError> {
    let one = Selection::One(axis);
    let mut braking = false;
    loop {
        let time = session.now();
        let (mut told, mut change) = (None, None);
        let mut stop = interrupt::asked() || until.is_some_and(|until| time >= until);
        match hand.act(session, one)? {
            Some(Act::Stop) => stop = true,
            Some(Act::Told(text)) => told = Some(text),
            Some(Act::Changed(line, text)) => (change, told) = (Some(line), Some(text)),
            None => {
                if let Some(made) = session.next_change().filter(|made| made.axes.contains(axis)) {
                    change = Some(made.command);
                    told = Some(format!("another terminal: {made}"));
                }
            }
        }
        if !braking && stop {
            brake(session, one)?;
            braking = true;
        }
        // First whether it rests, then where: the other way round it might
        // move on in between.
        let busy = session.is_busy(one)?;
        let position = if busy { session.position(axis)? } else { session.rest_position(axis)? };
        let sight = Sight { position, time: session.now(), braking, told, change };
        see(sight.clone());
        if !busy {
            return Ok(sight);
        }
        let left = until.filter(|_| !braking).map(|until| until.saturating_sub(session.now()));
        session.pause(left.map_or(POLL, |left| left.min(POLL)))?;
    }
}

/// Brakes these axes.
pub fn brake(session: &mut Session, axes: Selection) -> Result<(), LinkError> {
    for _ in 0..TRIES {
        // E: the line was damaged.
        if session.ask_of(axes, Command::Brake)? == Reply::Yes {
            return Ok(());
        }
    }
    Err(LinkError::Silent)
}

/// Where an axis ended up, and whether that is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// At rest, here.
    Rests(i64),
    /// At rest or not, somewhere.
    Uncertain,
}

/// How a watch ended.
#[derive(Debug)]
pub struct Ended {
    /// Where.
    pub end: End,
    /// Whether it was braked before it was done.
    pub braked: bool,
    /// Why it is not as it should be.
    pub failure: Option<Failure>,
}

/// What became of a watched axis, whatever happened: after a second Ctrl-C
/// everything is killed here.
pub fn conclude(session: &mut Session, axis: AxisId, watched: Result<Sight, LinkError>) -> Ended {
    let uncertain = |failure| Ended { end: End::Uncertain, braked: false, failure: Some(failure) };
    match watched {
        Ok(Sight { position: Some(at), braking, .. }) => {
            Ended { end: End::Rests(at), braked: braking, failure: None }
        }
        Ok(Sight { position: None, .. }) => uncertain(
            Failure::new("the position is uncertain: something has killed the motion")
                .hint("if it stands at a known place, or to go and find one: `stepwright zero`"),
        ),
        Err(LinkError::Killed) => match killed(session, axis) {
            // It had come to rest before K could do harm.
            Ok(Some(at)) => Ended { end: End::Rests(at), braked: true, failure: None },
            Ok(None) => {
                uncertain(Failure::interrupted("killed: the motor may have lost steps").hint(
                    "if it stands at a known place, or to go and find one: `stepwright zero`",
                ))
            }
            Err(()) => uncertain(adrift(
                session,
                "the board did not confirm K: the motor may still be moving",
                "switch off the motor's power",
            )),
        },
        Err(trouble) => {
            let what = format!("lost the board on its way: {trouble}");
            uncertain(adrift(session, &what, "the motor may still be moving: look at it"))
        }
    }
}

fn adrift(session: &mut Session, what: &str, todo: &str) -> Failure {
    let name = session.link().name();
    let look = format!("{todo}; then `stepwright status --port {name}`");
    let failure = Failure::new(format!("{name}: {what}")).hint(look);
    if interrupt::asked() { failure.status(interrupt::STATUS) } else { failure }
}

/// Kills everything; the position if it is still known.
fn killed(session: &mut Session, axis: AxisId) -> Result<Option<i64>, ()> {
    match session.kill() {
        Ok(true) => Ok(session.rest_position(axis).unwrap_or(None)),
        _ => Err(()),
    }
}

/// The failure of a start.
pub fn not_begun(session: &mut Session, not: NotBegun) -> Failure {
    let name = session.link().name();
    match not {
        NotBegun::Refused(line, Some(why)) => refused::by(session, &line, why),
        NotBegun::Refused(line, None) => Failure::new(format!("{name} refused {line}"))
            .hint("it does not say why; is it still travelling, is the speed too high for it?"),
        NotBegun::Trouble { trouble, moving: false } => super::target::lost(&name, &trouble),
        NotBegun::Trouble { trouble, moving: true } => {
            let what = format!("lost the board while giving the order: {trouble}");
            adrift(session, &what, "the motor may be moving: look at it")
        }
        NotBegun::Noise => {
            Failure::new(format!("{name}: every attempt to give the order was spoiled by noise"))
                .hint("nothing has moved. Look at the cable, its ground, and --baud")
        }
    }
}
