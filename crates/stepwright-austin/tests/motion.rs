//! A motion under Austin's law: its numbers, and the faults that well-known implementations have
//! where a motion changes, each with a test that would show it.

use stepwright::profile::Unfit;
use stepwright::{Accel, Rate, Speed};
use stepwright_austin::{Austin, Motion};

fn speed(v: u32) -> Speed {
    Speed::from_steps(v).unwrap()
}

fn accel(a: u32) -> Accel {
    Accel::from_steps(a).unwrap()
}

fn motion(top: u32, a: u32, target: i32) -> Motion {
    let mut motion = Motion::new(Rate::MHZ, speed(top), accel(a)).unwrap();
    motion.retarget(target);
    motion
}

fn take(motion: &mut Motion, pulses: usize) -> Vec<u32> {
    motion.by_ref().take(pulses).collect()
}

/// Whether no delay is shorter than the one before, except for the fraction of a tick.
fn slows(delays: &[u32]) -> bool {
    delays.windows(2).all(|pair| pair[1] + 1 >= pair[0])
}

/// Table 2, by a timer that shows two more digits: 10, then 5 or −20 rad/s² (1.8°).
#[test]
fn table_2() {
    let a =
        |rad: f64| Accel::from_millisteps((rad * 100e3 / core::f64::consts::PI) as u64).unwrap();
    let rate = Rate::from_hz(100_000_000).unwrap();
    let mut motion = Motion::new(rate, Speed::MAX, a(10.0)).unwrap();
    motion.retarget(100_000);
    // c0 is that of 10 rad/s², where the article gives only c198.
    let up: Vec<_> = motion.by_ref().take(201).collect();
    let scale = 2813.067 / f64::from(up[199]);
    let close = |got: u32, want: f64| {
        let got = f64::from(got) * scale;
        assert!((got - want).abs() < 0.02, "{got} {want}");
    };
    close(up[200], 2806.008);
    let mut slower = motion.clone();
    slower.set_accel(a(5.0)).unwrap();
    close(slower.next().unwrap(), 2802.498); // printed 2,803.498, a misprint
    close(slower.next().unwrap(), 2799.001);
    motion.set_decel(a(20.0)).unwrap();
    motion.set_top_speed(speed(10)).unwrap();
    close(motion.next().unwrap(), 2820.180);
    close(motion.next().unwrap(), 2834.568);
}

/// Without changes: Figures 2 to 4, the general form on the way up, and the same on the way down.
#[test]
fn without_a_change() {
    let delays: Vec<_> = motion(400, 400, 1_000).collect();
    let law: Vec<_> =
        Austin::new(Rate::MHZ, speed(400), accel(400)).delays(1_000).unwrap().collect();
    assert_eq!((delays.len(), delays[1], delays[200]), (1_000, 47_800, 2_503));
    assert!(delays.iter().zip(&law).take(700).all(|(a, b)| a.abs_diff(*b) <= 1));
    for (up, down) in delays[1..].iter().zip(delays.iter().rev()) {
        assert!(up.abs_diff(*down) <= 1, "{up} {down}");
    }
}

/// The end is exact whatever the remainder: a motion of m pulses has m − 1 delays after the first,
/// and the last is the first of a ramp.
#[test]
fn short_motions() {
    for target in (-60..=60).filter(|n| *n != 0) {
        for (a, d) in [(400, 400), (400, 130), (130, 400)] {
            let mut motion = motion(5_000, a, target);
            motion.set_decel(accel(d)).unwrap();
            let delays: Vec<_> = motion.by_ref().collect();
            assert_eq!(delays.len() as u32, target.unsigned_abs());
            assert_eq!((motion.position(), motion.next()), (target.into(), None));
            // As far from rest at both ends as 0.676·c0, within Table 1's n = 1.
            let c0 = |a: u32| 0.676e6 * (2.0 / f64::from(a)).sqrt();
            if let [0, first, .., last] = delays[..] {
                assert!(f64::from(first) >= 0.99 * c0(a), "{delays:?}");
                assert!(f64::from(last) >= 0.94 * c0(d), "{delays:?}");
            }
        }
    }
}

#[test]
fn refused_changes_change_nothing() {
    let mut motion = motion(400, 400, 500);
    take(&mut motion, 100);
    let mut other = motion.clone();
    assert_eq!(motion.set_top_speed(Speed::ZERO), Err(Unfit::Standstill));
    let rate = Rate::from_hz(100_000_000).unwrap();
    let slowest = Accel::MIN;
    assert_eq!(Motion::new(rate, speed(1), slowest).err(), Some(Unfit::TooSlow));
    other.set_top_speed(speed(400)).unwrap();
    other.set_accel(accel(400)).unwrap();
    other.retarget(500);
    assert!(motion.eq(other)); // nor do those that say what is so already
}

