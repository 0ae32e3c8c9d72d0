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
    static mut GROUP: core::mem::MaybeUninit<Group<'static, 3, 8>> = core::mem::MaybeUninit::uninit();
    static mut SLAVE: Slave<3> = Slave::new();
    static mut ANSWER: Option<Bytes<Reply>> = None;
    let group = unsafe { (&mut *(&raw mut GROUP)).write(Group::new(feeds, board)) };
    let slave = unsafe { &mut *(&raw mut SLAVE) };
    let answer = unsafe { &mut *(&raw mut ANSWER) };
    levels.set_enable(false);
    // SAFETY: all that an interrupt touches has been made.
    unsafe { avr_device::interrupt::enable() };

    loop {
        watchdog::feed();
        let _ = (clock.passed(), bitten);
        if answer.is_some() { drain(answer, &mut serial) } else { listen(&mut serial, group, slave, answer, &mut engine) }
        group.poll(&mut engine);
    }
}
#[inline(never)]
fn drain(answer: &mut Option<Bytes<Reply>>, serial: &mut Serial) {
    let Some(bytes) = answer else { return };
                while serial.has_room() {
                    match bytes.next() {
                        Some(byte) => serial.send(byte),
                        None => {
                            *answer = None;
                            break;
                        }
                    }
                }
}
#[inline(never)]
fn listen(serial: &mut Serial, group: &mut Group<'static, 3, 8>, slave: &mut Slave<3>, answer: &mut Option<Bytes<Reply>>, engine: &mut step::Held) {
    match serial.receive() {
                Some(Received::Byte(byte)) => {
                    let mut machine = Controller {
                        group,
                        engine,
                        axes: board::AXES as u8,
                    };
                    *answer = slave.push(byte, &mut machine).map(Reply::bytes);
                }
                Some(Received::Garbled) => slave.garbled(),
                None => {}
            }
}
