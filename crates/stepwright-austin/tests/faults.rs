//! Faults of well-known implementations of Austin's law, each with a test that would show it here.

use stepwright::{Accel, Rate, Speed};
use stepwright_austin::{
    Austin, C0, Carried, Divisor, Fixed, LinearFactor, Piecewise, PowerTerm, Ramp, Slope,
};

fn speed(v: u32) -> Speed {
    Speed::from_steps(v).unwrap()
}

fn accel(a: u32) -> Accel {
    Accel::from_steps(a).unwrap()
}

fn fixed(pulses: u32, c0: u32, c_min: u32) -> Vec<u32> {
    Fixed::new(pulses, c0, c_min).skip(1).collect()
}

/// Every law for the same order, without the first 0.
fn laws(rate: Rate, top: Speed, a: Accel, d: Accel, pulses: u32) -> Vec<(&'static str, Vec<u32>)> {
    let general = Austin::new(rate, top, a).with_decel(d);
    let all = |delays: Vec<u32>| delays.into_iter().skip(1).collect();
    let two = general.with_divisor(Divisor::TwoN);
    let linear = LinearFactor::new(rate, top, a).with_decel(d);
    let power = PowerTerm::new(rate, top, a, 4).with_decel(d);
    let stages = Piecewise::new(rate, top, a).with_decel(d);
    vec![
        ("general", all(general.delays(pulses).unwrap().collect())),
        ("exact c0", all(general.with_c0(C0::Exact).delays(pulses).unwrap().collect())),
        ("c/2n", all(two.delays(pulses).unwrap().collect())),
        ("linear", all(linear.delays(pulses).unwrap().collect())),
        ("power", all(power.delays(pulses).unwrap().collect())),
        ("piecewise", all(stages.delays(pulses).unwrap().collect())),
    ]
}

/// A listing that continues to subtract after c_min was passed accelerates without end.
#[test]
fn c_min_within_two_ramp_steps() {
    assert_eq!(fixed(6, 3_000, 2_500), [3_000, 2_500, 2_500, 2_500, 2_500]);
    assert_eq!(fixed(7, 5_000, 2_500), [5_000, 3_000, 2_500, 2_500, 2_500, 2_500]);
    for pulses in 2..40 {
        for (name, delays) in laws(Rate::MHZ, speed(400), accel(100_000), accel(100_000), pulses) {
            assert_eq!(delays.len() as u32, pulses - 1);
            assert!(delays.iter().all(|c| (2_499..6_000).contains(c)), "{name}: {delays:?}");
        }
    }
}

/// c₀ shorter than c_min must not make the first step faster than the top speed.
#[test]
fn c_min_above_c0() {
    assert_eq!(fixed(5, 1_000, 2_500), [2_500; 4]);
    for (name, delays) in laws(Rate::MHZ, speed(400), accel(2_000_000), accel(2_000_000), 50) {
        assert!(delays.iter().all(|c| (2_499..=2_501).contains(c)), "{name}: {delays:?}");
    }
}

/// With an unsigned divisor −(4j − 1) is huge, and nothing decelerates.
#[test]
fn deceleration_is_signed() {
    let delays = fixed(100, 50_000, 2_500);
    assert!(delays.windows(2).skip(50).all(|pair| pair[1] > pair[0]), "{delays:?}");
    for (name, delays) in laws(Rate::MHZ, speed(4_000), accel(400), accel(400), 100) {
        assert!(delays[98] > 3 * delays[50], "{name}: {delays:?}");
    }
}

/// Where the ramps meet, the sign of the divisor changes: the delay after the middle is not shorter
/// than the one before.
#[test]
fn the_sign_at_the_midpoint() {
    for pulses in 3..200 {
        let delays = fixed(pulses, 50_000, 100);
        let least = delays.iter().position(|c| Some(c) == delays.iter().min()).unwrap();
        assert!(delays[..=least].is_sorted_by(|a, b| a >= b), "{pulses}: {delays:?}");
        assert!(delays[least..].is_sorted(), "{pulses}: {delays:?}");
        for (name, delays) in laws(Rate::MHZ, speed(9_000), accel(400), accel(400), pulses) {
            let least = delays.iter().position(|c| Some(c) == delays.iter().min()).unwrap();
            // Whole ticks carry a fraction: one more or less is no change of speed.
            assert!(delays[..=least].windows(2).all(|p| p[0] + 1 >= p[1]), "{name}: {delays:?}");
            assert!(delays[least..].windows(2).all(|p| p[1] + 1 >= p[0]), "{name}: {delays:?}");
        }
    }
}