/// Fault: endless acceleration where c_min comes within two steps of the ramp.
#[test]
fn c_min_within_two_ramp_steps() {
    for after in 1..6 {
        for top in [5, 20, 25, 35, 50, 100] {
            let mut motion = motion(1_000, 400, 300);
            let last = *take(&mut motion, after).last().unwrap();
            motion.set_top_speed(speed(top)).unwrap();
            let delays: Vec<_> = motion.collect();
            let least = (1_000_000 / top - 1).min(if last == 0 { u32::MAX } else { last });
            assert!(delays.iter().all(|c| *c >= least), "{after} {top}: {delays:?}");
            assert!(delays.iter().all(|c| *c <= 200_001), "{after} {top}: {delays:?}");
        }
    }
}

/// Fault: c_min > c0 is not clamped.
#[test]
fn c_min_above_c0() {
    let mut motion = motion(10, 2_000_000, 50);
    assert_eq!(take(&mut motion, 3), [0, 100_000, 100_000]);
    motion.set_top_speed(speed(5)).unwrap();
    motion.set_accel(accel(50_000_000)).unwrap();
    assert!(motion.all(|c| (199_999..=200_001).contains(&c)));
}

/// Faults: an unsigned divisor that never brakes; no stop during the motion.
#[test]
fn a_stop_brakes_anywhere() {
    for after in [2, 3, 4, 10, 100, 2_000, 12_000] {
        let mut motion = motion(2_000, 400, 1_000_000);
        motion.set_decel(accel(800)).unwrap();
        let up = take(&mut motion, after);
        motion.stop();
        let place = motion.target();
        let down: Vec<_> = motion.by_ref().collect();
        assert!(slows(&down), "{after}: {down:?}");
        assert!(down.len() <= up.len() / 2 + 1, "{after}: {}", down.len());
        assert_eq!((motion.position(), motion.next()), (place, None));
        // The stop is repeated at every step.
        let mut again = self::motion(2_000, 400, 1_000_000);
        again.set_decel(accel(800)).unwrap();
        take(&mut again, after);
        for c in &down {
            again.stop();
            assert_eq!(again.next(), Some(*c), "{after}");
        }
        again.stop();
        assert_eq!(again.next(), None);
    }
}

/// Fault: no retarget during the motion. A further target: the fall becomes a rise again; a nearer
/// one, or one behind: to rest beyond it, and back, one step at a time.
#[test]
fn a_target_may_move() {
    let mut motion = motion(1_000, 1_000, 1_000);
    take(&mut motion, 800); // 200 steps to go, of 500 that the fall takes
    motion.retarget(3_000);
    let rise = take(&mut motion, 300);
    assert!(rise.windows(2).all(|pair| pair[1] <= pair[0] + 1));
    assert_eq!(rise[299], 1_000);
    motion.retarget(1_200); // nearer than it can stop
    assert_eq!(motion.by_ref().count(), 900); // 500 to rest at 1,600, and back
    assert_eq!((motion.position(), motion.is_forward()), (1_200, false));
    let mut most = 0;
    motion.retarget(2_000);
    take(&mut motion, 300);
    motion.retarget(-50);
    while motion.next().is_some() {
        most = most.max(motion.position());
    }
    // The speed of 300 steps, at the same rate: 299 and a half, rounded to a whole step.
    assert_eq!((most, motion.position()), (1_500 + 299, -50));
}

/// Fault: the sign of the divisor is lost where the ramps meet.
#[test]
fn the_sign_where_ramps_meet() {
    for target in 3..120 {
        let mut motion = motion(9_000, 400, target);
        let half = take(&mut motion, target as usize / 2);
        motion.retarget(2 * target);
        let delays: Vec<_> = half.into_iter().chain(motion).skip(1).collect();
        let least = delays.iter().position(|c| Some(c) == delays.iter().min()).unwrap();
        assert!(delays[..=least].windows(2).all(|p| p[0] + 1 >= p[1]), "{target}: {delays:?}");
        assert!(slows(&delays[least..]), "{target}: {delays:?}");
        assert!(least.abs_diff(delays.len() / 2) <= 1, "{target}: {least}");
    }
}

/// Fault: 4n + 1 leaves 16 bits at n = 8192, and n changes with the acceleration.
#[test]
fn n_beyond_8191() {
    let mut motion = motion(50_000, 10_000, i32::MAX);
    let at = *take(&mut motion, 12_001).last().unwrap(); // c at n = 11,999
    motion.set_accel(accel(100)).unwrap(); // n = 1,199,949
    let mut v2 = 2.0 * 10_000.0 * 11_999.5;
    assert!((f64::from(at) - 1e6 / f64::sqrt(v2)).abs() <= 1.0);
    for c in take(&mut motion, 30_000) {
        v2 += 200.0;
        assert!((f64::from(c) - 1e6 / v2.sqrt()).abs() <= 1.0, "{c}");
    }
    motion.stop();
    assert_eq!(motion.target(), 42_001 + (v2 / 2e4f64 - 0.5).ceil() as i64);
}

/// Fault: c0 is limited to 65,535.
#[test]
fn a_long_first_delay() {
    let mut motion = Motion::new(Rate::from_hz(16_000_000).unwrap(), speed(100), accel(1)).unwrap();
    motion.retarget(2);
    assert_eq!(motion.by_ref().collect::<Vec<_>>(), [0, 15_296_134]); // 0.676 · 16e6 · √2
    motion.retarget(1); // back, from rest
    assert_eq!(motion.by_ref().collect::<Vec<_>>(), [15_296_134]);
}

