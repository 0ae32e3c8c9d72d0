//! Runs `stepwright-port-test` on a chip's step timer.

use core::cell::UnsafeCell;
use core::marker::PhantomData;
use core::mem::MaybeUninit;

use stepwright::timer::StepTimer;
use stepwright::{HoldOff, Ticks};
use stepwright_device::main_loop::SerialPort;
use stepwright_port_test::{Checked, TestPort, TimerFault, TimerProbe, check};

/// A step timer under test, for a static that its interrupt and the program share.
pub struct TimerTrial<T: StepTimer, H> {
    probe: UnsafeCell<MaybeUninit<TimerProbe<T>>>,
    hold_off: PhantomData<H>,
}

// SAFETY: the program uses the probe while the interrupt is held off, the interrupt otherwise.
unsafe impl<T: StepTimer + Send, H> Sync for TimerTrial<T, H> {}

impl<T: StepTimer, H: HoldOff> TimerTrial<T, H> {
    /// A trial without a timer.
    pub const fn empty() -> TimerTrial<T, H> {
        TimerTrial { probe: UnsafeCell::new(MaybeUninit::uninit()), hold_off: PhantomData }
    }

    /// The step interrupt.
    ///
    /// # Safety
    /// Called by the interrupt that `H` holds off, and by nothing else.
    pub unsafe fn on_compare(&self) {
        // SAFETY: `run` has set the probe before it let the interrupt in, and holds it off while it
        // uses it.
        unsafe { (*self.probe.get()).assume_init_mut() }.on_compare();
    }

    /// Tests a timer whose interrupt comes within `latency` ticks, and sends the result on the line
    /// again and again: `kept`, the number of deadlines, interrupts without a reason, whether the
    /// counter wrapped (1); or the name of the fault, and its numbers.
    ///
    /// # Safety
    /// Called once, while the step interrupt is held off.
    pub unsafe fn run(&'static self, timer: T, latency: Ticks, line: &mut impl SerialPort) -> ! {
        // SAFETY: the caller's promise.
        unsafe { (*self.probe.get()).write(TimerProbe::new(timer)) };
        let (what, numbers): (&[u8], _) = match check(&mut Tried(self), latency) {
            Ok(Checked { values, spurious, wrapped }) => {
                (b"kept", [values as i32, spurious as i32, wrapped.into()])
            }
            Err(TimerFault::StandsStill) => (b"stands-still", [0; 3]),
            Err(TimerFault::Backward) => (b"backward", [0; 3]),
            Err(TimerFault::Lost { ahead, waited }) => (b"lost", [ahead, waited, 0]),
            Err(TimerFault::Early { ahead, by }) => (b"early", [ahead, by, 0]),
        };
        loop {
            what.iter().for_each(|byte| send(line, *byte));
            for number in numbers {
                send(line, b' ');
                say(line, number);
            }
            send(line, b'\r');
        }
    }
}

/// The timer under test, for [`check`].
struct Tried<T: StepTimer + 'static, H: 'static>(&'static TimerTrial<T, H>);

impl<T: StepTimer, H: HoldOff> TestPort for Tried<T, H> {
    type Timer = T;

    fn with<R>(&mut self, ask: impl FnOnce(&mut TimerProbe<T>) -> R) -> R {
        H::hold();
        // SAFETY: the interrupt is held off, and `run` has set the probe.
        let answer = ask(unsafe { (*self.0.probe.get()).assume_init_mut() });
        H::release();
        answer
    }

    fn idle(&mut self) {}
}

/// Sends a byte, after waiting for room.
fn send(line: &mut impl SerialPort, byte: u8) {
    while !line.has_room() {}
    line.send(byte);
}

/// Sends a number in decimal digits.
fn say(line: &mut impl SerialPort, number: i32) {
    if number < 0 {
        send(line, b'-');
    }
    let (number, mut place) = (number.unsigned_abs(), 1_000_000_000);
    while place != 0 {
        if number >= place || place == 1 {
            send(line, b'0' + (number / place % 10) as u8);
        }
        place /= 10;
    }
}
