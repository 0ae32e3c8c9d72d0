//! Time per step of each law, beside the crates `ramp-maker` and `stepgen`:
//! `cargo bench -p stepwright`. Figures and aims are in docs/benchmarks.md.
//!
//! One move for all: 4,000 steps, 10,000 steps/s², 4,000 steps/s, 1 MHz. The benchmark sums its
//! delays, so time per element is time per step.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ramp_maker::MotionProfile;
use stepwright::compress::Compress;
use stepwright::profile::{Cursor, Fit, RampSteps, Trapezoid, constant};
use stepwright::{Accel, Rate, Speed};

const STEPS: u32 = 4_000;

fn sum(delays: impl Iterator<Item = u32>) -> u64 {
    delays.map(u64::from).sum()
}

fn trapezoid() -> Trapezoid {
    let (top, accel) = (Speed::from_steps(4_000).unwrap(), Accel::from_steps(10_000).unwrap());
    Trapezoid::new(Rate::MHZ, Speed::ZERO, top, accel)
}

fn laws(c: &mut Criterion) {
    let mut group = c.benchmark_group("step");
    group.throughput(Throughput::Elements(STEPS.into()));
    let law = trapezoid();
    group.bench_function("trapezoid", |b| {
        b.iter(|| sum(black_box(law).delays(STEPS).unwrap()));
    });
    let v = |n| Speed::from_steps(n).unwrap();
    let ramp = RampSteps::new(Rate::MHZ, v(50), v(4_000), 800).unwrap();
    group.bench_function("ramp in steps", |b| {
        b.iter(|| sum(black_box(ramp).delays(STEPS).unwrap()));
    });
    group.bench_function("constant", |b| {
        b.iter(|| sum(constant::delays(Rate::MHZ, black_box(v(4_000)), STEPS).unwrap()));
    });
    group.bench_function("trapezoid as runs for a board", |b| {
        let fit = Fit::board(Rate::MHZ);
        b.iter(|| {
            let path = black_box(law).path(STEPS).unwrap();
            Cursor::new(path, fit).map(|run| run.duration()).sum::<u64>()
        });
    });
    group.bench_function("trapezoid compressed from its delays", |b| {
        b.iter(|| {
            let delays = black_box(law).delays(STEPS).unwrap();
            Compress::<_, 64>::new(delays, 1).map(|run| run.duration()).sum::<u64>()
        });
    });
    group.bench_function("peer: ramp-maker trapezoidal f32", |b| {
        b.iter(|| {
            let mut profile = ramp_maker::Trapezoidal::new(black_box(10_000.0f32));
            profile.enter_position_mode(4_000.0f32, STEPS);
            // Delays in seconds; ticks as a user would make them.
            sum(profile.delays().map(|seconds| (seconds * 1e6) as u32))
        });
    });
    group.bench_function("peer: stepgen", |b| {
        b.iter(|| {
            let mut profile = stepgen::Stepgen::new(1_000_000);
            profile.set_acceleration(black_box(10_000 << 8)).unwrap();
            profile.set_target_speed(4_000 << 8).unwrap();
            profile.set_target_step(STEPS).unwrap();
            sum(profile.map(|delay| (delay + 128) >> 8))
        });
    });
    group.finish();
}

/// A move with longer ramps: 40,000 steps, 40,000 steps/s², 20,000 steps/s.
fn long(c: &mut Criterion) {
    let mut group = c.benchmark_group("long step");
    group.throughput(Throughput::Elements(40_000));
    let (top, accel) = (Speed::from_steps(20_000).unwrap(), Accel::from_steps(40_000).unwrap());
    let law = Trapezoid::new(Rate::MHZ, Speed::ZERO, top, accel);
    group.bench_function("trapezoid", |b| {
        b.iter(|| sum(black_box(law).delays(40_000).unwrap()));
    });
    group.bench_function("peer: stepgen", |b| {
        b.iter(|| {
            let mut profile = stepgen::Stepgen::new(1_000_000);
            profile.set_acceleration(black_box(40_000 << 8)).unwrap();
            profile.set_target_speed(20_000 << 8).unwrap();
            profile.set_target_step(40_000).unwrap();
            sum(profile.map(|delay| (delay + 128) >> 8))
        });
    });
    group.finish();
}

criterion_group!(benches, laws, long);
criterion_main!(benches);