/// Faults: n = 0 leaves garbage after the last step; the next travel begins with the last delay of
/// this one; the remainder is kept.
#[test]
fn from_travel_to_travel() {
    let mut motion = motion(3_000, 3_000, 2_000);
    let there: Vec<_> = motion.by_ref().collect();
    assert_eq!((motion.next(), motion.next()), (None, None));
    motion.set_accel(accel(70_000)).unwrap(); // at rest, and back again
    motion.set_accel(accel(3_000)).unwrap();
    for target in [1, 2_000] {
        motion.retarget(target);
        let again: Vec<_> = motion.by_ref().collect();
        assert_eq!(again.len(), 1_999); // the very first pulse was where it stood
        assert!(again.iter().zip(&there[1..]).all(|(a, b)| a.abs_diff(*b) <= 1));
    }
}

/// Fault: a fall that begins at the top speed takes its first delay from elsewhere.
#[test]
fn from_the_top_speed() {
    let mut motion = motion(400, 1_000_000, 100_000);
    assert!(take(&mut motion, 50)[1..].iter().all(|c| *c == 2_500));
    motion.set_decel(accel(4_000)).unwrap();
    motion.stop();
    let down: Vec<_> = motion.collect();
    assert!(slows(&down) && (2_500..2_700).contains(&down[0]), "{down:?}");
    assert_eq!(down.len(), 20); // 400² / 2·4000
}

/// Fault: a top speed that is reached in less than a step is exceeded four times over. From a
/// crawl, where Eq 18 makes n < 0, a ramp is as steep as from rest.
#[test]
fn from_a_crawl() {
    for top in [1, 10, 100, 1_000] {
        let mut motion = motion(1, 1_000_000, 1_000);
        take(&mut motion, 3);
        motion.set_top_speed(speed(top)).unwrap();
        motion.set_accel(accel(100_000_000)).unwrap();
        assert!(motion.all(|c| c + 1 >= 1_000_000 / top));
    }
    let mut motion = motion(1, 1_000, 10_000);
    take(&mut motion, 3);
    motion.set_top_speed(speed(1_000)).unwrap();
    let up = take(&mut motion, 505);
    assert_eq!(up[504], 1_000);
    // 1000 steps/s take a second.
    let time: u32 = up.iter().sum();
    assert!((950_000..1_050_000).contains(&time), "{time}");
}

/// Fault: steps times deceleration exceeds 32 bits.
#[test]
fn steps_times_deceleration() {
    let rate = Rate::from_hz(16_000_000).unwrap();
    let mut motion = Motion::new(rate, speed(100_000), accel(5_000_000)).unwrap();
    motion.retarget(i32::MAX);
    assert_eq!(take(&mut motion, 1_100)[1_099], 160);
    for d in [10_000_000, 100_000_000, 5_000] {
        motion.set_decel(accel(d)).unwrap();
        let mut stopped = motion.clone();
        stopped.stop();
        let steps = (1e10 / f64::from(2 * d) - 0.5).ceil() as i64;
        assert_eq!(stopped.target() - stopped.position(), steps);
        assert_eq!(stopped.by_ref().count() as i64, steps);
        assert_eq!(motion.next(), Some(160)); // far from the end
    }
}

/// Any values in any order: no panic, no delay of 0 within a travel, no step too many.
#[test]
fn extremes() {
    let speeds = [1, 20_000, 1_000_000_000].map(|v| Speed::from_millisteps(v).unwrap());
    let accels = [1, 5_000, 400_000, 100_000_000_000].map(|a| Accel::from_millisteps(a).unwrap());
    let (mut held, mut refused) = (0, 0);
    for hz in [100_000, 1_000_000, 200_000_000] {
        let rate = Rate::from_hz(hz).unwrap();
        for (n, top) in speeds.iter().enumerate() {
            for accel in accels {
                let Ok(mut motion) = Motion::new(rate, *top, accel) else {
                    refused += 1;
                    continue;
                };
                held += 1;
                for (i, target) in [i32::MAX, i32::MIN, 3, 0, -1, i32::MAX].into_iter().enumerate()
                {
                    motion.retarget(target);
                    for decel in accels {
                        let _ = motion.set_decel(decel);
                        let first = i == 0 && motion.position() == 0;
                        let delays = take(&mut motion, 50);
                        assert!(delays.iter().skip(first.into()).all(|c| *c > 0));
                        let _ = motion.set_accel(accels[(i + n) % 4]);
                        let _ = motion.set_top_speed(speeds[(i + n) % 3]);
                        assert!(motion.speed() <= Speed::MAX);
                    }
                }
                motion.stop();
                let ahead = motion.target().abs_diff(motion.position());
                let pulses = motion.by_ref().take(10_000).count() as u64;
                assert_eq!(pulses, ahead.min(10_000), "{hz} {top} {accel:?}");
            }
        }
    }
    assert!(held >= 20 && refused >= 4, "{held} {refused}");
}
