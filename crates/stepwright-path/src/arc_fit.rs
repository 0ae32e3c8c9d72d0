//! A line or an arc in place of many chords, within a tolerance: `G64 P` of LinuxCNC's programs.
//!
//! ```text
//!            ●───●───●                  the way leads from the first place to the last;
//!        ●  ╱ ╲╱   ╲╱ ╲  ●              between them no place, and no chord, is further
//!      A ╱                ╲ B           from it than the tolerance
//! ```
//!
//! Chords wait while one line or one arc from the first place to the last fits all of them. Of the arcs from
//! A to B each is known by its bulge b, the tangent of a quarter of its sweep: the greater it is, the further
//! is it from the line on that side, everywhere. So each place, and the middle of each chord, allows b within
//! an interval, and what all allow is their intersection. In units of half of AB, with A at −1 and B at 1, an
//! arc is about b·(1 − x²) high; from that b the intervals are found again, with the true distances. The
//! middle of them is tried on all places and chords before it is taken.
//!
//! What is made begins and ends at places of the job. An arc of a few chords would be bound by what its ends turn:
//! they stay as they are, and are bound as their curve.

use std::collections::VecDeque;

use crate::pace::{PACES, Unplannable};
use crate::route::Route;
use crate::shape::norm;

/// Chords that one piece is made of, at most: what a chord costs grows with it.
const MOST: usize = 64;

/// Fewer chords than that are no arc: they stay as they are.
const FEW: usize = 4;

/// The greatest bulge: a sweep of 87°.
const BULGE: f64 = 0.4;

/// The least bulge: with less it is a line.
const LEVEL: f64 = 1e-7;

/// Chords on their way to a [`Route`], each with something of the caller's, as its line in the job.
///
/// ```
/// use std::f64::consts::TAU;
/// use stepwright_path::{AxisPace, ArcFit, Route};
/// let axis = AxisPace { step: 0.0125, speed: 200.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };
/// // A circle of 20 mm in chords of 0.1 mm, from places with two digits.
/// let place = |n: u32| (TAU * f64::from(n) / 1_257.0).sin_cos();
/// let round = |mm: f64| (mm * 100.0).round() / 100.0;
/// let mut times = Vec::new();
/// for tolerance in [0.0, 0.01] {
///     let mut route = Route::new([axis; 2])?;
///     let mut fit = ArcFit::new(tolerance)?;
///     for n in 0..=1_257 {
///         let (y, x) = place(n);
///         fit.line_to(&mut route, [round(20.0 * x - 20.0), round(20.0 * y)], 100.0, n)?;
///     }
///     fit.settle(&mut route)?;
///     route.close();
///     times.push(route.by_ref().last().unwrap().time);
///     assert_eq!(std::iter::from_fn(|| fit.settled()).last(), Some((route.length(), 1_257)));
/// }
/// assert!(times[1] < 0.5 * times[0], "{times:?}");
/// # Ok::<(), stepwright_path::Unplannable>(())
/// ```
#[derive(Clone, Debug)]
pub struct ArcFit<T, const N: usize> {
    tolerance: f64,
    feed: f64,
    /// Where the first chord begins, and where each ends.
    places: Vec<[f64; N]>,
    tags: VecDeque<T>,
    /// What leads from the first place to the last.
    found: Found,
    /// What the route has got: where each ends along it.
    settled: VecDeque<(f64, T)>,
}

/// What fits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Found {
    #[default]
    Line,
    /// Of two axes.
    Arc([usize; 2], Bow),
}

/// An arc from one place to another.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bow {
    centre: [f64; 2],
    /// In radians, positive from the first axis towards the second.
    sweep: f64,
}

impl<T, const N: usize> ArcFit<T, N> {
    /// With a tolerance in the route's unit; with 0 all goes on as it is.
    ///
    /// # Errors
    /// [`Unplannable::Tolerance`] if it is not 0, and beyond [`PACES`].
    pub fn new(tolerance: f64) -> Result<ArcFit<T, N>, Unplannable> {
        if tolerance != 0.0 && !PACES.contains(&tolerance) {
            return Err(Unplannable::Tolerance);
        }
        Ok(ArcFit {
            tolerance,
            feed: 0.0,
            places: Vec::new(),
            tags: VecDeque::new(),
            found: Found::Line,
            settled: VecDeque::new(),
        })
    }

