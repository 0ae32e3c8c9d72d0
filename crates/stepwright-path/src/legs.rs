//! The steps of an axis as runs: few enough for a small board to keep them all.
//!
//! ```text
//!   Steps    wait step wait step step step wait step step │ step step … wait
//!   delays   └─ d0 ──┘ └─ d1 ──┘ d2   d3   └─ d4 ──┘ d5   │ d6   d7      rest
//!   legs     └──────── run ───────────┘ └──── run ─────┘    └─ run ─┘    wait
//!                                            a turn ───►
//! ```
//!
//! A run's interval grows by the same from step to step, so that it covers up to some hundred
//! steps of a ramp or an arc.

use stepwright::Ticks;
use stepwright::compress::Compress;
use stepwright::run::Run;
use stepwright_cycle::{Leg, Pace};

/// Steps of a run, at most.
const WINDOW: usize = 2_048;
/// Ticks of a wait, at most: longer ones are several.
pub(crate) const WAIT: u64 = 1 << 30;

/// The steps of an axis to its path's end as [legs](Leg::Run), each within `error` ticks of its
/// time, and no interval shorter than `least` ticks unless the axis has such a one itself.
///
/// Changes of the path are to be made before: what is planned here stays.
pub fn legs(steps: impl IntoIterator<Item = Pace>, error: Ticks, least: Ticks) -> Vec<Leg> {
    let (mut delays, mut ways, mut waits) = (Vec::new(), Vec::new(), Vec::new());
    let mut waited = 0u64;
    for pace in steps {
        match pace {
            Pace::Wait { ticks } => waited += u64::from(ticks),
            Pace::Step { ticks, forward } => {
                let delay = std::mem::take(&mut waited) + u64::from(ticks);
                // So long a delay is one of its own.
                waits.push((delay / WAIT) as u32);
                delays.push((delay % WAIT) as Ticks);
                ways.push(forward);
            }
        }
    }
    let mut legs = Vec::new();
    let mut at = 0;
    for mut run in Compress::<_, WINDOW>::new(delays, error).with_least(least) {
        while run.count() > 0 {
            legs.extend((0..waits[at]).map(|_| wait(WAIT as Ticks)));
            // Up to the next turn, or wait.
            let ends = |n: &usize| ways[at + n] != ways[at] || waits[at + n] > 0;
            let all = usize::from(run.count());
            let count = (1..all).find(ends).unwrap_or(all) as u16;
            let (first, rest) = split(run, count);
            legs.push(Leg::Run { run: first, forward: ways[at] });
            at += usize::from(count);
            run = rest;
        }
    }
    while waited > 0 {
        let piece = waited.min(WAIT);
        legs.push(wait(piece as Ticks));
        waited -= piece;
    }
    legs
}

fn wait(ticks: Ticks) -> Leg {
    Leg::Run { run: Run::turn(ticks, true), forward: true }
}

/// The first `count` steps of a run, and the others.
fn split(run: Run, count: u16) -> (Run, Run) {
    let rest = run.interval().wrapping_add_signed(i64::from(run.add()) * i64::from(count));
    let first = Run::new(run.interval(), run.add(), count);
    (first, Run::new(rest, run.add(), run.count() - count))
}
