//! A curve: pieces of constant jerk, in closed form.
//!
//! Within a piece neither the speed nor the acceleration changes its sign. A piece is described
//! **from its slower end**, with time and distance counted from there:
//!
//! ```text
//!   σ(τ) = v·τ + a·τ²/2 + j·τ³/6       v ≥ 0, a + j·τ ≥ 0: σ rises ever faster
//! ```
//!
//! So σ is convex: Newton's method from the right converges to τ(σ) without overshooting, and as
//! σ′·τ ≥ σ, the relative error of τ is no larger than that of σ, however near to rest. Pieces
//! before the fastest moment have their places and times from the beginning, those after it from
//! the end, so that both ends are exact.
//!
//! A pulse is due whenever the curve reaches a whole step other than the last one. Where the curve
//! turns back between two steps, the pulse of the last step is not repeated:
//!
//! ```text
//!   11 ┈┈┈┈┈┈┈┈┈┈┈┈┈┈┈┈┈┈┈┈
//!            _____
//!   10 ┈┈┈▲╱┈┈┈┈┈╲┈┈┈┈┈┈┈┈┈     ▲ a pulse forward   ▼ a pulse back
//!        ╱        ╲
//!    9 ┈▲┈┈┈┈┈┈┈┈┈┈▼┈┈┈┈┈┈┈
//! ```

use super::State;
use super::course::{Course, Limits, Motion, Stage, way};
use crate::profile::{Phase, Unfit};
use crate::units::Rate;
use crate::wide::Wide;

/// The most pieces of a curve: 11 stages, 5 of them divided.
const PIECES: usize = 16;
/// The most legs: a curve turns back at most three times.
const LEGS: usize = 4;

/// A period of constant jerk, in steps and seconds, as seen from its slower end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Piece {
    /// Time and place of the slower end.
    at: Wide,
    place: Wide,
    /// Speed and acceleration at the slower end, and the jerk, positive in the piece's direction.
    v: Wide,
    a: Wide,
    pub(super) jerk: Wide,
    /// Time and distance to the faster end.
    time: Wide,
    way: Wide,
    /// Whether the slower end comes first.
    pub(super) speeds_up: bool,
    backward: bool,
    phase: Phase,
    /// The first pulse after the beginning of the piece (for the first piece: at it), and the last
    /// pulse before its end or at it.
    pub(super) first: u32,
    pub(super) last: u32,
    /// The last pulse whose interval has its middle before the end of the piece.
    middle: u32,
}

/// A part of the curve in one direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Leg {
    /// The last pulse before the leg, and its step.
    first: u32,
    from: i64,
    /// The last pulse of the leg.
    last: u32,
    /// When the leg begins, in seconds.
    pub(super) begin: Wide,
    pub(super) backward: bool,
}

impl Leg {
    /// The step of a pulse of this leg.
    fn place_of(&self, n: u32) -> i64 {
        let steps = i64::from(n.saturating_sub(self.first));
        if self.backward { self.from - steps } else { self.from + steps }
    }

    /// The motion at a moment of this leg, with its sign.
    pub(super) fn motion(&self, moment: &Moment) -> Motion {
        Motion { v: moment.v.flipped(self.backward), a: moment.a.flipped(self.backward) }
    }
}

/// The time and the motion at a pulse.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    /// The time in seconds.
    pub time: Wide,
    /// Speed and acceleration in the direction of motion.
    pub v: Wide,
    pub a: Wide,
    /// The time from the piece's slower end.
    pub tau: Wide,
}

/// A motion along one axis in closed form, within limits of speed, acceleration and jerk, with one
/// pulse per step; it may turn back on its way.
///
/// Made by a law: [`SCurve::curve`](super::SCurve::curve).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Curve {
    rate: Rate,
    pieces: [Piece; PIECES],
    piece_count: u8,
    legs: [Leg; LEGS],
    leg_count: u8,
    pulses: u32,
    /// The highest speed.
    peak: Wide,
}

const NO_PIECE: Piece = Piece {
    at: Wide::ZERO,
    place: Wide::ZERO,
    v: Wide::ZERO,
    a: Wide::ZERO,
    jerk: Wide::ZERO,
    time: Wide::ZERO,
    way: Wide::ZERO,
    speeds_up: true,
    backward: false,
    phase: Phase::Cruise,
    first: 0,
    last: 0,
    middle: 0,
};

const NO_LEG: Leg = Leg { first: 0, from: 0, last: 0, begin: Wide::ZERO, backward: false };

