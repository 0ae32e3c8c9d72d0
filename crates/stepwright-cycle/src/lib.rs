#![no_std]
#![forbid(unsafe_code)]
//! Motor cycles: several stepper motors at once, each with a program of its own, from one
//! timer.
//!
//! A *cycle* is one movement of all motors together. Each motor is given a [`Program`]: a number of
//! steps, steps without end, a list or series of delays, a callback, or steps that were planned
//! elsewhere. After its start the cycle runs in the step interrupt while the main program does
//! other work, and ends when all programs are over. It can be paused, resumed and finished early; a
//! limit switch, a bound or a late step ends it or stops one motor, according to its
//! [`Strategies`]. Positions have 64 bits, in the user's own unit, usually nanometres.
//!
//! ```
//! use stepwright::Rate;
//! use stepwright_cycle::{Calibration, Clock, Motor, Program};
//! use stepwright_sim::{CycleBoard, Edge, Stand};
//!
//! // Two motors on the virtual board: 7500 nm a step, at most a step each 1000 µs.
//! let motor = Motor::new(7_500, 1_000);
//! let mut board: CycleBoard<Vec<Edge>, 2> = CycleBoard::new(
//!     [motor; 2],
//!     [Stand::default(); 2],
//!     Clock::Deadlines,
//!     Rate::from_hz(16_000_000)?,
//!     Vec::new(),
//! );
//!
//! // 2000 steps forward in 2 s, and 500 steps back in the same time.
//! let cycle = board.cycle();
//! cycle.prepare(0, Program::Steps { count: 2_000, delay: 1_000 }, Calibration::None)?;
//! cycle.prepare(1, Program::Steps { count: -500, delay: 4_000 }, Calibration::None)?;
//! cycle.start()?;
//!
//! board.run_to_rest();
//! assert_eq!(board.cycle().position(0), Some(15_000_000)); // nm
//! assert_eq!(board.cycle().position(1), Some(-3_750_000));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! On a chip [`Cycle::new`] takes the chip's timer, a drive and the pins around the motors, and the
//! step interrupt calls [`Cycle::on_compare`]; the rest is the same. The program `cycle` of
//! Stepwright's AVR firmware is a complete example for an Arduino Uno or Mega.
//!
//! # The way of the data
//!
//! ```text
//!        foreground         │               step interrupt
//!                           │
//!  Program ─► prepare ─► start ─► ProgramRunner ─► run ─► Engine ─► Drive ─► pins
//!  (steps, list, series,    │   next leg,        deadlines  STEP,
//!   callback, paced)        │   bounds, brake               DIR
//!                           │       ▲
//!  Strategies ──────────────┼───────┤
//!  MachineIo: switches ──┼───────┘
//!                           │
//!  position · status · faults ◄──── steps counted where they are made
//! ```
//!
//! The engine, the drives and the timer are those of the crate [`stepwright`]. The engine asks a
//! motor's program for the next run when the previous run is made. A run is a leg, or 65,535 steps
//! of it: steps at one delay cost next to nothing, and steps from a callback cost what the callback
//! takes.
//!
//! # Source
//!
//! The documentation of [stepper_h](https://github.com/1i7/stepper_h), a library for ChipKIT and
//! Arduino that moves several motors from one timer. This crate has its behaviour and its numbers,
//! but none of its code, which is under the LGPL.
//!
//! | stepper_h | here |
//! | --- | --- |
//! | `init_stepper`, `init_stepper_ends` | [`Motor`] |
//! | `prepare_steps`, `prepare_whirl` … | [`Cycle::prepare`] with a [`Program`] |
//! | `calibrate_mode_t` | [`Calibration`] |
//! | `stepper_start_cycle`, `_finish_`, `_pause_`, `_resume_` | [`start`](Cycle::start), [`finish`](Cycle::finish), [`pause`](Cycle::pause), [`resume`](Cycle::resume) |
//! | `stepper_cycle_running`, `_paused`, `_error` | [`is_running`](Cycle::is_running), [`is_paused`](Cycle::is_paused), [`error`](Cycle::error) |
//! | `stepper_cycle_max_time` | [`longest`](Cycle::longest) |
//! | `stepper_set_error_handle_strategy` | [`Strategies`] |
//! | `smotor.status`, `.error`, `.current_pos` | [`status`](Cycle::status), [`faults`](Cycle::faults), [`position`](Cycle::position) |
//! | the timer's period | [`Clock`] |
//!
//! # What holds
//!
//! **Two clocks, one engine.** By default every step has its own deadline: no delay need be a
//! multiple of anything, and motors of unrelated speeds don't disturb each other. [`Clock::Tick`]
//! is stepper_h's fixed tick: the same engine with deadlines rounded down to the tick, and three
//! passes per step. [`Clock::Grid`] has the same steps in one pass each, for a small chip.
//!
//! **Motors are independent.** A motor that stops, or cancels the cycle, costs no other motor a
//! step that is due at that moment, and moves none of its edges.
//!
//! **Switches are latched.** They are read before every event of any motor, and whenever
//! [`look`](Cycle::look) is called (from a pin's interrupt); the position where a switch closed is
//! kept. A motor that moves towards a closed switch makes no further step. A motor that moves away
//! from it continues, and one that waits or has arrived has no fault. Optionally a motor brakes
//! there ([`AtHardEnd`]) and counts the steps that it makes beyond.

