//! A board with another program than the controller: the line, the time and the main loop common to such
//! programs.

use stepwright_device::ProgramDevice;
use stepwright_device::main_loop::Foreground;
use stepwright_protocol::BoardProgram;

/// Rounds of the main loop per visit.
const ROUNDS: usize = 8;

/// A program whose time is simulated.
pub trait SimProgram: BoardProgram {
    /// Lets time pass until `time`, with all events up to and at `time`. Returns the present, which may be
    /// somewhat later.
    fn pass_until(&mut self, time: u64) -> u64;
}

/// A virtual board that runs a program, with lines of up to `LONGEST` bytes.
pub struct ProgramBoard<P: BoardProgram, const LONGEST: usize> {
    device: ProgramDevice<P, (), LONGEST>,
    now: u64,
    answers: Vec<u8>,
    /// Ticks between two visits of the main loop.
    visit: u64,
    next_visit: u64,
}

impl<P: SimProgram, const LONGEST: usize> ProgramBoard<P, LONGEST> {
    /// A board with this program, whose main loop runs every `visit` ticks.
    pub fn of(program: P, visit: u64) -> Self {
        let (device, answers) = (ProgramDevice::new(program, ()), Vec::new());
        ProgramBoard { device, now: 0, answers, visit, next_visit: 0 }
    }

    /// The program.
    pub fn program(&mut self) -> &mut P {
        self.device.program()
    }

    /// The present, in ticks since the board was switched on.
    pub fn now(&self) -> u64 {
        self.now
    }

    /// Receives a byte on the serial line, now.
    pub fn receive(&mut self, byte: u8) {
        self.device.receive(byte);
        self.work();
    }

    /// The bytes that the board has sent since the last call.
    pub fn take_answers(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.answers)
    }

    /// Lets time pass until `time`, with all events up to and at `time`.
    pub fn run_until(&mut self, time: u64) {
        while self.now < time {
            let visit = self.next_visit <= time;
            let next = if visit { self.next_visit } else { time };
            self.now = self.device.program().pass_until(next.max(self.now));
            if visit {
                self.work();
            }
        }
    }

    /// Runs the main loop, and sends the answer at once.
    fn work(&mut self) {
        for _ in 0..ROUNDS {
            self.device.work();
            while let Some(byte) = self.device.next_byte() {
                self.answers.push(byte);
            }
            self.device.poll_io();
        }
        self.now = self.device.program().pass_until(self.now);
        self.next_visit = self.now + self.visit;
    }

    /// Whether anything moves.
    pub fn is_busy(&mut self) -> bool {
        self.program().is_busy()
    }

    /// The position of an axis; `None` if it is unknown.
    pub fn position(&mut self, axis: u8) -> Option<i64> {
        self.program().position(axis)
    }
}
