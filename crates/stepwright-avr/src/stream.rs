//! The player of a host's stream: frames and the common text lines over one serial line, three
//! axes, no planner.
//!
//! ```text
//!   serial interrupts ──► StreamDevice ──► entries, some 12 ms ahead ──► step interrupts
//!   (two rings)           (main loop, interrupts on; FIFO of frames)
//! ```

use core::mem::MaybeUninit;

use stepwright::entry::Wiring;
use stepwright::queue::Producer;
use stepwright::{Control, Ticks};
use stepwright_device::main_loop;
use stepwright_device::{StreamDevice, StreamIo};
use stepwright_protocol::flash_text;
use stepwright_stream::player::StreamPlayer;

use crate::board::{self, AXES, CLOCK, Levels};
use crate::clock::Clock;
use crate::reset::RamMark;
use crate::serial::Serial;
use crate::slot::{Slot, token};
use crate::step::{self, AvrEngine, RUNS};
use crate::{chip, watchdog};

/// The bytes of frames that can wait.
pub const FIFO: usize = if cfg!(feature = "mega") { 4_096 } else { 896 };

/// The shortest wait, in ticks: a step is 70 cycles of interrupt.
const LEAST: Ticks = 72;

type Board = StreamDevice<'static, AvrEngine, AvrStreamIo, RamMark, RUNS, FIFO>;

/// The base positions of the present travels.
static BASE: Slot<[i64; AXES]> = Slot::new([0; AXES]);

const WIRINGS: [Wiring; AXES] = [board::wiring(0), board::wiring(1), board::wiring(2)];

/// The whole board; `start` adds the engine, the queues and the pins. It is built in place, because
/// the stack has no room for a copy.
static BOARD: Slot<Board> = Slot::new(StreamDevice::new(
    StreamPlayer::new(
        AvrEngine::NONE,
        // SAFETY: `lend` expects producers of zeros, and `start` lends them before anything else.
        unsafe { MaybeUninit::<[Producer<'static, RUNS>; AXES]>::zeroed().assume_init() },
        WIRINGS,
        LEAST,
    ),
    // SAFETY: not used before `start`.
    unsafe { AvrStreamIo { clock: Clock::blank(), levels: token() } },
    RamMark,
    if cfg!(feature = "mega") { flash_text!("mega") } else { flash_text!("uno") },
    CLOCK,
));

/// The chip's side of its stream.
struct AvrStreamIo {
    clock: Clock,
    levels: Levels,
}

impl StreamIo for AvrStreamIo {
    #[inline(always)]
    fn now(&mut self) -> u16 {
        step::now()
    }

    #[inline(always)]
    fn ticked(&mut self) -> bool {
        self.clock.ticked()
    }

    fn inputs(&mut self) -> u8 {
        let mut inputs = !self.levels.switches() & 0b111;
        if !self.levels.driver_fault() {
            inputs |= 1 << 6;
        }
        if !self.levels.emergency() {
            inputs |= 1 << 7;
        }
        inputs
    }

    fn enable(&mut self) {
        self.levels.set_enable(false); // on while it is low
    }

    #[cfg(feature = "mega")]
    const LASER: bool = true;

    #[cfg(feature = "mega")]
    fn set_power(&mut self, power: u8) {
        laser::set(power);
    }
}

/// A Mega's laser: D46, by timer 5 in fast PWM of 8 bits at 7.8 kHz. The pin is low from power-up
/// on, and has no pulses while the power is 0.
#[cfg(feature = "mega")]
mod laser {
    use crate::chip::{PORTL, TC5};

    /// D46 on port L: OC5A.
    const PIN: u8 = 1 << 3;
    /// Fast PWM of 8 bits (WGM 5), with the clock divided by 8.
    const MODE_A: u8 = 1;
    const MODE_B: u8 = 1 << 3 | 0b010;
    /// Clears OC5A at a match, sets it at the bottom.
    const OUTPUT: u8 = 0b10 << 6;

    /// Makes the pin a low output.
    pub fn start(port: PORTL) {
        // SAFETY: directions and modes affect no memory; nothing else uses port L and timer 5.
        unsafe {
            port.ddrl().write(|w| w.bits(PIN));
            let timer = TC5::steal();
            timer.tccr5a().write(|w| w.bits(MODE_A));
            timer.tccr5b().write(|w| w.bits(MODE_B));
        }
    }

    /// Sets the duty: `power` + 1 parts of 256; 0 is off, and 255 is on without a pause.
    pub fn set(power: u8) {
        let (level, mode) = match power {
            0 => (0, MODE_A),
            255 => (PIN, MODE_A),
            _ => (0, MODE_A | OUTPUT),
        };
        // SAFETY: as in `start`.
        unsafe {
            let timer = TC5::steal();
            timer.ocr5a().write(|w| w.bits(power.into()));
            timer.tccr5a().write(|w| w.bits(mode));
            PORTL::steal().portl().write(|w| w.bits(level));
        }
    }
}

/// The board and its line.
pub struct StreamDesk {
    board: &'static mut Board,
    serial: Serial,
}

impl StreamDesk {
    /// Sets up everything, as at power-up.
    ///
    /// # Safety
    /// To be called once, with interrupts off.
    #[inline(never)]
    pub unsafe fn start() -> StreamDesk {
        // SAFETY: they are taken only here.
        let chip = unsafe { chip::Peripherals::steal() };
        watchdog::start(&chip.WDT);
        #[cfg(feature = "uno")]
        let (pins, levels) = board::pins(chip.PORTD, chip.PORTB);
        #[cfg(feature = "mega")]
        let (pins, levels) = board::pins(chip.PORTB, chip.PORTE, chip.PORTG, chip.PORTH);
        #[cfg(feature = "mega")]
        laser::start(chip.PORTL);
        // SAFETY: taken only here.
        let board = unsafe { BOARD.get() };
        board.io = AvrStreamIo { clock: Clock::start(chip.TC0), levels };
        let player = board.player();
        // SAFETY: the caller's promise.
        *player.engine() = unsafe { step::start(pins, BASE.get()) };
        for (axis, feed) in (0u8..).zip(player.feeds()) {
            // SAFETY: all zeros, and the only one of its axis.
            unsafe { step::lend(axis, feed) };
        }
        // The engine spaces late steps by the minimum interval.
        let mut timing = board::description().timing;
        timing.min_interval = timing.min_interval.min(LEAST);
        player.engine().set_timing(timing);
        board.begin();
        StreamDesk { board, serial: Serial::start(chip.USART0) }
    }

    /// Handles frames and lines, for ever.
    pub fn serve(mut self) -> ! {
        loop {
            watchdog::feed();
            main_loop::round(self.board, &mut self.serial);
        }
    }
}