mod brake;
mod clock;
mod ends;
mod homing;
mod kept;
pub mod line;
mod motor;
mod pause;
mod player;
mod program;
mod remote;
mod report;
mod runs;
mod strategy;
mod surroundings;
mod wide;
mod wiring;

pub use clock::Clock;
pub use homing::{Homing, HomingError};
pub use motor::{Calibration, End, Faults, Motor, Status};
pub use program::{DelayRamp, Leg, NextDelay, Pace, Paces, Program};
pub use remote::{CycleHold, Remote};
pub use runs::RunCost;
pub use strategy::{AtHardEnd, AtSmallDelay, AtSoftEnd, AtTiming, CycleError, Refusal, Strategies};
pub use surroundings::{MachineIo, MotorIo, Switches, Wires};

use brake::BRAKES;
use clock::{Beat, GRID, TICKS};
use pause::Pause;
use player::{ProgramRunner, Verdict};
use program::{PACED, RUNS, Reader};
use stepwright::Board;
use stepwright::drive::{Axes, Drive};
use stepwright::engine::{Engine, Timing};
use stepwright::queue::Asked;
use stepwright::timer::{Count, StepTimer};
use stepwright::units::Ticks;
use wiring::Wiring;

/// N ≤ 8 motors and their cycle.
///
/// Belongs to the step interrupt, which calls [`on_compare`](Cycle::on_compare), like an
/// [`Engine`]; the foreground calls the other methods, with that interrupt held off.
pub struct Cycle<'a, T: StepTimer, D, S, const N: usize> {
    engine: Engine<T, Wiring<D>, Asked<ProgramRunner<'a>>, N>,
    surroundings: S,
    strategies: Strategies,
    board: Board<N>,
    beat: Beat,
    state: State<T::Count, N>,
    error: Option<CycleError>,
    /// The switches that were closed at the last read.
    seen: Switches,
    /// The positions where the switches closed: minimum and maximum of each motor.
    triggers: [[Option<i64>; 2]; N],
    late: u32,
    longest: Ticks,
    runs: Option<RunCost>,
    /// The ticks that a turn takes.
    turn: Ticks,
}

enum State<C: Count, const N: usize> {
    Rest,
    Running,
    Paused(Pause<C, N>),
}

impl<'a, T: StepTimer, D: Drive, S: MachineIo, const N: usize> Cycle<'a, T, D, S, N> {
    /// All motors at position 0, facing forward, with their drivers off.
    pub fn new(
        timer: T,
        drive: D,
        surroundings: S,
        motors: [Motor; N],
        clock: Clock,
        board: Board<N>,
    ) -> Self {
        let mut cycle = Cycle::off(timer, drive, surroundings, motors, clock, board);
        cycle.begin();
        cycle
    }

    /// Motors before [`begin`](Cycle::begin): a constant, for a static cycle, because a small chip
    /// has no room for a second one while it is moved there.
    pub const fn off(
        timer: T,
        drive: D,
        surroundings: S,
        motors: [Motor; N],
        clock: Clock,
        board: Board<N>,
    ) -> Self {
        let beat = Beat::new(clock, board.rate);
        let wide = TICKS && matches!(clock, Clock::Tick { .. });
        let timing = if wide { ON_TICKS } else { board.timing };
        let mut players = [const { Asked::new(ProgramRunner::IDLE) }; N];
        let (mut inverted, mut n): (Axes, usize) = (0, 0);
        while n < N {
            players[n] = Asked::new(ProgramRunner::new(motors[n], beat, timing.hold));
            inverted |= (motors[n].inverted as Axes) << (n & 7);
            n += 1;
        }
        Cycle {
            engine: Engine::off(
                timer,
                Wiring::new(drive, inverted, wide),
                players,
                timing,
                board.rate,
            ),
            surroundings,
            strategies: Strategies::CANCEL,
            board,
            beat,
            state: State::Rest,
            error: None,
            seen: Switches::NONE,
            triggers: [[None; 2]; N],
            late: 0,
            longest: 0,
            runs: None,
            turn: 0,
        }
    }

