//! A board that plays streams: connecting to it, and its text answers.

use std::io;
use std::time::Duration;

use stepwright::{Board, Cost, Rate};
use stepwright_feeder::{FeedState, FeedTerms};
use stepwright_host::link::Link;
use stepwright_host::programs::{ask, places, wait_for_rest};
use stepwright_host::{LinkError, Session};
use stepwright_plan::gcode::JobPlan;
use stepwright_protocol::{Abilities, Ability, AxisId};
use stepwright_sim::Description;
use stepwright_stream::brake::BrakeLaw;
use stepwright_stream::credit::{Answered, CreditReader};
use stepwright_stream::frame::FILL;
use stepwright_stream::send::LinkTimes;

use crate::{Mute, PlayError, PlayVoice};

/// The first word of the board's answer to `?`.
pub const GREETING: &str = "stepwright-stream";

/// How far ahead the stream is sent, in µs, as far as the board has room. A computer with other
/// tasks may pause for some 0.4 s.
const AHEAD: u32 = 500_000;

/// How often a kill is sent, and how long to wait for each answer.
const KILLS: (usize, Duration) = (5, Duration::from_millis(300));

/// How long to wait at most until the line is quiet.
const HUSH: Duration = Duration::from_secs(1);

/// How long to wait for a moving board to come to rest.
const REST: Duration = Duration::from_secs(30);

/// A board with the program `stream`, at rest.
pub struct StreamedBoard {
    /// The conversation with it.
    pub session: Session,
    /// Its name in messages.
    pub name: String,
    /// The rate of its step timer.
    pub hz: u32,
    /// The speed of its line, in bits/s.
    pub baud: u32,
    /// Equal axes are this many ticks apart.
    pub stagger: u32,
    /// Whether it has an output for a laser.
    pub laser: bool,
    /// What it can do, for [`JobPlan::refused_by`].
    pub board: Board<3>,
    /// The axes' positions; `None` if the board does not know one.
    pub places: [Option<i64>; 3],
}

impl StreamedBoard {
    /// Meets the board at the end of a line of this many bits/s, and waits until nothing moves.
    ///
    /// # Errors
    /// No answer; another program; an axis that does not come to rest within 30 s; an interruption.
    pub fn meet(
        mut session: Session,
        baud: u32,
        voice: &dyn PlayVoice,
    ) -> Result<StreamedBoard, PlayError> {
        let name = session.name();
        const FLASH: &str = "flash the program for it: `stepwright flash uno --program stream`";
        StreamedBoard::wake(&mut session);
        let about = session.meet_program().map_err(|trouble| match trouble {
            LinkError::Silent => PlayError::new(format!("{name} does not answer")).hint(FLASH),
            trouble => PlayError::lost(&name, &trouble),
        })?;
        if about.split(' ').next() != Some(GREETING) {
            let other = format!("{name} runs another program, which plays no streams: {about}");
            return Err(PlayError::new(other).hint(FLASH));
        }
        StreamedBoard::met(session, &about, baud, voice)
    }

    /// Ends the frame in the middle of which a board was left: it takes all bytes as a part of that frame.
    /// To be called before its first line.
    pub fn wake(session: &mut Session) {
        let _ = session.link().write(&[FILL; 4]);
    }

    /// As [`meet`](StreamedBoard::meet), for a board that was woken and has given this answer to `?`.
    ///
    /// # Errors
    /// The same.
    pub fn met(
        mut session: Session,
        about: &str,
        baud: u32,
        voice: &dyn PlayVoice,
    ) -> Result<StreamedBoard, PlayError> {
        let name = session.name();
        let hz = word(about, "hz=").and_then(|hz| u32::try_from(hz).ok()).unwrap_or(16_000_000);
        at_rest(&mut session, &name, voice)?;
        let places = positions(&mut session, &name)?;
        let (stagger, laser) = (stagger(about), can(about, Ability::Laser));
        let board = costs(about, hz);
        Ok(StreamedBoard { session, name, hz, baud, stagger, laser, board, places })
    }