/// 4n + 1 exceeds 16 bits at n = 8192; the ramp continues by the formula, up and down.
#[test]
fn ramps_beyond_8191_steps() {
    let (c0, pulses) = (1_000_000, 60_001);
    let delays = fixed(pulses, c0, 1_000);
    let mut c = f64::from(c0);
    for n in 1..=29_000u32 {
        c -= 2.0 * c / (4.0 * f64::from(n) + 1.0);
        let off = (f64::from(delays[n as usize]) - c).abs();
        // Truncation costs up to 2⁻⁸ a step, a third of a tick in a hundred steps on average;
        // beyond 8191 nothing more.
        let cost = f64::from(n.min(8_191)) / 300.0;
        assert!(off <= 0.5 + cost, "{n}: {} {c}", delays[n as usize]);
    }
    let last = f64::from(delays[delays.len() - 1]) / (0.6 * f64::from(c0));
    assert!((last - 1.0).abs() < 0.005, "{last}");
    // In 2⁻⁸ ticks the ramp would stall here: 2·c·256 < 4n + 1.
    let delays = fixed(2_000_000, 20_000, 20);
    assert!(delays.contains(&20));
}

/// A motion can be stopped at any time, and ends after the steps that it needs.
#[test]
fn stop_during_a_move() {
    for after in [2, 3, 100, 5_000, 12_000] {
        let mut travel = Fixed::new(1_000_000, 50_000, 500);
        let up = travel.by_ref().take(after).count();
        travel.stop();
        let down: Vec<_> = travel.collect();
        assert!(down.len() <= up && down.is_sorted(), "{after}: {}", down.len());
        let law = Austin::new(Rate::MHZ, speed(2_000), accel(400)).with_decel(accel(800));
        let mut travel = law.delays(1_000_000).unwrap();
        let up: Vec<_> = travel.by_ref().take(after).collect();
        travel.stop();
        let down: Vec<_> = travel.collect();
        assert!(down.len() <= up.len() / 2 + 1, "{after}: {}", down.len());
        // From its speed, within one step.
        if let Some(first) = down.first() {
            let ratio = f64::from(*first) / f64::from(up[up.len() - 1]);
            assert!((0.99..1.5).contains(&ratio), "{after}: {ratio}");
        }
    }
    // It can also change its acceleration, level off, or continue.
    let mut ramp = Ramp::new(Rate::MHZ, accel(400), C0::Reduced).unwrap();
    let fast = ramp.by_ref().nth(500).unwrap();
    ramp.set(Slope::Down(accel(4_000)));
    assert_eq!(ramp.by_ref().count(), 49);
    assert!(fast > 1_500);
}

/// c₀ is not limited to 65,535.
#[test]
fn a_long_first_delay() {
    assert_eq!(fixed(4, 10_000_000, 2_500), [10_000_000, 6_000_000, 6_000_000]);
    assert_eq!(fixed(3, u32::MAX, 1), [u32::MAX, 2_576_980_377]);
    let law = Austin::new(Rate::from_hz(16_000_000).unwrap(), speed(100), accel(1));
    let delays: Vec<_> = law.delays(3).unwrap().collect();
    assert_eq!(delays[1], 15_296_134); // 0.676 · 16e6 · √2
}

