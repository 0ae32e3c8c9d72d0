//! The engine on your own chip: any timer, any `embedded-hal` pins, any feed.
//!
//! On a chip `Timer` reads registers and `on_compare` stands in the interrupt;
//! here the pins print and the timer jumps to the next compare.
//!
//! `cargo run -p stepwright-sim --example 07_your_own_board`

use std::convert::Infallible;

use embedded_hal::digital::{ErrorType, OutputPin};
use stepwright::drive::{Pins, StepDir};
use stepwright::profile::{Cursor, Fit, Trapezoid};
use stepwright::queue::Queue;
use stepwright::timer::StepTimer;
use stepwright::{Accel, Engine, Rate, Run, Speed, Timing};

#[derive(Default)]
struct Timer {
    count: u32,
    compare: u32,
}

impl StepTimer for Timer {
    type Count = u32;
    const LINGER: u32 = 0;

    fn now(&mut self) -> u32 {
        self.count
    }
    fn wake_at(&mut self, at: u32) {
        self.compare = at;
    }
    fn hold_until(&mut self, at: u32) {
        self.count = at;
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

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut queue = Queue::<64>::new();
    let (mut planner, consumer) = queue.split();
    let pins = [Pins { step: Pin("step"), direction: Pin("dir"), invert_direction: false }];
    let timing = Timing { pulse: 2, setup: 1, hold: 1, min_interval: 10 };
    let mut engine = Engine::new(Timer::default(), StepDir::new(pins), [consumer], timing);

    // Foreground: plan 20 pulses; the first comes 100 ticks after the start.
    let law =
        Trapezoid::new(Rate::MHZ, Speed::ZERO, Speed::from_steps(500)?, Accel::from_steps(9000)?);
    planner.push(Run::steady(100, 1)).map_err(|_| "the queue is full")?;
    for run in Cursor::new(law.path(20)?, Fit::board(Rate::MHZ)) {
        planner.push(run).map_err(|_| "the queue is full")?;
    }
    engine.start(0b1);

    // Interrupt.
    while !engine.report(0).idle {
        engine.timer().count = engine.timer().compare;
        engine.on_compare();
    }
    println!("\nposition {} after {} µs", engine.report(0).position, engine.timer().count);
    assert_eq!(engine.report(0).position, 20);
    Ok(())
}
