//! The firmware whose law runs in the step interrupt: each edge against the
//! law's own times, which the host computes with the same Rust. The chip's are
//! assembly.

mod common;

use common::{BESIDE, LATENCY, rest, say, steps, talk};
use stepwright::direct::{Direct, Ramp as Law};
use stepwright::profile::Ramp;
use stepwright::queue::{Feed, Taken};
use stepwright::{Accel, Order, Speed, Travel};
use stepwright_rig::Chip;
use stepwright_rig::edges::Step;

fn chip() -> Chip {
    common::program("direct")
}

/// The law of an order in steps/s and steps/s².
fn law(start: u32, top: u32, accel: u32, count: i32) -> Law {
    let ramp = Ramp::Accel(Accel::from_steps(accel).unwrap());
    let order = Order {
        start: Speed::from_steps(start).unwrap(),
        top: Speed::from_steps(top).unwrap(),
        up: ramp,
        down: ramp,
        jerk: None,
        travel: Travel::By(count),
    };
    Law::of(common::rate(), &order).unwrap()
}

/// When its pulses come, in cycles after the first.
fn times(law: Law) -> Vec<u64> {
    let mut feed = Direct::IDLE;
    feed.begin(true, 0, 1, law);
    let mut time = 0;
    let mut times = Vec::new();
    while let Taken::Run(run) = feed.take() {
        if run.count() == 1 {
            time += run.interval();
            times.push(time >> 16);
        }
    }
    times.iter().map(|time| time - times[0]).collect()
}

#[track_caller]
fn follows(steps: &[Step], times: &[u64], slack: i64) {
    assert_eq!(steps.len(), times.len(), "steps");
    if steps.is_empty() {
        return;
    }
    let off = |n: usize| (steps[n].time - steps[0].time) as i64 - times[n] as i64;
    let worst = (0..steps.len()).max_by_key(|&n| off(n).abs()).unwrap();
    assert!(off(worst).abs() <= slack, "step {worst} is {} cycles off", off(worst));
}

#[test]
fn every_edge_is_the_laws() {
    let mut chip = chip();
    for (start, top, accel, count) in [
        (0, 1_000, 2_000, 3_000), // quotients of 22 bits down to 9
        (0, 20_000, 40_000, 25_000),
        (0, 40_000, 40_000, 45_000), // … of 2
        (0, 30_000, 200_000, 9_000),
        (0, 30_000, 20_000, 3_001), // the top speed is out of reach
        (0, 900, 100_000, 200),     // reached within three steps
        (300, 5_000, 9_000, 4_000),
        (800, 700, 100, 100), // no ramp
    ] {
        chip.take_edges();
        say(&mut chip, &format!("PO s{start} t{top} a{accel} d{accel} G-{count} E"));
        assert!(chip.run_to_silence(8_000_000, 16_000_000 * 30));
        follows(&steps(&chip, 0), &times(law(start, top, accel, count)), LATENCY);
        rest(&mut chip);
    }
    assert!(chip.ask("?").unwrap().contains(" late=0 "));
}

#[test]
fn no_steps_one_two_and_three() {
    let mut chip = chip();
    for count in 0..4 {
        chip.take_edges();
        say(&mut chip, &format!("PO s0 t5000 a10000 d10000 G+{count} E"));
        rest(&mut chip);
        let times = times(law(0, 5_000, 10_000, count));
        follows(&steps(&chip, 0), &times[..count as usize], LATENCY);
    }
    chip.expect("V1", "6");
}

#[test]
fn nothing_in_the_foreground_holds_a_step_up() {
    let mut chip = chip();
    say(&mut chip, "PO s0 t38000 a40000 d40000 G+60000 E");
    chip.poll(&["V1", "F"]);
    chip.run_for(16_000_000);
    chip.poll(&[]);
    chip.run_for(8_000_000);
    rest(&mut chip);
    follows(&steps(&chip, 0), &times(law(0, 38_000, 40_000, 60_000)), LATENCY + 200);
    chip.expect("V1", "60000");
    assert!(chip.ask("?").unwrap().contains(" late=0 "));
}

#[test]
fn it_brakes_along_its_ramp_and_knows_where_it_is() {
    let mut chip = chip();
    let mut position = 0;
    for g in ["g+", "g-", "G+2147483647", "G-2147483647"] {
        chip.take_edges();
        say(&mut chip, &format!("PO s0 t9000 a20000 d20000 {g} E"));
        chip.run_for(16_000_000);
        chip.expect("Z", "Y");
        chip.expect("F", "B");
        rest(&mut chip);
        let made = steps(&chip, 0);
        // Half a second of ramp, half of level, as long a ramp down.
        let full = 9_000 * 9_000 / 40_000;
        assert!((2 * full + 4_000..2 * full + 6_000).contains(&made.len()), "{}", made.len());
        let way = made.len() as i64;
        position += if g.contains('+') { way } else { -way };
        chip.expect("V1", &position.to_string());
    }
}

#[test]
fn three_axes_each_on_its_own_ramp() {
    let mut chip = chip();
    say(&mut chip, "PO A1 s0 t2000 a5000 d5000 G+3000");
    say(&mut chip, "A2 s0 t1500 a9000 d9000 G-2000 A3 s0 t900 a2000 d2000 G+1000 E");
    assert!(chip.run_to_silence(8_000_000, 16_000_000 * 30));
    follows(&steps(&chip, 0), &times(law(0, 2_000, 5_000, 3_000)), 3 * BESIDE);
    follows(&steps(&chip, 1), &times(law(0, 1_500, 9_000, 2_000)), 3 * BESIDE);
    follows(&steps(&chip, 2), &times(law(0, 900, 2_000, 1_000)), 3 * BESIDE);
    rest(&mut chip);
    talk(&mut chip, "V1 3000\nV2 -2000\nV3 1000");
}

#[test]
fn what_it_cannot_do_it_refuses() {
    let mut chip = chip();
    talk(&mut chip, "PO Y\ns0 Y\nt1000 Y\na1000 Y\nd2000 Y\nG+100 Y\nE E\n? *ramp uncertain=0*");
    talk(&mut chip, "PO Y\nd1000 Y\nt60000 Y\nG+100 Y\nE E\n? *too-fast uncertain=0*");
    talk(&mut chip, "$ E\nF R\nV1 0\nPO Y\nt30000 Y\nG+10000 Y\nE Y\nF B");
    talk(&mut chip, "K Y\nF R\nV1 E\nI1 Y\nV1 0");
    assert!(steps(&chip, 0).len() < 10_000);
}