    /// This cycle with a turn that takes this many ticks: a leg that turns must have at least that
    /// delay, and twice that if two motors turn, unless steps may be late.
    pub const fn with_turns(mut self, ticks: Ticks) -> Self {
        self.turn = ticks;
        self
    }

    /// Sets all directions forward and the drivers off, and waits for a cycle.
    pub fn begin(&mut self) {
        self.engine.begin();
        self.surroundings.enable(0);
    }

    /// Changes the description of a motor. Its position stays.
    ///
    /// # Errors
    /// [`Refusal::Running`] while a cycle runs; [`Refusal::NoMotor`].
    pub fn set_motor(&mut self, motor: u8, what: Motor) -> Result<(), Refusal> {
        if self.is_running() {
            return Err(Refusal::Running);
        }
        let steps = self.steps(motor);
        let player = self.player(motor).ok_or(Refusal::NoMotor)?;
        // Steps made until now count with the old description.
        player.settle(steps);
        player.motor = what;
        let forward = self.engine.report(motor).forward;
        self.engine.drive().set_inverted(motor, what.inverted, forward);
        Ok(())
    }

    /// Called after the drive has moved a motor to other pins: sets its direction there.
    pub fn rewired(&mut self, motor: u8) {
        let forward = self.engine.report(motor).forward;
        self.engine.drive().tell_again(motor, forward);
    }

    /// Sets the clock.
    ///
    /// # Errors
    /// [`Refusal::Running`] while a cycle runs; [`Refusal::NoTick`] if the fixed tick is not
    /// compiled in.
    pub fn set_clock(&mut self, clock: Clock) -> Result<(), Refusal> {
        if self.is_running() {
            return Err(Refusal::Running);
        }
        let has = match clock {
            Clock::Deadlines => true,
            Clock::Tick { .. } => TICKS,
            Clock::Grid { .. } => GRID,
        };
        if !has {
            return Err(Refusal::NoTick);
        }
        if !TICKS && !GRID {
            return Ok(());
        }
        self.beat = Beat::new(clock, self.board.rate);
        let wide = self.beat.is_fixed();
        let timing = if wide { ON_TICKS } else { self.board.timing };
        self.engine.drive().wide = wide;
        self.engine.set_timing(timing);
        let beat = self.beat;
        self.engine.feeds().for_each(|player| player.set_beat(beat, timing.hold));
        Ok(())
    }

    /// Forgets the prepared programs.
    ///
    /// # Errors
    /// [`Refusal::Running`] while a cycle runs.
    pub fn forget(&mut self) -> Result<(), Refusal> {
        if self.is_running() {
            return Err(Refusal::Running);
        }
        self.engine.feeds().for_each(ProgramRunner::forget);
        Ok(())
    }

    /// Sets the reactions to faults, for cycles that start from now on.
    pub fn set_strategies(&mut self, strategies: Strategies) {
        self.strategies = strategies;
    }

    /// Sets the program of a motor for the next cycle.
    ///
    /// # Errors
    /// [`Refusal::Running`] while a cycle runs; [`Refusal::NoMotor`].
    pub fn prepare(
        &mut self,
        motor: u8,
        program: Program<'a>,
        calibration: Calibration,
    ) -> Result<(), Refusal> {
        if self.is_running() {
            return Err(Refusal::Running);
        }
        let steps = self.steps(motor);
        let player = self.player(motor).ok_or(Refusal::NoMotor)?;
        player.settle(steps);
        player.prepare(Reader::of(program), calibration);
        Ok(())
    }

