//! A chip's step timer under `stepwright-port-test`.

use stepwright_device::main_loop::SerialPort;
use stepwright_port_test::{Checked, TestPort, TimerFault, check};

/// Tries a timer whose interrupt comes within `latency` ticks, and says on the line what came of it,
/// again and again: `kept`, deadlines, interrupts for nothing, whether the counter wrapped (1); or
/// the fault by its name, and its numbers.
pub fn try_timer(port: &mut impl TestPort, latency: u32, line: &mut impl SerialPort) -> ! {
    let (what, numbers): (&[u8], _) = match check(port, latency) {
        Ok(Checked { values, spurious, wrapped }) => {
            (b"kept", [values as i32, spurious as i32, wrapped.into()])
        }
        Err(TimerFault::StandsStill) => (b"stands-still", [0; 3]),
        Err(TimerFault::Backward) => (b"backward", [0; 3]),
        Err(TimerFault::Lost { ahead, waited }) => (b"lost", [ahead, waited, 0]),
        Err(TimerFault::Early { ahead, by }) => (b"early", [ahead, by, 0]),
    };
    loop {
        what.iter().for_each(|byte| send(line, *byte));
        for number in numbers {
            send(line, b' ');
            say(line, number);
        }
        send(line, b'\r');
    }
}

/// Waits until there is room.
fn send(line: &mut impl SerialPort, byte: u8) {
    while !line.has_room() {}
    line.send(byte);
}

/// A number in decimal digits.
fn say(line: &mut impl SerialPort, number: i32) {
    if number < 0 {
        send(line, b'-');
    }
    let (number, mut place) = (number.unsigned_abs(), 1_000_000_000);
    while place != 0 {
        if number >= place || place == 1 {
            send(line, b'0' + (number / place % 10) as u8);
        }
        place /= 10;
    }
}
