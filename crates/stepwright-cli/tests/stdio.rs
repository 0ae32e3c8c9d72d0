//! Conversations with `stepwright board --stdio --fast`, and how they end.
//!
//! In a script a space stands for CR, so that it reads as it is answered, and
//! `_` for a second of line feeds: a pause.

use crate::common::{Ended, Scratch, stepwright_with};

/// This many bytes take a second at 115200 baud.
const SECOND: usize = 11_520;

fn bytes(script: &str) -> Vec<u8> {
    script
        .bytes()
        .flat_map(|byte| match byte {
            b' ' => vec![b'\r'],
            b'_' => vec![b'\n'; SECOND],
            byte => vec![byte],
        })
        .collect()
}

fn board(script: &str) -> Ended {
    stepwright_with(&["board", "--stdio", "--fast"], &bytes(script))
}

/// Answers and the report at the end are exactly these, the status 0.
#[track_caller]
fn plays(script: &str, answers: &str, report: &str) {
    let ended = board(script);
    let heard = ended.stdout.replace('\r', " ");
    assert_eq!(
        (heard.as_str(), ended.stderr.trim_end(), ended.code()),
        (answers, report, Some(0)),
        "{script}"
    );
}

const ORDER: &str = "PO S5 T100 R200 G+4000 E ";

#[test]
fn the_documents_example() {
    plays(ORDER, "Y Y Y Y Y Y ", "position 4000 ready");
    plays("P0 S5 T100 R200 G-4000 E ", "Y Y Y Y Y Y ", "position -4000 ready");
}

#[test]
fn busy_on_the_way_and_ready_at_the_end() {
    plays(
        &format!("{ORDER}F S6 PO Z9 _____F V1 "),
        "Y Y Y Y Y Y B E E E R 4000 ",
        "position 4000 ready",
    );
}

#[test]
fn the_position_is_told_on_the_way() {
    // After 1 s: 0.38 s of ramp for 200 steps, then 1000 steps/s.
    let ended = board(&format!("{ORDER}_V1 "));
    let position: i64 = ended.stdout.split('\r').nth(6).unwrap().parse().unwrap();
    assert!((815..=825).contains(&position), "{position}");
}

#[test]
fn a_soft_stop_keeps_the_position() {
    let ended = board(&format!("{ORDER}_Z F _F V1 "));
    let answers: Vec<&str> = ended.stdout.trim_end().split('\r').skip(6).collect();
    let [y, busy, ready, position] = answers[..] else { panic!("{ended:?}") };
    assert_eq!((y, busy, ready), ("Y", "B", "R"));
    // It ran at 1000 steps/s, and the ramp down is 200 steps; the board has
    // planned up to 24 ms ahead.
    let at: i64 = position.parse().unwrap();
    assert!((1015..=1050).contains(&at), "{at}");
    assert_eq!(ended.stderr, format!("position {at} ready\n"));
}

#[test]
fn a_kill_loses_the_position_until_it_is_set() {
    plays(
        &format!("{ORDER}_K F V1 I1 V1 PO G+10 E "),
        "Y Y Y Y Y Y Y R E Y 0 Y Y Y ",
        "position 10 ready",
    );
    plays(&format!("{ORDER}_K "), "Y Y Y Y Y Y Y ", "position uncertain");
    plays("K V1 ", "Y 0 ", "position 0 ready");
}

#[test]
fn an_endless_run_stops_by_z() {
    let ended = board("g- _Z _F V1 ");
    assert!(ended.stdout.starts_with("Y\rY\rR\r-10"), "{ended:?}");
    assert_eq!(ended.code(), Some(0));
    // Inside an order it waits for E.
    plays("PO g+ F V1 ", "Y Y R 0 ", "position 0 ready");
}

#[test]
fn an_endless_run_at_the_end_of_the_input_is_braked_and_is_an_error() {
    let ended = board("g+ _");
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    assert!(ended.stderr.contains("without end: braking it\n"), "{ended:?}");
    assert!(ended.stderr.contains("\nposition 10"), "{ended:?}");
    assert!(ended.stderr.contains(" ready\n"), "{ended:?}");
    ended.assert_error("without end");
    // One that is braked already comes to rest by itself.
    let ended = board("g+ _Z ");
    assert_eq!(ended.code(), Some(0), "{ended:?}");
}

#[test]
fn more_axes_are_reported_before_the_first() {
    plays(
        "PO G+30 A2 G-20 E A3 F _V2 V3 ",
        "Y Y Y Y Y Y R -20 0 ",
        "axis 2 position -20 ready\nposition 30 ready",
    );
    plays("A3 PO A3 G+7 E ", "Y Y Y Y Y ", "axis 3 position 7 ready\nposition 0 ready");
}

