//! A chip of 32 bits in QEMU.

use semihosting::io::{self, Write};
use semihosting::process;
use stepwright_ticks::LAWS;

#[cfg(target_arch = "arm")]
use cortex_m_rt::entry;
#[cfg(target_arch = "riscv32")]
use riscv_rt::entry;

/// Room for a line, and some more.
const LINE: usize = 64;

#[entry]
fn main() -> ! {
    let Ok(mut out) = io::stdout() else { process::exit(1) };
    for number in 0..=u32::MAX {
        for law in LAWS {
            let (mut line, mut length) = ([0; LINE], 0);
            law.tell(number, |byte| {
                line[length] = byte;
                length += 1;
            });
            if out.write_all(&line[..length]).is_err() {
                process::exit(1);
            }
        }
    }
    process::exit(0)
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    process::exit(101)
}
