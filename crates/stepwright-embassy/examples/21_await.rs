//! Moves that are awaited, joined and raced. On a PC a thread plays the interrupt, as in
//! `10_interrupt`.
//!
//! `cargo run -p stepwright-embassy --example 21_await`

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use embassy_futures::block_on;
use embassy_futures::join::join;
use embassy_futures::select::{Either, select};
use stepwright::drive::Drive;
use stepwright::timer::StepTimer;
use stepwright::{Accel, Axis, AxisLimits, Board, HoldOff, Rate, SharedEngine, Speed};
use stepwright_embassy::{Motors, News, Outcome};

/// Counts microseconds. The thread polls it continuously, so no wake-up is needed.
struct Timer(Instant);

impl StepTimer for Timer {
    type Count = u32;

    fn now(&mut self) -> u32 {
        self.0.elapsed().as_micros() as u32
    }
    fn wake_at(&mut self, _: u32) {}
}

/// Motors without pins.
struct Pins;

impl Drive for Pins {
    fn begin(&mut self, _: u8) {}
    fn end(&mut self, _: u8) {}
    fn direction(&mut self, _: u8, _: bool) {}
}

/// Whether the lock is taken. Who swaps it from false to true holds it; it starts taken, as
/// interrupts are off at power-up.
static ENTERED: AtomicBool = AtomicBool::new(true);

struct Interrupt;

// SAFETY: the thread and whoever holds exclude each other, in this order of memory.
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

static ENGINE: SharedEngine<Timer, Pins, Interrupt, 2> = SharedEngine::empty();
static NEWS: News = News::new();

fn main() {
    thread::spawn(|| {
        loop {
            Interrupt::hold();
            // SAFETY: this thread is the interrupt.
            let news = unsafe { ENGINE.on_compare() };
            Interrupt::release();
            if news {
                NEWS.tell();
            }
            thread::sleep(Duration::from_micros(50));
        }
    });
    let board = Board::unmeasured(Rate::MHZ);
    let (engine, feeds) = ENGINE.fill(Timer(Instant::now()), Pins, &board).expect("filled once");
    let motors = Motors::new(engine, feeds, board, &NEWS);

    let moves = async {
        let (mut x, mut y) = (motors.axis(Axis::X), motors.axis(Axis::Y));
        for axis in [&x, &y] {
            axis.set_limits(AxisLimits::new(Speed::of::<1_000>(), Accel::of::<9_000>()));
        }
        println!("x {}", x.move_to(300).await?);

        let (there, back) = join(x.move_to(0), y.move_by(-200)).await;
        println!("x {}, y {}", there?, back?);

        select(x.run(500), y.move_to(0)).await;
        println!("y is home, x goes on braking: {}", x.is_moving());
        println!("x rests at {:?}", x.rest().await);
        x.move_to(0).await
    };
    // The planner never ends.
    let Either::Second(end) = block_on(select(motors.plan(), moves));
    assert_eq!(end, Ok(Outcome::Reached { at: 0 }));
}
