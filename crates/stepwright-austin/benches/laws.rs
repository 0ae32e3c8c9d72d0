//! Time per step of each law: `cargo bench -p stepwright-austin`. Figures are in
//! docs/laws.md.
//!
//! One move for all: 4,000 steps, 10,000 steps/s², 4,000 steps/s, 1 MHz; what
//! is measured is the sum of its delays, so time per element is time per step.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use stepwright::{Accel, Rate, Speed};
use stepwright_austin::{
    Austin, Carried, Divisor, Fixed, LinearFactor, Motion, Piecewise, PowerTerm, Ramp, Slope,
};

const STEPS: u32 = 4_000;

fn sum(delays: impl Iterator<Item = u32>) -> u64 {
    delays.map(u64::from).sum()
}

fn austin(c: &mut Criterion) {
    let mut group = c.benchmark_group("step by Austin's laws");
    group.throughput(Throughput::Elements(STEPS.into()));
    let (rate, top) = (Rate::MHZ, Speed::from_steps(4_000).unwrap());
    let accel = Accel::from_steps(10_000).unwrap();
    // c₀ of Eq 15, and c_min.
    let (c0, c_min) = (9_560, 250);
    group.bench_function("fixed", |b| {
        b.iter(|| sum(Fixed::new(STEPS, black_box(c0), c_min)));
    });
    group.bench_function("remainder carried", |b| {
        b.iter(|| sum(Carried::new(STEPS, black_box(c0), c_min)));
    });
    let law = Austin::new(rate, top, accel);
    group.bench_function("general", |b| {
        b.iter(|| sum(black_box(law).delays(STEPS).unwrap()));
    });
    let two = law.with_divisor(Divisor::TwoN);
    group.bench_function("general, c over 2n", |b| {
        b.iter(|| sum(black_box(two).delays(STEPS).unwrap()));
    });
    group.bench_function("ramp that changes", |b| {
        b.iter(|| {
            let mut ramp = Ramp::new(rate, black_box(accel), Default::default()).unwrap();
            let up = sum(ramp.by_ref().take(STEPS as usize / 2));
            ramp.set(Slope::Down(accel));
            up + sum(ramp)
        });
    });
    group.bench_function("motion that changes", |b| {
        b.iter(|| {
            let mut motion = Motion::new(rate, top, black_box(accel)).unwrap();
            motion.retarget(STEPS as i32);
            sum(motion)
        });
    });
    let law = LinearFactor::new(rate, top, accel);
    group.bench_function("linear factor", |b| {
        b.iter(|| sum(black_box(law).delays(STEPS).unwrap()));
    });
    for p in [2, 4] {
        let law = PowerTerm::new(rate, top, accel, p);
        group.bench_function(format!("power term {p}"), |b| {
            b.iter(|| sum(black_box(law).delays(STEPS).unwrap()));
        });
    }
    let law = Piecewise::new(rate, top, accel);
    group.bench_function("piecewise", |b| {
        b.iter(|| sum(black_box(law).delays(STEPS).unwrap()));
    });
    group.finish();
}

criterion_group!(benches, austin);
criterion_main!(benches);
