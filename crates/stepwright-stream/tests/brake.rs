//! The brake against floating point, and a closed form: c² falls by 2a/f² a step.

use proptest::prelude::*;
use stepwright_stream::brake::{BrakeLaw, Braking};
use stepwright_stream::record::{Record, RecordAct, Trail};

const F: f64 = 16e6;

/// Intervals in ticks between the steps of a braking axis, the first one that of the step that is due.
fn intervals(first: f64, accel: f64) -> (Vec<f64>, usize) {
    let law = BrakeLaw::of((accel * 1_000.0) as u64, F as u32).unwrap();
    let last = (first * 256.0) as u32;
    let mut halvings = 0;
    let mut part = last;
    while part >= 0x7F00 << 8 {
        (part, halvings) = (part >> 1, halvings + 1);
    }
    let trail = Trail { last: part, growth: 0, halvings, moves: true };
    let mut braking = Braking::from(&trail);
    let (mut all, mut records) = (Vec::new(), 0);
    while let Some(record) = braking.next(law) {
        records += 1;
        assert!(record.is_playable(72), "{record:?}");
        match record.act {
            RecordAct::Steps(count) => {
                all.extend(vec![f64::from(record.interval) / 256.0; count.into()])
            }
            RecordAct::Groups { bits, count } => {
                for n in 0..i64::from(count) {
                    let wait = i64::from(record.interval) + n * i64::from(record.growth);
                    all.extend(vec![wait as f64 / 256.0; 1 << bits]);
                }
            }
            RecordAct::Step { .. } => all.push(record.time() as f64 / 256.0),
            RecordAct::Wait { .. } => *all.last_mut().unwrap() += record.time() as f64 / 256.0,
        }
        assert!(records < 100_000);
    }
    (all, records)
}

/// The largest deceleration: from the middle of a stretch of steps at one interval to that of the
/// next one.
fn steepest(first: f64, all: &[f64]) -> f64 {
    let mut stretches = vec![(first, 1.0)];
    for c in all {
        match stretches.last_mut() {
            Some((same, steps)) if same == c => *steps += 1.0,
            _ => stretches.push((*c, 1.0)),
        }
    }
    let between = stretches.windows(2).map(|pair| {
        let ((c, steps), (d, more)) = (pair[0], pair[1]);
        (F / c - F / d) / ((steps * c + more * d) / 2.0 / F)
    });
    between.fold(0.0, f64::max)
}

proptest! {
    /// From any speed, slow ones too: never steeper than ordered, and not much longer than it has to be.
    #[test]
    fn it_brakes_as_ordered(speed in 2.0f64..100_000.0, exponent in 1.0f64..6.0) {
        let accel = 10f64.powf(exponent);
        prop_assume!(speed * speed / 2.0 / accel < 300_000.0);
        let first = F / speed;
        let (all, _) = intervals(first, accel);
        let way = speed * speed / 2.0 / accel;
        let steepest = steepest(first, &all);
        prop_assert!(steepest <= accel * 1.005, "{steepest} of {accel}");
        // The mean of (c/c₀)³ over a growth of 1/8, and some steps near rest.
        let longer = (1.125f64.powi(4) - 1.0) / 4.0 / 0.125;
        prop_assert!((all.len() as f64) < longer * way + 5.0, "{} steps of {way}", all.len());
        prop_assert!(all.len() as f64 > way - 1.0, "{} steps of {way}", all.len());
        // At rest only from where one may be.
        let slowest = F * (2.0 / accel).sqrt();
        let last = all.last().copied().unwrap_or(first);
        prop_assert!(last >= slowest * 0.9999, "{last} of {slowest}");
        prop_assert!(all.windows(2).all(|pair| pair[1] >= pair[0]));
    }

    /// dc/dn = c³·a/f², in floating point.
    #[test]
    fn the_growth_is_the_formula(ticks in 72.0f64..2e6, accel in 10.0f64..1e6, bits in 0u8..8) {
        let law = BrakeLaw::of((accel * 1e3) as u64, F as u32).unwrap();
        let c = (ticks * 256.0).floor();
        let exact = (c / 256.0).powi(3) * accel / F / F * 256.0 * f64::from(1u32 << bits);
        prop_assert!(exact < 4e9 || law.growth(c as u32, bits) > 3_900_000_000);
        let exact = exact.min(f64::from(u32::MAX));
        let got = f64::from(law.growth(c as u32, bits));
        // Rounded down, in parts of 2⁻¹⁵: three factors by 1, two products by 2 and 4, the mantissa,
        // which is even, by 2; and the result.
        prop_assert!(got <= exact && got >= exact * (1.0 - 11.0 / 32_768.0) - 1.0, "{got} of {exact}");
    }

    #[test]
    fn a_law_comes_back(thousandths in 2_000u64.., hz in 1_000_000u32..200_000_000) {
        if let Some(law) = BrakeLaw::of(thousandths, hz) {
            let bytes = law.bytes();
            prop_assert_eq!(BrakeLaw::from_bytes(bytes), law);
            prop_assert!(!bytes.windows(3).any(|three| three == [0xFF; 3]) && bytes[5] != 0xFF);
        }
    }
}

