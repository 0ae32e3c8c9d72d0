//! A job on a board that plays streams: its steps are planned here and sent as they are needed.

use std::time::{Duration, Instant};

use stepwright_feeder::{FeedState, FeedTerms, StreamFeeder};
use stepwright_host::Session;
use stepwright_path::{AxisPace, Lead, Planned, RouteStep};
use stepwright_plan::gcode::{GcodeJob, JobPlan};
use stepwright_stream::brake::BrakeLaw;
use stepwright_stream::frame::FILL;
use stepwright_stream::send::LinkTimes;

use super::play::tell;
use crate::failure::Failure;
use crate::order::progress::Line;
use crate::order::target::{self, PortArgs};
use crate::{interrupt, programs, say};
use stepwright_host::link::serial::Share;

/// Between two looks at the line.
const LOOK: Duration = Duration::from_millis(1);
/// What is sent before it is played, in µs, as far as the board has the room.
const AHEAD: u32 = 500_000;
/// A board that moves still is waited for.
const REST: Duration = Duration::from_secs(30);

/// What became of a job on a board.
pub struct Streamed {
    /// Where the axes are, in steps; `None` where that is not known.
    pub position: [Option<i64>; 3],
    /// Steps that came late, since the board was switched on.
    pub late: u64,
    /// Seconds of the path.
    pub seconds: f64,
    pub braked: bool,
    /// How often the line had to be called, and frames sent again.
    pub again: u64,
}

/// A board that plays streams, at rest.
pub struct Met {
    pub session: Session,
    pub name: String,
    /// Its step timer.
    pub hz: u32,
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
        Ok(Met { session, name, hz, places })
    }
}

/// How the axes brake, by these decelerations in steps/s²; `None` if one is below what a board brakes by.
pub fn brakes(decels: [f64; 3], hz: u32) -> Option<[BrakeLaw; 3]> {
    let [x, y, z] = decels.map(|decel| BrakeLaw::of((decel * 1_000.0).floor() as u64, hz));
    Some([x?, y?, z?])
}

/// Streams a job that has been planned, and is not refused.
pub fn stream(
    port: &PortArgs,
    job: Vec<u8>,
    axes: [AxisPace; 3],
    plan: &JobPlan,
) -> Result<Streamed, Failure> {
    let Met { mut session, name, hz, places } = Met::at(port, "gcode")?;
    if places != [Some(0); 3] {
        let places = places.map(|place| place.map_or("?".to_owned(), |place| place.to_string()));
        say::note(format_args!(
            "{name} is at {}: the job takes that place for the machine's zero",
            places.join(" ")
        ));
    }
    let decels = [0, 1, 2].map(|n: usize| axes[n].accel / axes[n].step);
    let brakes = brakes(decels, hz).ok_or_else(|| {
        Failure::usage("an axis decelerates too slowly for a board that brakes by itself")
            .hint("--accel of 8 steps/s² and more")
    })?;
    let moves = plan.delays().into_iter().zip(0u8..).filter(|(delay, _)| delay.is_some());
    let moving = moves.map(|(_, axis)| 1 << axis).sum();
    let times = LinkTimes::of_baud(port.baud);
    // A computer that does other things as well may keep this one waiting for some 0.4 s.
    let terms = FeedTerms { hz, times, axes: moving, ahead: AHEAD, ..FeedTerms::avr(brakes) };
    let wrong = |why: &dyn std::fmt::Display| Failure::usage(format!("the axes: {why}"));
    let job = GcodeJob::new(job, axes).map_err(|why| wrong(&why))?;
    let mut job = Lead::new(Plan(job));
    let (feeder, braked) = feed(&mut session, &name, terms, &mut job, plan)?;
    match feeder.state() {
        FeedState::Over => {}
        FeedState::Lost => {
            return Err(Failure::new(format!("{name} does not answer any more")).hint(
                "what it has is played, and then it brakes; `stepwright gcode` again tells where it is",
            ));
        }
        state => return Err(off(&mut session, &name, state)),
    }
    let position = positions(&mut session)?;
    let about = ask(&mut session, b"?")?;
    let late = word(&about, "late=").unwrap_or(0);
    Ok(Streamed { position, late, seconds: job.ahead().0.time(), braked, again: feeder.again() })
}

/// The job, whose order is to brake from a time on.
#[derive(Clone)]
struct Plan(GcodeJob<std::vec::IntoIter<u8>>);

impl Planned for Plan {
    type Order = f64;

    fn step(&mut self) -> Option<RouteStep> {
        // What can't be read was said when it was planned.
        self.0.step().ok().flatten()
    }

