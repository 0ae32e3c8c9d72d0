//! What guards a machine, on the boards that have room for it: the lease.

use stepwright_sim::{Description, Edge, Queues, VirtualBoard};

type Board<'q> = VirtualBoard<'q, u16, Vec<Edge>>;

/// Ticks of a millisecond.
const MS: u64 = 16_000;

fn board(queues: &mut Queues) -> Board<'_> {
    VirtualBoard::new(queues, Description::uno(), Vec::new())
}

/// Says these lines, one after the other; the answers.
fn say(board: &mut Board<'_>, lines: &str) -> String {
    for line in lines.split_whitespace() {
        line.bytes().chain([b'\r']).for_each(|byte| board.receive(byte));
    }
    String::from_utf8(board.take_answers()).unwrap().replace('\r', " ").trim_end().to_owned()
}

fn wait(board: &mut Board<'_>, ms: u64) {
    board.run_until(board.now() + ms * MS);
}

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
        // A line that is refused is a line too.
        assert_eq!(say(&mut board, "x"), "E");
        assert!(board.is_endless());
    }
    wait(&mut board, 298);
    // Half a line is none.
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

/// A lease has run out then, moving or not: who comes next may know nothing of it.
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

/// The shorter silence of the two counts, and the setting outlives the lease.
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

/// It may be asked for and changed on the way, and the change holds at once.
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
