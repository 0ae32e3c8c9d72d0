//! The controller: it takes lines, and moves three motors.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use core::mem::MaybeUninit;

use stepwright::Group;
use stepwright_avr::panel::AvrPanel;
use stepwright_avr::serial::{Received, Serial};
use stepwright_avr::step::{Held, RUNS};
use stepwright_avr::timer::Timer;
use stepwright_avr::{board, chip, clock, eeprom, slot::Slot, step, watchdog};
use stepwright_device::Device;

/// All that the main loop works with.
///
/// It lies at a fixed address, not on the stack: an AVR reaches no further
/// than 63 bytes from the stack pointer with one instruction.
struct Slave {
    device: Device<'static, { board::AXES }, RUNS>,
    engine: Held,
    panel: AvrPanel,
    serial: Serial,
}

static SLAVE: Slot<MaybeUninit<Slave>> = Slot::new(MaybeUninit::uninit());

stepwright_avr::step_interrupt!();

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: called once, with interrupts off.
    let slave = unsafe { start() };
    // SAFETY: all that an interrupt touches has been made.
    unsafe { avr_device::interrupt::enable() };
    loop {
        watchdog::feed();
        slave.panel.tick();
        if slave.device.is_speaking() {
            slave.speak();
        } else {
            slave.listen();
        }
        slave.plan();
    }
}

/// Makes everything, as at power-up.
///
/// # Safety
/// To be called once, with interrupts off.
#[inline(never)]
unsafe fn start() -> &'static mut Slave {
    // SAFETY: the only time that anybody takes them.
    let chip = unsafe { chip::Peripherals::steal() };
    let bitten = watchdog::start(&chip.CPU, &chip.WDT);
    #[cfg(feature = "uno")]
    let (pins, levels) = board::pins(chip.PORTD, chip.PORTB);
    #[cfg(feature = "mega")]
    let (pins, levels) = board::pins(chip.PORTB, chip.PORTE, chip.PORTG, chip.PORTH);
    let board = board::description();
    // SAFETY: called once, with interrupts off.
    let (engine, feeds) = unsafe { step::start(Timer::start(), pins) };
    let clock = clock::Clock::start(chip.TC2);
    // Made in its place, and then begun: to move it there would take more
    // code than to make it.
    // SAFETY: called once, and nobody else names it.
    let slave = unsafe { SLAVE.get() }.write(Slave {
        device: Device::off(Group::new(feeds, board), board::AXES as u8),
        engine,
        panel: AvrPanel::new(levels, eeprom::Eeprom::new(chip.EEPROM), clock),
        serial: Serial::start(chip.USART0),
    });
    if bitten {
        slave.device.controller(&mut slave.engine).group.doubt();
    }
    slave.device.begin(&mut slave.engine, &mut slave.panel);
    slave
}

impl Slave {
    /// One piece of planning, and the other duties. The bench times it by its
    /// name.
    #[inline(never)]
    fn plan(&mut self) {
        self.device.poll(&mut self.engine, &mut self.panel);
    }

    /// Takes what has come, up to the end of a line. The master says the next
    /// one after its answer.
    #[inline(never)]
    fn listen(&mut self) {
        while let Some(received) = self.serial.receive() {
            match received {
                Received::Byte(byte) => {
                    if self.device.hear(byte, &mut self.engine, &mut self.panel) {
                        return;
                    }
                }
                Received::Garbled => self.device.garbled(),
            }
        }
    }

    /// Sends of the answer as much as there is room for. Planning goes on
    /// meanwhile.
    #[inline(never)]
    fn speak(&mut self) {
        while self.serial.has_room()
            && let Some(byte) = self.device.speak(&mut self.engine, &mut self.panel)
        {
            self.serial.send(byte);
        }
    }
}
