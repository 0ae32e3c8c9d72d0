//! A program with fewer features on the main loop's line: Austin's laws, the timed driver, motor
//! cycles.

use stepwright_protocol::{BoardProgram, Incoming, ProgramSlave};

use crate::main_loop::Foreground;
use crate::reset::ResetIo;

/// A program with its line and its slave, as [`round`](crate::main_loop::round) runs it. A line has
/// at most `LONGEST` bytes.
pub struct ProgramDevice<P: BoardProgram, M, const LONGEST: usize> {
    program: P,
    marks: M,
    line: Incoming<LONGEST>,
    slave: ProgramSlave<P::Reason>,
    /// A complete line waits until the answer before it is sent.
    waits: bool,
}

impl<P: BoardProgram, M: ResetIo, const LONGEST: usize> ProgramDevice<P, M, LONGEST> {
    /// The state after a reset: the positions are 0, or unknown as the marks say.
    pub fn new(mut program: P, mut marks: M) -> ProgramDevice<P, M, LONGEST> {
        if marks.begin() {
            program.mark_unknown();
        }
        let (line, slave) = (Incoming::new(), ProgramSlave::new());
        ProgramDevice { program, marks, line, slave, waits: false }
    }

    /// The program.
    pub fn program(&mut self) -> &mut P {
        &mut self.program
    }
}

impl<P: BoardProgram, M: ResetIo, const LONGEST: usize> Foreground
    for ProgramDevice<P, M, LONGEST>
{
    const LISTENS_MEANWHILE: bool = true;

    #[inline(always)]
    fn tick(&mut self) {}

    #[inline(always)]
    fn is_answering(&mut self) -> bool {
        self.slave.is_answering()
    }

    #[inline(always)]
    fn listens(&mut self) -> bool {
        !self.waits
    }

    fn receive(&mut self, byte: u8) {
        self.waits = self.line.receive(Some(byte));
    }

    fn garbled(&mut self) {
        self.line.garble();
    }

    fn work(&mut self) {
        if self.waits && !self.slave.is_answering() {
            self.waits = false;
            self.slave.obey(&mut self.line, &mut self.program);
            // Before the first step: a motion begins with the next poll, or some time after a start.
            self.marks.note(|| self.program.is_busy());
        }
    }

    fn next_byte(&mut self) -> Option<u8> {
        self.slave.next_byte(&mut self.program)
    }

    #[inline(always)]
    fn poll_io(&mut self) {
        self.program.poll();
        self.marks.note(|| self.program.is_busy());
    }
}
