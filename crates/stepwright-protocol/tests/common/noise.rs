//! Lines and half lines, valid and invalid, for the slave to survive.

use crate::common::Random;
use crate::judge::{AXES, remainder};

fn any_line(random: &mut Random) -> String {
    let pick = |random: &mut Random, lines: &[&str]| lines[random.below(lines.len())].to_string();
    let number = |random: &mut Random| match random.below(4) {
        0 => pick(random, &["", "0", "00", "-1", "999", "1000", "1000000", "1000001"]),
        1 => pick(random, &["2147483647", "2147483648", "4294967296", "99999999999999999999"]),
        _ => random.below(1000).to_string(),
    };
    let name = |random: &mut Random| {
        pick(
            random,
            &[
                "pulse-us",
                "idle-ms",
                "max-speed",
                "max-accel",
                "switch-high",
                "law",
                "safe-start",
                "debounce-ms",
                "home-first",
                "estop",
                "reset",
                "pulse",
                "",
            ],
        )
    };
    match random.below(11) {
        10 => match random.below(3) {
            0 => pick(random, &["$", "$reset", "$pulse-us", "$idle-ms=70000", "$$", "$="]),
            1 => format!("${}", name(random)),
            _ => format!("${}={}", name(random), number(random)),
        },
        0 => pick(random, &["PO", "P0", "E", "F", "Z", "K", "?", "!", ""]),
        1 => pick(random, &["g+", "g-", "A0", "A1", "A2", "A3", "A4", "V1", "V2", "I1", "I3"]),
        2 | 3 => {
            pick(random, &["S", "T", "R", "s", "t", "a", "d", "j", "A", "V", "I", "L"])
                + &number(random)
        }
        4 => pick(random, &["G+", "G-", "G", "@+", "@-", "@"]) + &number(random),
        5 | 6 => pick(
            random,
            &["PO", "E", "A2", "A0", "G+5", "L50", "T20", "a7", "t300", "j90", "j0", "$law=0"],
        ),
        _ => pick(random, &["F", "V1", "Z", "g+", "G-9", "PO", "E", "S3", "R10", "@-3"]),
    }
}

/// A valid conversation of a master.
fn sane(random: &mut Random) -> Vec<u8> {
    let mut lines = Vec::new();
    for _ in 0..=random.below(3) {
        lines.push("PO".to_string());
        for _ in 0..=random.below(2) {
            if random.one_in(3) {
                lines.push(format!("A{}", random.below(AXES + 1)));
            }
            for letter in ["S", "T", "R", "s", "t", "a", "d", "j"] {
                if random.one_in(3) {
                    lines.push(format!("{letter}{}", 1 + random.below(999)));
                }
            }
            lines.push(match random.below(4) {
                0 => "g+".into(),
                _ => format!("G{:+}", random.next() as i32 >> random.below(31)),
            });
        }
        lines.push("E".into());
        for _ in 0..random.below(4) {
            lines.push(
                [
                    "F",
                    "V1",
                    "Z",
                    "K",
                    "I1",
                    "?",
                    "A0",
                    "L500",
                    "$max-accel=9999",
                    "$safe-start=1",
                    "$home-first=1",
                    "!",
                    "$",
                    "@+70",
                    "t40",
                    "a9000",
                    "d10000",
                ][random.below(17)]
                .into(),
            );
        }
    }
    let summed = random.one_in(3);
    let tail = |line: &String| match summed {
        true => format!("{line}*{:02X}\r", remainder(line.as_bytes())),
        false => format!("{line}\r"),
    };
    lines.iter().flat_map(|line| tail(line).into_bytes()).collect()
}

fn mutate(random: &mut Random, bytes: &mut Vec<u8>) {
    for _ in 0..random.below(6) {
        let at = random.below(bytes.len().max(1));
        if at >= bytes.len() {
            return;
        }
        match random.below(7) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => drop(bytes.remove(at)),
            2 => bytes.insert(at, random.byte()),
            3 => bytes.insert(at, [b'\r', b'\n', b'E', b'0', b'+'][random.below(5)]),
            4 => bytes.truncate(at),
            5 => bytes.splice(at..at, vec![b'0'; random.below(40)]).for_each(drop),
            _ => {
                let end = (at + random.below(12)).min(bytes.len());
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy).for_each(drop);
            }
        }
    }
}

/// Interleaves two streams on one line, in pieces of a few bytes.
fn interleave(random: &mut Random, a: &[u8], b: &[u8]) -> Vec<u8> {
    let (mut a, mut b, mut mixed) = (a, b, Vec::new());
    while !a.is_empty() || !b.is_empty() {
        let from = if random.one_in(2) { &mut a } else { &mut b };
        let (piece, rest) = from.split_at(from.len().min(1 + random.below(7)));
        mixed.extend_from_slice(piece);
        *from = rest;
    }
    mixed
}

/// The bytes of one case.
pub fn input(random: &mut Random) -> Vec<u8> {
    match random.below(8) {
        0 => (0..random.below(200)).map(|_| random.byte()).collect(),
        1 => {
            let letters = b"PO0STRG@gEFZKIVALstad?!$+-123456789\r\r\r\r\r\n";
            (0..random.below(200)).map(|_| letters[random.below(letters.len())]).collect()
        }
        2 | 3 => {
            let lines: Vec<_> = (0..random.below(40)).map(|_| any_line(random)).collect();
            lines.iter().flat_map(|line| line.bytes().chain([b'\r'])).collect()
        }
        4 => {
            let (a, b) = (sane(random), sane(random));
            interleave(random, &a, &b)
        }
        5 => sane(random),
        _ => {
            let mut bytes = sane(random);
            mutate(random, &mut bytes);
            let rest = sane(random);
            bytes.extend(rest);
            bytes
        }
    }
}
