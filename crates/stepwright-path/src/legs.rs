//! The steps of an axis as runs: few enough for a small board to keep them all.
//!
//! ```text
//!   Steps    wait step wait step step step wait step step │ step step … wait
//!   delays   └─ d0 ──┘ └─ d1 ──┘ d2   d3   └─ d4 ──┘ d5   │ d6   d7      rest
//!   legs     └──────── run ───────────┘ └──── run ─────┘    └─ run ─┘    wait
//!                                            a turn ───►
//! ```
//!
//! The interval of a run grows by the same amount from step to step, so a run covers up to some hundred steps
//! of a ramp or an arc.

use stepwright::Ticks;
use stepwright::compress::Compress;
use stepwright::run::Run;
use stepwright_cycle::{Leg, Pace};

/// The most steps of a run.
const WINDOW: usize = 2_048;
/// The longest wait, in ticks. Longer ones are divided.
pub(crate) const WAIT: u64 = 1 << 30;

/// Returns the steps of an axis up to the end of its path as [legs](Leg::Run). Each step is within `error`
/// ticks of its time. No interval is shorter than `least` ticks, unless the axis has such an interval itself.
///
/// Changes of the path must be made before: what is planned here stays.
pub fn legs(steps: impl IntoIterator<Item = Pace>, error: Ticks, least: Ticks) -> Vec<Leg> {
    let (mut delays, mut ways, mut waits) = (Vec::new(), Vec::new(), Vec::new());
    let mut waited = 0u64;
    for pace in steps {
        match pace {
            Pace::Wait { ticks } => waited += u64::from(ticks),
            Pace::Step { ticks, forward } => {
                let delay = std::mem::take(&mut waited) + u64::from(ticks);
                // A long delay is divided into waits of WAIT ticks and the rest.
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
            // Up to the next turn or wait.
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

/// The first `count` steps of a run, and the remaining steps.
fn split(run: Run, count: u16) -> (Run, Run) {
    let rest = run.interval().wrapping_add_signed(i64::from(run.add()) * i64::from(count));
    let first = Run::new(run.interval(), run.add(), count);
    (first, Run::new(rest, run.add(), run.count() - count))
}
