//! The soft limits of a machine, on the whole virtual board: its steps keep them.

use crate::conversation::{Board, MS, say};
use stepwright_sim::{Description, Queues, VirtualBoard};

/// Says the lines, looks every ms until the board rests, and returns the extreme positions.
fn farthest(board: &mut Board<'_>, lines: &str) -> (i64, i64) {
    assert!(!say(board, lines).contains('E'), "{lines}");
    let (mut least, mut most) = (i64::MAX, i64::MIN);
    for _ in 0..60_000 {
        let to = board.now() + MS;
        board.run_until(to);
        let here = board.position(0).unwrap();
        (least, most) = (least.min(here), most.max(here));
        if say(board, "F") == "R" {
            return (least, most);
        }
    }
    panic!("it never rests: {lines}");
}

#[test]
fn a_g_never_passes_its_soft_limit() {
    let mut queues = Queues::default();
    let mut board: Board<'_> = VirtualBoard::new(&mut queues, Description::uno(), Vec::new());
    say(&mut board, "$soft-limits=1 $ahead-x=3000 $behind-x=7");
    for manner in ["S5 T100 R200", "s0 t9000 a20000 d5000", "s0 t9000 a16000 d5000 j400000"] {
        let (least, most) = farthest(&mut board, &format!("{manner} g+"));
        assert!(least >= -7, "{manner}: {least}");
        assert_eq!((most, board.position(0)), (3000, Some(3000)), "{manner}");
        assert!(say(&mut board, "?").contains(" stop=L-- errors=- "), "{manner}");
        let (least, _) = farthest(&mut board, "g-");
        assert_eq!((least, board.position(0)), (-7, Some(-7)), "{manner}");
    }
}

/// The limits hold for any change on the way: nearer, back, faster, slower.
#[test]
fn changes_on_the_way_keep_within_the_limits() {
    for change in ["@+3000", "@+10", "@-7", "t200", "t12000", "a90000", "a100", "d1"] {
        for when in [50, 300, 700] {
            let mut queues = Queues::default();
            let mut board: Board<'_> =
                VirtualBoard::new(&mut queues, Description::uno(), Vec::new());
            say(&mut board, "$soft-limits=1 $ahead-x=3000 $behind-x=7");
            say(&mut board, "s0 t6000 a20000 d9000 g+");
            let to = board.now() + when * MS;
            board.run_until(to);
            say(&mut board, change);
            let (least, most) = farthest(&mut board, "F V1");
            assert!(least >= -7 && most <= 3000, "{change} at {when} ms: {least} to {most}");
        }
    }
}
