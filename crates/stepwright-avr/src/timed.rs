//! The timed driver on a chip: a motor's windings and a timer of 16 bits.
//!
//! ```text
//!   counter   ╱│╱│╱│╱│╱│╱│╱│╱│╱    freely, at the I/O clock
//!   OCRnA      ·   ·   ·  ·   ·    absolute; what is longer than a lap is several
//!   steps      │          │   │
//! ```
//!
//! The Arduino driver starts the counter again with each step (fast PWM), and divides its clock.
//! Here it runs freely, and the article's prescaler is arithmetic, done by stepwright-timed's fit
//! with its rounding and all. So no tick is lost however late the interrupt comes; a
//! shortened top can't be missed, as the deadline is compared with the counter after it was
//! set; and a change of the prescaler, which on an AVR is one for several timers and divides
//! on whatever they do, costs nothing. CTC, whose counter starts again too, would have all
//! three troubles. Fast PWM's late compare register is modelled in software:
//! `Model::Latched`. The example `fast_pwm` does it the article's way.
//!
//! | file | what |
//! | --- | --- |
//! | `timer` | the counter and its compare register |
//! | `port` | pins, as windings have them |
//! | `shield` | the motor shield's pins |
//! | `io_clock` | the I/O clock from fuses and CLKPR |
//! | `example` | what the article's cases have in common |

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

use core::marker::PhantomData;

use avr_device::interrupt;
use stepwright::drive::{Coils, Port, Sequence, sequence::SHIELD};
use stepwright_timed::{Hold, Pace, Stepper};

use crate::slot::Slot;

/// One motor, the step interrupt's.
pub struct Motor<P> {
    /// When it steps, and its windings.
    stepper: Stepper<P>,
    /// What the compare register holds.
    deadline: u16,
    /// Clocks from there to the next event.
    left: u32,
}

/// Longer than half the counter a time can't be told from the past: it takes laps.
const FAR: u32 = 0x8000;
const LAP: u16 = 0x4000;

impl<P: Port> Motor<P> {
    /// At rest, on lines to be named by [`AvrEngine::new`].
    pub const fn new(port: P) -> Motor<P> {
        Motor { stepper: Stepper::new(Coils::new(port, SHIELD, 0)), deadline: 0, left: 0 }
    }

    /// A motion begins now.
    fn begin(&mut self, timer: &mut impl Timer, pace: Pace, forward: bool) {
        self.left = pace.interval();
        self.stepper.begin(pace, forward);
        self.deadline = timer.now();
        self.aim(timer);
        timer.clear();
        timer.enable(true);
    }

    /// The next lap, or the rest of the interval.
    #[inline(always)]
    fn aim(&mut self, timer: &mut impl Timer) {
        let lap = if self.left >= FAR { LAP } else { self.left as u16 };
        self.left = self.left.wrapping_sub(lap.into());
        self.deadline = self.deadline.wrapping_add(lap);
        timer.wake_at(self.deadline);
    }

    /// The step interrupt. The edge comes first, always as many cycles after the match. What
    /// comes then, an update above all, lets other interrupts in: another motor's edge waits
    /// for some 100 cycles instead of 1,200.
    ///
    /// # Safety
    /// For the interrupt that owns the motor and the timer, with interrupts off.
    #[inline(always)]
    pub unsafe fn on_compare(&mut self, timer: &mut impl Timer) {
        loop {
            if self.left == 0 {
                self.stepper.edge();
                timer.enable(false);
                // SAFETY: nobody else has the motor: its own interrupt is held off, others
                // have their own, and the foreground waits.
                unsafe { interrupt::enable() };
                let next = self.stepper.advance();
                interrupt::disable();
                let Some(interval) = next else { return };
                self.left = interval;
                timer.enable(true);
            }
            self.aim(timer);
            if (self.deadline.wrapping_sub(timer.now()) as i16) > 0 {
                return;
            }
            // Past already: what is due is done at once, and its interrupt not waited for.
            timer.clear();
        }
    }
}

/// What a program has of a motor: the driver's hold, and where the motor is.
pub trait Windings: Hold {
    /// The row of the motor's table.
    fn phase(&mut self) -> u8;
}

