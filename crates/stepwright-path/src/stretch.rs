//! A part of a route as it was passed: places, times and speeds.

/// A part of a route: a rise or a fall, a constant speed, a fall or a rise. Each of the three may take no time.
///
/// ```text
///   speeds   from 0 ╱▔▔▔▔ 1 ▔▔▔▔╲ to 2
///   times    0      1           2      3
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch<const N: usize> {
    /// Its beginning and its end, in units along the route from the start.
    pub way: [f64; 2],
    /// The times at which each of the three begins and the last one ends, in s after the start.
    pub times: [f64; 4],
    /// The speeds along the route at the beginning, in the middle and at the end, in units/s.
    pub speeds: [f64; 3],
    /// The length of each of the three, in units.
    pub ways: [f64; 3],
    /// The ordered speed, overrides included.
    pub feed: f64,
    /// Whether no speed was ordered: the route is as fast as the axes can be, and `feed` is that speed.
    pub rapid: bool,
    /// The place of each axis at both ends.
    pub places: [[f64; N]; 2],
    /// The units of each axis per unit of the route, at both ends.
    pub directions: [[f64; N]; 2],
}

impl<const N: usize> Stretch<N> {
    /// The time of its end, in s after the start.
    pub fn end(&self) -> f64 {
        self.times[3]
    }
}
