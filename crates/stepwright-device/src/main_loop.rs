//! The main loop of a board with the line, for every firmware and every program behind it.
//!
//! ```text
//!   ┌► tick ─► answer? ─ yes ─► send a byte, if there is room ─┐
//!   │               └─── no ──► receive, up to a line; work ───┤
//!   └── plan, up to a run ◄── poll_io: inputs, times ◄─────────┘
//! ```
//!
//! Nothing waits: each part returns after one piece of its work, so that inputs are looked at
//! and bytes are taken while a long order starts or an answer is being sent.

use core::ops::DerefMut;

use stepwright::Control;

use crate::device::Device;
use crate::panel::BoardIo;

/// A byte of the line, or what has become of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// It came.
    Byte(u8),
    /// It was lost or damaged on the way.
    Garbled,
}

/// A serial line as a main loop has it. None of its methods may wait.
pub trait SerialPort {
    /// The next byte that has come, if one has.
    fn receive(&mut self) -> Option<Received>;
    /// Whether there is room for a byte to send.
    fn has_room(&self) -> bool;
    /// Sends a byte. Called only while there is room.
    fn send(&mut self, byte: u8);
}

/// All of a board that is not an interrupt, but for its line.
pub trait Foreground {
    /// Whether it takes the next line while an answer is on its way: for a line that nothing
    /// keeps meanwhile.
    const LISTENS_MEANWHILE: bool = false;

    /// A round begins: the clock is looked at, the watchdog told that all is well.
    fn tick(&mut self);
    /// Whether some of the last answer has yet to be pulled.
    fn is_answering(&mut self) -> bool;
    /// Whether it takes a byte now.
    fn listens(&mut self) -> bool;
    /// Takes a byte from the line.
    fn receive(&mut self, byte: u8);
    /// A byte was lost or damaged.
    fn garbled(&mut self);
    /// Obeys a line that is complete, or does one piece of what it asks for.
    fn work(&mut self);
    /// The next byte of the answer.
    fn next_byte(&mut self) -> Option<u8>;
    /// Looks after inputs, times, settings. Called at least every millisecond.
    fn poll_io(&mut self) {}
    /// One piece of planning. True if there may be more.
    fn plan(&mut self) -> bool {
        false
    }
}

/// Pieces that a straight ramp's run is planned in; a byte of the line may wait for that long.
const PIECES: u8 = 4;

/// The main loop.
pub fn run(board: &mut impl Foreground, line: &mut impl SerialPort) -> ! {
    loop {
        round(board, line);
    }
}

/// The main loop once round.
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

// The parts are functions of their own: a small chip's frame stays within reach of its stack
// pointer, and a bench finds them by their names.

/// One piece of planning.
#[inline(never)]
fn plan(board: &mut impl Foreground) -> bool {
    board.plan()
}

/// Takes what has come, up to the end of a line.
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

/// Sends a byte of the answer, if there is room. Planning goes on between two bytes: an answer
/// that filled the line's buffer at once would hold it up for longer than a queue lasts.
#[inline(never)]
fn answer(board: &mut impl Foreground, line: &mut impl SerialPort) {
    if line.has_room()
        && let Some(byte) = board.next_byte()
    {
        line.send(byte);
    }
}

/// A [`Device`] with the board that it is on: what its firmware runs. `D` reaches the device,
/// which a chip may have at a fixed address.
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
