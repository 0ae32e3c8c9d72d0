//! A host that falls silent at a random instant, in one of several ways, while axes of all speeds move;
//! and what is to become of that.

use std::f64::consts::PI;

use stepwright_feeder::FeedTerms;
use stepwright_stream::credit::Credit;
use stepwright_stream::frame::{FILL, FrameBytes, Kind};

use super::judge::{Verdict, judge};
use super::wire::{Heard, Wire};
use super::{HZ, Job, MILLIS, Step, Target, position_of, s_curve, steps_of, terms, wander};

/// A board whose inputs can be closed.
pub trait Guarded: Target {
    /// Closes an input or opens it: 0 to 2 the axes' switches, 6 the drivers' fault, 7 the emergency
    /// stop.
    fn close(&mut self, input: u8, closed: bool);
    /// The present, in cycles of its edges.
    fn now(&self) -> u64;
    /// When the wire's time began, in cycles of its edges.
    fn begun(&self) -> u64 {
        0
    }
}

/// Random numbers of a seed.
pub struct Random(u64);

impl Random {
    /// Of a seed.
    pub fn new(seed: u64) -> Random {
        Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// Any (xorshift64*).
    pub fn any(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 8
    }

    /// Below `end`.
    pub fn below(&mut self, end: u64) -> u64 {
        self.any() % end.max(1)
    }

    /// Between two numbers above 0, each ratio as likely as another.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.any() as f64 / (1u64 << 56) as f64)
    }
}

/// What moves, and how it brakes.
#[derive(Clone)]
pub struct Motion {
    pub name: &'static str,
    pub path: [Vec<Step>; 3],
    pub decels: [f64; 3],
    /// What a board waits for a sign of life at rest, in ms; 0: for ever.
    pub lease: u32,
}

impl Motion {
    /// How a host feeds it.
    pub fn terms(&self) -> FeedTerms {
        let axes = (0..3).filter(|axis| !self.path[*axis].is_empty()).map(|axis| 1 << axis).sum();
        FeedTerms { axes, lease: self.lease, inputs: 0b1100_0111, ..terms(self.decels) }
    }
}

/// Steps at one speed.
fn level(seconds: f64, speed: f64) -> Vec<Step> {
    (0..(seconds * speed).ceil() as u32).map(|n| (0.01 + f64::from(n) / speed, true)).collect()
}

/// An S-curve of some `seconds`, to a speed.
fn travel(seconds: f64, speed: f64, accel: f64) -> Vec<Step> {
    let jerk = accel * 10.0;
    let rise = speed / accel + accel / jerk;
    s_curve((speed * (rise + (seconds - 2.0 * rise).max(0.01))) as usize, speed, accel, jerk)
}

/// A motion that turns all the time, to this many steps/s².
fn organic(random: &mut Random, accel: f64) -> [Vec<Step>; 3] {
    let hz = random.between(0.5, 8.0);
    let size = accel / (2.0 * PI * hz).powi(2);
    let waves = [(size, hz), (size / 12.0, hz * 3.1)];
    [0.0, 1.9, 0.4].map(|phase| wander(2.2, &waves[..if phase == 0.4 { 1 } else { 2 }], phase))
}

/// Kinds of motion.
pub const KINDS: u64 = 8;

