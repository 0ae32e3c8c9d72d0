//! A controller with S-curves, small enough for an Uno: it takes the line's every
//! word about travels, plans three motors ahead as the controller does, and has no
//! settings and no switches, whose place the curves take; its drivers are always on.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright::Group;
use stepwright_avr::board::{self, AXES};
use stepwright_avr::serial::{Received, Serial};
use stepwright_avr::step::{Held, RUNS};
use stepwright_avr::timer::Timer;
use stepwright_avr::{chip, reset, slot::Slot, step, watchdog};
use stepwright_device::Mark;
use stepwright_protocol::{Controller, Slave};

/// All that the main loop works with.
struct Board {
    engine: Held,
    serial: Serial,
}

/// Their memory is filled when the chip starts.
static SLAVE: Slot<Slave<AXES>> = Slot::new(Slave::blank());
static GROUP: Slot<Group<'static, AXES, RUNS>> = Slot::new(Group::new(
    // SAFETY: nobody else asks for them.
    unsafe { step::feeds() },
    board::description(),
));

stepwright_avr::step_interrupt!(queued);
stepwright_avr::serial_interrupts!();

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: called once, with interrupts off.
    let mut board = unsafe { start() };
    // SAFETY: all that an interrupt touches has been made.
    unsafe { avr_device::interrupt::enable() };
    loop {
        watchdog::feed();
        if slave().is_speaking() {
            board.speak();
        } else {
            board.listen();
        }
        // Three pieces make a run; a byte of the line may wait for that long.
        let _ = board.plan() && board.plan() && board.plan();
    }
}

/// Makes everything, as at power-up.
///
/// # Safety
/// To be called once, with interrupts off.
#[inline(never)]
unsafe fn start() -> Board {
    // SAFETY: the only time that anybody takes them.
    let chip = unsafe { chip::Peripherals::steal() };
    watchdog::start(&chip.WDT);
    #[cfg(feature = "uno")]
    let (pins, mut levels) = board::pins(chip.PORTD, chip.PORTB);
    #[cfg(feature = "mega")]
    let (pins, mut levels) = board::pins(chip.PORTB, chip.PORTE, chip.PORTG, chip.PORTH);
    levels.set_enable(false); // on while it is low
    let board = Board {
        // SAFETY: called once, with interrupts off.
        engine: unsafe { step::start(Timer::start(), pins) },
        serial: Serial::start(chip.USART0),
    };
    slave().begin();
    if reset::doubts() {
        group().doubt();
    }
    board
}

/// The line's end. At a fixed address, as in the controller.
#[inline(always)]
fn slave() -> &'static mut Slave<AXES> {
    // SAFETY: only the main program asks, for each thing that it does anew, and no
    // interrupt does.
    unsafe { SLAVE.get() }
}

/// The motors, likewise.
#[inline(always)]
fn group() -> &'static mut Group<'static, AXES, RUNS> {
    // SAFETY: as above.
    unsafe { GROUP.get() }
}

impl Board {
    /// The motors and the engine, for a line.
    #[inline(always)]
    fn machine(&mut self) -> Controller<'_, 'static, Held, AXES, RUNS> {
        Controller { group: group(), engine: &mut self.engine, axes: AXES as u8 }
    }

    /// One piece of planning.
    #[inline(never)]
    fn plan(&mut self) -> bool {
        group().poll(&mut self.engine)
    }

    /// Takes what has come, up to the end of a line.
    #[inline(never)]
    fn listen(&mut self) {
        while let Some(received) = self.serial.receive() {
            match received {
                Received::Byte(byte) => {
                    if slave().hear(byte, &mut self.machine()) {
                        // Never taken back: this board's RAM has to be cold for a
                        // power-up to be one of a known position.
                        if group().any_busy(&self.engine) {
                            reset::set_mark(Mark::MOVING);
                        }
                        return;
                    }
                }
                Received::Garbled => slave().garbled(),
            }
        }
    }

    /// Sends of the answer as much as there is room for. Planning goes on meanwhile.
    #[inline(never)]
    fn speak(&mut self) {
        while self.serial.has_room()
            && let Some(byte) = slave().speak(&mut self.machine())
        {
            self.serial.send(byte);
        }
    }
}
