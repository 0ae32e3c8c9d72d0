//! Tests whether the step timer keeps the contract of `StepTimer`. `RESULT` has the answer: 1, or
//! the fault.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use avr_device::interrupt;
use stepwright_avr::slot::Slot;
use stepwright_avr::timer::Timer;
use stepwright_port_test::{TestPort, TimerFault, TimerProbe, check};

/// The result: see `firmware/rig/tests/port_test.rs`.
#[unsafe(no_mangle)]
static RESULT: Slot<[i16; 3]> = Slot::new([0; 3]);

static PROBE: Slot<Option<TimerProbe<Timer>>> = Slot::new(None);

stepwright_avr::handler!(TIMER1_COMPA, TIMER1_COMPA, {
    // SAFETY: this is the step interrupt; the foreground holds it off while it uses the probe.
    if let Some(probe) = unsafe { PROBE.get() } {
        probe.on_compare();
    }
});

struct Chip(&'static Slot<Option<TimerProbe<Timer>>>);

impl TestPort for Chip {
    type Timer = Timer;

    fn with<R>(&mut self, ask: impl FnOnce(&mut TimerProbe<Timer>) -> R) -> R {
        interrupt::free(|_| {
            // SAFETY: no interrupt comes; `main` has set the probe.
            let probe = unsafe { self.0.get() }.as_mut();
            // SAFETY: as above.
            ask(unsafe { probe.unwrap_unchecked() })
        })
    }

    fn idle(&mut self) {}
}

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: called once, with interrupts off.
    unsafe { *PROBE.get() = Some(TimerProbe::new(Timer::start())) };
    // SAFETY: everything that an interrupt uses is set up.
    unsafe { interrupt::enable() };
    // The interrupt, and the longest hold, take some hundred cycles.
    let result = match check(&mut Chip(&PROBE), 1_000) {
        Ok(checked) => [1, checked.values as i16, checked.wrapped.into()],
        Err(TimerFault::Lost { ahead, waited }) => [2, ahead as i16, waited as i16],
        Err(TimerFault::Early { ahead, by }) => [3, ahead as i16, by as i16],
        Err(TimerFault::Backward) => [4, 0, 0],
        Err(TimerFault::StandsStill) => [5, 0, 0],
    };
    // SAFETY: no interrupt reads it.
    unsafe { *RESULT.get() = result };
    loop {
        core::hint::spin_loop();
    }
}
