extern crate std;
use std::format;
use std::string::String;
use std::vec::Vec;

use super::*;
use crate::{Command, Form, Refusal, crc};

/// Two axes: steps move the first at once, and the position of the second is unknown.
#[derive(Default)]
struct Toy {
    at: i64,
    busy: bool,
    killed: bool,
    polled: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Full(u32);

impl OwnFault for Full {
    fn word(&self) -> Text {
        text!("full")
    }
    fn number(&self, n: u8) -> Option<i64> {
        (n == 0).then_some(self.0.into())
    }
    fn read(word: &[u8], numbers: &mut Numbers<'_>) -> Option<Full> {
        if word == b"full" { numbers.word().map(Full) } else { None }
    }
}

#[derive(Debug, PartialEq)]
enum Row {
    Go(i32, u8),
    Big(u64),
    Full,
    All,
}

impl BoardProgram for Toy {
    type Row = Row;
    type Reason = Full;

    fn about(&mut self, n: u8) -> Option<Piece> {
        match n {
            0 => Some(Piece::Text(text!("stepwright-toy virtual axes=2 late="))),
            1 => Some(Piece::Number(7)),
            2 => Some(Piece::Text(text!(" can=sum"))),
            _ => None,
        }
    }
    fn axes(&self) -> u8 {
        2
    }
    fn read(&self, letter: u8, numbers: &mut Numbers<'_>) -> Option<Row> {
        Some(match letter {
            b'G' => Row::Go(numbers.count()?, numbers.up_to(9)?),
            b'B' => Row::Big(numbers.wide()?),
            b'L' => Row::Full,
            b'?' => Row::All,
            _ => return None,
        })
    }
    fn carry_out(&mut self, row: &Row) -> Result<Said, Fault<Full>> {
        match row {
            Row::Go(steps, _) => self.at += i64::from(*steps),
            Row::Big(number) => return Ok(Said::Number((*number >> 1) as i64)),
            Row::Full => return Err(Fault::Own(Full(22))),
            Row::All => return Ok(Said::Report),
        }
        Ok(Said::Yes)
    }
    fn number(&mut self, n: u8) -> Option<i64> {
        [self.at, -3, i64::MIN].get(usize::from(n)).copied()
    }
    fn is_busy(&mut self) -> bool {
        self.busy
    }
    fn position(&mut self, axis: u8) -> Option<i64> {
        (axis == 0 && !self.killed).then_some(self.at)
    }
    fn set_zero(&mut self, _: u8) {
        (self.at, self.killed) = (0, false);
    }
    fn mark_unknown(&mut self) {
        self.killed = true;
    }
    fn stop(&mut self) {
        self.busy = false;
    }
    fn kill(&mut self) {
        (self.busy, self.killed) = (false, true);
    }
    fn poll(&mut self) {
        self.polled += 1;
    }
}

/// Sends bytes, and returns the answers to the lines among them.
fn say(toy: &mut Toy, bytes: &[u8]) -> String {
    let (mut line, mut slave) = (Incoming::<32>::new(), ProgramSlave::new());
    let mut answers = Vec::new();
    for byte in bytes {
        if line.receive(Some(*byte)) {
            slave.obey(&mut line, toy);
            assert!(slave.is_answering());
            answers.extend(core::iter::from_fn(|| slave.next_byte(toy)));
            assert!(!slave.is_answering());
        }
    }
    String::from_utf8(answers).unwrap()
}

fn summed(line: &str) -> String {
    format!("{line}*{:02X}\r", line.bytes().fold(0, crc))
}

#[test]
fn the_common_rows_are_those_of_the_controller() {
    let mut toy = Toy { at: -12, ..Toy::default() };
    let about = "stepwright-toy virtual axes=2 late=7 can=sum\r";
    assert_eq!(
        say(&mut toy, b"?\rF\rV1\rV2\rV3\rZ\r"),
        format!("{about}R\r-12\rE uncertain\rE axis\rY\r")
    );
    toy.busy = true;
    assert_eq!(say(&mut toy, b"F\rI1\rK\rV1\rI1\rV1\r"), "B\rE busy\rY\rE uncertain\rY\r0\r");
    // The controller has a line of each of these forms, with the same meaning.
    for line in ["F", "V1", "Z", "K", "I1", "?"] {
        assert!(Command::parse(line.as_bytes()).is_ok());
        assert!(Form::of(line.as_bytes()).unwrap().is_common(), "{line}");
        assert!(!say(&mut toy, format!("{line}\r").as_bytes()).starts_with('E'), "{line}");
    }
    assert_eq!(Form::ALL.iter().filter(|form| form.is_common()).count(), 6);
    // No line of the controller begins with the mark.
    assert!(Form::of(b":").is_none());
}

#[test]
fn a_row_is_read_whole_before_it_is_obeyed() {
    let mut toy = Toy::default();
    assert_eq!(say(&mut toy, b":G5,9\rV1\r\n:G-7,0\r\n"), "Y\r5\rY\r");
    for (line, answer) in [
        ("G5,9", "E line"),
        (":", "E line"),
        (":x", "E line"),
        (":G5", "E line"),
        (":G5,", "E line"),
        (":G5,1,", "E line"),
        (":G5,1,1", "E line"),
        (":G+5,1", "E line"),
        (":G--5,1", "E line"),
        (":G5,1 ", "E line"),
        (":G5,10", "E range 2,0,9"),
        (":G2147483648,0", "E range 1,-2147483648,2147483647"),
        (":G9223372036854775808,0", "E range 1,-9223372036854775807,9223372036854775807"),
        (":G-0,-0", "Y"),
        (":B18446744073709551616", "E line"),
        (":B-1", "E range 1,0,9223372036854775807"),
        (":B18446744073709551615", "9223372036854775807"),
        (":L", "E full 22"),
        (":L0", "E line"),
        (":?", "-2,-3,-9223372036854775808"),
        ("", "E line"),
        ("F1", "E line"),
        ("V", "E line"),
        ("V1,1", "E line"),
        ("V-1", "E axis"),
        ("I0", "E axis"),
    ] {
        assert_eq!(say(&mut toy, format!("{line}\r").as_bytes()), format!("{answer}\r"), "{line}");
        assert_eq!(say(&mut toy, summed(line).as_bytes()), summed(answer), "{line}");
    }
    assert_eq!(toy.at, -2);
}

#[test]
fn every_number_of_64_bits_is_read() {
    for number in [0, 1, 9, 10, u64::MAX / 10, u64::MAX / 10 + 1, u64::MAX - 1, u64::MAX] {
        assert_eq!(Numbers::of(format!("{number}").as_bytes()).wide(), Some(number));
    }
    for tenth in
        [1_844_674_407_370_955_161u64, 1_844_674_407_370_955_162, 1_873_497_444_986_126_336]
    {
        for digit in 0..10 {
            let text = format!("{tenth}{digit}");
            assert_eq!(Numbers::of(text.as_bytes()).wide(), text.parse().ok(), "{text}");
        }
    }
}

/// Every bit of a line, its end too: the line is obeyed as sent, or not at all.
#[test]
fn a_flipped_bit_of_a_row_changes_nothing() {
    let line = summed(":G120,3").into_bytes();
    for bit in 0..8 * line.len() {
        let mut toy = Toy::default();
        let mut flipped = line.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        // The next line ends a line whose end was damaged.
        say(&mut toy, &[&flipped[..], summed("F").as_bytes(), b"\r"].concat());
        let same = flipped.eq_ignore_ascii_case(&line) && flipped[1] == b'G';
        assert_eq!(toy.at, if same { 120 } else { 0 }, "bit {bit}");
    }
}

/// For a master that uses checksums, and for one that has stopped using them.
#[test]
fn a_row_that_has_lost_a_byte_is_refused() {
    let line = summed(":G12,0").into_bytes();
    let (mut slave, mut incoming) = (ProgramSlave::new(), Incoming::<32>::new());
    for lost in 0..line.len() - 1 {
        let mut toy = Toy::default();
        let mut say = |text: &[u8]| {
            for byte in text {
                if incoming.receive(Some(*byte)) {
                    slave.obey(&mut incoming, &mut toy);
                    while slave.next_byte(&mut toy).is_some() {}
                }
            }
            toy.at
        };
        say(summed("F").as_bytes());
        assert_eq!(say(&[&line[..lost], &line[lost + 1..]].concat()), 0, "byte {lost}");
        assert_eq!(say(b":G3,0\r"), 0);
        assert_eq!(say(b"F\r:G3,0\r"), 3);
    }
}

/// Binary frames begin with such a byte; a line of text never has one.
#[test]
fn a_byte_of_0x80_and_more_damages_its_line_alone() {
    let mut toy = Toy::default();
    assert_eq!(say(&mut toy, b"\x80:G1,1\r:G1\xFF,1\rF\xB0\rF\r"), "E line\rE line\rE line\rR\r");
    assert_eq!(toy.at, 0);
    // A line with something like a checksum is answered with a checksum.
    assert_eq!(say(&mut toy, b":G1,1\xFF*00\r"), summed("E sum"));
}

#[test]
fn a_line_feed_stands_between_lines_alone_and_a_long_line_is_none() {
    let mut toy = Toy::default();
    assert_eq!(say(&mut toy, b"\n\nF\r\nF\r"), "R\rR\r");
    assert_eq!(say(&mut toy, b":G1\n,1\rF\n\r"), "E line\rE line\r");
    let long = [&[b'0'; 40][..], b"\rF\r"].concat();
    assert_eq!(say(&mut toy, &long), "E line\rR\r");
    let (mut line, mut slave) = (Incoming::<8>::new(), ProgramSlave::new());
    line.receive(Some(b'F'));
    assert!(!line.receive(None) && line.receive(Some(b'\r')));
    slave.obey(&mut line, &mut toy);
    let answer: Vec<u8> = core::iter::from_fn(|| slave.next_byte(&mut toy)).collect();
    assert_eq!(answer, b"E line\r");
}

#[test]
fn a_refusal_comes_back_and_shares_the_controllers_words() {
    let range = Fault::Range { number: 3, least: -5, most: i64::MAX };
    for (fault, text) in [
        (Fault::Line, "line"),
        (Fault::Sum, "sum"),
        (Fault::Axis, "axis"),
        (Fault::Busy, "busy"),
        (Fault::Uncertain, "uncertain"),
        (range, "range 3,-5,9223372036854775807"),
        (Fault::Own(Full(22)), "full 22"),
    ] {
        assert_eq!(Fault::read(format!("E {text}").as_bytes()), Some(fault));
        let word = text.split(' ').next().unwrap();
        let known = Refusal::named(word.as_bytes());
        assert!(fault == Fault::Own(Full(22)) || known.name() == word, "{word}");
    }
    for none in ["E", "Y", "E x", "E range 1", "E sum 1", "E full", "R"] {
        assert_eq!(Fault::<Full>::read(none.as_bytes()), None, "{none}");
    }
}
