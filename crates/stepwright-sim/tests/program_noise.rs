//! Orders of Austin's laws, the timed driver and motor cycles over a line with noise: with checksums a flipped
//! bit moves nothing.

use std::cell::Cell;

use stepwright::Rate;
use stepwright_cycle::{Clock, Leg, Motor};
use stepwright_protocol::crc;
use stepwright_sim::timed::TimedLineBoard;
use stepwright_sim::{
    CycleBoard, CycleLineBoard, Description, Edge, LawBoard, ProgramBoard, Queues, SimProgram,
    Stand,
};

fn summed(line: &str) -> Vec<u8> {
    format!("{line}*{:02X}\r", line.bytes().fold(0, crc)).into_bytes()
}

/// Sends these lines, 50 ms apart, lets a second pass, and returns the answers.
fn play<P: SimProgram, const L: usize>(
    board: &mut ProgramBoard<P, L>,
    lines: &[Vec<u8>],
) -> String {
    let mut answers = Vec::new();
    for line in lines {
        for byte in line {
            board.receive(*byte);
            board.run_until(board.now() + 1_400);
            answers.extend(board.take_answers());
        }
        board.run_until(board.now() + 800_000);
        answers.extend(board.take_answers());
        // A host repeats the refused line before it sends others; the lines below stop a motion.
        if answers.contains(&b'E') {
            break;
        }
    }
    for byte in b"\rZ\r" {
        board.receive(*byte);
    }
    let _ = board.take_answers();
    board.run_until(board.now() + 16_000_000);
    answers.extend(board.take_answers());
    String::from_utf8(answers).unwrap()
}

/// Flips every bit of each line of an order, including its end. `steps` plays lines on a new board, and returns
/// the answers and the number of steps. A flip may turn a digit of the checksum into a small letter: that is
/// the same order.
fn try_every_bit(order: &[&str], mut steps: impl FnMut(&[Vec<u8>]) -> (String, usize)) {
    let order: Vec<_> = order.iter().map(|line| summed(line)).collect();
    // Lines that end an incomplete last line, and stop a motion.
    let end = [summed("F"), summed("Z")];
    let (answers, whole) = steps(&[&order[..], &end].concat());
    assert!(whole > 0 && !answers.contains('E'), "{whole} steps: {answers}");
    for which in 0..order.len() {
        for bit in 0..8 * order[which].len() {
            let mut lines = order.clone();
            lines[which][bit / 8] ^= 1 << (bit % 8);
            let same = lines[which].eq_ignore_ascii_case(&order[which]);
            let (answers, made) = steps(&[&lines[..], &end].concat());
            // Only in the checksum do small letters count as capitals: a row's letter in the other case is
            // another row.
            let digit = bit / 8 >= order[which].len() - 3;
            let wanted = if same && digit { whole } else { 0 };
            assert_eq!(made, wanted, "line {which}, bit {bit}: {answers}");
        }
    }
}

#[test]
fn a_flipped_bit_of_an_order_by_a_law_moves_nothing() {
    for steps in [":G12", ":G-120", ":R1"] {
        try_every_bit(&[":F5000,1000", steps], |lines| {
            let mut queues = Queues::default();
            let mut board: LawBoard<'_, Vec<_>> =
                LawBoard::new(&mut queues, Description::uno(), Vec::new());
            let answers = play(&mut board, lines);
            (answers, board.recorder().iter().filter(|edge| edge.is_step()).count())
        });
    }
}

#[test]
fn a_flipped_bit_of_an_order_to_the_timed_driver_moves_nothing() {
    let order = [":W1,66,48,0,0,1,0,0,16,48,32", ":M1,128,32000,0,0,0,0,0"];
    try_every_bit(&order, |lines| {
        let mut board = TimedLineBoard::uno();
        let answers = play(&mut board, lines);
        (answers, board.program().steps().len())
    });
}

fn legs() -> [Cell<Leg>; 4] {
    [const { Cell::new(Leg::Wait { count: 0, delay: 0 }) }; 4]
}

/// A board with three motors that plays cycles.
fn cycles(legs: &[Cell<Leg>]) -> CycleLineBoard<'_, Vec<Edge>, 3> {
    let (motors, stands) = ([Motor::new(1, 1); 3], [Stand::default(); 3]);
    let rate = Rate::from_hz(16_000_000).unwrap();
    CycleLineBoard::new(CycleBoard::new(motors, stands, Clock::Deadlines, rate, Vec::new()), legs)
}

#[test]
fn a_flipped_bit_of_a_cycle_moves_nothing() {
    for order in [
        &[":M0,10,1000,0,0,0,0,0", ":S0,0,12,1000", ":G1"][..],
        &[":M1,10,1000,0,0,0,0,0", ":A0,-7,1000", ":A1,9,2000", ":L1,0,0,2", ":G9"],
        &[":M2,10,1000,0,0,0,0,0", ":D2,0,-40,3000,1000,100", ":G200"],
    ] {
        try_every_bit(order, |lines| {
            let legs = legs();
            let mut board = cycles(&legs);
            let answers = play(&mut board, lines);
            let motors = board.program().hold();
            (answers, motors.with_recorder(|edges| edges.iter().filter(|e| e.is_step()).count()))
        });
    }
}

/// A line without a checksum is answered without one.
#[test]
fn a_line_without_a_checksum_has_an_answer_without() {
    let mut queues = Queues::default();
    let mut board: LawBoard<'_, ()> = LawBoard::new(&mut queues, Description::uno(), ());
    let answers = play(&mut board, &[b":F5000,1000\r".to_vec(), b"\n:G7\r".to_vec()]);
    assert_eq!((&*answers, board.position(0)), ("Y\rY\r", Some(7)));
    let said = |text: &str| String::from_utf8(summed(text)).unwrap();
    assert_eq!(play(&mut board, &[b":G7*00\r".to_vec()]), said("E sum"));
    assert_eq!(play(&mut board, &[summed(":X")]), said("E line"));
}

#[test]
fn the_common_rows_are_every_programs() {
    let mut queues = Queues::default();
    let mut laws: LawBoard<'_, ()> = LawBoard::new(&mut queues, Description::uno(), ());
    let mut timed = TimedLineBoard::uno();
    let lines = [b"F\rV1\rI1\rZ\rK\r".to_vec()];
    assert_eq!(play(&mut laws, &lines), "R\r0\rY\rY\rY\r");
    // The timed driver counts no position.
    assert_eq!(play(&mut timed, &lines), "R\rE axis\rE axis\rY\rY\r");
    let legs = legs();
    let mut cycles = cycles(&legs);
    assert_eq!(play(&mut cycles, &lines), "R\r0\rY\rY\rY\r");
    let about = [b"?\r".to_vec()];
    for about in [play(&mut laws, &about), play(&mut timed, &about), play(&mut cycles, &about)] {
        assert!(about.starts_with("stepwright-") && about.contains(" can=sum"), "{about}");
    }
}
