//! A board that plays streams: connecting to it, and its text answers.

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

/// The time between two reads of the line.
pub const LOOK: Duration = Duration::from_millis(1);

/// How far ahead the stream is sent, in µs, as far as the board has room. A computer with other
/// tasks may pause for some 0.4 s.
const AHEAD: u32 = 500_000;

/// How often a kill is sent, and how long to wait for each answer.
const KILLS: (usize, Duration) = (5, Duration::from_millis(300));

/// How long to wait for a moving board to come to rest.
const REST: Duration = Duration::from_secs(30);

/// A board that plays streams, at rest.
pub struct Met {
    pub session: Session,
    pub name: String,
    /// The rate of its step timer.
    pub hz: u32,
    /// Equal axes are this many ticks apart.
    pub stagger: u32,
    /// Whether it has an output for a laser.
    pub laser: bool,
    /// The axes' positions; `None` if the board does not know one.
    pub places: [Option<i64>; 3],
}

impl Met {
    /// Opens the port for a command, and waits until nothing moves.
    pub fn at(port: &PortArgs, command: &str) -> Result<Met, Failure> {
        let mut session = port.open(command, Share::Alone)?;
        // A board that was left in the middle of a frame takes all bytes as part of that frame:
        // fill it.
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
        Err(Failure::usage(format!("{}: this board has no output for a laser", self.name)).hint(
            "a Mega and a Pico with the program `stream` have one; or run the job without --laser",
        ))
    }
}

/// Whether the board's answer to `?` lists this ability in `can=`.
fn can(about: &str, ability: Ability) -> bool {
    let words = about.split(' ').find_map(|word| word.strip_prefix("can="));
    words.is_some_and(|words| Abilities::parse(words.as_bytes()).has(ability))
}

/// The ticks by which equal axes are kept apart. 0 on 32-bit chips, where one interrupt makes the
/// steps of all axes.
pub fn stagger(about: &str) -> u32 {
    match about.split(' ').nth(1) {
        Some("uno" | "mega" | "virtual") => 75,
        _ => 0,
    }
}

/// The braking laws of the axes with these decelerations in steps/s²; `None` if one is below a
/// board's lowest.
pub fn brakes(decels: [f64; 3], hz: u32) -> Option<[BrakeLaw; 3]> {
    let [x, y, z] = decels.map(|decel| BrakeLaw::of((decel * 1_000.0).floor() as u64, hz));
    Some([x?, y?, z?])
}

/// The terms for feeding a board with this step timer over a line of this many baud.
pub fn terms(brakes: [BrakeLaw; 3], hz: u32, stagger: u32, baud: u32) -> FeedTerms {
    let times = LinkTimes::of_baud(baud);
    FeedTerms { hz, stagger, times, ahead: AHEAD, ..FeedTerms::avr(brakes) }
}

/// Waits until all axes are at rest.
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

/// Stops all axes at once, even if the board is in the middle of a frame. Returns the result as a
/// failure.
pub fn kill(session: &mut Session) -> Failure {
    let name = session.name();
    let (tries, patience) = KILLS;
    let link = session.link();
    for _ in 0..tries {
        // Fills an incomplete frame, which would otherwise take the line as its own bytes.
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

/// Whether a line with a positive answer comes, between the answers to frames.
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

/// The failure for a board that has left the path: the reason, its position, and a hint.
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

/// The positions of all axes; `None` for an axis that lost its position by a kill.
pub fn positions(session: &mut Session) -> Result<[Option<i64>; 3], Failure> {
    let (name, places) = (session.name(), places::places(session, 3));
    let places = places.map_err(|trouble| target::lost(&name, &trouble))?;
    places.try_into().map_err(|_| Failure::new(format!("{name} has fewer than 3 axes")))
}

/// Positions as text; ? is an unknown position.
pub fn spelt(places: [Option<i64>; 3]) -> String {
    places.map(|place| place.map_or("?".to_owned(), |place| place.to_string())).join(" ")
}

/// The positions of all axes, and the number of late steps since the board was switched on.
pub fn tells(session: &mut Session) -> Result<([Option<i64>; 3], u64), Failure> {
    let (name, places) = (session.name(), positions(session)?);
    let about = ask(session, b"?").map_err(|trouble| target::lost(&name, &trouble))?;
    Ok((places, word(&about, "late=").unwrap_or(0)))
}

/// The failure for a port that fails while the board plays.
pub fn gone(name: &str, error: &io::Error) -> Failure {
    Failure::new(format!("{name}: {error}"))
        .hint("the board plays what it has, and brakes by itself: its position stays known")
}

/// The failure for a board that stops answering while it plays for this command.
pub fn silent(name: &str, command: &str) -> Failure {
    Failure::new(format!("{name} does not answer any more")).hint(format!(
        "what it has is played, and then it brakes; `stepwright {command}` again tells where it is"
    ))
}

/// The number after a word of the answer to `?`.
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
