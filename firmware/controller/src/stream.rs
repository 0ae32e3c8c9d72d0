//! Streamed runs on a chip of 32 bits: frames and the common text lines over one serial line, three
//! axes, no planner. See `docs/stream.md`.
//!
//! A program of its own, not a part of the controller: its queues take entries from the frames alone, and
//! nobody has to say who has them.

use stepwright::drive::Drive;
use stepwright::engine::WIRING;
use stepwright::queue::Producer;
use stepwright::timer::StepTimer;
use stepwright::{Board, Control, HoldOff, Rate, SharedEngine, Ticks};
use stepwright_device::main_loop::{self, SerialPort};
use stepwright_device::{StreamDevice, StreamIo};
use stepwright_protocol::Text;
use stepwright_stream::player::StreamPlayer;

use crate::{AXES, Panel, RUNS};

/// Bytes of frames that wait, as on a Mega: more than a second of three busy axes.
pub const STREAM_FIFO: usize = 4_096;

/// Who plays a stream.
#[derive(Clone, Copy)]
pub struct StreamBoard {
    /// What it calls itself.
    pub name: Text,
    /// Its step timer. From 8 MHz to 25 MHz: a record waits for less than 2¹⁶ ticks.
    pub rate: Rate,
    /// No wait is shorter, in ticks.
    pub least: Ticks,
}

/// A [`Panel`] as a stream asks for it.
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
        // Pulled up: what is closed is low.
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

/// The player of streams on an engine of steps: fills that, and hears frames and lines for good.
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
    // What the engine paces late steps by.
    board.timing.min_interval = stream.least;
    if let Some(filled) = shared.fill(timer, drive, &board) {
        play_stream(filled, stream, panel, line, |_| ());
    }
    // Somebody else has filled it, which no program does.
    loop {
        core::hint::spin_loop();
    }
}

/// Likewise, of any engine, by the feeds of its queues; `round` looks after it as often as can be.
#[inline(always)]
pub fn play_stream<E: Control>(
    (engine, feeds): (E, [Producer<'static, RUNS>; AXES]),
    stream: StreamBoard,
    mut panel: impl Panel,
    line: &mut impl SerialPort,
    mut round: impl FnMut(&mut E),
) -> ! {
    let StreamBoard { name, rate, least } = stream;
    let begun = panel.count();
    let io = PanelIo { panel, milli: rate.micros(1_000), begun };
    let player = StreamPlayer::<_, RUNS, STREAM_FIFO>::new(engine, feeds, [WIRING; AXES], least);
    let mut device = StreamDevice::new(player, io, name, rate.hz());
    loop {
        main_loop::round(&mut device, line);
        round(device.player().engine());
    }
}
