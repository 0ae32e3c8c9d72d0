//! A part of a route as it was passed: where, when, how fast.

/// A part of a route: a rise or a fall, a constant speed, a fall or a rise. Each of the three may
/// last no time.
///
/// ```text
///   speeds   from 0 ╱▔▔▔▔ 1 ▔▔▔▔╲ to 2
///   times    0      1           2      3
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch<const N: usize> {
    /// Where it begins and ends, in units along the route from its start.
    pub way: [f64; 2],
    /// When each of the three begins, and the last one ends, in s after the start.
    pub times: [f64; 4],
    /// Units/s along the route: at the beginning, in the middle, at the end.
    pub speeds: [f64; 3],
    /// How far each of the three leads.
    pub ways: [f64; 3],
    /// The ordered speed, overrides included.
    pub feed: f64,
    /// Whether none was ordered: it goes as fast as the axes can, and `feed` is that speed.
    pub rapid: bool,
    /// Each axis at both ends.
    pub places: [[f64; N]; 2],
    /// Units that each axis goes in a unit of the route, at both ends.
    pub directions: [[f64; N]; 2],
}

impl<const N: usize> Stretch<N> {
    /// When it ends, in s after the start.
    pub fn end(&self) -> f64 {
        self.times[3]
    }
}
