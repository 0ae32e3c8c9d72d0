//! Motor cycles on any pins, ordered over the serial line.
//!
//! ```text
//!   line ─► Incoming ─► Remote ─► Cycle ◄── step interrupt ─► AnyPins: STEP, DIR
//!           (receiver's)  (main loop)  └───────────────────► AnyIo: ENABLE, switches
//! ```
//!
//! The receiver's interrupt takes the bytes of the line, even during the step interrupt, which may
//! take a millisecond; so no byte is lost.
//!
//! Like `cycle.rs`, with pins that are chosen while the program runs: a pin is a register and a
//! mask, so an edge costs some 10 cycles more.

use core::cell::Cell;
use core::sync::atomic::{Ordering, compiler_fence};

use avr_device::interrupt;
use stepwright::drive::{Axes, Drive};
#[cfg(feature = "cycles-full")]
use stepwright::run::Run;
#[cfg(feature = "mega")]
use stepwright_cycle::RunCost;
use stepwright_cycle::line::{LONGEST, MotorPins};
use stepwright_cycle::{Clock, Cycle, CycleHold, Leg, MachineIo, Motor, Remote, Switches};
use stepwright_device::ResetIo;
use stepwright_device::main_loop::{Received, SerialPort};
use stepwright_protocol::{BoardProgram, Incoming, ProgramSlave, Text, flash_text};

use crate::board;
use crate::chip;
use crate::console::{PolledLine, received};
use crate::reset::RamMark;
use crate::slot::{Slot, token};
use crate::timed::AnyPort;
use crate::timer::Timer;

/// The number of motors, and the total number of legs of their series.
#[cfg(feature = "uno")]
pub const MOTORS: usize = 3;
#[cfg(feature = "uno")]
const LEGS: usize = 22;
/// The number of motors, and the total number of legs of their series.
#[cfg(feature = "mega")]
pub const MOTORS: usize = 4;
#[cfg(feature = "mega")]
const LEGS: usize = 400;

#[cfg(feature = "uno")]
const ABOUT: &str = "stepwright-cycle uno hz=16000000 axes=3 legs=22";
#[cfg(feature = "mega")]
const ABOUT: &str = "stepwright-cycle mega hz=16000000 axes=4 legs=400";
#[cfg(feature = "cycles-full")]
const CAN: &str = ",brakes,home,tick,paths";
#[cfg(not(feature = "cycles-full"))]
const CAN: &str = "";

/// The longest stay in the step interrupt that makes one step, including a check of another motor's
/// wait (`firmware/rig/tests/cycles.rs`).
const COST: u16 = 2_000;

/// The least cycles between two steps of a motor. A step counts as late when half of this has
/// passed after its time, and it may have to wait for a query of the line and a check of closed
/// switches.
const MIN_INTERVAL: u32 = 4_800;

/// The cycles of a turn: the leg is read in the step before it, and its steps begin half an
/// interval later (`firmware/rig/tests/turns.rs`).
#[cfg(feature = "uno")]
const TURN: u32 = 10_600;
#[cfg(feature = "mega")]
const TURN: u32 = 8_800;

/// The costs of steps of planned runs, for lines and arcs: a run is played without a query.
#[cfg(feature = "mega")]
const RUNS: RunCost = RunCost { cost: 1_600, min_interval: 3_200, on_time: 24_000 };

/// A pin: the address of PINx of its port, which DDRx and PORTx follow, and its mask; 0 for no pin.
#[derive(Clone, Copy)]
struct Pin {
    place: u16,
    mask: u8,
}

impl Pin {
    const NONE: Pin = Pin { place: AnyPort::NONE.place(), mask: 0 };

    /// The pin with this code of a line, if the board has it.
    fn of(code: u8) -> Option<Pin> {
        if code == MotorPins::NO_PIN {
            return Some(Pin::NONE);
        }
        let mask = 1 << (code & 7);
        let port = AnyPort::of((code >> 3).wrapping_add(b'A'), mask)?;
        Some(Pin { place: port.place(), mask })
    }

