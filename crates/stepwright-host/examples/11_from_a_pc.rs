//! Moves a motor to 25 mm, on the port that is the argument, or on a virtual board.

use stepwright_host::{Board, Error, MotionLimits};

const STEPS_PER_MM: i64 = 80;

fn main() -> Result<(), Error> {
    let mut board = match std::env::args().nth(1) {
        Some(port) => Board::open(port)?,
        None => Board::virtual_uno(false)?,
    };
    println!("{}", board.axis(1)?.move_to(25 * STEPS_PER_MM, &MotionLimits::default())?);
    Ok(())
}
