//! Prints the lines of all laws, travel by travel, until the reader stops: on a host, on a chip of
//! 32 bits by semihosting, on an AVR by its serial line.
#![cfg_attr(any(target_os = "none", target_arch = "avr"), no_std, no_main)]

#[cfg(target_arch = "avr")]
#[path = "main/avr.rs"]
mod program;

#[cfg(all(target_os = "none", not(target_arch = "avr")))]
#[path = "main/simulated.rs"]
mod program;

#[cfg(not(any(target_os = "none", target_arch = "avr")))]
fn main() {
    use std::io::{BufWriter, Write, stdout};
    use stepwright_ticks::LAWS;

    let mut out = BufWriter::new(stdout().lock());
    for number in 0..=u32::MAX {
        for law in LAWS {
            let mut line = Vec::new();
            law.tell(number, |byte| line.push(byte));
            if out.write_all(&line).is_err() {
                return;
            }
        }
    }
}
