//! A board after a reset: its position is known only if it is still true.

use crate::conversation::{Board, MS, say};
use stepwright_sim::{Description, Mark, Queues, Remains, Reset, VirtualBoard};

/// The state that a board leaves this many ms after these lines.
fn after(lines: &str, ms: u64) -> Remains {
    let mut queues = Queues::default();
    let mut board: Board<'_> = VirtualBoard::new(&mut queues, Description::uno(), Vec::new());
    say(&mut board, lines);
    board.run_until(ms * MS);
    board.remains()
}

/// The position of the first axis after a reset, and whether all positions are known.
fn found(reset: Reset, remains: Remains) -> (String, bool) {
    let mut queues = Queues::default();
    let mut board: Board<'_> =
        VirtualBoard::restarted(&mut queues, Description::uno(), Vec::new(), reset, remains);
    let info = say(&mut board, "?");
    let known = info.contains(" uncertain=0 ");
    // The reason, if they are not known.
    assert!(info.contains(if known { " stop=--- " } else { " uncertain=7 stop=RRR " }), "{info}");
    assert_eq!(board.position(0).is_some(), known);
    let position = say(&mut board, "V1");
    assert_eq!(say(&mut board, "I1 V1"), "Y 0");
    (position, known)
}

const STILL: (&str, u64) = ("? V1 $", 50);
const MOVED: (&str, u64) = ("PO T100 G+20 E", 2_000);
const MOVING: (&str, u64) = ("PO T100 G+2000 E", 900);

#[test]
fn the_table_of_resets_holds() {
    use Reset::*;
    let rows: [(Reset, [bool; 3]); 3] =
        [(Power, [true, true, false]), (Watchdog, [false; 3]), (Other, [true, false, false])];
    for (reset, known) in rows {
        for ((lines, ms), known) in [STILL, MOVED, MOVING].into_iter().zip(known) {
            let what = if known { ("0".to_owned(), true) } else { ("E".to_owned(), false) };
            assert_eq!(found(reset, after(lines, ms)), what, "{reset:?} after {lines}");
        }
        let faded = Remains { mark: Mark(0xFFFF), ..after(MOVED.0, MOVED.1) };
        assert_eq!(found(reset, faded).1, reset != Watchdog, "{reset:?}, no mark");
    }
}

/// A board is marked from an order until the last step is made: before it steps, and as long as it steps.
#[test]
fn the_mark_is_there_whenever_a_step_is_made() {
    let mut queues = Queues::default();
    let mut board: Board<'_> = VirtualBoard::new(&mut queues, Description::uno(), Vec::new());
    assert_eq!(board.remains().mark, Mark::NONE);
    for order in ["PO T999 S999 G+30 E", "@+90", "PO G-3 E", "g+", "K"] {
        say(&mut board, order);
        for _ in 0..3_000 {
            let before = board.recorder().len();
            let marked = board.remains().mark == Mark::MOVING;
            board.run_until(board.now() + 100);
            assert!(marked || board.recorder().len() == before, "{order}");
        }
    }
    assert!(!board.is_busy());
    assert_eq!(board.remains().mark, Mark::MOVED);
}
