//! A machine that is fed ahead of its motion: a board that plays streams.
//!
//! ```text
//!   moves ─► route ─► steps ahead ─► FedRun, a StreamFeeder ─► the caller's line ─► board
//!              ▲                                                                      │ where it is
//!              └── a change, from where it can be made ◄──────────────────────────────┘ = the time of the session
//! ```
//!
//! The session's time is that of the board, and reports tell the board's position. A [`FedRun`]
//! sends steps ahead of the board. A hold or an override waits until the steps that were sent are
//! taken back; the path changes from there on.

use stepwright_feeder::{FeedState, StreamFeeder};

use crate::machine::GrblMachine;
use crate::motion::Coming;
use crate::session::Grbl;

/// Lines that a sender sends within this time are planned together, in µs.
const TOGETHER: u64 = 30_000;
/// If less than this is planned ahead of the board, in s, planning continues with the moves that
/// are known.
const LATE: f64 = 0.45;
/// The board is told of a rest this far ahead, in s.
const REST: f64 = 0.25;

impl<M: GrblMachine> Grbl<M> {
    /// Makes this the session of a board that is fed, without switches and probe. `$22=1` is refused
    /// with error 3, a probing move with error 20; so is `$32=1` with error 3, unless the board has an
    /// output for a laser.
    pub fn fed(mut self, laser: bool) -> Grbl<M> {
        self.motion.fed = true;
        self.lasers = laser;
        self
    }

    /// Whether a run is in progress, or waits for a [`FedRun`] to feed it. Until that begins, and
    /// while the board finishes the run before, the session's time stands still.
    pub fn has_run(&self) -> bool {
        self.run().is_some()
    }

    /// The number of that run. Its time 0 is the session's time of its first move.
    fn run(&self) -> Option<u64> {
        (!self.motion.is_over()).then_some(self.motion.runs)
    }

    /// Handles a board that has left the path or is lost, with its axes at `at`: raises an alarm
    /// that only a reset ends, after a message with these words.
    pub fn off_path(&mut self, at: [i64; 3], alarm: u8, words: &str) {
        self.motion.drop_at(at);
        self.after = None;
        self.forget_lines();
        self.say(&format!("[MSG:{words}]\r\n"));
        self.alarm(alarm);
    }
}

/// A run of a session that is being sent to a board.
///
/// Call its [`turn`](FedRun::turn) every few ms, and advance the session to [its
/// time](FedRun::now), until its [state](FedRun::state) is an end.
///
/// ```
/// use stepwright_feeder::{FeedState, FeedTerms, StreamFeeder};
/// use stepwright_grbl::{FedRun, Grbl, VirtualMill};
/// use stepwright_stream::brake::BrakeLaw;
/// let mut grbl = Grbl::new(VirtualMill::default()).fed(false);
/// let brakes = BrakeLaw::of(10_000_000, 16_000_000).unwrap(); // 10,000 steps/s², at 16 MHz
/// let feeder = || StreamFeeder::new(FeedTerms::avr([brakes; 3]), 0);
/// assert!(FedRun::begin(&grbl, 0.0, feeder()).is_none());
/// grbl.receive(0.0, b"G21 G91 G1 X1 F500\n");
/// let mut run = FedRun::begin(&grbl, 0.0, feeder()).unwrap();
/// let mut sent = 0;
/// for micros in (0..50_000).step_by(1_000) {
///     let heard = []; // what the board says
///     sent += run.turn(&mut grbl, &heard, micros).len();
///     grbl.advance(run.now());
/// }
/// // A board that answers would begin now.
/// assert!(sent > 0 && run.state() == FeedState::Filling);
/// ```
pub struct FedRun {
    number: u64,
    feeder: StreamFeeder,
    /// The session's time at the start of the run, and at present.
    base: f64,
    now: f64,
    /// The run's seconds that are planned.
    planned: f64,
    /// The laser's power from there on; `None` if it is to be told in any case.
    power: Option<u8>,
    /// What was planned before the steps that are being taken back, in s.
    changes: Option<f64>,
    /// Whether the run ended before it began.
    dropped: bool,
}

impl FedRun {
    /// Begins the run that waits at this time of the session; `None` if [none
    /// waits](Grbl::has_run). The feeder must be new: it has seen no step.
    pub fn begin<M: GrblMachine>(grbl: &Grbl<M>, now: f64, feeder: StreamFeeder) -> Option<FedRun> {
        let number = grbl.run()?;
        let (planned, power, changes, dropped) = (0.0, None, None, false);
        Some(FedRun { number, feeder, base: now, now, planned, power, changes, dropped })
    }

    /// Takes the bytes from the board, `micros` after the start of the run. Returns the bytes to
    /// send.
    pub fn turn<M: GrblMachine>(
        &mut self,
        grbl: &mut Grbl<M>,
        heard: &[u8],
        micros: u64,
    ) -> Vec<u8> {
        self.feeder.hear(heard, micros);
        let late = self.feeder.was_late();
        if let Some(planned) = self.changes.filter(|_| late || !self.feeder.is_cutting()) {
            (self.changes, self.power) = (None, None);
            if late {
                self.planned = planned;
            }
            grbl.motion.changed(!late);
        }
        let here = self.feeder.now(micros).max(0.0);
        let mine = grbl.run() == Some(self.number);
        // While a further run waits for the end of this one, time stands still.
        if mine || !grbl.has_run() {
            self.now = self.now.max(self.base + here);
        }
        if mine && self.feeder.state() == FeedState::Filling && grbl.motion.wants_stop() {
            grbl.motion.start_over();
            self.dropped = true;
            return Vec::new();
        }
        if mine
            && let Some(brakes) = grbl.motion.wants_change()
            && let Some(cut) = self.feeder.cut(micros, brakes)
        {
            self.changes = Some(self.planned);
            (self.planned, self.power) = (cut.time, None);
            grbl.motion.change_from(cut.time, cut.steps);
        }
        while self.feeder.wants() {
            let fills = self.feeder.state() == FeedState::Filling;
            let late = if fills { micros > TOGETHER } else { self.planned < here + LATE };
            // A run that waits is not planned here, so its steps are not lost.
            match if mine { grbl.motion.plan(late, here + REST) } else { None } {
                Some(Coming::Step(step)) => {
                    self.planned = step.time;
                    self.light(grbl.planned_power(step.time));
                    self.feeder.step(step.axis, step.time, step.forward);
                }
                Some(Coming::Rest(until)) => {
                    self.light(0);
                    self.planned = until;
                    self.feeder.know(until);
                    // The path is shorter than the amount that is sent ahead.
                    self.feeder.begin();
                    break;
                }
                // More moves may come.
                None if mine => break,
                None => self.feeder.end(self.planned),
            }
        }
        self.feeder.bytes(micros)
    }

    /// Sets the laser's power from the last planned step on.
    fn light(&mut self, power: u8) {
        if self.power.replace(power) != Some(power) {
            self.feeder.power(self.planned, power);
        }
    }

    /// The session's time in seconds, which is that of the board.
    pub fn now(&self) -> f64 {
        self.now
    }

    /// The state of the feeder. A run that is held or dropped before the board has begun is over at once; a
    /// held one waits for another [`FedRun`]: see [`is_dropped`](FedRun::is_dropped).
    pub fn state(&self) -> FeedState {
        if self.dropped { FeedState::Over } else { self.feeder.state() }
    }

    /// Whether the run was given up before the board had begun.
    pub fn is_dropped(&self) -> bool {
        self.dropped
    }
}