/// The foreground's hold on a motor and its timer: the interrupt is held off for each call.
pub struct AvrEngine<P: 'static, T> {
    motor: &'static Slot<Motor<P>>,
    /// A bit of its own among the motors that share a shield's enables, or 0.
    bit: u8,
    timer: PhantomData<T>,
}

impl<P: Pins, T: Timer> AvrEngine<P, T> {
    /// Names a motor's lines, which become outputs without current, and lets its timer run.
    /// `bit` is its own among the shields, which share their enables; 0 if it is on none.
    ///
    /// # Safety
    /// To be called once for a motor, with interrupts off. `T` is the timer whose interrupt
    /// is the motor's.
    pub unsafe fn new(
        motor: &'static Slot<Motor<P>>,
        port: P,
        sequence: Sequence,
        mask: u8,
        bit: u8,
    ) -> AvrEngine<P, T> {
        let mut held = AvrEngine { motor, bit, timer: PhantomData };
        held.motor(|motor, timer: &mut T| {
            motor.stepper.wire(port, sequence, mask);
            motor.stepper.coils().off();
            motor.stepper.coils().port().drive(mask);
            timer.start();
        });
        held
    }

    #[inline(always)]
    fn motor<R>(&mut self, look: impl FnOnce(&mut Motor<P>, &mut T) -> R) -> R {
        interrupt::free(|_| {
            // SAFETY: no interrupt comes.
            let (motor, mut timer) = unsafe { (self.motor.get(), T::steal()) };
            look(motor, &mut timer)
        })
    }

    /// Names the motor's lines once more, while it rests. These become outputs without
    /// current; the lines before stay as they are.
    pub fn rewire(&mut self, port: P, sequence: Sequence, mask: u8, bit: u8) {
        self.bit = bit;
        self.motor(|motor, _| {
            motor.stepper.wire(port, sequence, mask);
            motor.stepper.coils().off();
            motor.stepper.coils().port().drive(mask);
        });
    }

    /// Says at which row the motor is, before it moves: at power-up.
    pub fn restore(&mut self, phase: u8) {
        self.motor(|motor, _| motor.stepper.coils().restore(phase));
    }

    /// Whether it moves.
    pub fn is_moving(&mut self) -> bool {
        self.with(|pace| pace.is_moving())
    }
}

impl<P: Pins, T: Timer> Windings for AvrEngine<P, T> {
    fn phase(&mut self) -> u8 {
        self.motor(|motor, _| motor.stepper.phase())
    }
}

impl<P: Pins, T: Timer> Hold for AvrEngine<P, T> {
    #[inline(always)]
    fn with<R>(&mut self, look: impl FnOnce(&mut Pace) -> R) -> R {
        self.motor(|motor, _| look(&mut motor.stepper.pace))
    }
    fn begin(&mut self, pace: Pace, forward: bool) {
        shield::power(self.bit, true);
        self.motor(|motor, timer| motor.begin(timer, pace, forward));
    }
    fn stop(&mut self) {
        self.motor(|motor, timer| {
            timer.enable(false);
            motor.stepper.stop();
        });
        shield::power(self.bit, false);
    }
}

/// A motor with its timer's interrupt, as a module with a function that takes it.
#[macro_export]
macro_rules! timed_motor {
    ($(#[$doc:meta])* mod $name:ident, $timer:ident, $port:ident, $vector:ident) => {
        $(#[$doc])*
        mod $name {
            use $crate::slot::Slot;
            use $crate::timed::{AvrEngine, Motor, Timer, $port, $timer};

            static MOTOR: Slot<Motor<$port>> = Slot::new(Motor::new($port));

            $crate::handler!($vector, $vector, {
                // SAFETY: the interrupt that owns them.
                let (motor, mut timer) = unsafe { (MOTOR.get(), $timer::steal()) };
                // SAFETY: likewise; it comes with interrupts off.
                unsafe { motor.on_compare(&mut timer) };
            });

            /// Takes the motor.
            ///
            /// # Safety
            /// To be called once, with interrupts off.
            pub unsafe fn take(
                (sequence, mask): (stepwright::drive::Sequence, u8),
                bit: u8,
            ) -> AvrEngine<$port, $timer> {
                // SAFETY: the caller's promise; it is this timer's interrupt.
                unsafe { AvrEngine::new(&MOTOR, $port, sequence, mask, bit) }
            }
        }
    };
}
