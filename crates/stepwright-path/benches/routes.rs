//! The time per piece of a route, and per step: `cargo bench -p stepwright-path`. Figures are in docs/paths.md.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use stepwright_path::{AxisPace, Route};

const AXIS: AxisPace =
    AxisPace { step: 0.0125, speed: 300.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };

/// A wave of this many chords of this length.
fn wave(count: u32, chord: f64) -> Vec<[f64; 2]> {
    let place = |n: u32| {
        let x = f64::from(n) * chord;
        [x, 10.0 * (x / 15.0).sin()]
    };
    (1..=count).map(place).collect()
}

fn plan(places: &[[f64; 2]]) -> f64 {
    let (mut route, mut time) = (Route::new([AXIS; 2]).unwrap(), 0.0);
    for to in places {
        route.line_to(*to, 100.0).unwrap();
        while let Some(stretch) = route.pass_over() {
            time = stretch.end();
        }
    }
    route.close();
    while let Some(stretch) = route.pass_over() {
        time = stretch.end();
    }
    time
}

fn steps(places: &[[f64; 2]]) -> usize {
    let (mut route, mut count) = (Route::new([AXIS; 2]).unwrap(), 0);
    for to in places {
        route.line_to(*to, 100.0).unwrap();
        count += route.by_ref().count();
    }
    route.close();
    count + route.by_ref().count()
}

fn routes(c: &mut Criterion) {
    let mut group = c.benchmark_group("piece");
    for chord in [0.05, 0.2, 1.0] {
        let places = wave(20_000, chord);
        group.throughput(Throughput::Elements(20_000));
        group.bench_function(format!("chords of {chord} mm, planned"), |b| {
            b.iter(|| plan(black_box(&places)));
        });
    }
    group.finish();
    let mut group = c.benchmark_group("step");
    let places = wave(20_000, 0.2);
    group.throughput(Throughput::Elements(steps(&places) as u64));
    group.bench_function("chords of 0.2 mm", |b| b.iter(|| steps(black_box(&places))));
    group.finish();
}

criterion_group!(benches, routes);
criterion_main!(benches);
