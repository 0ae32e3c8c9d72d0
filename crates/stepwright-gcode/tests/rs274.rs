//! The moves of whole jobs, held against the canonical calls of LinuxCNC's interpreter `rs274`.
//!
//! `tests/rs274/` has jobs of our own with what `rs274 -g` (2.9.0~pre1, Debian 12) printed.
//! `STEPWRIGHT_NGC_FILES`, names in lines, has it run on these files instead: `cargo xtask rs274`
//! takes those of its package. A file that is beyond the dialect is tried again without the words
//! of other machines, which both then read without.

mod common;

use std::collections::BTreeMap;
use std::process::{Command, Output};
use std::{env, fs};

use common::blocks;
use stepwright_gcode::{Effect, Length, MoveKind, Options, Plane, Reader};

/// A move, its end and its centre in millimetres.
#[derive(Clone, Debug)]
struct Canonical {
    kind: Kind,
    to: [f64; 3],
    /// How far numbers may be off, as they were printed.
    slack: f64,
}

#[derive(Clone, Debug)]
enum Kind {
    Rapid,
    Feed,
    Probe,
    Arc { plane: Plane, clockwise: bool, centre: [f64; 2] },
}

/// What `rs274` printed, in machine coordinates.
fn theirs(printed: &str) -> Vec<Canonical> {
    let mut moves = Vec::new();
    let (mut unit, mut plane) = (1.0, Plane::Xy);
    // Coordinate system, G92, tool.
    let mut offsets = [[0.0; 3]; 3];
    for line in printed.lines() {
        // A number and the N word stand before a call.
        let Some((name, arguments)) = line.trim_end_matches(')').split_once('(') else { continue };
        let name = name.rsplit(' ').next().unwrap_or_default();
        let numbers: Vec<f64> =
            arguments.split([',', ' ']).filter_map(|number| number.parse().ok()).collect();
        // They are printed with four digits, in the unit of that time.
        let shifted = offsets.iter().filter(|offset| **offset != [0.0; 3]).count();
        let slack = 5.001e-5 * unit * (1 + shifted) as f64;
        let origin: [f64; 3] = std::array::from_fn(|axis| offsets.iter().map(|o| o[axis]).sum());
        let lengths =
            |from: usize| -> [f64; 3] { std::array::from_fn(|axis| numbers[from + axis] * unit) };
        let mut line_to = |kind| {
            let end = lengths(0);
            let to = std::array::from_fn(|axis| end[axis] + origin[axis]);
            moves.push(Canonical { kind, to, slack });
        };
        match name {
            "USE_LENGTH_UNITS" => unit = if arguments.contains("INCHES") { 25.4 } else { 1.0 },
            "SET_G5X_OFFSET" => offsets[0] = lengths(1),
            "SET_G92_OFFSET" => offsets[1] = lengths(0),
            "USE_TOOL_LENGTH_OFFSET" => offsets[2] = lengths(0),
            "SET_XY_ROTATION" => assert_eq!(numbers, [0.0], "no code of the dialect rotates"),
            "SELECT_PLANE" => {
                plane = match arguments {
                    "CANON_PLANE_XZ" => Plane::Zx,
                    "CANON_PLANE_YZ" => Plane::Yz,
                    _ => Plane::Xy,
                }
            }
            "STRAIGHT_TRAVERSE" => line_to(Kind::Rapid),
            "STRAIGHT_FEED" => line_to(Kind::Feed),
            "STRAIGHT_PROBE" => line_to(Kind::Probe),
            "ARC_FEED" => {
                let axes = plane.axes();
                let mut to = [0.0; 3];
                for (axis, number) in axes.into_iter().zip([0, 1, 5]) {
                    to[axis] = numbers[number] * unit + origin[axis];
                }
                let centre = [0, 1].map(|part| numbers[2 + part] * unit + origin[axes[part]]);
                let kind = Kind::Arc { plane, clockwise: numbers[4] < 0.0, centre };
                moves.push(Canonical { kind, to, slack });
            }
            _ => {}
        }
    }
    moves
}

/// What the reader says, or its first error.
fn ours(text: &[u8]) -> Result<Vec<Canonical>, stepwright_gcode::Error> {
    let millimetres = |length: Length| length.picometres() as f64 / Length::PER_MM as f64;
    let mut moves = Vec::new();
    // LinuxCNC's lines have 255 bytes.
    let mut reader = Reader::new(Options { line_limit: 255, ..Options::default() });
    for block in blocks(&mut reader, text) {
        for effect in block?.effects() {
            let part = match effect {
                Effect::Move(part) => part,
                // The rest of a file is not read there.
                Effect::Stop(stepwright_gcode::Stop::End | stepwright_gcode::Stop::Rewind) => {
                    return Ok(moves);
                }
                _ => continue,
            };
            let kind = match part.kind {
                MoveKind::Rapid => Kind::Rapid,
                MoveKind::Feed(_) => Kind::Feed,
                MoveKind::Probe(..) => Kind::Probe,
                MoveKind::Arc(arc, _) => Kind::Arc {
                    plane: arc.plane,
                    clockwise: arc.clockwise,
                    centre: arc.centre.map(millimetres),
                },
            };
            moves.push(Canonical { kind, to: part.to.0.map(millimetres), slack: 0.0 });
        }
    }
    Ok(moves)
}

