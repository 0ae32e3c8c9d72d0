//! The parts of a chip's self-test beside `stepwright-selftest`: the checksum of the flash,
//! repeated output of the line, and a capture for chips whose processor makes the steps.

use core::marker::PhantomData;
use core::sync::atomic::Ordering::Relaxed;
use core::sync::atomic::{AtomicBool, AtomicU32};

use stepwright::drive::{Axes, Drive};
use stepwright::timer::StepTimer;
use stepwright::{Board, EngineHandle, HoldOff, OrderedMotors, SharedEngine};
use stepwright_device::main_loop::SerialPort;
use stepwright_selftest::{Capture, Chip, Crc32, Found, Line, MOST_PULSES};

use crate::{AXES, PinPort, PortPins, RUNS};

/// CRC-32 of the program in the flash of a Cortex-M: from the vectors to the end of the data that
/// is copied to RAM.
pub fn flash_sum() -> u32 {
    unsafe extern "C" {
        static __vector_table: u32;
        static __sidata: u32;
        static __sdata: u32;
        static __edata: u32;
    }
    // Symbols of the linker's script: only their addresses are used.
    let first = &raw const __vector_table as usize;
    let [load, data, end] =
        [&raw const __sidata, &raw const __sdata, &raw const __edata].map(|symbol| symbol as usize);
    let last = load.wrapping_add(end.wrapping_sub(data));
    let mut sum = Crc32::new();
    let mut at = first;
    while at < last {
        // SAFETY: a word of the flash. `link.x` aligns all of it to words.
        sum.add(unsafe { (at as *const u32).read_volatile() });
        at = at.wrapping_add(4);
    }
    sum.end()
}

/// The self-test of a chip whose step interrupt stamps its pulses: plays, then sends the line for
/// ever. `board` is the chip's: a constant of the program, so that the compiler sees that its rate
/// is not 0.
#[inline(always)]
pub fn run_stamped<T: StepTimer, P: StampPort, H: HoldOff>(
    engine: &'static SharedEngine<T, StampedPins<P>, H, AXES, RUNS>,
    timer: T,
    pins: PortPins<P>,
    chip: &'static Chip,
    board: Board<AXES>,
    line: &mut impl SerialPort,
) -> ! {
    if let Some((engine, feeds)) = engine.fill(timer, StampedPins(pins), &board) {
        // SAFETY: they are filled before anything else. (If `new` is not inlined, the compiler does
        // not see the constant.)
        let mut motors = unsafe { OrderedMotors::blank(EngineHandle::none()) };
        motors.fill(engine, feeds, &board);
        let found = stepwright_selftest::run(&mut motors, chip, &mut Stamped::<P>(PhantomData));
        tell(chip, found, None, line)
    }
    // The engine was filled elsewhere, which no program does.
    loop {
        core::hint::spin_loop();
    }
}

/// Sends the result again and again, because a listener may come late.
pub fn tell(chip: &Chip, found: Found, khz: Option<u32>, line: &mut impl SerialPort) -> ! {
    let (version, flash) = (env!("CARGO_PKG_VERSION"), flash_sum());
    let said = Line { chip: chip.name, version, flash, hz: chip.rate.hz(), found, khz };
    loop {
        said.tell(|byte| send(line, byte));
        send(line, b'\r');
        send(line, b'\n');
    }
}

/// Sends a byte, after waiting for room.
fn send(line: &mut impl SerialPort, byte: u8) {
    while !line.has_room() {}
    line.send(byte);
}

/// Times for the edges of an order, and one more.
const ROOM: usize = MOST_PULSES as usize + 1;

/// The edges of STEP, as the processor saw them: a static of the chip. The step interrupt writes
/// it, the main loop reads it when the axis rests.
pub struct Stamps {
    /// The bit of STEP of the captured axis.
    axis: AtomicU32,
    /// The time when the present pulse rose, and whether the pin was low before it.
    rose: AtomicU32,
    was_low: AtomicBool,
    count: AtomicU32,
    rises: [AtomicU32; ROOM],
}

impl Stamps {
    /// No edges yet.
    pub const fn new() -> Stamps {
        Stamps {
            axis: AtomicU32::new(0),
            rose: AtomicU32::new(0),
            was_low: AtomicBool::new(false),
            count: AtomicU32::new(0),
            rises: [const { AtomicU32::new(0) }; ROOM],
        }
    }
}

impl Default for Stamps {
    fn default() -> Self {
        Stamps::new()
    }
}

/// A port whose levels can be read back from its outputs.
pub trait StampPort: PinPort {
    /// The step timer's count.
    fn count() -> u32;

    /// Whether the pin with this bit is high: its actual level, not the written one.
    fn is_high(bit: u32) -> bool;

    /// The edges.
    fn stamps() -> &'static Stamps;
}

/// STEP and DIR with stamped pulses. An edge counts if the pin was low before it and is high when
/// the pulse ends. Its time is read after the write that raises the pin.
pub struct StampedPins<P>(pub PortPins<P>);

impl<P: StampPort> Drive for StampedPins<P> {
    #[inline(always)]
    fn begin(&mut self, axes: Axes) {
        let stamps = P::stamps();
        stamps.was_low.store(!P::is_high(stamps.axis.load(Relaxed)), Relaxed);
        self.0.begin(axes);
        stamps.rose.store(P::count(), Relaxed);
    }

    #[inline(always)]
    fn end(&mut self, axes: Axes) {
        let stamps = P::stamps();
        let bit = stamps.axis.load(Relaxed);
        if u32::from(axes) << P::STEP & bit != 0 && stamps.was_low.load(Relaxed) && P::is_high(bit)
        {
            let count = stamps.count.load(Relaxed);
            if let Some(place) = stamps.rises.get(count as usize) {
                place.store(stamps.rose.load(Relaxed), Relaxed);
                stamps.count.store(count.wrapping_add(1), Relaxed);
            }
        }
        self.0.end(axes);
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        self.0.direction(axis, forward);
    }
}

/// The edges of such pins, for the main loop.
struct Stamped<P>(PhantomData<P>);

impl<P: StampPort> Capture for Stamped<P> {
    fn begin(&mut self, axis: u8) {
        let stamps = P::stamps();
        stamps.count.store(0, Relaxed);
        stamps.axis.store(1u32.wrapping_shl(P::STEP.wrapping_add(axis.into())), Relaxed);
    }

    fn count(&self) -> u32 {
        P::stamps().count.load(Relaxed)
    }

    fn rise(&self, number: u32) -> Option<u32> {
        let place = P::stamps().rises.get(number as usize).filter(|_| number < self.count());
        place.map(|rise| rise.load(Relaxed))
    }
}
