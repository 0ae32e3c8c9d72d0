//! What holds for every line: how it is written changes nothing, and numbers are exact.

use std::str::FromStr;

use crate::common::{blocks, words};
use dashu_float::DBig;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use stepwright_gcode::{Effect, Error, Reader, SpindleMode};

/// Words that often make a block, and often do not.
fn any_word() -> impl Strategy<Value = String> {
    let codes = select(vec![
        "G0", "G1", "G2", "G3", "G4", "G10", "G17", "G18", "G19", "G20", "G21", "G28", "G28.1",
        "G38.2", "G43.1", "G49", "G53", "G54", "G56", "G80", "G90", "G91", "G92", "G92.1", "G93",
        "G94", "M0", "M3", "M4", "M5", "M7", "M8", "M9", "M30", "L2", "L20", "P0", "P2",
    ]);
    let value = (select("FIJKNRSTXYZ".chars().collect::<Vec<_>>()), -9_i32..=99, 0_u32..=9);
    prop_oneof![
        codes.prop_map(str::to_owned),
        value.prop_map(|(letter, whole, tenth)| format!("{letter}{whole}.{tenth}")),
        select("IJKRSXYZ".chars().collect::<Vec<_>>()).prop_map(|letter| format!("{letter}1")),
    ]
}

/// Lines of words, each with its effects in a fresh state or in that of the lines before.
fn lines() -> impl Strategy<Value = Vec<Vec<String>>> {
    vec(vec(any_word(), 0..6), 1..8)
}

fn said(text: &[u8]) -> Vec<Result<Vec<String>, Error>> {
    let mut reader = Reader::default();
    blocks(&mut reader, b"G1 F100\n");
    let blocks = blocks(&mut reader, text);
    blocks.into_iter().map(|block| Ok(block?.effects().map(words).collect())).collect()
}

/// A word with blanks, comments and small letters in it.
fn dressed(word: &str, noise: &[u8]) -> String {
    let mut noise = noise.iter().cycle();
    let mut text = String::new();
    for char in word.chars() {
        match noise.next() {
            Some(0) => text += " ",
            Some(1) => text += "\t ",
            Some(2) => text += "(G1 X9; it)",
            Some(3) => {
                text.push(char.to_ascii_lowercase());
                continue;
            }
            _ => {}
        }
        text.push(char);
    }
    text
}

proptest! {
    #[test]
    fn blanks_comments_and_case_change_nothing(lines in lines(), noise in vec(0_u8..8, 1..40)) {
        let plain: Vec<_> = lines.iter().map(|line| line.concat()).collect();
        let dressed: Vec<_> = plain.iter().map(|line| dressed(line, &noise) + ";X1 (").collect();
        let number = |said: Vec<Result<Vec<String>, Error>>| -> Vec<_> {
            said.into_iter().map(|said| said.map_err(|error| (error.line, error.fault))).collect()
        };
        let (plain, dressed) = (plain.join("\n") + "\n", dressed.join("\r\n") + "\r\n");
        prop_assert_eq!(number(said(plain.as_bytes())), number(said(dressed.as_bytes())));
    }

    #[test]
    fn the_order_of_words_changes_nothing(
        line in vec(any_word(), 1..7).prop_flat_map(|line| (Just(line.clone()), Just(line).prop_shuffle()))
    ) {
        let (line, shuffled) = line;
        let (line, shuffled) = (said(line.concat().as_bytes()), said(shuffled.concat().as_bytes()));
        prop_assert_eq!(line[0].as_ref().ok(), shuffled[0].as_ref().ok());
    }

    /// Against decimals of any length.
    #[test]
    fn numbers_are_exact_or_the_nearest(whole in "0{0,3}[0-9]{0,8}", fraction in "[0-9]{0,16}") {
        let text = format!("{whole}.{fraction}");
        let exact = DBig::from_str(&format!("0{whole}.{fraction}0")).unwrap();
        let exact = exact.with_precision(60).value();
        let ten = |n: i32| DBig::from_str(&format!("1e{n}")).unwrap();
        let round = |number: DBig| number.round().to_int().value();
        let spindle = said(format!("M3 S{text}\n").as_bytes());
        let mut reader = Reader::default();
        let found = blocks(&mut reader, format!("S{text}\nX{text}\nG20 X-{text}\n").as_bytes());
        if (whole.is_empty() && fraction.is_empty()) || exact >= ten(7) {
            prop_assert_eq!(found[0].unwrap_err().fault.number(), 2);
            prop_assert!(spindle[0].is_err());
            return Ok(());
        }
        let Some(Effect::Spindle(spindle)) = found[0].unwrap().effects().next() else {
            prop_assert_eq!(round(&exact * ten(11)), 0.into());
            return Ok(());
        };
        prop_assert_eq!(spindle.mode, SpindleMode::Off);
        let scaled = round(&exact * ten(11));
        prop_assert_eq!(scaled.clone(), spindle.speed.scaled().into());
        // Millimetres and inches of the number that is held.
        let scaled = DBig::from(scaled).with_precision(60).value();
        let millimetres = round(&scaled / DBig::from(100));
        let inches = round(scaled * DBig::from(254) / DBig::from(1000));
        let [x, inch] = [&found[1], &found[2]];
        for (found, picometres) in [(x, millimetres), (inch, -inches)] {
            let reach = DBig::from(picometres.clone());
            let in_range = reach <= ten(15) && reach >= -ten(15);
            prop_assert_eq!(found.is_ok(), in_range);
            if let Some(Effect::Move(part)) = found.ok().and_then(|block| block.effects().next()) {
                prop_assert_eq!(picometres, part.to.0[0].picometres().into());
            }
        }
    }
}