impl Piece {
    fn new(stage: Stage) -> Piece {
        let backward = (stage.from.v + stage.to.v).is_minus();
        let speeds_up = stage.from.v.abs() <= stage.to.v.abs();
        let slow = if speeds_up { stage.from } else { stage.to };
        // Anything below 0 is rounding.
        let v = slow.v.flipped(backward).max(Wide::ZERO);
        let a = slow.a.flipped(backward == speeds_up);
        let (jerk, time) = (stage.jerk.flipped(backward), stage.time);
        let phase = match (jerk.is_zero(), jerk.is_minus() == speeds_up) {
            (true, _) if a.is_zero() => Phase::Cruise,
            (true, _) if speeds_up => Phase::Up,
            (true, _) => Phase::Down,
            (false, false) => Phase::JerkUp,
            (false, true) => Phase::JerkDown,
        };
        let way = way(v, a, jerk, time);
        Piece { v, a, jerk, time, way, speeds_up, backward, phase, ..NO_PIECE }
    }

    /// Place and time of the end of the piece.
    fn end(&self) -> (Wide, Wide) {
        match self.speeds_up {
            true => (self.place + self.way.flipped(self.backward), self.at + self.time),
            false => (self.place, self.at),
        }
    }

    /// The time of the beginning of the piece.
    fn begin(&self) -> Wide {
        if self.speeds_up { self.at } else { self.at - self.time }
    }

    /// The time from the slower end over the distance `sigma`; a guess speeds the search up.
    fn time_of(&self, sigma: Wide, guess: Option<Wide>) -> Wide {
        if !sigma.is_plus() {
            return Wide::ZERO;
        }
        // Each term alone would take longer than all together.
        let mut tau = self.time.min(sigma / self.v);
        if let Some(guess) = guess {
            tau = tau.min(guess);
        } else if self.jerk.is_minus() {
            // The jerk takes away at most a third of what the acceleration contributes.
            tau = tau.min((Wide::whole(3) * sigma / self.a).sqrt());
        } else {
            tau = tau.min((sigma.scaled(1) / self.a).sqrt());
            tau = tau.min((Wide::whole(6) * sigma / self.jerk).above_cube_root());
        }
        for _ in 0..40 {
            let change = self.jerk * tau;
            let v = self.v + (self.a + change.scaled(-1)) * tau;
            let off = way(self.v, self.a, self.jerk, tau) - sigma;
            let step = off / v;
            tau = (tau - step).min(self.time);
            if step.abs() <= tau.scaled(-34) {
                break;
            }
        }
        if tau.is_minus() { Wide::ZERO } else { tau }
    }

    /// The moment at which the curve is at `place`.
    fn moment(&self, place: Wide, guess: Option<Wide>) -> Moment {
        let sigma = (place - self.place).flipped(self.backward == self.speeds_up);
        let tau = self.time_of(sigma, guess);
        let change = self.jerk * tau;
        let v = self.v + (self.a + change.scaled(-1)) * tau;
        let a = self.a + change;
        if self.speeds_up {
            Moment { time: self.at + tau, v, a, tau }
        } else {
            Moment { time: self.at - tau, v, a: -a, tau }
        }
    }
}

impl Curve {
    /// From `motion` to the end speed of the limits, `distance` steps away.
    pub(super) fn new(
        rate: Rate,
        limits: &Limits,
        motion: Motion,
        distance: i64,
    ) -> Result<Curve, Unfit> {
        let mut curve = Curve {
            rate,
            pieces: [NO_PIECE; PIECES],
            legs: [NO_LEG; LEGS],
            piece_count: 0,
            leg_count: 0,
            pulses: 1,
            peak: motion.v.abs(),
        };
        curve.lay(&limits.course(motion, Wide::signed(distance)), motion.v, distance)?;
        curve.number(distance)?;
        curve.check()?;
        Ok(curve)
    }

    /// Divides the course into pieces and sets their places and times.
    fn lay(&mut self, course: &Course, v: Wide, distance: i64) -> Result<(), Unfit> {
        let (mut place, mut time) = (Wide::ZERO, Wide::ZERO);
        // The fastest point: the index of the piece after it, and the speed.
        let mut fastest = (0, v);
        for part in course.iter().flat_map(|stage| stage.parts()) {
            let mut piece = Piece::new(part);
            if part.from.v.abs() > fastest.1.abs() {
                fastest = (self.piece_count, part.from.v);
            }
            let end = (place + piece.way.flipped(piece.backward), time + piece.time);
            (piece.place, piece.at) = if piece.speeds_up { (place, time) } else { end };
            (place, time) = end;
            let slot = self.pieces.get_mut(usize::from(self.piece_count));
            *slot.ok_or(Unfit::TooLong)? = piece; // never happens: there are enough
            self.piece_count += 1;
            if part.to.v.abs() > fastest.1.abs() {
                fastest = (self.piece_count, part.to.v);
            }
        }
        // The rounding error is corrected at the highest speed.
        let rest = Wide::signed(distance) - place;
        let more = if rest.is_zero() { rest } else { rest / fastest.1 };
        self.peak = fastest.1.abs();
        let pieces = self.pieces.iter_mut().take(self.piece_count.into());
        for piece in pieces.skip(fastest.0.into()) {
            (piece.place, piece.at) = (piece.place + rest, piece.at + more);
        }
        Ok(())
    }

