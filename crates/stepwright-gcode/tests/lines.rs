//! How a line is written: blanks, case, comments, numbers, line ends.

use crate::common::{self, blocks, read, read_with, table};
use stepwright_gcode::{Options, Reader};

#[test]
fn words_are_read_however_they_are_written() {
    table(&[
        ("G0X1Y2Z3", "rapid X1 Y2 Z3"),
        ("g0x1y2z3\n", "rapid X1 Y2 Z3"),
        ("G00 X+1.0 Y2. Z03", "rapid X1 Y2 Z3"),
        (" G 0 0.0\tX 1 . 5 Y - . 2 5\r", "rapid X1.5 Y-0.25 Z0"),
        ("X1 G0", "rapid X1 Y0 Z0"),
        ("N0 G0 X1", "rapid X1 Y0 Z0"),
        ("N9999999 X1", "rapid X1 Y0 Z0"),
        ("G0 X.123456789 Y-1000000", "rapid X0.123456789 Y-1000000 Z0"),
        ("", ""),
        ("\n \t\n\r\n", ""),
    ]);
}

#[test]
fn comments_are_passed_over() {
    table(&[
        ("(G0 X1) G0 (Y2) X3 (Z4", "rapid X3 Y0 Z0"),
        ("G0 X1 ; Y2 (Z3)\nY2", "rapid X1 Y0 Z0\nrapid X1 Y2 Z0"),
        ("G0 X1(a number goes on behind a comment)5", "rapid X15 Y0 Z0"),
        ("(an ( is one comment) G0 X1", "rapid X1 Y0 Z0"),
        ("(; in parentheses) G0 X1", "rapid X1 Y0 Z0"),
        ("(a comment ends with its line\nG0 X1", "rapid X1 Y0 Z0"),
        ("(é ? ! ~ $ %) G0 X1 ; é", "rapid X1 Y0 Z0"),
        ("%\nG0 X1\n % the end\nX2", "rapid X1 Y0 Z0\nrapid X2 Y0 Z0"),
        ("G0 X1) Y2", "error 1 at 1:6"),
    ]);
}

#[test]
fn a_byte_order_mark_may_begin_the_input() {
    table(&[
        ("\u{feff}G0 X1", "rapid X1 Y0 Z0"),
        ("\u{feff}%\nX1", "rapid X1 Y0 Z0"),
        ("\u{feff}", ""),
        ("\u{feff}\nX1", "rapid X1 Y0 Z0"),
        // The line is what stands behind it.
        ("\u{feff}G0 Q1", "error 20 at 1:4"),
        ("\u{feff}\u{feff}G0 X1", "error 1 at 1:1"),
        ("\n\u{feff}G0 X1", "error 1 at 2:1"),
        // Another character that begins with the same byte.
        ("\u{fefe}G0 X1", "error 1 at 1:1"),
    ]);
    assert!(blocks(&mut Reader::default(), b"\xEF\xBB")[0].is_err());
}

#[test]
fn a_line_with_a_slash_is_skipped_if_asked() {
    let text = "/G0 X1\n / (a comment) X2\nX3";
    assert_eq!(read(text), "rapid X1 Y0 Z0\nrapid X2 Y0 Z0\nrapid X3 Y0 Z0");
    let options = Options { block_delete: true, ..Options::default() };
    assert_eq!(read_with(options, text), "rapid X3 Y0 Z0");
    assert_eq!(read("G0 /X1"), "error 1 at 1:4");
    assert_eq!(read("//G0 X1"), "error 1 at 1:2");
}

#[test]
fn a_line_has_a_length() {
    let comment = "(which does not count, however long a person may make it, even beyond 80)";
    // 4 + 2 + 74 = 80 bytes.
    let full = format!("G0 X1 {comment} Y0.{}1", "0".repeat(72));
    assert_eq!(read(&full), "rapid X1 Y0 Z0");
    let longer = format!("{full} 1 1");
    assert_eq!(read(&longer), format!("error 11 at 1:{}", full.len() + 2));
    let options = Options { line_limit: 82, ..Options::default() };
    assert_eq!(read_with(options, &longer), "rapid X1 Y0 Z0");
    assert_eq!(
        read_with(options, &format!("{longer}1")),
        format!("error 11 at 1:{}", longer.len() + 1)
    );
}

#[test]
fn a_line_that_goes_on_is_refused_before_it_ends() {
    let longest = format!("G0 X1 ;{}", "-".repeat(65_535 - 7));
    assert_eq!(read(&longest), "rapid X1 Y0 Z0");
    for longer in
        [format!("{longest}-"), " ".repeat(65_536), "\0".repeat(65_536), "(".repeat(65_536)]
    {
        let mut reader = Reader::default();
        let mut early = blocks(&mut reader, longer.as_bytes()).into_iter();
        let error = early.next().unwrap().unwrap_err();
        assert_eq!((error.fault.number(), error.line, error.column), (11, 1, u16::MAX));
        assert!(early.next().is_none());
        // It is one line, however long.
        let rest = blocks(&mut reader, b"G0 X1 ( and so on\r\nG0 X2");
        let moves: Vec<_> = rest.into_iter().map(|block| block.unwrap()).collect();
        assert_eq!((moves.len(), moves[0].line), (1, 2));
        assert_eq!(reader.position().to_string(), "X2 Y0 Z0");
    }
    // What is wrong before is said first, and once.
    assert_eq!(read(&format!("?{}\nX1", " ".repeat(99_999))), "error 1 at 1:1\nrapid X1 Y0 Z0");
}

#[test]
fn every_line_end_ends_one_line() {
    let text = b"G0 X1\rX2\nX3\r\n\n\rQ";
    let blocks = blocks(&mut Reader::default(), text);
    let lines: Vec<_> = blocks
        .iter()
        .map(|block| block.map_or_else(|error| error.line, |block| block.line))
        .collect();
    assert_eq!(lines, [1, 2, 3, 4, 5, 6]);
    assert!(blocks[5].is_err());
}

#[test]
fn a_line_has_its_number() {
    let blocks = blocks(&mut Reader::default(), b"N7 G0\nG1\n\nN8(x)\n");
    let numbers: Vec<_> = blocks.iter().map(|block| block.unwrap().number).collect();
    assert_eq!(numbers, [Some(7), None, None, Some(8)]);
}

#[test]
fn an_error_leaves_everything_as_it_was() {
    let mut reader = Reader::default();
    let before = "G21 G1 F100 X1 S10 M3\nG10 L2 P1 X5\n";
    assert!(blocks(&mut reader, before.as_bytes()).iter().all(Result::is_ok));
    let (modal, position) = (reader.modal(), reader.position());
    let wrong = "G20 G91 G18 G93 G55 G3 M4 S5 M8 T3 G10 L20 P2 Y7 Q\n";
    assert!(blocks(&mut reader, wrong.as_bytes())[0].is_err());
    // A fault that is found once all is executed.
    let wrong = "G20 G91 G18 G93 G55 M4 S5 M8 T3 G10 L20 P2 Y7 K1\n";
    assert!(blocks(&mut reader, wrong.as_bytes())[0].is_err());
    assert_eq!((reader.modal(), reader.position()), (modal, position));
    let now = blocks(&mut reader, b"X2\n")[0].unwrap().effects().map(common::words).next();
    assert_eq!(now.unwrap(), "feed F100 X7 Y0 Z0");
}
