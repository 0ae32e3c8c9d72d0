//! Changes during a travel, on the real binary: compared with the virtual board, edge by edge.
//!
//! The moment at which a change takes effect depends on what was planned when its line came. A chip
//! needs time for a line and for planning, the virtual board none. So the virtual board gets the
//! change at several moments near that of the chip, and at one of them every edge must be the
//! chip's. Legs are compared from their first step on, because a leg after a turn begins when the
//! foreground reaches it.

use crate::common::{self, LATENCY, board, chip, rest, say, steps};
use stepwright_rig::edges::Step;
use stepwright_rig::{Board, Chip};
use stepwright_sim::{Description, Edge, Pin, Queues, VirtualBoard};

/// The steps of axis 1 of a virtual Uno, which gets `order` at once and `change` this many cycles
/// after its first step.
fn virtual_steps(order: &str, change: &str, after: u64) -> Vec<Step> {
    let mut queues = Queues::default();
    let mut board: VirtualBoard<u16, Vec<Edge>> =
        VirtualBoard::new(&mut queues, Description::uno(), Vec::new());
    let tell = |board: &mut VirtualBoard<u16, Vec<Edge>>, lines: &str| {
        for line in lines.split_whitespace() {
            line.bytes().chain([b'\r']).for_each(|byte| board.receive(byte));
        }
    };
    tell(&mut board, order);
    while board.recorder().iter().all(|edge| !edge.is_step()) {
        board.run_until(board.now() + 1_000);
    }
    let first = board.recorder().iter().find(|edge| edge.is_step()).map_or(0, |edge| edge.time);
    board.run_until(first + after);
    tell(&mut board, change);
    assert!(board.take_answers().chunks(2).all(|answer| answer == b"Y\r"), "{change}");
    board.run_to_rest();
    let (mut forward, mut position, mut steps) = (true, 0, Vec::new());
    for edge in board.recorder().iter().filter(|edge| edge.axis == 0) {
        match edge.pin {
            Pin::Direction => forward = edge.level,
            Pin::Step if edge.level => {
                position += if forward { 1 } else { -1 };
                steps.push(Step { time: edge.time, position });
            }
            _ => {}
        }
    }
    steps
}

/// The largest distance of corresponding steps, in cycles; each leg from its first step on. `None`
/// if the steps differ.
fn apart(real: &[Step], ideal: &[Step]) -> Option<i64> {
    let same = |(a, b): (&Step, &Step)| a.position == b.position;
    if real.len() != ideal.len() || !real.iter().zip(ideal).all(same) {
        return None;
    }
    let (mut first, mut worst) = (0, 0);
    for n in 1..real.len() {
        let turned = n > 1 && real[n].position == real[n - 2].position;
        if turned {
            first = n;
        }
        let passed = |steps: &[Step]| (steps[n].time - steps[first].time) as i64;
        worst = worst.max((passed(real) - passed(ideal)).abs());
    }
    Some(worst)
}

/// Sends the order, and this many cycles later the change. Returns the last position.
#[track_caller]
fn changed(order: &str, wait: u64, change: &str) -> (Chip, i64) {
    let mut chip = chip();
    say(&mut chip, order);
    chip.run_for(wait);
    say(&mut chip, change);
    let told = chip.now();
    rest(&mut chip);
    let real = steps(&chip, 0);
    let told = told - real[0].time;
    // The line was received before its answer was sent: at 115,200 baud some 90 µs a byte. The
    // virtual board is fed as often as it polls.
    let tries = (0..160).map(|n| (told + 40_000).saturating_sub(n * 2_000));
    let best = tries.filter_map(|at| apart(&real, &virtual_steps(order, change, at))).min();
    let best = best.expect("no moment makes the virtual board do the same");
    assert!(best <= LATENCY, "{order} {change}: {best} cycles apart");
    let end = real.last().unwrap().position;
    chip.expect("V1", &end.to_string());
    assert!(chip.ask("?").unwrap().contains(" late=0 "));
    (chip, end)
}

