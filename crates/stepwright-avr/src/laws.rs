//! Austin's laws over the serial line: the motor on axis 1 moves by any of them, ordered by
//! `stepwright move --law … --port`, or by any sender of the rows of `stepwright_austin::line`.
//!
//! ```text
//!   serial interrupts ──► Station ──► delays, up to 6 steps ahead ──► step interrupt of axis 1
//!   (two rings)           (main loop, interrupts on)
//! ```
//!
//! A Mega holds all laws in the program `laws`. An Uno has three programs: `laws` with the general
//! form and the published listing, `transitions` with linear factor and piecewise, and
//! `power-term`.

use core::mem::MaybeUninit;

use stepwright_austin::Station;
use stepwright_austin::line::LONGEST;
use stepwright_austin::station::{About, Costs};
use stepwright_device::ProgramDevice;
use stepwright_device::main_loop;
use stepwright_protocol::{Text, flash_text};

use crate::board::{self, AXES};
use crate::reset::RamMark;
use crate::serial::Serial;
use crate::slot::Slot;
use crate::step::{self, AvrEngine, RUNS};
use crate::{chip, watchdog};

/// The base positions of the present travels.
static BASE: Slot<[i64; AXES]> = Slot::new([0; AXES]);
/// The motor with its line; `start` makes it.
static STATION: Slot<MaybeUninit<Motor>> = Slot::new(MaybeUninit::uninit());

type Motor = ProgramDevice<Station<'static, AvrEngine, RUNS>, RamMark, LONGEST>;

fn about() -> About {
    let name: Text = if cfg!(feature = "mega") { flash_text!("mega") } else { flash_text!("uno") };
    About { name, mhz: board::CLOCK / 1_000_000, costs: Costs::AVR }
}

/// The motor and its line.
pub struct Desk {
    motor: &'static mut Motor,
    serial: Serial,
}

impl Desk {
    /// Sets up everything, as at power-up.
    ///
    /// # Safety
    /// To be called once, with interrupts off.
    #[inline(never)]
    pub unsafe fn start() -> Desk {
        // SAFETY: they are taken only here.
        let chip = unsafe { chip::Peripherals::steal() };
        watchdog::start(&chip.WDT);
        #[cfg(feature = "uno")]
        let (pins, mut levels) = board::pins(chip.PORTD, chip.PORTB);
        #[cfg(feature = "mega")]
        let (pins, mut levels) = board::pins(chip.PORTB, chip.PORTE, chip.PORTG, chip.PORTH);
        levels.set_enable(false); // on while it is low
        // SAFETY: the caller's promise. `lend` expects a producer of zeros, and this is the only
        // one of its axis.
        let (engine, feed) = unsafe {
            let engine = step::start(pins, BASE.get());
            let mut feed = MaybeUninit::zeroed().assume_init();
            step::lend(0, &mut feed);
            (engine, feed)
        };
        // SAFETY: taken only here.
        let station = unsafe { STATION.get() };
        let motor = station.write(ProgramDevice::new(Station::new(engine, feed, about()), RamMark));
        Desk { motor, serial: Serial::start(chip.USART0) }
    }

    /// Handles lines and computes delays, for ever.
    pub fn serve(mut self) -> ! {
        loop {
            watchdog::feed();
            main_loop::round(self.motor, &mut self.serial);
        }
    }
}

/// Makes a program with the laws of its features.
#[macro_export]
macro_rules! ordered_laws {
    () => {
        $crate::step_interrupts!();
        $crate::serial_interrupts!();

        #[avr_device::entry]
        fn main() -> ! {
            // SAFETY: called once, with interrupts off.
            let desk = unsafe { $crate::laws::Desk::start() };
            // SAFETY: everything that an interrupt uses is set up.
            unsafe { avr_device::interrupt::enable() };
            desk.serve()
        }
    };
}
