//! The functions that a page calls. There is one board, and a page has one thread.
//!
//! | function | what |
//! | --- | --- |
//! | `stepwright_on` | switches a new board on, at tick 0 |
//! | `stepwright_hz`, `_axes`, `_byte_time` | ticks per second, number of axes, ticks of a byte on the line |
//! | `stepwright_now`, `_busy` | ticks since power-up; whether an axis moves |
//! | `stepwright_run` | lets time pass until a tick |
//! | `stepwright_receive` | receives a byte; returns the number of answer bytes at `_out` |
//! | `stepwright_edge_times`, `_edge_pins`, `_edges`, `_edges_kept` | the last edges: see [`Tape`] |
//! | `stepwright_out` | the address of the answers |
//! | `stepwright_shaft` | the position of a shaft, counted at its pins |
//!
//! Addresses stay valid as long as the module lives: it never allocates.

use core::cell::UnsafeCell;

use stepwright_sim::Queues;

use crate::machine::VirtualMachine;
use crate::tape::{KEPT, Tape};

/// The longest answer of a board.
const OUT_LEN: usize = 1024;

/// The answers for the page.
struct OutText {
    bytes: [u8; OUT_LEN],
    len: usize,
}

impl OutText {
    /// Replaces the text, and returns its length.
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

// SAFETY: WebAssembly without shared memory has one thread; elsewhere no two threads call these functions.
unsafe impl<T> Sync for OneThread<T> {}

static OUT: OneThread<OutText> =
    OneThread(UnsafeCell::new(OutText { bytes: [0; OUT_LEN], len: 0 }));

static TAPE: OneThread<Tape> = OneThread(UnsafeCell::new(Tape::new()));
static QUEUES: OneThread<Option<Queues>> = OneThread(UnsafeCell::new(None));
static MACHINE: OneThread<Option<VirtualMachine<'static>>> = OneThread(UnsafeCell::new(None));

fn out() -> &'static mut OutText {
    // SAFETY: there is one thread, and no reference outlives a call.
    unsafe { &mut *OUT.0.get() }
}

fn machine() -> &'static mut Option<VirtualMachine<'static>> {
    // SAFETY: there is one thread, and no reference outlives a call.
    unsafe { &mut *MACHINE.0.get() }
}

/// The edges of the machine. The tape is borrowed as long as there is a machine.
fn tape() -> Option<&'static Tape> {
    machine().as_mut().map(VirtualMachine::tape)
}

/// Switches a new board on, at tick 0, in place of the one before.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_on() {
    *machine() = None;
    // SAFETY: the machine that borrowed them is gone, and nothing else borrows them.
    let (queues, tape) = unsafe { (&mut *QUEUES.0.get(), &mut *TAPE.0.get()) };
    tape.clear();
    *machine() = Some(VirtualMachine::new(queues.insert(Queues::default()), tape));
}

/// Ticks per second of the board's clock; 0 while it is off.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_hz() -> u32 {
    machine().as_ref().map_or(0, VirtualMachine::hz)
}

/// The number of axes.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_axes() -> u32 {
    machine().as_ref().map_or(0, VirtualMachine::axes).into()
}

/// Ticks that a byte takes on the line.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_byte_time() -> u32 {
    machine().as_ref().map_or(0, VirtualMachine::byte_time) as u32
}

/// Ticks since the board was switched on.
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

/// Receives a byte on the line, now. Returns the number of answer bytes.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_receive(byte: u32) -> u32 {
    let Some(machine) = machine() else { return 0 };
    let answers = machine.receive(byte as u8);
    out().put(answers.iter().copied())
}

/// The times of the last edges: see [`Tape::times`]. Null while the board is off.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_edge_times() -> *const f64 {
    tape().map_or(core::ptr::null(), |tape| tape.times().as_ptr())
}

/// The pins of the last edges: see [`Tape::pins`]. Null while the board is off.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_edge_pins() -> *const u8 {
    tape().map_or(core::ptr::null(), |tape| tape.pins().as_ptr())
}

/// The number of edges so far.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_edges() -> u32 {
    tape().map_or(0, Tape::count)
}

/// The number of edges that are kept.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_edges_kept() -> u32 {
    KEPT as u32
}

/// Steps of an axis, from 0, forward minus backward.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_shaft(axis: u32) -> f64 {
    tape().and_then(|tape| tape.shaft(axis as usize)).map_or(f64::NAN, |steps| steps as f64)
}

/// The address of the board's answers.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_out() -> *const u8 {
    out().bytes.as_ptr()
}

#[cfg(all(target_family = "wasm", not(test)))]
mod panic {
    unsafe extern "C" {
        /// Exists nowhere: code that could panic would have to import it.
        fn stepwright_panicked() -> !;
    }

    #[panic_handler]
    fn panicked(_: &core::panic::PanicInfo<'_>) -> ! {
        // SAFETY: it takes nothing and does not return.
        unsafe { stepwright_panicked() }
    }
}
