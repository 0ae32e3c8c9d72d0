//! A controller with S-curves, small enough for an Uno: it takes the line's every
//! word about travels, plans three motors ahead as the controller does, and has no
//! settings and no switches, whose place the curves take; its drivers are always on.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright::{Given, Steppers};
use stepwright_avr::board::{self, AXES};
use stepwright_avr::in_flash::InFlash;
use stepwright_avr::serial::Serial;
use stepwright_avr::step::{AvrEngine, RUNS};
use stepwright_avr::{chip, reset, slot::Slot, step, watchdog};
use stepwright_device::Mark;
use stepwright_device::main_loop::{self, Foreground};
use stepwright_protocol::Slave;

/// All that the main loop works with.
struct Board {
    slave: SlaveOwner,
    motors: MotorsOwner,
}

type Motors = Steppers<'static, AvrEngine, AXES, RUNS, ()>;

/// All zeros, which take no flash; `start` does the rest.
static SLAVE: Slot<Slave<AXES>> = Slot::new(Slave::blank());
static MOTORS: Slot<Motors> =
    // SAFETY: `start` powers them up before anything else.
    Slot::new(unsafe { Steppers::blank(AvrEngine::NONE) });

/// Its board.
#[unsafe(link_section = ".progmem.data")]
static BOARD: InFlash<Given<AXES>> = InFlash::new(Given::new(board::description()));

stepwright_avr::step_interrupts!();
stepwright_avr::serial_interrupts!();

#[avr_device::entry]
fn main() -> ! {
    let mut base = [0; board::AXES];
    // SAFETY: called once, with interrupts off; this frame is never left.
    let (mut board, mut line) = unsafe { start(&mut *(&raw mut base)) };
    // SAFETY: all that an interrupt touches has been made.
    unsafe { avr_device::interrupt::enable() };
    main_loop::run(&mut board, &mut line)
}

/// Makes everything, as at power-up.
///
/// # Safety
/// To be called once, with interrupts off.
#[inline(never)]
unsafe fn start(base: &'static mut [i64; board::AXES]) -> (Board, Serial) {
    // SAFETY: the only time that anybody takes them.
    let chip = unsafe { chip::Peripherals::steal() };
    watchdog::start(&chip.WDT);
    #[cfg(feature = "uno")]
    let (pins, mut levels) = board::pins(chip.PORTD, chip.PORTB);
    #[cfg(feature = "mega")]
    let (pins, mut levels) = board::pins(chip.PORTB, chip.PORTE, chip.PORTG, chip.PORTH);
    levels.set_enable(false); // on while it is low
    let line = Serial::start(chip.USART0);
    let mut board = Board { slave: SlaveOwner(()), motors: MotorsOwner(()) };
    board.slave.get().begin();
    let motors = board.motors.get();
    // SAFETY: called once, with interrupts off.
    *motors.engine() = unsafe { step::start(pins, base) };
    // SAFETY: nobody else asks for them, and it is in flash.
    let feed = |axis, feed: &mut _| unsafe { step::lend(axis, feed) };
    motors.power_up_for_orders(feed, |given| unsafe { BOARD.load(given) });
    if reset::doubts() {
        motors.doubt();
    }
    (board, line)
}

/// The right to the line's end, which only `start` makes, once.
struct SlaveOwner(());

impl SlaveOwner {
    /// The line's end. At a fixed address, as in the controller.
    #[inline(always)]
    fn get(&mut self) -> &mut Slave<AXES> {
        // SAFETY: there is one owner, which is borrowed for as long, and no interrupt
        // asks for it.
        unsafe { SLAVE.get() }
    }
}

/// The right to the motors, likewise.
struct MotorsOwner(());

impl MotorsOwner {
    /// The motors.
    #[inline(always)]
    fn get(&mut self) -> &mut Motors {
        // SAFETY: as above.
        unsafe { MOTORS.get() }
    }
}

impl Foreground for Board {
    #[inline(always)]
    fn tick(&mut self) {
        watchdog::feed();
    }
    #[inline(always)]
    fn is_answering(&mut self) -> bool {
        self.slave.get().is_answering()
    }
    #[inline(always)]
    fn listens(&mut self) -> bool {
        self.slave.get().listens()
    }
    #[inline(always)]
    fn receive(&mut self, byte: u8) {
        self.slave.get().receive(byte, self.motors.get());
    }
    #[inline(always)]
    fn garbled(&mut self) {
        self.slave.get().garbled();
    }
    #[inline(always)]
    fn work(&mut self) {
        self.slave.get().work(self.motors.get());
        // Never taken back: this board's RAM has to be cold for a power-up to be one of a
        // known position.
        if self.motors.get().any_moving() {
            reset::set_mark(Mark::MOVING);
        }
    }
    #[inline(always)]
    fn next_byte(&mut self) -> Option<u8> {
        self.slave.get().next_byte(self.motors.get())
    }
    #[inline(always)]
    fn plan(&mut self) -> bool {
        self.motors.get().plan()
    }
}
