//! Plays a motor's program as runs for the engine.
//!
//! The engine asks for a run when the previous one is made, so the program is read one step ahead,
//! and never more.
//!
//! ```text
//!   deadlines    step           hold          delay
//!                 │╲ next leg?   │ DIR          │ step
//!                 ├──────────────┴──────────────┤
//!
//!   fixed tick    n              m−2      m−1      m
//!                 │ step, DIR    │ bounds │ rise   │ step
//!                 ├──────────────┼────────┼────────┤
//!
//!   in one pass   n−1            m−2      m−1
//!                 │ step         │ end?   │ step
//!                 ├──────────────┴────────┤
//! ```
//!
//! Bounds stop a motor when its step would be due (on the fixed tick, two ticks before), and only
//! if there is a step left to make: a motor that waits or ends at a bound has done nothing wrong.

mod braking;
#[cfg(feature = "runs")]
mod by_run;
mod by_tick;
mod on_grid;

use super::brake::{BRAKES, Brake};
use super::clock::{ANY_TICK, Beat, Clock};
use super::kept::Kept;
use super::motor::{Calibration, Faults, Motor, Status};
use super::program::{Next, PACED, Pace, RUNS, Reader};
use super::strategy::{AtSmallDelay, AtSoftEnd, Strategies};
use super::wide::{product, quotient};
use stepwright::queue::{Feed, Taken};
use stepwright::run::Run;
use stepwright::units::{Rate, Ticks};

/// The consequence of a motor's fault for the cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// None.
    Fine,
    /// The motor stops; the others continue.
    Stop,
    /// All motors stop.
    Cancel,
    /// All motors brake, then the cycle is cancelled.
    Brake,
}

/// What to do at the next call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Read the next part of the program.
    Leg,
    /// Hand out the rest of a wait.
    Wait,
    /// Hand out steps of the present leg.
    Steps,
    /// Hand out the rest of a long delay, then its step.
    Far,
    /// Hand out a single step, in ticks.
    Pace,
    /// Hand out steps of a run that was planned elsewhere.
    #[cfg(feature = "runs")]
    Run,
    /// Hand out a wait, in ticks.
    Look,
    /// On the fixed tick, up to two ticks before the step: check whether it may be made. STEP rises
    /// a tick later.
    Approach,
    /// STEP has risen, and falls a tick later.
    Drop,
    /// A bound is in the way when the step would be due.
    Out,
    /// On the fixed tick: the last step is made, and a tick passes.
    Linger,
    /// Nothing: the program is over.
    Over,
}

/// The most ticks from a step to the turn after it.
const FAR: u64 = 1 << 15;

pub(crate) struct ProgramRunner<'a> {
    pub motor: Motor,
    pub calibration: Calibration,
    pub status: Status,
    pub faults: Faults,
    pub verdict: Verdict,
    pub strategies: Strategies,
    /// Whether its next step goes forward or backward; `None`: it makes none now.
    pub heading: Option<bool>,
    reader: Reader<'a>,
    /// Whether it has a program that waits for the start.
    ready: bool,
    stage: Stage,
    beat: Beat,
    /// The time from a step to a change of direction, in ticks.
    hold: Ticks,
    /// Ticks of the next delay that have passed.
    gone: Ticks,
    /// The direction of the last step.
    facing: bool,
    forward: bool,
    /// Whether nothing of the program was handed out yet.
    fresh: bool,
    /// Steps left of the present leg, and µs before each.
    left: u32,
    delay: u32,
    /// The part of these steps that is known to end before a soft end.
    free: u32,
    /// µs left of a wait.
    pending: u64,
    /// Ticks to the next step that has its own delay, or of a wait.
    pace: Kept<Ticks, { (PACED || RUNS) as usize }>,
    /// Ticks waited since the last such step; the delay before the present one; and all ticks from
    /// one to the other.
    waited: Kept<Ticks, { PACED as usize }>,
    before: Kept<Ticks, { PACED as usize }>,
    own: Kept<Ticks, { PACED as usize }>,
    /// The planned run of which `left` steps are left.
    #[cfg(feature = "runs")]
    run: Run,
    /// Steps of the run that is played, and whether a step was made before it since the motor last
    /// stood.
    handed: Kept<u16, { BRAKES as usize }>,
    rolling: Kept<bool, { BRAKES as usize }>,
    /// The braking, if the motor brakes.
    brake: Kept<Option<Brake>, { BRAKES as usize }>,
    /// Fixed tick: the µs by which the last step came too early.
    over: Kept<u32, ANY_TICK>,
    /// Fixed tick of one pass: whether STEP has just risen, a tick before the step's own.
    risen: Kept<bool, ANY_TICK>,
    /// Position in the user's unit at the time when the engine had counted `counted` steps.
    base: i64,
    counted: i64,
    /// Steps handed out since then.
    planned: i64,
    /// Whether it has turned after a step since then.
    turned: bool,
}

