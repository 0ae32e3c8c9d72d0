//! A virtual board with motors on coils makes the steps of STEP and DIR as rows of a table.

use stepwright_sim::{
    AxisDrive, Description, Edge, Pin, Queues, Shaft, VirtualBoard, vcd::VcdWriter,
};

const DRIVES: [&str; 7] = [
    "unipolar",
    "unipolar-wave",
    "unipolar-half",
    "bridge",
    "bridge-wave",
    "bridge-half",
    "shield",
];

/// An Uno with axes on these drives.
fn uno(drives: &[&str]) -> Description {
    let drives: Vec<AxisDrive> = drives.iter().map(|drive| drive.parse().unwrap()).collect();
    Description::uno().with_drives(&drives)
}

/// The edges while two axes go there and one comes back.
fn edges(description: Description) -> Vec<Edge> {
    let mut queues = Queues::default();
    let mut board: VirtualBoard<u16, Vec<Edge>> =
        VirtualBoard::new(&mut queues, description, Vec::new());
    for orders in [&[(1, "+401"), (2, "+77")][..], &[(1, "-150")]] {
        for (axis, way) in orders {
            let order = format!("A{axis}\rPO\rA{axis}\rS5\rT100\ra2375\rd2375\rG{way}\rE\r");
            order.bytes().for_each(|byte| board.receive(byte));
        }
        board.run_to_rest();
    }
    assert_eq!((board.position(0), board.position(1), board.late()), (Some(251), Some(77), 0));
    std::mem::take(board.recorder())
}

/// The times of an axis' steps.
fn steps(edges: &[Edge], axis: u8) -> Vec<u64> {
    let steps = edges.iter().filter(|edge| edge.axis == axis && edge.is_step());
    steps.map(|edge| edge.time).collect()
}

#[test]
fn coils_step_when_step_would() {
    let plain = edges(uno(&[]));
    let right = steps(&plain, 0);
    assert_eq!(right.len(), 551);
    for drive in DRIVES {
        let description = uno(&[&format!("1:{drive}")]);
        let found = edges(description);
        let mine = || found.iter().filter(|edge| edge.axis == 0);
        assert!(mine().all(|edge| matches!(edge.pin, Pin::Coil(_))), "{drive}");
        // All lines of a step change at one moment.
        let mut times: Vec<u64> = mine().map(|edge| edge.time).collect();
        times.dedup();
        assert_eq!(times, right, "{drive}");
        // By its rows, the shaft has gone there and back.
        let mut shaft = Shaft::of(&description, 0);
        let ways: Vec<bool> = mine().filter_map(|edge| shaft.follow(*edge)).collect();
        assert_eq!(shaft.position(), 251, "{drive}");
        assert!(ways[..401].iter().all(|way| *way) && ways[401..].iter().all(|way| !way));
        // The pulses of the other axis are unchanged.
        let others = |edges: &[Edge]| Vec::from_iter(edges.iter().filter(|e| e.axis == 1).copied());
        assert_eq!(others(&found), others(&plain), "{drive}");
    }
}

/// The Arduino driver's unipolar rows: 1001, 1100, 0110, 0011, of phases A to D, where a 1 does not conduct,
/// with the half steps between them.
#[test]
fn lines_have_the_rows_of_the_documents() {
    let full = ["0110", "0011", "1001", "1100"];
    let half = ["0110", "0010", "0011", "0001", "1001", "1000", "1100", "0100"];
    for (drive, rows) in [("unipolar", &full[..]), ("unipolar-half", &half)] {
        let description = uno(&[&format!("1:{drive}")]);
        let mine = description.pins().filter(|(axis, ..)| *axis == 0);
        let mut levels: Vec<bool> = mine.map(|(.., level)| level.unwrap()).collect();
        let text = |levels: &[bool]| -> String {
            levels.iter().map(|high| if *high { '1' } else { '0' }).collect()
        };
        assert_eq!(text(&levels), rows[0]);
        let edges = edges(description);
        let mut times = edges.iter().filter(|e| e.axis == 0).peekable();
        for step in 1..=401 {
            let time = times.peek().unwrap().time;
            while let Some(edge) = times.next_if(|edge| edge.time == time) {
                let Pin::Coil(line) = edge.pin else { panic!("{edge:?}") };
                levels[usize::from(line)] = edge.level;
            }
            assert_eq!(text(&levels), rows[step % rows.len()], "{drive}, step {step}");
        }
    }
}

/// The setting `reverse` also turns a motor on coils.
#[test]
fn an_axis_that_is_turned_round_goes_back_through_its_table() {
    let description = uno(&["1:bridge-half"]);
    let mut queues = Queues::default();
    let mut board: VirtualBoard<u16, Vec<Edge>> =
        VirtualBoard::new(&mut queues, description, Vec::new());
    "$reverse=1\rPO\rG+9\rE\r".bytes().for_each(|byte| board.receive(byte));
    board.run_to_rest();
    let mut shaft = Shaft::of(&description, 0);
    for edge in std::mem::take(board.recorder()) {
        shaft.follow(edge);
    }
    assert_eq!((board.position(0), shaft.position()), (Some(9), -9));
}

#[test]
fn a_dump_has_a_wire_for_each_line() {
    let description = Description { axes: 2, ..uno(&["2:bridge"]) };
    let pins: Vec<_> = description.pins().collect();
    let dump = VcdWriter::levels(Vec::new(), description.board.rate, &pins).finish(0).unwrap();
    let dump = String::from_utf8(dump).unwrap();
    let wires: Vec<_> = dump.lines().filter(|line| line.starts_with("$var")).collect();
    let names = ["a step1", "b dir1", "w10 coil2a", "w11 coil2b", "w12 coil2c", "w13 coil2d"];
    assert_eq!(wires, names.map(|name| format!("$var wire 1 {name} $end")));
    assert!(dump.ends_with("$dumpvars\n0a\nxb\n0w10\n1w11\n0w12\n1w13\n$end\n#0\n"), "{dump}");
}
