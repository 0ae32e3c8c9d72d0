//! Noise against the reader: whatever comes, every line gets one answer, a refused line changes
//! nothing, and moves hang together.
//!
//! `STEPWRIGHT_FUZZ_LINES` sets the number of lines (the default takes some seconds),
//! `STEPWRIGHT_FUZZ_SEED` the seed.

use crate::common::words;
use stepwright_gcode::{
    Arc, Effect, FeedRate, Length, Move, MoveKind, Options, Parameter, Point, Reader, System,
};

/// Numbers from a seed, by the recurrence of Vigna's SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound as u64) as usize
    }

    fn one_of<'a>(&mut self, list: &[&'a str]) -> &'a str {
        list[self.below(list.len())]
    }
}

const CODES: &[&str] = &[
    "G0", "G1", "G2", "G3", "G4", "G10", "G17", "G18", "G19", "G20", "G21", "G28", "G28.1", "G30",
    "G30.1", "G38.2", "G38.3", "G38.4", "G38.5", "G40", "G43.1", "G49", "G53", "G54", "G55", "G56",
    "G57", "G58", "G59", "G59.1", "G61", "G64", "G80", "G90", "G91", "G91.1", "G92", "G92.1",
    "G93", "G94", "M0", "M1", "M2", "M3", "M4", "M5", "M6", "M7", "M8", "M9", "M30", "L2", "L20",
    "P0", "P1", "P6", "P7", "F100", "R1", "R-5",
];
const LETTERS: &[&str] = &["X", "Y", "Z", "X", "Y", "I", "J", "K", "R", "F", "S", "T", "N", "P"];
const NUMBERS: &[&str] = &[
    "0",
    "1",
    "-1",
    "2",
    "5",
    ".5",
    "-.5",
    "10",
    "1000000",
    "-1000000",
    "999999.999999999",
    "9999999",
    "-9999999.99999999999",
    "0.000000001",
    "123.456789012345",
    "",
    "-",
    "1e5",
    "#1",
];

/// Moves that are good for most numbers, at `#`.
const MOVES: &[&str] = &[
    "X#",
    "G0 X# Y# Z#",
    "G94 G1 F300 X# Z#",
    "G94 G2 F300 G17 X# Y# R2500",
    "G93 G3 F5 G18 X# Z# R-2500 Y#",
    "G91 G3 F9 G17 X2 Y0 I1 J#",
    "G91 G2 F9 G19 Y0 Z0 J# K#",
    "G91 G2 F9 G17 X10.004 Y0 I5",
    "G38.2 F9 Z#",
];

/// A number up to 1000 with three digits after the point.
fn small(random: &mut Random) -> f64 {
    random.below(2_000_000) as f64 / 1000.0 - 1000.0
}

/// A line: words, most of them good, or bytes.
fn line(random: &mut Random, text: &mut Vec<u8>) {
    text.clear();
    if random.below(16) == 0 {
        for _ in 0..random.below(90) {
            let byte = random.next() as u8;
            text.push(if byte == b'\n' || byte == b'\r' { b' ' } else { byte });
        }
        return;
    }
    if random.below(2) == 0 {
        let template = random.one_of(MOVES).split('#');
        for (number, part) in template.enumerate() {
            if number > 0 {
                text.extend(small(random).to_string().bytes());
            }
            text.extend(part.bytes());
        }
        return;
    }
    for _ in 0..random.below(7) {
        if random.below(2) == 0 {
            text.extend(random.one_of(CODES).bytes());
        } else {
            text.extend(random.one_of(LETTERS).bytes());
            match random.below(3) {
                0 => text.extend(random.one_of(NUMBERS).bytes()),
                _ => text.extend(small(random).to_string().bytes()),
            }
        }
        if random.below(200) == 0 {
            text.extend(random.one_of(&["(", ")", ";", "%", "/", "$", "é"]).bytes());
        }
    }
}