    fn is(&self, other: &Pin) -> bool {
        self.mask != 0 && (self.mask, self.place) == (other.mask, other.place)
    }

    /// The address of PINx, DDRx or PORTx: 0, 1, 2.
    #[inline(always)]
    fn register(&self, which: u16) -> *mut u8 {
        usize::from(self.place.wrapping_add(which)) as *mut u8
    }

    /// Inverts the level.
    #[inline(always)]
    fn toggle(&self) {
        // SAFETY: a port's register, because `of` returns no other; ones toggle their pins.
        unsafe { self.register(0).write_volatile(self.mask) }
    }

    /// Sets the level of an output, or switches a pull-up.
    fn set(&self, high: bool) {
        // SAFETY: as above; reading has no effect.
        let now = unsafe { self.register(2).read_volatile() } & self.mask != 0;
        if now != high {
            self.toggle();
        }
    }

    /// Makes it an output or an input.
    fn drive(&self, output: bool) {
        // SAFETY: as above; only the main program sets directions of pins, one at a time.
        unsafe {
            let register = self.register(1);
            let now = register.read_volatile();
            register.write_volatile(if output { now | self.mask } else { now & !self.mask });
        }
    }

    /// Whether there is a pin, and it is low.
    #[inline(always)]
    fn is_low(&self) -> bool {
        // SAFETY: reading a port has no effect.
        self.mask != 0 && unsafe { self.register(0).read_volatile() } & self.mask == 0
    }
}

/// STEP and DIR.
pub struct AnyPins {
    step: [Pin; MOTORS],
    direction: [Pin; MOTORS],
}

impl AnyPins {
    // Every `begin` has its `end`.
    #[inline(always)]
    fn toggle(&self, mut axes: Axes) {
        for pin in &self.step {
            if axes & 1 != 0 {
                pin.toggle();
            }
            axes >>= 1;
        }
    }
}

impl Drive for AnyPins {
    #[inline(always)]
    fn begin(&mut self, axes: Axes) {
        self.toggle(axes);
    }

    #[inline(always)]
    fn end(&mut self, axes: Axes) {
        self.toggle(axes);
    }

    #[inline(never)]
    fn direction(&mut self, axis: u8, forward: bool) {
        if let Some(pin) = self.direction.get(usize::from(axis)) {
            pin.set(forward);
        }
    }
}

/// ENABLE and switches.
pub struct AnyIo {
    enable: [Pin; MOTORS],
    min: [Pin; MOTORS],
    max: [Pin; MOTORS],
    /// The motors that have a switch.
    watched: Axes,
}

impl MachineIo for AnyIo {
    #[inline(always)]
    fn switches(&mut self) -> Switches {
        if self.watched == 0 { Switches::NONE } else { self.closed() }
    }

    #[inline(never)]
    fn enable(&mut self, axes: Axes) {
        for pin in &self.enable {
            // Motors may share a pin: it is on while any of them is wanted. Low is on.
            let mut others = axes;
            let mut wanted = false;
            for other in &self.enable {
                wanted |= others & 1 != 0 && pin.is(other);
                others >>= 1;
            }
            pin.set(!wanted);
        }
    }
}

impl AnyIo {
    #[inline(never)]
    fn closed(&self) -> Switches {
        let (mut switches, mut bit): (Switches, Axes) = (Switches::NONE, 1);
        for (min, max) in self.min.iter().zip(&self.max) {
            if min.is_low() {
                switches.min |= bit;
            }
            if max.is_low() {
                switches.max |= bit;
            }
            bit <<= 1;
        }
        switches
    }
}

/// The motors with their switches and drivers.
type Motors = Cycle<'static, Timer, AnyPins, AnyIo, MOTORS>;

/// Set up by `start`, before interrupts are enabled; from then on owned by the step interrupt.
static CYCLE: Slot<Motors> = Slot::new(motors());

