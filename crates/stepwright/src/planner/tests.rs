extern crate std;
use super::share::{share, share_of_ramp};
use super::*;
use crate::order::{Order, Travel};
use crate::profile::Fit;
use crate::profile::Ramp;
use crate::run::Run;
use crate::units::{Accel, Jerk, Rate, Speed};

/// The run that is ready.
fn taken(planner: &mut Planner, work: &mut Work) -> Run {
    planner.take(work);
    let run = *work.taken().unwrap();
    work.clear();
    run
}

/// A long ramp ends when the closed form says: no run loses a fraction of a tick for good.
#[test]
fn rounding_does_not_add_up() {
    for (hz, top, accel) in [
        (380_632, 19_543_030, 50_000),
        (16_000_000, 12_692_480, 50_000),
        (200_000_000, 900_000_000, 90_000_000),
    ] {
        let rate = Rate::from_hz(hz).unwrap();
        let clock = Clock::new(rate, &Fit::EXACT.lasting(rate.micros(8_000)));
        let ramp = Ramp::Accel(Accel::from_millisteps(accel).unwrap());
        let top = Speed::from_millisteps(top).unwrap();
        let order = Order {
            start: Speed::ZERO,
            top,
            up: ramp,
            down: ramp,
            jerk: None,
            travel: Travel::Endless(true),
        };
        let mut planner = Planner::IDLE;
        planner.lay_out(&clock, &order).unwrap();
        let steps = planner.rise;
        let mut work = Work::NONE;
        let mut time = 0u64;
        while planner.rise > 0 {
            if planner.next(&clock, &mut work) == Planned::Ready {
                time += taken(&mut planner, &mut work).duration();
            }
        }
        let (a, n) = (accel as f64 / 1e3, f64::from(steps));
        let want = (2.0 * n / a).sqrt() * f64::from(hz);
        let off = time as f64 / 65536.0 - want;
        assert!(off.abs() <= want * 2f64.powi(-29) + 0.5, "{off} of {want}");
    }
}

/// The step that a change of piece divides takes its time: the travel is as long as its law says.
#[test]
fn a_corner_takes_its_time() {
    let rate = Rate::from_hz(16_000_000).unwrap();
    let clock = Clock::new(rate, &Fit::board(rate));
    let ramp = Ramp::Accel(Accel::from_steps(40_000).unwrap());
    for top in (4_003..40_000).step_by(500) {
        let top = Speed::from_steps(top).unwrap();
        let (start, travel) = (Speed::ZERO, Travel::By(60_000));
        let order = Order { start, top, up: ramp, down: ramp, jerk: None, travel };
        let mut planner = Planner::IDLE;
        planner.lay_out(&clock, &order).unwrap();
        let (mut work, mut time) = (Work::NONE, 0u64);
        loop {
            match planner.next(&clock, &mut work) {
                Planned::Ready => {
                    time += taken(&mut planner, &mut work).duration();
                }
                Planned::Again => {}
                Planned::End => break,
            }
        }
        let want = order.path(rate).unwrap().time_of(60_000 - 1) as f64;
        let off = time as f64 / 65536.0 - want;
        // The law's time is in whole ticks.
        assert!(off.abs() <= 0.5 + want * 2f64.powi(-29), "{off} at {top:?}");
    }
}

/// A fall still reaches its target when its travel is set up again on the way, whatever the
/// rounding; also if it began as fast as it falls from.
#[test]
fn a_fall_that_is_laid_out_again_reaches_its_target() {
    let clock = Clock::new(Rate::from_hz(100_000).unwrap(), &Fit::EXACT);
    let ramp = |millisteps| Ramp::Accel(Accel::from_millisteps(millisteps).unwrap());
    for start in (1..400_000).step_by(997) {
        let v = |millisteps| Speed::from_millisteps(millisteps).unwrap();
        let (up, down) = (ramp(540_828), ramp(582_287));
        let (start, top, travel) = (v(start), v(445_693), Travel::By(8));
        let order = Order { start, top, up, down, jerk: None, travel };
        let mut planner = Planner::IDLE;
        planner.lay_out(&clock, &order).unwrap();
        let (mut work, mut left) = (Work::NONE, 7);
        while left > 0 {
            if planner.next(&clock, &mut work) != Planned::Ready {
                continue;
            }
            left -= i32::from(taken(&mut planner, &mut work).count as i16);
            let mut again = planner;
            again.resume(left);
            assert_eq!(again.steps_left(), left as u32, "{start:?}");
        }
    }
}