    /// Refuses a job with a laser if the board has no output for one, and a job that is too fast for it.
    ///
    /// # Errors
    /// The refusal.
    pub fn admits(&self, plan: &JobPlan) -> Result<(), PlayError> {
        if let Some(refused) = plan.refused_by(&self.board) {
            let what = refused.words(&self.name);
            return Err(PlayError::new(what.clone())
                .at(what, refused.line, None)
                .hint("a lower speed of this axis, or fewer steps a turn"));
        }
        if plan.laser.is_none() || self.laser {
            return Ok(());
        }
        Err(PlayError::new(format!("{}: this board has no output for a laser", self.name)).hint(
            "a Mega and a Pico with the program `stream` have one; or run the job without it",
        ))
    }

    /// The terms for feeding it with axes that brake with these decelerations, in steps/s²; `None` if
    /// one is below the board's lowest, some 8 steps/s².
    pub fn terms(&self, decels: [f64; 3]) -> Option<FeedTerms> {
        let brake = |decel: f64| BrakeLaw::of((decel * 1_000.0).floor() as u64, self.hz);
        let [x, y, z] = decels.map(brake);
        let times = LinkTimes::of_baud(self.baud);
        let terms = FeedTerms::avr([x?, y?, z?]);
        Some(FeedTerms { hz: self.hz, stagger: self.stagger, times, ahead: AHEAD, ..terms })
    }

    /// Waits until all axes are at rest.
    ///
    /// # Errors
    /// The board does not answer; an axis moves for more than 30 s.
    pub fn rest(&mut self) -> Result<(), PlayError> {
        at_rest(&mut self.session, &self.name, &Mute)
    }

    /// Makes the present place of each axis of unknown position 0. Returns whether there was such an axis.
    ///
    /// # Errors
    /// The board does not answer, or refuses.
    pub fn zero_unknown(&mut self) -> Result<bool, PlayError> {
        let mut unknown = false;
        for (axis, place) in AxisId::first(3).zip(&mut self.places) {
            if place.is_some() {
                continue;
            }
            let answer = ask(&mut self.session, &[b'I', b'0' + axis.number()]);
            let answer = answer.map_err(|trouble| PlayError::lost(&self.name, &trouble))?;
            if answer != "Y" {
                return Err(PlayError::new(format!("{}: I was answered {answer}", self.name)));
            }
            (*place, unknown) = (Some(0), true);
        }
        Ok(unknown)
    }

    /// The positions of all axes; `None` for an axis that lost its position by a kill or a reset.
    ///
    /// # Errors
    /// The board does not answer.
    pub fn positions(&mut self) -> Result<[Option<i64>; 3], PlayError> {
        positions(&mut self.session, &self.name)
    }

    /// The positions of all axes, and the number of late steps since the board was switched on.
    ///
    /// # Errors
    /// The board does not answer.
    pub fn tells(&mut self) -> Result<([Option<i64>; 3], u64), PlayError> {
        let places = self.positions()?;
        let about = ask(&mut self.session, b"?");
        let about = about.map_err(|trouble| PlayError::lost(&self.name, &trouble))?;
        Ok((places, word(&about, "late=").unwrap_or(0)))
    }

    /// Drops the board's answers to frames, a part of which could be taken for a line, until it has been
    /// quiet for this long, or has not been quiet for a second.
    pub fn hush(&mut self, quiet: Duration) {
        let (link, mut buffer) = (self.session.link(), [0; 256]);
        let end = link.now() + HUSH;
        while link.now() < end && link.read(&mut buffer, quiet).is_ok_and(|count| count != 0) {}
    }

    /// Stops all axes at once, even if the board is in the middle of a frame. Returns the result as
    /// an interruption.
    pub fn kill(&mut self) -> PlayError {
        let (tries, patience) = KILLS;
        for _ in 0..tries {
            // Fills an incomplete frame, which would otherwise take the line as its own bytes.
            let link = self.session.link();
            if link.write(&[FILL; 4]).and_then(|()| link.write(b"K\r")).is_err() {
                break;
            }
            if says_yes(link, patience) {
                let killed = "killed: the positions of axes that moved are lost";
                return PlayError::interrupted(killed);
            }
        }
        PlayError::interrupted(format!(
            "{}: the board did not confirm K: the motors may still be moving",
            self.name
        ))
        .hint("switch off the motors' power; a board that hears nothing brakes when it runs short")
    }

