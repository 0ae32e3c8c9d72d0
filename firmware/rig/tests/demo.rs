//! The demo of Austin's article on the chip: the published listing's delays, there and back, on
//! step and direction, an L6219 in full, half and quarter steps, a unipolar motor and a shield's
//! bridges.

use stepwright::drive::Sequence;
use stepwright::drive::sequence::{L6219_FULL, L6219_HALF, L6219_QUARTER, SHIELD, UNIPOLAR_HALF};
use stepwright_austin::Fixed;
use stepwright_rig::board::Pin;
use stepwright_rig::{Board, Chip, firmware};

use crate::common::board;

const MILLIS: u64 = 16_000;
/// The largest difference between an edge and the host's delays, in cycles: there is no other
/// interrupt.
const EDGE: u64 = 20;

/// The levels from each change to the next; `before` first.
fn levels(changes: &[(u64, u8, bool)]) -> Vec<(u64, u8)> {
    let (mut all, mut now): (Vec<(u64, u8)>, u8) = (Vec::new(), 0);
    for (time, which, level) in changes {
        now = if *level { now | 1 << which } else { now & !(1 << which) };
        match all.last_mut() {
            Some(last) if last.0 == *time => last.1 = now,
            _ => all.push((*time, now)),
        }
    }
    all
}

/// The times of the steps, from the first.
fn times() -> Vec<u64> {
    let mut time = 0;
    let delays = Fixed::new(1_000, 50_000, 2_500);
    delays
        .map(|delay| {
            time += u64::from(delay) * 16;
            time
        })
        .collect()
}

#[track_caller]
fn compare(real: &[u64], wanted: &[u64], what: &str) {
    assert_eq!(real.len(), wanted.len(), "{what}");
    let off = real.iter().zip(wanted).map(|(r, w)| (r - real[0]).abs_diff(w - wanted[0])).max();
    println!("{what}: {} steps, {} cycles", real.len(), off.unwrap());
    assert!(off.unwrap() <= EDGE, "{what}: {off:?} cycles");
}

#[test]
fn the_articles_demo_on_six_drives() {
    let board = board();
    let image = firmware::load(&format!("{}-demo", board.name()));
    let mut chip = Chip::new(board, &image.unwrap_or_else(|error| panic!("{error:#}")));
    let (port, step, direction) = match board {
        Board::Uno => ('B', Pin('D', 2), Pin('D', 5)),
        _ => ('A', Pin('C', 1), Pin('C', 2)),
    };
    let mut pins: Vec<Pin> = (0..6).map(|bit| Pin(port, bit)).collect();
    pins.extend([step, direction]);
    chip.watch_pins(&pins);
    // Six drives, twice some three seconds each.
    chip.run_for(45_000 * MILLIS);
    let changes = chip.watched_changes().to_vec();
    let wanted = times();
    assert_eq!(wanted.len(), 1_000);

    // Step and direction: DIR well before the first step, pulses of at least 2 µs.
    let rises: Vec<u64> =
        changes.iter().filter(|(_, pin, level)| *pin == 6 && *level).map(|c| c.0).collect();
    let falls = changes.iter().filter(|(_, pin, level)| *pin == 6 && !*level).map(|c| c.0);
    assert!(rises.iter().zip(falls).all(|(rise, fall)| (32..100).contains(&(fall - rise))));
    let turns: Vec<_> = changes.iter().filter(|(_, pin, _)| *pin == 7).collect();
    assert!(turns.len() == 2 && turns[0].2 && !turns[1].2, "{turns:?}");
    assert!(turns[0].0 < rises[0] && (rises[999]..rises[1_000]).contains(&turns[1].0));
    compare(&rises[..1_000], &wanted, "step and direction, there");
    compare(&rises[1_000..], &wanted, "step and direction, back");

    // Windings: on, 1,000 steps through the table, off; and back.
    let windings: Vec<_> = changes.iter().filter(|change| change.1 < 6).copied().collect();
    let windings = levels(&windings);
    let mut rest = &windings[..];
    let tables: [(&str, Sequence, u8); 5] = [
        ("L6219, full steps", L6219_FULL, 0b11_1111),
        ("L6219, half steps", L6219_HALF, 0b11_1111),
        ("L6219, quarter steps", L6219_QUARTER, 0b11_1111),
        ("unipolar, half steps", UNIPOLAR_HALF, 0b1111),
        ("motor shield", SHIELD, 0b11),
    ];
    for (name, sequence, mask) in tables {
        let mut phase = 0;
        for forward in [true, false] {
            let mut table = Vec::new();
            for _ in 0..1_000 {
                phase = sequence.after(phase, forward);
                table.push(sequence.levels(phase));
            }
            // The current comes on at a row, once the previous lines have been released.
            let begin = rest
                .windows(2)
                .position(|pair| pair[1].0 - pair[0].0 > 15_000 && pair[1].1 & mask == table[0])
                .unwrap_or_else(|| panic!("{name}: no first step"));
            let steps = &rest[begin + 1..begin + 1_001];
            let got: Vec<u8> = steps.iter().map(|(_, levels)| levels & mask).collect();
            assert_eq!(got, table, "{name}");
            let real: Vec<u64> = steps.iter().map(|(time, _)| *time).collect();
            compare(&real, &wanted, name);
            // The last interval again, then off, which is also a shield's first row.
            if table[999] != sequence.off() & mask {
                let off = rest[begin + 1_001];
                assert_eq!(off.1 & mask, sequence.off() & mask, "{name}");
                let (settled, last) = (off.0 - real[999], wanted[999] - wanted[998]);
                assert!(settled.abs_diff(last) <= 2 * EDGE, "{name}: {settled}, not {last}");
            }
            rest = &rest[begin + 1_000..];
        }
        assert_eq!(phase, 0, "{name}: there and back");
    }
}
