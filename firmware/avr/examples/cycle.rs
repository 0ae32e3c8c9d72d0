//! stepper_h's basic example: three motors with different speeds at the same time, in the
//! background, and their positions each second.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use stepwright_avr::board::{X, Y, Z};
use stepwright_avr::console::Console;
use stepwright_avr::cycle::{self, AvrEngine};
use stepwright_cycle::{Motor, Program, Refusal, Switches};

stepwright_avr::cycle_interrupt!();

#[avr_device::entry]
fn main() -> ! {
    // 7.5 µm a step, at most one step each millisecond, between two bounds.
    let axis = Motor::new(7_500, 1_000);
    // SAFETY: called once, with interrupts off.
    let (mut motors, mut console) = unsafe {
        cycle::start(
            [
                axis.between(0, 300_000_000),
                axis.between(0, 216_000_000).inverted(),
                axis.between(0, 100_000_000).inverted(),
            ],
            Switches::NONE,
        )
    };
    console.line("Starting stepper_h test...");
    print(&mut console, &mut motors);
    if go(&mut motors).is_err() {
        console.line("refused");
    }

    // Once a second while the motors move, once when they have arrived, and then every ten seconds.
    let mut printed = console.millis().wrapping_add(1);
    console.wait_until(printed);
    let mut moving = true;
    loop {
        let (now, running) = (console.millis(), motors.is_running());
        let pause = match (running, moving) {
            (true, _) => 1_000,
            (false, true) => 0,
            (false, false) => 10_000,
        };
        if now.wrapping_sub(printed) >= pause {
            (printed, moving) = (now, running);
            print(&mut console, &mut motors);
        }
        // Any code may come here: the motors move meanwhile.
    }
}

/// 150 mm, 75 mm and 7.5 mm, each in 20 s.
fn go(motors: &mut AvrEngine) -> Result<(), Refusal> {
    motors.prepare(X, Program::Steps { count: 20_000, delay: 1_000 })?;
    motors.prepare(Y, Program::Steps { count: 10_000, delay: 2_000 })?;
    motors.prepare(Z, Program::Steps { count: 1_000, delay: 20_000 })?;
    motors.start()
}

fn print(console: &mut Console, motors: &mut AvrEngine) {
    // All positions are read first: sending a number takes longer than a step.
    let at = [X, Y, Z].map(|motor| motors.position(motor));
    for (name, at) in ["X.pos=", ", Y.pos=", ", Z.pos="].iter().zip(at) {
        console.text(name);
        console.position(at);
    }
    console.line("");
}