const ORDER: &str = "PO s0 t4000 a10000 d10000 G+4000 E";

#[test]
fn a_target_further_on() {
    for wait in [1_000_000, 6_000_000, 17_000_000] {
        assert_eq!(changed(ORDER, wait, "@+5000").1, 5_000);
    }
}

#[test]
fn a_target_nearer() {
    assert_eq!(changed(ORDER, 6_000_000, "@+2500").1, 2_500);
}

#[test]
fn a_target_behind_through_rest() {
    for wait in [1_000_000, 8_000_000] {
        assert_eq!(changed(ORDER, wait, "@-300").1, -300);
    }
    // Too near to stop in time: beyond it, and back.
    let (chip, end) = changed(ORDER, 8_000_000, "@+1500");
    assert_eq!(end, 1_500);
    let most = steps(&chip, 0).iter().map(|step| step.position).max().unwrap();
    assert!(most > 2_000, "{most}");
}

#[test]
fn another_speed_and_ramp() {
    assert_eq!(changed(ORDER, 7_000_000, "t1500").1, 4_000);
    assert_eq!(changed(ORDER, 7_000_000, "t9000").1, 4_000);
    assert_eq!(changed(ORDER, 3_000_000, "a3000").1, 4_000);
    assert_eq!(changed(ORDER, 7_000_000, "d5000").1, 4_000);
}

#[test]
fn an_endless_travel_gets_a_target() {
    assert_eq!(changed("s0 t3000 a8000 d8000 g-", 9_000_000, "@-2500").1, -2_500);
}

#[test]
fn what_can_not_be_is_refused_with_its_reason_and_nothing_changes() {
    let mut chip = chip();
    chip.expect("@+5", "E");
    assert!(chip.ask("?").unwrap().contains("last=no-travel"));
    say(&mut chip, "$max-speed=5000 PO s100 t4000 a10000 d10000 G+4000 E");
    chip.run_for(6_000_000);
    chip.expect("t5001", "E");
    assert!(chip.ask("?").unwrap().contains("last=too-fast"));
    chip.expect("t99", "E");
    assert!(chip.ask("?").unwrap().contains("last=too-slow"));
    chip.expect("S20", "E");
    rest(&mut chip);
    let path = common::path_of_accel(100, 4_000, 10_000, 4_000);
    common::follows(&steps(&chip, 0), &path, common::FIT + LATENCY);
}

// ---- S-curves ----

const CURVE: &str = "PO s0 t4000 a15000 d15000 j200000 G+4000 E";

#[test]
fn an_s_curve_and_changes_on_it() {
    if board() != Board::Mega {
        return;
    }
    let ends = |order, wait, change| changed(order, wait, change).1;
    assert_eq!(ends(CURVE, 10_000_000, "@+6000"), 6_000);
    assert_eq!(ends(CURVE, 2_000_000, "t1500"), 4_000);
    assert_eq!(ends(CURVE, 8_000_000, "t1500"), 4_000);
    assert_eq!(ends(CURVE, 3_000_000, "a3000"), 4_000);
    assert_eq!(ends(CURVE, 6_000_000, "@-300"), -300);
    let end = ends("s0 t3000 a15000 d9000 j300000 g-", 9_000_000, "Z");
    assert!((-3_000..-500).contains(&end), "{end}");
}

#[test]
fn without_a_jerk_its_ramps_are_straight() {
    for (start, top, accel, steps) in
        [(0, 4_000, 10_000, 4_000), (100, 2_000, 3_000, 500), (50, 10_000, 100_000, 5_000)]
    {
        let mut chip = chip();
        say(&mut chip, &format!("PO s{start} t{top} a{accel} d{accel} G+{steps} E"));
        rest(&mut chip);
        let path = common::path_of_accel(start, top, accel, steps);
        common::follows(&common::steps(&chip, 0), &path, common::FIT + LATENCY);
        assert!(chip.ask("?").unwrap().contains(" late=0 "));
    }
    // A change takes effect at the next whole step.
    let mut chip = chip();
    say(&mut chip, ORDER);
    chip.run_for(6_000_000);
    say(&mut chip, "@+6000 t3000");
    rest(&mut chip);
    assert_eq!(common::steps(&chip, 0).last().unwrap().position, 6_000);
}

