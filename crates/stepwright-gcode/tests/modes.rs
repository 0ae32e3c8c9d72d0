//! What a block means: modes, offsets, signals, in the order of execution.

use crate::common::{self, table};
use stepwright_gcode::Reader;

#[test]
fn axis_words_move_in_the_motion_mode() {
    table(&[
        ("X1", "rapid X1 Y0 Z0"),
        (
            "G1 F200 X1\nY1\nG0 Z1\nX0",
            "feed F200 X1 Y0 Z0\nfeed F200 X1 Y1 Z0\nrapid X1 Y1 Z1\nrapid X0 Y1 Z1",
        ),
        ("G1\nF200\nX1", "feed F200 X1 Y0 Z0"),
        ("G1 F200 X0\nX-0.0", ""),
        ("G80\nG0 X1", "rapid X1 Y0 Z0"),
        ("G80 X1", "error 31 at 1:5"),
        ("G1 F1\nG80\nF2 Y1", "error 31 at 3:4"),
        ("G53", ""),
        ("G40 G61 G91.1 G49 G80", "ToolLength = X0 Y0 Z0"),
        ("G64\nG64 P0.01 X1\nG64 P0 G61.0", "rapid X1 Y0 Z0\nerror 21 at 3:8"),
        // P of a dwell is none of it; nor has G61 one.
        ("G64 G4 P1\nG61 P1", "dwell 1\nerror 36 at 2:5"),
    ]);
}

/// The last tolerance that was said holds, beyond the end of a program; that of a line with an error was not said.
#[test]
fn the_tolerance_is_a_mode() {
    let mut reader = Reader::default();
    for (line, tolerance) in [
        ("X1", "0"),
        ("G64 P0.01", "0.01"),
        ("G1 F9 X2", "0.01"),
        ("G64 P0.5 Q1", "0.01"),
        ("G64", "0"),
        ("G20 G64 P1", "25.4"),
        ("M2", "25.4"),
        ("G61", "0"),
    ] {
        for byte in line.bytes().chain(*b"\n") {
            reader.push(byte);
        }
        assert_eq!(reader.modal().tolerance.to_string(), tolerance, "{line}");
    }
}

#[test]
fn distances_and_units() {
    table(&[
        ("G91 X1\nX1 Y-2\nG90 X1", "rapid X1 Y0 Z0\nrapid X2 Y-2 Z0\nrapid X1 Y-2 Z0"),
        (
            "G20 X1\nG21 X1\nG20 Y-.00000001",
            "rapid X25.4 Y0 Z0\nrapid X1 Y0 Z0\nrapid X1 Y-0.000000254 Z0",
        ),
        ("G20 G1 F10 X1\nG21 X1", "feed F254 X25.4 Y0 Z0\nfeed F254 X1 Y0 Z0"),
        ("G91 G20 X1 Y1\nG90 X1 Y1", "rapid X25.4 Y25.4 Z0"),
    ]);
}

#[test]
fn feed_rates() {
    table(&[
        ("G1 X1", "error 22 at 1:1"),
        ("G1\nX1 Y1", "error 22 at 2:1"),
        ("F5 G1\nF0\nX1", "error 22 at 3:1"),
        ("G1 F100 X1\nF200\nX2", "feed F100 X1 Y0 Z0\nfeed F200 X2 Y0 Z0"),
        ("G93 G1 F2.5 X1\nX2\nF4 X3", "feed 1/2.5 X1 Y0 Z0\nerror 22 at 2:1\nfeed 1/4 X3 Y0 Z0"),
        ("G93 G0 X1\nG1 F0 X2", "rapid X1 Y0 Z0\nerror 22 at 2:1"),
        // The rate of one mode is none of the other.
        ("F100\nG93\nG1 X1", "error 22 at 3:1"),
        ("F100\nG93\nG94 G1 X1", "error 22 at 3:5"),
        ("G93 F3\nG94 F30 G1 X1", "feed F30 X1 Y0 Z0"),
        ("F100\nG94 G1 X1", "feed F100 X1 Y0 Z0"),
        // Inches do not change moves a minute.
        ("G20 G93 G1 F2 X1", "feed 1/2 X25.4 Y0 Z0"),
    ]);
}

