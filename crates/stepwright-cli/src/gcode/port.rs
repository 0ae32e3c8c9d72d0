//! A board that plays streams: how it is met, and what it says in text.

use std::io;
use std::time::Duration;

use stepwright_feeder::{FeedState, FeedTerms};
use stepwright_host::Session;
use stepwright_host::link::Link;
use stepwright_host::link::serial::Share;
use stepwright_plan::gcode::JobPlan;
use stepwright_protocol::{Abilities, Ability};
use stepwright_stream::brake::BrakeLaw;
use stepwright_stream::credit::{Answered, CreditReader};
use stepwright_stream::frame::FILL;
use stepwright_stream::send::LinkTimes;

use crate::failure::Failure;
use crate::order::places::{self, ask};
use crate::order::target::{self, PortArgs};
use crate::{programs, say};

/// Between two looks at the line.
pub const LOOK: Duration = Duration::from_millis(1);

/// What is sent before it is played, in µs, as far as the board has the room: a computer that does other
/// things as well may pause for some 0.4 s.
const AHEAD: u32 = 500_000;

/// How often a kill is said, and how long its answer is waited for each time.
const KILLS: (usize, Duration) = (5, Duration::from_millis(300));

/// A board that moves still is waited for.
const REST: Duration = Duration::from_secs(30);

/// A board that plays streams, at rest.
pub struct Met {
    pub session: Session,
    pub name: String,
    /// Its step timer.
    pub hz: u32,
    /// Its axes come this many ticks after one another.
    pub stagger: u32,
    /// Whether it has an output for a laser.
    pub laser: bool,
    /// Where its axes are, as far as it knows.
    pub places: [Option<i64>; 3],
}

impl Met {
    /// Opens the port for a command, and waits until nothing moves.
    pub fn at(port: &PortArgs, command: &str) -> Result<Met, Failure> {
        let mut session = port.open(command, Share::Alone)?;
        // A board that somebody has left in the middle of a frame hears nothing else.
        let _ = session.link().write(&[FILL; 4]);
        let about = target::met_program(&mut session, programs::STREAM, |_| "stream")?;
        let name = session.name();
        let hz = word(&about, "hz=").and_then(|hz| u32::try_from(hz).ok()).unwrap_or(16_000_000);
        at_rest(&mut session, &name)?;
        let places = positions(&mut session)?;
        let (stagger, laser) = (stagger(&about), can(&about, Ability::Laser));
        Ok(Met { session, name, hz, stagger, laser, places })
    }

    /// Refuses a job with a laser if the board has no output for one.
    pub fn checked_for(&self, plan: &JobPlan) -> Result<(), Failure> {
        if plan.laser.is_none() || self.laser {
            return Ok(());
        }
        Err(Failure::usage(format!("{}: this board has no output for a laser", self.name))
            .hint("a Mega with the program `stream` has one; or run the job without --laser"))
    }
}

/// Whether a board says in `can=` of its answer to `?` that it has this ability.
fn can(about: &str, ability: Ability) -> bool {
    let words = about.split(' ').find_map(|word| word.strip_prefix("can="));
    words.is_some_and(|words| Abilities::parse(words.as_bytes()).has(ability))
}

/// By how many ticks equal axes are kept apart: not at all on a chip of 32 bits, a visit of whose interrupt
/// makes the steps of all at once.
pub fn stagger(about: &str) -> u32 {
    match about.split(' ').nth(1) {
        Some("uno" | "mega" | "virtual") => 75,
        _ => 0,
    }
}

/// How the axes brake, by these decelerations in steps/s²; `None` if one is below what a board brakes by.
pub fn brakes(decels: [f64; 3], hz: u32) -> Option<[BrakeLaw; 3]> {
    let [x, y, z] = decels.map(|decel| BrakeLaw::of((decel * 1_000.0).floor() as u64, hz));
    Some([x?, y?, z?])
}

/// How a board with this step timer is fed over a line of this many baud.
pub fn terms(brakes: [BrakeLaw; 3], hz: u32, stagger: u32, baud: u32) -> FeedTerms {
    let times = LinkTimes::of_baud(baud);
    FeedTerms { hz, stagger, times, ahead: AHEAD, ..FeedTerms::avr(brakes) }
}

/// Waits until nothing moves any more.
pub fn at_rest(session: &mut Session, name: &str) -> Result<(), Failure> {
    let end = session.now() + REST;
    let mut told = false;
    while ask(session, b"F").map_err(|trouble| target::lost(name, &trouble))? != "R" {
        if session.now() > end {
            return Err(Failure::new(format!("{name} still moves"))
                .hint("`K` at a terminal stops it at once"));
        }
        if !told {
            say::note(format_args!("{name} moves: waiting until it rests"));
            told = true;
        }
        session.link().rest(Duration::from_millis(100));
    }
    Ok(())
}

