extern crate std;
use super::*;
use crate::profile::Fit;
use crate::units::Rate;

/// A long ramp ends when the closed form says: no run loses a part of a
/// tick for good.
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
        let order =
            Order { start: Speed::ZERO, top, up: ramp, down: ramp, travel: Travel::Endless(true) };
        let mut planner = Planner::IDLE;
        planner.lay_out(&clock, &order).unwrap();
        let steps = planner.rise;
        let (mut work, mut run) = (Work::NONE, Run::steady(0, 0));
        let mut time = 0u64;
        while planner.rise > 0 {
            if let Planned::Run(_) = planner.next(&clock, &mut work, &mut run) {
                time += run.duration();
            }
        }
        let (a, n) = (accel as f64 / 1e3, f64::from(steps));
        let want = (2.0 * n / a).sqrt() * f64::from(hz);
        let off = time as f64 / 65536.0 - want;
        assert!(off.abs() <= want * 2f64.powi(-29) + 0.5, "{off} of {want}");
    }
}

/// A piece ends in as few runs as it can: a level in two of one length, a ramp
/// with what is no multiple of 32 by itself.
#[test]
fn the_end_of_a_piece_is_shared() {
    let runs = |share: fn(u32, u32) -> u32, mut room: u32| {
        let mut runs = std::vec::Vec::new();
        while room > 0 {
            let steps = share(room, 256);
            assert!((1..=256).contains(&steps), "{steps} of {room}");
            runs.push(steps);
            room -= steps;
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
