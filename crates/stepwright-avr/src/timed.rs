//! The timed driver on a chip: a motor's windings and a timer of 16 bits.
//!
//! ```text
//!   counter   ╱│╱│╱│╱│╱│╱│╱│╱│╱    freely, at the I/O clock
//!   OCRnA      ·   ·   ·  ·   ·    absolute; what is longer than a lap is several
//!   steps      │          │   │
//! ```
//!
//! The Arduino driver restarts the counter at each step (fast PWM), and divides its clock. Here the
//! counter runs freely, and the article's prescaler is arithmetic: stepwright-timed's fit computes
//! it, with its rounding. So no tick is lost however late the interrupt comes; a shortened top
//! can't be missed, because the deadline is compared with the counter after it was set; and a
//! change of the prescaler, which on an AVR several timers share and which keeps dividing all the
//! time, costs nothing. CTC, whose counter restarts too, would have all three problems. Fast PWM's
//! late compare register is modelled in software: `Model::Latched`. The example `fast_pwm` uses the
//! article's method.
//!
//! | file | content |
//! | --- | --- |
//! | `timer` | the counter and its compare register |
//! | `port` | the pins of windings |
//! | `shield` | the motor shield's pins |
//! | `io_clock` | the I/O clock, from the fuses and CLKPR |
//! | `example` | the common part of the article's cases |

pub mod example;
mod io_clock;
mod port;
pub mod shield;
mod timer;

pub use io_clock::io_clock_now;
pub use port::{AnyPort, Pins, PortB};
#[cfg(feature = "mega")]
pub use port::{PortA, PortH};
pub use timer::{Timer, Timer1};
#[cfg(feature = "mega")]
pub use timer::{Timer3, Timer4, Timer5};

use avr_device::interrupt;
pub use stepwright::drive::Sequence;
use stepwright::drive::{Coils, Port, sequence::SHIELD};
use stepwright_timed::line::Wire;
use stepwright_timed::{Hold, Pace, Stepper, WiredMotor};

use crate::guarded::Guarded;
use crate::laps::Laps;
use crate::slot::Slot;

/// One motor, owned by the step interrupt.
pub struct Motor<P> {
    /// The motor's timing and windings.
    stepper: Stepper<P>,
    laps: Laps,
}

impl<P: Port> Motor<P> {
    /// A motor at rest, on lines that [`AvrEngine::new`] sets.
    pub const fn new(port: P) -> Motor<P> {
        Motor { stepper: Stepper::new(Coils::new(port, SHIELD, 0)), laps: Laps::new() }
    }

    /// Begins a motion now.
    fn begin(&mut self, timer: &mut impl Timer, pace: Pace, forward: bool) {
        let first = pace.interval();
        self.stepper.begin(pace, forward);
        self.laps.begin(timer, first);
    }

    /// The step interrupt. The edge comes first, always the same number of cycles after the match.
    /// The work after it, mainly an update, lets other interrupts nest: another motor's edge waits
    /// for some 100 cycles instead of 1,200.
    ///
    /// # Safety
    /// For the interrupt that owns the motor and the timer, with interrupts off.
    #[inline(always)]
    pub unsafe fn on_compare(&mut self, timer: &mut impl Timer) {
        loop {
            if self.laps.is_due() {
                self.stepper.edge();
                timer.enable(false);
                // SAFETY: nothing else uses the motor: its own interrupt is held off, other motors
                // have their own, and the foreground waits.
                unsafe { interrupt::enable() };
                let next = self.stepper.advance();
                interrupt::disable();
                let Some(interval) = next else { return };
                self.laps.next(interval);
                timer.enable(true);
            }
            if self.laps.wait(timer) {
                return;
            }
        }
    }
}

/// A program's handle to a motor: the driver's hold, and the motor's phase.
pub trait Windings: Hold {
    /// The present row of the motor's table.
    fn phase(&mut self) -> u8;
}

/// The foreground's handle to a motor and its timer: each call holds off the interrupt.
pub struct AvrEngine<P: 'static, T> {
    motor: Guarded<Motor<P>, T>,
    /// The motor's bit among those that share a shield's enables, or 0.
    bit: u8,
}

