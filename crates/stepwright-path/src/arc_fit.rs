//! Replaces many chords by a line or an arc, within a tolerance: `G64 P` in LinuxCNC's programs.
//!
//! ```text
//!            ●───●───●                  the way leads from the first place to the last;
//!        ●  ╱ ╲╱   ╲╱ ╲  ●              between them no place, and no chord, is further
//!      A ╱                ╲ B           from it than the tolerance
//! ```
//!
//! Chords wait as long as one line or one arc from the first place to the last fits all of them. An arc from A
//! to B is given by its bulge b, the tangent of a quarter of its sweep. A larger bulge moves the whole arc
//! further from the line AB, to that side. Each place, and the middle of each chord, therefore allows an
//! interval of b, and the intersection of all intervals fits all of them. In units of half of AB, with A at −1
//! and B at 1, the height of an arc is about b·(1 − x²). From the b that this gives, the intervals are computed
//! again, with the exact distances. The middle of their intersection is checked against all places and chords
//! before it is used.
//!
//! Each line or arc begins and ends at places of the job. The speed of an arc of a few chords would be limited
//! by the turns at its ends. A few chords therefore stay chords, and are limited as the curve that they form.

use std::collections::VecDeque;

use crate::pace::{PACES, Unplannable};
use crate::route::Route;
use crate::shape::norm;

/// The most chords that one line or arc replaces: the cost of a chord grows with their number.
const MOST: usize = 64;

/// The fewest chords that an arc replaces. Fewer stay chords.
const FEW: usize = 4;

/// The largest bulge: a sweep of 87°.
const BULGE: f64 = 0.4;

/// The smallest bulge. A flatter arc is as good as a line.
const LEVEL: f64 = 1e-7;

/// Collects chords for a [`Route`], each with a tag of the caller, for example its line in the job.
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
    /// The beginning of the first chord, then the end of each chord.
    places: Vec<[f64; N]>,
    tags: VecDeque<T>,
    /// The line or arc from the first place to the last.
    found: Found,
    /// The chords and moves that the route has: the end of each along the route, and its tag.
    settled: VecDeque<(f64, T)>,
}

/// A line or an arc that fits all chords.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Found {
    #[default]
    Line,
    /// An arc of these two axes.
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
    /// An empty collection with a tolerance in the route's unit. With a tolerance of 0, all chords go to the
    /// route unchanged.
    ///
    /// # Errors
    /// [`Unplannable::Tolerance`] if the tolerance is neither 0 nor within [`PACES`].
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

    /// Sets the tolerance of the chords that follow. If it differs from the present tolerance, the chords that
    /// wait go to the route first.
    ///
    /// # Errors
    /// As for [`new`](ArcFit::new), with everything unchanged; as for [`settle`](ArcFit::settle).
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

    /// Adds a straight line to a place, at most at `feed` units/s. The line may wait.
    ///
    /// # Errors
    /// As for [`Route::line_to`]; the line is not added.
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

    /// Passes all chords that wait on to the route.
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
            // The route refuses an arc whose centre is too far away, or nearer than a step.
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

    /// Notes that the route has the line or the move with this tag, at its end.
    pub(crate) fn pass_on(&mut self, route: &Route<N>, tag: T) {
        self.settled.push_back((route.length(), tag));
    }

    /// The next chord or move that the route has, in the order in which they were added: its end along the
    /// route, and its tag.
    pub fn settled(&mut self) -> Option<(f64, T)> {
        self.settled.pop_front()
    }

    /// The number of chords that wait.
    pub fn waiting(&self) -> usize {
        self.tags.len()
    }

    /// Drops the chords that wait.
    pub fn clear(&mut self) {
        self.places.clear();
        self.tags.clear();
        self.found = Found::Line;
    }
}

/// The line or arc from the first of these places to the last, within the tolerance of all of them.
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

/// Whether a line fits, and each place is further along it than the place before.
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
        // In units of half of AB: A is at −1, B at 1.
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
        // An arc to the left of AB turns right.
        Some(Bow { centre, sweep: -4.0 * bulge.atan() })
    }

    /// The part of the arc up to a place.
    fn part(&self, first: [f64; 2], place: [f64; 2]) -> f64 {
        let [a, b] = [way(&self.centre, &first), way(&self.centre, &place)];
        (a[0] * b[1] - a[1] * b[0]).atan2(dot(&a, &b)) / self.sweep
    }
}

/// The middle of the interval of corrections to the bulge that all places and the middles of all chords allow.
/// `off` gives the present distance of a place from the arc.
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
    /// The height of its centre above the middle of AB.
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

    /// The distance of a place from the arc, positive above the arc: outside the circle if the bulge is
    /// positive, inside it if the bulge is negative.
    fn off(&self, [x, y]: [f64; 2]) -> f64 {
        (x.hypot(y - self.middle) - self.radius) * self.up
    }

    /// Whether all places and all chords are within the tolerance of the circle.
    fn fits(&self, places: &[[f64; 2]], tolerance: f64) -> bool {
        let near = |off: f64| off.abs() <= tolerance;
        let chord = |pair: &[[f64; 2]]| {
            // The foot is the point of the chord's line nearest to the centre.
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
