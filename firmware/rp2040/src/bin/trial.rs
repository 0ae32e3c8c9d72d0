//! Four axes, controlled by a test that writes into the last 8 KB of the RAM: `test/pico.cjs`.
#![no_std]
#![no_main]

use stepwright::{Accel, Axis, AxisLimits, AxisSet, Board, Control, MoveError, Speed, Steppers};
use stepwright_controller::Register;
use stepwright_rp2040::board::{BOUND, MACHINES, board};
use stepwright_rp2040::chip;
use stepwright_rp2040::pio::{self, PioInterrupt, PioPlayer};
use stepwright_sink::SharedSink;

const BOARD: Board<MACHINES> = board();

static SINK: SharedSink<PioPlayer, PioInterrupt, MACHINES> = SharedSink::empty();

// In RAM, like all functions that it calls.
#[unsafe(link_section = ".data.stepwright")]
#[unsafe(no_mangle)]
extern "C" fn PIO0_IRQ_0() {
    // SAFETY: this is the player's interrupt.
    unsafe { SINK.serve(pio::begun()) };
}

/// A word of the test's memory: the order, its four arguments, and the answer.
const fn word(n: usize) -> Register {
    // SAFETY: RAM that belongs to no section.
    unsafe { Register::at(0x2004_0000 + 4 * n) }
}

const ORDERS: usize = 0;
const ANSWER: usize = 8;

/// The axis with this number.
fn axis(number: u32) -> Axis<MACHINES> {
    Axis::new(number as usize).unwrap_or(Axis::X)
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: first, and once.
    let player = unsafe {
        chip::start();
        PioPlayer::new()
    };
    if let Some((engine, feeds)) = SINK.fill(player, &BOARD, BOUND) {
        serve(Steppers::new(engine, feeds, BOARD));
    }
    loop {
        core::hint::spin_loop();
    }
}

/// Polls the motors, and carries out the test's orders.
fn serve<E: Control>(mut motors: Steppers<'_, E, MACHINES, 8>) -> ! {
    loop {
        motors.poll();
        let order = word(ORDERS).read();
        if order == 0 {
            continue;
        }
        let [a, b, c, d] = [1, 2, 3, 4].map(|n| word(n).read());
        let answer = match order {
            // A line of the axes whose travel is not 0.
            1 => {
                let ends = [a, b, c, d].map(|steps| i64::from(steps as i32));
                let all = (0u32..).zip(ends).filter(|(_, steps)| *steps != 0);
                said(motors.move_line_to(all.map(|(n, steps)| (axis(n), steps))))
            }
            2 => said(motors.run(axis(a), b as i32)),
            3 => {
                // Sets the position to the steps counted, at which the axis stands.
                motors.kill(axis(a));
                let at = motors.engine().position(a as u8);
                said(motors.set_position(axis(a), at)).wrapping_add(at as u32)
            }
            4 => {
                motors.stop(axis(a));
                0
            }
            5 => motors.engine().position(a as u8) as u32,
            6 => match (Speed::from_steps(b), Accel::from_steps(c)) {
                (Ok(speed), Ok(accel)) => {
                    motors.set_limits(axis(a), AxisLimits::new(speed, accel));
                    0
                }
                _ => 9,
            },
            7 => motors.any_moving().into(),
            8 => motors.late(),
            // Keeps the main loop busy for this many microseconds.
            9 => {
                let begun = chip::micros_low();
                while chip::micros_low().wrapping_sub(begun) < a {}
                0
            }
            10 => {
                motors.clear_late();
                0
            }
            11 => said(motors.retarget(axis(a), (b as i32).into())),
            12 => {
                motors.stop(AxisSet::ALL);
                0
            }
            13 => said(motors.set_position(axis(a), (b as i32).into())),
            14 => {
                motors.set_drivers(a, b, c);
                0
            }
            _ => 99,
        };
        word(ANSWER).write(answer);
        word(ORDERS).write(0);
    }
}

/// 0, or 1000000 for a refused order.
fn said(result: Result<(), MoveError>) -> u32 {
    if result.is_ok() { 0 } else { 1_000_000 }
}
