#![no_std]
//! The serial controller on a chip of 32 bits, except the chip's own parts.
//!
//! ```text
//!   bytes ─► SerialPort ─► Device ─► motors ─► SharedEngine ─► Drive ─► pins
//!                            │                    ▲
//!               PortIo ◄─────┘                    └── StepTimer, its interrupt
//!               a Panel, the time, kept RAM
//! ```
//!
//! A chip's folder (`firmware/nrf51`) has a timer, a drive, a serial line and a [`Panel`]; its
//! program passes them to [`run`]. The lines, the settings and the supervision are those of the
//! AVR's controller, from the same code: `stepwright-device`.

mod compare;
#[cfg(feature = "cycles")]
mod cycles;
mod engine;
mod io;
mod kept;
#[cfg(feature = "laws")]
mod laws;
mod never_panics;
mod port_pins;
mod register;
mod ring;
#[cfg(feature = "selftest")]
mod selftest;
#[cfg(feature = "stream")]
mod stream;
mod trial;
mod turned;

pub use compare::{CompareRegister, CompareTimer};
#[cfg(feature = "cycles")]
pub use cycles::{ControllerCycle, CyclePins};
pub use engine::{ControllerEngine, run};
pub use io::{Panel, PortIo};
#[cfg(feature = "laws")]
pub use laws::{LawEngine, run_laws};
pub use port_pins::{PinPort, PortPins};
pub use register::Register;
pub use ring::Ring;
#[cfg(feature = "selftest")]
pub use selftest::{StampPort, StampedPins, Stamps, flash_sum, run_stamped, tell};
#[cfg(feature = "stream")]
pub use stream::{STREAM_FIFO, StreamBoard, play_stream, run_stream};
pub use trial::TimerTrial;
pub use turned::Turned;

use stepwright::profile::Fit;
use stepwright::{Board, Control, Cost, OrderedMotors, Rate, Timing};
use stepwright_device::Device;
use stepwright_device::main_loop::{self, OnBoard, SerialPort};

/// The motors of the controller.
pub const AXES: usize = 3;
/// The entries that a queue holds, as on an Uno.
pub const RUNS: usize = 8;

/// The board of a controller: the rate of its step timer, the cost of a step, and the number of
/// runs that it plans in a second. The rest is as on the Uno: pulses of 2 µs, 16 ms planned ahead.
pub const fn board(rate: Rate, cost: Cost<AXES>, runs: u16) -> Board<AXES> {
    let (pulse, side) = (rate.nanos(2_000), rate.nanos(1_000));
    Board {
        rate,
        timing: Timing { pulse, setup: side, hold: side, min_interval: cost.ticks[0] },
        cost,
        runs,
        fit: Fit::board(rate),
        horizon: rate.micros(16_000),
        lead: rate.micros(250),
    }
}

/// Runs the controller with motors of any engine, whose step timer counts at `rate`.
#[inline(always)]
pub fn run_motors<E: Control>(
    motors: OrderedMotors<'_, E, AXES, RUNS>,
    rate: Rate,
    panel: impl Panel,
    line: &mut impl SerialPort,
) -> ! {
    let mut io = PortIo::new(panel, rate);
    let mut device = Device::new(motors, AXES as u8, &mut io);
    main_loop::run(&mut OnBoard { device: &mut device, io }, line)
}
