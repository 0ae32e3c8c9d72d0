//! Every travel's count, ramp and rest, from the edges of the real binary.

use crate::common::{
    BESIDE, FIT, LATENCY, chip, follows, path_of_accel, path_of_steps, rest, say, steps,
};

#[test]
fn ramps_in_steps_follow_the_closed_form() {
    let mut chip = chip();
    // Start and top speed in 10 steps/s, ramp, steps: with and without a cruise, from the slowest
    // to the fastest of the Nano slave.
    let orders = [
        (1, 1, 1, 3),
        (5, 100, 200, 4000),
        (5, 100, 200, 300),
        (2, 500, 999, 2500),
        (100, 50, 10, 100),
        (20, 999, 999, 2000),
    ];
    for (start, top, ramp, count) in orders {
        chip.take_edges();
        say(&mut chip, &format!("PO S{start} T{top} R{ramp} G+{count} E"));
        // In silence: only the step interrupt runs.
        assert!(chip.run_to_silence(4_000_000, 16_000_000 * 20));
        let path = path_of_steps(10 * start, 10 * top, ramp, count);
        follows(&steps(&chip, 0), &path, FIT + LATENCY);
        rest(&mut chip);
    }
    let sum: i64 = orders.iter().map(|order| i64::from(order.3)).sum();
    chip.expect("V1", &sum.to_string());
}

#[test]
fn ramps_in_steps_per_second_squared_follow_the_closed_form() {
    let mut chip = chip();
    for (start, top, accel, count) in [
        (0, 4_000, 10_000, 4_000),
        (0, 20_000, 40_000, 20_000),
        (0, 20_000, 20_000, 300),
        (0, 200, 100, 200),
        (0, 5_000, 500_000, 50),
    ] {
        chip.take_edges();
        let order = format!("PO s{start} t{top} a{accel} d{accel} G-{count} E");
        say(&mut chip, &order);
        assert!(chip.run_to_silence(8_000_000, 16_000_000 * 30));
        let path = path_of_accel(start, top, accel, count);
        follows(&steps(&chip, 0), &path, FIT + LATENCY);
        let backward = steps(&chip, 0).windows(2).all(|s| s[1].position == s[0].position - 1);
        assert!(backward, "{order} went forward");
        rest(&mut chip);
    }
    assert!(chip.ask("?").unwrap().contains(" late=0 "));
}

#[test]
fn three_axes_at_once_each_on_its_own_curve() {
    let mut chip = chip();
    say(&mut chip, "PO A1 t2000 a5000 d5000 G+3000");
    say(&mut chip, "A2 t3000 a9000 d9000 G-4000");
    say(&mut chip, "A3 t777 a1234 d1234 G+500 E");
    assert!(chip.run_to_silence(4_000_000, 16_000_000 * 20));
    for (axis, top, accel, count) in
        [(0, 2_000, 5_000, 3_000), (1, 3_000, 9_000, 4_000), (2, 777, 1_234, 500)]
    {
        // Each begins at the 50 steps/s of power-up. A step of one or two other axes may delay it.
        let path = path_of_accel(50, top, accel, count);
        follows(&steps(&chip, axis), &path, FIT + BESIDE);
    }
    say(&mut chip, "A0");
    rest(&mut chip);
    chip.expect("V1", "3000");
    chip.expect("V2", "-4000");
    chip.expect("V3", "500");
    assert!(chip.ask("?").unwrap().contains(" late=0 "));
}

#[test]
fn an_axis_starts_while_another_one_runs() {
    let mut chip = chip();
    say(&mut chip, "A1 PO T100 G+1500 E");
    chip.run_for(4_000_000);
    say(&mut chip, "A2 PO A2 T80 G-600 E A0");
    rest(&mut chip);
    let (x, y) = (steps(&chip, 0), steps(&chip, 1));
    follows(&x, &path_of_steps(50, 1000, 200, 1500), FIT + BESIDE);
    follows(&y, &path_of_steps(50, 800, 200, 600), FIT + BESIDE);
    assert!(y[0].time > x[50].time && y[0].time < x[1499].time);
}

#[test]
fn serial_traffic_without_a_pause_disturbs_no_step() {
    let mut chip = chip();
    say(&mut chip, "PO t5000 a20000 d20000 G+12000 E");
    chip.poll(&["V1", "F"]);
    chip.run_for(16_000_000 * 4);
    chip.poll(&[]);
    chip.run_for(1_000_000);
    chip.take_said();
    // A pair of lines and answers is some 12 bytes: over 900 a second.
    assert!(chip.polled() > 4 * 900, "{} answers", chip.polled());
    assert_eq!(chip.lost(), 0);
    follows(&steps(&chip, 0), &path_of_accel(50, 5_000, 20_000, 12_000), FIT + LATENCY);
    rest(&mut chip);
    chip.expect("V1", "12000");
    assert!(chip.ask("?").unwrap().contains(" late=0 "));
}

#[test]
fn the_position_on_the_way_is_the_edges() {
    let mut chip = chip();
    say(&mut chip, "PO T300 R500 G-5000 E");
    for _ in 0..40 {
        chip.run_for(700_000);
        let before = steps(&chip, 0).last().map_or(0, |step| step.position);
        let said: i64 = chip.ask("V1").unwrap().parse().unwrap();
        let after = steps(&chip, 0).last().map_or(0, |step| step.position);
        assert!(after <= said && said <= before, "{said} is not in {after} ..= {before}");
    }
    rest(&mut chip);
}

/// A compare match that occurs while the order is started belongs to none of its steps: whenever
/// the order comes, its first step waits for its time.
#[test]
fn no_first_step_is_early_in_any_phase_of_the_timer() {
    let mut chip = chip();
    say(&mut chip, "PO S20 T20 R1 G+3 E");
    rest(&mut chip);
    for phase in 0..100 {
        chip.take_edges();
        chip.run_for(phase * 331);
        say(&mut chip, "PO G+3 E");
        rest(&mut chip);
        follows(&steps(&chip, 0), &path_of_steps(200, 200, 1, 3), FIT + LATENCY);
    }
}
