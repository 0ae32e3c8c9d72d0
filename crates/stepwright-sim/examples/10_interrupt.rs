//! An engine in an interrupt, and motors in the main loop. On a PC a thread stands for the interrupt.
//!
//! `cargo run -p stepwright-sim --example 10_interrupt`

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use stepwright::drive::Drive;
use stepwright::timer::StepTimer;
use stepwright::{Accel, Axis, AxisLimits, Board, HoldOff, Rate, SharedEngine, Speed, Steppers};

/// Counts microseconds.
pub(crate) struct Timer(pub(crate) Instant);

impl StepTimer for Timer {
    type Count = u32;

    fn now(&mut self) -> u32 {
        self.0.elapsed().as_micros() as u32
    }
    /// The thread reads the time again and again, so no event is missed.
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

/// The interrupt of the timer. On a chip `hold` and `release` clear and set its enable bit; here `ENTERED` is a
/// lock. It is held off at power-up.
pub(crate) struct Interrupt;

static ENTERED: AtomicBool = AtomicBool::new(true);

// SAFETY: `serve` and every holder exclude each other, with acquire and release ordering.
unsafe impl HoldOff for Interrupt {
    fn hold() {
        while ENTERED.swap(true, Ordering::Acquire) {
            thread::yield_now();
        }
    }
    fn release() {
        ENTERED.store(false, Ordering::Release);
    }
}

/// Serves the interrupt until it is done.
pub(crate) fn serve(on_compare: impl Fn(), done: &AtomicBool) {
    while !done.load(Ordering::Relaxed) {
        Interrupt::hold();
        on_compare();
        Interrupt::release();
        thread::sleep(Duration::from_micros(50));
    }
}

static ENGINE: SharedEngine<Timer, Pins, Interrupt, 1> = SharedEngine::empty();
static DONE: AtomicBool = AtomicBool::new(false);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let board = Board::unmeasured(Rate::MHZ);
    let (engine, feeds) = ENGINE.fill(Timer(Instant::now()), Pins, &board).ok_or("filled twice")?;
    let interrupt = thread::spawn(|| {
        // SAFETY: this thread is the interrupt. On a chip its return value wakes a sleeping main loop.
        serve(|| _ = unsafe { ENGINE.on_compare() }, &DONE);
    });

    let mut motors = Steppers::new(engine, feeds, board);
    motors.set_limits(Axis::X, AxisLimits::new(Speed::of::<1_000>(), Accel::of::<9_000>()));
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
