//! Limit switches with bouncing contacts: `debounce-ms`.

use crate::conversation::{Board, MS, board, say, wait};
use stepwright_sim::{Pin, Queues};

fn steps(board: &mut Board<'_>) -> usize {
    board.recorder().iter().filter(|edge| edge.pin == Pin::Step && edge.level).count()
}

/// Opens and closes the switch of axis 1 for some ms; its pin is low when it is closed.
fn bounce(board: &mut Board<'_>, ms: u64) {
    let end = board.now() + ms * MS;
    let mut part = 1;
    while board.now() < end {
        part = part % 7 + 1;
        board.set_switch(0, part % 2 == 0);
        board.run_until(board.now() + part * MS / 3);
    }
}

/// The stop does not wait, and no bounce lets the motor go on.
#[test]
fn the_first_contact_stops_and_the_bounces_let_nothing_go_on() {
    for debounce in [0, 25, 250] {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        say(&mut board, &format!("$switches=1 $debounce-ms={debounce} T100 g-"));
        wait(&mut board, 1_500);
        board.set_switch(0, false);
        let before = steps(&mut board);
        wait(&mut board, 1);
        assert_eq!(say(&mut board, "F"), "R", "{debounce} ms");
        let stopped = steps(&mut board);
        assert!(stopped <= before + 1, "{debounce} ms: {} steps", stopped - before);
        bounce(&mut board, 20);
        wait(&mut board, 500);
        assert_eq!(steps(&mut board), stopped, "{debounce} ms");
        assert_eq!(say(&mut board, "V1"), format!("-{stopped}"));
    }
}

/// Between two bounces the switch reads open: an order towards it would make some steps into the switch.
#[test]
fn no_order_slips_in_between_two_bounces() {
    for debounce in [25u64, 1, 250] {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        say(&mut board, &format!("$switches=1 $debounce-ms={debounce} PO S5 T100 G-2000 E"));
        wait(&mut board, 1_000);
        board.set_switch(0, false);
        wait(&mut board, 1);
        let stopped = steps(&mut board);
        // It opens for the time of the setting, closes for a moment, and so on: it never counts as open.
        for _ in 0..20 {
            board.set_switch(0, true);
            for _ in 0..debounce.min(5) {
                assert_eq!(say(&mut board, "PO G-5 E"), "Y Y E", "{debounce} ms");
                board.run_until(board.now() + debounce * MS / debounce.min(5) - 8);
            }
            board.set_switch(0, false);
            board.run_until(board.now() + MS / 10);
        }
        assert_eq!(steps(&mut board), stopped, "{debounce} ms");
        // Open for nearly the time of the setting it counts as closed, a little longer as open. The last closed
        // sample was up to 50 µs before the contact opened.
        board.set_switch(0, true);
        let open = board.now();
        while board.now() < open + debounce * MS - MS / 5 {
            board.run_until(board.now() + MS / 10);
            let after = board.now() - open;
            assert_eq!(say(&mut board, "PO g- E"), "Y Y E", "{debounce} ms: {after} ticks");
        }
        assert_eq!(say(&mut board, "PO G+1 E"), "Y Y Y", "the way back is free meanwhile");
        wait(&mut board, 25);
        assert_eq!(say(&mut board, "F PO G-5 E"), "R Y Y Y", "{debounce} ms");
        board.run_to_rest();
        assert_eq!(steps(&mut board), stopped + 6);
    }
}

/// Without debouncing the first open sample counts as a release.
#[test]
fn without_debounce_an_open_switch_is_open_at_once() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "$switches=1 $debounce-ms=0");
    board.set_switch(0, false);
    wait(&mut board, 10);
    assert_eq!(say(&mut board, "PO G-5 E"), "Y Y E");
    board.set_switch(0, true);
    assert_eq!(say(&mut board, "PO G-5 E"), "Y Y Y");
}

/// Another axis is not held, nor an axis that no longer has a switch.
#[test]
fn a_bounce_holds_its_own_axis_and_only_while_it_has_a_switch() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "$switches=1 $debounce-ms=250");
    board.set_switch(0, false);
    wait(&mut board, 2);
    board.set_switch(0, true);
    assert_eq!(say(&mut board, "A2 PO A2 G-5 E"), "Y Y Y Y Y");
    board.run_to_rest();
    assert_eq!(say(&mut board, "A1 PO G-5 E"), "Y Y Y E");
    assert_eq!(say(&mut board, "$switches=0 PO G-5 E"), "Y Y Y Y");
}

/// Homing as a host does it: fast to the switch, away from it, and slowly to it again. The switch bounces
/// whenever it changes, and closes at −100.
#[test]
fn a_switch_that_bounces_is_found_at_the_same_step_each_time() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "$switches=1");
    let mut found = Vec::new();
    for round in 0..4u64 {
        for order in ["PO S5 T60 R50 G-500 E", "PO G+40 E", "PO S5 T5 R1 G-60 E"] {
            wait(&mut board, 60);
            assert!(say(&mut board, order).ends_with('Y'), "{round} {order}");
            // The contact chatters for 3 ms after its lever passes −100.
            let (mut inside, mut moved) = (board.position(0).unwrap() <= -100, 0);
            while board.is_busy() {
                board.run_until(board.now() + MS / 5);
                let now = board.position(0).unwrap() <= -100;
                if now != inside {
                    (inside, moved) = (now, board.now());
                }
                let chatters = board.now() < moved + 3 * MS;
                let closed = if chatters {
                    (board.now() / (MS / 5 * (round + 1))).is_multiple_of(2)
                } else {
                    inside
                };
                board.set_switch(0, !closed);
            }
        }
        found.push(board.position(0).unwrap());
        assert_eq!(say(&mut board, "PO G+60 E"), "Y Y Y");
        wait(&mut board, 1);
        board.set_switch(0, true);
        board.run_to_rest();
    }
    assert!(found.iter().all(|at| *at == found[0]), "{found:?}");
}