    /// Finds the legs, and assigns the pulses to the pieces.
    fn number(&mut self, distance: i64) -> Result<(), Unfit> {
        let count = usize::from(self.piece_count);
        let mut leg = Leg { backward: self.pieces[0].backward, ..NO_LEG };
        let mut before: Option<&mut Piece> = None;
        for (n, piece) in self.pieces.iter_mut().take(count).enumerate() {
            if piece.backward != leg.backward {
                // A turn on a step: rounding must not put it before the step.
                if let Some(piece) = before {
                    let way = (piece.end().0 - Wide::signed(leg.from)).flipped(leg.backward);
                    let steps = (way + Wide::whole(1).scaled(-30)).floor().max(0);
                    let last = leg.first.saturating_add(u32::try_from(steps).unwrap_or(0));
                    leg.last = leg.last.max(last);
                    piece.last = leg.last;
                }
                self.leg_count = push(&mut self.legs, self.leg_count, leg);
                leg = Leg {
                    first: leg.last,
                    from: leg.place_of(leg.last),
                    begin: piece.begin(),
                    backward: piece.backward,
                    ..leg
                };
            }
            let way = (piece.end().0 - Wide::signed(leg.from)).flipped(leg.backward);
            let steps = match n + 1 == count {
                true if leg.backward => leg.from - distance,
                true => distance - leg.from,
                false => way.floor(),
            };
            let last = u32::try_from(i64::from(leg.first).saturating_add(steps.max(0)));
            let last = last.ok().filter(|&last| last < 1 << 31).ok_or(Unfit::TooLong)?;
            let middle = (way + Wide::whole(1).scaled(-1)).floor().max(0);
            piece.first = if n == 0 { 0 } else { leg.last + 1 };
            piece.last = last.max(leg.last);
            piece.middle = leg.first.saturating_add(u32::try_from(middle).unwrap_or(u32::MAX));
            leg.last = piece.last;
            before = Some(piece);
        }
        self.leg_count = push(&mut self.legs, self.leg_count, leg);
        self.pulses = leg.last + 1;
        // The last pulse belongs to the last piece, even if the rest of that piece is shorter than
        // a place this far out can represent. (Except if the curve only comes back to a step that
        // it has made.)
        let last = leg.last;
        if last > leg.first {
            for piece in self.pieces.iter_mut().take(count.saturating_sub(1)) {
                piece.last = piece.last.min(last.saturating_sub(1));
            }
        }
        if let Some(piece) = self.pieces.get_mut(count.saturating_sub(1)) {
            (piece.first, piece.middle) = (piece.first.min(last), last);
        }
        // A middle after the turn belongs to the next leg.
        let mut next = (leg.backward, last.saturating_add(1));
        let mut most = last;
        for piece in self.pieces.iter_mut().take(count).rev() {
            if piece.backward != next.0 {
                most = next.1.saturating_sub(1);
            }
            piece.middle = piece.middle.min(most);
            next = (piece.backward, piece.first);
        }
        Ok(())
    }

    /// Checks that no interval exceeds 2³¹ ticks. The longest intervals are where the speed is
    /// least: where pieces meet.
    fn check(&self) -> Result<(), Unfit> {
        if self.length() == 0 {
            return Ok(());
        }
        let meetings = self.pieces.iter().take(self.piece_count.into()).map(|piece| piece.last);
        for n in meetings.chain([0]) {
            let n = n.min(self.length() - 1);
            if self.due(n + 1).saturating_sub(self.due(n)) >> 63 != 0 {
                return Err(Unfit::TooSlow);
            }
        }
        Ok(())
    }

    /// The number of pulses in this curve, including the one at which it begins: 0 … 2³¹.
    pub const fn pulses(&self) -> u32 {
        self.pulses
    }

    /// This curve with at most `pulses` pulses; 0 if there is none to make.
    pub(super) fn of(mut self, pulses: u32) -> Curve {
        self.pulses = self.pulses.min(pulses);
        self
    }

    /// Steps from the first pulse to the last.
    pub(super) const fn length(&self) -> u32 {
        self.pulses.saturating_sub(1)
    }

    pub(super) const fn rate(&self) -> Rate {
        self.rate
    }