    fn obey(&mut self, at: &f64) {
        self.0.cancel_at(*at);
    }

    fn stays(_: &f64) -> bool {
        false
    }
}

/// Feeds the board until the job is over, or it is off the path.
fn feed(
    session: &mut Session,
    name: &str,
    terms: FeedTerms,
    job: &mut Lead<Plan>,
    plan: &JobPlan,
) -> Result<(StreamFeeder, bool), Failure> {
    let link = session.link();
    let begun = link.now();
    let mut feeder = StreamFeeder::new(terms, 0);
    let (mut line, mut shown, mut braked, mut told) = (Line::new(), None, false, false);
    let mut buffer = [0; 256];
    let gone = |error: std::io::Error| {
        Failure::new(format!("{name}: {error}"))
            .hint("the board plays what it has, and brakes by itself: its position stays known")
    };
    while !feeder.state().is_end() {
        if interrupt::presses() >= 2 {
            link.write(b"K\r").map_err(gone)?;
            line.end();
            return Err(Failure::interrupted("killed: the positions of axes that moved are lost"));
        }
        let micros = |now: Duration| now.saturating_sub(begun).as_micros() as u64;
        if !told && interrupt::asked() {
            told = true;
            line.note(interrupt::braking());
        }
        if told
            && !braked
            && let Some(cut) = feeder.cut(micros(link.now()), true)
        {
            braked = true;
            job.cut(cut.steps, &[cut.time]);
        }
        while feeder.wants() {
            match job.plan() {
                Some(step) => feeder.step(step.axis, step.time, step.forward),
                None => feeder.end(job.ahead().0.time()),
            }
        }
        let bytes = feeder.bytes(micros(link.now()));
        if !bytes.is_empty() {
            link.write(&bytes).map_err(gone)?;
        }
        let count = link.read(&mut buffer, LOOK).map_err(gone)?;
        let now = micros(link.now());
        feeder.hear(buffer.get(..count).unwrap_or_default(), now);
        if feeder.was_late() {
            job.undo_cut();
            braked = false;
        } else if !feeder.is_cutting() {
            job.keep_cut();
        }
        while job.pass(feeder.now(now)).is_some() {}
        if shown.is_none_or(|shown: Instant| shown.elapsed() > Duration::from_millis(100)) {
            shown = Some(Instant::now());
            tell(&mut line, feeder.time(), plan.time, braked);
        }
    }
    line.end();
    Ok((feeder, braked))
}

/// Waits until nothing moves any more.
pub fn at_rest(session: &mut Session, name: &str) -> Result<(), Failure> {
    let end = session.now() + REST;
    let mut told = false;
    while ask(session, b"F")? != "R" {
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

/// Why the board has left the path, where it is, and what to do.
fn off(session: &mut Session, name: &str, state: FeedState) -> Failure {
    let why = match state {
        FeedState::Tripped => "an input that stops it has closed",
        FeedState::Wrong => "it has refused a part of the job",
        _ => "it was short of what comes next",
    };
    let rests = at_rest(session, name).is_ok();
    let places = positions(session).ok().filter(|_| rests).map(|places| {
        places.map(|place| place.map_or("?".to_owned(), |place| place.to_string())).join(" ")
    });
    let where_ = places.map_or(String::new(), |places| format!(", at {places}"));
    Failure::new(format!("{name} has braked, off the path: {why}{where_}"))
        .hint("the positions are known; a slower job, or a computer with less to do")
}

/// Where all axes are.
pub fn positions(session: &mut Session) -> Result<[Option<i64>; 3], Failure> {
    let mut position = [None; 3];
    for (axis, place) in (b'1'..).zip(&mut position) {
        *place = ask(session, &[b'V', axis])?.parse().ok();
    }
    Ok(position)
}

/// An answer to a text line.
pub fn ask(session: &mut Session, line: &[u8]) -> Result<String, Failure> {
    let name = session.name();
    for _ in 0..3 {
        let answer = session.say(line).map_err(|trouble| target::lost(&name, &trouble))?;
        // What is left of the last answer to a frame is no text.
        let text = answer.map(|text| text.chars().filter(char::is_ascii).collect::<String>());
        if let Some(text) = text.filter(|text| !text.is_empty()) {
            return Ok(text);
        }
    }
    Err(target::lost(&name, &stepwright_host::LinkError::Silent))
}

/// The number behind a word of the answer to `?`.
pub fn word(about: &str, name: &str) -> Option<u64> {
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
    }
}
