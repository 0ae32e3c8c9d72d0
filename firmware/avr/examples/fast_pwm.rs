//! The Arduino driver, case 1, by the published method: timer 1 in fast PWM, mode 15, wraps at each
//! step.
//!
//! ```text
//!   OCR1A is written    │ while it counts
//!   and takes effect    │ when the counter comes round: the hardware buffers it
//!   the prescaler does  │ at once
//! ```
//!
//! So after an update one step lasts the old top at the new prescaler. The core models this as
//! `Model::Latched`; here the chip itself does it.
//!
//! OCR1A holds top − 1, because the counter counts from 0 (the article loads top itself, and is a
//! count slower). When the prescaler changes, the elapsed counts are converted to counts of the new
//! prescaler: the article lets the counter continue, so the time of the update at prescaler 1
//! counts eightfold at 8. A prescaler keeps dividing whatever the timer does, which would leave a
//! count of the slower one uncertain; so it is restarted as well, with timer 0, which shares it and
//! is not used here.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use stepwright::drive::{Coils, sequence::SHIELD};
use stepwright_avr::chip::{TC0, TC1};
use stepwright_avr::slot::Slot;
use stepwright_avr::timed::{Pins, PortB, Windings, example, shield};
use stepwright_timed::{Control, Counts, Hold, Pace, SetSpeed, Stepper};

const ORDER: SetSpeed = SetSpeed {
    control: Control::SPEED_VARIABLE
        .and(Control::IRQ_TIMING)
        .and(Control::VARIABLE_PWR)
        .and(Control::SLOWER)
        .and(Control::DRV_EN),
    top: 15_000,
    limit: 8_900,
    modification: 64,
    update_ms: 1_000,
    mod_counts: 19,
};

static MOTOR: Slot<Motor> =
    Slot::new(Motor { stepper: Stepper::new(Coils::new(PortB, SHIELD, 0)), shift: 0 });

/// The motor, owned by the interrupt.
struct Motor {
    stepper: Stepper<PortB>,
    /// log₂ of the timer's prescaler.
    shift: u8,
}

/// WGM11 and WGM10 in TCCR1A, WGM13 and WGM12 in TCCR1B: mode 15.
const MODE: (u8, u8) = (0b11, 0b1_1000);
/// TOIE1 in TIMSK1, TOV1 in TIFR1.
const OVERFLOW: u8 = 1;
/// More cycles than the computation takes when the prescaler changes.
const AHEAD: u16 = 256;

/// CS12, CS11 and CS10: the bits of a prescaler.
const fn select(shift: u8) -> u8 {
    match shift {
        0 => 1,
        3 => 2,
        6 => 3,
        8 => 4,
        _ => 5,
    }
}

impl Motor {
    fn begin(&mut self, timer: &TC1, pace: Pace, forward: bool) {
        let Counts { top, shift } = pace.counts();
        self.stepper.begin(pace, forward);
        self.shift = shift;
        // SAFETY: bits of the timer that this owns; no memory is affected.
        unsafe {
            // Stopped, and in normal mode, where the compare register is not buffered.
            timer.tccr1b().write(|w| w.bits(0));
            timer.tccr1a().write(|w| w.bits(0));
            timer.ocr1a().write(|w| w.set(register(top)));
            timer.tcnt1().write(|w| w.set(0));
            timer.tccr1a().write(|w| w.bits(MODE.0));
            timer.tccr1b().write(|w| w.bits(MODE.1));
            // Now the buffered register.
            timer.ocr1a().write(|w| w.set(register(top)));
            timer.tifr1().write(|w| w.bits(OVERFLOW));
            timer.timsk1().write(|w| w.bits(OVERFLOW));
            timer.tccr1b().write(|w| w.bits(MODE.1 | select(shift)));
        }
    }

    /// The counter has wrapped.
    #[inline(always)]
    fn on_overflow(&mut self, timer: &TC1) {
        if self.stepper.event().is_none() {
            stop(timer);
            return;
        }
        let pace = &self.stepper.pace;
        let shift = pace.counts().shift;
        if shift != self.shift {
            change(timer, self.shift, shift);
            self.shift = shift;
        }
        timer.ocr1a().write(|w| w.set(register(pace.next_top())));
    }
}

/// Changes the prescaler, at the next count that is whole at both prescalers. Some 20 cycles are
/// lost from there to the write of the counter.
#[cold]
#[inline(never)]
fn change(timer: &TC1, old: u8, new: u8) {
    let ahead =
        timer.tcnt1().read().bits().wrapping_add(AHEAD.wrapping_shr(old.into())).wrapping_add(1);
    let (at, count) = if new > old {
        let by = new.wrapping_sub(old);
        let count = ahead.wrapping_shr(by.into()).wrapping_add(1);
        (count.wrapping_shl(by.into()), count)
    } else {
        (ahead, ahead.wrapping_shl(old.wrapping_sub(new).into()))
    };
    let clock = MODE.1 | select(new);
    while (at.wrapping_sub(timer.tcnt1().read().bits()) as i16) > 0 {}
    // SAFETY: the counter's clock and its prescaler, which nothing else uses, affect no memory.
    unsafe {
        timer.tccr1b().write(|w| w.bits(clock));
        TC0::steal().gtccr().write(|w| w.psrsync().set_bit());
    }
    timer.tcnt1().write(|w| w.set(count));
}

/// The value of the compare register for a period of this many counts.
fn register(top: u32) -> u16 {
    top.wrapping_sub(1) as u16
}

/// Disables the interrupt.
fn stop(timer: &TC1) {
    // SAFETY: as above.
    unsafe { timer.timsk1().write(|w| w.bits(0)) };
}

stepwright_avr::handler!(TIMER1_OVF, TIMER1_OVF, {
    // SAFETY: this is the interrupt that owns them.
    let (motor, timer) = unsafe { (MOTOR.get(), TC1::steal()) };
    motor.on_overflow(&timer);
});

/// The foreground's handle.
struct AvrEngine;

impl AvrEngine {
    #[inline(always)]
    fn motor<R>(&mut self, look: impl FnOnce(&mut Motor, &TC1) -> R) -> R {
        avr_device::interrupt::free(|_| {
            // SAFETY: no interrupt comes.
            let (motor, timer) = unsafe { (MOTOR.get(), TC1::steal()) };
            look(motor, &timer)
        })
    }
}

impl Hold for AvrEngine {
    #[inline(always)]
    fn with<R>(&mut self, look: impl FnOnce(&mut Pace) -> R) -> R {
        self.motor(|motor, _| look(&mut motor.stepper.pace))
    }
    fn begin(&mut self, pace: Pace, forward: bool) {
        shield::power(1, true);
        self.motor(|motor, timer| motor.begin(timer, pace, forward));
    }
    fn stop(&mut self) {
        self.motor(|motor, timer| {
            stop(timer);
            motor.stepper.stop();
        });
        shield::power(1, false);
    }
}

impl Windings for AvrEngine {
    fn phase(&mut self) -> u8 {
        self.motor(|motor, _| motor.stepper.phase())
    }
}

#[avr_device::entry]
fn main() -> ! {
    shield::pins();
    let (sequence, mask) = shield::lines(shield::DIRECTION);
    AvrEngine.motor(|motor, _| {
        motor.stepper.wire(PortB, sequence, mask);
        motor.stepper.coils().port().drive(mask);
    });
    // SAFETY: called once, with interrupts off, and the motor is made.
    unsafe { example::logged(&mut AvrEngine, &ORDER) }
}
