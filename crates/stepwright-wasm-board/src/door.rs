//! The functions that a page calls. There is one board and one conversation, and a page has one
//! thread; a worker has a module of its own.
//!
//! | function | what |
//! | --- | --- |
//! | `stepwright_on` | switches a new board on, at tick 0 |
//! | `stepwright_hz`, `_axes`, `_byte_time` | ticks in a second, its axes, ticks of a byte on the line |
//! | `stepwright_now`, `_busy` | ticks since it was switched on; whether an axis moves |
//! | `stepwright_run` | lets time pass until a tick |
//! | `stepwright_receive` | a byte arrives; how many bytes of answers stand at `_out` |
//! | `stepwright_edge_times`, `_edge_pins`, `_edges`, `_edges_kept` | the last edges: see [`Tape`] |
//! | `stepwright_shaft` | where a shaft is, counted at its pins |
//! | `stepwright_in`, `_out` | where texts are written to, and read from |
//! | `stepwright_say` | the bytes of the line at `_in` go to `_out`: how many; 0, if it is none |
//! | `stepwright_resync` | the bytes that get in step again go to `_out`: how many |
//! | `stepwright_hear` | a byte of the board: a number of [`Heard`](crate::Heard) |
//! | `stepwright_answer` | where the numbers of the last answer are |
//! | `stepwright_sums` | whether lines have checksums |
//! | `stepwright_order`, `_low`, `_high` | where the numbers of an order are written to; their ranges |
//! | `stepwright_script` | the lines of the order go to `_out`: how many bytes; or −1 − the place of a number outside its range |
//! | `stepwright_word` | a word of a [`WordList`] goes to `_out`: how long; −1, if there is none |
//! | `stepwright_meaning` | what the line at `_in` means goes to `_out`: how long |
//! | `stepwright_setting` | of a setting: 0 its default, 1 its smallest, 2 its largest number |
//!
//! Addresses hold as long as the module does: nothing is ever allocated.

use core::cell::UnsafeCell;

use stepwright_protocol::Setting;
use stepwright_sim::Queues;

use crate::host::HostHalf;
use crate::machine::VirtualMachine;
use crate::script::{self, OrderField};
use crate::tape::{KEPT, Tape};
use crate::words::{WordList, meaning};

/// The longest line, with room.
const IN: usize = 64;

/// The longest answer of a board.
const OUT: usize = 1024;

/// A text on its way to the page.
struct OutText {
    bytes: [u8; OUT],
    len: usize,
}

impl OutText {
    /// From here on another text; how long it is.
    fn put(&mut self, bytes: impl Iterator<Item = u8>) -> u32 {
        self.len = 0;
        bytes.for_each(|byte| self.push(byte));
        self.len as u32
    }

    fn push(&mut self, byte: u8) {
        if let Some(place) = self.bytes.get_mut(self.len) {
            *place = byte;
            self.len += 1;
        }
    }
}

struct Desk {
    host: HostHalf,
    order: [f64; OrderField::COUNT],
    input: [u8; IN],
    out: OutText,
}

impl Desk {
    fn input(&self, len: u32) -> &[u8] {
        self.input.get(..len as usize).unwrap_or_default()
    }
}

struct OneThread<T>(UnsafeCell<T>);

// SAFETY: WebAssembly without shared memory has one thread; elsewhere nothing calls these
// functions from two.
unsafe impl<T> Sync for OneThread<T> {}

static DESK: OneThread<Desk> = OneThread(UnsafeCell::new(Desk {
    host: HostHalf::new(),
    order: [0.0; OrderField::COUNT],
    input: [0; IN],
    out: OutText { bytes: [0; OUT], len: 0 },
}));

static TAPE: OneThread<Tape> = OneThread(UnsafeCell::new(Tape::new()));
static QUEUES: OneThread<Option<Queues>> = OneThread(UnsafeCell::new(None));
static MACHINE: OneThread<Option<VirtualMachine<'static>>> = OneThread(UnsafeCell::new(None));

fn desk() -> &'static mut Desk {
    // SAFETY: one thread, and no reference outlives a call.
    unsafe { &mut *DESK.0.get() }
}

fn machine() -> &'static mut Option<VirtualMachine<'static>> {
    // SAFETY: one thread, and no reference outlives a call.
    unsafe { &mut *MACHINE.0.get() }
}

/// The machine's edges. Its tape is borrowed as long as there is a machine.
fn tape() -> Option<&'static Tape> {
    machine().as_mut().map(VirtualMachine::tape)
}

/// Switches a new board on, at tick 0; the one before is no more.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_on() {
    *machine() = None;
    // SAFETY: the machine that borrowed them is gone, and nothing else does.
    let (queues, tape) = unsafe { (&mut *QUEUES.0.get(), &mut *TAPE.0.get()) };
    tape.clear();
    *machine() = Some(VirtualMachine::new(queues.insert(Queues::default()), tape));
}

/// Ticks of the board's clock in a second; 0 while it is off.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_hz() -> u32 {
    machine().as_ref().map_or(0, VirtualMachine::hz)
}