    /// Starts all prepared motors together.
    ///
    /// # Errors
    /// [`Refusal`], with the values that the clock needs; nothing moves then. The programs stay
    /// prepared, unless a first delay was too small.
    pub fn start(&mut self) -> Result<(), Refusal> {
        if self.is_running() {
            return Err(Refusal::Running);
        }
        self.check()?;
        self.set_pace();
        self.error = None;
        self.engine.clear_late();
        (self.late, self.longest) = (0, 0);
        let mut axes: Axes = 0;
        for motor in 0..N as u8 {
            let (steps, strategies) = (self.steps(motor), self.strategies);
            let Some(player) = self.player(motor) else { continue };
            if player.is_ready() {
                player.begin(steps, strategies);
                axes |= 1 << motor;
            } else {
                player.settle(steps);
                player.calibration = Calibration::None;
                player.status = Status::Idle;
            }
        }
        self.state = State::Running;
        self.engine.start_when_loaded(axes);
        if let Some(motor) = self.canceller() {
            // Found in the first part of a program: nothing has moved.
            self.stop();
            for player in self.engine.feeds() {
                player.status = Status::Idle;
            }
            let needs = self.player(motor).map_or(0, |player| player.motor.smallest_delay);
            return Err(Refusal::SmallDelay { motor, needs });
        }
        self.surroundings.enable(axes);
        if self.beat.is_fixed() {
            // Events that are due at once belong to tick 0.
            self.engine.on_compare();
        }
        self.after();
        Ok(())
    }

    /// Checks the requirements of the clock, motor by motor.
    fn check(&mut self) -> Result<(), Refusal> {
        let (timing, board) = (self.board.timing, self.board);
        let (fixed, period) = (self.beat.is_fixed(), self.beat.period());
        let ticks = fixed || self.beat.is_grid();
        let (mut moving, mut turning) = (0usize, 0u32);
        for player in self.engine.feeds().filter(|player| player.is_ready()) {
            moving = moving.saturating_add(player.fastest().is_some().into());
            turning = turning.wrapping_add(player.fastest_turn().is_some().into());
        }
        let on_time = self.strategies.timing == AtTiming::Cancel;
        let turn = if on_time { self.beat.micros(self.turn.wrapping_mul(turning)) } else { 0 };
        if !self.engine.feeds().any(|player| player.is_ready()) {
            return Err(Refusal::Nothing);
        }
        if self.strategies.hard_end.brakes() {
            if !BRAKES {
                return Err(Refusal::NoBrakes);
            }
            let mut motors = (0u8..).zip(self.engine.feeds());
            if let Some((motor, _)) = motors.find(|(_, p)| p.is_ready() && p.motor.decel == 0) {
                return Err(Refusal::NeedsDecel { motor });
            }
        }
        let cost = board.step_cost(moving).min(u32::MAX >> FULL) << FULL;
        let least = timing.min_interval.max(timing.hold.saturating_add(timing.setup));
        let least = self.beat.micros(least).max(1);
        let mut load = 0u32;
        for (motor, player) in (0u8..).zip(self.engine.feeds()) {
            let Some(fastest) = player.fastest().filter(|_| player.is_ready()) else { continue };
            let smallest = player.motor.smallest_delay;
            if player.has_own_paces() && !PACED {
                return Err(Refusal::NoPaths { motor });
            }
            if ticks {
                if player.is_paced() {
                    return Err(Refusal::NeedsDeadlines { motor });
                }
                let floor = period.saturating_mul(3);
                let next = smallest.div_ceil(period.max(1)).saturating_mul(period);
                if smallest < floor {
                    return Err(Refusal::PeriodTooLong { motor, needs: floor });
                }
                if next != smallest {
                    return Err(Refusal::PeriodAliquant { motor, needs: next });
                }
            }
            if fixed {
                continue;
            }
            let (mut cost, mut least) = (cost, least);
            if RUNS && player.is_paced() && !player.has_own_paces() {
                if fastest < smallest {
                    return Err(Refusal::SmallDelay { motor, needs: smallest });
                }
                if let Some(runs) = self.runs {
                    cost = runs.cost.min(u32::MAX >> FULL) << FULL;
                    let on_time = moving > 1 && on_time;
                    least =
                        self.beat.micros(if on_time { runs.on_time } else { runs.min_interval });
                }
            }
            if fastest < least {
                return Err(Refusal::TooFast { motor, needs: least });
            }
            if player.fastest_turn().is_some_and(|delay| delay < turn) {
                return Err(Refusal::TooFast { motor, needs: turn });
            }
            // The steps of all motors together may take all the time there is.
            let room = (1u32 << FULL).saturating_sub(load);
            let needs = cost.checked_div(room).unwrap_or(Ticks::MAX);
            let ticks = Ticks::try_from(self.beat.ticks(fastest)).unwrap_or(Ticks::MAX);
            load = load.saturating_add(cost / ticks.max(1));
            if load > 1 << FULL {
                let needs = self.beat.micros(needs);
                return Err(Refusal::TooFast { motor, needs });
            }
        }
        Ok(())
    }

    /// Ends the cycle between two steps; positions stay known. Does nothing if the cycle is already
    /// over.
    pub fn finish(&mut self) {
        if self.is_running() {
            self.stop();
        }
    }

