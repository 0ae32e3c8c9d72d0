//! For the proof that nothing here can panic: a door to all of the reader for the linker.
//!
//! As WebAssembly the panic handler is a function that would have to be imported. A module without
//! imports holds no code that panics; `cargo xtask test --only cross` builds it and looks.

use crate::{Effect, MoveKind, Options, Reader};

static mut READER: Option<Reader> = None;

/// Takes a byte of a job. Of the end of a line its number, or less than 0 for an error; 0 of all
/// else.
#[unsafe(no_mangle)]
pub extern "C" fn push(byte: u8) -> i64 {
    // SAFETY: a module has one thread, and nothing else borrows it.
    let reader = unsafe { &mut *core::ptr::addr_of_mut!(READER) };
    let reader = reader.get_or_insert_with(|| Reader::new(Options::default()));
    match reader.push(byte).or_else(|| if byte == 0 { reader.finish() } else { None }) {
        None => 0,
        Some(Err(error)) => -i64::from(error.fault.number()),
        Some(Ok(block)) => block.effects().fold(i64::from(block.line), |sum, effect| {
            sum ^ match effect {
                Effect::Move(part) => match part.kind {
                    MoveKind::Arc(arc, _) => arc.centre[0].picometres(),
                    _ => part.to.0[0].picometres(),
                },
                Effect::Dwell(seconds) => seconds.scaled(),
                _ => 1,
            }
        }),
    }
}

unsafe extern "C" {
    /// Stands nowhere: code that could panic would have to import it.
    fn stepwright_panicked() -> !;
}

#[panic_handler]
fn panicked(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: it takes nothing and does not return.
    unsafe { stepwright_panicked() }
}