/// A motion of one of the [`KINDS`].
pub fn motion(kind: u64, random: &mut Random) -> Motion {
    let none = Vec::new;
    let (name, path, decels) = match kind % KINDS {
        0 => {
            let (v, a) = (random.between(10_000.0, 38_000.0), random.between(20_000.0, 80_000.0));
            let decels = [0.9, 0.7, 0.4].map(|part| a * part);
            ("three fast axes", [1.0, 1.0, 1.0].map(|part| travel(2.2, v * part, a)), decels)
        }
        1 => {
            let a = random.between(200_000.0, 400_000.0);
            let path = [travel(2.0, random.between(100_000.0, 200_000.0), a), none(), none()];
            ("one axis at the top", path, [a * 0.9; 3])
        }
        2 => {
            let accel = random.between(3_000.0, 100_000.0);
            let decels = [(); 3].map(|()| random.between(1_500.0, 100_000.0));
            ("turns all the time", organic(random, accel), decels)
        }
        3 => {
            let decels = [(); 3].map(|()| random.between(8.1, 500.0));
            let path = [(); 3].map(|()| level(2.5, random.between(1.0, 60.0)));
            ("three slow axes", path, decels)
        }
        4 => {
            let slow = random.between(1.0, 40.0);
            let path = [travel(2.2, 30_000.0, 40_000.0), level(2.5, slow), none()];
            let decels = [35_000.0, random.between(8.1, 100.0), 1_000.0];
            ("a fast and a slow axis", path, decels)
        }
        5 => {
            let (v, w) = (random.between(5_000.0, 30_000.0), random.between(50.0, 600.0));
            let path = [travel(2.2, v, 50_000.0), level(2.2, w), travel(2.0, w * 3.0, w * 10.0)];
            ("three axes of all speeds", path, [30_000.0, w * 4.0, w * 6.0])
        }
        6 => {
            let v = random.between(40_000.0, 55_000.0);
            let path = [travel(2.2, v, 60_000.0), none(), travel(2.2, v * 0.8, 60_000.0)];
            ("two fast axes", path, [55_000.0, 1_000.0, 45_000.0])
        }
        _ => {
            let speeds = [(); 3].map(|()| random.between(20.0, 3_000.0));
            // To rest within 4 s: a chip's seconds are dear.
            let decels = speeds.map(|v| random.between(v / 4.0 + 8.1, v * 4.0 + 50.0));
            ("three axes at one speed each", speeds.map(|v| level(2.5, v)), decels)
        }
    };
    Motion { name, path, decels, lease: 0 }
}

/// How a host falls silent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Befalls {
    /// The plug is pulled: nothing arrives any more.
    Plug,
    /// The host is killed: what its system had is still sent.
    Killed,
    /// Some bytes arrive still: it ends in the middle of a frame.
    Middle,
    /// Noise comes instead, for some ms.
    Noise(u64),
    /// Half a text line, and no more.
    HalfLine,
    /// The host lives, and has nothing more to send: it pings.
    Starves,
    /// What was not opened is taken back, and then nothing comes.
    Cut,
    /// The end is said behind what the board has, wherever that leads.
    End,
    /// `Z` is said, and the host goes on.
    Stop,
    /// An input closes.
    Input(u8),
}

impl Befalls {
    /// One of them.
    pub fn any(random: &mut Random) -> Befalls {
        match random.below(13) {
            0 => Befalls::Plug,
            1 => Befalls::Killed,
            2..=4 => Befalls::Middle,
            5 | 6 => Befalls::Noise(1 + random.below(400)),
            7 => Befalls::HalfLine,
            8 => Befalls::Starves,
            9 => Befalls::Cut,
            10 => Befalls::Stop,
            11 => Befalls::End,
            _ => Befalls::Input([0, 1, 2, 6, 7][random.below(5) as usize]),
        }
    }
}

/// After the last word a board knows by this time, in cycles, that nobody speaks: what is ahead of it, a
/// lease, and some.
const PATIENCE: u64 = 1_800 * MILLIS;
/// All that is ahead of a board, in cycles.
const AHEAD: u64 = 620 * MILLIS;
/// What is opened, in cycles, and until a brake can be told from a path that slows down as well.
const SOON: u64 = 80 * MILLIS;

/// What became of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    pub axes: [Verdict; 3],
    /// Whether the board had started, and whether it left the path.
    pub started: bool,
    pub off: bool,
}