    /// The error for a board that has left the path: the reason, its position, and a hint.
    pub fn off(&mut self, state: FeedState) -> PlayError {
        let name = self.name.clone();
        let why = match state {
            FeedState::Tripped => "an input that stops it has closed",
            FeedState::Wrong => "it has refused a part of the job",
            _ => "it was short of what comes next",
        };
        let rests = self.rest().is_ok();
        let Some(places) = self.positions().ok().filter(|_| rests) else {
            return PlayError::new(format!("{name} has braked, off the path: {why}"))
                .hint("whether it rests, and where, it has not said");
        };
        let at = spelt(places);
        if places.contains(&None) {
            return PlayError::new(format!("{name} has stopped, off the path, at {at}")).hint(
                "a place that is ? is lost: by a kill (K), now or before the job, or by a reset",
            );
        }
        PlayError::new(format!("{name} has braked, off the path: {why}, at {at}"))
            .hint("the positions are known; a slower job, or a computer with less to do")
    }

    /// The error for a port that fails while the board plays.
    pub fn gone(&self, error: &io::Error) -> PlayError {
        PlayError::new(format!("{}: {error}", self.name))
            .hint("the board plays what it has, and brakes by itself: its position stays known")
    }

    /// The error for a board that stops answering while it plays.
    pub fn silent(&self) -> PlayError {
        PlayError::new(format!("{} does not answer any more", self.name)).hint(
            "what it has is played, and then it brakes; once it answers again it tells where it is",
        )
    }
}

/// Positions as text; ? is an unknown position.
pub fn spelt(places: [Option<i64>; 3]) -> String {
    places.map(|place| place.map_or("?".to_owned(), |place| place.to_string())).join(" ")
}

fn at_rest(session: &mut Session, name: &str, voice: &dyn PlayVoice) -> Result<(), PlayError> {
    let mut told = false;
    let rests = wait_for_rest(session, REST, || {
        if !std::mem::replace(&mut told, true) {
            voice.note(&format_args!("{name} moves: waiting until it rests"));
        }
        !voice.asked()
    });
    match rests.map_err(|trouble| PlayError::lost(name, &trouble))? {
        true => Ok(()),
        false if voice.asked() => Err(PlayError::interrupted(format!("{name} still moves"))),
        false => Err(PlayError::new(format!("{name} still moves"))
            .hint("`K` at a terminal stops it at once")),
    }
}

/// The costs of steps on the board with this answer to `?`: those of an Uno where no others are known.
fn costs(about: &str, hz: u32) -> Board<3> {
    let uno = Description::uno().board;
    let rate = Rate::from_hz(hz).unwrap_or(uno.rate);
    let each = match about.split(' ').nth(1) {
        // Measured with jerk limits: one axis at 200,000 steps/s, three at 50,000 (docs/stream.md).
        Some("pico") => [4, 6, 6],
        // 12,000, and three at 6,000.
        Some("micro:bit" | "virt") => [80, 75, 50],
        _ => return uno,
    };
    let cost = Cost::any_pulse(each.map(|micros| rate.micros(micros)));
    let mut board = Description::at(rate, cost).board;
    // Pulse and pause are in the costs.
    board.timing.min_interval = 0;
    board
}

fn positions(session: &mut Session, name: &str) -> Result<[Option<i64>; 3], PlayError> {
    let places = places(session, 3).map_err(|trouble| PlayError::lost(name, &trouble))?;
    places.try_into().map_err(|_| PlayError::new(format!("{name} has fewer than 3 axes")))
}

/// Whether the board's answer to `?` lists this ability in `can=`.
fn can(about: &str, ability: Ability) -> bool {
    let words = about.split(' ').find_map(|word| word.strip_prefix("can="));
    words.is_some_and(|words| Abilities::parse(words.as_bytes()).has(ability))
}

