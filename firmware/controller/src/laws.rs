//! Austin's laws over the serial line, on a chip of 32 bits: its first axis moves by any of them.

use stepwright::drive::Drive;
use stepwright::timer::StepTimer;
use stepwright::{Board, HoldOff, SharedEngine};
use stepwright_austin::Station;
use stepwright_austin::line::LONGEST;
use stepwright_austin::station::{About, Costs};
use stepwright_device::ProgramDevice;
use stepwright_device::main_loop::{self, SerialPort};
use stepwright_protocol::Text;

use crate::kept::KeptMark;
use crate::{AXES, Panel, RUNS};

/// The static that a chip's step interrupt and [`run_laws`] share.
pub type LawEngine<T, D, H> = SharedEngine<T, D, H, AXES, RUNS>;

/// Fills the engine, switches the drivers on, and serves the rows of `stepwright_austin::line` for
/// ever. `name` is the board's name in the answer to `?`. The shortest delay of a law is that of an
/// AVR.
pub fn run_laws<T: StepTimer, D: Drive, H: HoldOff>(
    engine: &'static LawEngine<T, D, H>,
    timer: T,
    drive: D,
    board: &Board<AXES>,
    mut panel: impl Panel,
    name: Text,
    line: &mut impl SerialPort,
) -> ! {
    if let Some((engine, [feed, ..])) = engine.fill(timer, drive, board) {
        let mhz = board.rate.hz() / 1_000_000;
        let station = Station::new(engine, feed, About { name, mhz, costs: Costs::AVR });
        let mut motor: ProgramDevice<_, _, LONGEST> =
            ProgramDevice::new(station, KeptMark(panel.reset()));
        panel.set_enable(false); // on while it is low
        loop {
            panel.feed();
            main_loop::round(&mut motor, line);
        }
    }
    // The engine was filled elsewhere, which no program does.
    loop {
        core::hint::spin_loop();
    }
}
