//! Ramps for which planning is fast enough, and those for which it is not, which are refused.

use crate::common::{board, chip, image, rest, say, steps};
use stepwright_rig::Board;

#[test]
fn a_ramp_too_steep_to_plan_is_refused() {
    for (accel, count) in [(1_000_000, 30), (2_000_000, 60), (3_000_000, 60)] {
        let mut chip = chip();
        say(&mut chip, &format!("PO s0 t30000 a{accel} d{accel} G-{count}"));
        chip.expect("E", "E");
        assert!(chip.ask("?").unwrap().contains(" last=too-steep "));
        assert!(steps(&chip, 0).is_empty());
        // Refused during motion too: the travel continues unchanged.
        say(&mut chip, "PO s0 t30000 a20000 d20000 G-9000 E");
        chip.run_for(2_000_000);
        chip.expect(&format!("a{accel}"), "E");
        assert!(chip.ask("?").unwrap().contains(" last=too-steep "));
        rest(&mut chip);
        assert_eq!(steps(&chip, 0).last().unwrap().position, -9_000);
        assert!(chip.ask("?").unwrap().contains(" late=0 "));
    }
}

/// The queue holds the whole travel.
#[test]
fn a_steep_ramp_of_a_few_steps_is_on_time() {
    for count in [1, 2, 4, 6] {
        let mut chip = chip();
        say(&mut chip, &format!("PO s0 t30000 a2000000 d2000000 G+{count} E"));
        rest(&mut chip);
        chip.expect("V1", &count.to_string());
        assert!(chip.ask("?").unwrap().contains(" late=0 "), "{count} steps");
    }
}

#[test]
fn half_as_steep_a_ramp_is_on_time() {
    let mut chip = chip();
    for count in [10, 30, 60, 100] {
        say(&mut chip, &format!("PO s0 t30000 a500000 d500000 G+{count} E"));
        rest(&mut chip);
    }
    chip.expect("V1", "200");
    assert!(chip.ask("?").unwrap().contains(" late=0 "));
}

/// At 123,733 steps/s runs of 1, 2, 4 … steps would be over before the next are planned, so such a
/// travel begins with a longer one. Whatever the host queries at the beginning.
#[test]
fn a_travel_that_starts_fast_is_on_time() {
    if board() == Board::Mega {
        // Its step interrupt is slower.
        return;
    }
    for phase in 0..20 {
        let mut chip = chip();
        say(&mut chip, "PO m123733722 s123733 G-1883 E");
        chip.run_for(11_000 + 100 * phase);
        chip.send("V1\r".repeat(20).as_bytes());
        chip.run_for(16_000 * 60);
        // More than the board keeps: the rest of them ends here.
        chip.poll(&[]);
        chip.ask("");
        rest(&mut chip);
        assert!(chip.ask("?").unwrap().contains(" late=0 "), "phase {phase}");
    }
}

/// Code that waits for 4·`rounds` cycles and some 20 more, then goes to `next`.
fn delay(rounds: u16, next: u32) -> Vec<u8> {
    let load = |register: u16, byte: u8| {
        let byte = u16::from(byte);
        0xE000 | (byte & 0xF0) << 4 | (register - 16) << 4 | byte & 0x0F
    };
    let [low, high] = rounds.to_le_bytes();
    let words = [
        0x938F, // push r24
        0x939F, // push r25
        0xB78F, // in r24, SREG
        0x938F, // push r24
        load(24, low),
        load(25, high),
        0x9701, // sbiw r24, 1
        0xF7F1, // brne to there
        0x918F, // pop r24
        0xBF8F, // out SREG, r24
        0x919F, // pop r25
        0x918F, // pop r24
    ];
    words.into_iter().chain(jump(next)).flat_map(u16::to_le_bytes).collect()
}

/// A jump to an address in bytes.
fn jump(to: u32) -> [u16; 2] {
    [0x940C | (to >> 17) as u16, (to / 2) as u16]
}

/// Code that occupies the processor for too long makes a step late. A step is late if less than
/// half an interval and 1 µs are left to the next one, and counts once; the following steps keep
/// their times.
#[test]
fn each_late_step_counts_once() {
    // After the largest program for which a boot loader leaves room.
    let (image, free) = (image(), board().flash() as u32 - 0x100);
    let (vector, handler) = match board() {
        Board::Uno => (11, image.function("__vector_11").0),
        Board::Mega => (17, image.function("__vector_17").0),
    };
    let aside = jump(free).map(u16::to_le_bytes).concat();
    let interval = 3_200;
    let mut late = 0;
    let mut chip = chip();
    say(&mut chip, "s5000 t5000 g+");
    chip.run_for(400_000);
    // In 1/10 of an interval, and whether that is late.
    for (tenths, is_late) in [(2, false), (4, false), (6, true), (8, true)] {
        let (from, now) = (steps(&chip, 0).len(), chip.now());
        while steps(&chip, 0).len() == from {
            chip.run_for(20);
        }
        chip.set_code(free, &delay((interval * tenths / 10 / 4) as u16, handler));
        let was = chip.set_code(4 * vector, &aside);
        chip.run_for(interval);
        chip.set_code(4 * vector, &was);
        chip.run_for(100_000);
        let times: Vec<_> = steps(&chip, 0)[from..].iter().map(|step| step.time).collect();
        let beside = times.windows(2).map(|pair| pair[1] - pair[0]);
        let slow: Vec<_> = beside.filter(|ticks| ticks.abs_diff(interval) > 150).collect();
        assert!(slow.len() == 2, "{tenths}: one came {slow:?}, from {now}");
        assert!(slow[0].abs_diff(interval + interval * tenths / 10) < 100, "{tenths}: {slow:?}");
        let both = (slow[0] + slow[1]).abs_diff(2 * interval);
        assert!(both < 10, "{tenths}: what follows keeps its time, {slow:?}");
        late += u32::from(is_late);
        assert!(chip.ask("?").unwrap().contains(&format!(" late={late} ")), "{tenths}");
    }
    say(&mut chip, "Z");
    rest(&mut chip);
    chip.expect("V1", &steps(&chip, 0).len().to_string());
}