const fn motors() -> Motors {
    let motors = Cycle::off(
        // SAFETY: it takes no memory, and it is not used before `start`, whose caller has the right
        // to it.
        unsafe { token() },
        AnyPins { step: [Pin::NONE; MOTORS], direction: [Pin::NONE; MOTORS] },
        AnyIo {
            enable: [Pin::NONE; MOTORS],
            min: [Pin::NONE; MOTORS],
            max: [Pin::NONE; MOTORS],
            watched: 0,
        },
        [Motor::new(1, 1); MOTORS],
        Clock::Deadlines,
        board::any_cycle(COST, MIN_INTERVAL),
    );
    #[cfg(feature = "mega")]
    let motors = motors.with_runs(RUNS);
    motors.with_turns(TURN)
}

// All its bits are 0: any other leg would need flash for its initial value.
#[cfg(feature = "cycles-full")]
const NOTHING: Leg = Leg::Run { run: Run::steady(0, 0), forward: false };
#[cfg(not(feature = "cycles-full"))]
const NOTHING: Leg = Leg::Steps { count: 0, delay: 0 };

static STORE: Slot<[Cell<Leg>; LEGS]> = Slot::new([const { Cell::new(NOTHING) }; LEGS]);

/// The incoming line. The receiver's interrupt owns it, and while that is disabled, the main loop.
static LINE: Slot<Incoming<LONGEST>> = Slot::new(Incoming::new());

/// The foreground's handle to the motors: each call holds off the step interrupt.
pub struct Held(());

impl CycleHold<'static, MOTORS> for Held {
    type Timer = Timer;
    type Drive = AnyPins;
    type Io = AnyIo;

    #[inline(always)]
    fn with<R>(&mut self, ask: impl FnOnce(&mut Motors) -> R) -> R {
        Timer::enable(false);
        compiler_fence(Ordering::SeqCst);
        // SAFETY: `serve` made this and the motors before it, and no step interrupt comes; the
        // receiver's interrupt does not use them.
        let told = ask(unsafe { CYCLE.get() });
        compiler_fence(Ordering::SeqCst);
        Timer::enable(true);
        told
    }

    #[inline(never)]
    fn wire(&mut self, motor: u8, pins: &MotorPins) -> Result<(), u8> {
        let mut all = [Pin::NONE; 5];
        for ((pin, code), place) in all.iter_mut().zip(&pins.codes).zip(0u8..) {
            *pin = Pin::of(*code).ok_or(place)?;
        }
        let [step, direction, enable, min, max] = all;
        self.with(|cycle| {
            for (place, pin) in (0u8..).zip(&all) {
                if cycle_has(cycle, motor, pin, place == ENABLE)
                    || all.iter().filter(|other| pin.is(other)).count() > 1
                {
                    return Err(place);
                }
            }
            let n = usize::from(motor);
            let drive = cycle.drive();
            let (Some(to_step), Some(to_direction)) =
                (drive.step.get_mut(n), drive.direction.get_mut(n))
            else {
                return Err(0);
            };
            (*to_step, *to_direction) = (step, direction);
            let io = cycle.surroundings();
            for (to, pin) in [(&mut io.enable, enable), (&mut io.min, min), (&mut io.max, max)] {
                if let Some(to) = to.get_mut(n) {
                    *to = pin;
                }
            }
            io.watched &= !(1 << n);
            if min.mask | max.mask != 0 {
                io.watched |= 1 << n;
            }
            // Steps low and drivers off before the pins become outputs; pull-ups at the switches.
            step.set(false);
            enable.set(true);
            for pin in [step, direction, enable] {
                pin.drive(true);
            }
            for pin in [min, max] {
                pin.drive(false);
                pin.set(true);
            }
            Ok(())
        })
    }

    fn about(&self) -> (Text, Text) {
        (flash_text!(ABOUT), flash_text!(CAN))
    }
}

