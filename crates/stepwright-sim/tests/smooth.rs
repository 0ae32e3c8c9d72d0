//! How even the Uno's ramps are, by the deadlines of its planner: the figures by which other systems were
//! measured.

use crate::edges::steps_of;
use stepwright::profile::Ramp;
use stepwright::{Accel, Axis, Order, Speed, Travel};
use stepwright_oracle::IdealTrapezoid;
use stepwright_sim::{Description, Edge, Queues, VirtualBoard};

/// The times of all pulses of a travel from rest to rest, in ticks at 16 MHz.
fn pulses(steps: i32, accel: u32, top: u32) -> Vec<u64> {
    let mut queues = Queues::default();
    let mut board: VirtualBoard<u16, Vec<Edge>> =
        VirtualBoard::new(&mut queues, Description::uno(), Vec::new());
    let ramp = Ramp::Accel(Accel::from_steps(accel).unwrap());
    let order = Order {
        start: Speed::ZERO,
        top: Speed::from_steps(top).unwrap(),
        up: ramp,
        down: ramp,
        jerk: None,
        travel: Travel::By(steps),
    };
    board.motors().start([(Axis::X, order)]).unwrap();
    board.run_to_rest();
    steps_of(board.recorder(), 0).iter().map(|s| s.0).collect()
}

#[test]
fn intervals_deviate_by_a_few_parts_in_ten_thousand() {
    let pulses = pulses(4_000, 10_000, 4_000);
    let last = pulses.len() - 1;
    let ideal = IdealTrapezoid::new((0.0, 0.0), 4e3, (2e4, 2e4), last as f64);
    let mut sum = 0.0;
    let mut count = 0.0;
    for n in 2..last - 2 {
        let want = 16e6 * (ideal.time((n + 1) as f64) - ideal.time(n as f64));
        let got = (pulses[n + 1] - pulses[n]) as f64;
        sum += (got / want - 1.0).powi(2);
        count += 1.0;
    }
    let rms = 100.0 * f64::sqrt(sum / count);
    assert!(rms <= 0.05, "{rms} %");
}

#[test]
fn the_acceleration_has_no_jumps() {
    let pulses = pulses(20_000, 40_000, 20_000);
    let mean = |k: usize| (pulses[8 * k + 8] - pulses[8 * k]) as f64 / 8.0;
    let speed = |k: usize| 16e6 / mean(k);
    let mut peak = 0.0f64;
    for k in 1..pulses.len() / 8 - 2 {
        // Between the middles of two neighbouring means.
        let time = (pulses[8 * k + 16] - pulses[8 * k]) as f64 / 2.0 / 16e6;
        peak = peak.max((speed(k + 1) - speed(k)).abs() / time / 40_000.0);
    }
    assert!(peak <= 1.4, "{peak}");
}
