//! Motors for your own program: three on the pins of the CNC shield, moved by the step interrupts
//! while the program does other work.

use stepwright::{Axis, MoveError, PlannedBoard};

use crate::board::{self, AXES};
use crate::chip::Peripherals;
use crate::in_flash::InFlash;
use crate::lamp;
use crate::slot::Slot;
use crate::step::{self, AvrEngine, RUNS};

/// The motors: X, Y and Z of the shield.
pub type Steppers = stepwright::Steppers<'static, AvrEngine, AXES, RUNS>;

/// Zeros, which take no flash; `start` sets the rest.
static MOTORS: Slot<Steppers> =
    // SAFETY: `start` powers them up before anything else.
    Slot::new(unsafe { Steppers::blank(AvrEngine::NONE) });

/// The base positions of the present travels.
static BASE: Slot<[i64; AXES]> = Slot::new([0; AXES]);

/// The description of the board.
#[unsafe(link_section = ".progmem.data")]
static BOARD: InFlash<PlannedBoard<AXES>> = InFlash::new(PlannedBoard::new(board::description()));

/// Makes a program from a function that moves motors: `fn main(motors: &mut Steppers) -> Result<(),
/// MoveError>`. The function is called once, with the drivers on, and all motors at rest at
/// position 0.
///
/// When it returns, the moves that have begun continue. An error lights the lamp at D13.
#[macro_export]
macro_rules! steppers {
    ($program:path) => {
        $crate::step_interrupts!();

        #[avr_device::entry]
        fn stepwright_program() -> ! {
            // SAFETY: called once, with interrupts off.
            let motors = unsafe { $crate::steppers::start() };
            // SAFETY: everything that an interrupt uses is set up.
            unsafe { avr_device::interrupt::enable() };
            let result = $program(motors);
            $crate::steppers::go_on(motors, result)
        }
    };
}

/// Takes the chip, and switches the drivers on.
///
/// # Safety
/// To be called once, with interrupts off.
#[doc(hidden)]
pub unsafe fn start() -> &'static mut Steppers {
    // SAFETY: they are taken only here.
    let chip = unsafe { Peripherals::steal() };
    #[cfg(feature = "uno")]
    let (pins, mut levels) = board::pins(chip.PORTD, chip.PORTB);
    #[cfg(feature = "mega")]
    let (pins, mut levels) = board::pins(chip.PORTB, chip.PORTE, chip.PORTG, chip.PORTH);
    levels.set_enable(false); // on while it is low
    // SAFETY: taken only here.
    let motors = unsafe { MOTORS.get() };
    // SAFETY: called once, with interrupts off.
    *motors.engine() = unsafe { step::start(pins, BASE.get()) };
    // SAFETY: nothing else takes the feeds, and the board is in flash.
    let feed = |axis, feed: &mut _| unsafe { step::lend(axis, feed) };
    motors.power_up(feed, |given| unsafe { BOARD.load(given) });
    motors
}

/// Whether the limit switch of an axis is closed: it connects D9, D10 or D11 (X, Y, Z), which have
/// pull-ups, to ground. Nothing stops at it by itself.
pub fn is_pressed(axis: Axis<AXES>) -> bool {
    board::switches() >> axis.index() & 1 == 0
}

/// Continues the moves in progress after the program has returned.
#[doc(hidden)]
pub fn go_on(motors: &mut Steppers, result: Result<(), MoveError>) -> ! {
    if result.is_err() {
        lamp::set(true);
    }
    loop {
        motors.poll();
    }
}