/// 1000²/(2·2500) steps are 200: no step is divided, and none is a run of its own.
#[test]
fn a_ramp_of_whole_steps_has_no_corner() {
    let clock = Clock::new(Rate::from_hz(16_000_000).unwrap(), &Fit::EXACT);
    let ramp = Ramp::Accel(Accel::from_steps(2_500).unwrap());
    let (start, top) = (Speed::ZERO, Speed::from_steps(1_000).unwrap());
    let order = Order { start, top, up: ramp, down: ramp, jerk: None, travel: Travel::By(1_001) };
    let mut planner = Planner::IDLE;
    planner.lay_out(&clock, &order).unwrap();
    assert_eq!((planner.rise, planner.level, planner.fall), (200, 600, 200));
    assert_eq!((planner.rise_part, planner.fall_part), (0, 0));
}

/// An order of 0.001 steps/s or a few, from its start to its top speed.
fn slow(start: u32, top: u32, travel: i32) -> Order {
    let v = |millis| Speed::from_millisteps(millis).unwrap();
    let ramp = Ramp::Accel(Accel::from_steps(1).unwrap());
    let travel = Travel::By(travel);
    Order { start: v(start), top: v(top), up: ramp, down: ramp, jerk: None, travel }
}

/// A board must be able to step the peak speed: it is rounded up.
#[test]
fn a_peak_is_rounded_up() {
    let clock = Clock::new(Rate::from_hz(16_000_000).unwrap(), &Fit::EXACT);
    let mut planner = Planner::IDLE;
    // One step up at 1 step/s²: √2 steps/s; two: 2 steps/s, exactly. A single step is left as it
    // is.
    for (travel, peak) in [(3, 1_415), (5, 2_000), (1, 1)] {
        planner.lay_out(&clock, &slow(0, 1_000_000, travel)).unwrap();
        assert_eq!(planner.peak(), peak, "{travel} pulses");
    }
}

/// 2³² ticks of 16 MHz are 268.4 s: an interval at 0.004 steps/s is shorter, one at 0.003 longer.
#[test]
fn no_interval_is_longer_than_32_bits() {
    let clock = Clock::new(Rate::from_hz(16_000_000).unwrap(), &Fit::EXACT);
    let mut planner = Planner::IDLE;
    assert_eq!(planner.lay_out(&clock, &slow(4, 4, 9)), Ok(()));
    assert_eq!(planner.lay_out(&clock, &slow(3, 3, 9)), Err(Unfit::TooSlow));
    // Nor is the interval across a peak from rest, with its ramps.
    assert_eq!(planner.lay_out(&clock, &slow(0, 4, 9)), Ok(()));
    assert_eq!(planner.lay_out(&clock, &slow(0, 3, 9)), Err(Unfit::TooSlow));
}

/// A piece ends in as few runs as it can: a level in two of the same length, a ramp with the steps
/// beyond a multiple of 32 by themselves.
#[test]
fn the_end_of_a_piece_is_shared() {
    let runs = |share: fn(u32, u16) -> u16, mut room: u32| {
        let mut runs = std::vec::Vec::new();
        while room > 0 {
            let steps = share(room, 256);
            assert!((1..=256).contains(&steps), "{steps} of {room}");
            runs.push(steps);
            room -= u32::from(steps);
        }
        runs
    };
    assert_eq!(runs(share, 700), [256, 222, 222]);
    assert_eq!(runs(share, 255), [255]);
    assert_eq!(runs(share_of_ramp, 700), [256, 224, 192, 28]);
    assert_eq!(runs(share_of_ramp, 255), [224, 31]);
    for room in 0..2000 {
        runs(share, room);
        runs(share_of_ramp, room);
    }
}

mod bent {
    use super::*;
    use crate::profile::SCurve;
    use crate::units::Jerk;
    use proptest::prelude::*;
    use std::vec::Vec;