/// n = 0 would divide by 1 and leave −c: at the start, and in the delay after the last pulse.
#[test]
fn n_is_never_0() {
    for pulses in 0..9 {
        let delays = fixed(pulses, 50_000, 2_500);
        assert_eq!(delays.len() as u32, pulses.saturating_sub(1));
        assert!(delays.iter().all(|c| (17_421..=50_000).contains(c)), "{delays:?}");
        let mut travel = Fixed::new(pulses, 50_000, 2_500);
        assert_eq!(travel.by_ref().count() as u32, pulses);
        assert_eq!((travel.next(), travel.next()), (None, None));
        for (name, delays) in laws(Rate::MHZ, speed(4_000), accel(400), accel(400), pulses) {
            assert!(delays.iter().all(|c| (5_000..90_000).contains(c)), "{name}: {delays:?}");
        }
    }
}

/// A travel that begins at its top speed and brakes more gently than it would have accelerated: its
/// first slower delay is computed from this travel, not from an earlier one.
#[test]
fn starting_at_top_speed_then_braking() {
    let law = Austin::new(Rate::MHZ, speed(400), accel(1_000_000)).with_decel(accel(4_000));
    for _ in 0..2 {
        let delays: Vec<_> = law.delays(200).unwrap().skip(1).collect();
        assert!(delays[..100].iter().all(|c| (2_499..=2_501).contains(c)));
        assert!(delays.windows(2).all(|pair| pair[1] + 1 >= pair[0]), "{delays:?}");
        assert!(delays.iter().all(|c| *c < 20_000), "{delays:?}");
    }
}

/// The remainder of a division on the way up leaks neither into the way down nor into the next
/// travel.
#[test]
fn no_remainder_from_ramp_to_ramp() {
    let once = fixed(5_000, 50_000, 300);
    assert_eq!(once, fixed(5_000, 50_000, 300));
    let law = Austin::new(Rate::MHZ, speed(3_000), accel(3_000));
    let delays: Vec<_> = law.delays(5_000).unwrap().skip(1).collect();
    for (up, down) in delays[1..].iter().zip(delays.iter().rev()) {
        assert!(up.abs_diff(*down) <= 1, "{up} {down}");
    }
}

/// The top speed is reached in less than one step: no delay is shorter than c_min (one
/// implementation runs about four times too fast).
#[test]
fn top_speed_in_less_than_one_step() {
    for top in [1, 10, 100, 1_000] {
        for a in [1_000_000, 100_000_000] {
            let c_min = 1_000_000 / top;
            for (name, delays) in laws(Rate::MHZ, speed(top), accel(a), accel(a), 20) {
                assert!(delays.iter().all(|c| c + 1 >= c_min), "{name}: {delays:?}");
            }
        }
    }
}

/// Steps times deceleration is far more than 32 bits.
#[test]
fn steps_times_deceleration() {
    let law = Austin::new(Rate::from_hz(16_000_000).unwrap(), speed(100_000), accel(5_000_000))
        .with_decel(accel(10_000_000));
    // 1000 steps up, 500 down.
    let mut travel = law.delays(1 << 31).unwrap();
    let up = travel.by_ref().take_while(|c| *c != 160).count();
    assert!((990..=1_001).contains(&up), "{up}");
    assert_eq!(travel.len(), (1 << 31) - up - 1);
    for (steps, a, d) in
        [(3_000, accel(100_000_000), accel(1)), (3_000, accel(1), accel(100_000_000))]
    {
        let (top, rate) = (speed(1_000_000), Rate::MHZ);
        for (name, delays) in laws(rate, top, a, d, steps) {
            assert_eq!(delays.len() as u32, steps - 1);
            assert!(delays.iter().all(|c| *c < 1_500_000), "{name}");
        }
    }
}

/// The law in the interrupt and the published form are the same arithmetic except for the
/// remainder: they differ by no more than that.
#[test]
fn the_law_in_the_interrupt() {
    for (pulses, c0, c_min) in [(3, 50_000, 2_500), (10, 50_000, 2_500), (2_000, 50_000, 1_000)] {
        let ours = fixed(pulses, c0, c_min);
        let direct: Vec<_> = Carried::new(pulses, c0, c_min).collect();
        assert_eq!(ours.len(), direct.len());
        for (i, (a, b)) in ours.iter().zip(&direct).enumerate() {
            assert!(a.abs_diff(*b) <= 1 + a / 500, "{i}: {a} {b}");
        }
    }
}