#[test]
fn a_board_says_whether_it_has_s_curves() {
    let mut chip = chip();
    chip.expect("$law", "law=1");
    say(&mut chip, "PO s0 t1000 a5000 d5000");
    let (answer, can) = match board() {
        Board::Mega => ("Y", " can=jerk,safety,sum"),
        _ => ("E", " can=safety,sum"),
    };
    // The line itself is refused, and so is the order without it.
    chip.expect("j200000", answer);
    chip.expect("G+100", "Y");
    chip.expect("E", answer);
    let said = chip.ask("?").unwrap();
    assert!(said.contains(can) && said.contains(" last=no-jerk ") == (answer == "E"), "{said}");
}

/// With bends of 50 ms, under any traffic.
#[test]
fn s_curves_that_are_admitted_are_on_time() {
    if board() != Board::Mega {
        return;
    }
    for (axes, top, accel) in
        [(1, 50_000_u32, 16_000_u32), (2, 1_000, 3_500), (2, 30_000, 3_500), (3, 3_000, 1_000)]
    {
        for traffic in [&[][..], &["?"], &["V1", "F"]] {
            let mut chip = chip();
            let (jerk, way) = (20 * accel, (u64::from(top).pow(2) / u64::from(accel)) as u32 + top);
            say(&mut chip, "PO");
            for axis in 1..=axes {
                say(&mut chip, &format!("A{axis} s0 t{top} a{accel} d{accel} j{jerk} G+{way}"));
            }
            say(&mut chip, "E");
            chip.poll(traffic);
            chip.run_for(24_000_000);
            chip.poll(&[]);
            chip.run_for(1_600_000);
            rest(&mut chip);
            let said = chip.ask("?").unwrap();
            assert!(said.contains(" late=0 "), "{axes} axes to {top} steps/s: {said}");
            for axis in 0..axes {
                assert_eq!(steps(&chip, axis).last().unwrap().position, i64::from(way));
            }
        }
    }
}

/// Nothing is planned while a line is obeyed: a new target behind all three axes takes no more time
/// than three changes of a straight ramp.
#[test]
fn a_target_of_three_s_curves_takes_less_than_a_quarter_of_what_is_queued() {
    if board() != Board::Mega {
        return;
    }
    let mut chip = chip();
    say(&mut chip, "PO A0 s50 t900 a400 d400 j10000 g- E");
    chip.run_for(8_000_000);
    let image = common::image();
    let work = image.functions(&["9main_loop4work"]).next().expect("a main loop").address;
    chip.watch_calls(work);
    chip.expect("@+15", "Y");
    let longest = chip.take_calls().into_iter().max().unwrap();
    // 4 ms of 16,000 cycles each.
    assert!(longest < 64_000, "{longest} cycles");
    rest(&mut chip);
    assert!(chip.ask("?").unwrap().contains(" late=0 "));
}

