//! The fitter, judged from the edges alone: records are played, and each step is held against its time.

use proptest::prelude::*;
use stepwright::entry::Wiring;
use stepwright_stream::fit::{EntryFitter, FitTerms, Moment, What};

fn terms(micros: u32) -> FitTerms {
    FitTerms {
        tolerance: micros * 16 * 256,
        longest: 128_000 * 256,
        shortest: 72,
        patience: 256_000 * 256,
    }
}

/// Edges of what the fitter makes: when, and whether a step; and how many records.
fn edges(moments: &[Moment], terms: FitTerms) -> (Vec<(f64, bool)>, usize) {
    let (mut fitter, mut at, mut edges, mut records) = (EntryFitter::new(terms), 0, vec![], 0);
    let mut now = 0u64;
    while let Some((record, played)) = fitter.next(&moments[at..]) {
        at += played;
        records += 1;
        assert!(record.is_playable(terms.shortest), "{record:?}");
        // As a chip plays it: 24 bits, 8 of them behind the point.
        for (n, (pins, events, wait)) in record.entry(Wiring::new(1, 2)).groups().enumerate() {
            for event in 0..events {
                let waits = record.act.steps() <= 1 && (n > 0 || event > 0);
                if pins != 0 && !waits {
                    edges.push((now as f64 / 256.0, pins == 1));
                }
                now += u64::from(wait >> 8);
            }
        }
        assert_eq!(now, fitter.played());
    }
    assert_eq!(at, moments.len() - 1, "all but the end");
    (edges, records)
}

/// The largest distance of an edge from its moment, in µs.
fn worst(moments: &[Moment], edges: &[(f64, bool)]) -> f64 {
    let wanted: Vec<_> =
        moments.iter().filter(|m| matches!(m.what, What::Step | What::Turn)).collect();
    assert_eq!(wanted.len(), edges.len());
    let apart = wanted.iter().zip(edges).map(|(moment, edge)| {
        assert_eq!(moment.what == What::Step, edge.1);
        (edge.0 - moment.at as f64 / 256.0).abs() / 16.0
    });
    apart.fold(0.0, f64::max)
}

/// Moments of steps at these intervals in ticks, negative ones behind a turn; the ends left calm.
fn moments(intervals: &[f64]) -> Vec<Moment> {
    let mut at = 3_000.0;
    let mut all = vec![Moment { at: 0, what: What::Nothing }];
    let mut push = |at: f64, what| all.push(Moment { at: (at * 256.0) as u64, what });
    push(at, What::Step);
    for interval in intervals {
        if *interval < 0.0 {
            push(at + 1_300.0, What::Turn);
            at += interval.abs() + 2_600.0;
        } else {
            at += interval;
        }
        push(at, What::Step);
    }
    push(at + 2_400.0, What::End);
    all
}

#[test]
fn constant_speed_is_few_records() {
    let intervals = vec![80.0; 20_000];
    let all = moments(&intervals);
    let (edges, records) = edges(&all, terms(1));
    assert!(worst(&all, &edges) <= 1.0);
    // 8 ms each.
    assert!(records < 16, "{records}");
}

#[test]
fn a_long_wait_is_exact() {
    for wait in [40_000.0, 1e6, 5e6, 3e7, 1.3e9] {
        let all = moments(&[1_000.0, wait, 900.0, -wait, 900.0]);
        let (edges, _) = edges(&all, terms(1));
        assert!(worst(&all, &edges) <= 1.0, "{wait}");
    }
}

proptest! {
    /// Ramps, curves and turns: a step is never beyond the tolerance.
    #[test]
    fn steps_keep_their_times(
        pieces in prop::collection::vec((90.0f64..60_000.0, -0.02f64..0.02, 1usize..400, any::<bool>()), 1..12),
        micros in prop::sample::select(vec![1u32, 5, 10, 25]),
    ) {
        let mut intervals = Vec::new();
        for (first, bend, count, turn) in pieces {
            let mut c: f64 = first;
            for n in 0..count {
                c = (c * (1.0 + bend * (n as f64 / 40.0).sin())).clamp(90.0, 2e6);
                intervals.push(if turn && n == 0 { -c } else { c });
            }
        }
        let all = moments(&intervals);
        let (edges, records) = edges(&all, terms(micros));
        let worst = worst(&all, &edges);
        prop_assert!(worst <= f64::from(micros) + 0.01, "{worst} of {micros}");
        prop_assert!(records <= all.len() * 2);
    }

    /// Noise beyond the tolerance: each step is on time all the same, one by one.
    #[test]
    fn noise_is_followed(noise in prop::collection::vec(0.0f64..3_000.0, 2..200)) {
        let intervals: Vec<f64> = noise.iter().map(|more| 200.0 + more).collect();
        let all = moments(&intervals);
        let (edges, _) = edges(&all, terms(1));
        prop_assert!(worst(&all, &edges) <= 1.01);
    }
}

/// The looser, the fewer: as long as time does not end them.
#[test]
fn tolerance_saves_records() {
    let intervals: Vec<f64> =
        (0..20_000).map(|n| 2_000.0 + 900.0 * (f64::from(n) / 300.0).sin()).collect();
    let all = moments(&intervals);
    let counts = [1, 10].map(|micros| edges(&all, terms(micros)).1);
    assert!(counts[1] < counts[0], "{counts:?}");
}
