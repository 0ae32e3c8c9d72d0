//! A plugin for QEMU 7.2: it observes a firmware, by the instructions that it has executed.
//!
//! ```text
//! -plugin FILE,watch=LOW-HIGH[+LOW-HIGH]             stores to these addresses, to QEMU's log
//! …,gate=SOCKET                                      … and the board runs only as far as it is told there
//! -plugin FILE,entry=PC,out=FILE                     the cost of each visit of an interrupt
//! -plugin FILE,stack=LOW,out=FILE                    the lowest store from LOW on, in RAM
//! -plugin FILE,told=LOW-HIGH,out=FILE                each store there: its distance from LOW
//! -plugin FILE,trap=PC,out=FILE                      the longest time for which all interrupts are masked
//! ```
//!
//! With `-icount shift=N` an instruction takes 2^N ns, so their number is the time. A watched store
//! is a line `@COUNT ADDRESS` after those of QEMU's own trace of the device. A visit begins at
//! `entry` and ends with the return from there; each is a line `instructions cycles`, the cycles of
//! a Cortex-M0 (see `visits.rs`).
//!
//! At a gate the board waits from its first instruction on. A number of 64 bits, the lowest byte
//! first, lets it run to the block of code after that many instructions, where it writes `=COUNT`
//! and waits again. So its time does not run ahead of a test that feeds it.

mod api;
mod masked;
mod visits;

use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::fs::File;
use std::io::{Read, Write};
use std::ops::Range;
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock};

use api::*;
use masked::Masked;
use visits::Visits;

/// The version of the interface that this plugin uses.
#[unsafe(no_mangle)]
pub static qemu_plugin_version: c_int = 1;

/// The executed instructions. QEMU adds to it in the code that it generates.
static COUNT: AtomicU64 = AtomicU64::new(0);

/// The RAM of a Cortex-M.
const RAM: Range<u64> = 0x2000_0000..0x4000_0000;
/// The lowest store of the stack.
static LOWEST: AtomicU64 = AtomicU64::new(u64::MAX);

/// The task that the arguments request.
enum Task {
    Watch(Vec<Range<u64>>),
    Visits(Visits),
    Stack(Mutex<(u64, File)>),
    Told(Range<u64>, Mutex<File>),
    Masked(Masked),
}

static TASK: OnceLock<Task> = OnceLock::new();

/// The socket of the gate, and the instructions up to which the board may run.
static GATE: OnceLock<Mutex<UnixStream>> = OnceLock::new();
static UNTIL: AtomicU64 = AtomicU64::new(0);

/// Called at the beginning of a block of code: waits at the gate.
unsafe extern "C" fn entered(_: c_uint, _: *mut c_void) {
    let count = COUNT.load(Ordering::Relaxed);
    while count >= UNTIL.load(Ordering::Relaxed) {
        log(&format!("={count}"));
        let mut until = [0; 8];
        let told = GATE.get().and_then(|gate| gate.lock().ok()?.read_exact(&mut until).ok());
        // The other side is gone: this is the end of the test.
        let until = told.map_or(u64::MAX, |()| u64::from_le_bytes(until));
        UNTIL.store(until, Ordering::Relaxed);
    }
}

/// Writes a line to QEMU's log.
fn log(line: &str) {
    if let Ok(line) = CString::new(format!("{line}\n")) {
        // SAFETY: a text that ends with 0.
        unsafe { qemu_plugin_outs(line.as_ptr()) };
    }
}

/// Called at a store: checks whether it is watched, the lowest of the stack, or a report.
unsafe extern "C" fn stored(_: c_uint, _: u32, address: u64, _: *mut c_void) {
    let ranges = match TASK.get() {
        Some(Task::Watch(ranges)) => ranges,
        Some(Task::Stack(lowest)) => {
            if let Ok(mut lowest) = lowest.lock()
                && RAM.contains(&address)
                && (lowest.0..).contains(&address)
                && LOWEST.fetch_min(address, Ordering::Relaxed) > address
            {
                // If the disk is full, lines are missing.
                let _ = writeln!(lowest.1, "{address}");
            }
            return;
        }
        Some(Task::Told(range, out)) => {
            if range.contains(&address)
                && let Ok(mut out) = out.lock()
            {
                let _ = writeln!(out, "{}", address - range.start);
            }
            return;
        }
        _ => return,
    };
    if ranges.iter().any(|range| range.contains(&address)) {
        log(&format!("@{} {address:#x}", COUNT.load(Ordering::Relaxed)));
    }
}