/// Three axes whose bends last only a few steps: two bends and two corners, with a run for each
/// step, were late if something changed soon.
#[test]
fn sharp_bends_of_three_axes_are_on_time_or_refused() {
    if board() != Board::Mega {
        return;
    }
    let stories = [
        ("s494 t520 a190 d190 j1474510", 45_715, "Z"),
        ("s381 t402 a106 d106 j2623120", 16_544, "@+15"),
        ("s410 t927 a37 d37 j299924", 15_145, "t977 Z"),
        ("s535 t583 a189 d189 j663698", 9_961, "Z"),
        ("s1040 t1974 a34 d34 j34357", 32_377, "t2024 Z"),
        ("s3598 t3672 a1029 d1029 j3145036", 53_506, "@+15"),
        // Admitted.
        ("s649 t944 a171 d171 j5815", 20_029, "@+15 Z"),
        ("s0 t1153 a1153 d1153 j2990", 26_287, "@-20 Z"),
    ];
    let mut refused = 0;
    for (order, micros, change) in stories {
        let mut chip = chip();
        say(&mut chip, &format!("PO A0 {order} g-"));
        if chip.ask("E").as_deref() == Some("E") {
            assert!(chip.ask("?").unwrap().contains(" last=too-steep "), "{order}");
            refused += 1;
            continue;
        }
        chip.run_for(16 * micros);
        say(&mut chip, change);
        rest(&mut chip);
        let said = chip.ask("?").unwrap();
        assert!(said.contains(" late=0 "), "{order} {change}: {said}");
    }
    assert_eq!(refused, 6);
}

// ---- several axes at once ----

/// The longest time for which the main loop obeys one of these lines, without interrupts.
fn longest(chip: &mut Chip, lines: &str) -> u64 {
    let image = common::image();
    let work = image.functions(&["9main_loop4work"]).next().expect("a main loop").address;
    chip.watch_calls(work);
    say(chip, lines);
    chip.take_calls().into_iter().max().unwrap()
}

/// While a line is obeyed, no switch is sampled and nothing is planned. It takes longest soon after
/// another change, whose rest is not set up yet.
#[test]
fn a_line_that_changes_three_axes_takes_two_milliseconds() {
    for start in [0, 100] {
        let mut chip = chip();
        say(&mut chip, &format!("PO A0 s{start} t4000 a10000 d10000 G+4000 E"));
        chip.run_for(2_000_000);
        for line in ["t3000", "a9000", "d9000", "@+5000", "@-300", "t3500", "@+100"] {
            let cycles = longest(&mut chip, line);
            assert!(cycles < 36_000, "{line}: {cycles} cycles");
        }
        let cycles = longest(&mut chip, "A1 t3600 a9500 d9500 @+5000 @-300 t3500");
        assert!(cycles < 36_000, "one axis: {cycles} cycles");
        rest(&mut chip);
        assert!(chip.ask("?").unwrap().contains(" late=0 "));
    }
}

/// Near the ramps that three axes may have, most of the queues is empty.
#[test]
fn three_axes_that_change_on_steep_ramps_are_on_time() {
    for accel in [20_000, 25_000] {
        for line in ["t3000", "@-300", "a9000", "d9000"] {
            for wait in [400_000, 600_000, 800_000, 2_500_000] {
                let mut chip = chip();
                say(&mut chip, &format!("PO A0 s0 t20000 a{accel} d{accel} G+20000 E"));
                chip.run_for(wait);
                say(&mut chip, line);
                rest(&mut chip);
                let said = chip.ask("?").unwrap();
                assert!(said.contains(" late=0 "), "{accel} {line} after {wait} cycles: {said}");
            }
        }
    }
}

/// Whenever the contact closes.
#[test]
fn a_switch_stops_its_axis_while_three_axes_change() {
    for line in [&b"d9000\r"[..], b"@-300\r"] {
        for after in (0..100_000).step_by(4_000) {
            let mut chip = chip();
            say(&mut chip, "$switches=1 $switch-forward=1 PO A0 s0 t4000 a10000 d10000 G+4000 E");
            chip.run_for(2_000_000);
            chip.send(line);
            chip.run_for(after);
            chip.press(0, true);
            let pressed = chip.now();
            chip.run_for(1_600_000);
            let last = steps(&chip, 0).last().unwrap().time;
            let late = last.saturating_sub(pressed);
            assert!(late <= 2 * 16_000 + 4_000, "{late} cycles, {after} after the line");
        }
    }
}
