//! The guards of a machine, on boards that have room for them: the lease, and the inputs that stop everything.

use crate::conversation::{Board, board, say, wait};
use stepwright_sim::Queues;

/// A word of the answer to `?`.
fn word(board: &mut Board<'_>, name: &str) -> String {
    let info = say(board, "?");
    info.split([' ', '=']).skip_while(|word| *word != name).nth(1).unwrap().to_owned()
}

// ---- Lease ----

#[test]
fn a_lease_holds_as_long_as_lines_come() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    assert_eq!(say(&mut board, "L300 A0 T100 g+"), "Y Y Y Y");
    for _ in 0..20 {
        wait(&mut board, 298);
        // A refused line counts as a line.
        assert_eq!(say(&mut board, "x"), "E");
        assert!(board.is_endless());
    }
    wait(&mut board, 298);
    // Half a line does not count.
    board.receive(b'F');
    assert!(board.is_endless(), "the silence is shorter still");
    wait(&mut board, 5);
    assert!(!board.is_endless() && board.is_busy(), "it brakes along its ramp");
    board.run_to_rest();
    assert_eq!(say(&mut board, "F F"), "E R");
    assert_eq!(
        (word(&mut board, "stop"), word(&mut board, "uncertain")),
        ("TTT".into(), "0".into())
    );
}

/// After its time a lease is over, moving or not: the next host may not know of it.
#[test]
fn a_lease_ends_with_its_silence_and_when_it_is_given_back() {
    for end in ["moving", "at rest", "given back"] {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        assert_eq!(say(&mut board, "L200"), "Y");
        match end {
            "moving" => {
                say(&mut board, "g+");
                wait(&mut board, 205);
                assert!(!board.is_endless(), "{end}");
                board.run_to_rest();
            }
            "at rest" => wait(&mut board, 205),
            _ => assert_eq!(say(&mut board, "L0"), "Y"),
        }
        assert_eq!(say(&mut board, "g+"), "Y", "{end}");
        wait(&mut board, 60_000);
        assert!(board.is_endless(), "{end}");
    }
}

/// The shorter of the two times counts, and the setting outlives the lease.
#[test]
fn a_lease_and_the_time_out_of_the_settings_both_hold() {
    for (timeout, lease, first) in [(100, 300, 100), (300, 100, 100), (300, 0, 300)] {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        say(&mut board, &format!("$timeout-ms={timeout} L{lease} T100 g+"));
        wait(&mut board, first - 2);
        assert!(board.is_endless(), "{timeout} {lease}");
        wait(&mut board, 5);
        assert!(!board.is_endless(), "{timeout} {lease}");
        board.run_to_rest();
        say(&mut board, "g+");
        wait(&mut board, timeout + 3);
        assert!(!board.is_endless(), "{timeout} {lease}: the setting stays");
    }
}

/// A lease may be requested and changed while an axis moves, and takes effect at once.
#[test]
fn a_lease_is_changed_on_the_way() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    say(&mut board, "T100 g+");
    wait(&mut board, 1_000);
    assert_eq!(say(&mut board, "L60000"), "Y");
    wait(&mut board, 59_990);
    assert_eq!(say(&mut board, "L1"), "Y");
    assert!(board.is_endless());
    wait(&mut board, 4);
    assert!(!board.is_endless());
}

// ---- Inputs ----

