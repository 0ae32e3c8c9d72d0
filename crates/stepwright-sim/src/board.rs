//! The board itself: the device and its engine in simulated time.

use core::cell::Cell;

use stepwright::drive::Axes;
use stepwright::engine::WIRING;
use stepwright::entry::Wiring;
use stepwright::queue::{Consumer, Producer, Queue};
use stepwright::timer::Count;
use stepwright::{Axis, Control, Engine, OrderedMotors};
use stepwright_device::{Device, Mark, Reset};
use stepwright_protocol::Settings;

use crate::clock::{LentNow, Present, SimTimer};
use crate::description::Description;
use crate::edge::Recorder;
use crate::few::{Answers, EnableChanges};
use crate::panel::{EMPTY, Eeprom, Remains, SimPanel};
use crate::pins::Pins;
use crate::steppers::SimEngine;

/// The axes of a virtual board. A description may connect fewer.
pub const AXES: usize = 3;

/// The entries queued for each axis, as on the Uno.
pub(crate) const RUNS: usize = 8;

/// The shared state of a board: the queues of its axes, the time, and which axes are reversed. Made before the
/// board, which borrows it.
#[derive(Default)]
pub struct Queues {
    queues: [Queue<RUNS>; AXES],
    now: Cell<u64>,
    reverse: Cell<Axes>,
}

/// The two ends of an axis' queue, for the foreground and the engine.
pub(crate) type Ends<'q> = (Producer<'q, RUNS>, Consumer<'q, RUNS>);

/// The parts that a board borrows.
pub(crate) struct Shared<'q> {
    pub(crate) ends: [Ends<'q>; AXES],
    pub(crate) now: LentNow<'q>,
    pub(crate) reverse: &'q Cell<Axes>,
}

impl Queues {
    /// Lends the queues to a new board, at tick 0.
    pub(crate) fn lend(&mut self, description: &Description) -> Shared<'_> {
        let wiring =
            if description.assembly { Wiring::new(WIRING.step, WIRING.turn) } else { WIRING };
        let Queues { queues, now, reverse } = self;
        now.set(0);
        reverse.set(0);
        Shared {
            ends: queues.each_mut().map(|queue| queue.split_as(wiring)),
            now: LentNow(now),
            reverse,
        }
    }
}

pub(crate) type BoardEngine<'q, C, R> =
    Engine<SimTimer<C, LentNow<'q>>, Pins<'q, R>, Consumer<'q, RUNS>, AXES>;

/// A board with a timer as wide as `C` (`u16` for an Uno), whose edges go to `R`.
///
/// Time passes only in [`run_until`](VirtualBoard::run_until) and [`run_to_rest`](VirtualBoard::run_to_rest),
/// as fast as the computer can simulate it. For real time, call `run_until` with the time of day.
pub struct VirtualBoard<'q, C: Count, R: Recorder> {
    now: LentNow<'q>,
    device: Device<'q, SimEngine<'q, R, C>, AXES, RUNS>,
    panel: SimPanel<'q>,
    answers: Answers,
    /// Ticks between two visits of the foreground to the planner.
    visit: u64,
    next_visit: u64,
}

impl<'q, C: Count, R: Recorder> VirtualBoard<'q, C, R> {
    /// Switches a new board on.
    pub fn new(queues: &'q mut Queues, description: Description, recorder: R) -> Self {
        VirtualBoard::with_eeprom(queues, description, recorder, EMPTY)
    }

    /// Switches a board on with these bytes in its EEPROM. Its pulse and direction times come from its
    /// settings, not from its description.
    pub fn with_eeprom(
        queues: &'q mut Queues,
        description: Description,
        recorder: R,
        eeprom: Eeprom,
    ) -> Self {
        let remains = Remains { eeprom, mark: Mark::NONE };
        VirtualBoard::restarted(queues, description, recorder, Reset::Power, remains)
    }

    /// A board after a reset, with the [`remains`](VirtualBoard::remains) of another board. Like a new board it
    /// begins at tick 0.
    pub fn restarted(
        queues: &'q mut Queues,
        description: Description,
        recorder: R,
        reset: Reset,
        remains: Remains,
    ) -> Self {
        let Shared { ends: [x, y, z], now, reverse } = queues.lend(&description);
        let pins = Pins::new(now, reverse, &description.coils, recorder);
        let board = description.board;
        let timer = SimTimer::on_grid(now, description.grid);
        let engine = Engine::new(timer, pins, [x.1, y.1, z.1], board.timing, board.rate);
        let engine = SimEngine::new(now, engine);
        let mut panel = SimPanel::new(now, board.rate, reverse, reset, remains);
        let axes = description.axes.clamp(1, AXES as u8);
        let motors = OrderedMotors::new(engine, [x.0, y.0, z.0], board);
        let mut device = Device::new(motors, axes, &mut panel);
        device.motors_mut().engine().face();
        VirtualBoard {
            device,
            panel,
            answers: Answers::default(),
            // A foreground as quick as the board: a queue may last only for its entries of one step each.
            visit: u64::from(board.rate.micros(50).min(6 * board.cost.ticks[0]).max(1)),
            next_visit: 0,
            now,
        }
    }

    /// The present, in ticks since the board was switched on.
    pub fn now(&self) -> u64 {
        self.now.get()
    }

