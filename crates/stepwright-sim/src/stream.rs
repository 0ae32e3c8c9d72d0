//! A board that plays a host's stream on simulated pins: the program `stream` of a chip.

use stepwright::engine::WIRING;
use stepwright::entry::Wiring;
use stepwright::timer::Count;
use stepwright::{Control, Engine, Ticks};
use stepwright_device::main_loop::Foreground;
use stepwright_device::{StreamDevice, StreamIo};
use stepwright_protocol::flash_text;
use stepwright_stream::player::StreamPlayer;

use crate::board::{Queues, RUNS, Shared};
use crate::clock::{LentNow, Present, SimTimer};
use crate::description::Description;
use crate::edge::Recorder;
use crate::pins::Pins;
use crate::steppers::SimEngine;

/// Bytes of the FIFO, as on the Uno.
pub const FIFO: usize = 896;
/// The shortest wait, in ticks, as on the Uno.
const LEAST: Ticks = 72;
/// Rounds of the main loop per visit.
const ROUNDS: usize = 8;

/// The surroundings of the virtual board's stream.
struct SimIo<'q> {
    now: LentNow<'q>,
    /// Ticks per millisecond, and the last millisecond that was reported.
    millis: u64,
    told: u64,
    inputs: u8,
    /// The power of the laser, if it has just changed.
    changed: Option<u8>,
}

impl StreamIo for SimIo<'_> {
    fn now(&mut self) -> u16 {
        self.now.get() as u16
    }

    fn ticked(&mut self) -> bool {
        let ticked = self.now.get() / self.millis > self.told;
        self.told += u64::from(ticked);
        ticked
    }

    fn inputs(&mut self) -> u8 {
        self.inputs
    }

    fn enable(&mut self) {}

    const LASER: bool = true;

    fn set_power(&mut self, power: u8) {
        self.changed = Some(power);
    }
}

/// A board that takes frames and the common text lines, and moves three axes.
///
/// ```
/// use stepwright_sim::{Description, Edge, Queues, StreamBoard};
/// let mut queues = Queues::default();
/// let mut board: StreamBoard<Vec<Edge>> =
///     StreamBoard::new(&mut queues, Description::uno(), Vec::new());
/// board.receive(b"V2\r");
/// board.run_until(16_000);
/// assert_eq!(board.take_answers(), b"0\r");
/// ```
pub struct StreamBoard<'q, R: Recorder, C: Count = u16> {
    device: StreamDevice<'q, SimEngine<'q, R, C>, SimIo<'q>, (), RUNS, FIFO>,
    now: LentNow<'q>,
    answers: Vec<u8>,
    /// Ticks between two visits of the main loop.
    visit: u64,
    next_visit: u64,
}

impl<'q, R: Recorder, C: Count> StreamBoard<'q, R, C> {
    /// Switches a new board on.
    pub fn new(queues: &'q mut Queues, description: Description, recorder: R) -> Self {
        let board = description.board;
        let Shared { ends: [x, y, z], now, reverse } = queues.lend(&description);
        let mut pins = Pins::new(now, reverse, &description.coils, recorder);
        pins.face();
        let timer = SimTimer::on_grid(now, description.grid);
        let mut timing = board.timing;
        timing.min_interval = timing.min_interval.min(LEAST);
        let engine = Engine::new(timer, pins, [x.1, y.1, z.1], timing, board.rate);
        let wirings = [Wiring::new(WIRING.step, WIRING.turn); 3];
        let engine = SimEngine::new(now, engine);
        let player = StreamPlayer::new(engine, [x.0, y.0, z.0], wirings, LEAST);
        let millis = u64::from(board.rate.hz() / 1_000);
        let io = SimIo { now, millis, told: 0, inputs: 0, changed: None };
        let device = StreamDevice::new(player, io, (), flash_text!("virtual"), board.rate.hz());
        let visit = u64::from(board.rate.micros(50));
        StreamBoard { device, now, answers: Vec::new(), visit, next_visit: 0 }
    }

    /// The present, in ticks since the board was switched on.
    pub fn now(&self) -> u64 {
        self.now.get()
    }

    /// Receives bytes on the serial line, now.
    pub fn receive(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.device.receive(*byte);
            self.work();
        }
    }

    /// The bytes that the board has sent since the last call.
    pub fn take_answers(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.answers)
    }

    /// Lets time pass until `time`, with all events up to and at `time`.
    pub fn run_until(&mut self, time: u64) {
        while self.now() < time {
            let visit = self.next_visit <= time;
            let next = if visit { self.next_visit } else { time };
            let pass = next.saturating_sub(self.now());
            self.engine().pass(pass as Ticks);
            if visit {
                self.work();
            }
        }
    }

    /// The main loop.
    fn work(&mut self) {
        for _ in 0..ROUNDS {
            self.device.tick();
            self.device.work();
            while self.device.is_answering() {
                self.answers.extend(self.device.next_byte());
            }
            self.device.poll_io();
            if let Some(power) = self.device.io.changed.take() {
                let now = self.now();
                self.recorder().laser(now, power);
            }
        }
        self.next_visit = self.now() + self.visit;
    }

    /// Closes or opens an input: 0 to 2 are the axes' switches, 6 is the drivers' fault, 7 the emergency stop.
    pub fn set_input(&mut self, input: u8, closed: bool) {
        let bit = 1 << (input & 7);
        let inputs = &mut self.device.io.inputs;
        *inputs = if closed { *inputs | bit } else { *inputs & !bit };
    }

    /// Whether anything moves, or waits for its next entry.
    pub fn is_busy(&mut self) -> bool {
        self.device.player().is_busy()
    }

    /// The position of an axis; `None` if it is unknown.
    pub fn position(&mut self, axis: u8) -> Option<i64> {
        self.device.player().position(axis)
    }

    /// The number of late steps since the board was switched on.
    pub fn late(&mut self) -> u32 {
        self.engine().late()
    }

    fn engine(&mut self) -> &mut SimEngine<'q, R, C> {
        self.device.player().engine()
    }

    /// The recorder.
    pub fn recorder(&mut self) -> &mut R {
        self.engine().recorder()
    }
}
