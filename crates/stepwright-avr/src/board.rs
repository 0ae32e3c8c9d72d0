//! The board: its pins and the cost of its steps.
//!
//! The wiring is that of the CNC shield for the Uno. Each switch connects its pin to ground.
//!
//! | | STEP | DIR | switch |
//! | --- | --- | --- | --- |
//! | X, axis 1 | D2 | D5 | D9 |
//! | Y, axis 2 | D3 | D6 | D10 |
//! | Z, axis 3 | D4 | D7 | D11 |
//!
//! D8 enables all drivers while it is low. On the Mega A0 is the emergency stop, A1 the fault of a
//! driver.

use core::arch::asm;
use core::sync::atomic::{AtomicU8, Ordering};

use stepwright::drive::Axes;
use stepwright::profile::Fit;
use stepwright::{Board, Cost, Rate, StepTicks, Timing};

/// Writes all pins of a port's register.
macro_rules! write {
    ($register:expr, $bits:expr) => {
        // SAFETY: a level or direction of pins affects no memory.
        $register.write(|w| unsafe { w.bits($bits) })
    };
}

/// Sets the pins in a mask high or low, and does not change the others.
macro_rules! set {
    ($register:expr, $mask:expr, $high:expr) => {{
        let before = $register.read().bits();
        write!($register, if $high { before | $mask } else { before & !$mask })
    }};
}

#[cfg(feature = "mega")]
#[path = "board/mega.rs"]
mod pins;
#[cfg(feature = "uno")]
#[path = "board/uno.rs"]
mod pins;

pub(crate) use pins::switches;
pub use pins::{Levels, Pins, pins, wiring};

/// The axes that turn the other way round. The foreground writes it while they rest; the step
/// interrupt reads it when it sets DIR.
static REVERSE: AtomicU8 = AtomicU8::new(0);

/// The level of DIR for this direction of an axis.
fn level(axis: u8, forward: bool) -> bool {
    forward != (REVERSE.load(Ordering::Relaxed) & (1 << (axis & 7)) != 0)
}

/// Whether DIR of an axis is at its forward level.
pub(crate) fn is_forward(axis: u8) -> bool {
    pins::direction(axis) == level(axis, true)
}

/// Sets the axes that turn the other way round. They must rest.
pub fn set_reverse(axes: Axes) {
    let changed = REVERSE.load(Ordering::Relaxed) ^ axes;
    REVERSE.store(axes, Ordering::Relaxed);
    if changed != 0 {
        // SAFETY: counts in a register of its own: 4 cycles a round, 1 ms.
        unsafe {
            asm!("0: sbiw {count}, 1", "brne 0b", count = inout(reg_iw) (CLOCK / 4000) as u16 => _);
        }
    }
    pins::turn_round(changed);
}

/// The number of axes.
pub const AXES: usize = 3;

/// The first axis.
pub const X: u8 = 0;
/// The second axis.
pub const Y: u8 = 1;
/// The third axis.
pub const Z: u8 = 2;

/// Clock cycles per second.
pub const CLOCK: u32 = 16_000_000;

/// The rate of the step timer, which counts every cycle.
const RATE: Rate = match Rate::from_hz(CLOCK) {
    Ok(rate) => rate,
    Err(_) => panic!("CLOCK is no rate of a timer"),
};

/// The costs of the chip, and the usual times of a driver.
pub const fn description() -> Board<AXES> {
    let cost = Cost { ticks: COST, pulse: SHORT_PULSE, longer: LONGER, shortest: SHORTEST };
    with(cost, MIN_INTERVAL)
}

/// The same for motor cycles.
pub const fn cycle() -> Board<AXES> {
    any_cycle(CYCLE_COST, CYCLE_COST as u32)
}

/// The same for any number of motors, where a step takes `cost` cycles and two steps of a motor are
/// at least `min_interval` apart.
pub const fn any_cycle<const N: usize>(cost: StepTicks, min_interval: u32) -> Board<N> {
    with(Cost::any_pulse([cost; N]), min_interval)
}

const fn with<const N: usize>(cost: Cost<N>, min_interval: u32) -> Board<N> {
    let rate = RATE;
    Board {
        rate,
        timing: Timing {
            pulse: rate.nanos(2_000),
            setup: rate.nanos(1_000),
            hold: rate.nanos(1_000),
            min_interval,
        },
        cost,
        runs: RUNS_A_SECOND,
        fit: Fit::board(rate),
        horizon: rate.micros(16_000),
        lead: rate.micros(250),
    }
}

/// The cycles allowed for a step while 1, 2, 3 axes move: a tenth more than at the rates without a
/// late step under back-to-back traffic (`rate_ramps` in `bench/avr.json`, in the least favourable
/// build). Three axes get more, because a fast axis beside two slow ones is on time less often than
/// three axes of one speed.
#[cfg(not(feature = "bench"))]
const COST: [StepTicks; AXES] = [125, 184, 251];
/// The longest pulse for which that holds. For a longer pulse the step interrupt waits.
const SHORT_PULSE: StepTicks = 45;
/// The same with longer pulses: the costs at which pulses of 3 to 20 µs are kept in
/// `firmware/rig/tests/pulse.rs`, and a tenth more.
#[cfg(not(feature = "bench"))]
const LONGER: [StepTicks; AXES] = [1_250, 1_700, 4_400];
/// Twice the largest lateness of an edge while 1, 2, 3 axes move (`edge_error_worst` in
/// `bench/avr.json`), less the microsecond by which a step may be later than half an interval.
#[cfg(not(feature = "bench"))]
const SHORTEST: [StepTicks; AXES] = [COST[0], 280, 560];
#[cfg(feature = "bench")]
const SHORTEST: [StepTicks; AXES] = [MIN_INTERVAL as StepTicks; AXES];
/// A tenth less than on the steepest ramps without a late step (`steepest` in `bench/avr.json`).
#[cfg(not(feature = "bench"))]
const RUNS_A_SECOND: u16 = 2_900;
#[cfg(feature = "bench")]
const RUNS_A_SECOND: u16 = u16::MAX;
/// The longest stay in the step interrupt that makes one step, including a check of another motor's
/// wait (`firmware/rig/tests/cycle.rs`). Several steps that are due together take less each.
#[cfg(not(feature = "bench"))]
const CYCLE_COST: StepTicks = 1_600;
/// The bench measures what a step takes: nothing is refused.
#[cfg(feature = "bench")]
const COST: [StepTicks; AXES] = [MIN_INTERVAL as StepTicks; AXES];
#[cfg(feature = "bench")]
const LONGER: [StepTicks; AXES] = [MIN_INTERVAL as StepTicks; AXES];
#[cfg(feature = "bench")]
const CYCLE_COST: StepTicks = MIN_INTERVAL as StepTicks;

/// The least cycles between two steps of an axis.
#[cfg(not(feature = "bench"))]
const MIN_INTERVAL: u32 = COST[0] as u32;
/// A pulse and a pause of the same length.
#[cfg(feature = "bench")]
const MIN_INTERVAL: u32 = 64;