#[test]
fn the_board_tells_about_itself() {
    plays(
        "? ",
        "stepwright 0.1 axes=3 max=128000 late=0 refused=0 last=none uncertain=0 stop=--- errors=- can=jerk,safety,sum closed=0 ",
        "position 0 ready",
    );
    plays(
        "PO t200000 a100000000 G+99999 E ? ! ? ",
        "Y Y Y Y E stepwright 0.1 axes=3 max=128000 late=0 refused=1 last=too-fast uncertain=0 stop=--- errors=- can=jerk,safety,sum closed=0 \
         Y stepwright 0.1 axes=3 max=128000 late=0 refused=0 last=none uncertain=0 stop=--- errors=- can=jerk,safety,sum closed=0 ",
        "position 0 ready",
    );
}

#[test]
fn garbage_is_answered_e_and_moves_nothing() {
    plays("hello G+5 E po S0 T1000 G5 ", "E E E E E E E ", "position 0 ready");
    plays("PO G+5 T9999 E ", "Y Y E E ", "position 0 ready");
    let long = "G+".to_owned() + &"0".repeat(5000) + "5 F ";
    plays(&long, "E R ", "position 0 ready");
    let mut noise: Vec<u8> = (0..60_000u32).map(|n| ((n * n) >> 7) as u8).collect();
    noise.extend(b"\rK\rI1\rF\r");
    let ended = stepwright_with(&["board", "--stdio", "--fast"], &noise);
    assert!(ended.stdout.ends_with("Y\rY\rR\r"), "{ended:?}");
    assert_eq!((ended.stderr.as_str(), ended.code()), ("position 0 ready\n", Some(0)));
}

#[test]
fn half_a_line_is_not_carried_out_and_is_told() {
    for (script, answers) in [("PO G+5 E", "Y Y "), ("F\n", "")] {
        let ended = board(script);
        assert_eq!(ended.stdout.replace('\r', " "), answers, "{script}");
        assert!(ended.stderr.starts_with("position 0 ready\nerror: "), "{ended:?}");
        ended.assert_error("within a line, which was not carried out");
    }
    plays("", "", "position 0 ready");
    plays("\nF\n \n", "R ", "position 0 ready");
}

#[test]
fn the_same_script_does_the_same_to_the_tick() {
    let script = bytes("PO S5 t1003 R77 A2 s0 t777 a900 d1200 G+4000 A1 G-3000 E _V1 V2 Z _V1 ");
    let dumps: Vec<(String, Vec<u8>)> = ["one.vcd", "two.vcd"]
        .iter()
        .map(|name| {
            let file = Scratch::new(name);
            let args = ["board", "--stdio", "--fast", "--vcd", file.path()];
            let ended = stepwright_with(&args, &script);
            assert_eq!(ended.code(), Some(0), "{ended:?}");
            (ended.stdout, std::fs::read(&file.0).unwrap())
        })
        .collect();
    assert!(dumps[0].1.len() > 10_000);
    assert_eq!(dumps[0], dumps[1]);
}

#[test]
fn in_real_time_it_ends_alike() {
    let ended = stepwright_with(&["board", "--stdio"], &bytes("PO T100 G+40 E "));
    assert_eq!((ended.stdout.as_str(), ended.code()), ("Y\rY\rY\rY\r", Some(0)));
    assert_eq!(ended.stderr, "position 40 ready\n");
}

#[test]
fn other_boards() {
    let other = |args: &[&str], script: &str| {
        let args = [&["board", "--stdio", "--fast"], args].concat();
        stepwright_with(&args, &bytes(script))
    };
    let ended = other(&["--timer-hz", "1000000", "--timer-bits", "32", "--axes", "1"], "? A2 ");
    // A step costs 8 µs of this timer.
    assert_eq!(
        ended.stdout,
        "stepwright 0.1 axes=1 max=125000 late=0 refused=0 last=none uncertain=0 stop=- errors=- can=jerk,safety,sum closed=0\rE\r"
    );
    for bits in ["16", "32"] {
        for hz in ["100000", "2000000", "200000000"] {
            let ended = other(&["--timer-hz", hz, "--timer-bits", bits], ORDER);
            assert_eq!(ended.stderr, "position 4000 ready\n", "{bits} {hz}");
        }
    }
    let ended = other(&["--timer-hz", "5"], "");
    assert_eq!(ended.code(), Some(2), "{ended:?}");
    ended.assert_error("100000 to 200000000");
    for wrong in [&["--axes", "4"][..], &["--timer-bits", "8"], &["--pty"]] {
        assert_eq!(other(wrong, "").code(), Some(2), "{wrong:?}");
    }
}
