//! For the proof that this crate cannot panic: a function through which the linker keeps all of the reader.
//!
//! In WebAssembly the panic handler calls a function that must be imported. A module without imports therefore
//! has no code that panics. `cargo xtask test --only cross` builds the module and checks that.

use crate::{Effect, MoveKind, Options, Reader};

static mut READER: Option<Reader> = None;

/// Takes a byte of a job. At the end of a line, returns a number that depends on the whole block, or less than
/// 0 for an error; otherwise 0.
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
    /// Defined nowhere: code that could panic would have to import it.
    fn stepwright_panicked() -> !;
}

#[panic_handler]
fn panicked(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: it takes nothing and does not return.
    unsafe { stepwright_panicked() }
}