#[test]
fn coordinate_systems() {
    table(&[
        ("G10 L2 P1 X10 Y20\nX1\nY1", "G54 = X10 Y20 Z0\nrapid X11 Y0 Z0\nrapid X11 Y21 Z0"),
        (
            "G10 L2 P2 X10\nX1\nG55 X1\nG54 X1",
            "G55 = X10 Y0 Z0\nrapid X1 Y0 Z0\nrapid X11 Y0 Z0\nrapid X1 Y0 Z0",
        ),
        ("G55 G10 L2 P0 Z5 Y-1\nY0\nZ0", "G55 = X0 Y-1 Z5\nrapid X0 Y-1 Z0\nrapid X0 Y-1 Z5"),
        ("G10 L2 P6 X1\nG10 L2 P6 Y2", "G59 = X1 Y0 Z0\nG59 = X1 Y2 Z0"),
        // The present position becomes 3 in it.
        ("X10\nG10 L20 P1 X3\nX4", "rapid X10 Y0 Z0\nG54 = X7 Y0 Z0\nrapid X11 Y0 Z0"),
        (
            "X10\nG10 L20 P3 X3\nX4\nG56 X4",
            "rapid X10 Y0 Z0\nG56 = X7 Y0 Z0\nrapid X4 Y0 Z0\nrapid X11 Y0 Z0",
        ),
        (
            "X10\nG92 X4\nG10 L20 P1 X0\nX1",
            "rapid X10 Y0 Z0\nG92 = X6 Y0 Z0\nG54 = X4 Y0 Z0\nrapid X11 Y0 Z0",
        ),
        ("G20 G10 L2 P1 X1 G91\nG21 G90 X0", "G54 = X25.4 Y0 Z0\nrapid X25.4 Y0 Z0"),
        ("G10 L2 P1 X5\nG53 X1\nX1", "G54 = X5 Y0 Z0\nrapid X1 Y0 Z0\nrapid X6 Y0 Z0"),
        ("X5\nG91 G53 G1 F9 X1\nX1", "rapid X5 Y0 Z0\nfeed F9 X1 Y0 Z0\nfeed F9 X2 Y0 Z0"),
    ]);
}

#[test]
fn offsets_of_g92_and_of_the_tool() {
    table(&[
        (
            "X10 Y5\nG92 X0\nX1\nG92.1\nX1",
            "rapid X10 Y5 Z0\nG92 = X10 Y0 Z0\nrapid X11 Y5 Z0\nG92 = X0 Y0 Z0\nrapid X1 Y5 Z0",
        ),
        (
            "X10\nG92 X0\nG92 X4 Z1\nX0 Z0",
            "rapid X10 Y0 Z0\nG92 = X10 Y0 Z0\nG92 = X6 Y0 Z-1\nrapid X6 Y0 Z-1",
        ),
        (
            "G10 L2 P1 X2\nX8\nG92 X0\nG55 X0",
            "G54 = X2 Y0 Z0\nrapid X10 Y0 Z0\nG92 = X8 Y0 Z0\nrapid X8 Y0 Z0",
        ),
        ("X3 G92.1", "G92 = X0 Y0 Z0\nrapid X3 Y0 Z0"),
        (
            "G43.1 Z2.5\nZ1\nG49\nZ1",
            "ToolLength = X0 Y0 Z2.5\nrapid X0 Y0 Z3.5\nToolLength = X0 Y0 Z0\nrapid X0 Y0 Z1",
        ),
        ("G43.1 Z2\nG92 Z0\nZ1", "ToolLength = X0 Y0 Z2\nG92 = X0 Y0 Z-2\nrapid X0 Y0 Z1"),
        (
            "G43.1 Z2\nZ0\nG10 L20 P1 Z1\nZ0",
            "ToolLength = X0 Y0 Z2\nrapid X0 Y0 Z2\nG54 = X0 Y0 Z-1\nrapid X0 Y0 Z1",
        ),
    ]);
}

#[test]
fn kept_positions() {
    table(&[
        ("X5 Y6\nG28.1\nX0\nG28", "rapid X5 Y6 Z0\nG28 = X5 Y6 Z0\nrapid X0 Y6 Z0\nrapid X5 Y6 Z0"),
        (
            "X5 Y6 Z7\nG30.1\nG91 G30 Z1\nG30 X-1 Y-1",
            "rapid X5 Y6 Z7\nG30 = X5 Y6 Z7\nrapid X5 Y6 Z8\nrapid X5 Y6 Z7\nrapid X4 Y5 Z7\nrapid X5 Y6 Z7",
        ),
        ("X5 Y6 Z7\nG28 Z9", "rapid X5 Y6 Z7\nrapid X5 Y6 Z9\nrapid X5 Y6 Z0"),
        ("G28", ""),
        ("G28.1 X3\nG28", "G28 = X0 Y0 Z0\nrapid X3 Y0 Z0\nrapid X0 Y0 Z0"),
        // A kept position is the machine's.
        (
            "X5\nG28.1\nG10 L2 P1 X1\nG28 X8",
            "rapid X5 Y0 Z0\nG28 = X5 Y0 Z0\nG54 = X1 Y0 Z0\nrapid X9 Y0 Z0\nrapid X5 Y0 Z0",
        ),
        // The motion mode stays.
        ("G1 F5 X1\nG28 X0\nX2", "feed F5 X1 Y0 Z0\nrapid X0 Y0 Z0\nfeed F5 X2 Y0 Z0"),
    ]);
}

