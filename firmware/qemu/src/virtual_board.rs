//! The virtual board with the same description.

use stepwright::Board;
use stepwright_sim::{Description, Edge, Queues, VirtualBoard};

use crate::boards::Simulated;

/// The description of the virtual board.
pub fn description(of: &Simulated) -> Description {
    let Board { rate, cost, .. } = of.board;
    Description { board: of.board, ..Description::at(rate, cost) }
}

/// Makes a virtual board, and calls `play` with it.
pub fn with<R>(of: &Simulated, play: impl FnOnce(&mut VirtualBoard<'_, u32, Vec<Edge>>) -> R) -> R {
    let mut queues = Queues::default();
    play(&mut VirtualBoard::new(&mut queues, description(of), Vec::new()))
}

/// Sends it a line, and returns the answer.
pub fn ask(board: &mut VirtualBoard<'_, u32, Vec<Edge>>, line: &str) -> String {
    line.bytes().chain([b'\r']).for_each(|byte| board.receive(byte));
    String::from_utf8_lossy(&board.take_answers()).trim_end_matches('\r').to_owned()
}

/// The times of an axis's steps, in ticks.
pub fn steps(edges: &[Edge], axis: u8) -> Vec<u64> {
    edges.iter().filter(|edge| edge.axis == axis && edge.is_step()).map(|edge| edge.time).collect()
}
