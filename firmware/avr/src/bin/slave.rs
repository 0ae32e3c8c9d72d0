//! The controller: it takes lines, and moves three motors.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use stepwright_avr::clock::Clock;
use stepwright_avr::eeprom::Eeprom;
use stepwright_avr::panel::AvrPanel;
use stepwright_avr::serial::{Received, Serial};
use stepwright_avr::step::{Feeds, Held, RUNS};
use stepwright_avr::timer::Timer;
use stepwright_avr::{board, chip, step, watchdog};
use stepwright_device::Device;
use stepwright_protocol::{Bytes, Reply};

type Controller = Device<'static, { board::AXES }, RUNS>;

/// All that the main loop works with.
struct Slave<'a> {
    device: &'a mut Controller,
    engine: Held,
    panel: AvrPanel,
    serial: Serial,
    /// What is still to be sent of the last answer.
    answer: Option<Bytes<Reply>>,
}

stepwright_avr::step_interrupt!();

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: the only time that anybody takes them, and interrupts are off.
    let chip = unsafe { chip::Peripherals::steal() };
    let bitten = watchdog::start(&chip.CPU, &chip.WDT);
    #[cfg(feature = "uno")]
    let (pins, levels) = board::pins(chip.PORTD, chip.PORTB);
    #[cfg(feature = "mega")]
    let (pins, levels) = board::pins(chip.PORTB, chip.PORTE, chip.PORTG, chip.PORTH);
    // SAFETY: called once, with interrupts off.
    let (mut engine, feeds) = unsafe { step::start(Timer::start(), pins, board::timing()) };
    let clock = Clock::start(chip.TC2);
    let mut panel = AvrPanel::new(levels, Eeprom::new(chip.EEPROM), clock);
    let mut device = device(feeds, &mut engine, &mut panel);
    if bitten {
        // Nobody knows where the motors are.
        device.doubt();
    }
    let serial = Serial::start(chip.USART0);
    let mut slave = Slave { device: &mut device, engine, panel, serial, answer: None };
    // SAFETY: all that an interrupt touches has been made.
    unsafe { avr_device::interrupt::enable() };
    loop {
        slave.turn();
    }
}

/// Makes the device: out of line, so that it grows where it stays. There is no
/// room for a second one.
#[inline(never)]
fn device(feeds: Feeds, engine: &mut Held, panel: &mut AvrPanel) -> Controller {
    Device::of(feeds, board::description(), board::AXES as u8, engine, panel)
}

// All are out of line: an AVR reaches no further than 63 bytes from its stack
// pointer with one instruction, and the frame of `main` is far larger.
impl Slave<'_> {
    /// Once round the main loop.
    #[inline(never)]
    fn turn(&mut self) {
        watchdog::feed();
        self.panel.tick();
        if self.answer.is_some() {
            self.speak();
        } else {
            self.listen();
        }
        self.device.poll(&mut self.engine, &mut self.panel);
    }

    /// Takes what has come, up to the end of a line. The master says the next
    /// one after its answer.
    #[inline(never)]
    fn listen(&mut self) {
        while let Some(received) = self.serial.receive() {
            match received {
                Received::Byte(byte) => {
                    let reply = self.device.push(byte, &mut self.engine, &mut self.panel);
                    if let Some(reply) = reply {
                        self.answer = Some(reply.bytes());
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
        let Some(bytes) = &mut self.answer else { return };
        while self.serial.has_room() {
            match bytes.next() {
                Some(byte) => self.serial.send(byte),
                None => {
                    self.answer = None;
                    return;
                }
            }
        }
    }
}