impl<'a> ProgramRunner<'a> {
    /// A motor without a program.
    pub(crate) const IDLE: ProgramRunner<'a> =
        ProgramRunner::new(Motor::new(0, 1), Beat::new(Clock::Deadlines, Rate::MHZ), 0);

    pub(crate) const fn new(motor: Motor, beat: Beat, hold: Ticks) -> ProgramRunner<'a> {
        ProgramRunner {
            motor,
            calibration: Calibration::None,
            status: Status::Idle,
            faults: Faults::NONE,
            verdict: Verdict::Fine,
            strategies: Strategies::CANCEL,
            heading: None,
            reader: Reader::NONE,
            ready: false,
            stage: Stage::Over,
            beat,
            hold,
            gone: 0,
            facing: true,
            forward: true,
            fresh: true,
            left: 0,
            delay: 0,
            free: 0,
            pending: 0,
            pace: Kept::new(0),
            waited: Kept::new(0),
            before: Kept::new(0),
            own: Kept::new(0),
            #[cfg(feature = "runs")]
            run: Run::steady(0, 0),
            handed: Kept::new(0),
            rolling: Kept::new(false),
            brake: Kept::new(None),
            over: Kept::new(0),
            risen: Kept::new(false),
            base: 0,
            counted: 0,
            planned: 0,
            turned: false,
        }
    }

    /// Takes a program for the next cycle, and clears the state of the previous one.
    pub(crate) fn prepare(&mut self, reader: Reader<'a>, calibration: Calibration) {
        self.reader = reader;
        self.calibration = calibration;
        self.ready = true;
        self.status = Status::Idle;
        self.faults = Faults::NONE;
        self.verdict = Verdict::Fine;
        self.stage = Stage::Over;
        self.heading = None;
    }

    /// Forgets the prepared program.
    pub(crate) fn forget(&mut self) {
        (self.reader, self.ready) = (Reader::NONE, false);
    }

    /// Sets another clock.
    pub(crate) fn set_beat(&mut self, beat: Beat, hold: Ticks) {
        (self.beat, self.hold) = (beat, hold);
    }

    /// Whether it has a program that waits for the start.
    pub(crate) fn is_ready(&self) -> bool {
        self.ready
    }

    /// Whether its steps are counted in ticks of the timer.
    pub(crate) fn is_paced(&self) -> bool {
        self.reader.is_paced()
    }

    /// Whether each of its steps is asked for by itself, in ticks.
    pub(crate) fn has_own_paces(&self) -> bool {
        self.reader.has_own_paces()
    }

    /// The smallest delay that its program may have, in µs.
    pub(crate) fn fastest(&self) -> Option<u32> {
        self.reader.fastest(self.motor.smallest_delay, &self.beat)
    }

    /// The smallest delay of a leg that turns, in µs.
    pub(crate) fn fastest_turn(&self) -> Option<u32> {
        self.reader.fastest_turn(self.motor.smallest_delay)
    }

    /// Begins the program; the engine has counted `steps`.
    pub(crate) fn begin(&mut self, steps: i64, strategies: Strategies) {
        self.settle(steps);
        self.strategies = strategies;
        (self.ready, self.status, self.stage) = (false, Status::Running, Stage::Leg);
        (self.left, self.pending, self.gone, self.free) = (0, 0, 0, 0);
        self.waited.set(0);
        self.before.set(0);
        self.handed.set(0);
        self.rolling.set(false);
        self.brake.set(None);
        self.over.set(0);
        self.risen.set(false);
        self.fresh = true;
        self.beat.reset();
    }

    /// Ends the program, wherever it is.
    pub(crate) fn end(&mut self) {
        if self.status == Status::Running {
            self.status = Status::Finished;
        }
        self.stage = Stage::Over;
        self.heading = None;
    }

    /// Makes the present position the base of further ones; the engine has counted `steps`.
    pub(crate) fn settle(&mut self, steps: i64) {
        self.base = self.position(steps);
        if self.calibration == Calibration::BoundsMax && self.has_moved(steps) {
            self.motor.max = Some(self.base);
        }
        (self.counted, self.planned, self.turned) = (steps, 0, false);
    }

    /// The position in the user's unit after this many steps.
    pub(crate) fn position(&self, steps: i64) -> i64 {
        let made = steps.wrapping_sub(self.counted);
        if self.calibration == Calibration::StartMin && (made != 0 || self.turned) {
            return self.motor.min.unwrap_or(0);
        }
        let distance = self.motor.distance;
        let way = match i32::try_from(made) {
            // 63 bits, and no check whether they are more.
            Ok(made) => {
                let way = product(made.unsigned_abs(), distance) as i64;
                if made < 0 { way.wrapping_neg() } else { way }
            }
            Err(_) => made.saturating_mul(distance.into()),
        };
        self.base.saturating_add(way)
    }

    /// Whether it has made steps since the last call of `settle`.
    pub(crate) fn has_moved(&self, steps: i64) -> bool {
        steps != self.counted || self.turned
    }

    /// Sets the present position.
    pub(crate) fn set_position(&mut self, steps: i64, position: i64) {
        (self.base, self.counted, self.planned) = (position, steps, 0);
        self.turned = false;
    }

    /// How many of `count` steps of the present leg may be made before a soft end is in the way.
    #[inline(never)] // called in four places
    fn room(&mut self, count: u32) -> u32 {
        if self.free < count {
            self.free = self.look_ahead(self.left.max(count));
        }
        count.min(self.free)
    }

    /// [`room`](Self::room), computed again whatever is known.
    fn look_ahead(&self, count: u32) -> u32 {
        // Without a bound the limit is that of the numbers: a position is never wrong.
        let (bound, end) = match self.forward {
            true => (self.motor.max, i64::MAX),
            false => (self.motor.min, i64::MIN),
        };
        let bound = match self.calibration {
            Calibration::None => bound.unwrap_or(end),
            Calibration::StartMin => return count,
            Calibration::BoundsMax => end,
        };
        let at = self.position(self.counted.wrapping_add(self.planned));
        // Beyond the bound there is no room, rather than a negative one.
        let way = match self.forward {
            true if at < bound => bound.abs_diff(at),
            false if at > bound => at.abs_diff(bound),
            _ => return 0,
        };
        let distance = self.motor.distance.max(1);
        // A product: a division takes a small chip ten times as long.
        if product(count, distance) <= way {
            return count;
        }
        quotient(way, distance)
    }

    /// Counts `count` steps as handed out.
    fn plan(&mut self, count: u16) {
        self.handed.set(count);
        self.fresh = false;
        self.left = self.left.saturating_sub(count.into());
        self.free = self.free.saturating_sub(count.into());
        let steps = i64::from(count);
        self.planned = self.planned.wrapping_add(if self.forward { steps } else { -steps });
    }

    fn fault(&mut self, fault: Faults, verdict: Verdict) -> Taken {
        self.faults |= fault;
        self.verdict = verdict;
        self.end();
        Taken::End
    }

    /// Ends the way: the switch is closed, or the bound is reached.
    pub(crate) fn trip(&mut self, fault: Faults, strategy: AtSoftEnd) -> Taken {
        self.fault(
            fault,
            match strategy {
                AtSoftEnd::StopMotor => Verdict::Stop,
                AtSoftEnd::Cancel => Verdict::Cancel,
            },
        )
    }

    /// Whether the motor brakes.
    pub(crate) fn is_braking(&self) -> bool {
        self.brake.get().is_some()
    }

    /// Takes back the last `count` steps that were handed out; they are not made for now.
    pub(crate) fn take_back(&mut self, count: u16) {
        self.left = self.left.saturating_add(count.into());
        let steps = i64::from(count);
        self.planned = self.planned.wrapping_sub(if self.forward { steps } else { -steps });
    }

    /// Reads the program until there is something to do. `None` if a delay is too small for its
    /// strategy.
    fn read(&mut self) -> Option<Stage> {
        loop {
            match self.reader.next() {
                Next::Steps { count: 0, .. } | Next::Wait { count: 0, .. } => {}
                Next::Steps { count, delay, forward } => {
                    let smallest = self.motor.smallest_delay.max(1);
                    (self.left, self.free, self.forward) = (count, 0, forward);
                    self.delay = if delay == 0 { smallest } else { delay };
                    if self.delay < smallest {
                        self.too_small()?;
                        self.delay = smallest;
                    }
                    return Some(Stage::Steps);
                }
                Next::Pace(_) if !PACED => return Some(Stage::Over),
                Next::Pace(Pace::Step { ticks, forward }) => {
                    (self.left, self.free, self.forward) = (1, 0, forward);
                    self.pace.set(ticks);
                    let waited = self.waited.take();
                    self.before.set(waited);
                    let smallest = self.beat.ticks(self.motor.smallest_delay);
                    if u64::from(ticks) + u64::from(waited) < smallest {
                        self.too_small()?;
                        let smallest = Ticks::try_from(smallest).unwrap_or(Ticks::MAX);
                        self.pace.set(smallest.saturating_sub(waited));
                    }
                    self.own.set(self.pace.get().saturating_add(waited));
                    return Some(Stage::Pace);
                }
                Next::Pace(Pace::Wait { ticks }) => {
                    self.pace.set(ticks.max(1));
                    self.waited.set(self.waited.get().saturating_add(self.pace.get()));
                    let interval = u64::from(self.waited.get()) << 16;
                    if self.brake.get().is_some_and(|brake| brake.is_over(interval)) {
                        return Some(Stage::Over);
                    }
                    return Some(Stage::Look);
                }
                #[cfg(feature = "runs")]
                Next::Run { run, forward } => return Some(self.read_run(run, forward)),
                // A motor that waits stands: nothing is left to brake.
                Next::Wait { .. } if self.is_braking() => return Some(Stage::Over),
                Next::Wait { count, delay } => {
                    let delay = if delay == 0 { self.motor.smallest_delay.max(1) } else { delay };
                    self.pending = product(count, delay);
                    self.rolling.set(false);
                    return Some(Stage::Wait);
                }
                Next::Over => return Some(Stage::Over),
            }
        }
    }

    /// Handles a delay that is too small. `None` if that ends the program.
    fn too_small(&mut self) -> Option<()> {
        let verdict = match self.strategies.small_delay {
            AtSmallDelay::Fix => return Some(()),
            AtSmallDelay::StopMotor => Verdict::Stop,
            AtSmallDelay::Cancel => Verdict::Cancel,
        };
        self.fault(Faults::STEP_DELAY_SMALL, verdict);
        None
    }

    /// The change of direction at the beginning of the present leg, if there is one, this many
    /// ticks before its first step. It comes in the middle of these ticks: so the step before it
    /// has as much time as others, and the reading at both points is split in two halves.
    fn turn(&mut self, ticks: u64) -> Option<Taken> {
        if self.forward == self.facing {
            return None;
        }
        self.facing = self.forward;
        // The steps back may cancel those before.
        // (32 bits are enough: no leg has more steps.)
        self.turned |= self.planned as u32 != 0;
        // At the start nothing waits, and the engine turns at once.
        let half = if self.fresh { 0 } else { (ticks / 2).min(FAR) as Ticks };
        self.gone = self.hold.max(half);
        self.rolling.set(false);
        Some(Taken::Run(Run::turn(self.gone, self.forward)))
    }

    /// Hands out a wait of `us` µs.
    fn pass(&mut self, us: u32) -> Taken {
        self.fresh = false;
        let wait = self.beat.wait(us).saturating_sub(core::mem::take(&mut self.gone));
        Taken::Run(Run::turn(wait, self.facing))
    }

    /// Hands out a piece of the pending wait.
    fn pass_piece(&mut self) -> Taken {
        let piece = self.pending.min(self.beat.piece.into());
        self.pending -= piece;
        self.pass(piece as u32)
    }

    /// The next run by deadlines.
    // Runs of a path are taken without it, in half the time.
    #[cfg_attr(feature = "runs", inline(never))]
    fn by_deadline(&mut self) -> Taken {
        loop {
            match self.stage {
                Stage::Leg => match self.read() {
                    Some(Stage::Over) | None => {
                        self.end();
                        return Taken::End;
                    }
                    Some(stage) => self.stage = stage,
                },
                Stage::Wait if self.pending > 0 => return self.pass_piece(),
                Stage::Wait => self.stage = Stage::Leg,
                Stage::Steps if self.left == 0 => self.stage = Stage::Leg,
                #[cfg(feature = "runs")]
                Stage::Run if self.left == 0 => self.stage = Stage::Leg,
                #[cfg(feature = "runs")]
                Stage::Run if self.is_braking() => return self.brake_on(),
                Stage::Steps | Stage::Pace if self.is_braking() => {
                    return self.brake_on();
                }
                Stage::Steps => {
                    if let Some(turn) = self.turn(self.beat.ticks(self.delay)) {
                        return turn;
                    }
                    self.heading = Some(self.forward);
                    let most = self.left.min(self.beat.longest().into());
                    let room = self.room(most);
                    if room == 0 || self.delay > self.beat.piece {
                        self.pending = self.delay.into();
                        self.stage = Stage::Far;
                        continue;
                    }
                    let count = room as u16;
                    self.plan(count);
                    let run = self.beat.steps(self.delay, count);
                    return match core::mem::take(&mut self.gone) {
                        0 => Taken::Run(run),
                        gone => {
                            let first = (run.interval() >> 16) as Ticks;
                            Taken::After(first.saturating_sub(gone), run)
                        }
                    };
                }
                Stage::Far => {
                    self.heading = Some(self.forward);
                    if self.pending > self.beat.piece.into() {
                        return self.pass_piece();
                    }
                    let us = self.pending as u32;
                    if self.room(1) == 0 {
                        self.stage = Stage::Out;
                        // On the fixed tick the bound is checked a tick before STEP would rise.
                        return self.pass(us.saturating_sub(self.beat.period()));
                    }
                    self.stage = Stage::Steps;
                    self.plan(1);
                    let gone = core::mem::take(&mut self.gone);
                    return Taken::Run(self.beat.step(us, gone));
                }
                #[cfg(feature = "runs")]
                Stage::Run => return self.by_run(),
                Stage::Pace => {
                    if let Some(turn) = self.turn(self.pace.get().into()) {
                        return turn;
                    }
                    self.heading = Some(self.forward);
                    let ticks = self.pace.get().saturating_sub(core::mem::take(&mut self.gone));
                    if self.room(1) == 0 {
                        self.stage = Stage::Out;
                        return Taken::Run(Run::turn(ticks, self.facing));
                    }
                    self.stage = Stage::Leg;
                    self.plan(1);
                    return Taken::Run(Run::steady(ticks, 1));
                }
                Stage::Look => {
                    self.stage = Stage::Leg;
                    return Taken::Run(Run::turn(self.pace.get(), self.facing));
                }
                Stage::Out => {
                    return self.trip(Faults::soft(self.forward), self.strategies.soft_end);
                }
                _ => return Taken::End,
            }
        }
    }
}

impl Feed for ProgramRunner<'_> {
    const GROWS: bool = RUNS;

    fn take(&mut self) -> Taken {
        self.heading = None;
        if BRAKES {
            let made = self.handed.take() > 0;
            self.rolling.set(self.rolling.get() || made);
        }
        #[cfg(feature = "runs")]
        if let Some(run) = self.by_next_run() {
            return Taken::Run(run);
        }
        if self.beat.is_fixed() {
            return self.by_tick();
        }
        if self.beat.is_grid()
            && let Some(taken) = self.on_grid()
        {
            return taken;
        }
        self.by_deadline()
    }

    fn clear(&mut self) {
        self.end();
    }
}