    /// Times of the pulses of a travel, in ticks; the first is 0.
    fn times(rate: Rate, order: &Order) -> Result<Vec<f64>, Unfit> {
        let clock = Clock::new(rate, &Fit::EXACT.lasting(rate.micros(8_000)));
        let mut planner = Planner::IDLE;
        planner.lay_out(&clock, order)?;
        let mut work = Work::NONE;
        let mut times = std::vec![0.0];
        let (mut calls, mut time) = (0u32, 0u64);
        loop {
            calls += 1;
            assert!(calls < 10_000_000, "it never ends");
            match planner.next(&clock, &mut work) {
                Planned::Ready => {
                    let run = taken(&mut planner, &mut work);
                    let mut interval = run.interval();
                    for _ in 0..run.count() {
                        time += interval;
                        times.push(time as f64 / 65536.0);
                        interval = interval.wrapping_add_signed(run.add().into());
                    }
                }
                Planned::Again => {}
                Planned::End => return Ok(times),
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(3000))]

        /// From rest to rest the planner follows the closed form of 128 bits.
        #[test]
        fn pulses_keep_the_curve(
            hz in prop_oneof![Just(1_000_000u32), Just(16_000_000)],
            start in prop_oneof![Just(0u32), 1u32..500_000],
            top in 1_000u32..20_000_000,
            up in 100_000u64..100_000_000, down in 100_000u64..100_000_000,
            jerk in 0u32..20, fine in 1_000u64..2_000,
            pulses in prop_oneof![1i32..20, 20i32..5_000],
        ) {
            let rate = Rate::from_hz(hz).unwrap();
            let jerk = Jerk::from_millisteps((fine * 1_000) << jerk).unwrap();
            let (up, down) = (Accel::from_millisteps(up).unwrap(), Accel::from_millisteps(down).unwrap());
            let (start, top) = (Speed::from_millisteps(start).unwrap(), Speed::from_millisteps(top).unwrap());
            let order = Order {
                start, top, up: Ramp::Accel(up), down: Ramp::Accel(down), jerk: Some(jerk),
                travel: Travel::By(pulses),
            };
            let law = SCurve::new(rate, start, top, up, jerk).with_decel(down);
            let Ok(delays) = law.delays(pulses as u32) else { return Ok(()) };
            let Ok(times) = times(rate, &order) else { return Ok(()) };
            prop_assert_eq!(times.len(), pulses as usize);
            let mut want = 0.0;
            for (n, (delay, time)) in delays.zip(&times).enumerate() {
                want += f64::from(delay);
                let off = time - want;
                prop_assert!(off.abs() <= 2.0 + want * 2f64.powi(-26), "pulse {}: {} off of {}", n, off, want);
            }
        }
    }
}

/// The rest of a travel, run by run.
fn rest_of(mut planner: Planner, clock: &Clock) -> std::vec::Vec<(u32, u16, u16, i32)> {
    let (mut work, mut runs) = (Work::NONE, std::vec::Vec::new());
    loop {
        match planner.next(clock, &mut work) {
            Planned::Ready => {
                let run = taken(&mut planner, &mut work);
                runs.push((run.ticks, run.part, run.count, run.add));
            }
            Planned::Again => {}
            Planned::End => return runs,
        }
    }
}

/// The rest of a changed S-curve is divided in pieces. A change between two pieces leads to the
/// same plan as one before the first.
#[test]
fn a_change_between_the_pieces_of_a_division_begins_it_again() {
    let rate = Rate::from_hz(16_000_000).unwrap();
    let clock = Clock::new(rate, &Fit::board(rate));
    let ramp = Ramp::Accel(Accel::from_steps(20_000).unwrap());
    let v = |steps| Speed::from_steps(steps).unwrap();
    let jerk = Some(crate::units::Jerk::from_steps(200_000).unwrap());
    let (start, travel) = (Speed::ZERO, Travel::By(4_000));
    let order = Order { start, top: v(4_000), up: ramp, down: ramp, jerk, travel };
    let mut planner = Planner::IDLE;
    planner.lay_out(&clock, &order).unwrap();
    let (mut work, mut left) = (Work::NONE, 3_999);
    while left > 3_700 {
        if planner.next(&clock, &mut work) == Planned::Ready {
            left -= i32::from(taken(&mut planner, &mut work).count as i16);
        }
    }
    // A higher top speed than the rest has room for, so that several speeds are tried.
    planner.limit(&Change::Top(v(90_000)));
    planner.check(&clock).unwrap();
    planner.resume(left);
    while planner.rise > 0 || planner.rise_part != 0 {
        if planner.next(&clock, &mut work) == Planned::Ready {
            left -= i32::from(taken(&mut planner, &mut work).count as i16);
        }
    }
    assert!(planner.is_again());
    let mut pieces = 0;
    let mut midway = planner;
    while midway.is_again() {
        for change in [Change::Top(v(1_500)), Change::Target(0)] {
            let (mut before, mut between) = (planner, midway);
            for planner in [&mut before, &mut between] {
                planner.limit(&change);
                planner.check(&clock).unwrap();
                planner.resume(left / 2);
            }
            assert_eq!(between.peak(), before.peak());
            assert_eq!(rest_of(between, &clock), rest_of(before, &clock), "{pieces}: {change:?}");
        }
        assert_eq!(midway.next(&clock, &mut work), Planned::Again);
        pieces += 1;
    }
    assert!(pieces > 8, "{pieces}");
}