/// How many moves are the same; lines without length are passed over.
fn compare(ours: &[Canonical], theirs: &[Canonical]) -> Result<usize, String> {
    let is_short = |moves: &[Canonical], at: usize, slack: f64| {
        let from = at.checked_sub(1).map_or([0.0; 3], |before| moves[before].to);
        !matches!(moves[at].kind, Kind::Arc { .. }) && near(&from, &moves[at].to, 2.0 * slack)
    };
    let (mut a, mut b, mut equal) = (0, 0, 0);
    loop {
        match (ours.get(a), theirs.get(b)) {
            (None, None) => return Ok(equal),
            (Some(our), Some(their)) if is_same(our, their) => {
                (a, b, equal) = (a + 1, b + 1, equal + 1);
            }
            (_, Some(their)) if is_short(theirs, b, their.slack) => b += 1,
            (Some(_), their) if is_short(ours, a, their.map_or(5e-5, |their| their.slack)) => {
                a += 1
            }
            (our, their) => return Err(format!("move {a}: {our:?}\nrs274's {b}: {their:?}")),
        }
    }
}

fn near(a: &[f64], b: &[f64], slack: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= slack)
}

fn is_same(our: &Canonical, their: &Canonical) -> bool {
    let kinds = match (&our.kind, &their.kind) {
        (Kind::Rapid, Kind::Rapid) | (Kind::Feed, Kind::Feed) | (Kind::Probe, Kind::Probe) => true,
        (
            Kind::Arc { plane, clockwise, centre },
            Kind::Arc { plane: their_plane, clockwise: their_turn, centre: their_centre },
        ) => {
            plane == their_plane
                && clockwise == their_turn
                && near(centre, their_centre, their.slack)
        }
        _ => false,
    };
    kinds && near(&our.to, &their.to, their.slack)
}

#[test]
fn moves_are_those_of_rs274() {
    let Ok(names) = env::var("STEPWRIGHT_NGC_FILES") else {
        for (job, printed) in [
            (&include_bytes!("rs274/plate.ngc")[..], include_str!("rs274/plate.canon")),
            (include_bytes!("rs274/inches.ngc"), include_str!("rs274/inches.canon")),
        ] {
            let ours = ours(job).unwrap();
            let equal = compare(&ours, &theirs(printed)).unwrap();
            assert_eq!(equal, ours.len());
            assert!(equal > 15);
        }
        return;
    };
    let (mut same, mut moves, mut theirs_alone, mut differ) = ([0; 2], [0; 2], 0, Vec::new());
    let mut refused = BTreeMap::<u8, u32>::new();
    for name in names.lines() {
        let text = fs::read(name).unwrap();
        let (text, ours, bared) = match ours(&text) {
            Ok(ours) => (text, ours, false),
            Err(error) => {
                *refused.entry(error.fault.number()).or_default() += 1;
                let text = bare(&text);
                let Ok(ours) = ours(&text) else { continue };
                (text, ours, true)
            }
        };
        let out = rs274(&text);
        if !out.status.success() {
            theirs_alone += 1;
            println!("rs274 refuses {name}: {}", String::from_utf8_lossy(&out.stderr).trim());
            continue;
        }
        match compare(&ours, &theirs(&String::from_utf8_lossy(&out.stdout))) {
            Ok(equal) => {
                same[usize::from(bared)] += 1;
                moves[usize::from(bared)] += equal;
            }
            Err(why) => differ.push(format!("{name}: {why}")),
        }
    }
    println!("the same: {} files as they are, with {} moves,", same[0], moves[0]);
    println!("  and {} without the words of other machines, with {} moves", same[1], moves[1]);
    println!("refused by rs274 alone: {theirs_alone}");
    println!("beyond the dialect, files by error: {refused:?}");
    assert!(differ.is_empty(), "{}", differ.join("\n"));
    assert!(moves[0] + moves[1] >= 1000, "too few moves to say anything");
}

/// What `rs274` says to a text.
fn rs274(text: &[u8]) -> Output {
    // It keeps parameters in a file where it stands.
    let folder = env::temp_dir().join(format!("stepwright-rs274-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("job.ngc"), text).unwrap();
    let out = Command::new("rs274").args(["-g", "job.ngc"]).current_dir(&folder).output().unwrap();
    fs::remove_dir_all(&folder).unwrap();
    out
}

/// Words of other machines: more axes, tool changes and tables, blending, kinematics.
fn is_of_others(letter: u8, number: &str) -> bool {
    match (letter, number.parse::<f64>()) {
        (b'A'..=b'E' | b'H' | b'Q' | b'U'..=b'W', _) => true,
        (b'G', Ok(code)) => [8.0, 43.0, 64.0].contains(&code),
        (b'M', Ok(code)) => [6.0, 48.0, 49.0, 61.0, 428.0, 429.0].contains(&code),
        _ => false,
    }
}

/// A text without comments and without these words, nor the P of G64.
fn bare(text: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(text).to_ascii_uppercase();
    let mut bare = String::new();
    for line in text.lines() {
        let mut rest = String::new();
        let mut comment = false;
        for char in line.chars().take_while(|&char| char != ';') {
            comment |= char == '(';
            if !comment && !char.is_whitespace() {
                rest.push(char);
            }
            comment &= char != ')';
        }
        let blends = rest.contains("G64");
        let mut rest = &rest[..];
        while let Some(letter) = rest.chars().next() {
            let length = letter.len_utf8();
            let is_number = |char: char| char.is_ascii_digit() || "+-.".contains(char);
            let end =
                rest[length..].find(|char| !is_number(char)).map_or(rest.len(), |at| at + length);
            let number = &rest[length..end];
            let is_out = letter.is_ascii_uppercase() && is_of_others(letter as u8, number)
                || blends && letter == 'P';
            if !is_out {
                bare += &rest[..end];
            }
            rest = &rest[end..];
        }
        bare += "\n";
    }
    bare.into_bytes()
}