/// Called when QEMU has translated a block: registers the callbacks for its instructions.
unsafe extern "C" fn translated(_: PluginId, block: *mut Block) {
    if GATE.get().is_some() {
        let none = std::ptr::null_mut();
        // SAFETY: QEMU's block, and a function of the required type.
        unsafe { qemu_plugin_register_vcpu_tb_exec_cb(block, entered, NO_REGISTERS, none) };
    }
    // SAFETY: QEMU's block, and an index below its number of instructions.
    let all =
        unsafe { (0..qemu_plugin_tb_n_insns(block)).map(|n| qemu_plugin_tb_get_insn(block, n)) };
    for instruction in all {
        match TASK.get() {
            Some(Task::Watch(_) | Task::Stack(_) | Task::Told(..)) => {
                let count = COUNT.as_ptr().cast();
                // SAFETY: QEMU's instruction, a static of 64 bits, and a function of the required
                // type.
                unsafe {
                    qemu_plugin_register_vcpu_insn_exec_inline(instruction, ADD_U64, count, 1);
                    qemu_plugin_register_vcpu_mem_cb(
                        instruction,
                        stored,
                        NO_REGISTERS,
                        WRITES,
                        std::ptr::null_mut(),
                    );
                }
            }
            // SAFETY: QEMU's instruction.
            Some(Task::Visits(visits)) => unsafe { visits.follow(instruction) },
            // SAFETY: as above.
            Some(Task::Masked(masked)) => unsafe { masked.follow(instruction) },
            None => {}
        }
    }
}

/// Parses a number of an argument, decimal or hexadecimal.
fn number(text: &str) -> Option<u64> {
    match text.strip_prefix("0x") {
        Some(digits) => u64::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}

/// The task that the arguments request.
fn task(arguments: &[String]) -> Option<Task> {
    let value = |key: &str| {
        arguments.iter().find_map(|argument| argument.strip_prefix(key)?.strip_prefix('='))
    };
    let range = |text: &str| {
        let (low, high) = text.split_once('-')?;
        Some(number(low)?..number(high)?)
    };
    if let Some(ranges) = value("watch") {
        return Some(Task::Watch(ranges.split('+').map(range).collect::<Option<_>>()?));
    }
    let address = |key| value(key).and_then(number);
    if let Some(low) = address("stack") {
        return Some(Task::Stack(Mutex::new((low, File::create(value("out")?).ok()?))));
    }
    if let Some(told) = value("told") {
        return Some(Task::Told(range(told)?, Mutex::new(File::create(value("out")?).ok()?)));
    }
    if let Some(trap) = address("trap") {
        return Some(Task::Masked(Masked::new(trap, value("out")?).ok()?));
    }
    let visits = Visits::new(address("entry")?, value("out")?);
    Some(Task::Visits(visits.ok()?))
}

/// QEMU's call at its start.
///
/// # Safety
/// Called by QEMU, with as many texts as it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn qemu_plugin_install(
    id: PluginId,
    _: *const c_void,
    count: c_int,
    arguments: *const *const c_char,
) -> c_int {
    let text = |n: usize| {
        // SAFETY: the caller's promise.
        let text = unsafe { CStr::from_ptr(*arguments.add(n)) };
        text.to_string_lossy().into_owned()
    };
    let arguments: Vec<String> = (0..count.max(0) as usize).map(text).collect();
    let Some(task) = task(&arguments) else {
        eprintln!(
            "stepwright's plugin knows watch and gate; entry and out; stack and out; told and out; \
             trap and out"
        );
        return -1;
    };
    if let Some(path) = arguments.iter().find_map(|argument| argument.strip_prefix("gate=")) {
        match UnixStream::connect(path) {
            Ok(gate) => _ = GATE.set(Mutex::new(gate)),
            Err(why) => {
                eprintln!("stepwright's plugin finds no gate at {path}: {why}");
                return -1;
            }
        }
    }
    if TASK.set(task).is_err() {
        return -1;
    }
    // SAFETY: QEMU's id, and a function of the required type.
    unsafe { qemu_plugin_register_vcpu_tb_trans_cb(id, translated) };
    0
}