    /// This tolerance from here on. What waits goes to the route if it is another one.
    ///
    /// # Errors
    /// As for [`new`](ArcFit::new), and all stays as it was; as for [`settle`](ArcFit::settle).
    pub fn set_tolerance(
        &mut self,
        route: &mut Route<N>,
        tolerance: f64,
    ) -> Result<(), Unplannable> {
        ArcFit::<T, N>::new(tolerance)?;
        if tolerance != self.tolerance {
            self.settle(route)?;
            self.tolerance = tolerance;
        }
        Ok(())
    }

    /// Adds a straight line to a place, at most at `feed` units/s. It may wait.
    ///
    /// # Errors
    /// As for [`Route::line_to`], and it was not added.
    pub fn line_to(
        &mut self,
        route: &mut Route<N>,
        to: [f64; N],
        feed: f64,
        tag: T,
    ) -> Result<(), Unplannable> {
        route.check(&to)?;
        if !PACES.contains(&feed) {
            return Err(Unplannable::Speed);
        }
        if feed != self.feed || self.tags.len() >= MOST {
            self.settle(route)?;
            self.feed = feed;
        }
        let from = self.places.last().copied().unwrap_or(route.end());
        if self.tolerance == 0.0 || to == from {
            self.settle(route)?;
            route.line_to(to, feed)?;
            self.pass_on(route, tag);
            return Ok(());
        }
        if self.places.is_empty() {
            self.places.push(from);
        }
        self.places.push(to);
        if let Some(found) = fitting(&self.places, self.tolerance) {
            self.found = found;
        } else {
            self.places.pop();
            self.settle(route)?;
            (self.feed, self.places) = (feed, vec![from, to]);
        }
        self.tags.push_back(tag);
        Ok(())
    }

    /// The route gets all that waits.
    ///
    /// # Errors
    /// As for [`Route::line_to`].
    pub fn settle(&mut self, route: &mut Route<N>) -> Result<(), Unplannable> {
        let (Some(&first), Some(&last)) = (self.places.first(), self.places.last()) else {
            return Ok(());
        };
        let begin = route.length();
        let whole = match self.found {
            Found::Line => route.line_to(last, self.feed).map(|()| true)?,
            // An arc is refused where its centre is too far off, or nearer than a step.
            Found::Arc(axes, Bow { centre, sweep }) => {
                self.tags.len() >= FEW
                    && route.arc(axes, centre, sweep, [0.0; N], self.feed).is_ok()
            }
        };
        let (long, all) = (route.length() - begin, way(&first, &last));
        let part = |place: &[f64; N]| match self.found {
            Found::Line => dot(&way(&first, place), &all) / square(&all),
            Found::Arc(axes, bow) => bow.part(flat(&first, axes), flat(place, axes)),
        };
        let mut end = begin;
        for place in &self.places[1..] {
            if !whole {
                route.line_to(*place, self.feed)?;
            }
            let Some(tag) = self.tags.pop_front() else { break };
            let within = whole && !self.tags.is_empty();
            let there = if within { begin + long * part(place) } else { route.length() };
            end = there.min(route.length()).max(end);
            self.settled.push_back((end, tag));
        }
        self.places.clear();
        self.found = Found::Line;
        Ok(())
    }

    /// The route has got it.
    pub(crate) fn pass_on(&mut self, route: &Route<N>, tag: T) {
        self.settled.push_back((route.length(), tag));
    }

    /// The next one that the route has got, in their order: where it ends along the route.
    pub fn settled(&mut self) -> Option<(f64, T)> {
        self.settled.pop_front()
    }

    /// How many wait.
    pub fn waiting(&self) -> usize {
        self.tags.len()
    }

    /// What waits is not made.
    pub fn clear(&mut self) {
        self.places.clear();
        self.tags.clear();
        self.found = Found::Line;
    }
}

/// What leads from the first of these places to the last, within the tolerance of all.
fn fitting<const N: usize>(places: &[[f64; N]], tolerance: f64) -> Option<Found> {
    if is_line(places, tolerance) {
        return Some(Found::Line);
    }
    let first = places.first()?;
    let moves = |axis: &usize| places.iter().any(|place| place[*axis] != first[*axis]);
    let mut moving = (0..N).filter(moves);
    let axes = [moving.next()?, moving.next()?];
    if moving.next().is_some() {
        return None;
    }
    let places: Vec<_> = places.iter().map(|place| flat(place, axes)).collect();
    Some(Found::Arc(axes, Bow::fitting(&places, tolerance)?))
}

/// Whether a line does, all the way ahead.
fn is_line<const N: usize>(places: &[[f64; N]], tolerance: f64) -> bool {
    let [first, between @ .., last] = places else { return false };
    let all = way(first, last);
    let long = norm(&all);
    let mut before = 0.0;
    let ahead = between.iter().all(|place| {
        let way = way(first, place);
        let along = dot(&way, &all) / long;
        let off = (square(&way) - along * along).max(0.0).sqrt();
        std::mem::replace(&mut before, along) < along && off <= tolerance
    });
    ahead && before < long
}