/// The index of ENABLE among a motor's pins.
const ENABLE: u8 = 2;

/// Whether another motor uses a pin. Motors may share an ENABLE.
fn cycle_has(cycle: &mut Motors, motor: u8, pin: &Pin, enables: bool) -> bool {
    let has = |pins: &[Pin; MOTORS]| {
        (0u8..).zip(pins).any(|(other, theirs)| other != motor && pin.is(theirs))
    };
    let drive = cycle.drive();
    let drives = has(&drive.step) || has(&drive.direction);
    let io = cycle.surroundings();
    drives || has(&io.min) || has(&io.max) || (!enables && has(&io.enable))
}

/// Takes the chip: motors without pins, and a serial line of 115200 baud. Serves them for ever.
///
/// # Safety
/// To be called once, with interrupts off. The program needs a
/// [`cycles_interrupts!`](crate::cycles_interrupts).
#[inline(never)]
pub unsafe fn serve() -> ! {
    // SAFETY: they are taken only here.
    let chip = unsafe { chip::Peripherals::steal() };
    // SAFETY: called once.
    let _ = unsafe { Timer::start() };
    // SAFETY: interrupts are off.
    unsafe { CYCLE.get() }.begin();
    let mut line = PolledLine::start(chip.USART0);
    // SAFETY: nobody else has it mutably.
    let mut remote = Remote::new(Held(()), unsafe { STORE.share() });
    line.interrupt();
    // SAFETY: everything that an interrupt uses is set up.
    unsafe { interrupt::enable() };
    let mut slave = ProgramSlave::new();
    if RamMark.begin() {
        remote.mark_unknown();
    }
    loop {
        remote.poll();
        RamMark.note(|| remote.is_busy());
        if !line.interrupts() && !slave.is_answering() {
            // SAFETY: the receiver's interrupt is disabled, so the main loop owns the line.
            slave.obey(unsafe { LINE.get() }, &mut remote);
            RamMark.note(|| remote.is_busy());
            line.interrupt();
        }
        if line.has_room()
            && let Some(byte) = slave.next_byte(&mut remote)
        {
            line.send(byte);
        }
    }
}

/// The step interrupt, called by [`cycles_interrupts!`](crate::cycles_interrupts).
///
/// # Safety
/// Only for the step interrupt, once there are motors.
#[doc(hidden)]
#[inline(always)]
pub unsafe fn on_compare() {
    Timer::enable(false);
    // SAFETY: the only interrupt that comes now is the receiver's.
    unsafe { interrupt::enable() };
    // SAFETY: the caller's promise; the foreground accesses them only with this interrupt held off.
    unsafe { CYCLE.get() }.on_compare();
    interrupt::disable();
    Timer::enable(true);
}

/// The receiver's interrupt, called in the same way.
///
/// # Safety
/// Only for the receiver's interrupt.
#[doc(hidden)]
#[inline(always)]
pub unsafe fn on_receive() {
    // SAFETY: this interrupt comes only while it owns the line; it also owns the receiver.
    let (usart, line) = unsafe { (chip::USART0::steal(), LINE.get()) };
    if let Some(received) = received(&usart)
        && line.receive(match received {
            Received::Byte(byte) => Some(byte),
            Received::Garbled => None,
        })
    {
        usart.ucsr0b().modify(|_, w| w.rxcie0().clear_bit());
    }
}

/// Puts the interrupts of motor cycles on any pins into a program.
#[macro_export]
macro_rules! cycles_interrupts {
    () => {
        $crate::handler!(TIMER1_COMPA, TIMER1_COMPA, {
            // SAFETY: this is the step interrupt, which `serve` lets come.
            unsafe { $crate::cycles::on_compare() }
        });
        $crate::handler!(USART_RX, USART0_RX, {
            // SAFETY: this is the receiver's interrupt.
            unsafe { $crate::cycles::on_receive() }
        });
    };
}