    /// Ends all programs and all pulses.
    fn stop(&mut self) {
        if let State::Paused(pause) = core::mem::replace(&mut self.state, State::Rest) {
            self.engine.thaw(pause.frozen);
        }
        self.state = State::Rest;
        self.engine.kill(Axes::MAX);
        self.engine.drive().lower(Axes::MAX);
        self.surroundings.enable(0);
        for motor in 0..N as u8 {
            let steps = self.steps(motor);
            if let Some(player) = self.player(motor) {
                player.settle(steps);
            }
        }
    }

    /// The step interrupt.
    pub fn on_compare(&mut self) {
        let begun = self.engine.timer().now();
        if !matches!(self.state, State::Running) {
            self.engine.on_compare();
            return self.wait();
        }
        let fixed = self.beat.is_fixed();
        // On the fixed tick the time counts from the tick that is due.
        let behind = if fixed { self.engine.behind() } else { 0 };
        // Motors that a switch stops are done; the events of the others are played, and then the
        // cycle may be over.
        let mut news = self.watch();
        news |= self.engine.on_compare();
        // Modulo the counter.
        let took = self.engine.timer().now().since(begun) as Ticks;
        let took = took & T::Count::HOP.wrapping_mul(4).wrapping_sub(1);
        if took > self.longest {
            self.longest = took;
        }
        // Only an end, a late step or a closed switch changes anything; on the fixed tick this
        // handler may also have taken too long.
        if news || fixed {
            self.took(took, behind);
            self.after();
        }
    }

    /// Reads the switches now: for the interrupt of their pins, or a foreground that polls them.
    pub fn look(&mut self) {
        self.watch();
        if matches!(self.state, State::Running) {
            self.after();
        }
    }

    /// Checks a handler that took `ticks` and came `behind` ticks late.
    fn took(&mut self, ticks: Ticks, behind: Ticks) {
        let slow = self.beat.is_fixed() && self.is_slow(ticks.saturating_add(behind));
        let late = self.engine.late();
        if slow || late != self.late {
            self.late = late;
            self.exceeded();
        }
    }

    /// Whether this many ticks are more than a fixed tick.
    #[inline(never)]
    fn is_slow(&self, ticks: Ticks) -> bool {
        u64::from(ticks) > self.beat.ticks(self.beat.period())
    }

    /// Reacts to a handler that took too long, or to late steps.
    #[cold]
    #[inline(never)]
    fn exceeded(&mut self) {
        if self.strategies.timing == AtTiming::Cancel {
            self.error = Some(CycleError::TimingExceeded);
            self.stop();
        }
    }

    /// Ends the cycle if it is cancelled or over.
    fn after(&mut self) {
        if !matches!(self.state, State::Running) {
            return;
        }
        if let Some(motor) = self.canceller() {
            self.error = Some(CycleError::MotorError { motor });
            self.stop();
        } else if self.engine.rests() {
            if BRAKES && let Some(motor) = self.first(Verdict::Brake) {
                self.error = Some(CycleError::MotorError { motor });
            }
            self.stop();
        }
    }

    /// The first motor whose fault cancels the cycle.
    fn canceller(&mut self) -> Option<u8> {
        self.first(Verdict::Cancel)
    }

    /// The first motor with this verdict.
    fn first(&mut self, verdict: Verdict) -> Option<u8> {
        let mut motors = (0u8..).zip(self.engine.feeds());
        motors.find(|(_, player)| player.verdict == verdict).map(|(motor, _)| motor)
    }

    fn player(&mut self, motor: u8) -> Option<&mut ProgramRunner<'a>> {
        self.engine.feed(motor)
    }

    /// The steps of a motor. On the fixed tick a step counts when STEP falls.
    fn steps(&mut self, motor: u8) -> i64 {
        if let State::Paused(Pause { steps, .. }) = &self.state {
            return steps.get(usize::from(motor)).copied().unwrap_or(0);
        }
        let report = self.engine.report(motor);
        let raised = self.engine.drive().raised.checked_shr(motor.into()).unwrap_or(0) & 1;
        let rising = if report.forward { i64::from(raised) } else { -i64::from(raised) };
        report.position.wrapping_sub(rising)
    }
}

/// Bits of a load: 1 << 16 is all the time there is. A small chip divides 32 bits.
const FULL: u32 = 16;

/// The fixed tick of three passes has its own times, all of them ticks.
const ON_TICKS: Timing = Timing { pulse: 0, setup: 0, hold: 0, min_interval: 0 };
