//! A small controller whose law runs in the step interrupt: it takes lines, and
//! moves three motors along Austin's ramp. Whatever the main loop does, no
//! step waits for it.
//!
//! Its ramps up and down are alike, it has no settings, and its drivers are
//! always on.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright::Order;
use stepwright::direct::Motors;
use stepwright_avr::board::{self, AXES};
use stepwright_avr::direct::Held;
use stepwright_avr::serial::{Received, Serial};
use stepwright_avr::timer::Timer;
use stepwright_avr::{chip, direct, reset, slot::Slot, watchdog};
use stepwright_device::Mark;
use stepwright_protocol::{AxisId, Machine, Refusal, Slave};

/// All that the main loop works with.
struct Board {
    slave: &'static mut Slave<AXES>,
    joined: Joined,
    serial: Serial,
}

/// The motors and the engine.
struct Joined {
    motors: &'static mut Motors<AXES>,
    engine: Held,
}

/// Their memory is filled when the chip starts.
static SLAVE: Slot<Slave<AXES>> = Slot::new(Slave::blank());
static MOTORS: Slot<Motors<AXES>> = Slot::new(Motors::new(board::direct()));

stepwright_avr::step_interrupt!(direct);
stepwright_avr::serial_interrupts!();

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: called once, with interrupts off.
    let mut board = unsafe { start() };
    // SAFETY: all that an interrupt touches has been made.
    unsafe { avr_device::interrupt::enable() };
    let mut turns = 0u16;
    loop {
        watchdog::feed();
        if board.slave.is_speaking() {
            board.speak();
        } else {
            board.listen();
        }
        // Once in a second or some: it holds the step interrupt off.
        turns = turns.wrapping_add(1);
        if turns == 0 {
            board.joined.motors.poll(&mut board.joined.engine);
        }
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
        // SAFETY: the only one to ask.
        slave: unsafe { SLAVE.get() },
        joined: Joined {
            // SAFETY: the only one to ask.
            motors: unsafe { MOTORS.get() },
            // SAFETY: called once, with interrupts off.
            engine: unsafe { direct::start(Timer::start(), pins) },
        },
        serial: Serial::start(chip.USART0),
    };
    board.slave.begin();
    if reset::doubts() {
        board.joined.motors.doubt();
    }
    board
}

impl Board {
    /// Takes what has come, up to the end of a line.
    #[inline(never)]
    fn listen(&mut self) {
        while let Some(received) = self.serial.receive() {
            match received {
                Received::Byte(byte) => {
                    if self.slave.hear(byte, &mut self.joined) {
                        return;
                    }
                }
                Received::Garbled => self.slave.garbled(),
            }
        }
    }

    /// Sends of the answer as much as there is room for.
    #[inline(never)]
    fn speak(&mut self) {
        while self.serial.has_room()
            && let Some(byte) = self.slave.speak(&mut self.joined)
        {
            self.serial.send(byte);
        }
    }
}

impl Machine for Joined {
    fn axes(&self) -> u8 {
        AXES as u8
    }

    fn busy(&self, axis: AxisId) -> bool {
        self.motors.is_busy(&self.engine, axis.index() as u8)
    }

    fn prepare(&mut self, axis: AxisId, order: &Order) -> Result<(), Refusal> {
        Ok(self.motors.prepare(&mut self.engine, axis.index() as u8, order)?)
    }

    fn commit(&mut self) -> Result<(), Refusal> {
        // Never taken back: RAM has to be cold for a power-up to be one of a known
        // position.
        reset::set_mark(Mark::MOVING);
        Ok(self.motors.commit(&mut self.engine)?)
    }

    fn cancel(&mut self) {
        self.motors.cancel(&mut self.engine);
    }

    fn brake(&mut self, axis: AxisId) {
        self.motors.brake(&mut self.engine, axis.index() as u8);
    }

    fn kill(&mut self) {
        self.motors.kill(&mut self.engine);
    }

    fn position(&self, axis: AxisId) -> Option<i64> {
        self.motors.position(&self.engine, axis.index() as u8)
    }

    fn uncertain(&self) -> u8 {
        self.motors.uncertain()
    }

    fn zero(&mut self, axis: AxisId) {
        self.motors.zero(&mut self.engine, axis.index() as u8);
    }

    fn max_rate(&self) -> u32 {
        self.motors.board().max_speed().steps()
    }

    fn late(&self) -> u32 {
        use stepwright::Control;
        self.engine.late()
    }

    fn clear_late(&mut self) {
        use stepwright::Control;
        self.engine.clear_late();
    }
}
