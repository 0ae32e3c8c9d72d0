//! Lines of scaled orders: all axes end together, each within a step of the line.

use proptest::prelude::*;
use stepwright::profile::Ramp;
use stepwright::{Accel, Jerk, Order, Rate, Speed, Travel};

const HZ: f64 = 16_000_000.0;

/// Seconds of every pulse of an order, from its closed form.
fn times(order: &Order) -> Vec<f64> {
    let rate = Rate::from_hz(HZ as u32).unwrap();
    let Travel::By(steps) = order.travel else { unreachable!() };
    let pulses = steps.unsigned_abs();
    let seconds = |ticks: u64| ticks as f64 / HZ;
    match order.s_curve(rate) {
        None => {
            let path = order.path(rate).unwrap();
            (0..pulses).map(|n| seconds(path.time_of(n))).collect()
        }
        Some(law) => {
            let curve = law.unwrap().curve(pulses).unwrap();
            (0..pulses).map(|n| seconds(curve.time_of(n))).collect()
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn axes_keep_to_the_line_and_end_together(
        start in prop_oneof![Just(0u32), 20u32..500],
        top in 1_000u32..40_000,
        up in 2_000u32..200_000, down in 2_000u32..200_000,
        by_steps in proptest::option::of(20u16..900),
        jerk in proptest::option::of(50_000u64..5_000_000),
        furthest in 100i32..5_000,
        shares in [0.02f64..1.0, -1.0f64..-0.02],
    ) {
        let accel = |a| by_steps.map_or(Ramp::Accel(Accel::from_steps(a).unwrap()), Ramp::Steps);
        let order = Order {
            start: Speed::from_steps(start).unwrap(),
            top: Speed::from_steps(top).unwrap(),
            up: accel(up),
            down: accel(down),
            jerk: jerk.map(|jerk| Jerk::from_steps(jerk).unwrap()),
            travel: Travel::Endless(true),
        };
        let ways = shares.map(|share| (share * f64::from(furthest)) as i32);
        let orders: Vec<_> = order.split_line([ways[0], furthest, ways[1]]).unwrap().collect();
        let way = |axis: u8| [ways[0], furthest, ways[1]][usize::from(axis)];
        let lead = times(&orders.iter().find(|(axis, _)| *axis == 1).unwrap().1);
        let end = lead[lead.len() - 1];
        for (axis, order) in &orders {
            prop_assert_eq!(order.travel, Travel::By(way(*axis)));
            let own = times(order);
            if own.len() == 1 {
                continue;
            }
            // The effect of half a thousandth on a speed, twice on an acceleration; and on the
            // start speed, with which the ramps begin and end.
            let slow = f64::from(order.top.millisteps()) / 1e3;
            let accel = |ramp| order.accel(ramp).unwrap().millisteps() as f64 / 1e3;
            let weak = accel(order.up).min(accel(order.down));
            let mut rounding = end * (1e-3 / slow + 1e-3 / weak) + 1e-3 / weak + 1e-6;
            if order.jerk.is_some() {
                // An S-curve stays near its start speed for long: half a thousandth of it, over the
                // whole time, at the mean speed.
                rounding += 0.5e-3 * end * end / (own.len() - 1) as f64;
            }
            prop_assert!((own[own.len() - 1] - end).abs() <= rounding, "{} {end}", own[own.len() - 1]);
            // Between which of the longest axis's pulses each comes.
            let share = (own.len() - 1) as f64 / (lead.len() - 1) as f64;
            for (n, time) in own.iter().enumerate() {
                let place = n as f64 / share;
                let before = lead[(place - 1e-6).max(0.0).floor() as usize];
                let after = lead[((place + 1e-6).ceil() as usize).min(lead.len() - 1)];
                prop_assert!(
                    (before - rounding..=after + rounding).contains(time),
                    "axis {axis}, pulse {n}: {time} of {before} to {after}"
                );
            }
        }
    }
}

#[test]
fn an_axis_that_rests_gets_no_order_and_extremes_do_no_harm() {
    let ramp = Ramp::Accel(Accel::MAX);
    let (start, top) = (Speed::ZERO, Speed::MAX);
    let order =
        Order { start, top, up: ramp, down: ramp, jerk: Some(Jerk::MAX), travel: Travel::By(9) };
    assert_eq!(order.split_line([0, 0, 0]).unwrap().count(), 0);
    let all: Vec<_> = order.split_line([i32::MIN, i32::MAX, 1, 2]).unwrap().collect();
    assert_eq!(all.len(), 4);
    assert_eq!((all[0].1.top, all[0].1.travel), (Speed::MAX, Travel::By(i32::MIN)));
    assert!(all[3].1.top > Speed::ZERO);
    let none = Order { up: Ramp::Steps(0), ..order };
    assert!(none.split_line([1, 2]).is_err());
}
