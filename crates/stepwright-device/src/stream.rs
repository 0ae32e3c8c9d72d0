//! A board that plays a host's stream: frames and the common text lines on one wire.
//!
//! ```text
//!   bytes ─► link ─┬─ frames ─► player ─► queues
//!                  └─ text ───► line ─► F V I Z K ?
//!   bytes ◄─ credit, between two bytes of a text answer ◄─┘
//! ```

use stepwright::Control;
use stepwright_protocol::{
    BoardProgram, Fault, Incoming, Numbers, OwnFault, Piece, ProgramSlave, Said, Text, flash_text,
};
use stepwright_stream::credit::LEN as CREDIT;
use stepwright_stream::link::Came;
use stepwright_stream::player::StreamPlayer;
use stepwright_stream::record::AXES;

use crate::main_loop::Foreground;
use crate::reset::ResetIo;

/// The longest text line, in bytes.
const LONGEST: usize = 16;

/// The board's side of a stream.
pub trait StreamIo {
    /// The step timer, or its lower 16 bits.
    fn now(&mut self) -> u16;
    /// Whether a millisecond has passed: true once for each. Called at least every 16 ms.
    fn ticked(&mut self) -> bool;
    /// The closed inputs, as bits: 0 to 2 the axes' switches, 6 the drivers' fault, 7 the emergency
    /// stop.
    fn inputs(&mut self) -> u8;
    /// Switches the drivers on. Called again and again while they are to be on.
    fn enable(&mut self);
    /// Whether the board has an output for a laser.
    const LASER: bool = false;
    /// Sets the power of the laser: 0, off, to 255. Called when it changes; it is off at first.
    fn set_power(&mut self, power: u8) {
        let _ = power;
    }
}

/// The rows and reasons of a program that has none of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Streamless {}

impl OwnFault for Streamless {
    fn word(&self) -> Text {
        match *self {}
    }

    fn number(&self, _: u8) -> Option<i64> {
        match *self {}
    }

    fn read(_: &[u8], _: &mut Numbers<'_>) -> Option<Streamless> {
        None
    }
}

/// The player as the program behind the text lines.
pub struct StreamProgram<'q, E, const Q: usize, const LEN: usize> {
    /// The player of the frames.
    pub player: StreamPlayer<'q, E, Q, LEN>,
    name: Text,
    hz: u32,
    laser: bool,
}

impl<'q, E: Control, const Q: usize, const LEN: usize> BoardProgram
    for StreamProgram<'q, E, Q, LEN>
{
    type Row = Streamless;
    type Reason = Streamless;

    fn about(&mut self, n: u8) -> Option<Piece> {
        Some(Piece::Text(match n {
            0 => flash_text!("stepwright-stream "),
            1 => self.name,
            2 => flash_text!(" hz="),
            3 => return Some(Piece::Number(self.hz)),
            4 => flash_text!(" axes=3 late="),
            5 => return Some(Piece::Number(self.player.engine().late())),
            6 => flash_text!(" fifo="),
            7 => return Some(Piece::Number(LEN as u32)),
            8 if self.laser => flash_text!(" can=sum,laser"),
            8 => flash_text!(" can=sum"),
            _ => return None,
        }))
    }

    fn axes(&self) -> u8 {
        AXES as u8
    }

    fn read(&self, _: u8, _: &mut Numbers<'_>) -> Option<Streamless> {
        None
    }

    fn carry_out(&mut self, row: &Streamless) -> Result<Said, Fault<Streamless>> {
        match *row {}
    }

    fn is_busy(&mut self) -> bool {
        self.player.is_busy()
    }

    fn position(&mut self, axis: u8) -> Option<i64> {
        self.player.position(axis)
    }

    fn set_zero(&mut self, axis: u8) {
        self.player.set_zero(axis);
    }

    fn mark_unknown(&mut self) {
        self.player.mark_unknown();
    }

    fn stop(&mut self) {
        self.player.stop();
    }

    fn kill(&mut self) {
        self.player.kill();
    }

    fn poll(&mut self) {}
}

/// The whole foreground of a streaming board, as [`round`](crate::main_loop::round) runs it.
pub struct StreamDevice<'q, E, I, M, const Q: usize, const LEN: usize> {
    program: StreamProgram<'q, E, Q, LEN>,
    /// The board.
    pub io: I,
    marks: M,
    line: Incoming<LONGEST>,
    slave: ProgramSlave<Streamless>,
    /// A complete line waits until the answer before it is sent.
    waits: bool,
    /// The beginning of another line has come while one waited, and is lost.
    overrun: bool,
    /// The credit that is being sent, and the number of its bytes sent.
    credit: [u8; CREDIT],
    sent: u8,
    /// The present power of the laser.
    power: u8,
}