/// All that a line may change.
fn everything(reader: &Reader) -> impl PartialEq + use<> {
    let parameters = [Parameter::G28, Parameter::G30, Parameter::G92, Parameter::ToolLength];
    let systems = System::ALL.map(|system| reader.parameter(Parameter::System(system)));
    (reader.modal(), reader.position(), parameters.map(|one| reader.parameter(one)), systems)
}

fn is_in_range(point: Point) -> bool {
    point.0.iter().all(|length| length.picometres().abs() <= Length::MAX.picometres())
}

/// Millimetres from the centre of an arc to a point.
fn radius(arc: Arc, point: Point) -> f64 {
    let [first, second, _] = arc.plane.axes();
    let part = |at: Length, centre: Length| (at.picometres() - centre.picometres()) as f64 * 1e-9;
    part(point.0[first], arc.centre[0]).hypot(part(point.0[second], arc.centre[1]))
}

fn judge_move(part: Move) {
    assert!(is_in_range(part.to));
    let rate = match part.kind {
        MoveKind::Rapid => None,
        MoveKind::Feed(rate) | MoveKind::Probe(_, rate) | MoveKind::Arc(_, rate) => Some(rate),
    };
    assert!(match rate {
        Some(FeedRate::PerMinute(rate)) => rate > Length::ZERO,
        Some(FeedRate::Inverse(moves)) => moves.scaled() > 0,
        None => true,
    });
    let MoveKind::Arc(arc, _) = part.kind else {
        assert_ne!(part.from, part.to);
        return;
    };
    let (start, end) = (radius(arc, part.from), radius(arc, part.to));
    let gap = (start - end).abs();
    // The rounding of this judge comes on top.
    let slack = 1e-9 + start * 1e-12;
    assert!(
        start > 0.0 && (gap <= 0.005 + slack || gap <= 0.5 + slack && gap <= start * 0.001 + slack)
    );
}

#[test]
fn noise_does_no_harm() {
    let set = |name: &str| std::env::var(name).ok().map(|n| n.parse::<u64>().expect(name));
    let count = set("STEPWRIGHT_FUZZ_LINES").unwrap_or(300_000);
    let mut random = Random(set("STEPWRIGHT_FUZZ_SEED").unwrap_or(1));
    let options = Options { line_limit: 60, ..Options::default() };
    let (mut reader, mut text) = (Reader::new(options), Vec::new());
    let (mut moves, mut arcs, mut refused) = (0, 0, [0_u32; 39]);
    for number in 1..=count {
        // Near zero again, or nearly all is beyond the range after some time.
        if number % 50 == 0 {
            reader.set_position(Point::ZERO);
            for system in System::ALL {
                reader.set_parameter(Parameter::System(system), Point::ZERO);
            }
        }
        line(&mut random, &mut text);
        let (before, position) = (everything(&reader), reader.position());
        for &byte in &text {
            assert_eq!(reader.push(byte), None);
        }
        match reader.push(b'\n').expect("an answer at the end of a line") {
            Ok(block) => {
                assert_eq!(u64::from(block.line), number);
                let mut at = position;
                for effect in block.effects() {
                    let Effect::Move(part) = effect else { continue };
                    assert_eq!(part.from, at, "{}", words(effect));
                    judge_move(part);
                    at = part.to;
                    moves += 1;
                    arcs += u64::from(matches!(part.kind, MoveKind::Arc(..)));
                }
                assert_eq!(at, reader.position());
            }
            Err(error) => {
                assert_eq!(u64::from(error.line), number);
                assert!(error.column >= 1 && usize::from(error.column) <= text.len());
                assert!(before == everything(&reader), "{}", text.escape_ascii());
                refused[usize::from(error.fault.number())] += 1;
            }
        }
    }
    println!("{count} lines, {moves} moves, {arcs} arcs, refused: {refused:?}");
    // A fuzz that reaches nothing proves nothing.
    if count >= 100_000 {
        assert!(moves > count / 20 && arcs > count / 2000, "{moves} moves, {arcs} arcs");
        let known = (1..=4).chain([11]).chain(20..=38);
        for number in known {
            assert!(refused[number] > 0, "no error {number}");
        }
    }
}
