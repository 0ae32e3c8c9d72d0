//! The controller: it takes lines, and moves three motors.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use core::ops::{Deref, DerefMut};

use stepwright::{OrderedMotors, PlannedBoard};
use stepwright_avr::in_flash::InFlash;
use stepwright_avr::panel::AvrIo;
use stepwright_avr::serial::Serial;
use stepwright_avr::step::{AvrEngine, RUNS};
use stepwright_avr::{board, chip, clock, eeprom, slot::Slot, step, watchdog};
use stepwright_device::Device;
use stepwright_device::main_loop::{self, OnBoard};

type Controller = Device<'static, AvrEngine, { board::AXES }, RUNS>;

/// All zeros, which take no flash. `start` sets it up in place, because the stack has no room for a
/// second one.
static DEVICE: Slot<Controller> =
    // SAFETY: `start` powers the motors up before anything else.
    Slot::new(Device::blank(unsafe { OrderedMotors::blank(AvrEngine::NONE) }));

/// The description of the board.
#[unsafe(link_section = ".progmem.data")]
static BOARD: InFlash<PlannedBoard<{ board::AXES }>> =
    InFlash::new(PlannedBoard::new(board::description()));

stepwright_avr::step_interrupts!();
stepwright_avr::serial_interrupts!();

#[avr_device::entry]
fn main() -> ! {
    let mut base = [0; board::AXES];
    // SAFETY: called once, with interrupts off; this frame is never left.
    let (mut board, mut line) = unsafe { start(&mut *(&raw mut base)) };
    // SAFETY: everything that an interrupt uses is set up.
    unsafe { avr_device::interrupt::enable() };
    main_loop::run(&mut board, &mut line)
}

/// Sets up everything, as at power-up.
///
/// # Safety
/// To be called once, with interrupts off.
#[inline(never)]
unsafe fn start(base: &'static mut [i64; board::AXES]) -> (OnBoard<Owner, AvrIo>, Serial) {
    // SAFETY: they are taken only here.
    let chip = unsafe { chip::Peripherals::steal() };
    watchdog::start(&chip.WDT);
    #[cfg(feature = "uno")]
    let (pins, levels) = board::pins(chip.PORTD, chip.PORTB);
    #[cfg(feature = "mega")]
    let (pins, levels) = board::pins(chip.PORTB, chip.PORTE, chip.PORTG, chip.PORTH);
    let mut io =
        AvrIo::new(levels, eeprom::Eeprom::new(chip.EEPROM), clock::Clock::start(chip.TC0));
    let line = Serial::start(chip.USART0);
    let mut device = Owner(());
    let motors = device.motors_mut();
    // SAFETY: called once, with interrupts off.
    *motors.engine() = unsafe { step::start(pins, base) };
    // SAFETY: nothing else takes the feeds, and the board is in flash.
    let feed = |axis, feed: &mut _| unsafe { step::lend(axis, feed) };
    motors.power_up(feed, |given| unsafe { BOARD.load(given) });
    device.begin(board::AXES as u8, &mut io);
    (OnBoard { device, io }, line)
}

/// Access to the device, which only `start` creates, once. The device is at a fixed address, and
/// not behind a pointer: this makes all code that uses it shorter by a tenth.
struct Owner(());

impl Deref for Owner {
    type Target = Controller;

    #[inline(always)]
    fn deref(&self) -> &Controller {
        // SAFETY: there is one owner, which is borrowed for as long, and no interrupt uses the
        // device.
        unsafe { DEVICE.get() }
    }
}

impl DerefMut for Owner {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Controller {
        // SAFETY: as above.
        unsafe { DEVICE.get() }
    }
}
