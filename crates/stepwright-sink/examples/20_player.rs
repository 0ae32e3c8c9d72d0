//! Motors that play by themselves: four axes over a model player, as over the PIO of an RP2040.
//!
//! `cargo run -p stepwright-sink --example 20_player`

use std::cell::Cell;

use stepwright::queue::Queue;
use stepwright::{Accel, Axis, AxisLimits, Board, Cost, Rate, Speed, Steppers};
use stepwright_sink::{ModelEdge, ModelPlayer, SinkEngine};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // 125 MHz; each axis makes a step every 4 µs at most, whatever the others do.
    let rate = Rate::of::<125_000_000>();
    let mut board = Board::<4> { cost: Cost::independent(500), ..Board::unmeasured(rate) };
    board.runs = u16::MAX; // a PC plans as fast as it is asked
    board.set_drivers(rate.micros(1), rate.micros(1), rate.micros(1));

    // The player tells each edge; a chip's makes it on a pin.
    let (steps, last) = (Cell::new([0u32; 4]), Cell::new(0));
    let player = ModelPlayer::<4, _>::new(|edge: ModelEdge| {
        if edge.step.is_some() {
            let mut all = steps.get();
            all[usize::from(edge.axis)] += 1;
            steps.set(all);
            last.set(edge.at);
        }
    });

    let mut queues = [const { Queue::<8>::new() }; 4];
    let [x, y, z, e] = queues.each_mut().map(Queue::split);
    let engine = SinkEngine::new(player, [x.1, y.1, z.1, e.1], board.timing, rate.micros(1));
    let mut motors = Steppers::new(engine, [x.0, y.0, z.0, e.0], board);
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        motors.set_limits(axis, AxisLimits::new(Speed::of::<250_000>(), Accel::of::<2_000_000>()));
    }

    motors.move_line_to([(Axis::X, 100_000), (Axis::Y, -60_000), (Axis::Z, 25_000)])?;
    while motors.any_moving() {
        while motors.poll() == Some(0) {} // all that is wanted now
        motors.engine().pass(125_000); // a millisecond
    }
    let ended = last.get() as f64 / 125e6;
    println!("{:?} steps in {ended:.4} s, {} times dry", steps.get(), motors.late());
    assert_eq!(steps.get(), [100_000, 60_000, 25_000, 0]);
    assert_eq!(motors.position(Axis::Y), Some(-60_000));
    assert_eq!(motors.late(), 0);
    Ok(())
}
