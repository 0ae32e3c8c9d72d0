//! Does the step timer keep the contract of `StepTimer`? The line says so.
#![no_std]
#![no_main]

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

use stepwright::HoldOff;
use stepwright_controller::try_timer;
use stepwright_nrf51::timer::{StepInterrupt, Timer};
use stepwright_nrf51::uart::{self, Uart};
use stepwright_port_test::{TestPort, TimerProbe};

/// What one side has while the other can't come.
#[repr(transparent)]
struct Slot<T>(UnsafeCell<T>);
// SAFETY: `main` and the interrupt take turns: see where they take it.
unsafe impl<T> Sync for Slot<T> {}

static PROBE: Slot<MaybeUninit<TimerProbe<Timer>>> = Slot(UnsafeCell::new(MaybeUninit::uninit()));

#[unsafe(no_mangle)]
extern "C" fn TIMER0() {
    // SAFETY: `main` has put it there before it let the interrupt in, and holds it off while it
    // has the probe.
    unsafe { (*PROBE.0.get()).assume_init_mut() }.on_compare();
}

struct Chip;

impl TestPort for Chip {
    type Timer = Timer;

    fn with<R>(&mut self, ask: impl FnOnce(&mut TimerProbe<Timer>) -> R) -> R {
        StepInterrupt::hold();
        // SAFETY: the interrupt is held off, and `main` has put it there.
        let answer = ask(unsafe { (*PROBE.0.get()).assume_init_mut() });
        StepInterrupt::release();
        answer
    }

    fn idle(&mut self) {}
}

#[unsafe(no_mangle)]
extern "C" fn UART0() {
    // SAFETY: this is the line's interrupt.
    unsafe { uart::on_receive() };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: once, and no interrupt is let in yet.
    unsafe { (*PROBE.0.get()).write(TimerProbe::new(Timer::start())) };
    // SAFETY: once.
    let mut line = unsafe { Uart::start() };
    // 1,000 ticks: the interrupt, and what it finds.
    try_timer(&mut Chip, 1_000, &mut line)
}