/// Lets it befall a board that is being fed, now, and judges what comes of it.
///
/// # Errors
/// What is not as it has to be, in a sentence.
pub fn befall<B: Guarded>(
    board: &mut B,
    wire: &mut Wire,
    motion: &Motion,
    befalls: Befalls,
    random: &mut Random,
) -> Result<Outcome, String> {
    let mut heard = Heard::default();
    let begun = wire.now();
    let mut bound = AHEAD;
    match befalls {
        Befalls::Plug => wire.cut(0),
        Befalls::Killed => {}
        Befalls::Middle => {
            // The next moment at which something is under way.
            while wire.under_way() < 2 && wire.now() < begun + 300 * MILLIS {
                wire.feed(board, wire.now() + MILLIS / 4);
            }
            wire.cut(random.below(wire.under_way() as u64) as usize);
        }
        Befalls::Noise(millis) => {
            wire.cut(0);
            for _ in 0..millis * 11 {
                wire.send(&[random.any() as u8]);
            }
            bound += millis * MILLIS;
        }
        Befalls::HalfLine => wire.send(&b"V1*1"[..1 + random.below(4) as usize]),
        Befalls::Starves => {}
        Befalls::Cut | Befalls::End => {
            wire.pass(board, begun + 12 * MILLIS);
            heard.listen(board);
            ask_credit(board, wire, &mut heard);
            // Unless another one is opened meanwhile.
            let Credit { next, opened, .. } = heard.credit.unwrap_or_default();
            let frame = match befalls {
                Befalls::Cut => FrameBytes::new(Kind::Cut, next, &[opened]),
                _ => FrameBytes::new(Kind::End, next, &[]),
            };
            wire.send(frame.as_bytes());
        }
        Befalls::Stop => {
            wire.send(b"Z\r");
            wire.feed(board, begun + 100 * MILLIS);
            bound = SOON;
        }
        Befalls::Input(input) => {
            board.close(input, true);
            wire.feed(board, begun + 20 * MILLIS);
            bound = SOON;
        }
    }
    let silent = wire.now();
    // Who gives no lease, or goes on pinging, is waited for where all rest.
    let waits = motion.lease == 0 || befalls == Befalls::Starves;
    // Until the board says that it is off the path; then, until it rests.
    let (mut next, mut between) = (silent, None);
    loop {
        next += 20 * MILLIS;
        wire.pass(board, next);
        heard.listen(board);
        if befalls == Befalls::Starves && (next - silent).is_multiple_of(100 * MILLIS) {
            wire.send(FrameBytes::new(Kind::Ping, 0, &[]).as_bytes());
        }
        if heard.off && between.is_none() {
            between = Some(random.below(3) as u8);
            asks_on_the_way(board, wire, &mut heard, between.unwrap_or(0))?;
            next = wire.now();
        }
        if heard.off || next > silent + PATIENCE {
            let credit = ask_credit(board, wire, &mut heard).ok_or("no credit")?;
            next = wire.now();
            if !credit.is(Credit::MOVES) || !credit.is(Credit::STARTED) {
                break;
            }
        }
        if next > silent + 100 * 1_000 * MILLIS {
            if waits {
                // At rest on its path; the judge sees that no axis stopped at speed.
                break;
            }
            return Err("it moves for ever".into());
        }
    }
    let credit = heard.credit.ok_or("no credit")?;
    let mut outcome = Outcome { off: credit.is(Credit::OFF), ..Outcome::default() };
    outcome.started = credit.is(Credit::STARTED);
    if credit.is(Credit::WRONG) {
        return Err("it refused a record".into());
    }
    let tripped = matches!(befalls, Befalls::Input(_)) && outcome.off;
    if credit.is(Credit::TRIPPED) != tripped {
        return Err(format!("{befalls:?}, and tripped is {}", !tripped));
    }
    board.close(0, false);
    let mut whole = true;
    // A stop that comes before the run has begun is over then.
    let zero = board.begun();
    let first = board.edges().iter().find(|edge| edge.is_step());
    let begins = first.map_or(0, |first| first.time - zero);
    if befalls == Befalls::Stop && begins > begun + 20 * MILLIS {
        bound = AHEAD;
    }
    for axis in 0..3u8 {
        let n = usize::from(axis);
        let steps = steps_of(board.edges(), axis);
        let told = ask(board, wire, &mut heard, &format!("V{}", axis + 1));
        let at = position_of(&steps);
        if told.as_deref() != Some(&*at.to_string()) {
            return Err(format!("axis {axis} says {told:?}, and its edges {at}"));
        }
        let path = &motion.path[n];
        let verdict =
            judge(&steps, path, motion.decels[n]).map_err(|why| format!("axis {axis}: {why}"))?;
        whole &= verdict.kept == path.len() && verdict.braked == 0;
        // A slow axis makes the step that it was about to make, and the first one of its brake comes an
        // interval of the path later.
        let kept = path.get(verdict.kept.saturating_sub(2)..=verdict.kept).unwrap_or(&[]);
        let slack = kept.last().map_or(0.0, |last| last.0 - kept[0].0);
        let first = steps.first().map_or(0, |first| first.0 - board.begun());
        let left = first as f64 + verdict.left * HZ;
        if left > (silent + bound) as f64 + slack * HZ && verdict.kept < path.len() {
            return Err(format!(
                "axis {axis} leaves the path {:.0} ms later",
                (left - silent as f64) / 16e3
            ));
        }
        outcome.axes[n] = verdict;
    }
    // Not off, and started: then it has made all, unless it waits, or an end was said while all rest.
    if outcome.started && !outcome.off && !whole && !waits && befalls != Befalls::End {
        return Err("it is short of its path's end, and says nothing".into());
    }
    Ok(outcome)
}