impl<'q, E: Control, I: StreamIo, M: ResetIo, const Q: usize, const LEN: usize>
    StreamDevice<'q, E, I, M, Q, LEN>
{
    /// The state at power-up: a board of this name whose timer counts `hz` ticks a second. To be
    /// [begun](StreamDevice::begin).
    pub const fn new(
        player: StreamPlayer<'q, E, Q, LEN>,
        io: I,
        marks: M,
        name: Text,
        hz: u32,
    ) -> Self {
        StreamDevice {
            program: StreamProgram { player, name, hz, laser: I::LASER },
            io,
            marks,
            line: Incoming::new(),
            slave: ProgramSlave::new(),
            waits: false,
            overrun: false,
            credit: [0; CREDIT],
            sent: CREDIT as u8,
            power: 0,
        }
    }

    /// Sets the state after a reset: the positions are 0, or unknown as the marks say. Call it
    /// before the main loop.
    pub fn begin(&mut self) {
        if self.marks.begin() {
            self.program.player.mark_unknown();
        }
    }

    /// The player of the frames.
    pub fn player(&mut self) -> &mut StreamPlayer<'q, E, Q, LEN> {
        &mut self.program.player
    }

    fn hear(&mut self, byte: Option<u8>) {
        match self.program.player.hear(byte) {
            Came::Text(byte) if !self.waits => self.waits = self.line.receive(Some(byte)),
            // A line that comes before the answer to the previous one is lost: a host waits for its
            // answer, and frames are never delayed.
            Came::Text(b'\r') => self.overrun = false,
            Came::Text(b'\n') => {}
            Came::Broken | Came::Garbled if !self.waits => self.line.garble(),
            Came::Text(_) | Came::Broken | Came::Garbled => self.overrun = true,
            Came::Called => {
                self.overrun = false;
                // A waiting line is complete.
                if !self.waits {
                    let _ = self.line.take();
                }
            }
            // A frame: the mark is set at a setup, long before the first step.
            Came::Nothing | Came::Frame(..) => {
                self.marks.note(|| self.program.player.may_move());
            }
        }
    }
}

impl<'q, E: Control, I: StreamIo, M: ResetIo, const Q: usize, const LEN: usize> Foreground
    for StreamDevice<'q, E, I, M, Q, LEN>
{
    const LISTENS_MEANWHILE: bool = true;

    #[inline(always)]
    fn tick(&mut self) {
        while self.io.ticked() {
            let inputs = self.io.inputs();
            self.program.player.tick(inputs);
            if self.program.player.is_set_up() {
                self.io.enable();
            }
            self.marks.note(|| self.program.player.may_move());
        }
    }

    #[inline(always)]
    fn is_answering(&mut self) -> bool {
        if usize::from(self.sent) >= CREDIT
            && let Some(credit) = self.program.player.answer()
        {
            (self.credit, self.sent) = (credit.bytes(), 0);
        }
        usize::from(self.sent) < CREDIT || self.slave.is_answering()
    }

    #[inline(always)]
    fn listens(&mut self) -> bool {
        true
    }

    #[inline(always)]
    fn receive(&mut self, byte: u8) {
        self.hear(Some(byte));
    }

    fn garbled(&mut self) {
        self.hear(None);
    }

    fn work(&mut self) {
        if self.waits && !self.slave.is_answering() {
            self.waits = false;
            self.slave.obey(&mut self.line, &mut self.program);
            if core::mem::take(&mut self.overrun) {
                self.line.garble();
            }
        }
    }

    fn next_byte(&mut self) -> Option<u8> {
        match self.credit.get(usize::from(self.sent)) {
            Some(byte) => {
                self.sent = self.sent.wrapping_add(1);
                Some(*byte)
            }
            None => self.slave.next_byte(&mut self.program),
        }
    }

    #[inline(always)]
    fn poll_io(&mut self) {
        let now = self.io.now();
        self.program.player.poll(now);
        let power = self.program.player.laser();
        if I::LASER && power != self.power {
            self.power = power;
            self.io.set_power(power);
        }
    }
}
