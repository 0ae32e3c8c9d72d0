//! A machine that is fed before it moves: a board that plays what is streamed.
//!
//! ```text
//!   moves ─► route ─► steps ahead ─► the caller's feeder ─► board
//!              ▲                                             │ where it is
//!              └── a change, from where it can be made ◄─────┘ = the time of the session
//! ```
//!
//! The session lives where the board is: its time is the board's, and reports tell where that is.
//! [`plan`](Grbl::plan) gives steps ahead of it. A hold or an override waits until the caller has taken back
//! what was sent, and says from when on it is [changed](Grbl::change_from).

use crate::machine::GrblMachine;
use crate::motion::Coming;
use crate::session::Grbl;

impl<M: GrblMachine> Grbl<M> {
    /// On a board that is fed, without switches, probe and laser. `$22=1` and `$32=1` are refused with
    /// error 3, a probing move with error 20.
    pub fn fed(mut self) -> Grbl<M> {
        self.motion.fed = true;
        self
    }

    /// The number of the run that is under way. It began at the session's time of its first
    /// move, when its own is 0. The session's time stands until the board begins it, also while the
    /// board comes to the end of the run before.
    pub fn run(&self) -> Option<u64> {
        (!self.motion.is_over()).then_some(self.motion.runs)
    }

    /// What comes next of the run of this number. `None` until more moves come: with `late` it goes on by
    /// what is known. Where it rests, it may rest until `rest`, in s of the run. `None` as well where
    /// the run is over: the steps of one that waits are not lost to it.
    pub fn plan(&mut self, run: u64, late: bool, rest: f64) -> Option<Coming> {
        if self.run() == Some(run) { self.motion.plan(late, rest) } else { None }
    }

    /// Whether the run is to be changed; and if so, whether it brakes from there on.
    pub fn wants_change(&self) -> Option<bool> {
        self.motion.wants_change()
    }

    /// The run changes at this time of it, behind this many steps.
    pub fn change_from(&mut self, time: f64, steps: u64) {
        self.motion.change_from(time, steps);
    }

    /// Whether the board has taken the change. If not, it is wanted still.
    pub fn changed(&mut self, made: bool) {
        self.motion.changed(made);
    }

    /// The board has left the path, or is lost, and its axes are there: an alarm that only a reset
    /// ends, with these words before it.
    pub fn off_path(&mut self, at: [i64; 3], alarm: u8, words: &str) {
        self.motion.drop_at(at);
        self.after = None;
        self.forget_lines();
        self.say(&format!("[MSG:{words}]\r\n"));
        self.alarm(alarm);
    }
}
