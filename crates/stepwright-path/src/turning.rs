//! The speed at which a curve may begin, end and change, within the jerk of each axis.
//!
//! At a speed v the acceleration of an axis is κ·v², with κ the change of its direction per unit of the path.
//! Within a time L/v it may change by what the jerk allows, and by what the jump hides: a u whose acceleration
//! changes evenly follows a step Δ of the acceleration, and is at most Δ²/8J away from the axis.
//!
//! ```text
//!   |Δκ|·v² ≤ √(4·S·J) + J·L/v
//! ```
//!
//! over windows of 0, 1, 2, 4 … nodes, each without a corner in between, as a corner has its jump. These bounds
//! are for speed. Each plan is checked against the law with [`Lens`](crate::lens::Lens).

use std::collections::VecDeque;

use crate::cell::Cell;
use crate::route::AxisPace;

/// The part of the jerk for speeding up where the route turns.
pub(crate) const TURN: f64 = 0.9;

/// The number of window lengths above 0. The longest window has 2 to the power of this less one nodes.
const WINDOWS: u32 = 6;

/// The curvature before and behind a node; `None` at a corner.
type Bends<const N: usize> = Option<[[f64; N]; 2]>;

fn bends<const N: usize>(cells: &VecDeque<Cell<N>>, n: usize) -> Bends<N> {
    let before = n.checked_sub(1).and_then(|n| cells.get(n));
    let (Some(before), Some(after)) = (before, cells.get(n)) else {
        let cell = cells.get(n).or(cells.back())?;
        if n == 0 && cell.turn.is_some() {
            // Within a curve of chords: the turning before is not known any more, but the state of the law
            // includes it.
            return None;
        }
        return Some([cell.shape.curvature(if n == 0 { cell.begin } else { cell.end }); 2]);
    };
    if let Some(turn) = after.turn {
        // Chords of a curve, or a chord and an arc.
        return Some([turn; 2]);
    }
    let both = [before.shape.curvature(before.end), after.shape.curvature(after.begin)];
    let turn: [f64; N] = std::array::from_fn(|axis| after.first[axis] - before.last[axis]);
    let straight = turn.iter().all(|turn| turn.abs() < SMOOTH);
    straight.then_some(both)
}

/// Whether there is a corner at a node between two cells.
pub(crate) fn is_corner<const N: usize>(cells: &VecDeque<Cell<N>>, n: usize) -> bool {
    bends(cells, n).is_none()
}

/// The last node up to which cells that follow don't change the bounds.
pub(crate) fn firm<const N: usize>(cells: &VecDeque<Cell<N>>) -> usize {
    let far = cells.len().saturating_sub(1 << (WINDOWS - 1));
    (far + 1..cells.len()).rev().find(|n| bends(cells, *n).is_none()).unwrap_or(far)
}

/// A smaller change of direction counts as none.
const SMOOTH: f64 = 1e-6;

/// Lowers the largest w at nodes and over cells to these bounds.
pub(crate) fn bound<const N: usize>(
    cells: &VecDeque<Cell<N>>,
    (caps, tops): (&mut [f64], &mut [f64]),
    axes: &[AxisPace; N],
    jerk: &[f64; N],
) {
    let slack: [f64; N] = std::array::from_fn(|n| (4.0 * axes[n].jump * jerk[n]).sqrt() * SLACK);
    let count = cells.len();
    let nodes: Vec<Bends<N>> = (0..=count).map(|n| bends(cells, n)).collect();
    let places: Vec<f64> = cells.iter().map(|cell| cell.begin).collect();
    let end = cells.back().map_or(0.0, |cell| cell.end);
    let place = |n: usize| places.get(n).copied().unwrap_or(end);
    // For each node, the last one before the next corner.
    let mut clear = vec![count; count + 1];
    for n in (0..count).rev() {
        clear[n] = if nodes[n + 1].is_none() { n } else { clear[n + 1] };
    }
    for n in 0..=count {
        let Some([before, after]) = nodes[n] else { continue };
        for window in 0..=WINDOWS {
            let to = if window == 0 { n } else { n + (1 << (window - 1)) };
            let Some(Some([there, _])) = nodes.get(to) else { break };
            if to > clear[n] {
                break;
            }
            let from = if window == 0 { before } else { after };
            let there = if window == 0 { after } else { *there };
            let length = place(to) - place(n);
            let mut w = caps[n..=to].iter().copied().fold(f64::INFINITY, f64::min);
            let known = w;
            for axis in 0..N {
                let change = (there[axis] - from[axis]).abs();
                w = w.min(most(w, change, slack[axis], jerk[axis] * length));
            }
            if w < known {
                caps[n..=to].iter_mut().for_each(|cap| *cap = cap.min(w));
                tops[n..to].iter_mut().for_each(|top| *top = top.min(w));
            }
        }
    }
}

/// The factor of that step that is used. It is more than all curves allow: the law decides.
const SLACK: f64 = 1.2;

/// The largest w up to this one with change·w ≤ slack + reach/√w.
fn most(w: f64, change: f64, slack: f64, reach: f64) -> f64 {
    if !w.is_finite() {
        if change == 0.0 {
            return w;
        }
        // The root is at most the larger of these.
        let high = (2.0 * slack / change).max((2.0 * reach / change).powf(2.0 / 3.0));
        return most(high, change, slack, reach);
    }
    let mut v = w.sqrt();
    if change * w * v <= slack * v + reach {
        return w;
    }
    // By Newton's method from above, where the function is convex.
    for _ in 0..20 {
        let off = change * v * v * v - slack * v - reach;
        let slope = 3.0 * change * v * v - slack;
        let next = v - off / slope;
        if next.is_nan() || next >= v * (1.0 - 1e-9) || next <= 0.0 {
            break;
        }
        v = next;
    }
    v * v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_speed_by_hand() {
        // No slack: v³ = 1000/8.
        assert!((most(1e4, 8.0, 0.0, 1_000.0) - 25.0).abs() < 1e-6);
        // No time: w = 400/4.
        assert!((most(1e4, 4.0, 400.0, 0.0) - 100.0).abs() < 1e-6);
        assert_eq!(most(50.0, 4.0, 400.0, 0.0), 50.0);
        assert!((most(f64::INFINITY, 4.0, 400.0, 0.0) - 100.0).abs() < 1e-6);
    }
}