/// The ticks by which equal axes are kept apart. 0 on 32-bit chips, where one interrupt makes the
/// steps of all axes.
fn stagger(about: &str) -> u32 {
    match about.split(' ').nth(1) {
        Some("uno" | "mega" | "virtual") => 75,
        _ => 0,
    }
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

/// The number after a word of the answer to `?`.
fn word(about: &str, name: &str) -> Option<u64> {
    about.split(' ').find_map(|word| word.strip_prefix(name))?.parse().ok()
}

#[cfg(test)]
mod tests {
    use stepwright_path::AxisPace;
    use stepwright_plan::gcode::{JobTerms, Peak};

    use super::*;
    use crate::stream::PlayOrder;

    #[test]
    fn words_of_an_answer() {
        let about = "stepwright-stream uno hz=16000000 axes=3 late=12 fifo=896 can=sum";
        assert_eq!(word(about, "hz="), Some(16_000_000));
        assert_eq!(word(about, "late="), Some(12));
        assert_eq!(word(about, "axis="), None);
        assert_eq!((stagger(about), stagger("stepwright-stream pico hz=15625000")), (75, 0));
        assert!(!can(about, Ability::Laser) && can("x y can=sum,laser", Ability::Laser));
    }

    /// What was measured is admitted, and what was too fast is not: docs/stream.md.
    #[test]
    fn a_board_is_judged_by_its_own_costs() {
        let [pico, micro] = ["pico hz=15625000", "micro:bit hz=16000000"];
        let [uno, mega] = ["uno hz=16000000", "mega hz=16000000"];
        let admits = |about: &str, rates: [f64; 3]| {
            let board =
                costs(&format!("stepwright-stream {about}"), word(about, "hz=").unwrap() as u32);
            let peaks = rates.map(|rate| Peak { rate, line: 0 });
            JobPlan { peaks, ..JobPlan::default() }.refused_by(&board).is_none()
        };
        assert!(admits(pico, [200_000.0, 0.0, 0.0]) && admits(pico, [50_000.0; 3]));
        assert!(!admits(pico, [260_000.0, 0.0, 0.0]) && !admits(pico, [60_000.0; 3]));
        assert!(admits(micro, [12_000.0, 0.0, 0.0]) && admits(micro, [6_000.0; 3]));
        assert!(!admits(micro, [20_000.0, 0.0, 0.0]) && !admits(micro, [9_000.0; 3]));
        for board in [uno, mega] {
            assert!(admits(board, [100_000.0, 0.0, 0.0]) && admits(board, [20_000.0; 3]));
            assert!(!admits(board, [200_000.0, 0.0, 0.0]) && !admits(board, [50_000.0; 3]));
        }
    }

    /// A line whose time does not pass, and on which nothing comes.
    struct Dead;

    impl Link for Dead {
        fn write(&mut self, _: &[u8]) -> io::Result<()> {
            panic!("nothing is to be sent")
        }
        fn read(&mut self, _: &mut [u8], _: Duration) -> io::Result<usize> {
            Ok(0)
        }
        fn now(&self) -> Duration {
            Duration::ZERO
        }
        fn name(&self) -> String {
            "uno".to_owned()
        }
    }

    #[test]
    fn a_board_without_a_laser_refuses_the_job_before_a_byte_is_sent() {
        let axis = AxisPace { step: 0.0125, speed: 200.0, accel: 1e3, jump: 5.0, jerk: 1e9 };
        let job = b"M3 S500\nG1 X1 F600\n";
        let terms = JobTerms { laser: Some(1_000.0), ..JobTerms::default() };
        let uno = Description::uno().board;
        let plan = JobPlan::on(job.iter().copied(), [axis; 3], &terms, &uno, |_, _| ()).unwrap();
        let mut board = StreamedBoard {
            session: Session::new(Box::new(Dead)),
            name: "uno".to_owned(),
            hz: 16_000_000,
            baud: 115_200,
            stagger: 75,
            laser: false,
            board: uno,
            places: [Some(0); 3],
        };
        let refused = board.play(job.to_vec(), [axis; 3], &plan, &mut &PlayOrder::default());
        assert_eq!(refused.unwrap_err().message, "uno: this board has no output for a laser");
        board.laser = true;
        assert!(board.admits(&plan).is_ok());
    }
}
