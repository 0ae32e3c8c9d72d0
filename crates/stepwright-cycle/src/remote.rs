//! The board's half of the line: lines come in, cycles are played, answers go out.
//!
//! ```text
//!   bytes ─► Incoming ─► hear ─► Cycle ◄── interrupt
//!   bytes ◄─ next_byte ◄─ answer    ▲
//!                                   poll: time, acts on the way, homing
//! ```
//!
//! Without I/O of its own: the same on a chip, whose main loop calls the three, and on the
//! virtual board. The bytes of a line may be taken by an interrupt, so that none is lost while
//! the motors keep the main loop waiting.

use core::cell::Cell;

use stepwright::drive::Drive;
use stepwright::timer::{Count, StepTimer};
use stepwright::units::Ticks;

use super::Cycle;
use super::homing::{Homing, HomingError};
use super::kept::Kept;
use super::line::{
    CycleLine, CycleReport, HOMES, Incoming, LineAct, LineFault, LineProgram, MotorPins, home_code,
};
use super::motor::{Faults, Status};
use super::program::{Leg, Program};
use super::strategy::{CycleError, Refusal};
use super::surroundings::MachineIo;
use stepwright_protocol::{bare, crc, hex};

/// The motors of a board, as its main program has them.
pub trait CycleHold<'a, const N: usize> {
    /// The step timer.
    type Timer: StepTimer;
    /// The drive.
    type Drive: Drive;
    /// Switches and enables.
    type Io: MachineIo;

    /// Does something with the cycle, the step interrupt held off.
    fn with<R>(
        &mut self,
        ask: impl FnOnce(&mut Cycle<'a, Self::Timer, Self::Drive, Self::Io, N>) -> R,
    ) -> R;

    /// Has a motor on these pins from now on, while no cycle runs.
    ///
    /// # Errors
    /// The place of the pin, from 0, that the board has not or that is another's.
    fn wire(&mut self, motor: u8, pins: &MotorPins) -> Result<(), u8>;

    /// A byte of the answer to `?`, without its end.
    fn about(&self, at: u8) -> Option<u8>;
}

/// A board whose N ≤ 8 motors are moved over a line.
pub struct Remote<'a, H: CycleHold<'a, N>, const N: usize> {
    hold: H,
    legs: &'a [Cell<Leg>],
    /// The number of the last cycle, and whether it has yet to end.
    number: u8,
    active: bool,
    /// Since its start, in ticks, and when that was counted.
    time: u64,
    seen: Ticks,
    /// What is to happen on the way, and what has: ticks after the start, one more.
    due: [u64; 3],
    done: [u64; 3],
    /// Faults that were seen, and when.
    faults: [(Faults, u64); N],
    homing: Kept<Option<Homing>, { HOMES as usize }>,
    home: (u8, u32),
    answer: Outgoing<N>,
}

/// An answer that is being sent.
struct Outgoing<const N: usize> {
    what: Saying,
    /// Its parts that were sent.
    part: u8,
    /// The number that is being sent, and its digits that are left.
    number: u64,
    digits: u8,
    /// Its checksum, if it has one.
    sum: Option<u8>,
    /// Positions when it began.
    positions: [i64; N],
    time: u64,
}

#[derive(Clone, Copy)]
enum Saying {
    Nothing,
    About,
    Yes,
    Fault(LineFault),
    Report,
    /// The checksum and the end: its byte.
    Tail(u8),
}

