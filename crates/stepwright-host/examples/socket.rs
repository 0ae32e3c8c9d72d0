//! Moves a motor to 25 mm on the board behind a socket, with tokio:
//! `cargo run --example socket --features tokio HOST:PORT`.

use stepwright_host::{AsyncBoard, Error, MotionLimits};

const STEPS_PER_MM: i64 = 80;

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Error> {
    let place = std::env::args().nth(1).unwrap_or_else(|| "127.0.0.1:4000".to_owned());
    let mut board = AsyncBoard::connect(place).await?;
    let to = 25 * STEPS_PER_MM;
    println!("{}", board.axis(1)?.move_to(to, &MotionLimits::default()).await?);
    Ok(())
}
