//! The three validation cases of the Arduino driver on the virtual board, number for number.
//!
//! The logs are in `stepwright_sim::timed::published`.

use stepwright::drive::sequence::{L6219_QUARTER, SHIELD};
use stepwright_sim::timed::published::{self, CALL_MS, DUMP_EVERY_MS, FIRST_DUMP_MS};
use stepwright_sim::timed::{TimedBoard, TimedLineBoard};
use stepwright_timed::fit::Hardware;
use stepwright_timed::{Call, Code, Control, Dump, Model, SetSpeed, Status};

const UNO: Hardware = Hardware::avr16(16_000_000);
const CASE_1: SetSpeed = published::CASE_1.order;
const CASE_2: SetSpeed = published::CASE_2.order;
const CASE_3: SetSpeed = published::CASE_3.order;

fn board(model: Model) -> TimedBoard {
    TimedBoard::new(UNO, model, SHIELD, CALL_MS)
}

/// Dumps at the log's times.
fn dumps(board: &mut TimedBoard, count: usize) -> Vec<Dump> {
    let begin = board.now();
    (0..count)
        .map(|k| {
            board.run_until(begin + board.clocks(FIRST_DUMP_MS + DUMP_EVERY_MS * k as f64));
            board.dump()
        })
        .collect()
}

fn rows(dumps: &[Dump]) -> Vec<[u32; 5]> {
    let row = |d: &Dump| [d.top, d.modification, d.steps_left, d.time, d.counts.into()];
    dumps.iter().map(row).collect()
}

#[test]
fn case_1_slower() {
    let log = published::CASE_1.log.to_vec();
    let mut board = board(Model::Latched);
    assert_eq!(board.set_speed(&CASE_1), Code::FINE);
    let dumps = dumps(&mut board, log.len());
    let [rows, wanted] = [rows(&dumps), log].map(|rows| {
        let exact = |row: &[u32; 5]| [row[0], row[1], row[3], row[4]];
        (rows.iter().map(exact).collect::<Vec<_>>(), rows.iter().map(|r| r[2]).collect::<Vec<_>>())
    });
    assert_eq!(rows.0, wanted.0);
    let off: Vec<_> = rows.1.iter().zip(&wanted.1).map(|(a, b)| a.abs_diff(*b)).collect();
    assert!(off.iter().all(|off| *off <= 1), "steps left: off by {off:?}");
    for dump in &dumps {
        assert_eq!((dump.control.bits(), dump.status, dump.update_ms), (0xF0, Status::NONE, 1000));
        assert_eq!(dump.end, 0);
    }

    // The end: 7 updates are never made, and after the stop all numbers except the time are 0.
    board.run_for_millis(1_500);
    assert!(!board.is_moving());
    assert_eq!(board.steps().len(), 8_900);
    assert_eq!(board.status(), Status::REACHED);
    assert_eq!(board.set_speed(&SetSpeed::STOP), Code::FINE);
    assert_eq!(board.dump(), Dump { time: 13_009, ..Dump::default() });
    assert_eq!(board.status(), Status::NONE);
}

/// The twelve updates of case 1: 15000 + 64·(2^k − 1).
#[test]
fn case_1s_updates() {
    let mut board = board(Model::Ideal);
    board.set_speed(&CASE_1);
    for k in 0..=12 {
        board.run_until(board.clocks(1_000.0 * f64::from(k) + 100.0));
        assert_eq!(board.dump().top, 15_000 + 64 * ((1 << k) - 1));
    }
}

/// A new top that took effect at once would give other counts than the log: this distinguishes the models.
#[test]
fn case_1_at_once_is_three_steps_off() {
    let mut board = board(Model::Ideal);
    board.set_speed(&CASE_1);
    let left: Vec<_> = dumps(&mut board, 13).iter().map(|dump| dump.steps_left).collect();
    assert_eq!(left[10..], [323, 140, 39]);
}

#[test]
fn case_2_faster() {
    let log = published::CASE_2.log.to_vec();
    for model in [Model::Latched, Model::Ideal] {
        let mut board = board(model);
        assert_eq!(board.set_speed(&CASE_2), Code::FINE);
        let dumps = dumps(&mut board, log.len());
        assert_eq!(rows(&dumps), log, "{model:?}");
        for dump in &dumps {
            assert_eq!((dump.control.bits(), dump.status), (0xF2, Status::NONE));
        }
        // The log ends before the eleventh update; after that the speed is fixed.
        board.run_for_millis(1_000);
        let dump = board.dump();
        assert_eq!((dump.top, dump.modification, dump.counts), (32_332, 1_164, 0));
        assert_eq!(dump.status, Status::SPIN_FIXED);
    }
}

