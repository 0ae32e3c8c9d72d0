//! The board itself: engine, motors and the slave, over simulated time.

use stepwright::drive::{Axes, Drive};
use stepwright::queue::{Consumer, Queue};
use stepwright::timer::Count;
use stepwright::{Engine, Group};
use stepwright_protocol::{Controller, Slave};

use crate::clock::{Now, SimTimer};
use crate::description::Description;
use crate::edge::{Edge, Pin, Recorder};

/// Axes of a virtual board, of which a description may connect fewer.
pub const AXES: usize = 3;

/// Runs queued for each axis, as on the Uno.
const RUNS: usize = 8;

/// Where the runs of a board's axes wait. Made before the board, which borrows
/// it.
#[derive(Default)]
pub struct Queues([Queue<RUNS>; AXES]);

/// Simulated pins: every change goes to the recorder.
struct Pins<R> {
    now: Now,
    forward: [Option<bool>; AXES],
    recorder: R,
}

impl<R: Recorder> Pins<R> {
    fn steps(&mut self, axes: Axes, level: bool) {
        let time = self.now.get();
        for axis in (0..AXES as u8).filter(|axis| axes >> axis & 1 != 0) {
            self.recorder.edge(Edge { time, axis, pin: Pin::Step, level });
        }
    }
}

impl<R: Recorder> Drive for Pins<R> {
    fn begin(&mut self, axes: Axes) {
        self.steps(axes, true);
    }

    fn end(&mut self, axes: Axes) {
        self.steps(axes, false);
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        let Some(known) = self.forward.get_mut(usize::from(axis)) else { return };
        if *known != Some(forward) {
            *known = Some(forward);
            let time = self.now.get();
            self.recorder.edge(Edge { time, axis, pin: Pin::Direction, level: forward });
        }
    }
}

type BoardEngine<'q, C, R> = Engine<SimTimer<C>, Pins<R>, Consumer<'q, RUNS>, AXES>;

/// A board with a timer as wide as `C` (`u16` for an Uno), whose edges go to
/// `R`.
///
/// Time passes only in [`run_until`](VirtualBoard::run_until) and
/// [`run_to_rest`](VirtualBoard::run_to_rest), as fast as the machine can; for
/// real time call the first with the time of day.
pub struct VirtualBoard<'q, C: Count, R: Recorder> {
    now: Now,
    engine: BoardEngine<'q, C, R>,
    group: Group<'q, AXES, RUNS>,
    slave: Slave<AXES>,
    axes: u8,
    answers: Vec<u8>,
    /// Ticks between two visits of the foreground to the planner.
    visit: u64,
    next_visit: u64,
}

impl<'q, C: Count, R: Recorder> VirtualBoard<'q, C, R> {
    /// Switches a board on.
    pub fn new(queues: &'q mut Queues, description: Description, recorder: R) -> Self {
        let now = Now::default();
        let pins = Pins { now: now.clone(), forward: [None; AXES], recorder };
        let [x, y, z] = queues.0.each_mut().map(Queue::split);
        let board = description.board;
        let consumers = [x.1, y.1, z.1];
        VirtualBoard {
            engine: Engine::new(SimTimer::new(now.clone()), pins, consumers, board.timing),
            group: Group::new([x.0, y.0, z.0], board),
            slave: Slave::new(),
            axes: description.axes.clamp(1, AXES as u8),
            answers: Vec::new(),
            visit: u64::from(board.rate.micros(50)),
            next_visit: 0,
            now,
        }
    }

    /// The present, in ticks since the board was switched on.
    pub fn now(&self) -> u64 {
        self.now.get()
    }

    /// A byte arrives on the serial line, now.
    pub fn receive(&mut self, byte: u8) {
        let mut machine =
            Controller { group: &mut self.group, engine: &mut self.engine, axes: self.axes };
        if let Some(reply) = self.slave.push(byte, &mut machine) {
            self.answers.extend(reply.bytes());
        }
        self.plan();
    }

    /// What the board has said since the last call.
    pub fn take_answers(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.answers)
    }

    /// Lets time pass until `time`; what is due at `time` has happened then.
    pub fn run_until(&mut self, time: u64) {
        while self.now.get() < time {
            self.pass(time);
        }
    }

    /// Lets time pass until no axis moves. Without end, if one runs endlessly.
    pub fn run_to_rest(&mut self) {
        self.plan();
        while self.is_busy() {
            self.pass(u64::MAX);
        }
    }

    /// On to the next event of the engine or the next visit of the
    /// foreground, but not beyond `limit`.
    fn pass(&mut self, limit: u64) {
        let wake = self.engine.timer().wake();
        if wake <= limit && wake <= self.next_visit {
            // Time may have passed it by during a pulse.
            self.now.set(wake.max(self.now.get()));
            self.engine.on_compare();
        } else if self.next_visit <= limit {
            self.now.set(self.next_visit.max(self.now.get()));
            self.plan();
        } else {
            self.now.set(limit);
        }
    }

    /// The foreground has a look, and plans what is wanted.
    fn plan(&mut self) {
        while self.group.poll(&mut self.engine) {}
        self.next_visit = self.now.get() + self.visit;
    }

    /// Whether any axis has a travel in progress.
    pub fn is_busy(&self) -> bool {
        self.group.any_busy(&self.engine)
    }

    /// Whether any axis goes on until it is stopped: it would never rest.
    pub fn is_endless(&self) -> bool {
        self.group.any_endless()
    }

    /// Position of an axis in steps, also on the way; `None` if uncertain.
    pub fn position(&self, axis: u8) -> Option<i64> {
        self.group.position(&self.engine, axis)
    }

    /// Steps that came late.
    pub fn late(&self) -> u32 {
        self.engine.late()
    }

    /// The motors and the engine, for orders that need no line.
    pub fn controller(&mut self) -> Controller<'_, 'q, impl stepwright::Control, AXES, RUNS> {
        Controller { group: &mut self.group, engine: &mut self.engine, axes: self.axes }
    }

    /// The recorder.
    pub fn recorder(&mut self) -> &mut R {
        &mut self.engine.drive().recorder
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