/// Calls the board, and asks how it is.
pub fn ask_credit(board: &mut impl Target, wire: &mut Wire, heard: &mut Heard) -> Option<Credit> {
    heard.listen(board);
    heard.credit = None;
    wire.send(&[FILL; 4]);
    wire.send(FrameBytes::new(Kind::Ping, 0, &[]).as_bytes());
    for _ in 0..50 {
        wire.pass(board, wire.now() + MILLIS);
        heard.listen(board);
        if wire.under_way() == 0 && heard.credit.is_some() {
            break;
        }
    }
    heard.credit
}

/// Says a line; the answer.
pub fn ask(
    board: &mut impl Target,
    wire: &mut Wire,
    heard: &mut Heard,
    line: &str,
) -> Option<String> {
    // Noise may have begun a line, which ends here; its answer comes before.
    wire.send(&[FILL; 4]);
    wire.send(b"\r");
    wire.pass(board, wire.now() + 16 * MILLIS);
    heard.listen(board);
    heard.forget();
    wire.send(line.as_bytes());
    wire.send(b"\r");
    for _ in 0..200 {
        wire.pass(board, wire.now() + MILLIS / 4);
        heard.listen(board);
        if let Some(line) = heard.line() {
            return Some(line);
        }
    }
    None
}

/// While it brakes, the position that it tells is one that the edges have had meanwhile.
fn asks_on_the_way<B: Guarded>(
    board: &mut B,
    wire: &mut Wire,
    heard: &mut Heard,
    axis: u8,
) -> Result<(), String> {
    // What waits on the line comes first.
    wire.cut(0);
    let before = position_of(&steps_of(board.edges(), axis));
    let told = ask(board, wire, heard, &format!("V{}", axis + 1)).ok_or("no answer to V")?;
    let after = position_of(&steps_of(board.edges(), axis));
    match told.parse::<i64>() {
        Ok(at) if at >= before.min(after) && at <= before.max(after) => Ok(()),
        _ => Err(format!("on the way axis {axis} says {told}, and its edges {before} … {after}")),
    }
}

/// A run, up to a random instant of it, in cycles from the beginning.
pub fn instant(motion: &Motion, random: &mut Random) -> u64 {
    let end = Job::new(motion.path.clone()).end;
    random.below(((end + 0.1) * HZ) as u64)
}