/// A change of a straight ramp is set up at once, so in few pieces: also if there is room for the
/// fall alone, and no speed between the bounds fits.
#[test]
fn a_straight_ramp_is_laid_out_in_two_rounds() {
    let rate = Rate::from_hz(16_000_000).unwrap();
    let clock = Clock::new(rate, &Fit::board(rate));
    let order = Order {
        start: Speed::from_steps(500).unwrap(),
        top: Speed::from_millisteps(665_203).unwrap(),
        up: Ramp::Steps(200),
        down: Ramp::Steps(200),
        jerk: None,
        travel: Travel::By(14),
    };
    let mut planner = Planner::IDLE;
    planner.lay_out(&clock, &order).unwrap();
    let mut work = Work::NONE;
    while planner.steps_left() > 0 {
        let mut changed = planner;
        changed.limit(&Change::Top(Speed::from_steps(1896).unwrap()));
        changed.check(&clock).unwrap();
        let left = changed.steps_left();
        let (mut piece, mut pieces) = (Layout::Rise, 0);
        while piece != Layout::Check {
            piece = changed.divide_piece(piece, left);
            pieces += 1;
        }
        // Fall, meet, try, twice; and the speed between, in two.
        assert!(pieces <= 9, "{pieces} pieces with {left} steps left");
        assert_eq!(changed.steps_left(), left);
        if planner.next(&clock, &mut work) == Planned::Ready {
            taken(&mut planner, &mut work);
        }
    }
}

/// The top speed of a bent travel without room for its own is found in few iterations, also if it
/// is close above the start speed: the board answers no order before.
#[test]
fn the_top_speed_of_a_bent_travel_is_found_in_few_rounds() {
    let rate = Rate::from_hz(16_000_000).unwrap();
    let clock = Clock::new(rate, &Fit::board(rate));
    // From 1 to e^n, evenly in the exponent.
    let mut seed = 1u64;
    let mut power = |n: f64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((seed >> 11) as f64 / (1u64 << 53) as f64 * n).exp()
    };
    let (mut found, mut rounds) = (0, 0);
    while found < 2_000 {
        let (top, up, down) = (2000.0 * power(11.0), power(12.0), power(12.0));
        let steps = 1 + power(11.0) as i32;
        let order = Order {
            start: Speed::from_millisteps((top / power(3.0)) as u32).unwrap(),
            top: Speed::from_millisteps(top as u32).unwrap(),
            up: Ramp::Accel(Accel::clamped(10 * up as u32)),
            down: Ramp::Accel(Accel::clamped(10 * down as u32)),
            jerk: Some(Jerk::from_millisteps((10_000.0 * up * power(5.0)) as u64).unwrap()),
            travel: Travel::By(steps),
        };
        let mut planner = Planner::IDLE;
        planner.accept(&order).unwrap();
        let mut piece = Layout::Speeds;
        let mut tried = 0;
        while piece != Layout::Check {
            tried += u32::from(piece == Layout::Fall);
            match planner.lay(&clock, piece, steps as u32) {
                Ok(next) => piece = next,
                Err(_) => break,
            }
        }
        assert!(tried <= 12, "{tried} rounds: {order:?}");
        if tried > 1 {
            (found, rounds) = (found + 1, rounds + tried);
        }
    }
    assert!(rounds < 6 * found, "{rounds} rounds of {found} travels");
}
