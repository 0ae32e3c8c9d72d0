//! Every error, its number and its place, and what it says.

use crate::common::{blocks, table};
use stepwright_gcode::{Fault, Reader};

#[test]
fn words_that_are_none() {
    table(&[
        ("1", "error 1 at 1:1"),
        ("G0 X1 #2", "error 1 at 1:7"),
        ("G0 X1 \u{e9}", "error 1 at 1:7"),
        ("G0 X1?", "error 1 at 1:6"),
        ("G0 X1*23", "error 1 at 1:6"),
        ("G0 X1\u{feff}", "error 1 at 1:6"),
        (" \u{feff}G0 X1", "error 1 at 1:2"),
        ("X1.2.3", "error 1 at 1:5"),
        ("X1-2", "error 1 at 1:3"),
        ("\n\nG0 X", "error 2 at 3:4"),
        ("G0 XY1", "error 2 at 1:4"),
        ("G0 X-", "error 2 at 1:4"),
        ("G0 X--1", "error 2 at 1:4"),
        ("G0 X#1", "error 2 at 1:4"),
        ("G0 X[1]", "error 2 at 1:4"),
        ("G", "error 2 at 1:1"),
        ("X10000000", "error 2 at 1:1"),
        ("G0 Y0 X1000000.000000001", "error 2 at 1:7"),
        ("G20 X39370.1", "error 2 at 1:5"),
        ("G1 X1 F1000001", "error 2 at 1:7"),
        ("$H", "error 3 at 1:1"),
        (" $G1 X1", "error 3 at 1:2"),
        ("G0 $", "error 1 at 1:4"),
    ]);
}

#[test]
fn numbers_that_are_not_allowed() {
    table(&[
        ("F-1", "error 4 at 1:1"),
        ("G0 S-0.001", "error 4 at 1:4"),
        ("T-1", "error 4 at 1:1"),
        ("N-1", "error 4 at 1:1"),
        ("G4 P-1", "error 4 at 1:4"),
        ("G64 P-1", "error 4 at 1:5"),
        ("G10 L2 P-1 X1", "error 4 at 1:8"),
        ("T1.5", "error 23 at 1:1"),
        ("G10 L2.5 P1 X1", "error 23 at 1:5"),
        ("G10 L2 P1.5 X1", "error 23 at 1:8"),
        ("M3.1", "error 23 at 1:1"),
        ("N1.5", "error 27 at 1:1"),
        ("N9999999.999999999999", "error 27 at 1:1"),
        ("T256", "error 38 at 1:1"),
        ("G10 L2 P7 X1", "error 29 at 1:8"),
        ("G59.1", "error 29 at 1:1"),
        ("G0 G59.3", "error 29 at 1:4"),
    ]);
}

#[test]
fn codes_that_are_not_there() {
    table(&[
        ("G5", "error 20 at 1:1"),
        ("G0 G41", "error 20 at 1:4"),
        ("G1.1", "error 20 at 1:1"),
        ("G-1", "error 20 at 1:1"),
        ("G38.6", "error 20 at 1:1"),
        ("G28.01", "error 20 at 1:1"),
        ("G81", "error 20 at 1:1"),
        ("G90.1", "error 20 at 1:1"),
        ("G43 H1", "error 20 at 1:1"),
        ("M6", "error 20 at 1:1"),
        ("M98", "error 20 at 1:1"),
        ("G0 A1", "error 20 at 1:4"),
        ("X1 Q1", "error 20 at 1:4"),
        ("O100", "error 20 at 1:1"),
        ("G10 L1 P1 X1", "error 20 at 1:5"),
    ]);
}

#[test]
fn two_of_a_modal_group() {
    let groups: [&[&str]; 12] = [
        &["G4", "G10", "G28", "G28.1", "G30", "G30.1", "G53", "G92", "G92.1"],
        &["G0", "G1", "G2", "G3", "G38.2", "G38.3", "G38.4", "G38.5", "G80"],
        &["G17", "G18", "G19"],
        &["G90", "G91"],
        &["G93", "G94"],
        &["G20", "G21"],
        &["G43.1", "G49"],
        &["G54", "G55", "G56", "G57", "G58", "G59"],
        &["M0", "M1", "M2", "M30"],
        &["M3", "M4", "M5"],
        &["M7", "M8", "M9"],
        &["G91.1"],
    ];
    for group in groups.into_iter().chain([&["G40"][..], &["G61", "G64"]]) {
        for first in group {
            for second in group {
                let text = format!("{first} {second}");
                table(&[(&text, &format!("error 21 at 1:{}", first.len() + 2))]);
            }
        }
    }
    // Of different groups, in one block.
    table(&[("G0 G17 G90 G91.1 G94 G21 G40 G54 G61 M0 M5 M9 X1", "rapid X1 Y0 Z0\nPause")]);
}