impl<'a, H: CycleHold<'a, N>, const N: usize> Remote<'a, H, N> {
    /// Motors on no pins, and memory for legs.
    pub fn new(hold: H, legs: &'a [Cell<Leg>]) -> Self {
        Remote {
            hold,
            legs,
            number: 0,
            active: false,
            time: 0,
            seen: 0,
            due: [0; 3],
            done: [0; 3],
            faults: [(Faults::NONE, 0); N],
            homing: Kept::new(None),
            home: (0, 0),
            answer: Outgoing {
                what: Saying::Nothing,
                part: 0,
                number: 0,
                digits: 0,
                sum: None,
                positions: [0; N],
                time: 0,
            },
        }
    }

    /// The motors.
    pub fn hold(&mut self) -> &mut H {
        &mut self.hold
    }

    /// The same, to look at.
    pub fn held(&self) -> &H {
        &self.hold
    }

    /// Whether the answer to the last line has been sent.
    pub fn is_free(&self) -> bool {
        matches!(self.answer.what, Saying::Nothing)
    }

    /// Obeys a line that has come to its end, once the answer before it [has been
    /// sent](Remote::is_free).
    #[inline(never)]
    pub fn hear(&mut self, line: &mut Incoming) {
        let (line, summed) = match line.whole().map(checked) {
            None => (Err(LineFault::Sum), true),
            Some(Err(fault)) => (Err(fault), true),
            Some(Ok((text, summed))) => {
                let legs = u16::try_from(self.legs.len()).unwrap_or(u16::MAX);
                (CycleLine::read(text, N as u8, legs), summed)
            }
        };
        let what = match &line {
            Ok(line) => self.carry_out(line),
            Err(fault) => Saying::Fault(*fault),
        };
        self.snapshot();
        self.answer.sum = summed.then_some(0);
        (self.answer.what, self.answer.part, self.answer.digits) = (what, 0, 0);
    }

    /// Where all are now.
    #[inline(never)]
    fn snapshot(&mut self) {
        self.count_time();
        self.answer.time = self.time;
        for (motor, at) in (0u8..).zip(&mut self.answer.positions) {
            // One at a time: the step interrupt is held off for each.
            *at = self.hold.with(|cycle| cycle.position(motor)).unwrap_or(0);
        }
    }

    fn carry_out(&mut self, line: &CycleLine) -> Saying {
        match line {
            CycleLine::Info => return Saying::About,
            CycleLine::Look => return Saying::Report,
            CycleLine::Now(act) => {
                if self.active {
                    self.act(*act);
                }
                return Saying::Yes;
            }
            CycleLine::Start(number) | CycleLine::Home(number, _) if *number == self.number => {
                return Saying::Yes;
            }
            _ => {}
        }
        if self.active {
            return Saying::Fault(LineFault::Refused(Refusal::Running));
        }
        let done = match line {
            CycleLine::Start(number) => {
                self.begin(*number);
                let started = self.hold.with(|cycle| cycle.start());
                self.zero();
                if started.is_err() {
                    (self.active, self.number) = (false, 0);
                }
                started.map_err(LineFault::Refused)
            }
            CycleLine::Home(number, homing) if HOMES => {
                self.begin(*number);
                self.zero();
                self.homing.set(Some(*homing));
                self.home = (1, 0);
                Ok(())
            }
            line => self.set_up(line),
        };
        match done {
            Ok(()) => Saying::Yes,
            Err(fault) => Saying::Fault(fault),
        }
    }

    /// What is said before a cycle. Out of line: a start has the stack for itself.
    #[inline(never)]
    fn set_up(&mut self, line: &CycleLine) -> Result<(), LineFault> {
        let done = match line {
            CycleLine::New => {
                self.due = [0; 3];
                self.homing.set(None);
                self.hold.with(|cycle| cycle.forget())
            }
            CycleLine::Clock(clock, strategies) => {
                let (clock, strategies) = (*clock, *strategies);
                self.hold.with(|cycle| {
                    cycle.set_strategies(strategies);
                    cycle.set_clock(clock)
                })
            }
            CycleLine::Wire(motor, pins) => {
                if let Err(place) = self.hold.wire(*motor, pins) {
                    return Err(LineFault::Pin { number: place.wrapping_add(2) });
                }
                self.hold.with(|cycle| cycle.rewired(*motor));
                Ok(())
            }
            CycleLine::Motor(motor, what) => self.hold.with(|cycle| cycle.set_motor(*motor, *what)),
            CycleLine::Position(motor, at) => {
                self.hold.with(|cycle| cycle.set_position(*motor, *at))
            }
            CycleLine::Leg(at, leg) => {
                if let Some(place) = self.legs.get(usize::from(*at)) {
                    place.set(*leg);
                }
                Ok(())
            }
            CycleLine::Prepare(motor, calibration, program) => {
                let program = match *program {
                    LineProgram::Steps { count, delay } => Program::Steps { count, delay },
                    LineProgram::Whirl { forward, delay } => Program::Whirl { forward, delay },
                    LineProgram::Ramp { steps, forward, ramp } => {
                        Program::Ramp { steps, forward, ramp }
                    }
                    LineProgram::Legs { first, count } => {
                        let (first, count) = (usize::from(first), usize::from(count));
                        let legs = self.legs.get(first..).unwrap_or_default();
                        Program::Stored(legs.get(..count).unwrap_or_default())
                    }
                };
                self.hold.with(|cycle| cycle.prepare(*motor, program, *calibration))
            }
            CycleLine::Act(act, ticks) => {
                if let Some(due) = self.due.get_mut(*act as usize) {
                    *due = ticks.saturating_add(1);
                }
                Ok(())
            }
            _ => return Err(LineFault::Unknown),
        };
        done.map_err(LineFault::Refused)
    }

    /// A cycle of this number begins.
    fn begin(&mut self, number: u8) {
        (self.number, self.active) = (number, true);
        (self.done, self.home) = ([0; 3], (0, 0));
        // A motor that takes no part keeps those of its last cycle.
        for (motor, known) in (0u8..).zip(&mut self.faults) {
            *known = (self.hold.with(|cycle| cycle.faults(motor)), 0);
        }
    }

    /// Its time is 0 now.
    fn zero(&mut self) {
        self.seen = self.now();
        self.time = 0;
    }

    /// The timer's count.
    fn now(&mut self) -> Ticks {
        self.hold.with(|cycle| cycle.timer().now().since(<H::Timer as StepTimer>::Count::ZERO.0))
            as Ticks
    }

    /// Counts the time until now, less than a turn of the counter.
    #[inline(never)]
    fn count_time(&mut self) {
        let now = self.now();
        let turn = (<H::Timer as StepTimer>::Count::HOP << 2).wrapping_sub(1);
        if self.active {
            self.time = self.time.wrapping_add((now.wrapping_sub(self.seen) & turn).into());
        }
        self.seen = now;
    }

    /// What the main program does now and then: at least each half turn of the timer's counter,
    /// and as often as acts on the way are to be exact.
    #[inline(never)]
    pub fn poll(&mut self) {
        self.count_time();
        if !self.active {
            return;
        }
        let time = self.time.wrapping_add(1);
        for act in LineAct::ALL {
            let due = self.due.get_mut(act as usize);
            if let Some(due) = due
                && *due != 0
                && *due <= time
            {
                *due = 0;
                self.act(act);
            }
        }
        // First, so that of a cycle that is over every fault is seen.
        let running = self.hold.with(|cycle| cycle.is_running());
        for (motor, (known, at)) in (0u8..).zip(&mut self.faults) {
            let faults = self.hold.with(|cycle| cycle.faults(motor));
            if faults != *known {
                (*known, *at) = (faults, time);
            }
        }
        if running {
            return;
        }
        if let Some(mut homing) = self.homing.get() {
            let done = self.hold.with(|cycle| homing.poll(cycle));
            self.homing.set(Some(homing));
            self.home = match done {
                Ok(false) => return,
                Ok(true) => (2, 0),
                Err(HomingError::NotFound) => (3, 0),
                Err(HomingError::StillClosed) => (4, 0),
                Err(HomingError::Cancelled(..)) => (5, 0),
                Err(HomingError::Refused(refusal)) => home_code(refusal),
            };
            self.homing.set(None);
        }
        self.active = false;
    }

    /// Something happens to the cycle now.
    fn act(&mut self, act: LineAct) {
        let finish = matches!(act, LineAct::Finish);
        if finish && self.homing.take().is_some() {
            self.home = (5, 0);
        }
        let done = self.hold.with(|cycle| match act {
            LineAct::Pause => cycle.pause(),
            LineAct::Resume => cycle.resume(),
            LineAct::Finish => {
                let running = cycle.is_running();
                cycle.finish();
                if running { Ok(()) } else { Err(Refusal::NotRunning) }
            }
        });
        self.count_time();
        let time = self.time.wrapping_add(1);
        if let Some(at) = self.done.get_mut(act as usize)
            && done.is_ok()
        {
            *at = time;
        }
    }

    /// The maximum of a motor: of one that rests, for it takes too long to be asked for between
    /// two steps.
    fn max(&mut self, motor: u8) -> Option<i64> {
        if self.active { None } else { self.hold.with(|cycle| cycle.motor(motor))?.max }
    }

    /// A number of the report.
    fn number(&mut self, part: u8) -> Option<i64> {
        let whole = |number: u64| number as i64;
        let Some(place) = part.checked_sub(CycleReport::HEAD) else {
            return Some(match part {
                0 => self
                    .hold
                    .with(|cycle| match (cycle.is_running(), cycle.is_paused()) {
                        (_, true) => 2,
                        (true, _) => 1,
                        _ => 0,
                    })
                    .max(self.active.into()),
                1 => self.number.into(),
                2 => whole(self.answer.time),
                3 => match self.hold.with(|cycle| cycle.error()) {
                    None => 0,
                    Some(CycleError::TimingExceeded) => 1,
                    Some(CycleError::MotorError { motor }) => i64::from(motor) + 2,
                },
                4 => self.hold.with(|cycle| cycle.late()).into(),
                5 => self.hold.with(|cycle| cycle.longest()).into(),
                6..=8 => whole(self.done.get(usize::from(part - 6)).copied().unwrap_or(0)),
                9 => self.home.0.into(),
                _ => self.home.1.into(),
            });
        };
        let (motor, which) = (place / CycleReport::EACH, place % CycleReport::EACH);
        let n = usize::from(motor);
        let (faults, fault_at) = *self.faults.get(n)?;
        Some(match which {
            0 => {
                let status = match self.hold.with(|cycle| cycle.status(motor)) {
                    Status::Idle => 0,
                    Status::Running => 1,
                    Status::Finished => 2,
                };
                status + if self.max(motor).is_some() { 4 } else { 0 }
            }
            1 => faults.bits().into(),
            2 => whole(fault_at),
            3 => self.answer.positions.get(n).copied().unwrap_or(0),
            _ => self.max(motor).unwrap_or(0),
        })
    }

    /// The next byte to be sent, if there is one.
    #[inline(never)]
    pub fn next_byte(&mut self) -> Option<u8> {
        let byte = self.next_plain()?;
        if let Some(sum) = &mut self.answer.sum {
            *sum = crc(*sum, byte);
        }
        Some(byte)
    }

    fn next_plain(&mut self) -> Option<u8> {
        if let Some(left) = self.answer.digits.checked_sub(1) {
            self.answer.digits = left;
            let bytes = self.answer.number.to_le_bytes();
            let byte = bytes.get(usize::from(left / 2)).copied().unwrap_or(0);
            return Some(hex(if left.is_multiple_of(2) { byte } else { byte >> 4 }));
        }
        let part = self.answer.part;
        self.answer.part = part.wrapping_add(1);
        let number = match self.answer.what {
            Saying::Nothing => return None,
            Saying::About => match self.hold.about(part) {
                Some(byte) => return Some(byte),
                None => None,
            },
            Saying::Yes if part == 0 => return Some(b'Y'),
            Saying::Yes => None,
            Saying::Fault(_) if part == 0 => return Some(b'E'),
            // A number, a comma, a number …
            Saying::Fault(_) if part.is_multiple_of(2) => return self.comma(part < 8),
            Saying::Fault(fault) => fault.numbers().get(usize::from(part / 2)).copied(),
            Saying::Report if part % 2 == 1 => {
                let all = CycleReport::HEAD + CycleReport::EACH * N as u8;
                return self.comma(part / 2 + 1 < all);
            }
            Saying::Report => self.number(part / 2),
            Saying::Tail(at) => return self.tail(at),
        };
        match number {
            None => self.comma(false),
            Some(number) => {
                let (size, mut digits) = (number.unsigned_abs(), 16u8);
                let bytes = size.to_le_bytes();
                while digits > 1 {
                    let byte = bytes.get(usize::from((digits - 1) / 2)).copied().unwrap_or(0);
                    if (if digits.is_multiple_of(2) { byte >> 4 } else { byte & 15 }) != 0 {
                        break;
                    }
                    digits -= 1;
                }
                (self.answer.number, self.answer.digits) = (size, digits);
                if number < 0 { Some(b'-') } else { self.next_plain() }
            }
        }
    }

    /// A comma, or the end of the line.
    fn comma(&mut self, more: bool) -> Option<u8> {
        if more {
            return Some(b',');
        }
        self.answer.what = Saying::Tail(if self.answer.sum.is_some() { 0 } else { 3 });
        self.next_plain()
    }

    /// `*`, two digits, a carriage return.
    fn tail(&mut self, at: u8) -> Option<u8> {
        self.answer.what = if at < 3 { Saying::Tail(at + 1) } else { Saying::Nothing };
        let sum = self.answer.sum;
        if at == 0 {
            // What follows is not summed.
            self.answer.number = sum.unwrap_or(0).into();
            self.answer.sum = None;
        }
        let sum = self.answer.number as u8;
        Some(match at {
            0 => b'*',
            1 => hex(sum >> 4),
            2 => hex(sum),
            _ => b'\r',
        })
    }
}

/// A line without its checksum, and whether it had one.
fn checked(line: &[u8]) -> Result<(&[u8], bool), LineFault> {
    bare(line).ok_or(LineFault::Sum)
}
