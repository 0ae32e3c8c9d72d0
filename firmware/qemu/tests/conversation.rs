//! Conversations with the controller, compared with the virtual board.

use stepwright_qemu::boards::CONTROLLERS;
use stepwright_qemu::{Machine, Pace, Simulated, machine, virtual_board};

/// Plays a table on every board: see [`talk_with`]. The steps are the same on all.
fn talk(table: &str) -> [usize; 3] {
    let [steps, others @ ..] = CONTROLLERS.map(|board| talk_with(board, table));
    assert!(
        table.contains('~') || others.iter().all(|other| *other == steps),
        "{others:?}, {steps:?}"
    );
    steps
}

/// Plays a table on a board and on the virtual one: a line and its answer, with `*` for any
/// characters. `*rest` waits for the end of the travel. A line begins with `~` if its answer
/// depends on the moment: the two boards may then differ. Returns the number of steps of each axis,
/// the same on both unless it depended on a moment.
fn talk_with(board: &Simulated, table: &str) -> [usize; 3] {
    let name = board.name;
    let mut chip = Machine::start(board, "controller", Pace::Quick).unwrap();
    let ideal = virtual_board::with(board, |board| {
        for row in table.lines().map(str::trim).filter(|row| !row.is_empty()) {
            let (line, pattern) = row.split_once(' ').unwrap_or((row, ""));
            if line == "*rest" {
                chip.rest().unwrap();
                for line in ["A0", "F", "A1"] {
                    virtual_board::ask(board, line);
                }
                board.run_to_rest();
                continue;
            }
            let (line, moment) = line.strip_prefix('~').map_or((line, false), |line| (line, true));
            let line = line.replace("\"\"", "");
            let real = chip.ask(&line).expect(row);
            let ideal = virtual_board::ask(board, &line);
            assert!(matches(&real, pattern.trim()), "{name}, {row}: {real}");
            assert!(moment || real == ideal, "{name}, {row}: {real:?}, not {ideal:?}");
        }
        [0, 1, 2].map(|axis| virtual_board::steps(board.recorder(), axis).len())
    });
    let edges = chip.end().unwrap();
    let real = [0, 1, 2].map(|axis| machine::steps(&edges, axis).len());
    assert!(table.contains('~') || real == ideal, "{name}: {real:?} steps, not {ideal:?}");
    real
}

/// Whether `text` matches `pattern`, in which each `*` stands for anything.
fn matches(text: &str, pattern: &str) -> bool {
    match pattern.split_once('*') {
        Some((begin, rest)) => text.strip_prefix(begin).is_some_and(|left| {
            left.char_indices().map(|(at, _)| &left[at..]).chain([""]).any(|end| matches(end, rest))
        }),
        None => text == pattern,
    }
}

#[test]
fn the_travel_order_of_the_document() {
    let steps = talk(
        "F       R
         PO      Y
         S5      Y
         T100    Y
         R200    Y
         G+400   Y
         E       Y
         F       B
         ~V1     *
         *rest
         V1      400
         P0      Y
         G-1234  Y
         E       Y
         *rest
         V1      -834",
    );
    assert_eq!(steps, [1634, 0, 0]);
}

/// At a step a second, so that it still moves when it is killed, however long the lines before
/// take.
#[test]
fn while_busy_no_line_of_an_order_is_taken() {
    talk(
        "T1      Y
         g+      Y
         PO      E
         S5      E
         T5      E
         R5      E
         G+5     E
         g-      E
         E       E
         I1      E
         F       B
         ~V1     *
         A1      Y
         ?       stepwright * last=busy uncertain=0*
         !       Y
         Z       Y
         Z       Y
         K       Y
         F       R
         V1      E
         I1      Y
         V1      0",
    );
}

/// At a step a second, for the same reason.
#[test]
fn drive_until_stopped() {
    talk(
        "T1      Y
         g-      Y
         F       B
         Z       Y
         F       B
         *rest
         F       R
         ~V1     -*",
    );
}

#[test]
fn a_kill_loses_the_position() {
    talk("K Y\nV1 0\nT1 Y\ng+ Y\nK Y\nF R\nV2 0\n~V1 *\nI1 Y\nV1 0");
}

#[test]
fn nothing_one_and_two_steps() {
    let orders = [("G+0", 0), ("G+1", 1), ("G+2", 3), ("G-2", 1), ("G-1", 0)];
    let rows =
        orders.map(|(line, position)| format!("PO Y\n{line} Y\nE Y\n*rest\nV1 {position}\n"));
    assert_eq!(talk(&rows.concat()), [6, 0, 0]);
}

#[test]
fn what_cannot_be_is_refused_and_nothing_moves() {
    let steps = talk(
        "E       E
         PO      Y
         T1000   E
         G+4000  Y
         E       E
         ?       stepwright * last=range uncertain=0*
         PO      Y
         t1000000 Y
         a100000000 Y
         d100000000 Y
         G+50000 Y
         E       E
         ?       stepwright * last=too-fast uncertain=0*
         G+-5    E
         V9      E
         12345678901234567 E
         T100    Y
         \"\"    E
         F       R",
    );
    assert_eq!(steps, [0; 3]);
}

/// Settings take effect, are kept and listed; an axis turns the other way round.
#[test]
fn settings() {
    let steps = talk(
        "$           max-speed=1000000 * pulse-us=2 reverse=0 *
         $pulse-us=7 Y
         $reverse=2  Y
         $max-speed=300 Y
         $           max-speed=300 * pulse-us=7 reverse=2 *
         PO          Y
         t301        Y
         G+10        Y
         E           E
         PO          Y
         t300        Y
         G+10        Y
         A2          Y
         t200        Y
         G-20        Y
         E           Y
         *rest
         V1          10
         V2          -20",
    );
    assert_eq!(steps, [10, 20, 0]);
}

/// 24 random orders for one to three axes, with ramps of every kind: refusals and final positions
/// agree with the virtual board after each.
#[test]
fn random_travels_end_where_the_virtual_board_ends() {
    let mut seed = 7u64;
    let mut random = |below: u32| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as u32 % below
    };
    let mut rows = String::new();
    for _ in 0..24 {
        rows += "A0 Y\nPO Y\n";
        for axis in 1..=1 + random(3) {
            let steps = random(600) as i32 - 300;
            let jerk = random(2) * random(90_000);
            let (start, top) = (random(300), 300 + random(5_000));
            let (up, down) = (1_000 + random(6_000), 1_000 + random(6_000));
            rows += &format!(
                "A{axis} Y\ns{start} Y\nt{top} Y\na{up} Y\nd{down} Y\nj{jerk} Y\nG{steps:+} Y\n"
            );
        }
        rows += "E *\n*rest\nV1 *\nV2 *\nV3 *\n";
    }
    rows += "? * late=0 *";
    let steps = talk(&rows);
    assert!(steps.iter().all(|steps| *steps > 100), "{steps:?}");
}
