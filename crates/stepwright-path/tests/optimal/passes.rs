//! The time-optimal speed without a limit of the jerk, by two passes.
//!
//! ```text
//!   back   the largest w at each node from which the next node's can be kept
//!   on     from rest, as much acceleration as each cell allows
//! ```
//!
//! With constant acceleration over each cell, no speed that keeps the limits at both ends of each cell is
//! faster anywhere. An arc may use what turning leaves on the side where turning helps. A planner that does not
//! use that is slower.

use stepwright_path::AxisPace;

use super::{Cell, Grid};

/// The range of the acceleration over a cell from a w to at most another w; empty if the first is above the
/// second.
fn room<const N: usize>(cell: &Cell<N>, axes: &[AxisPace; N], w: f64, next: f64) -> (f64, f64) {
    let way = 2.0 * cell.length;
    let (mut least, mut most) = (-w / way, (next - w) / way);
    for (n, end) in cell.ends.iter().enumerate() {
        for (axis, pace) in axes.iter().enumerate() {
            let (t, k) = (end.t[axis], end.k[axis]);
            // t·a + k·w there, as c·a + d.
            let (c, d) = (t + if n == 0 { 0.0 } else { way * k }, k * w);
            if c.abs() > 1e-12 {
                let [a, b] = [(-pace.accel - d) / c, (pace.accel - d) / c];
                (least, most) = (least.max(a.min(b)), most.min(a.max(b)));
            } else if d.abs() > pace.accel {
                return (1.0, 0.0);
            }
        }
    }
    (least, most)
}

/// The fastest w at each node.
pub fn fastest<const N: usize>(grid: &Grid<N>, axes: &[AxisPace; N]) -> Vec<f64> {
    let mut most = grid.caps.clone();
    for n in (0..grid.cells.len()).rev() {
        let keeps = |w: f64| {
            let (a, b) = room(&grid.cells[n], axes, w, most[n + 1]);
            a <= b
        };
        let mut high = most[n];
        if !keeps(high) {
            let mut low = 0.0;
            for _ in 0..60 {
                let middle = (low + high) / 2.0;
                if keeps(middle) { low = middle } else { high = middle }
            }
            high = low;
        }
        most[n] = high;
    }
    let mut w = vec![0.0];
    for (n, cell) in grid.cells.iter().enumerate() {
        let (_, a) = room(cell, axes, w[n], most[n + 1]);
        w.push((w[n] + 2.0 * cell.length * a).clamp(0.0, most[n + 1]));
    }
    w
}