#[test]
fn probes() {
    table(&[
        ("G38.2 Z-5 F20", "probe to! F20 X0 Y0 Z-5"),
        ("G38.3 F20 Z-5\nZ-6", "probe to? F20 X0 Y0 Z-5\nprobe to? F20 X0 Y0 Z-6"),
        ("F20 G38.4 X1", "probe off! F20 X1 Y0 Z0"),
        ("F20 G38.5 X1", "probe off? F20 X1 Y0 Z0"),
        ("F20 G38.2 X0", "error 33 at 1:5"),
        ("G38.2 X1", "error 22 at 1:1"),
    ]);
}

#[test]
fn a_probe_ends_where_the_caller_says() {
    let mut reader = stepwright_gcode::Reader::default();
    assert!(common::blocks(&mut reader, b"X1 Z2\nF20 G38.2 Z-5\n").iter().all(Result::is_ok));
    let mut touched = reader.position();
    touched.0[2] = stepwright_gcode::Length::from_picometres(-1_500_000_000).unwrap();
    reader.set_position(touched);
    let blocks = common::blocks(&mut reader, b"G10 L20 P1 Z0\nG91 G0 Z1\n");
    let words: Vec<_> = blocks
        .iter()
        .flat_map(|b| b.unwrap().effects().map(common::words).collect::<Vec<_>>())
        .collect();
    assert_eq!(words, ["G54 = X0 Y0 Z-1.5", "rapid X1 Y0 Z-0.5"]);
}

#[test]
fn signals_come_before_the_move_of_their_block() {
    table(&[
        (
            "X1 M3 S1000 M8 T2 G4 P.5",
            "tool 2\nspindle cw 1000\ncoolant flood\ndwell 0.5\nrapid X1 Y0 Z0",
        ),
        (
            "S5\nM4\nS6\nS6\nM4\nM5\nM5",
            "spindle off 5\nspindle ccw 5\nspindle ccw 6\nspindle off 6",
        ),
        ("M7\nM8\nM7\nM9\nM9", "coolant mist\ncoolant mist flood\ncoolant"),
        ("T1\nT1\nT0\nT255", "tool 1\ntool 0\ntool 255"),
        ("G4 P0\nG4 P1.5", "dwell 0\ndwell 1.5"),
        // A laser's power over two lines, without a stop between.
        (
            "M4 G1 F9 S1 X1\nS2 X2",
            "spindle ccw 1\nfeed F9 X1 Y0 Z0\nspindle ccw 2\nfeed F9 X2 Y0 Z0",
        ),
    ]);
}

#[test]
fn pauses_and_ends() {
    table(&[
        ("X1 M0\nM1 X2", "rapid X1 Y0 Z0\nPause\nrapid X2 Y0 Z0\nOptionalPause"),
        (
            "M3 S9 M8\nX1 M2",
            "spindle cw 9\ncoolant flood\nrapid X1 Y0 Z0\nspindle off 9\ncoolant\nEnd",
        ),
        ("M30\n%", "Rewind"),
        // G1, G17, G54, G90 and G94 hold behind an end; inches, the feed rate and offsets do.
        (
            "G20 F10 G10 L2 P2 X1\nG92 Y1\nG55 G18 G91 G0\nM2\nX1\nG2 X3 I1",
            "G55 = X25.4 Y0 Z0\nG92 = X0 Y-25.4 Z0\nEnd\nfeed F254 X25.4 Y0 Z0\n\
             cw F254 X76.2 Y0 Z0 about X50.8 Y0",
        ),
        ("G93\nM2\nX1", "End\nerror 22 at 3:1"),
    ]);
}

#[test]
fn all_that_a_block_can_do_at_once() {
    table(&[
        (
            "T9 S8 M3 M8 G4 P1 X1 M2",
            "tool 9\nspindle cw 8\ncoolant flood\ndwell 1\nrapid X1 Y0 Z0\nspindle off 8\ncoolant\nEnd",
        ),
        (
            "T9 S8 M3 M8 G49 G28.1 M30",
            "tool 9\nspindle cw 8\ncoolant flood\nToolLength = X0 Y0 Z0\nG28 = X0 Y0 Z0\n\
             spindle off 8\ncoolant\nRewind",
        ),
    ]);
}