/// How many axes the board has.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_axes() -> u32 {
    machine().as_ref().map_or(0, VirtualMachine::axes).into()
}

/// Ticks that a byte takes on its line.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_byte_time() -> u32 {
    machine().as_ref().map_or(0, VirtualMachine::byte_time) as u32
}

/// Ticks since it was switched on.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_now() -> f64 {
    machine().as_ref().map_or(0, VirtualMachine::now) as f64
}

/// Whether an axis moves: 1, or 0.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_busy() -> u32 {
    machine().as_ref().is_some_and(VirtualMachine::is_busy).into()
}

/// Lets time pass until this tick.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_run(until: f64) {
    if let Some(machine) = machine() {
        machine.run_until(until as u64);
    }
}

/// A byte arrives on its line, now. How many bytes it has answered.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_receive(byte: u32) -> u32 {
    let Some(machine) = machine() else { return 0 };
    let answers = machine.receive(byte as u8);
    desk().out.put(answers.iter().copied())
}

/// When the last edges were: see [`Tape::times`]. Null while it is off.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_edge_times() -> *const f64 {
    tape().map_or(core::ptr::null(), |tape| tape.times().as_ptr())
}

/// Of which pins they were: see [`Tape::pins`]. Null while it is off.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_edge_pins() -> *const u8 {
    tape().map_or(core::ptr::null(), |tape| tape.pins().as_ptr())
}

/// How many edges there have been.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_edges() -> u32 {
    tape().map_or(0, Tape::count)
}

/// How many of them are kept.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_edges_kept() -> u32 {
    KEPT as u32
}

/// Steps that an axis, from 0, has made forward, less those backward.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_shaft(axis: u32) -> f64 {
    tape().and_then(|tape| tape.shaft(axis as usize)).map_or(f64::NAN, |steps| steps as f64)
}

/// Where texts are written to.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_in() -> *mut u8 {
    desk().input.as_mut_ptr()
}

/// Where texts are read from.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_out() -> *const u8 {
    desk().out.bytes.as_ptr()
}

/// The bytes of a line, to be put on the line: how many; 0 if it is no line of the protocol.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_say(len: u32) -> u32 {
    let desk = desk();
    let line = desk.input.get(..len as usize).unwrap_or_default();
    match desk.host.say(line) {
        Some(bytes) => desk.out.put(bytes),
        None => 0,
    }
}

/// The bytes that get in step with a board again: how many.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_resync() -> u32 {
    let desk = desk();
    let bytes = desk.host.resync();
    desk.out.put(bytes)
}

/// A byte of the board: a number of [`Heard`](crate::Heard).
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_hear(byte: u32) -> u32 {
    desk().host.hear(byte as u8) as u32
}

/// Where the numbers of the last answer are.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_answer() -> *const f64 {
    desk().host.numbers().as_ptr()
}

/// From now on every line has a checksum, or none.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_sums(on: u32) {
    desk().host.use_sums(on != 0);
}

/// Where the numbers of an order are written to, in the order of [`OrderField`].
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_order() -> *mut f64 {
    desk().order.as_mut_ptr()
}

/// The smallest that is allowed of a number; NaN if there is no such number.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_low(place: u32) -> f64 {
    OrderField::range(place as usize).map_or(f64::NAN, |range| range.low)
}

/// The largest that is allowed of a number; NaN if there is no such number.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_high(place: u32) -> f64 {
    OrderField::range(place as usize).map_or(f64::NAN, |range| range.high)
}

/// The lines of the order: how many bytes; or −1 − the place of a number outside its range.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_script() -> i32 {
    let Desk { order, out, .. } = desk();
    out.len = 0;
    match script::write(order, |byte| out.push(byte)) {
        Ok(()) => out.len as i32,
        Err(place) => -1 - place as i32,
    }
}

/// A word of a table: how long; −1 if there is none.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_word(list: u32, place: u32) -> i32 {
    let list = WordList::ALL.get(list as usize);
    match list.and_then(|list| list.word(place as usize)) {
        Some(word) => desk().out.put(word.bytes()) as i32,
        None => -1,
    }
}

/// What a line means: how long that is.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_meaning(len: u32) -> u32 {
    let desk = desk();
    let words = meaning(desk.input(len));
    desk.out.put(words.bytes())
}

/// Of a setting: 0 its default, 1 its smallest, 2 its largest number; NaN if there is none.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_setting(place: u32, which: u32) -> f64 {
    let Some(setting) = Setting::ALL.get(place as usize) else { return f64::NAN };
    let range = setting.range();
    match which {
        0 => setting.default().into(),
        1 => (*range.start()).into(),
        2 => (*range.end()).into(),
        _ => f64::NAN,
    }
}

#[cfg(all(target_family = "wasm", not(test)))]
mod panic {
    unsafe extern "C" {
        /// Stands nowhere: code that could panic would have to import it.
        fn stepwright_panicked() -> !;
    }

    #[panic_handler]
    fn panicked(_: &core::panic::PanicInfo<'_>) -> ! {
        // SAFETY: it takes nothing and does not return.
        unsafe { stepwright_panicked() }
    }
}
