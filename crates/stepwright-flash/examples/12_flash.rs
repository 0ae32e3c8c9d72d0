//! Prints which firmware an Uno gets, and writes it to the port that is named.

use stepwright_flash::{Firmware, FlashBoard, FlashProgram};
use stepwright_host::link::serial::{LeaseWait, SerialLink, Share};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let firmware = Firmware::of(FlashBoard::Uno, false, FlashProgram::Slave)?;
    println!("{} bytes, SHA-256 {}", firmware.bytes().len(), firmware.hash());
    let Some(port) = std::env::args().nth(1) else { return Ok(()) };
    let free = |_: &_| LeaseWait::Over;
    let link = SerialLink::open(port.as_ref(), firmware.baud(), Share::Alone, free)?;
    Ok(firmware.write(link, |stage, done| println!("{stage} {done} bytes"))?)
}
