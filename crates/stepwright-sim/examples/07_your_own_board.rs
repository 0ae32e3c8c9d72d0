//! Motors on your own chip: any timer, any `embedded-hal` pins.
//!
//! On a chip `Timer` reads registers, `on_compare` is called by the interrupt, and the motors reach the engine
//! with the interrupt held off: see `10_interrupt.rs`. Here the pins print, the timer jumps to the next
//! compare, and the motors hold the engine itself. `tests/ports.rs` checks the timer with
//! `stepwright-port-test`.
//!
//! `cargo run -p stepwright-sim --example 07_your_own_board`

use std::convert::Infallible;

use embedded_hal::digital::{ErrorType, OutputPin};
use stepwright::drive::{Pins, StepDir};
use stepwright::queue::Queue;
use stepwright::timer::{Count, StepTimer};
use stepwright::{Accel, Axis, AxisLimits, Board, Engine, MoveError, Rate, Speed, Steppers};

#[derive(Default)]
pub(crate) struct Timer {
    pub(crate) count: u32,
    pub(crate) compare: u32,
}

impl StepTimer for Timer {
    type Count = u32;
    fn now(&mut self) -> u32 {
        self.count
    }
    /// A time that has passed matches at once.
    fn wake_at(&mut self, at: u32) {
        self.compare = if at.is_after(self.count) { at } else { self.count };
    }
}

struct Pin(&'static str);

impl ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_high(&mut self) -> Result<(), Infallible> {
        print!("{} ", self.0);
        Ok(())
    }
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

fn main() -> Result<(), MoveError> {
    let mut queue = Queue::<8>::new();
    let (feed, entries) = queue.split();
    let pins = [Pins { step: Pin("step"), direction: Pin("dir"), invert_direction: false }];
    // Up to 10,000 steps/s; more once you have measured the cost of a step on your chip.
    let board = Board::unmeasured(Rate::MHZ);
    let engine =
        Engine::new(Timer::default(), StepDir::new(pins), [entries], board.timing, board.rate);

    let mut motors = Steppers::new(engine, [feed], board);
    let limits = AxisLimits::new(Speed::of::<500>(), Accel::of::<9_000>());
    motors.set_limits(Axis::X, limits);
    motors.move_to(Axis::X, 20)?;
    while motors.is_moving(Axis::X) {
        motors.poll();
        // The interrupt.
        let engine = motors.engine();
        engine.timer().count = engine.timer().compare;
        engine.on_compare();
    }
    println!(
        "\nposition {:?} after {} µs",
        motors.position(Axis::X),
        motors.engine().timer().count
    );
    assert_eq!(motors.position(Axis::X), Some(20));
    Ok(())
}
