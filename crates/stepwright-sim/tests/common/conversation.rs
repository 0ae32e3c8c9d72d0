//! A virtual Uno, and the lines of a host.

use stepwright_sim::{Description, Edge, Queues, VirtualBoard};

pub type Board<'q> = VirtualBoard<'q, u16, Vec<Edge>>;

/// Ticks per millisecond.
pub const MS: u64 = 16_000;

pub fn board(queues: &mut Queues) -> Board<'_> {
    VirtualBoard::new(queues, Description::uno(), Vec::new())
}

/// Says these lines one after the other, and returns the answers.
pub fn say(board: &mut Board<'_>, lines: &str) -> String {
    for line in lines.split_whitespace() {
        line.bytes().chain([b'\r']).for_each(|byte| board.receive(byte));
    }
    String::from_utf8(board.take_answers()).unwrap().replace('\r', " ").trim_end().to_owned()
}

pub fn wait(board: &mut Board<'_>, ms: u64) {
    board.run_until(board.now() + ms * MS);
}