impl Bow {
    fn fitting(places: &[[f64; 2]], tolerance: f64) -> Option<Bow> {
        let (&first, &last) = (places.first()?, places.last()?);
        let all = way(&first, &last);
        let half = norm(&all) / 2.0;
        if half == 0.0 {
            return None;
        }
        let tolerance = tolerance / half;
        // Half of AB is 1, A at −1 and B at 1.
        let [ahead, left] = [[all[0], all[1]], [-all[1], all[0]]];
        let scale = 2.0 * half * half;
        let place = |place: &[f64; 2]| {
            let way = way(&first, place);
            [dot(&way, &ahead) / scale - 1.0, dot(&way, &left) / scale]
        };
        let places: Vec<_> = places.iter().map(place).collect();
        if !places.windows(2).all(|pair| pair[0][0] < pair[1][0]) {
            return None;
        }
        let flat = allowed(&places, |[_, y]| y, tolerance)?;
        let round = Circle::new(flat)?;
        let bulge = flat + allowed(&places, |place| round.off(place), tolerance)?;
        let round = Circle::new(bulge)?;
        if !round.fits(&places, tolerance) {
            return None;
        }
        let middle = [0, 1].map(|n| (first[n] + last[n]) / 2.0);
        let down = round.middle / 2.0;
        let centre = [0, 1].map(|n| middle[n] + down * left[n]);
        // On the left of the way it turns right.
        Some(Bow { centre, sweep: -4.0 * bulge.atan() })
    }

    /// The part of it up to a place.
    fn part(&self, first: [f64; 2], place: [f64; 2]) -> f64 {
        let [a, b] = [way(&self.centre, &first), way(&self.centre, &place)];
        (a[0] * b[1] - a[1] * b[0]).atan2(dot(&a, &b)) / self.sweep
    }
}

/// The middle of what all places and the middles of all chords allow to be added to the bulge, by how far
/// they are from it now.
fn allowed(places: &[[f64; 2]], off: impl Fn([f64; 2]) -> f64, tolerance: f64) -> Option<f64> {
    let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut look = |place: [f64; 2]| {
        let rise = 1.0 - place[0] * place[0];
        let off = off(place);
        least = least.max((off - tolerance) / rise);
        most = most.min((off + tolerance) / rise);
    };
    for (n, pair) in places.windows(2).enumerate() {
        if n > 0 {
            look(pair[0]);
        }
        look([0, 1].map(|axis| (pair[0][axis] + pair[1][axis]) / 2.0));
    }
    (least <= most).then_some((least + most) / 2.0)
}

/// A circle through A and B.
struct Circle {
    /// Its centre is that far above the middle of AB.
    middle: f64,
    radius: f64,
    up: f64,
}

impl Circle {
    fn new(bulge: f64) -> Option<Circle> {
        if !(LEVEL..=BULGE).contains(&bulge.abs()) {
            return None;
        }
        let middle = (bulge * bulge - 1.0) / (2.0 * bulge);
        let radius = (bulge * bulge + 1.0) / (2.0 * bulge.abs());
        Some(Circle { middle, radius, up: bulge.signum() })
    }

    /// How far a place is above its upper half, or, if it is below, below its lower half.
    fn off(&self, [x, y]: [f64; 2]) -> f64 {
        (x.hypot(y - self.middle) - self.radius) * self.up
    }

    /// Whether all places and all chords are within the tolerance.
    fn fits(&self, places: &[[f64; 2]], tolerance: f64) -> bool {
        let near = |off: f64| off.abs() <= tolerance;
        let chord = |pair: &[[f64; 2]]| {
            // Nearest to the centre.
            let (a, all) = (way(&[0.0, self.middle], &pair[0]), way(&pair[0], &pair[1]));
            let at = -dot(&a, &all) / square(&all);
            let foot = [a[0] + at * all[0], a[1] + at * all[1]];
            !(0.0..=1.0).contains(&at) || near(norm(&foot) - self.radius)
        };
        places.iter().all(|place| near(self.off(*place))) && places.windows(2).all(chord)
    }
}

fn flat<const N: usize>(place: &[f64; N], axes: [usize; 2]) -> [f64; 2] {
    axes.map(|axis| place[axis])
}

fn way<const N: usize>(from: &[f64; N], to: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|n| to[n] - from[n])
}

fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn square<const N: usize>(way: &[f64; N]) -> f64 {
    dot(way, way)
}
