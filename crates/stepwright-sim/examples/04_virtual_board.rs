//! A motor that moves: the real engine on simulated pins.
//!
//! `cargo run -p stepwright-sim --example 04_virtual_board`

use stepwright::profile::Ramp;
use stepwright::{Accel, Order, Speed, Travel};
use stepwright_sim::{Description, Edge, Queues, VirtualBoard};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut queues = Queues::default();
    let mut board: VirtualBoard<u16, Vec<Edge>> =
        VirtualBoard::new(&mut queues, Description::uno(), Vec::new());

    let order = Order {
        start: Speed::ZERO,
        top: Speed::from_steps(4000)?,
        up: Ramp::Accel(Accel::from_steps(10_000)?),
        down: Ramp::Accel(Accel::from_steps(20_000)?),
        jerk: None,
        travel: Travel::By(-4000),
    };
    let controller = board.controller();
    controller.group.start(controller.engine, [(0, order)])?;

    // The motor moves in the background; look at it every 200 ms.
    while board.is_busy() {
        board.run_until(board.now() + 16_000_000 / 5);
        println!("position {:?}", board.position(0));
    }
    let steps = board.recorder().iter().filter(|edge| edge.is_step()).count();
    println!("{steps} steps emitted, {} late", board.late());
    assert_eq!((board.position(0), steps, board.late()), (Some(-4000), 4000, 0));

    // Faster than the board can step is refused before anything moves.
    let too_fast =
        Order { top: Speed::from_steps(200_000)?, travel: Travel::Endless(true), ..order };
    let controller = board.controller();
    println!("{}", controller.group.start(controller.engine, [(0, too_fast)]).unwrap_err());
    Ok(())
}
