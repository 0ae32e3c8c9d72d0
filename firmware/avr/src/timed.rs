//! The timed driver on a chip: a shield's motor on a timer of 16 bits.
//!
//! The counter runs freely at a prescaler of 1, and the compare register holds an absolute
//! time; what is longer than the counter is a few laps. So no tick is lost however late
//! the interrupt comes, a shortened top can't be missed, and a change of the prescaler,
//! which on an AVR is one for all timers and runs freely, costs nothing: the prescaler of
//! document 000 is arithmetic, done by the core's fit, with its rounding and all.
//!
//! Fast PWM's late compare register is modelled in software: `Model::Latched`.

use core::sync::atomic::{AtomicU8, Ordering};

use stepwright::drive::{Coils, Port, Sequence, sequence::SHIELD};
use stepwright::timed::Pace;
use stepwright::timer::fit::{Oscillator, divider_of, io_clock};

use crate::chip;

/// One motor, the step interrupt's.
pub struct Motor<P> {
    /// When the next step is due.
    pub pace: Pace,
    /// Its windings.
    pub coils: Coils<P>,
    /// What the compare register holds.
    deadline: u16,
    /// Clocks from there to the next event.
    left: u32,
}

/// Longer than half the counter a time can't be told from the past: it takes laps.
const FAR: u32 = 0x8000;
const LAP: u16 = 0x4000;

impl<P: Port> Motor<P> {
    /// At rest, on lines to be named by [`wire`](Motor::wire).
    pub const fn new(port: P) -> Motor<P> {
        Motor { pace: Pace::idle(), coils: Coils::new(port, SHIELD, 0), deadline: 0, left: 0 }
    }

    /// Says which lines it has.
    pub fn wire(&mut self, port: P, sequence: Sequence, mask: u8) {
        self.coils = Coils::new(port, sequence, mask);
    }

    /// A motion begins now.
    pub fn begin(&mut self, timer: &mut impl Compare, pace: Pace, forward: bool) {
        self.left = pace.interval();
        self.pace = pace;
        self.coils.set_forward(forward);
        self.coils.on();
        self.deadline = timer.now();
        self.aim(timer);
        timer.clear();
        timer.enable(true);
    }

    /// The next lap, or the rest of the interval.
    #[inline(always)]
    fn aim(&mut self, timer: &mut impl Compare) {
        let lap = if self.left >= FAR { LAP } else { self.left as u16 };
        self.left = self.left.wrapping_sub(lap.into());
        self.deadline = self.deadline.wrapping_add(lap);
        timer.wake_at(self.deadline);
    }

