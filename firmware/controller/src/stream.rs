//! The player of a host's stream on a chip of 32 bits: frames and the common text lines over one
//! serial line, three axes, no planner. See `docs/stream.md`.
//!
//! It is a program of its own, not a part of the controller: its queues take entries from the
//! frames only, so their ownership need not be managed.

use stepwright::drive::Drive;
use stepwright::engine::WIRING;
use stepwright::queue::Producer;
use stepwright::timer::StepTimer;
use stepwright::{Board, Control, HoldOff, Rate, SharedEngine, Ticks};
use stepwright_device::main_loop::{self, SerialPort};
use stepwright_device::{StreamDevice, StreamIo};
use stepwright_protocol::Text;
use stepwright_stream::player::StreamPlayer;

use crate::kept::KeptMark;
use crate::{AXES, Panel, RUNS};

/// The bytes of frames that can wait, as on a Mega: more than a second of three busy axes.
pub const STREAM_FIFO: usize = 4_096;

/// The description of a board that plays a stream.
#[derive(Clone, Copy)]
pub struct StreamBoard {
    /// The board's name.
    pub name: Text,
    /// The rate of the step timer. From 8 MHz to 25 MHz: a record waits for less than 2¹⁶ ticks.
    pub rate: Rate,
    /// The shortest wait, in ticks.
    pub least: Ticks,
}

/// A [`Panel`], for a stream.
struct PanelIo<P> {
    panel: P,
    milli: u32,
    /// The count at the beginning of the present millisecond.
    begun: u32,
}

impl<P: Panel> StreamIo for PanelIo<P> {
    #[inline(always)]
    fn now(&mut self) -> u16 {
        self.panel.count() as u16
    }

    #[inline(always)]
    fn ticked(&mut self) -> bool {
        self.panel.feed();
        let ticked = self.panel.count().wrapping_sub(self.begun) >= self.milli;
        if ticked {
            self.begun = self.begun.wrapping_add(self.milli);
        }
        ticked
    }

    fn inputs(&mut self) -> u8 {
        // With pull-ups, a closed input is low.
        let mut inputs = !self.panel.switches() & ((1 << AXES) - 1);
        if !self.panel.driver_fault() {
            inputs |= 1 << 6;
        }
        if !self.panel.emergency() {
            inputs |= 1 << 7;
        }
        inputs
    }

    fn enable(&mut self) {
        self.panel.set_enable(false); // on while it is low
    }

    const LASER: bool = P::LASER;

    fn set_power(&mut self, power: u8) {
        self.panel.set_power(power);
    }
}

/// Plays streams on the step engine: fills it, and handles frames and lines for ever.
#[inline(always)]
pub fn run_stream<T: StepTimer, D: Drive, H: HoldOff>(
    shared: &'static SharedEngine<T, D, H, AXES, RUNS>,
    timer: T,
    drive: D,
    board: &Board<AXES>,
    stream: StreamBoard,
    panel: impl Panel,
    line: &mut impl SerialPort,
) -> ! {
    let mut board = *board;
    // The engine spaces late steps by the minimum interval.
    board.timing.min_interval = stream.least;
    if let Some(filled) = shared.fill(timer, drive, &board) {
        play_stream(filled, stream, panel, line, |_| ());
    }
    // The engine was filled elsewhere, which no program does.
    loop {
        core::hint::spin_loop();
    }
}

/// The same with any engine, through the feeds of its queues; `round` is called with the engine as
/// often as possible.
#[inline(always)]
pub fn play_stream<E: Control>(
    (engine, feeds): (E, [Producer<'static, RUNS>; AXES]),
    stream: StreamBoard,
    mut panel: impl Panel,
    line: &mut impl SerialPort,
    mut round: impl FnMut(&mut E),
) -> ! {
    let StreamBoard { name, rate, least } = stream;
    let (begun, marks) = (panel.count(), KeptMark(panel.reset()));
    let io = PanelIo { panel, milli: rate.micros(1_000), begun };
    let player = StreamPlayer::<_, RUNS, STREAM_FIFO>::new(engine, feeds, [WIRING; AXES], least);
    let mut device = StreamDevice::new(player, io, marks, name, rate.hz());
    device.begin();
    loop {
        main_loop::round(&mut device, line);
        round(device.player().engine());
    }
}