#[test]
fn words_that_stand_twice() {
    for letter in "FIJKLNPRSTXYZ".chars() {
        let text = format!("G0 {letter}1 {letter}1");
        table(&[(&text, "error 25 at 1:7")]);
    }
}

#[test]
fn axis_words_have_one_code() {
    table(&[
        ("G0 G92 X1", "error 24 at 1:4"),
        ("G92 X1 G1", "error 24 at 1:8"),
        ("G1 G10 L2 P1 X1", "error 24 at 1:4"),
        ("G0 G28 X1", "error 24 at 1:4"),
        ("G38.2 G30 X1", "error 24 at 1:7"),
        ("G43.1 Z1 G0", "error 24 at 1:10"),
        ("G49 G92 X0", "error 24 at 1:5"),
        ("G0 G49 X1", "error 24 at 1:4"),
        ("G2", "error 26 at 1:1"),
        ("G3 I5 J5", "error 26 at 1:1"),
        ("G17 G38.2 F1", "error 26 at 1:5"),
        ("G92", "error 26 at 1:1"),
        ("G10 L2 P1", "error 26 at 1:1"),
        ("G10 L20 P1", "error 26 at 1:1"),
        ("G43.1", "error 37 at 1:1"),
        ("G43.1 X1", "error 37 at 1:7"),
        ("G43.1 Z1 Y1", "error 37 at 1:10"),
        ("G53 G2 X1 I1 F1", "error 30 at 1:1"),
        ("G80\nG53 X1", "error 30 at 2:1"),
        ("G38.2 G53 X1 F1", "error 30 at 1:7"),
        ("G80\nX1", "error 31 at 2:1"),
    ]);
}

#[test]
fn words_that_are_missing_or_too_many() {
    table(&[
        ("G4", "error 28 at 1:1"),
        ("G0 X1 G4", "error 28 at 1:7"),
        ("G10 P1 X1", "error 28 at 1:1"),
        ("G10 L2 X1", "error 28 at 1:1"),
        ("G0 X1 P1", "error 36 at 1:7"),
        ("G0 R1 X1 I1", "error 36 at 1:4"),
        ("J1", "error 36 at 1:1"),
        ("L1", "error 36 at 1:1"),
        ("G49 Z1", "error 36 at 1:5"),
        ("G2 F1 X1 R5 I1", "error 36 at 1:13"),
        ("G2 F1 X2 I1 K0", "error 36 at 1:13"),
        ("G2 F1 X2 I1 P1", "error 36 at 1:13"),
        ("G2 F1 X2 I1\nI1", "cw F1 X2 Y0 Z0 about X1 Y0\nerror 36 at 2:1"),
    ]);
}

#[test]
fn positions_beyond_the_range() {
    table(&[
        ("X1000000\nG91 X.000000001", "rapid X1000000 Y0 Z0\nerror 33 at 2:5"),
        ("G10 L2 P1 Y-1000000\nX1 Y-1", "G54 = X0 Y-1000000 Z0\nerror 33 at 2:4"),
        ("X1000000\nG92 X-1", "rapid X1000000 Y0 Z0\nerror 33 at 2:5"),
        ("X1000000\nG10 L20 P1 X-1", "rapid X1000000 Y0 Z0\nerror 33 at 2:12"),
        ("X999999\nG2 F1 X999997 Y2 I2", "rapid X999999 Y0 Z0\nerror 33 at 2:1"),
    ]);
}

#[test]
fn an_error_says_what_is_wrong_and_what_to_do() {
    for (text, said) in [
        ("G1 X10 F-5", "line 1, column 8: error 4: F is negative: write 0 or more"),
        (
            "G0 X1 X2",
            "line 1, column 7: error 25: X stands twice in this block: remove one of them",
        ),
        ("X1 P2", "line 1, column 4: error 36: no code of this block uses P: remove it"),
        ("G4", "line 1, column 1: error 28: a word that is needed is missing: add P"),
        (
            "G0\u{feff}X1",
            "line 1, column 3: error 1: a byte order mark (U+FEFF) stands here: it is allowed at the start of a file alone; remove it",
        ),
        (
            "E1",
            "line 1, column 1: error 20: there is no word E: the letters are F, G, I to N, P, R to T and X to Z",
        ),
    ] {
        let error = blocks(&mut Reader::default(), text.as_bytes())[0].unwrap_err();
        assert_eq!(error.to_string(), said);
    }
}

#[test]
fn the_letters_that_an_error_lists_are_those_that_are_read() {
    for letter in 'A'..='Z' {
        let error = blocks(&mut Reader::default(), format!("{letter}").as_bytes())[0].unwrap_err();
        assert_eq!(error.fault, Fault::Number);
        let text = format!("{letter}0.00001");
        let fault =
            blocks(&mut Reader::default(), text.as_bytes())[0].err().map(|error| error.fault);
        let listed = "FGIJKLMNPRSTXYZ".contains(letter);
        assert_eq!(fault == Some(Fault::Word(letter)), !listed, "{letter}");
    }
}