impl<P: Pins, T: Timer> AvrEngine<P, T> {
    /// Sets a motor's lines, which become outputs without current, and starts its timer. `bit` is
    /// the motor's own among the shields, which share their enables; 0 if it is on no shield.
    ///
    /// # Safety
    /// To be called once for a motor, with interrupts off. `T` is the timer whose interrupt owns
    /// the motor.
    pub unsafe fn new(
        motor: &'static Slot<Motor<P>>,
        port: P,
        sequence: Sequence,
        mask: u8,
        bit: u8,
    ) -> AvrEngine<P, T> {
        // SAFETY: the caller's promise.
        let mut held = AvrEngine { motor: unsafe { Guarded::new(motor) }, bit };
        held.rewire(port, sequence, mask, bit);
        held
    }

    /// Sets other lines for the motor, which must rest. They become outputs without current; the
    /// previous lines stay as they are.
    pub fn rewire(&mut self, port: P, sequence: Sequence, mask: u8, bit: u8) {
        self.bit = bit;
        self.motor.with(|motor, _| {
            motor.stepper.wire(port, sequence, mask);
            motor.stepper.coils().off();
            motor.stepper.coils().port().drive(mask);
        });
    }

    /// Sets the row of the motor's table before it moves, at power-up.
    pub fn restore(&mut self, phase: u8) {
        self.motor.with(|motor, _| motor.stepper.coils().restore(phase));
    }

    /// Whether the motor moves.
    pub fn is_moving(&mut self) -> bool {
        self.with(|pace| pace.is_moving())
    }
}

impl<T: Timer> WiredMotor for AvrEngine<AnyPort, T> {
    fn rewire(&mut self, wire: &Wire) -> bool {
        let Some(port) = AnyPort::of(wire.port, wire.mask) else { return false };
        if wire.shield {
            shield::pins();
        }
        let bit = if wire.shield { T::SHIELD } else { 0 };
        AvrEngine::rewire(self, port, wire.sequence, wire.mask, bit);
        self.restore(wire.phase);
        true
    }

    fn phase(&mut self) -> u8 {
        Windings::phase(self)
    }
}

impl<P: Pins, T: Timer> Windings for AvrEngine<P, T> {
    fn phase(&mut self) -> u8 {
        self.motor.with(|motor, _| motor.stepper.phase())
    }
}

impl<P: Pins, T: Timer> Hold for AvrEngine<P, T> {
    #[inline(always)]
    fn with<R>(&mut self, look: impl FnOnce(&mut Pace) -> R) -> R {
        self.motor.with(|motor, _| look(&mut motor.stepper.pace))
    }
    fn begin(&mut self, pace: Pace, forward: bool) {
        shield::power(self.bit, true);
        self.motor.with(|motor, timer| motor.begin(timer, pace, forward));
    }
    fn stop(&mut self) {
        self.motor.with(|motor, timer| {
            timer.enable(false);
            motor.stepper.stop();
        });
        shield::power(self.bit, false);
    }
}

/// Makes a module for a motor and its timer's interrupt, with a function that takes the motor.
#[macro_export]
macro_rules! timed_motor {
    ($(#[$doc:meta])* mod $name:ident, $timer:ident, $port:ident, $vector:ident) => {
        $(#[$doc])*
        mod $name {
            use $crate::slot::Slot;
            use $crate::timed::{AvrEngine, Motor, Timer, $port, $timer};

            static MOTOR: Slot<Motor<$port>> = Slot::new(Motor::new($port));

            $crate::handler!($vector, $vector, {
                // SAFETY: this is the interrupt that owns them.
                let (motor, mut timer) = unsafe { (MOTOR.get(), $timer::steal()) };
                // SAFETY: as above; it runs with interrupts off.
                unsafe { motor.on_compare(&mut timer) };
            });

            /// Takes the motor.
            ///
            /// # Safety
            /// To be called once, with interrupts off.
            pub unsafe fn take(
                (sequence, mask): ($crate::timed::Sequence, u8),
                bit: u8,
            ) -> AvrEngine<$port, $timer> {
                // SAFETY: the caller's promise; it is this timer's interrupt.
                unsafe { AvrEngine::new(&MOTOR, $port, sequence, mask, bit) }
            }
        }
    };
}
