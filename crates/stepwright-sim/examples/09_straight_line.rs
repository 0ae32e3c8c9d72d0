//! Three axes along a straight line: one order, scaled for each, so that all begin and
//! end together.
//!
//! `cargo run -p stepwright-sim --example 09_straight_line`

use stepwright::profile::Ramp;
use stepwright::{Accel, Order, Speed, Travel};
use stepwright_sim::{Description, Edge, Pin, Queues, VirtualBoard};

/// The first side of stepper_h's triangle.
const WAY: [i32; 3] = [20_000, 6_666, 2_666];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut queues = Queues::default();
    let mut board: VirtualBoard<u16, Vec<Edge>> =
        VirtualBoard::new(&mut queues, Description::uno(), Vec::new());
    let ramp = Ramp::Accel(Accel::from_steps(40_000)?);
    let order = Order {
        start: Speed::ZERO,
        top: Speed::from_steps(15_000)?,
        up: ramp,
        down: ramp,
        jerk: None,
        // How far, the line says.
        travel: Travel::By(0),
    };
    let controller = board.controller();
    controller.group.start(controller.engine, order.along(WAY)?)?;
    board.run_to_rest();

    for axis in 0..3u8 {
        let steps = board.recorder().iter();
        let steps = steps.filter(|e| e.axis == axis && e.pin == Pin::Step && e.level);
        let times: Vec<u64> = steps.map(|edge| edge.time).collect();
        let (first, last) = (times[0], times[times.len() - 1]);
        let ms = |ticks: u64| ticks as f64 / 16_000.0;
        println!(
            "axis {axis}: {:>6} steps, the first at {:.3} ms, the last at {:.3} ms",
            times.len(),
            ms(first),
            ms(last)
        );
        assert_eq!(board.position(axis), Some(WAY[usize::from(axis)].into()));
    }
    Ok(())
}
