//! The virtual board in a machine, whose carriage closes a limit switch.

use stepwright_protocol::AxisId;
use stepwright_sim::{Answers, Description, Edge, Pin, Queues, Switch, VirtualBoard};

use crate::tape::Tape;

/// The time between two samples of the switch, in µs.
const LOOK: u32 = 100;

/// The board of `stepwright board`: an Uno with three axes.
pub struct VirtualMachine<'q> {
    board: VirtualBoard<'q, u16, &'q mut Tape>,
    description: Description,
    /// Ticks between two samples of the switch.
    look: u64,
    switch: Switch,
}

impl<'q> VirtualMachine<'q> {
    /// The limit switch of axis 1, as in `stepwright serve`.
    pub const SWITCH: Switch = Switch { axis: AxisId::FIRST, at: -1000 };

    /// Switches a new board on; its edges go to `tape`.
    pub fn new(queues: &'q mut Queues, tape: &'q mut Tape) -> VirtualMachine<'q> {
        let description = Description::uno();
        let look = u64::from(description.board.rate.micros(LOOK));
        let board = VirtualBoard::new(queues, description, tape);
        VirtualMachine { board, description, look, switch: VirtualMachine::SWITCH }
    }

    /// Ticks per second of its timer.
    pub fn hz(&self) -> u32 {
        self.description.board.rate.hz()
    }

    /// The number of its axes.
    pub fn axes(&self) -> u8 {
        self.description.axes
    }

    /// Ticks that a byte takes on the line.
    pub fn byte_time(&self) -> u64 {
        self.description.byte_time()
    }

    /// Ticks since the board was switched on.
    pub fn now(&self) -> u64 {
        self.board.now()
    }

    /// The edges of its pins.
    pub fn tape(&mut self) -> &Tape {
        self.board.recorder()
    }

    /// Whether any axis moves.
    pub fn is_busy(&self) -> bool {
        self.board.is_busy()
    }

    /// Receives a byte on the line, now, and returns the answers.
    pub fn receive(&mut self, byte: u8) -> Answers {
        self.board.receive(byte);
        self.note_enable();
        self.board.take_answers()
    }

    /// Lets time pass until `time` ticks.
    pub fn run_until(&mut self, time: u64) {
        while self.board.now().saturating_add(self.look) < time {
            self.board.run_until(self.board.now().saturating_add(self.look));
            self.turn_switch();
        }
        self.board.run_until(time);
        self.turn_switch();
        self.note_enable();
    }

    fn turn_switch(&mut self) {
        let axis = self.switch.axis.index();
        let shaft = self.board.recorder().shaft(axis).unwrap_or(0);
        // A closed switch is low: it connects to ground, and the pin is pulled up.
        self.board.set_switch(axis as u8, !self.switch.is_closed(shaft));
    }

    fn note_enable(&mut self) {
        let changes = self.board.take_enable_changes();
        for &(time, level) in changes.iter() {
            self.board.recorder().add(Edge { time, axis: 0, pin: Pin::Enable, level });
        }
    }
}
