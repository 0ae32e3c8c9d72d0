//! The functions that a page calls. There is one board, and a page has one thread.
//!
//! | function | what |
//! | --- | --- |
//! | `stepwright_on` | switches a new board on, at tick 0 |
//! | `stepwright_hz`, `_axes`, `_byte_time` | ticks in a second, its axes, ticks of a byte on the line |
//! | `stepwright_now`, `_busy` | ticks since it was switched on; whether an axis moves |
//! | `stepwright_run` | lets time pass until a tick |
//! | `stepwright_receive` | a byte arrives; how many bytes of answers stand at `_out` |
//! | `stepwright_edge_times`, `_edge_pins`, `_edges`, `_edges_kept` | the last edges: see [`Tape`] |
//! | `stepwright_out` | where the answers stand |
//! | `stepwright_shaft` | where a shaft is, counted at its pins |
//!
//! Addresses hold as long as the module does: nothing is ever allocated.

use core::cell::UnsafeCell;

use stepwright_sim::Queues;

use crate::machine::VirtualMachine;
use crate::tape::{KEPT, Tape};

/// The longest answer of a board.
const OUT_LEN: usize = 1024;

/// Answers on their way to the page.
struct OutText {
    bytes: [u8; OUT_LEN],
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

struct OneThread<T>(UnsafeCell<T>);

// SAFETY: WebAssembly without shared memory has one thread; elsewhere nothing calls these
// functions from two.
unsafe impl<T> Sync for OneThread<T> {}

static OUT: OneThread<OutText> =
    OneThread(UnsafeCell::new(OutText { bytes: [0; OUT_LEN], len: 0 }));

static TAPE: OneThread<Tape> = OneThread(UnsafeCell::new(Tape::new()));
static QUEUES: OneThread<Option<Queues>> = OneThread(UnsafeCell::new(None));
static MACHINE: OneThread<Option<VirtualMachine<'static>>> = OneThread(UnsafeCell::new(None));

fn out() -> &'static mut OutText {
    // SAFETY: one thread, and no reference outlives a call.
    unsafe { &mut *OUT.0.get() }
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
    out().put(answers.iter().copied())
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

/// Where the answers of the board are read from.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_out() -> *const u8 {
    out().bytes.as_ptr()
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
