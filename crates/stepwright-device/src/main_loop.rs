//! The main loop of a board with a serial line, for every firmware and every program.
//!
//! ```text
//!   ┌► tick ─► answer? ─ yes ─► send a byte, if there is room ─┐
//!   │               └─── no ──► receive, up to a line; work ───┤
//!   └── plan, up to a run ◄── poll_io: inputs, times ◄─────────┘
//! ```
//!
//! No part waits: each returns after one piece of its work, so that inputs are sampled and bytes
//! are received while a long order starts or an answer is sent.

use core::ops::DerefMut;

use stepwright::Control;

use crate::device::Device;
use crate::panel::BoardIo;

/// A received byte, or an error in its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// A byte.
    Byte(u8),
    /// A byte was lost or damaged on the way.
    Garbled,
}

/// A serial line for the main loop. None of its methods may wait.
pub trait SerialPort {
    /// The next received byte, if there is one.
    fn receive(&mut self) -> Option<Received>;
    /// Whether there is room for a byte to send.
    fn has_room(&self) -> bool;
    /// Sends a byte. Called only while there is room.
    fn send(&mut self, byte: u8);
}

/// The foreground of a board, without its line.
pub trait Foreground {
    /// Whether it takes the next line while an answer is being sent: for a serial port that does
    /// not buffer it meanwhile.
    const LISTENS_MEANWHILE: bool = false;

    /// Called at the beginning of each round: reads the clock and feeds the watchdog.
    fn tick(&mut self);
    /// Whether part of the last answer is still to be sent.
    fn is_answering(&mut self) -> bool;
    /// Whether it takes a byte now.
    fn listens(&mut self) -> bool;
    /// Takes a byte from the line.
    fn receive(&mut self, byte: u8);
    /// Reports that a byte was lost or damaged.
    fn garbled(&mut self);
    /// Obeys a complete line, or does one piece of its work.
    fn work(&mut self);
    /// The next byte of the answer.
    fn next_byte(&mut self) -> Option<u8>;
    /// Handles inputs, times and settings. Called every millisecond, except while a line is obeyed:
    /// some 2 ms for a change, and the interrupts meanwhile.
    fn poll_io(&mut self) {}
    /// One piece of planning. True if there may be more.
    fn plan(&mut self) -> bool {
        false
    }
}

/// The number of pieces in which a straight ramp's run is planned. A byte of the line may wait for
/// that long.
const PIECES: u8 = 4;

/// The main loop.
pub fn run(board: &mut impl Foreground, line: &mut impl SerialPort) -> ! {
    loop {
        round(board, line);
    }
}

/// One round of the main loop.
#[inline(always)]
pub fn round<B: Foreground>(board: &mut B, line: &mut impl SerialPort) {
    board.tick();
    if board.is_answering() {
        answer(board, line);
        if B::LISTENS_MEANWHILE {
            listen(board, line);
        }
    } else {
        listen(board, line);
        work(board);
    }
    board.poll_io();
    for _ in 0..PIECES {
        if !plan(board) {
            break;
        }
    }
}

// The parts are functions of their own, so that a small chip's frame stays within reach of its
// stack pointer, and a bench finds them by name.

/// One piece of planning.
#[inline(never)]
fn plan(board: &mut impl Foreground) -> bool {
    board.plan()
}

/// Receives the bytes that have come, up to the end of a line.
#[inline(never)]
fn listen(board: &mut impl Foreground, line: &mut impl SerialPort) {
    while board.listens()
        && let Some(received) = line.receive()
    {
        match received {
            Received::Byte(byte) => board.receive(byte),
            Received::Garbled => board.garbled(),
        }
    }
}

/// Obeys a line, or does one piece of starting an order.
#[inline(never)]
fn work(board: &mut impl Foreground) {
    board.work();
}

/// Sends a byte of the answer, if there is room. Planning continues between two bytes: an answer
/// that filled the line's buffer at once would delay it for longer than a queue lasts.
#[inline(never)]
fn answer(board: &mut impl Foreground, line: &mut impl SerialPort) {
    if line.has_room()
        && let Some(byte) = board.next_byte()
    {
        line.send(byte);
    }
}

/// A [`Device`] on its board, as the firmware runs it. `D` dereferences to the device, which may be
/// at a fixed address on a chip.
pub struct OnBoard<D, P> {
    /// The device.
    pub device: D,
    /// Its board's pins, time and memory.
    pub io: P,
}

impl<'q, D, P, E, const N: usize, const Q: usize> Foreground for OnBoard<D, P>
where
    D: DerefMut<Target = Device<'q, E, N, Q>>,
    P: BoardIo,
    E: Control + 'q,
{
    #[inline(always)]
    fn tick(&mut self) {
        self.io.tick();
    }
    #[inline(always)]
    fn is_answering(&mut self) -> bool {
        self.device.is_answering()
    }
    #[inline(always)]
    fn listens(&mut self) -> bool {
        self.device.listens()
    }
    #[inline(always)]
    fn receive(&mut self, byte: u8) {
        self.device.receive(byte, &mut self.io);
    }
    #[inline(always)]
    fn garbled(&mut self) {
        self.device.garbled();
    }
    #[inline(always)]
    fn work(&mut self) {
        self.device.work(&mut self.io);
    }
    #[inline(always)]
    fn next_byte(&mut self) -> Option<u8> {
        self.device.next_byte(&mut self.io)
    }
    #[inline(always)]
    fn poll_io(&mut self) {
        self.device.poll_io(&mut self.io);
    }
    #[inline(always)]
    fn plan(&mut self) -> bool {
        self.device.plan()
    }
}
