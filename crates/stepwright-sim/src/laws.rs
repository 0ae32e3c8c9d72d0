//! A motor that goes by one of Austin's laws, on simulated pins: the program `laws` of a chip.

use stepwright::Engine;
use stepwright::timer::Count;
use stepwright_austin::Station;
use stepwright_austin::station::{About, Costs};

use crate::board::{Queues, RUNS, Shared};
use crate::clock::{LentNow, Present, SimTimer};
use crate::description::Description;
use crate::edge::Recorder;
use crate::pins::Pins;
use crate::steppers::SimEngine;

/// A board that hears the lines of `stepwright_austin::line`, and moves its first axis.
///
/// ```
/// use stepwright_sim::{Description, Edge, LawBoard, Queues};
/// let mut queues = Queues::default();
/// let mut board: LawBoard<Vec<Edge>> =
///     LawBoard::new(&mut queues, Description::uno(), Vec::new());
/// for byte in *b"F50000,2500\rG10\r" {
///     board.receive(byte);
/// }
/// assert_eq!(board.take_answers(), b"Y\rY\r");
/// board.run_until(16_000_000);
/// let steps: Vec<u64> =
///     board.recorder().iter().filter(|edge| edge.is_step()).map(|edge| edge.time).collect();
/// assert_eq!((steps.len(), steps[1] - steps[0], steps[2] - steps[1]), (10, 800_000, 480_000));
/// ```
pub struct LawBoard<'q, R: Recorder, C: Count = u16> {
    now: LentNow<'q>,
    station: Station<'q, SimEngine<'q, R, C>, RUNS>,
    answers: Vec<u8>,
    /// Ticks between two visits of the main loop.
    visit: u64,
    next_visit: u64,
}

impl<'q, R: Recorder, C: Count> LawBoard<'q, R, C> {
    /// Switches a new board on.
    pub fn new(queues: &'q mut Queues, description: Description, recorder: R) -> Self {
        let board = description.board;
        let Shared { ends: [x, y, z], now, reverse } = queues.lend(&description);
        let mut pins = Pins::new(now, reverse, &description.coils, recorder);
        pins.face();
        let timer = SimTimer::on_grid(now, description.grid);
        let engine = Engine::new(timer, pins, [x.1, y.1, z.1], board.timing, board.rate);
        let mhz = board.rate.hz() / 1_000_000;
        let about = About { name: "virtual", mhz, costs: Costs::AVR };
        LawBoard {
            station: Station::new(SimEngine::new(now, engine), x.0, about),
            now,
            answers: Vec::new(),
            visit: u64::from(board.rate.micros(50)),
            next_visit: 0,
        }
    }

    /// The present, in ticks since the board was switched on.
    pub fn now(&self) -> u64 {
        self.now.get()
    }

    /// A byte arrives on the serial line, now.
    pub fn receive(&mut self, byte: u8) {
        self.station.receive(Some(byte));
        while let Some(byte) = self.station.next_byte() {
            self.answers.push(byte);
        }
        self.work();
    }

    /// What the board has said since the last call.
    pub fn take_answers(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.answers)
    }

    /// Lets time pass until `time`; what is due at `time` has happened then.
    pub fn run_until(&mut self, time: u64) {
        while self.now.get() < time {
            let wake = self.station.engine().next_event();
            if wake <= time && wake <= self.next_visit {
                self.station.engine().serve();
            } else if self.next_visit <= time {
                self.now.set(self.next_visit.max(self.now.get()));
                self.work();
            } else {
                self.now.set(time);
            }
        }
    }

    /// The main loop: delays are made as far ahead as there is room.
    fn work(&mut self) {
        for _ in 0..RUNS {
            self.station.work();
        }
        self.next_visit = self.now.get() + self.visit;
    }

    /// Whether the motor moves.
    pub fn is_busy(&self) -> bool {
        self.station.is_moving()
    }

    /// Where the motor is; `None` if that is uncertain.
    pub fn position(&self) -> Option<i64> {
        self.station.position()
    }

    /// The recorder.
    pub fn recorder(&mut self) -> &mut R {
        self.station.engine().recorder()
    }
}