    /// The step interrupt. The edge comes first, always as many cycles after the match.
    #[inline(always)]
    pub fn on_compare(&mut self, timer: &mut impl Compare) {
        loop {
            if self.left == 0 {
                if self.pace.is_step() {
                    self.coils.step();
                }
                match self.pace.advance() {
                    Some(interval) => self.left = interval,
                    None => return timer.enable(false),
                }
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

/// A timer's counter and compare register A.
pub trait Compare {
    /// The counter.
    fn now(&mut self) -> u16;
    /// Sets the compare register.
    fn wake_at(&mut self, at: u16);
    /// Forgets a match.
    fn clear(&mut self);
    /// Lets a match interrupt, or not.
    fn enable(&mut self, on: bool);
}

macro_rules! compare {
    (
        $name:ident, $tc:ident, $count:ident, $compare:ident, $prescaler:ident, $select:ident,
        $mask:ident, $enable:ident, $flags:ident, $flag:ident
    ) => {
        /// A timer, free-running at the I/O clock.
        pub struct $name(chip::$tc);

        impl $name {
            /// Lets it run.
            pub fn start(registers: chip::$tc) {
                registers.$prescaler().write(|w| w.$select().direct());
            }

            /// The registers.
            ///
            /// # Safety
            /// For the interrupt that owns them, or while it can't come.
            #[inline(always)]
            pub unsafe fn steal() -> $name {
                // SAFETY: the caller's promise.
                $name(unsafe { chip::$tc::steal() })
            }
        }

        impl Compare for $name {
            #[inline(always)]
            fn now(&mut self) -> u16 {
                self.0.$count().read().bits()
            }
            #[inline(always)]
            fn wake_at(&mut self, at: u16) {
                self.0.$compare().write(|w| w.set(at));
            }
            #[inline(always)]
            fn clear(&mut self) {
                self.0.$flags().write(|w| w.$flag().set_bit());
            }
            #[inline(always)]
            fn enable(&mut self, on: bool) {
                self.0.$mask().write(|w| w.$enable().bit(on));
            }
        }
    };
}

compare!(Timer1, TC1, tcnt1, ocr1a, tccr1b, cs1, timsk1, ocie1a, tifr1, ocf1a);
#[cfg(feature = "mega")]
compare!(Timer3, TC3, tcnt3, ocr3a, tccr3b, cs3, timsk3, ocie3a, tifr3, ocf3a);

macro_rules! port {
    ($name:ident, $port:ident, $read:ident, $toggle:ident) => {
        /// A port's pins. Writing ones to PINx toggles these and leaves the others alone.
        pub struct $name;

        impl $name {
            #[inline(always)]
            fn write_under(mask: u8, levels: u8) {
                // SAFETY: reading, and one write that leaves other pins alone.
                let port = unsafe { chip::$port::steal() };
                let changed = (port.$read().read().bits() ^ levels) & mask;
                // SAFETY: levels of pins touch no memory.
                port.$toggle().write(|w| unsafe { w.bits(changed) });
            }
        }

        impl Port for $name {
            fn set(&mut self, mask: u8) {
                $name::write_under(mask, mask);
            }
            fn clear(&mut self, mask: u8) {
                $name::write_under(mask, 0);
            }
            #[inline(always)]
            fn write(&mut self, mask: u8, levels: u8) {
                $name::write_under(mask, levels);
            }
        }
    };
}

port!(PortB, PORTB, portb, pinb);
#[cfg(feature = "mega")]
port!(PortH, PORTH, porth, pinh);

/// A motor with its timer, and the foreground's hold on both, as a module.
#[macro_export]
macro_rules! timed_motor {
    ($(#[$doc:meta])* mod $name:ident, $timer:ident, $port:ident, $vector:ident) => {
        $(#[$doc])*
        mod $name {
            use stepwright::timed::{Hold, Pace};
            use $crate::slot::Slot;
            use $crate::timed::{self, Motor, $port, $timer};

            static MOTOR: Slot<Motor<$port>> = Slot::new(Motor::new($port));

            $crate::handler!($vector, $vector, {
                // SAFETY: the interrupt that owns them.
                let (motor, mut timer) = unsafe { (MOTOR.get(), $timer::steal()) };
                motor.on_compare(&mut timer);
            });

            /// The foreground's hold: the interrupt is held off for each call.
            pub struct Held {
                /// A bit of its own among the motors that share the enables.
                bit: u8,
            }

            impl Held {
                /// Says which lines the motor has. `bit` is its own.
                ///
                /// # Safety
                /// To be called once, with interrupts off.
                pub unsafe fn new(
                    sequence: stepwright::drive::Sequence,
                    mask: u8,
                    bit: u8,
                ) -> Held {
                    // SAFETY: the caller's promise.
                    unsafe { MOTOR.get() }.wire($port, sequence, mask);
                    Held { bit }
                }

                #[inline(always)]
                fn motor<R>(&mut self, look: impl FnOnce(&mut Motor<$port>, &mut $timer) -> R) -> R {
                    ::avr_device::interrupt::free(|_| {
                        // SAFETY: no interrupt comes.
                        let (motor, mut timer) = unsafe { (MOTOR.get(), $timer::steal()) };
                        look(motor, &mut timer)
                    })
                }

                /// The row of the motor's table.
                pub fn phase(&mut self) -> u8 {
                    self.motor(|motor, _| motor.coils.phase())
                }

                /// Whether it moves.
                pub fn is_moving(&mut self) -> bool {
                    self.motor(|motor, _| motor.pace.is_moving())
                }
            }

            impl Hold for Held {
                #[inline(always)]
                fn with<R>(&mut self, look: impl FnOnce(&mut Pace) -> R) -> R {
                    self.motor(|motor, _| look(&mut motor.pace))
                }
                fn begin(&mut self, pace: Pace, forward: bool) {
                    timed::power(self.bit, true);
                    self.motor(|motor, timer| motor.begin(timer, pace, forward));
                }
                fn stop(&mut self) {
                    use $crate::timed::Compare;
                    self.motor(|_, timer| timer.enable(false));
                    timed::power(self.bit, false);
                }
            }
        }
    };
}

/// The bits of D12 and D13 on port B.
pub const DIRECTION: [u8; 2] = if cfg!(feature = "mega") { [6, 7] } else { [4, 5] };
/// On the Mega the bits of D9 and D8 on port H, where a second shield has them.
pub const DIRECTION_2: [u8; 2] = [6, 5];
/// D11 on port B: enable B.
const ENABLE_B: u8 = if cfg!(feature = "mega") { 1 << 5 } else { 1 << 3 };
/// D3: enable A, on port D of the Uno and port E of the Mega.
const ENABLE_A: u8 = if cfg!(feature = "mega") { 1 << 5 } else { 1 << 3 };

/// The bits of two lines as a mask.
pub const fn mask_of([a, b]: [u8; 2]) -> u8 {
    1 << a | 1 << b
}

/// Motors whose drivers are on: shields that are stacked share their enables.
static DRIVING: AtomicU8 = AtomicU8::new(0);

/// The drivers of one motor are to be on, or off.
pub fn power(bit: u8, on: bool) {
    let before = DRIVING.load(Ordering::Relaxed);
    let now = if on { before | bit } else { before & !bit };
    DRIVING.store(now, Ordering::Relaxed);
    let levels = if now != 0 { 0xFF } else { 0 };
    PortB::write_under(ENABLE_B, levels);
    // SAFETY: the step interrupt has no pin on this port.
    #[cfg(feature = "uno")]
    let port = unsafe { chip::PORTD::steal() }.portd().as_ptr();
    // SAFETY: as above.
    #[cfg(feature = "mega")]
    let port = unsafe { chip::PORTE::steal() }.porte().as_ptr();
    // SAFETY: a port's register, which nobody else writes.
    unsafe { port.write_volatile(levels & ENABLE_A) };
}

/// Makes the shields' pins outputs, all low: enables off, brakes off.
pub fn pins() {
    // SAFETY: interrupts are off, or have no business with these registers.
    let chip = unsafe { chip::Peripherals::steal() };
    // SAFETY: directions of pins touch no memory.
    unsafe {
        chip.PORTB.ddrb().write(|w| w.bits(mask_of(DIRECTION) | ENABLE_B | BRAKES_B));
        #[cfg(feature = "uno")]
        chip.PORTD.ddrd().write(|w| w.bits(ENABLE_A));
        #[cfg(feature = "mega")]
        {
            chip.PORTE.ddre().write(|w| w.bits(ENABLE_A));
            // The brakes, or the second shield's directions.
            chip.PORTH.ddrh().write(|w| w.bits(mask_of(DIRECTION_2)));
        }
    }
}

/// On the Uno D9 and D8, the brakes, are on port B; they stay low.
const BRAKES_B: u8 = if cfg!(feature = "mega") { 0 } else { 0b11 };

/// The I/O clock in Hz, from the fuses and CLKPR, as `motorTimerGetIOclocksPerSecond`.
pub fn io_clock_now() -> u32 {
    // SAFETY: reading a register.
    let clkpr = unsafe { chip::CPU::steal() }.clkpr().read().bits();
    let oscillator = Oscillator::from_low_fuse(low_fuse());
    io_clock(oscillator.hz(), divider_of(clkpr).unwrap_or(1)).unwrap_or(oscillator.hz())
}

/// The low fuse byte. (simavr has none there and gives the first byte of the program, a
/// jump, which reads as a crystal.)
fn low_fuse() -> u8 {
    avr_device::interrupt::free(|_| {
        let fuse: u8;
        // SAFETY: SPMCSR is 0x37 on both chips; LPM within 3 cycles after BLBSET and SPMEN
        // reads a fuse and changes nothing.
        unsafe {
            core::arch::asm!(
                "out 0x37, {mode}",
                "lpm {fuse}, Z",
                mode = in(reg) 0b0000_1001u8,
                fuse = lateout(reg) fuse,
                in("Z") 0u16,
                options(nostack, preserves_flags),
            );
        }
        fuse
    })
}
