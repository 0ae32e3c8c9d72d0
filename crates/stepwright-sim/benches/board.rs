//! Edges per second of the virtual board: `cargo bench -p stepwright-sim`.
//! Figures and aims are in docs/benchmarks.md.
//!
//! A move of 100,000 steps with ramps, planned and played by the real engine; each step has two edges, which go
//! to a recorder.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use stepwright::profile::Ramp;
use stepwright::{Accel, Axis, Order, Speed, Travel};
use stepwright_sim::{Description, Edge, Queues, Recorder, VirtualBoard};

const STEPS: i32 = 100_000;

/// Counts the edges, so that none is optimised away.
#[derive(Default)]
struct Counter(u64);

impl Recorder for Counter {
    fn edge(&mut self, edge: Edge) {
        self.0 += u64::from(black_box(edge).level) + 1;
    }
}

fn play(top: u32, axes: usize) -> u64 {
    let mut queues = Queues::default();
    let mut board: VirtualBoard<u16, Counter> =
        VirtualBoard::new(&mut queues, Description::uno(), Counter::default());
    let order = Order {
        start: Speed::ZERO,
        top: Speed::from_steps(top).unwrap(),
        up: Ramp::Accel(Accel::from_steps(40_000).unwrap()),
        down: Ramp::Accel(Accel::from_steps(40_000).unwrap()),
        jerk: None,
        travel: Travel::By(STEPS),
    };
    let orders = Axis::all().take(axes).map(|axis| (axis, order));
    board.motors().start(orders).unwrap();
    board.run_to_rest();
    board.recorder().0
}

fn edges(c: &mut Criterion) {
    let mut group = c.benchmark_group("edges");
    group.sample_size(20);
    for (axes, top) in [(1, 100_000), (2, 50_000), (3, 30_000)] {
        group.throughput(Throughput::Elements(2 * STEPS as u64 * axes as u64));
        group.bench_function(format!("{axes} axes"), |b| b.iter(|| play(black_box(top), axes)));
    }
    group.finish();
}

criterion_group!(benches, edges);
criterion_main!(benches);
