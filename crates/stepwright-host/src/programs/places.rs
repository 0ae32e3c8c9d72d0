//! The positions of a board's axes, with any program. All programs know `V` and `F`.
//!
//! Another stepwright may send lines to the same board meanwhile, as `stop` and `kill` do. The
//! answer to such a line may come in place of the answer to one of these. So positions count only
//! if each answer to `V` has the right form, and also the answer to the `F` after them.

use std::time::Duration;

use stepwright_protocol::AxisId;

use crate::conversation::LinkError;
use crate::motion::POLL;
use crate::session::Session;

/// How often positions are requested.
const TRIES: usize = 5;

/// Sends a text line, and returns the board's answer. A line without an answer is sent twice more.
///
/// # Errors
/// [`LinkError`]: the board does not answer, or the link has failed.
pub fn ask(session: &mut Session, line: &[u8]) -> Result<String, LinkError> {
    for _ in 0..3 {
        // The rest of an answer to a frame is not text.
        let answer = session.say(line)?;
        let text = answer.map(|text| text.chars().filter(char::is_ascii).collect::<String>());
        if let Some(text) = text.filter(|text| !text.is_empty()) {
            return Ok(text);
        }
    }
    Err(LinkError::Silent)
}

/// Waits until all axes are at rest, for at most `limit`. `moves` is called at each look at a moving board, and
/// returns whether to go on waiting. Returns whether the axes are at rest.
///
/// # Errors
/// [`LinkError`]: the board does not say whether it moves, or the link has failed.
pub fn wait_for_rest(
    session: &mut Session,
    limit: Duration,
    mut moves: impl FnMut() -> bool,
) -> Result<bool, LinkError> {
    let (end, mut others) = (session.now().saturating_add(limit), 0);
    loop {
        match ask(session, b"F")?.as_str() {
            "R" => return Ok(true),
            "B" if session.now() > end || !moves() => return Ok(false),
            "B" => {}
            _ if others < TRIES => others += 1,
            _ => return Err(LinkError::Silent),
        }
        session.pause(POLL)?;
    }
}

/// The positions of the first axes, at most this many; `None` for an axis that lost its position by
/// a kill.
///
/// # Errors
/// [`LinkError`]: the answers are not those of positions, or the link has failed.
pub fn places(session: &mut Session, most: u8) -> Result<Vec<Option<i64>>, LinkError> {
    for _ in 0..TRIES {
        if let Some(places) = in_step(session, most)? {
            return Ok(places);
        }
        // Drops bytes that come meanwhile.
        session.pause(Duration::from_millis(100))?;
    }
    Err(LinkError::Silent)
}

/// Requests the positions once; `None` if an answer is to another line.
fn in_step(session: &mut Session, most: u8) -> Result<Option<Vec<Option<i64>>>, LinkError> {
    let mut places = Vec::new();
    for axis in AxisId::first(most) {
        let answer = ask(session, &[b'V', b'0' + axis.number()])?;
        match (answer.as_str(), answer.parse()) {
            (_, Ok(place)) => places.push(Some(place)),
            ("E uncertain", _) => places.push(None),
            ("E axis", _) if !places.is_empty() => break,
            _ => return Ok(None),
        }
    }
    let step = ask(session, b"F")?;
    Ok(matches!(step.as_str(), "R" | "B").then_some(places))
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;
    use std::io;

    use crate::link::Link;

    use super::*;

    /// A board with two axes. Answers to another program's lines come before its own.
    struct Shared {
        others: VecDeque<&'static str>,
        said: Vec<u8>,
        answers: Vec<u8>,
        now: Duration,
    }

    impl Link for Shared {
        fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
            for byte in bytes {
                if *byte != b'\r' {
                    self.said.push(*byte);
                    continue;
                }
                if let Some(other) = self.others.pop_front().filter(|other| !other.is_empty()) {
                    self.answers.extend(other.bytes().chain([b'\r']));
                }
                let answer = match std::mem::take(&mut self.said).as_slice() {
                    b"V1" => "-4000",
                    b"V2" => "E uncertain",
                    b"F" => "R",
                    [b'V', _] => "E axis",
                    _ => "E line",
                };
                self.answers.extend(answer.bytes().chain([b'\r']));
            }
            Ok(())
        }

        fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
            self.now += limit.min(Duration::from_millis(10));
            let said = self.answers.drain(..self.answers.len().min(buffer.len()));
            Ok(buffer.iter_mut().zip(said).map(|(to, byte)| *to = byte).count())
        }

        fn now(&self) -> Duration {
            self.now
        }

        fn name(&self) -> String {
            "the board".to_owned()
        }
    }

    fn with(others: &[&'static str]) -> Session {
        let others = others.iter().copied().collect();
        let (said, answers) = (Vec::new(), Vec::new());
        Session::new(Box::new(Shared { others, said, answers, now: Duration::ZERO }))
    }

    /// Without the check of `F`, the third of these would be taken for the position of another
    /// axis.
    #[test]
    fn an_answer_to_another_program_is_no_place() {
        for others in [&[][..], &["Y"], &["", "77"], &["Y", "Y", "R"], &["", "", "0", "Y"]] {
            let two = places(&mut with(others), 3).map_err(|trouble| trouble.to_string());
            assert_eq!(two, Ok(vec![Some(-4000), None]), "{others:?}");
        }
    }

    #[test]
    fn who_never_says_whether_it_moves_is_not_waited_for() {
        let rests = |others: &[&'static str], looks: usize| {
            let (limit, mut looks) = (Duration::from_secs(9), 0..looks);
            let rests = wait_for_rest(&mut with(others), limit, || looks.next().is_some());
            rests.map_err(|trouble| trouble.to_string())
        };
        assert_eq!(rests(&[], 9), Ok(true));
        assert_eq!(rests(&["Y", "B", "B", "B", "B", "B", "B", "Y"], 9), Ok(true));
        assert_eq!(rests(&["B"; 20], 9), Ok(false));
        // More looks than there are in 9 s.
        assert_eq!(rests(&["B"; 1_000], 900), Ok(false));
        assert!(rests(&["E line"; 20], 9).is_err());
    }
}
