//! The Nano slave's conversation, three axes at once, and a dump for GTKWave.
//!
//! `cargo run -p stepwright-sim --example 06_serial_line > moves.vcd`

use std::io;

use stepwright_sim::vcd::VcdWriter;
use stepwright_sim::{Description, Queues, VirtualBoard};

fn main() -> io::Result<()> {
    let uno = Description::uno();
    let mut queues = Queues::default();
    let vcd = VcdWriter::new(io::stdout().lock(), uno.board.rate, uno.axes);
    let mut board: VirtualBoard<u16, _> = VirtualBoard::new(&mut queues, uno, Some(vcd));

    for line in ["PO", "S5", "T100", "R20", "G+300", "A2", "G-200", "A3", "t2500", "G+77", "E"] {
        for byte in line.bytes().chain([b'\r']) {
            board.receive(byte);
            // A byte takes 87 µs at 115200 baud.
            board.run_until(board.now() + uno.byte_time());
        }
        eprintln!("{line:6} {}", String::from_utf8_lossy(&board.take_answers()));
    }
    board.run_to_rest();
    for axis in 0..3 {
        eprintln!("axis {}: {:?}", axis + 1, board.position(axis));
    }
    let end = board.now();
    if let Some(vcd) = board.recorder().take() {
        drop(vcd.finish(end)?);
    }
    Ok(())
}
