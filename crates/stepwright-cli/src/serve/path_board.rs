//! Plays a cycle file on a real board, by `stepwright cycle --port` as a separate process.
//!
//! ```text
//!   file ─► stdin ─► stepwright cycle - --port PORT --format csv ─► board
//!   page ◄─ report ◄─ rows `at` on stdout, some ten a second
//!   stop ─► SIGINT: the cycle on the board ends
//! ```

use std::env;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use stepwright_serve::path::PathFile;

use crate::failure::Failure;
use stepwright_plan::sheet::quoted;
use stepwright_play::stream::{PlayEnd, PlayOrder, PlayWish};

/// The time between two checks of the order.
const LOOK: Duration = Duration::from_millis(5);

/// Plays files on a board.
pub struct BoardPlayer {
    port: PathBuf,
    /// The names of the motors, as in the rows.
    names: Vec<String>,
}

impl BoardPlayer {
    /// A player for the board at this port; `names` are those of the motors.
    pub fn new(port: PathBuf, names: Vec<String>) -> BoardPlayer {
        BoardPlayer { port, names: names.iter().map(|name| quoted(name).to_string()).collect() }
    }

    /// Plays a file, without hold. Calls `tell` with the board's time in s, the motors' positions,
    /// and the wish that they obey.
    ///
    /// # Errors
    /// The board is missing, refuses the file, or has cancelled a cycle.
    pub fn play(
        &self,
        file: &PathFile,
        order: &PlayOrder,
        tell: &mut dyn FnMut(f64, &[i64], PlayWish),
    ) -> Result<PlayEnd, Failure> {
        let failed = |error| Failure::new(format!("can't play {}: {error}", file.name));
        let mut child = self.begin().map_err(failed)?;
        let (rows, errors) = (lines(child.stdout.take()), lines(child.stderr.take()));
        if let Some(mut stdin) = child.stdin.take() {
            // A process that ends before it has read the whole file gives the reason.
            let _ = stdin.write_all(file.text.as_bytes());
        }
        let (mut places, mut seconds, mut ended) = (vec![0; self.names.len()], 0.0, None);
        loop {
            if ended.is_none()
                && let Some(end) = end(order.wish())
            {
                ended = Some(end);
                finish(&child).map_err(failed)?;
                tell(seconds, &places, PlayWish::Brake);
            }
            match rows.recv_timeout(LOOK) {
                Ok(row) => {
                    if let Some((motor, time, place)) = self.read(&row) {
                        (places[motor], seconds) = (place, time);
                        if motor + 1 == places.len() {
                            let wish = if ended.is_some() { PlayWish::Brake } else { PlayWish::Go };
                            tell(seconds, &places, wish);
                        }
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        let status = child.wait().map_err(failed)?;
        match ended {
            // The cycle ended before it received the order.
            _ if status.success() => Ok(PlayEnd::Done),
            Some(end) => Ok(end),
            None => Err(blamed(&errors.iter().collect::<Vec<_>>(), &file.name)),
        }
    }

    fn begin(&self) -> std::io::Result<Child> {
        let mut command = Command::new(env::current_exe()?);
        command.args(["cycle", "-", "--format", "csv", "--port"]).arg(&self.port);
        let pipes = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        pipes.spawn()
    }

    /// Motor, time and position from a row `time_us,motor,at,,position`.
    fn read(&self, row: &str) -> Option<(usize, f64, i64)> {
        let (rest, place) = row.rsplit_once(',')?;
        let (time, motor) = rest.strip_suffix(",at,")?.split_once(',')?;
        let motor = self.names.iter().position(|name| name == motor)?;
        Some((motor, time.parse::<f64>().ok()? / 1e6, place.parse().ok()?))
    }
}

/// The end that this wish causes.
fn end(wish: PlayWish) -> Option<PlayEnd> {
    match wish {
        PlayWish::Go | PlayWish::Hold => None,
        PlayWish::Brake => Some(PlayEnd::Stopped),
        PlayWish::Kill => Some(PlayEnd::Killed),
    }
}

/// Receives lines as they come.
fn lines(from: Option<impl Read + Send + 'static>) -> Receiver<String> {
    let (tell, hear) = mpsc::channel();
    thread::spawn(move || {
        let lines = from.into_iter().flat_map(|from| BufReader::new(from).lines());
        lines.map_while(Result::ok).try_for_each(|line| tell.send(line))
    });
    hear
}

/// Tells the process to end the cycle.
#[cfg(unix)]
fn finish(child: &Child) -> std::io::Result<()> {
    use rustix::process::{Pid, Signal, kill_process};
    Ok(kill_process(Pid::from_child(child), Signal::INT)?)
}

#[cfg(not(unix))]
fn finish(_: &Child) -> std::io::Result<()> {
    Err(std::io::Error::other("a cycle can't be ended from here on this system"))
}

/// The failure from a process' standard error, for a file with this name.
fn blamed(said: &[String], name: &str) -> Failure {
    let after = |begin: &str| said.iter().find_map(|line| line.strip_prefix(begin));
    let what = after("error: ").unwrap_or("it broke off without a word");
    // `-:7:1:` is a position in the file.
    let place = what.strip_prefix("-:").and_then(|rest| {
        let (line, rest) = rest.split_once(':')?;
        let (_, what) = rest.split_once(": ")?;
        Some(format!("{name}, line {line}: {what}"))
    });
    let failure = Failure::new(place.unwrap_or_else(|| what.to_owned()));
    match after(" hint: ") {
        Some(hint) => failure.hint(hint),
        None => failure,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_say_where_motors_are() {
        let player = BoardPlayer::new("x".into(), vec!["X".into(), "a, \"b\"".into()]);
        assert_eq!(player.read("1500000.5,X,at,,-30"), Some((0, 1.5000005, -30)));
        let second = format!("7,{},at,,5", player.names[1]);
        assert_eq!(player.read(&second), Some((1, 7e-6, 5)));
        for other in [
            "time_us,motor,event,value,position",
            "5,,cycle,start,",
            "5,Y,at,,5",
            "5,X,fault,end,5",
        ] {
            assert_eq!(player.read(other), None, "{other}");
        }
    }

    #[test]
    fn a_failure_has_its_place_and_its_remedy() {
        let said = ["error: -:7:3: too fast for X", "     7 | line", " hint: slower"];
        let failure = blamed(&said.map(str::to_owned), "a.toml");
        assert_eq!(failure.message(), "a.toml, line 7: too fast for X");
        assert_eq!(failure.hinted(), Some("slower"));
        let failure = blamed(&["error: there is no port".to_owned()], "a.toml");
        assert_eq!((failure.message(), failure.hinted()), ("there is no port", None));
    }
}
