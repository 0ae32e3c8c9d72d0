//! Austin's laws over the serial line, on a chip of 32 bits: its first axis goes by any of them.

use stepwright::drive::Drive;
use stepwright::timer::StepTimer;
use stepwright::{Board, HoldOff, SharedEngine};
use stepwright_austin::Station;
use stepwright_austin::line::LONGEST;
use stepwright_austin::station::{About, Costs};
use stepwright_device::ProgramDevice;
use stepwright_device::main_loop::{self, SerialPort};
use stepwright_protocol::Text;

use crate::{AXES, Panel, RUNS};

/// What a chip's program has in a static, for its step interrupt and for [`run_laws`].
pub type LawEngine<T, D, H> = SharedEngine<T, D, H, AXES, RUNS>;

/// Fills the engine, switches the drivers on, and serves the rows of `stepwright_austin::line` for good.
/// `name` is the board's, in the answer to `?`. The shortest delay of a law is an AVR's.
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
        let mut motor: ProgramDevice<_, LONGEST> = ProgramDevice::new(station);
        panel.set_enable(false); // on while it is low
        loop {
            panel.feed();
            main_loop::round(&mut motor, line);
        }
    }
    // Somebody else has filled it, which no program does.
    loop {
        core::hint::spin_loop();
    }
}
