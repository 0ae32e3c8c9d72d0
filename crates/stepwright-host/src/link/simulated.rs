//! A link to a board that is simulated in this process.

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use stepwright_sim::{Description, ProgramBoard, Queues, SimProgram, VirtualBoard};

use super::Link;
use super::pace::Paced;

/// A simulated board.
pub trait Simulated {
    /// Ticks of its timer per second.
    fn hz(&self) -> u32;

    /// Ticks that a byte takes on its serial line.
    fn byte_time(&self) -> u64;

    /// Ticks since the board was switched on.
    fn now(&self) -> u64;

    /// Lets time pass until `time` ticks.
    fn run_until(&mut self, time: u64);

    /// Receives a byte on its serial line, now.
    fn receive(&mut self, byte: u8);

    /// The bytes that the board has sent since the last call.
    fn take_answers(&mut self) -> Vec<u8>;

    /// Ends a recording.
    ///
    /// # Errors
    /// The recording can't be written.
    fn finish(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A virtual Uno: up to three axes, and a step timer of 16 MHz.
pub struct VirtualUno {
    board: VirtualBoard<'static, u16, ()>,
    description: Description,
}

impl VirtualUno {
    /// Switches a virtual Uno on. The memory of its queues is never freed.
    pub fn new() -> VirtualUno {
        VirtualUno::of(3)
    }

    /// One with this many axes, 1 to 3.
    pub fn of(axes: u8) -> VirtualUno {
        let queues = Box::leak(Box::<Queues>::default());
        let description = Description { axes, ..Description::uno() };
        VirtualUno { board: VirtualBoard::new(queues, description, ()), description }
    }
}

impl VirtualUno {
    /// The board, for tests.
    pub fn board(&mut self) -> &mut VirtualBoard<'static, u16, ()> {
        &mut self.board
    }
}

impl Default for VirtualUno {
    fn default() -> VirtualUno {
        VirtualUno::new()
    }
}

impl Simulated for VirtualUno {
    fn hz(&self) -> u32 {
        self.description.board.rate.hz()
    }

    fn byte_time(&self) -> u64 {
        self.description.byte_time()
    }

    fn now(&self) -> u64 {
        self.board.now()
    }

    fn run_until(&mut self, time: u64) {
        self.board.run_until(time);
    }

    fn receive(&mut self, byte: u8) {
        self.board.receive(byte);
    }

    fn take_answers(&mut self) -> Vec<u8> {
        self.board.take_answers()
    }
}

/// A virtual board with another program than the controller.
pub struct VirtualProgram<P: SimProgram, const LONGEST: usize> {
    /// The board, for tests.
    pub board: ProgramBoard<P, LONGEST>,
    hz: u32,
    byte_time: u64,
}

impl<P: SimProgram, const LONGEST: usize> VirtualProgram<P, LONGEST> {
    /// A board whose timer has `hz` ticks per second, and whose line takes `byte_time` ticks for a byte.
    pub fn new(board: ProgramBoard<P, LONGEST>, hz: u32, byte_time: u64) -> Self {
        VirtualProgram { board, hz, byte_time }
    }
}

impl<P: SimProgram, const LONGEST: usize> Simulated for VirtualProgram<P, LONGEST> {
    fn hz(&self) -> u32 {
        self.hz
    }

    fn byte_time(&self) -> u64 {
        self.byte_time
    }

    fn now(&self) -> u64 {
        self.board.now()
    }

    fn run_until(&mut self, time: u64) {
        self.board.run_until(time);
    }

    fn receive(&mut self, byte: u8) {
        self.board.receive(byte);
    }

    fn take_answers(&mut self) -> Vec<u8> {
        self.board.take_answers()
    }
}

/// A link to a simulated board whose time passes while the host waits.
pub struct VirtualLink<B> {
    board: Paced<B>,
    /// Bytes on their way to the host, and the tick at which each arrives.
    coming: VecDeque<(u64, u8)>,
}

impl<B: Simulated> VirtualLink<B> {
    /// Connects to a board. Its time passes in real time, or, if it is `fast`, as fast as it can be simulated.
    pub fn new(board: B, fast: bool) -> VirtualLink<B> {
        VirtualLink { board: Paced::new(board, fast), coming: VecDeque::new() }
    }

    /// The board.
    pub fn board(&mut self) -> &mut B {
        &mut self.board.board
    }
}

impl<B: Simulated> Link for VirtualLink<B> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        for &byte in bytes {
            self.board.receive(byte);
            for answer in self.board.board.take_answers() {
                let last = self.coming.back().map_or(0, |(time, _)| *time);
                let here = last.max(self.board.board.now()) + self.board.byte_time();
                self.coming.push_back((here, answer));
            }
        }
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        // Rounded up: a wait of less than a tick must let time pass.
        let until = self.board.board.now() + self.board.ticks(limit) + 1;
        let until = self.coming.front().map_or(until, |(time, _)| until.min(*time));
        self.board.pass_until(until);
        let now = self.board.board.now();
        let mut count = 0;
        while let (Some((time, byte)), Some(slot)) = (self.coming.front(), buffer.get_mut(count)) {
            if *time > now {
                break;
            }
            *slot = *byte;
            count += 1;
            self.coming.pop_front();
        }
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.board.now()
    }

    fn name(&self) -> String {
        "the virtual board".to_owned()
    }

    fn finish(&mut self) -> io::Result<()> {
        self.board.board.finish()
    }
}
