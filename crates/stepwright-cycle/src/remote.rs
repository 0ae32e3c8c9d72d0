//! The board's half of the line: reads lines, plays cycles, answers.
//!
//! ```text
//!   bytes ─► Incoming ─► ProgramSlave ─► Remote ─► Cycle ◄── interrupt
//!   bytes ◄──────────────── answer ◄────────┘  ▲
//!                              poll: time, acts on the way, homing
//! ```
//!
//! It does no I/O: the same on a chip and on the virtual board. An interrupt may receive the bytes
//! of a line, so that none is lost while the motors keep the main loop waiting.

use core::cell::Cell;

use stepwright::drive::Drive;
use stepwright::timer::{Count, StepTimer};
use stepwright::units::Ticks;

use super::Cycle;
use super::homing::{Homing, HomingError};
use super::kept::Kept;
use super::line::{
    CycleFault, CycleLine, CycleReport, HOMES, LineAct, LineProgram, MotorPins, home_code,
};
use super::motor::{Faults, Status};
use super::program::{Leg, Program};
use super::strategy::{CycleError, Refusal};
use super::surroundings::MachineIo;
use stepwright_protocol::{BoardProgram, Fault, Numbers, Piece, Said, Text, flash_text};

/// The motors of a board, as its main program holds them.
pub trait CycleHold<'a, const N: usize> {
    /// The step timer.
    type Timer: StepTimer;
    /// The drive.
    type Drive: Drive;
    /// The switches and enables.
    type Io: MachineIo;

    /// Calls `ask` with the cycle while the step interrupt is held off.
    fn with<R>(
        &mut self,
        ask: impl FnOnce(&mut Cycle<'a, Self::Timer, Self::Drive, Self::Io, N>) -> R,
    ) -> R;

    /// Moves a motor to these pins, while no cycle runs.
    ///
    /// # Errors
    /// The index of the pin, from 0, that the board does not have or that is in use.
    fn wire(&mut self, motor: u8, pins: &MotorPins) -> Result<(), u8>;

    /// The answer to `?` up to its `can=`, and the words of `can=`.
    fn about(&self) -> (Text, Text);
}

/// A board whose N ≤ 8 motors are moved over a line.
pub struct Remote<'a, H: CycleHold<'a, N>, const N: usize> {
    hold: H,
    legs: &'a [Cell<Leg>],
    /// The number of the last cycle, and whether it is still active.
    number: u8,
    active: bool,
    /// Ticks since the start of the cycle, and the count at which they were last updated.
    time: u64,
    seen: Ticks,
    /// The times of the acts that are still due, and of those done: ticks after the start, plus 1.
    due: [u64; 3],
    done: [u64; 3],
    /// The faults seen, and when.
    faults: [(Faults, u64); N],
    homing: Kept<Option<Homing>, { HOMES as usize }>,
    home: Kept<(u8, u32), { HOMES as usize }>,
    /// Motors whose position is unknown after a kill or a reset.
    lost: u8,
    /// The moment of the report, whose numbers are computed while the line is sent: the low bits of
    /// the time and of the step count of each motor.
    moment: u32,
    counts: [u32; N],
}

