//! The speed along cells: two passes in w = v², and the check against the law of speed.
//!
//! ```text
//!   back   from rest at the end: as fast as can still be braked      ╱▔▔╲__╱▔▔╲
//!   on     from the speed there is: no faster than can be risen to   as fast as both allow
//! ```
//!
//! Where the backward pass is at a limit of the path, not on its way down to the end, pieces after the end
//! change nothing before that place. The plan is final up to there ([`Passes::sure`]).
//!
//! Joints are limited one by one, but the law of speed is about any two moments. The result is therefore
//! checked against the law ([`Bucket`]). Where it fails, the joints between both moments are passed slower, in
//! the end at rest. A motion from rest to rest over each cell exceeds no limit, so this ends.

use std::collections::VecDeque;

use crate::bucket::Bucket;
use crate::cell::Cell;
use crate::route::AxisPace;

/// The number of rounds in which joints are passed slower, before they are passed at rest.
const SLOWER: usize = 40;

/// The factor of w in each of these rounds.
const BY: f64 = 0.9;

/// The number of rounds in which joints are passed at rest, before the plan is given up.
const AT_REST: usize = 100;

/// The speed at each node: at the beginning of each cell, and at the end of the last one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Passes {
    pub w: VecDeque<f64>,
    /// The number of cells from the first on whose speed is final.
    pub sure: usize,
}

impl Passes {
    /// Plans all cells, from the present speed to rest. Returns `None`, and changes nothing, if the law cannot
    /// be kept.
    pub fn plan<const N: usize>(
        &mut self,
        cells: &VecDeque<Cell<N>>,
        bucket: &Bucket<N>,
        axes: &[AxisPace; N],
        strict: bool,
    ) -> Option<()> {
        let count = cells.len();
        let first = self.w.front().copied().unwrap_or(0.0);
        // The limits of each node: of its joint, and of the cells on both sides.
        let mut caps = vec![0.0; count + 1];
        for n in 1..count {
            caps[n] = cells[n].cap.min(cells[n - 1].top).min(cells[n].top);
        }
        let mut sure = 0;
        for round in 0.. {
            let mut back = caps.clone();
            for n in (1..count).rev() {
                // The rise over the cell, seen backwards.
                let rise = cells[n].back(back[n + 1]);
                if rise < back[n] {
                    back[n] = rise;
                } else if round == 0 {
                    sure = sure.max(n);
                }
            }
            let mut w = VecDeque::with_capacity(count + 1);
            let mut at = first;
            w.push_back(at);
            for (cell, back) in cells.iter().zip(&back[1..]) {
                // From above a limit that was lowered, the speed can only fall.
                at = back.min(cell.rise(at)).max(cell.fall(at));
                w.push_back(at);
            }
            // Exactly at rest, in spite of rounding.
            w[count] = 0.0;
            let broken = if strict { broken(cells, &w, *bucket, axes) } else { Vec::new() };
            if broken.is_empty() {
                (self.w, self.sure) = (w, sure);
                return Some(());
            }
            if round > SLOWER + AT_REST {
                return None;
            }
            let mut slower = false;
            for (from, to) in broken {
                for n in from.max(1)..=to.min(count - 1) {
                    let cap = if round < SLOWER { BY * w[n] } else { 0.0 };
                    slower |= cap < caps[n];
                    caps[n] = cap.min(caps[n]);
                }
            }
            if !slower {
                return None;
            }
        }
        None
    }
}

/// The nodes at which the law is broken, each after the node with which it is broken, up to the last node that
/// has a speed. After a broken node, the check begins again as if nothing had been before it.
pub(crate) fn broken<const N: usize>(
    cells: &VecDeque<Cell<N>>,
    w: &VecDeque<f64>,
    bucket: Bucket<N>,
    axes: &[AxisPace; N],
) -> Vec<(usize, usize)> {
    let mut bucket = bucket.begin();
    let mut broken = Vec::new();
    let mut meet = |bucket: &mut Bucket<N>, v: f64, direction: &[f64; N], n: usize| {
        if let Some(with) = bucket.meet(v, direction, n, axes) {
            broken.push((with, n));
            *bucket = Bucket::only(v, direction, n);
        }
    };
    for (n, cell) in cells.iter().enumerate().take(w.len() - 1) {
        meet(&mut bucket, w[n].sqrt(), &cell.first, n);
        bucket.wait(cell.trip(w[n], w[n + 1]).duration(), axes);
        meet(&mut bucket, w[n + 1].sqrt(), &cell.last, n + 1);
    }
    broken
}
