//! Orders of Austin's laws over a line with noise: with checksums a flipped bit moves nothing.

use stepwright_protocol::crc;
use stepwright_sim::{Description, Edge, LawBoard, Queues};

fn summed(line: &str) -> Vec<u8> {
    format!("{line}*{:02X}\r", line.bytes().fold(0, crc)).into_bytes()
}

/// What a board does that gets these lines one after another: its answers, its edges, its
/// position.
fn play(lines: &[Vec<u8>]) -> (String, Vec<Edge>, Option<i64>) {
    let mut queues = Queues::default();
    let mut board: LawBoard<'_, Vec<Edge>> =
        LawBoard::new(&mut queues, Description::uno(), Vec::new());
    let mut answers = Vec::new();
    for line in lines {
        for byte in line {
            board.receive(*byte);
            board.run_until(board.now() + 1_400);
            answers.extend(board.take_answers());
        }
    }
    while board.is_busy() {
        board.run_until(board.now() + 160_000);
    }
    answers.extend(board.take_answers());
    let position = board.position();
    (String::from_utf8(answers).unwrap(), board.recorder().clone(), position)
}

/// Every bit of each line of an order by the published listing, its end too. (A digit of a
/// checksum may become the small letter: that is the same order.)
#[test]
fn a_flipped_bit_of_an_order_moves_nothing() {
    let law = summed("F5000,1000");
    for steps in ["G12", "G-120", "R1"] {
        let order = [law.clone(), summed(steps)];
        let end = [summed("Z"), summed("V")];
        let (answers, whole, position) = play(&[&order[..], &end].concat());
        assert!(answers.starts_with("Y*88\rY*88\rY*88\r"), "{answers}");
        // What the pins do without any order.
        let none = play(&end).1;
        assert!(position.is_some_and(|at| at != 0) && whole.len() > none.len());
        for which in 0..order.len() {
            for bit in 0..8 * order[which].len() {
                let mut lines = order.to_vec();
                lines[which][bit / 8] ^= 1 << (bit % 8);
                let (answers, edges, position) = play(&[&lines[..], &end].concat());
                if edges != whole {
                    assert_eq!(edges, none, "{steps}, line {which}, bit {bit}: {answers}");
                    assert_eq!(position, Some(0));
                }
            }
        }
    }
}

/// Whoever writes without checksums is answered without.
#[test]
fn a_line_without_a_checksum_has_an_answer_without() {
    let (answers, edges, position) = play(&[b"F5000,1000\r".to_vec(), b"\nG7\r".to_vec()]);
    assert_eq!((&*answers, position), ("Y\rY\r", Some(7)));
    assert!(!edges.is_empty());
    let (answers, ..) = play(&[b"G7*00\r".to_vec(), summed("X")]);
    // "E sum" and "E line", each with its own checksum.
    let said = |text: &str| String::from_utf8(summed(text)).unwrap();
    assert_eq!(answers, said("E sum") + &said("E line"));
}
