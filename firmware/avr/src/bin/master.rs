//! The other end of the wire: a board that has a slave carry out a programme.
//!
//! It sends the Nano slave's lines, so any slave that knows them will do. Its TX is connected to
//! the slave's RX and the other way round, ground to ground. D13 is the lamp on the board; a button
//! connects D2 to ground.
//!
//! | lamp | |
//! | --- | --- |
//! | off | under way |
//! | on | done |
//! | blinks once a second | the slave is silent |
//! | blinks five times a second | the slave refused a line, or is elsewhere |
//!
//! The button starts the programme again.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright::Speed;
use stepwright_avr::chip::{self, PORTB};
use stepwright_avr::clock::Clock;
use stepwright_avr::serial::Serial;
use stepwright_avr::watchdog;
use stepwright_device::main_loop::{Received, SerialPort};
use stepwright_protocol::{
    AxisId, Command, Distance, Master, Order, Ramp, RampSteps, Reply, Script, Travel,
};

/// The targets of axis 1, in steps from its initial position, and the number of rounds.
const STOPS: [i64; 3] = [4000, -4000, 0];
const ROUNDS: u8 = 2;
/// Steps per second at the ends of a travel, and at its top.
const START: u32 = 50;
const TOP: u32 = 1000;
/// Steps of both ramps.
const RAMP: u32 = 200;

/// The longest wait for an answer in ms. A slave answers within some milliseconds.
const SILENCE: u16 = 500;
/// The milliseconds between two queries of the status.
const PAUSE: u16 = 20;
/// The number of attempts when lines get lost.
const TRIES: u8 = 3;

/// The reason why the programme was given up.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fault {
    /// No answer came.
    Silent,
    /// The answer was E, or the axis is where it should not be.
    Refused,
}

/// The master's half of the line, lamp and button.
struct Board {
    master: Master,
    serial: Serial,
    clock: Clock,
    lamp: PORTB,
    #[cfg(feature = "uno")]
    button: chip::PORTD,
    #[cfg(feature = "mega")]
    button: chip::PORTE,
}

stepwright_avr::serial_interrupts!();

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: they are taken only here, and interrupts are off.
    let mut board = Board::new(unsafe { chip::Peripherals::steal() });
    // SAFETY: everything that an interrupt uses is set up.
    unsafe { avr_device::interrupt::enable() };
    loop {
        board.set_lamp(false);
        let blink = match board.carry_out() {
            Ok(()) => 0,
            Err(Fault::Refused) => 100,
            Err(Fault::Silent) => 500,
        };
        board.show(blink);
    }
}

impl Board {
    /// Carries the programme out.
    fn carry_out(&mut self) -> Result<(), Fault> {
        self.get_in_step()?;
        self.arrive()?;
        let home = self.position()?;
        for _ in 0..ROUNDS {
            for stop in STOPS {
                self.go(home.wrapping_add(stop))?;
            }
        }
        Ok(())
    }

    /// Moves axis 1 to a position. If a line or its answer was lost, the master can't know which,
    /// so this reads the position and goes on from there.
    fn go(&mut self, to: i64) -> Result<(), Fault> {
        let mut ended = self.try_to_go(to);
        for _ in 1..TRIES {
            if ended.is_ok() {
                break;
            }
            self.get_in_step()?;
            ended = self.try_to_go(to);
        }
        ended
    }

    fn try_to_go(&mut self, to: i64) -> Result<(), Fault> {
        self.arrive()?;
        let way = to.wrapping_sub(self.position()?);
        if way == 0 {
            return Ok(());
        }
        let orders = [(AxisId::FIRST, order(way).ok_or(Fault::Refused)?)];
        for command in Script::new(&orders).map_err(|_| Fault::Refused)? {
            if self.ask(command)? != Reply::Yes {
                return Err(Fault::Refused);
            }
        }
        self.arrive()?;
        if self.position()? == to { Ok(()) } else { Err(Fault::Refused) }
    }

    /// Waits until the slave is ready. The query may be repeated.
    fn arrive(&mut self) -> Result<(), Fault> {
        loop {
            match self.ask(Command::Status) {
                Ok(Reply::Ready) => return Ok(()),
                Ok(_) => self.wait(PAUSE),
                Err(_) => self.get_in_step()?,
            }
        }
    }