/// Each grows by 1/16 to 1/8, up to the slowest interval.
#[test]
fn it_takes_few_entries() {
    let (all, records) = intervals(F / 38_000.0, 40_000.0);
    let (way, ratio) = (38_000f64.powi(2) / 80_000.0, (2.0f64 / 40_000.0).sqrt() * 38_000.0);
    let (fewest, most) = (ratio.ln() / 1.125f64.ln(), ratio.ln() / 1.0625f64.ln());
    assert!((fewest - 1.0..most + 3.0).contains(&(records as f64)), "{records}");
    assert!(all.len() as f64 / way < 1.14, "{}", all.len());
}

/// Where it turns, or waits without a step to come, it rests at once.
#[test]
fn without_a_step_to_come_it_rests() {
    let law = BrakeLaw::of(1_000_000, 16_000_000).unwrap();
    let mut trail = Trail::NONE;
    trail.pass(&Record { act: RecordAct::Steps(100), interval: 800 << 8, growth: 0 });
    assert!(Braking::from(&trail).next(law).is_some());
    for act in [
        RecordAct::Step { halvings: 0, goes_on: false },
        RecordAct::Wait { halvings: 2, turn: true },
    ] {
        trail.pass(&Record { act, interval: 1_300 << 8, growth: 0 });
        assert_eq!(Braking::from(&trail).next(law), None);
    }
}

/// Fast axes with gentle decelerations: the growth of a group is less than can be said. By records, as there are
/// up to 10⁹ steps.
#[test]
fn gentle_decelerations_brake_at_any_speed() {
    for (speed, accel) in [
        (200_000.0, 118_000.0),
        (200_000.0, 60_000.0),
        (200_000.0, 15_000.0),
        (200_000.0, 1_000.0),
        (157_000.0, 7_000.0),
        (100_000.0, 1_000.0),
        (50_000.0, 200.0),
        (120_000.0, 90.0),
    ] {
        let law = BrakeLaw::of((accel * 1_000.0) as u64, F as u32).unwrap();
        let first = F / speed;
        let trail = Trail { last: (first * 256.0) as u32, growth: 0, halvings: 0, moves: true };
        let mut braking = Braking::from(&trail);
        // Of stretches at one interval: the interval in ticks, and steps.
        let (mut before, mut way, mut steepest, mut jump) = ((first, 1.0), 0.0, 0.0f64, 0.0f64);
        let mut see = |interval: f64, steps: f64| {
            let (c, count) = before;
            if interval != c {
                let (v, w) = (F / c, F / interval);
                let time = (count * c + steps * interval) / 2.0 / F;
                steepest = steepest.max((v - w) / time);
                if v > 10_000.0 {
                    jump = jump.max((v - w) / v);
                }
                before = (interval, steps);
            } else {
                before.1 += steps;
            }
            way += steps;
        };
        while let Some(record) = braking.next(law) {
            assert!(record.is_playable(70), "{record:?}");
            let interval =
                |n: i64| (i64::from(record.interval) + n * i64::from(record.growth)) as f64 / 256.0;
            match record.act {
                RecordAct::Steps(count) => see(interval(0), count.into()),
                RecordAct::Groups { bits, count } => {
                    (0..count.into()).for_each(|n| see(interval(n), f64::from(1u32 << bits)));
                }
                // Below 570 steps/s each step is a record: its test is above.
                RecordAct::Step { .. } => break,
                RecordAct::Wait { .. } => {}
            }
        }
        let whole = speed * speed / 2.0 / accel;
        assert!(steepest <= accel * 1.005, "{speed}, {accel}: {steepest}");
        assert!(way < 1.2 * whole && way > 0.98 * whole, "{speed}, {accel}: {way} of {whole}");
        assert!(jump < 0.02, "{speed}, {accel}: {jump}");
    }
}

/// Behind a corner the last group was growing faster: the axis brakes from the speed that it has.
#[test]
fn it_brakes_from_the_speed_behind_a_corner() {
    for growth in [-(5_000 << 8), -(3_001 << 8), -(1_000 << 8)] {
        let trail = Trail { last: 3_000 << 8, growth, halvings: 0, moves: true };
        let law = BrakeLaw::of(40_000_000, F as u32).unwrap();
        let mut braking = Braking::from(&trail);
        let first = braking.next(law).unwrap();
        assert!((3_000 << 8..3_200 << 8).contains(&first.interval), "{first:?}");
    }
}
