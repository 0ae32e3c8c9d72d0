//! The controller: it takes lines, and moves three motors.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright::{Given, Steppers};
use stepwright_avr::in_flash::InFlash;
use stepwright_avr::panel::AvrIo;
use stepwright_avr::serial::{Received, Serial};
use stepwright_avr::step::{AvrEngine, RUNS};
use stepwright_avr::{board, chip, clock, eeprom, slot::Slot, step, watchdog};
use stepwright_device::Device;

/// All that the main loop works with.
struct Slave {
    device: Owner,
    panel: AvrIo,
    serial: Serial,
}

type Controller = Device<'static, AvrEngine, { board::AXES }, RUNS>;

/// All zeros, which take no flash; `start` does the rest, as there is no room for a
/// second one on the stack.
static DEVICE: Slot<Controller> =
    // SAFETY: `start` powers the motors up before anything else.
    Slot::new(Device::blank(unsafe { Steppers::blank(AvrEngine::NONE) }));

/// Its board.
#[unsafe(link_section = ".progmem.data")]
static BOARD: InFlash<Given<{ board::AXES }>> = InFlash::new(Given::new(board::description()));

stepwright_avr::step_interrupts!();
stepwright_avr::serial_interrupts!();

#[avr_device::entry]
fn main() -> ! {
    let mut base = [0; board::AXES];
    // SAFETY: called once, with interrupts off; this frame is never left.
    let mut slave = unsafe { start(&mut *(&raw mut base)) };
    // SAFETY: all that an interrupt touches has been made.
    unsafe { avr_device::interrupt::enable() };
    loop {
        watchdog::feed();
        slave.panel.tick();
        if slave.device.get().is_answering() {
            slave.next_byte();
        } else {
            slave.listen();
            slave.work();
        }
        slave.device.get().poll_io(&mut slave.panel);
        // Four pieces make a run; a byte of the line may wait for that long.
        let _ = slave.plan() && slave.plan() && slave.plan() && slave.plan();
    }
}

/// Makes everything, as at power-up.
///
/// # Safety
/// To be called once, with interrupts off.
#[inline(never)]
unsafe fn start(base: &'static mut [i64; board::AXES]) -> Slave {
    // SAFETY: the only time that anybody takes them.
    let chip = unsafe { chip::Peripherals::steal() };
    watchdog::start(&chip.WDT);
    #[cfg(feature = "uno")]
    let (pins, levels) = board::pins(chip.PORTD, chip.PORTB);
    #[cfg(feature = "mega")]
    let (pins, levels) = board::pins(chip.PORTB, chip.PORTE, chip.PORTG, chip.PORTH);
    let mut slave = Slave {
        device: Owner(()),
        panel: AvrIo::new(
            levels,
            eeprom::Eeprom::new(chip.EEPROM),
            clock::Clock::start(chip.TC0),
        ),
        serial: Serial::start(chip.USART0),
    };
    let motors = slave.device.get().motors_mut();
    // SAFETY: called once, with interrupts off.
    *motors.engine() = unsafe { step::start(pins, base) };
    // SAFETY: nobody else asks for them, and it is in flash.
    let feed = |axis, feed: &mut _| unsafe { step::lend(axis, feed) };
    motors.power_up_for_orders(feed, |given| unsafe { BOARD.load(given) });
    slave.device.get().begin(board::AXES as u8, &mut slave.panel);
    slave
}

/// The right to the device, which only `start` makes, once.
struct Owner(());

impl Owner {
    /// The device. At a fixed address, and not through a pointer: that makes all
    /// that works on it shorter by a tenth.
    #[inline(always)]
    fn get(&mut self) -> &mut Controller {
        // SAFETY: there is one owner, which is borrowed for as long, and no interrupt
        // asks for the device.
        unsafe { DEVICE.get() }
    }
}

impl Slave {
    /// One piece of planning. The bench times it by its name.
    #[inline(never)]
    fn plan(&mut self) -> bool {
        self.device.get().plan()
    }

    /// Takes what has come, up to the end of a line.
    #[inline(never)]
    fn listen(&mut self) {
        while self.device.get().listens()
            && let Some(received) = self.serial.receive()
        {
            match received {
                Received::Byte(byte) => {
                    self.device.get().receive(byte, &mut self.panel);
                }
                Received::Garbled => self.device.get().garbled(),
            }
        }
    }

    /// Obeys a line, or does one piece of starting an order. The bench times it by its name.
    #[inline(never)]
    fn work(&mut self) {
        self.device.get().work(&mut self.panel);
    }

    /// Sends of the answer as much as there is room for. Planning goes on
    /// meanwhile.
    #[inline(never)]
    fn next_byte(&mut self) {
        while self.serial.has_room()
            && let Some(byte) = self.device.get().next_byte(&mut self.panel)
        {
            self.serial.send(byte);
        }
    }
}