    /// The position of axis 1. E may mean that the line came damaged, so the query is repeated then
    /// as well.
    fn position(&mut self) -> Result<i64, Fault> {
        for _ in 0..TRIES {
            match self.ask(Command::Position(AxisId::FIRST)) {
                Ok(Reply::Position(steps)) => return Ok(steps),
                _ => self.get_in_step()?,
            }
        }
        Err(Fault::Refused)
    }

    /// Sends a line, and waits for its answer.
    fn ask(&mut self, command: Command) -> Result<Reply, Fault> {
        let line = self.master.send(command).map_err(|_| Fault::Silent)?;
        self.send(line);
        self.receive().ok_or(Fault::Silent)
    }

    /// Starts afresh after a silence: see [`Master::resync`].
    fn get_in_step(&mut self) -> Result<(), Fault> {
        for _ in 0..TRIES {
            let line = self.master.resync();
            self.send(line);
            if self.receive().is_some() {
                return Ok(());
            }
        }
        Err(Fault::Silent)
    }

    fn send(&mut self, line: impl Iterator<Item = u8>) {
        for byte in line {
            while !self.serial.has_room() {}
            self.serial.send(byte);
        }
    }

    /// The answer, or `None` after a silence.
    fn receive(&mut self) -> Option<Reply> {
        let mut silent = 0;
        while silent < SILENCE {
            match self.serial.receive() {
                Some(Received::Byte(byte)) => {
                    let reply = self.master.receive(byte);
                    if reply.is_some() {
                        return reply;
                    }
                }
                // A damaged answer is noise, and skipped.
                Some(Received::Garbled) | None => {}
            }
            silent += self.tick();
        }
        None
    }

    /// Waits for this many milliseconds.
    fn wait(&mut self, millis: u16) {
        let mut passed = 0;
        while passed < millis {
            passed += self.tick();
        }
    }

    /// The milliseconds since the last call. Feeds the watchdog.
    fn tick(&mut self) -> u16 {
        watchdog::feed();
        self.clock.ticked().into()
    }

    /// Shows the result until the button is pressed and released: the lamp changes every `blink`
    /// milliseconds, or is on if that is 0.
    fn show(&mut self, blink: u16) {
        let mut lit = true;
        let mut pressed = false;
        let mut since = 0;
        loop {
            self.set_lamp(lit);
            // A button bounces for some milliseconds.
            self.wait(10);
            match (pressed, self.is_pressed()) {
                (true, false) => return,
                (_, now) => pressed = now,
            }
            since += 10;
            if blink != 0 && since >= blink {
                since = 0;
                lit = !lit;
            }
        }
    }
}

/// A travel of this many steps; `None` if the line can't express it.
fn order(way: i64) -> Option<Order> {
    let ramp = Ramp::Steps(RampSteps::new(RAMP)?);
    Some(Order {
        start: Speed::from_steps(START).ok()?,
        top: Speed::from_steps(TOP).ok()?,
        up: ramp,
        down: ramp,
        jerk: None,
        travel: Travel::By(Distance::new(i32::try_from(way).ok()?)),
    })
}

/// D13 on port B.
#[cfg(feature = "uno")]
const LAMP: u8 = 1 << 5;
#[cfg(feature = "mega")]
const LAMP: u8 = 1 << 7;

impl Board {
    /// Sets up lamp, button and everything else.
    fn new(chip: chip::Peripherals) -> Board {
        watchdog::start(&chip.WDT);
        // SAFETY: a level or direction of pins affects no memory.
        chip.PORTB.ddrb().write(|w| unsafe { w.bits(LAMP) });
        #[cfg(feature = "uno")]
        let button = chip.PORTD;
        #[cfg(feature = "uno")]
        button.portd().write(|w| w.pd2().set_bit());
        #[cfg(feature = "mega")]
        let button = chip.PORTE;
        #[cfg(feature = "mega")]
        button.porte().write(|w| w.pe4().set_bit());
        Board {
            master: Master::new(),
            serial: Serial::start(chip.USART0),
            clock: Clock::start(chip.TC0),
            lamp: chip.PORTB,
            button,
        }
    }

    fn set_lamp(&mut self, lit: bool) {
        // SAFETY: a level of a pin affects no memory.
        self.lamp.portb().write(|w| unsafe { w.bits(if lit { LAMP } else { 0 }) });
    }

    fn is_pressed(&self) -> bool {
        #[cfg(feature = "uno")]
        let level = self.button.pind().read().pd2();
        #[cfg(feature = "mega")]
        let level = self.button.pine().read().pe4();
        level.bit_is_clear()
    }
}
