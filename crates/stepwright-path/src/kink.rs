//! The accelerations with which a corner is reached and left.
//!
//! At a corner the speed of each axis jumps, so the speed along the route need not change smoothly: the route
//! may brake up to the corner, and speed up from there on.
//!
//! ```text
//!   v  ╲     ╱        before  −α along the route, of an axis −α·t
//!       ╲   ╱         behind   β                            β·t′
//!        ╲_╱
//! ```
//!
//! If an axis jumps by all of S, its u is at the far end of the hidden range on both sides, and u' does not
//! jump. The jump of the axis's own acceleration at the corner is hidden if u leaves that end on one side,
//! again within S:
//!
//! ```text
//!   |β·t′ + α·t| ≤ √(2·S·J)
//! ```
//!
//! An axis that turns back accelerates in the same direction before and behind the corner, so any acceleration
//! is allowed. These bounds are for speed. Each plan is checked against the law with
//! [`Lens`](crate::lens::Lens).

use std::collections::VecDeque;

use crate::cell::Cell;
use crate::route::AxisPace;
use crate::turning::is_corner;

/// The part of that bound that is used: the motion before and behind a corner uses the jump, too.
const PART: f64 = 0.9;

/// The number of rounds over all axes: lowering one side may leave another axis more to hide.
const ROUNDS: usize = 2;

/// The largest deceleration before a node, and the largest acceleration behind it.
pub(crate) type Kink = [f64; 2];

/// The accelerations of each node, if it is passed at the w in `caps`.
pub(crate) fn kinks<const N: usize>(
    cells: &VecDeque<Cell<N>>,
    caps: &[f64],
    axes: &[AxisPace; N],
    jerk: &[f64; N],
) -> Vec<Kink> {
    let hidden = std::array::from_fn(|axis| (2.0 * axes[axis].jump * jerk[axis]).sqrt());
    let node = |n: usize| {
        let before = n.checked_sub(1).and_then(|n| cells.get(n));
        let (Some(before), Some(after)) = (before, cells.get(n)) else { return [0.0; 2] };
        if !is_corner(cells, n) {
            return [0.0; 2];
        }
        let most = [before, after].map(|cell| cell.slope(caps[n]));
        hide(most, [&before.last, &after.first], &hidden).map(|accel| PART * accel)
    };
    (0..caps.len()).map(node).collect()
}

/// Lowers these accelerations to what each axis can hide.
fn hide<const N: usize>(mut kink: Kink, ways: [&[f64; N]; 2], hidden: &[f64; N]) -> Kink {
    for axis in (0..ROUNDS).flat_map(|_| 0..N) {
        let parts = [0, 1].map(|side| kink[side] * ways[side][axis]);
        let sum = parts[0] + parts[1];
        let over = sum.abs() - hidden[axis];
        if over <= 0.0 {
            continue;
        }
        // The sides that add to the sum.
        let own = parts.map(|part| if part * sum > 0.0 { part.abs() } else { 0.0 });
        for side in [0, 1].into_iter().filter(|side| own[*side] > 0.0) {
            kink[side] *= (1.0 - over / (own[0] + own[1])).max(0.0);
        }
    }
    kink
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_axes_hide_by_hand() {
        let near = |kink: Kink, to: Kink| {
            assert!(kink.iter().zip(to).all(|(a, b)| (a - b).abs() < 1e-9), "{kink:?} {to:?}");
        };
        let most = [1_000.0, 800.0];
        // From X to Y: each has its own.
        near(hide(most, [&[1.0, 0.0], &[0.0, 1.0]], &[300.0, 200.0]), [300.0, 200.0]);
        // Back: only the difference counts.
        near(hide(most, [&[1.0, 0.0], &[-1.0, 0.0]], &[300.0, 200.0]), most);
        near(hide(most, [&[1.0, 0.0], &[-1.0, 0.0]], &[50.0, 200.0]), [850.0, 800.0]);
        // Ahead: both together.
        near(hide(most, [&[1.0, 0.0], &[0.8, 0.6]], &[164.0, 1e9]), [100.0, 80.0]);
    }
}
