//! The controller: it takes lines, and moves three motors.
#![no_std]
#![no_main]

use stepwright::Group;
use stepwright_avr::serial::{Received, Serial};
use stepwright_avr::{board, chip, clock::Clock, step, timer, watchdog};
use stepwright_protocol::{Bytes, Controller, Reply, Slave};

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: the only time that anybody takes them, and interrupts are off.
    let chip = unsafe { chip::Peripherals::steal() };
    let bitten = watchdog::start(&chip.CPU, &chip.WDT);
    #[cfg(feature = "uno")]
    let (pins, mut levels) = board::pins(chip.PORTD, chip.PORTB);
    #[cfg(feature = "mega")]
    let (pins, mut levels) = board::pins(chip.PORTB, chip.PORTE, chip.PORTG, chip.PORTH);
    let mut clock = Clock::start(chip.TC2);
    let mut serial = Serial::start(chip.USART0);
    let board = board::description();
    // SAFETY: called once each, with interrupts off.
    let (mut engine, feeds) =
        unsafe { step::start(timer::Timer::start(timer::registers()), pins, board.timing) };
    let mut group = Group::new(feeds, board);
    let mut slave = Slave::<{ board::AXES }>::new();
    let mut answer: Option<Bytes<Reply>> = None;
    levels.set_enable(false);
    // SAFETY: all that an interrupt touches has been made.
    unsafe { avr_device::interrupt::enable() };

    loop {
        watchdog::feed();
        let _ = (clock.passed(), bitten);
        match &mut answer {
            // Planning goes on while a long answer waits for room.
            Some(bytes) => {
                while serial.has_room() {
                    match bytes.next() {
                        Some(byte) => serial.send(byte),
                        None => {
                            answer = None;
                            break;
                        }
                    }
                }
            }
            None => match serial.receive() {
                Some(Received::Byte(byte)) => {
                    let mut machine = Controller {
                        group: &mut group,
                        engine: &mut engine,
                        axes: board::AXES as u8,
                    };
                    answer = slave.push(byte, &mut machine).map(Reply::bytes);
                }
                Some(Received::Garbled) => slave.garbled(),
                None => {}
            },
        }
        group.poll(&mut engine);
    }
}