/// Every update of case 2. The first comes at 1200 ms, with the fourth step of 300 ms, since the interrupt
/// checks only when it steps.
#[test]
fn case_2s_updates() {
    let mut board = board(Model::Ideal);
    board.set_speed(&CASE_2);
    let mut seen = Vec::new();
    while seen.len() < 11 {
        let due = board.due().unwrap();
        let before = board.dump().top;
        board.run_until(due);
        let dump = board.dump();
        if dump.top != before {
            seen.push((dump.top, dump.modification));
            if seen.len() == 1 {
                assert_eq!(board.now(), board.clocks(1_200.0));
            }
        }
    }
    let wanted = [
        (2_415_000, 1_192_500),
        (1_222_500, 596_250),
        (626_250, 298_125),
        (328_125, 149_062),
        (179_063, 74_531),
        (104_532, 37_265),
        (67_267, 18_632),
        (48_635, 9_316),
        (39_319, 4_658),
        (34_661, 2_329),
        (32_332, 1_164),
    ];
    assert_eq!(seen, wanted);
}

#[test]
fn case_3_polled_with_a_callback() {
    for model in [Model::Ideal, Model::Latched] {
        let mut board = board(model);
        assert_eq!(board.set_speed(&CASE_3), Code::FINE);
        assert_eq!(board.dump().control.bits(), 0xE2);
        let (mut calls, mut counts, mut after) = (Vec::new(), 0u32, 0u32);
        let mut last = board.millis();
        // The main loop: one millisecond per turn.
        for _ in 0..60_000 {
            board.run_for_millis(1);
            counts += 1;
            if board.millis() - last >= 50 {
                last = board.millis();
                board.update_check(|call| calls.push((call, counts)));
            }
            after += u32::from(!calls.is_empty());
        }
        assert_eq!(calls.len(), 1, "{model:?}: {calls:?}");
        assert_eq!(calls[0].0, Call::Reached);
        assert!(after > 1_000 && counts == 60_000, "the main loop runs on");
        assert_eq!(board.steps().len(), 10_000);
        let status = board.status();
        assert_eq!(status, Status::REACHED.and(Status::REACH_CALLED));
        assert_eq!(board.dump().top, 32_332);
    }
}

/// Austin: current on at the start, off after the last step. The phase is kept.
#[test]
fn an_l6219_rests_after_its_last_step() {
    let mut board = TimedBoard::new(UNO, Model::Ideal, L6219_QUARTER, 0);
    board.restore(5);
    let order = SetSpeed { limit: 3, ..SetSpeed::fixed(Control::DRV_EN, 32_000) };
    board.set_speed(&order);
    board.run_for_millis(50);
    let changes: Vec<_> =
        board.changes().iter().map(|change| (change.time, change.levels)).collect();
    let off = L6219_QUARTER.off();
    let row = |n: u8| L6219_QUARTER.levels(5 + n);
    let times = [0, 0, 32_000, 64_000, 96_000, 128_000];
    let levels = [off, row(0), row(1), row(2), row(3), off];
    assert_eq!(changes, times.into_iter().zip(levels).collect::<Vec<_>>());
    assert_eq!(board.steps().len(), 3);
    assert_eq!(board.phase(), 8);
}

/// Pins that an Uno does not have, or that belong to the serial line, are answered `E`, and the motor stays
/// wired as before.
#[test]
fn pins_of_another_board_are_refused_and_change_nothing() {
    let mut board = TimedLineBoard::uno();
    let mut say = |line: &str| {
        for byte in line.bytes().chain(*b"\r") {
            board.receive(byte);
            board.run_until(board.now() + 1_400);
        }
        board.run_until(board.now() + 8_000_000);
        String::from_utf8(board.take_answers()).unwrap()
    };
    let moves = ":M1,128,32000,3,0,0,0,0";
    for bad in
        [":W1,90,48,0,0,1,0,0,16,48,32", ":W1,65,48,0,0,1,0,0,16,48,32", ":W1,68,3,0,0,0,0,0,1,3,2"]
    {
        assert_eq!(say(bad), "E pins\r", "{bad}");
    }
    // The timer has no motor yet.
    assert_eq!(say(moves), "-4\r");
    for good in [":W1,68,252,0,0,1,0,0,16,48,32", ":W1,66,48,0,0,1,0,0,16,48,32"] {
        assert_eq!(say(good), "Y\r", "{good}");
    }
    assert_eq!(say(moves), "0\r");
    assert_eq!(say(":W1,66,192,0,0,1,0,0,64,192,128"), "E pins\r");
    assert_eq!(say(moves), "0\r");
    assert_eq!(board.program().steps().len(), 6);
}