/// Stops everything at once, wherever in a frame the board is; what came of it.
pub fn kill(session: &mut Session) -> Failure {
    let name = session.name();
    let (tries, patience) = KILLS;
    let link = session.link();
    for _ in 0..tries {
        // Half a frame would take the line for a part of itself.
        let said = link.write(&[FILL; 4]).and_then(|()| link.write(b"K\r"));
        if said.is_err() {
            break;
        }
        if says_yes(link, patience) {
            return Failure::interrupted("killed: the positions of axes that moved are lost");
        }
    }
    Failure::interrupted(format!(
        "{name}: the board did not confirm K: the motors may still be moving"
    ))
    .hint("switch off the motors' power; a board that hears nothing brakes when it runs short")
}

/// Whether a line comes that says yes, among what answers frames.
fn says_yes(link: &mut dyn Link, patience: Duration) -> bool {
    let end = link.now() + patience;
    let (mut reader, mut line, mut yes) = (CreditReader::new(), Vec::new(), false);
    let mut buffer = [0; 256];
    while !yes && link.now() < end {
        let left = end.saturating_sub(link.now());
        let Ok(count) = link.read(&mut buffer, left) else { return false };
        for byte in buffer.get(..count).unwrap_or_default() {
            reader.hear(*byte, |told| match told {
                Answered::Text(b'\r') => yes |= std::mem::take(&mut line) == b"Y",
                Answered::Text(b'\n') | Answered::Credit(_) => {}
                Answered::Text(byte) => line.push(byte),
            });
        }
    }
    yes
}

/// Why the board has left the path, where it is, and what to do.
pub fn off(session: &mut Session, name: &str, state: FeedState) -> Failure {
    let why = match state {
        FeedState::Tripped => "an input that stops it has closed",
        FeedState::Wrong => "it has refused a part of the job",
        _ => "it was short of what comes next",
    };
    let rests = at_rest(session, name).is_ok();
    let Some(places) = positions(session).ok().filter(|_| rests) else {
        return Failure::new(format!("{name} has braked, off the path: {why}"))
            .hint("whether it rests, and where, it has not said");
    };
    let at = spelt(places);
    if places.contains(&None) {
        return Failure::new(format!("{name} has stopped, off the path, at {at}"))
            .hint("a place that is ? is lost: a kill (K) has lost it, now or before the job");
    }
    Failure::new(format!("{name} has braked, off the path: {why}, at {at}"))
        .hint("the positions are known; a slower job, or a computer with less to do")
}

/// Where all axes are; `None` of one that a kill has lost.
pub fn positions(session: &mut Session) -> Result<[Option<i64>; 3], Failure> {
    let (name, places) = (session.name(), places::places(session, 3));
    let places = places.map_err(|trouble| target::lost(&name, &trouble))?;
    places.try_into().map_err(|_| Failure::new(format!("{name} has fewer than 3 axes")))
}

/// Positions as words: ? is one that is not known.
pub fn spelt(places: [Option<i64>; 3]) -> String {
    places.map(|place| place.map_or("?".to_owned(), |place| place.to_string())).join(" ")
}

/// Where all axes are, and how many steps came late since the board was switched on.
pub fn tells(session: &mut Session) -> Result<([Option<i64>; 3], u64), Failure> {
    let (name, places) = (session.name(), positions(session)?);
    let about = ask(session, b"?").map_err(|trouble| target::lost(&name, &trouble))?;
    Ok((places, word(&about, "late=").unwrap_or(0)))
}

/// The port fails while the board plays.
pub fn gone(name: &str, error: &io::Error) -> Failure {
    Failure::new(format!("{name}: {error}"))
        .hint("the board plays what it has, and brakes by itself: its position stays known")
}

/// The board says nothing more while it plays for this command.
pub fn silent(name: &str, command: &str) -> Failure {
    Failure::new(format!("{name} does not answer any more")).hint(format!(
        "what it has is played, and then it brakes; `stepwright {command}` again tells where it is"
    ))
}

/// The number behind a word of the answer to `?`.
fn word(about: &str, name: &str) -> Option<u64> {
    about.split(' ').find_map(|word| word.strip_prefix(name))?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_an_answer() {
        let about = "stepwright-stream uno hz=16000000 axes=3 late=12 fifo=896 can=sum";
        assert_eq!(word(about, "hz="), Some(16_000_000));
        assert_eq!(word(about, "late="), Some(12));
        assert_eq!(word(about, "axis="), None);
        assert_eq!((stagger(about), stagger("stepwright-stream pico hz=15625000")), (75, 0));
    }
}