    /// Receives a byte on the serial line, now.
    pub fn receive(&mut self, byte: u8) {
        self.device.receive(byte, &mut self.panel);
        // Starts an order at once: all its parts take no time.
        while self.device.work(&mut self.panel) {}
        if self.device.is_answering() {
            while let Some(byte) = self.device.next_byte(&mut self.panel) {
                self.answers.push(byte);
            }
            // The line may have been a setting that reverses an axis.
            self.engine().face();
        }
        self.plan();
    }

    /// The bytes that the board has sent since the last call.
    pub fn take_answers(&mut self) -> Answers {
        core::mem::take(&mut self.answers)
    }

    /// Lets time pass until `time`, with all events up to and at `time`.
    pub fn run_until(&mut self, time: u64) {
        while self.now.get() < time {
            self.pass(time);
        }
    }

    /// Lets time pass until no axis moves. Never returns if an axis runs endlessly.
    pub fn run_to_rest(&mut self) {
        self.plan();
        while self.is_busy() {
            self.pass(u64::MAX);
        }
    }

    /// Goes on to the next event of the engine or the next visit of the foreground, but not beyond `limit`.
    fn pass(&mut self, limit: u64) {
        let wake = self.engine().next_event();
        if wake <= limit && wake <= self.next_visit {
            self.engine().serve();
        } else if self.next_visit <= limit {
            self.now.set(self.next_visit.max(self.now.get()));
            self.plan();
        } else {
            self.now.set(limit);
        }
    }

    /// A visit of the foreground, which plans ahead.
    fn plan(&mut self) {
        while self.device.poll(&mut self.panel) {}
        self.next_visit = self.now.get() + self.visit;
    }

    /// Whether any axis has a travel in progress.
    pub fn is_busy(&self) -> bool {
        self.device.motors().any_moving()
    }

    /// Whether any axis runs until it is stopped.
    pub fn is_endless(&self) -> bool {
        self.device.motors().any_endless()
    }

    /// The position of an axis in steps, also while it moves; `None` if it is uncertain.
    pub fn position(&self, axis: u8) -> Option<i64> {
        Axis::new(axis.into()).ok().and_then(|axis| self.device.motors().position(axis))
    }

    /// The number of late steps.
    pub fn late(&self) -> u32 {
        self.device.motors().late()
    }

    /// The motors, for orders without a line; no setting limits them.
    pub fn motors(&mut self) -> &mut OrderedMotors<'q, impl Control, AXES, RUNS> {
        self.device.motors_mut()
    }

    fn engine(&mut self) -> &mut SimEngine<'q, R, C> {
        self.device.motors_mut().engine()
    }

    /// The board's settings.
    pub fn settings(&self) -> &Settings {
        self.device.settings()
    }

    /// Sets the level of a limit switch's pin. The pins are pulled up: a switch to ground makes its pin low
    /// when it closes.
    pub fn set_switch(&mut self, axis: u8, high: bool) {
        let bit = 1u8.checked_shl(axis.into()).unwrap_or(0);
        self.panel.switches = self.panel.switches & !bit | if high { bit } else { 0 };
    }

    /// Sets the level of the emergency stop's pin; it is high at first, pulled up.
    pub fn set_emergency(&mut self, high: bool) {
        self.panel.emergency = high;
    }

    /// Sets the level of the pin of the drivers' fault outputs; it is high at first.
    pub fn set_driver_fault(&mut self, high: bool) {
        self.panel.driver_fault = high;
    }

    /// The level of the pin that enables the drivers.
    pub fn enable_level(&self) -> bool {
        self.panel.enable
    }

    /// The changes of the enable pin since the last call, with their times in ticks and levels: the last 64 at
    /// most.
    pub fn take_enable_changes(&mut self) -> EnableChanges {
        core::mem::take(&mut self.panel.enable_changes)
    }

    /// The present bytes of the EEPROM.
    pub fn eeprom(&self) -> Eeprom {
        self.panel.remains.eeprom
    }

    /// The state that a reset now would leave, besides the wiring.
    pub fn remains(&self) -> Remains {
        self.panel.remains
    }

    /// Whether settings are still being written to the EEPROM.
    pub fn is_saving(&self) -> bool {
        self.device.is_saving()
    }

    /// The recorder.
    pub fn recorder(&mut self) -> &mut R {
        self.engine().recorder()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge::Edge;

    #[test]
    fn an_endless_run_is_told_apart_until_it_brakes() {
        let mut queues = Queues::default();
        let mut board: VirtualBoard<u16, Vec<Edge>> =
            VirtualBoard::new(&mut queues, Description::uno(), Vec::new());
        let say = |board: &mut VirtualBoard<u16, Vec<Edge>>, line: &[u8]| {
            line.iter().for_each(|&byte| board.receive(byte));
        };
        assert!(!board.is_endless());
        say(&mut board, b"g+\r");
        board.run_until(8_000_000);
        assert!(board.is_endless() && board.is_busy());
        say(&mut board, b"Z\r");
        assert!(!board.is_endless() && board.is_busy());
        board.run_to_rest();
        say(&mut board, b"PO\rG-40\rE\r");
        assert!(!board.is_endless() && board.is_busy());
    }
}
