//! An engine in an interrupt, and motors in the main loop: on a PC a thread is the interrupt.
//!
//! `cargo run -p stepwright-sim --example 10_interrupt`

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use stepwright::drive::Drive;
use stepwright::queue::{Consumer, Queue};
use stepwright::timer::StepTimer;
use stepwright::{Accel, Axis, AxisLimits, Board, Engine, MoveError};
use stepwright::{Rate, SharedEngine, Speed, Steppers};

/// Counts microseconds.
struct Timer(Instant);

impl StepTimer for Timer {
    type Count = u32;
    const LINGER: u32 = 0;

    fn now(&mut self) -> u32 {
        self.0.elapsed().as_micros() as u32
    }
    /// The thread looks at the time all the while.
    fn wake_at(&mut self, _: u32) {}
}

/// Rising edges of STEP.
static STEPS: AtomicU32 = AtomicU32::new(0);

struct Pins;

impl Drive for Pins {
    fn begin(&mut self, _: u8) {
        STEPS.fetch_add(1, Ordering::Relaxed);
    }
    fn end(&mut self, _: u8) {}
    fn direction(&mut self, _: u8, _: bool) {}
}

static ENGINE: SharedEngine<Engine<Timer, Pins, Consumer<'static, 8>, 1>> = SharedEngine::empty();
static DONE: AtomicBool = AtomicBool::new(false);

fn main() -> Result<(), MoveError> {
    // On a chip: a static cell's.
    let (feed, entries) = Box::leak(Box::<Queue<8>>::default()).split();
    let board = Board::unmeasured(Rate::MHZ);
    let engine =
        ENGINE.fill(Engine::new(Timer(Instant::now()), Pins, [entries], board.timing, board.rate));
    let interrupt = thread::spawn(|| {
        while !DONE.load(Ordering::Relaxed) {
            ENGINE.on_compare();
            thread::sleep(Duration::from_micros(50));
        }
    });

    let mut motors = Steppers::new(engine, [feed], board);
    let limits = AxisLimits::new(Speed::from_steps(1_000)?, Accel::from_steps(9_000)?);
    motors.set_limits(Axis::X, limits);
    for target in [300, 100] {
        motors.move_to(Axis::X, target)?;
        while motors.is_moving(Axis::X) {
            motors.poll();
            thread::sleep(Duration::from_millis(1));
        }
        println!("at {:?}, {} late steps", motors.position(Axis::X), motors.late());
    }
    DONE.store(true, Ordering::Relaxed);
    let ended = interrupt.join().is_ok();
    assert!(ended && motors.position(Axis::X) == Some(100));
    assert_eq!(STEPS.load(Ordering::Relaxed), 500);
    Ok(())
}