impl<'a, H: CycleHold<'a, N>, const N: usize> Remote<'a, H, N> {
    /// Motors without pins, and memory for legs.
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
            home: Kept::new((0, 0)),
            lost: 0,
            moment: 0,
            counts: [0; N],
        }
    }

    /// The access to the motors.
    pub fn hold(&mut self) -> &mut H {
        &mut self.hold
    }

    /// Records the time and the step counts of all motors.
    #[inline(never)]
    fn snapshot(&mut self) {
        self.count_time();
        self.moment = self.time as u32;
        for (motor, count) in (0u8..).zip(&mut self.counts) {
            // One motor at a time: the step interrupt is held off for each.
            *count = self.hold.with(|cycle| cycle.count(motor));
        }
    }

    /// Carries out a row that prepares a cycle. Out of line, so that a start has the stack for
    /// itself.
    #[inline(never)]
    fn set_up(&mut self, line: &CycleLine) -> Result<(), CycleFault> {
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
                    let number = place.wrapping_add(2);
                    return Err(CycleFault::Pin { number });
                }
                self.hold.with(|cycle| cycle.rewired(*motor));
                Ok(())
            }
            CycleLine::Motor(motor, what) => self.hold.with(|cycle| cycle.set_motor(*motor, *what)),
            CycleLine::Position(motor, at) => {
                self.lost &= !(1 << *motor);
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
            // The rows that begin a cycle, and those for a running one.
            _ => Ok(()),
        };
        done.map_err(CycleFault::Refused)
    }

    /// Begins a cycle with this number.
    fn begin(&mut self, number: u8) {
        (self.number, self.active) = (number, true);
        self.done = [0; 3];
        self.home.set((0, 0));
        // A motor that takes no part keeps the faults of its last cycle.
        for (motor, known) in (0u8..).zip(&mut self.faults) {
            *known = (self.hold.with(|cycle| cycle.faults(motor)), 0);
        }
    }

    /// Sets the time to 0.
    fn zero(&mut self) {
        self.seen = self.now();
        self.time = 0;
    }

    /// The count of the timer.
    fn now(&mut self) -> Ticks {
        self.hold.with(|cycle| cycle.timer().now().since(<H::Timer as StepTimer>::Count::ZERO.0))
            as Ticks
    }

    /// Adds the time until now, which is less than a turn of the counter.
    #[inline(never)]
    fn count_time(&mut self) {
        let now = self.now();
        let turn = (<H::Timer as StepTimer>::Count::HOP << 2).wrapping_sub(1);
        if self.active {
            self.time = self.time.wrapping_add((now.wrapping_sub(self.seen) & turn).into());
        }
        self.seen = now;
    }

    /// Applies an act to the cycle now.
    fn act(&mut self, act: LineAct) {
        let finish = matches!(act, LineAct::Finish);
        if finish && self.homing.take().is_some() {
            self.home.set((5, 0));
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

    /// The maximum of a motor at rest; computing it takes too long between two steps.
    fn max(&mut self, motor: u8) -> Option<i64> {
        if self.active { None } else { self.hold.with(|cycle| cycle.motor(motor))?.max }
    }
}

impl<'a, H: CycleHold<'a, N>, const N: usize> BoardProgram for Remote<'a, H, N> {
    type Row = CycleLine;
    type Reason = CycleFault;

    fn about(&mut self, n: u8) -> Option<Piece> {
        let (about, can) = self.hold.about();
        Some(match n {
            0 => Piece::Text(about),
            1 => Piece::Text(flash_text!(" late=")),
            2 => Piece::Number(self.hold.with(|cycle| cycle.late())),
            3 => Piece::Text(flash_text!(" can=sum")),
            4 => Piece::Text(can),
            _ => return None,
        })
    }

    fn axes(&self) -> u8 {
        N as u8
    }

    fn read(&self, letter: u8, numbers: &mut Numbers<'_>) -> Option<CycleLine> {
        let legs = u16::try_from(self.legs.len()).unwrap_or(u16::MAX);
        CycleLine::read(letter, numbers, N as u8, legs)
    }

    // In the frame of its caller, so that a start has the stack for itself.
    #[inline(always)]
    fn carry_out(&mut self, line: &CycleLine) -> Result<Said, Fault<CycleFault>> {
        match line {
            CycleLine::Look => {
                self.snapshot();
                return Ok(Said::Report);
            }
            CycleLine::Now(act) => {
                if self.active {
                    self.act(*act);
                }
                return Ok(Said::Yes);
            }
            CycleLine::Start(number) | CycleLine::Home(number, _) if *number == self.number => {
                return Ok(Said::Yes);
            }
            _ => {}
        }
        if self.active {
            return Err(Fault::Busy);
        }
        match line {
            CycleLine::Start(number) => {
                self.begin(*number);
                let started = self.hold.with(|cycle| cycle.start());
                self.zero();
                if let Err(refusal) = started {
                    (self.active, self.number) = (false, 0);
                    return Err(Fault::Own(CycleFault::Refused(refusal)));
                }
            }
            CycleLine::Home(number, homing) if HOMES => {
                self.begin(*number);
                self.zero();
                self.homing.set(Some(*homing));
                self.home.set((1, 0));
            }
            line => self.set_up(line).map_err(Fault::Own)?,
        }
        Ok(Said::Yes)
    }

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
                2 => {
                    let since = (self.time as u32).wrapping_sub(self.moment);
                    whole(self.time.wrapping_sub(since.into()))
                }
                3 => match self.hold.with(|cycle| cycle.error()) {
                    None => 0,
                    Some(CycleError::TimingExceeded) => 1,
                    Some(CycleError::MotorError { motor }) => i64::from(motor) + 2,
                },
                4 => self.hold.with(|cycle| cycle.late()).into(),
                5 => self.hold.with(|cycle| cycle.longest()).into(),
                6..=8 => whole(self.done.get(usize::from(part - 6)).copied().unwrap_or(0)),
                9 => self.home.get().0.into(),
                _ => self.home.get().1.into(),
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
                let lost = i64::from(self.lost >> motor & 1);
                status + if self.max(motor).is_some() { 4 } else { 0 } + 8 * lost
            }
            1 => faults.bits().into(),
            2 => whole(fault_at),
            3 => {
                let count = self.counts.get(n).copied().unwrap_or(0);
                self.hold.with(|cycle| cycle.position_at(motor, count)).unwrap_or(0)
            }
            _ => self.max(motor).unwrap_or(0),
        })
    }

    fn is_busy(&mut self) -> bool {
        self.active
    }

    fn position(&mut self, axis: u8) -> Option<i64> {
        if self.lost >> axis & 1 != 0 {
            return None;
        }
        self.hold.with(|cycle| cycle.position(axis))
    }

    fn set_zero(&mut self, axis: u8) {
        self.lost &= !(1 << axis);
        // The axis is at rest, and the motor exists.
        let _ = self.hold.with(|cycle| cycle.set_position(axis, 0));
    }

    fn mark_unknown(&mut self) {
        self.lost = u8::MAX;
    }

    fn stop(&mut self) {
        if self.active {
            self.act(LineAct::Finish);
        }
    }

    fn kill(&mut self) {
        for motor in 0..N as u8 {
            if self.hold.with(|cycle| cycle.status(motor)) == Status::Running {
                self.lost |= 1 << motor;
            }
        }
        self.stop();
    }

    /// Call it at least each half turn of the timer's counter, and as often as acts during a cycle
    /// must be exact.
    #[inline(never)]
    fn poll(&mut self) {
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
        // Read first, so that every fault of a finished cycle is seen.
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
            self.home.set(match done {
                Ok(false) => return,
                Ok(true) => {
                    self.lost &= !(1 << homing.motor);
                    (2, 0)
                }
                Err(HomingError::NotFound) => (3, 0),
                Err(HomingError::StillClosed) => (4, 0),
                Err(HomingError::Cancelled(..)) => (5, 0),
                Err(HomingError::Refused(refusal)) => home_code(refusal),
            });
            self.homing.set(None);
        }
        self.active = false;
        // Acts that are still due are not for the next cycle.
        self.due = [0; 3];
    }
}
