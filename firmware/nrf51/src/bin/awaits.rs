//! Moves that are awaited without an executor. It is linked like the controller, so nothing in
//! `stepwright-embassy` can panic.
#![no_std]
#![no_main]

use core::fmt::Write;
use core::pin::{Pin, pin};
use core::task::{Context, Poll, Waker};

use cortex_m::asm;
use stepwright::{Axis, Control, MoveError, SharedEngine, Speed};
use stepwright_embassy::{Motors, News, Outcome};
use stepwright_nrf51::board::BOARD;
use stepwright_nrf51::pins::StepPins;
use stepwright_nrf51::timer::{StepInterrupt, Timer};
use stepwright_nrf51::uart::Uart;

static ENGINE: SharedEngine<Timer, StepPins, StepInterrupt, 3> = SharedEngine::empty();
static NEWS: News = News::new();

#[unsafe(no_mangle)]
extern "C" fn TIMER0() {
    // SAFETY: this is the step interrupt.
    if unsafe { ENGINE.on_compare() } {
        NEWS.tell();
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: each of them once.
    let (timer, pins, mut line) = unsafe { (Timer::start(), StepPins::new(), Uart::to_talk()) };
    if let Some((engine, feeds)) = ENGINE.fill(timer, pins, &BOARD) {
        let motors = Motors::new(engine, feeds, BOARD, &NEWS);
        let reached = moves(&motors) == Ok(()) && motors.late() == 0;
        let _ = line.write_str(if reached { "reached\r" } else { "not reached\r" });
    }
    loop {
        asm::wfe();
    }
}

/// There and back, a run that another handle stops, and a fault.
fn moves(motors: &Motors<'_, impl Control, 3>) -> Result<(), MoveError> {
    let mut plan = pin!(motors.plan());
    let (mut x, mut y) = (motors.axis(Axis::X), motors.axis(Axis::Y));
    for target in [400, 100] {
        if wait(plan.as_mut(), pin!(x.move_to(target)))? != (Outcome::Reached { at: target }) {
            return Err(MoveError::PositionUnknown);
        }
    }
    {
        let mut run = pin!(y.run(-300));
        // The first poll begins it.
        if run.as_mut().poll(&mut Context::from_waker(Waker::noop())).is_pending() {
            let mut other = motors.axis(Axis::Y);
            other.set_top_speed(Speed::of::<200>())?;
            wait(plan.as_mut(), pin!(motors.motion(Axis::Y)));
            let _ = wait(plan.as_mut(), pin!(other.stop()));
        }
        let _ = wait(plan.as_mut(), run)?;
    }
    motors.fault(Axis::Z);
    motors.kill(Axis::Z);
    motors.stop();
    if motors.axis(Axis::Z).retarget(5).is_ok() || motors.with(|all| all.any_moving()) == Some(true)
    {
        return Err(MoveError::PositionUnknown);
    }
    y.set_position(-2)?;
    let _ = wait(plan.as_mut(), pin!(y.move_by(2)))?;
    drop(y.move_to(0)); // never polled
    wait(plan.as_mut(), pin!(y.rest()));
    Ok(())
}

/// Polls a future to its end. Every wake-up comes from an interrupt here.
fn wait<T>(mut plan: Pin<&mut impl Future>, mut future: Pin<&mut impl Future<Output = T>>) -> T {
    let mut context = Context::from_waker(Waker::noop());
    loop {
        // It never ends, and may have more to do at once.
        let _ = plan.as_mut().poll(&mut context);
        if let Poll::Ready(end) = future.as_mut().poll(&mut context) {
            return end;
        }
        asm::wfe();
    }
}