/// An input: its setting, its letter in `stop=`, and how to set it.
type Input = (&'static str, &'static str, fn(&mut Board<'_>, bool));

const INPUTS: [Input; 2] = [
    ("estop", "E", |board, high| board.set_emergency(high)),
    ("driver-fault", "D", |board, high| board.set_driver_fault(high)),
];

#[test]
fn an_active_input_stops_what_moves_at_once_and_refuses_orders() {
    for (setting, letter, set) in INPUTS {
        for level in [1, 2] {
            let high = level == 2;
            let mut queues = Queues::default();
            let mut board = board(&mut queues);
            set(&mut board, !high);
            assert_eq!(say(&mut board, &format!("${setting}={level}")), "Y");
            assert_eq!(say(&mut board, "A0 T100 g+ A1"), "Y Y Y Y");
            wait(&mut board, 1_500);
            assert!(board.is_endless());
            let edges = board.recorder().len();
            set(&mut board, high);
            wait(&mut board, 2);
            assert!(!board.is_busy(), "{setting} {level}");
            let stopped = board.recorder().len();
            // At 500 steps/s: at most one step of each axis, and no ramp.
            assert!(stopped - edges <= 6, "{setting} {level}: {}", stopped - edges);
            assert_eq!(word(&mut board, "stop"), letter.repeat(3));
            assert_eq!(
                (word(&mut board, "uncertain"), say(&mut board, "V1")),
                ("7".into(), "E".into())
            );
            // Nothing starts while the input is active, by any kind of order.
            for order in ["g+", "A0 g-", "PO G+5 E", "PO G+0 E"] {
                assert!(say(&mut board, order).ends_with('E'), "{setting} {level}: {order}");
                assert_eq!(word(&mut board, "last"), "fault", "{order}");
                say(&mut board, "A1");
            }
            wait(&mut board, 1_000);
            assert_eq!(board.recorder().len(), stopped, "{setting} {level}: it moves on");
            set(&mut board, !high);
            wait(&mut board, 2);
            assert_eq!(say(&mut board, "I1 PO G+5 E"), "Y Y Y Y", "{setting} {level}");
            board.run_to_rest();
            assert_eq!(say(&mut board, "V1"), "5");
            assert_eq!(word(&mut board, "stop"), format!("-{}", letter.repeat(2)));
        }
    }
}

/// An order that was begun before the stop is not carried out after it.
#[test]
fn an_input_at_rest_spoils_the_open_order_and_leaves_the_position() {
    for (setting, _, set) in INPUTS {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        say(&mut board, &format!("${setting}=1 PO G+7 E"));
        board.run_to_rest();
        wait(&mut board, 30);
        assert_eq!(say(&mut board, "PO G+7"), "Y Y");
        set(&mut board, false);
        wait(&mut board, 2);
        set(&mut board, true);
        wait(&mut board, 2);
        assert_eq!((say(&mut board, "E"), word(&mut board, "last")), ("E".into(), "fault".into()));
        assert_eq!((say(&mut board, "V1"), word(&mut board, "stop")), ("7".into(), "---".into()));
        assert_eq!(say(&mut board, "PO G+7 E"), "Y Y Y");
    }
}

#[test]
fn an_input_that_is_not_set_up_does_nothing() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    for (_, _, set) in INPUTS {
        set(&mut board, false);
    }
    assert_eq!(say(&mut board, "PO G+70 E"), "Y Y Y");
    board.run_to_rest();
    assert_eq!((say(&mut board, "V1"), word(&mut board, "stop")), ("70".into(), "---".into()));
}

// ---- Drivers after a kill ----

#[test]
fn a_kill_switches_the_drivers_off_where_it_is_set_to() {
    for (off, how) in [(0, "K"), (1, "K"), (0, "estop"), (1, "estop")] {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        say(&mut board, &format!("$kill-off={off} $estop=1 $enable-ms=20 T500 g+"));
        wait(&mut board, 500);
        assert!(!board.enable_level(), "a low level switches them on");
        if how == "K" {
            say(&mut board, "K");
        } else {
            board.set_emergency(false);
        }
        wait(&mut board, 2);
        assert!(!board.is_busy());
        assert_eq!(board.enable_level(), off == 1, "{how} {off}");
        board.set_emergency(true);
        wait(&mut board, 100);
        // The next order switches the drivers on, and waits for them.
        let steps = board.recorder().len();
        assert_eq!(say(&mut board, "I1 PO G+5 E"), "Y Y Y Y");
        assert!(!board.enable_level());
        wait(&mut board, 18);
        assert_eq!(board.recorder().len() == steps, off == 1, "{how} {off}");
        board.run_to_rest();
        assert_eq!(say(&mut board, "V1"), "5");
    }
}
