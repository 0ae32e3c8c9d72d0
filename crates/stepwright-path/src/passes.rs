//! The speed along cells: two passes in w = v², and what the law of speed asks for besides.
//!
//! ```text
//!   back   from rest at the end: as fast as can still be braked      ╱▔▔╲__╱▔▔╲
//!   on     from the speed there is: no faster than can be risen to   as fast as both allow
//! ```
//!
//! Where a pass back is at a limit of the path, and not on its way down to the end, what comes
//! behind the end changes nothing before that place: so far a plan is final ([`Passes::sure`]).
//!
//! Joints are bound one by one, and the law of speed is about every two moments. So what comes
//! out is tried against it ([`Bucket`]), and where it fails, the joints between both moments are
//! passed slower, at last at rest. From rest to rest over each cell nothing exceeds anything, so
//! this ends.

use std::collections::VecDeque;

use crate::bucket::Bucket;
use crate::cell::Cell;
use crate::route::AxisPace;

/// Rounds in which joints are passed slower, before they are at rest.
const SLOWER: usize = 40;

/// Of w, in each.
const BY: f64 = 0.9;

/// Rounds in which joints are at rest, before the plan is given up.
const AT_REST: usize = 100;

/// The speed at each node: where a cell begins, and at the end of the last one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Passes {
    pub w: VecDeque<f64>,
    /// Cells from the first on whose speed is final.
    pub sure: usize,
}

impl Passes {
    /// Over all cells, from the speed that there is to rest. `None`, and nothing changes, if the
    /// law can't be kept.
    pub fn plan<const N: usize>(
        &mut self,
        cells: &VecDeque<Cell<N>>,
        bucket: &Bucket<N>,
        axes: &[AxisPace; N],
        strict: bool,
    ) -> Option<()> {
        let count = cells.len();
        let first = self.w.front().copied().unwrap_or(0.0);
        // At each node: the joint, and the tops of both sides.
        let mut caps = vec![0.0; count + 1];
        for n in 1..count {
            caps[n] = cells[n].cap.min(cells[n - 1].top).min(cells[n].top);
        }
        let mut sure = 0;
        for round in 0.. {
            let mut back = caps.clone();
            for n in (1..count).rev() {
                // What rises on the way back.
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
                // From beyond a speed that has been made less it can only fall.
                at = back.min(cell.rise(at)).max(cell.fall(at));
                w.push_back(at);
            }
            // By the law, whatever is rounded.
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

/// The nodes, up to the last that has a speed, at which the law is broken, each behind the one that it is broken
/// with. From one on it is looked at as if nothing had been before.
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
