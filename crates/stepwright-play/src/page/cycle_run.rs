//! Plays a file for a page: in real time on a virtual board, as a real board would play it, or on a
//! real board.

use std::fmt::Display;
use std::thread;
use std::time::{Duration, Instant};

use stepwright_cyclefile::MOST;
use stepwright_host::programs::CycleSession;

use super::PageListener;
use crate::cycle::{CyclePlayer, CyclesOnBoard, Onlooker, PlayAhead, PlayPart, PlayText};
use crate::stream::{PlayEnd, PlayOrder, PlayWish};
use crate::{Mute, PlayError, PlayFormat, PlayVoice};

/// The time between two checks of the clock and the order.
const LOOK: Duration = Duration::from_millis(2);

/// The time between two reports.
const REPORT: Duration = Duration::from_millis(20);

/// The longest duration of a cycle in seconds.
const LIMIT: u32 = 3_600;

/// Lets the virtual board's time pass in real time.
struct RealTime<'a> {
    begun: Instant,
    hz: f64,
    motors: usize,
    places: [i64; MOST],
    order: &'a PlayOrder,
    braking: bool,
    killed: bool,
    told: Option<Instant>,
    tell: PageListener<'a>,
}

impl RealTime<'_> {
    fn report(&mut self, ticks: u64) {
        self.told = Some(Instant::now());
        let wish = if self.braking { PlayWish::Brake } else { PlayWish::Go };
        (self.tell)(ticks as f64 / self.hz, &self.places[..self.motors], wish);
    }
}

impl Onlooker for RealTime<'_> {
    fn part(&mut self, _: PlayPart) {}

    fn at(&mut self, _: u64, positions: &[i64; MOST]) {
        self.places = *positions;
    }

    fn may(&mut self, ticks: u64) -> Result<PlayAhead, PlayError> {
        match self.order.wish() {
            PlayWish::Kill => {
                self.killed = true;
                return Err(PlayError::interrupted("killed"));
            }
            PlayWish::Brake if !self.braking => {
                self.braking = true;
                self.report(ticks);
                return Ok(PlayAhead::Stop);
            }
            _ => {}
        }
        if self.told.is_none_or(|told| told.elapsed() >= REPORT) {
            self.report(ticks);
        }
        let now = || (self.begun.elapsed().as_secs_f64() * self.hz) as u64;
        if now() <= ticks {
            thread::sleep(LOOK);
        }
        Ok(PlayAhead::On(now()))
    }
}

/// Plays a file in real time, without hold. Calls `tell` with the time in s, the motors' positions
/// and the order that they obey; also at the end.
///
/// # Errors
/// A mistake in the file; a cycle that is refused or cancelled.
pub fn play_cycles(
    name: &str,
    text: &str,
    order: &PlayOrder,
    tell: PageListener,
) -> Result<PlayEnd, PlayError> {
    let text = PlayText::named(name, text);
    let mut plan = stepwright_cyclefile::read(&text)?;
    let mut stages = std::mem::take(&mut plan.stages);
    let motors = plan.names.len();
    let mut time = RealTime {
        begun: Instant::now(),
        hz: f64::from(plan.rate.hz()),
        motors,
        places: plan.positions,
        order,
        braking: false,
        killed: false,
        told: None,
        tell,
    };
    let (played, ticks, braked) = {
        let session = CyclePlayer::new(&plan, &text, (), PlayFormat::Silent, &Mute, None, LIMIT);
        let mut session = session.before(&mut time);
        let played = session.play(&mut stages);
        (played, session.now(), session.braked())
    };
    time.report(ticks);
    match played {
        _ if time.killed => Ok(PlayEnd::Killed),
        Ok(()) if braked => Ok(PlayEnd::Stopped),
        Ok(()) => Ok(PlayEnd::Done),
        Err(why) => Err(why),
    }
}

/// The voice of a run on a board: silent, and ended by the order.
struct Ordered<'a>(&'a PlayOrder);

impl PlayVoice for Ordered<'_> {
    fn result(&self, _: &dyn Display) {}

    fn note(&self, _: &dyn Display) {}

    fn asked(&self) -> bool {
        self.0.wish() >= PlayWish::Brake
    }
}

/// Plays a file on a board, without hold. Calls `tell` some ten times a second with
/// the board's time in s, the motors' positions and the order that they obey.
///
/// # Errors
/// A mistake in the file; a cycle that is refused or cancelled.
pub fn play_cycles_on(
    board: CycleSession,
    name: &str,
    text: &str,
    order: &PlayOrder,
    tell: PageListener,
) -> Result<PlayEnd, PlayError> {
    let text = PlayText::named(name, text);
    let mut plan = stepwright_cyclefile::read(&text)?;
    let mut stages = std::mem::take(&mut plan.stages);
    let hz = f64::from(plan.rate.hz());
    let mut look = |ticks: u64, places: &[i64]| tell(ticks as f64 / hz, places, order.wish());
    let voice = Ordered(order);
    let mut player = CyclesOnBoard::new(board, &plan, &text, PlayFormat::Silent, &voice, LIMIT);
    player.watch_by(&mut look);
    match player.play(&mut stages) {
        // A cycle may end before it has received the order.
        Ok(()) => Ok(PlayEnd::Done),
        Err(why) if !why.interrupted => Err(why),
        Err(_) if order.wish() == PlayWish::Kill => Ok(PlayEnd::Killed),
        Err(_) => Ok(PlayEnd::Stopped),
    }
}
