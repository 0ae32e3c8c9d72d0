//! Run endlessly, brake from anywhere, and know where you are.
//!
//! `cargo run -p stepwright-sim --example 05_stop_anywhere`

use stepwright::profile::Ramp;
use stepwright::{Order, Speed, Travel};
use stepwright_sim::{Description, Queues, VirtualBoard};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut queues = Queues::default();
    let mut board: VirtualBoard<u16, ()> = VirtualBoard::new(&mut queues, Description::uno(), ());
    let order = Order {
        start: Speed::from_steps(50)?,
        top: Speed::from_steps(1000)?,
        up: Ramp::Steps(200),
        down: Ramp::Steps(200),
        jerk: None,
        travel: Travel::Endless(true),
    };
    let millisecond = 16_000;
    let controller = board.controller();
    controller.group.start(controller.engine, [(2, order)])?;
    board.run_until(700 * millisecond);
    println!("after 700 ms at {:?}", board.position(2));

    // A soft stop: along the ramp, position kept.
    board.controller().group.brake(2);
    board.run_to_rest();
    println!("braked, at rest at {:?}", board.position(2));
    assert!(board.position(2).is_some());

    // A kill: at once, and the position is uncertain until it is set.
    let controller = board.controller();
    controller.group.start(controller.engine, [(2, order)])?;
    board.run_until(board.now() + 700 * millisecond);
    let controller = board.controller();
    controller.group.kill(controller.engine);
    println!("killed: position {:?}", board.position(2));
    assert_eq!(board.position(2), None);
    Ok(())
}
