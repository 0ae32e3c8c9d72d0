//! A path of several lines and arcs in one cycle, passed at speed.
//!
//! ```text
//!   path = { speed, accel, pieces = [line, arc, …] } ──► Joined ──► Route ──► Stream ──► motors
//! ```
//!
//! Places of the route are counted from the positions of the motors, so its steps are those of the motors,
//! whatever the positions.

use std::ops::Range;

use stepwright::Ticks;
use stepwright_path::{AxisPace, AxisStream, PACES, Route, Stream, Unplannable};
use toml::Spanned;

use crate::file;
use crate::plan::{Act, CyclePlan, MOST, Move, TimedAct};
use crate::text::{CycleText, FileError};

/// The steps of a motor along a joined path.
pub(crate) type JoinedSteps = AxisStream<Route<MOST>, MOST>;

/// A joined path while it is played. Its [`Route`] may be changed.
pub type JoinedPath = Stream<Route<MOST>, MOST>;

/// Lines and arcs, and the limits along them.
pub struct Joined {
    /// The speed along the path, in units/s.
    pub speed: f64,
    /// The acceleration of each motor, in units/s².
    accel: f64,
    /// The change of the speed of each motor that is allowed at once, in units/s.
    jump: Option<f64>,
    /// The jerk of each motor, in units/s³, if it is limited.
    jerk: Option<f64>,
    pieces: Vec<(Range<usize>, Piece)>,
}

/// A line or an arc, in positions.
enum Piece {
    /// Motors, and the positions to which they move.
    Line(Vec<(u8, i64)>),
    /// Two motors around a centre, by an angle in radians.
    Arc([u8; 2], [i64; 2], f64),
}

impl Joined {
    /// Checks a path of the file.
    pub(crate) fn read(
        plan: &CyclePlan,
        text: &CycleText,
        given: &Spanned<file::Joined>,
    ) -> Result<Joined, FileError> {
        let (at, given) = (given.span(), given.get_ref());
        if given.pieces.is_empty() {
            return Err(text.blame(at, "a path takes pieces: lines and arcs"));
        }
        for (value, wrong) in [
            (Some(&given.speed), Unplannable::Speed),
            (Some(&given.accel), Unplannable::Accel),
            (given.start_speed.as_ref(), Unplannable::Jump),
            (given.jerk.as_ref(), Unplannable::Jerk),
        ] {
            if let Some(value) = value.filter(|value| !PACES.contains(value.get_ref())) {
                return Err(text.blame(value.span(), wrong));
            }
        }
        let piece = |given: &Spanned<file::Piece>| {
            let (at, piece) = (given.span(), given.get_ref());
            let line = !piece.to.is_empty();
            let made = match (&piece.motors, &piece.centre, &piece.degrees) {
                (None, None, None) if line => Piece::Line(plan.targets(text, &piece.to)?),
                (Some([x, y]), Some(centre), Some(degrees)) if !line => {
                    let motors = [plan.motor(text, x)?, plan.motor(text, y)?];
                    Piece::Arc(motors, *centre, degrees.to_radians())
                }
                _ => {
                    let what = "a piece is a line, which has to, or an arc, which has motors, \
                                centre and degrees";
                    return Err(text.blame(at, what));
                }
            };
            Ok((at, made))
        };
        let pieces = given.pieces.iter().map(piece).collect::<Result<_, _>>()?;
        let jump = given.start_speed.as_ref().map(|jump| *jump.get_ref());
        let jerk = given.jerk.as_ref().map(|jerk| *jerk.get_ref());
        let (speed, accel) = (*given.speed.get_ref(), *given.accel.get_ref());
        Ok(Joined { speed, accel, jump, jerk, pieces })
    }

    /// The whole route. Its places are counted from the positions of the motors.
    fn route(
        &self,
        plan: &CyclePlan,
        text: &CycleText,
        from: &[i64],
    ) -> Result<Route<MOST>, FileError> {
        let axes = plan.motors.map(|motor| {
            let step = f64::from(motor.distance);
            // A little slower, so that no step comes a tick too soon by rounding.
            let speed = 0.999 * step / (f64::from(motor.smallest_delay) / 1e6);
            // The speed after the first step from rest.
            let jump = self.jump.unwrap_or((2.0 * self.accel * step).sqrt());
            let jerk = self.jerk.unwrap_or(f64::INFINITY);
            AxisPace { step, speed, accel: self.accel, jump: jump.min(speed), jerk }
        });
        let wrong = |at: &Range<usize>, what: Unplannable| text.blame(at.clone(), what);
        let begin = self.pieces.first().map_or(0..0, |(at, _)| at.clone());
        let mut route = Route::new(axes).map_err(|what| wrong(&begin, what))?;
        let here = |motor: u8| from.get(usize::from(motor)).copied().unwrap_or(0) as f64;
        for (at, piece) in &self.pieces {
            let added = match piece {
                Piece::Line(to) => {
                    let mut end = route.end();
                    for &(motor, to) in to {
                        end[usize::from(motor)] = to as f64 - here(motor);
                    }
                    route.line_to(end, self.speed)
                }
                Piece::Arc(motors, centre, sweep) => {
                    let centre = [0, 1].map(|n| centre[n] as f64 - here(motors[n]));
                    let motors = motors.map(usize::from);
                    route.arc(motors, centre, *sweep, [0.0; MOST], self.speed)
                }
            };
            added.map_err(|what| wrong(at, what))?;
        }
        route.close();
        Ok(route)
    }

    /// The moves of the motors; none if no motor has a step to make. `acts` is empty afterwards.
    pub(crate) fn moves(
        &self,
        plan: &CyclePlan,
        text: &CycleText,
        positions: &[i64],
        acts: &mut Vec<TimedAct>,
        at: &Range<usize>,
        lead: Ticks,
    ) -> Result<Vec<Move>, FileError> {
        let mut route = self.route(plan, text, positions)?;
        let begins = f64::from(lead) / f64::from(plan.rate.hz());
        for TimedAct { us, at, act } in std::mem::take(acts) {
            let seconds = (us as f64 / 1e6 - begins).max(0.0);
            match act {
                Act::Pause => route.hold(seconds),
                Act::Resume => route.resume(seconds),
                Act::Finish => route.cancel(seconds),
                Act::Feed(scale) => {
                    route.scale(seconds, scale).map_err(|what| text.blame(at, what))?;
                }
                Act::To(_) => {
                    let what = "a path of several pieces keeps its end; a line or an arc may \
                                have another one";
                    return Err(text.blame(at, what));
                }
            }
        }
        let mut moving = [false; MOST];
        route.clone().for_each(|step| moving[step.axis] = true);
        let least = plan.motors.map(|motor| plan.rate.micros(motor.smallest_delay));
        let (path, steps) = Stream::new(route, plan.rate, lead, least);
        let motors = (0u8..).zip(steps).zip(moving.into_iter().zip(least));
        let motors = motors.filter(|(_, (moving, _))| *moving);
        Ok(motors
            .map(|((motor, steps), (_, least))| {
                Move::joined(motor, at.clone(), steps, path.clone(), least)
            })
            .collect())
    }
}