    /// The leg of pulse n.
    pub(super) fn leg_of(&self, n: u32) -> &Leg {
        let mut legs = self.legs.iter().take(self.leg_count.into());
        legs.find(|leg| n <= leg.last && n > leg.first).unwrap_or(&self.legs[0])
    }

    /// The piece of pulse n.
    pub(super) fn piece_of(&self, n: u32) -> &Piece {
        let mut pieces = self.pieces.iter().take(self.piece_count.into());
        pieces.find(|piece| n <= piece.last).unwrap_or(&NO_PIECE)
    }

    /// The moment of pulse n; a guess of its time in its piece speeds the search up.
    pub(super) fn moment(&self, n: u32, guess: Option<Wide>) -> Moment {
        self.piece_of(n).moment(Wide::signed(self.leg_of(n).place_of(n)), guess)
    }

    /// Seconds in 2⁻³² ticks.
    pub(super) fn ticks(&self, time: Wide) -> u128 {
        (time * Wide::whole(self.rate.hz().into())).to_q32()
    }

    /// The time of pulse n, in 2⁻³² ticks.
    fn due(&self, n: u32) -> u128 {
        self.ticks(self.moment(n, None).time)
    }

    /// The time of pulse `n`, in ticks after pulse 0, rounded to the nearest tick; `n` beyond the
    /// end counts as the end.
    pub fn time_of(&self, n: u32) -> u64 {
        let due = self.due(n.min(self.length())).saturating_add(1 << 31);
        u64::try_from(due >> 32).unwrap_or(u64::MAX)
    }

    /// Steps from the first pulse to pulse `n`, negative if it is behind the first; `n` beyond the
    /// end counts as the end.
    pub fn place_of(&self, n: u32) -> i64 {
        let n = n.min(self.length());
        self.leg_of(n).place_of(n)
    }

    /// Speed and acceleration at pulse `n`, from which another curve may begin; `n` beyond the end
    /// counts as the end.
    pub fn state_at(&self, n: u32) -> State {
        let n = n.min(self.length());
        State(self.leg_of(n).motion(&self.moment(n, None)))
    }

    /// The highest speed on this curve, in thousandths of a step per second,
    /// rounded up.
    pub fn peak(&self) -> u32 {
        if self.pulses < 2 {
            return 0;
        }
        let v = self.peak * Wide::whole(1000);
        // A value that differs from a whole number only by rounding counts as that number.
        let v = v - v.scaled(-50);
        u32::try_from(v.ceil()).unwrap_or(u32::MAX)
    }

    /// The phase of pulse n: that of the middle of the interval before it; for pulse 0, that of the
    /// first interval.
    pub fn phase_of(&self, n: u32) -> Phase {
        let n = n.clamp(1, self.length().max(1));
        let mut pieces = self.pieces.iter().take(self.piece_count.into());
        pieces.find(|piece| n <= piece.middle).unwrap_or(&NO_PIECE).phase
    }

    /// The phases in order, with the number of pulses of each; phases without a pulse are left out.
    pub fn phases(&self) -> impl Iterator<Item = (Phase, u32)> {
        let mut gone = 0;
        let pulses = self.pulses;
        let pieces = self.pieces.iter().take(self.piece_count.into());
        let alone = (self.piece_count == 0 && pulses > 0).then_some((Phase::Cruise, pulses));
        let phases = pieces.filter_map(move |piece| {
            // The first pulse has no interval: it belongs to the phase of the next one.
            let end = match piece.middle {
                0 if self.length() > 0 => 0,
                middle => middle.saturating_add(1).min(pulses),
            };
            let count = end.saturating_sub(gone);
            gone = gone.max(end);
            (count > 0).then_some((piece.phase, count))
        });
        phases.chain(alone)
    }

    /// Steps from the point where the speed begins to fall for the last time to the end, rounded
    /// up.
    pub fn braking_steps(&self) -> u32 {
        let pieces = self.pieces.iter().take(self.piece_count.into());
        let fall = pieces.rev().take_while(|piece| !piece.speeds_up).last();
        let Some(fall) = fall.filter(|_| self.length() > 0) else { return 0 };
        let begin = fall.place - fall.way.flipped(fall.backward);
        let end = Wide::signed(self.leg_of(self.length()).place_of(self.length()));
        u32::try_from((end - begin).abs().ceil()).unwrap_or(u32::MAX)
    }
}

fn push(legs: &mut [Leg; LEGS], count: u8, leg: Leg) -> u8 {
    match legs.get_mut(usize::from(count)) {
        Some(slot) => {
            *slot = leg;
            count + 1
        }
        None => count, // never happens: there are enough
    }
}
