//! The timed driver over simulated time: the Arduino driver's system without an Arduino.
//!
//! The driver, the interrupt's part and the drive are those of a chip; the timer, the caller's milliseconds and
//! the pins are simulated.
//!
//! ```
//! use stepwright::drive::sequence::SHIELD;
//! use stepwright_timed::{Code, Control, Model, SetSpeed};
//! use stepwright_timed::fit::Hardware;
//! use stepwright_sim::timed::TimedBoard;
//!
//! let mut board = TimedBoard::new(Hardware::avr16(16_000_000), Model::Ideal, SHIELD, 0);
//! let order = SetSpeed { limit: 4, ..SetSpeed::fixed(Control::DRV_EN, 32_000) };
//! assert_eq!(board.set_speed(&order), Code::FINE);
//! board.run_for_millis(100);
//! assert_eq!(board.steps(), [32_000, 64_000, 96_000, 128_000]);
//! assert!(!board.is_moving());
//! ```

mod program;
pub mod published;

pub use program::{TimedLineBoard, TimedMotor};

use stepwright::drive::{Coils, Sequence};
use stepwright_timed::fit::Hardware;
use stepwright_timed::{Call, Code, Driver, Dump, Hold, Model, Pace, SetSpeed, Status, Stepper};

use crate::pins::Lines;

/// The levels of all lines of the motor from this time on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// Clocks of the timer since the board was switched on.
    pub time: u64,
    /// One bit per line, the first line in bit 0.
    pub levels: u8,
    /// Whether the drivers' enables are high.
    pub enabled: bool,
}

/// A board with one motor and the timed driver.
#[derive(Debug)]
pub struct TimedBoard {
    driver: Driver,
    motion: Motion,
    /// The caller's clock at power-up.
    millis: u32,
}

/// The state of the step interrupt.
#[derive(Debug)]
struct Motion {
    stepper: Stepper<Lines>,
    now: u64,
    due: Option<u64>,
    enabled: bool,
    steps: Vec<u64>,
    changes: Vec<Change>,
}

impl Motion {
    /// A motor at rest, without current.
    fn new(mut coils: Coils<Lines>) -> Motion {
        coils.off();
        let mut motion = Motion {
            stepper: Stepper::new(coils),
            now: 0,
            due: None,
            enabled: false,
            steps: Vec::new(),
            changes: Vec::new(),
        };
        motion.note();
        motion
    }

    /// Lets time pass until `clock`, with all events up to and at `clock`.
    fn run_until(&mut self, clock: u64) {
        while let Some(due) = self.due.filter(|due| *due <= clock) {
            self.interrupt(due);
        }
        self.now = self.now.max(clock);
    }

    /// Records the pins if they have changed.
    fn note(&mut self) {
        let (time, levels, enabled) = (self.now, self.stepper.coils().port().0, self.enabled);
        let last = self.changes.last().map(|change| (change.levels, change.enabled));
        if last != Some((levels, enabled)) {
            self.changes.push(Change { time, levels, enabled });
        }
    }

    /// The step interrupt.
    fn interrupt(&mut self, time: u64) {
        self.now = time;
        if self.stepper.pace.is_step() {
            self.steps.push(time);
        }
        self.due = self.stepper.event().map(|interval| time + u64::from(interval));
        self.note();
    }
}

impl Hold for Motion {
    fn with<R>(&mut self, look: impl FnOnce(&mut Pace) -> R) -> R {
        look(&mut self.stepper.pace)
    }

    fn begin(&mut self, pace: Pace, forward: bool) {
        self.due = Some(self.now + u64::from(pace.interval()));
        self.stepper.begin(pace, forward);
        self.enabled = true;
        self.note();
    }

    fn stop(&mut self) {
        self.due = None;
        self.stepper.stop();
        self.enabled = false;
        self.note();
    }
}

impl TimedBoard {
    /// Switches a board on: its timer, when a new top takes effect, the levels of the motor's lines, and the
    /// caller's milliseconds at power-up.
    pub fn new(hardware: Hardware, model: Model, sequence: Sequence, millis: u32) -> TimedBoard {
        let motion = Motion::new(Coils::new(Lines::default(), sequence, 0xFF));
        TimedBoard { driver: Driver::new(hardware, model), motion, millis }
    }

    /// Clocks since the board was switched on.
    pub fn now(&self) -> u64 {
        self.motion.now
    }

    /// The caller's clock.
    pub fn millis(&self) -> u32 {
        let passed = u128::from(self.now()) * 1000 / u128::from(self.hz());
        self.millis.wrapping_add(passed as u32)
    }

    fn hz(&self) -> u32 {
        self.driver.hardware().hz()
    }

    /// The clocks of this many milliseconds.
    pub fn clocks(&self, millis: f64) -> u64 {
        (millis * f64::from(self.hz()) / 1e3).round() as u64
    }

    /// `motorSetSpeed`, now.
    pub fn set_speed(&mut self, order: &SetSpeed) -> Code {
        let millis = self.millis();
        self.driver.set_speed(&mut self.motion, order, millis)
    }

    /// `motorTimerUpdateCheck`, now.
    pub fn update_check(&mut self, call: impl FnMut(Call)) {
        let millis = self.millis();
        self.driver.update_check(&mut self.motion, millis, call);
    }

    /// `motorReadStatus`.
    pub fn status(&mut self) -> Status {
        self.driver.status(&mut self.motion)
    }

    /// The debug dump, now.
    pub fn dump(&mut self) -> Dump {
        let phase = self.motion.stepper.phase();
        self.driver.dump(&mut self.motion, phase)
    }

    /// Lets time pass until `clock`, with all events up to and at `clock`.
    pub fn run_until(&mut self, clock: u64) {
        self.motion.run_until(clock);
    }

    /// Lets this many milliseconds pass.
    pub fn run_for_millis(&mut self, millis: u32) {
        self.run_until(self.now() + self.clocks(millis.into()));
    }

    /// The time of the next event, if the motor moves.
    pub fn due(&self) -> Option<u64> {
        self.motion.due
    }

    /// Whether the motor moves.
    pub fn is_moving(&self) -> bool {
        self.motion.stepper.pace.is_moving()
    }

    /// The times of all steps so far.
    pub fn steps(&self) -> &[u64] {
        &self.motion.steps
    }

    /// All changes of the pins so far; the lines change together.
    pub fn changes(&self) -> &[Change] {
        &self.motion.changes
    }

    /// The present row of the motor's table.
    pub fn phase(&self) -> u8 {
        self.motion.stepper.phase()
    }

    /// Sets the row at which the motor is, before it moves: at power-up.
    pub fn restore(&mut self, phase: u8) {
        self.motion.stepper.coils().restore(phase);
    }
}
