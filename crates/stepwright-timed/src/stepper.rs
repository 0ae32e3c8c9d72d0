//! What the step interrupt does: the edge, then the next interval.
//!
//! ```text
//!   begin        steps             the last      an interval later
//!     ▔▔▔▔▔▔▔▔▔▔▔╳▔▔▔▔▔╳▔▔▔▔▔╳▔▔▔▔▔▔▔╳▔▔▔▔▔▔▔▔▔▔▔┐
//!     current on                                 └ off, if the drive rests
//! ```
//!
//! Source: Austin for the L6219, whose current is on from the start until after the
//! last step. What else has to be switched off, enables, is the caller's.

use super::pace::Pace;
use stepwright::drive::{Coils, Port, Sequence};
use stepwright::units::Ticks;

/// A motor of the timed driver: when it steps, and its windings.
#[derive(Debug)]
pub struct Stepper<P> {
    /// When the next event is due.
    pub pace: Pace,
    coils: Coils<P>,
    /// The last step was made; the event that is due switches the current off.
    resting: bool,
}

impl<P: Port> Stepper<P> {
    /// At rest.
    pub const fn new(coils: Coils<P>) -> Stepper<P> {
        Stepper { pace: Pace::idle(), coils, resting: false }
    }

    /// Says which lines it has.
    pub fn wire(&mut self, port: P, sequence: Sequence, mask: u8) {
        self.coils = Coils::new(port, sequence, mask);
    }

    /// Its windings.
    #[inline]
    pub fn coils(&mut self) -> &mut Coils<P> {
        &mut self.coils
    }

    /// The row of the motor's table that it is at.
    pub const fn phase(&self) -> u8 {
        self.coils.phase()
    }

    /// A motion begins now, and the current goes on where the motor is. The first event is
    /// due an [`interval`](Pace::interval) later.
    pub fn begin(&mut self, pace: Pace, forward: bool) {
        self.pace = pace;
        self.resting = false;
        self.coils.set_forward(forward);
        self.coils.on();
    }

    /// No more events. The current goes off; the phase stays.
    pub fn stop(&mut self) {
        self.resting = false;
        self.coils.off();
    }

    /// An event is due: makes the step, if it is one, and says how many clocks later the
    /// next event is. `None` after the last.
    #[inline(always)]
    pub fn event(&mut self) -> Option<Ticks> {
        self.edge();
        self.advance()
    }

    /// The first half of an event: the step, if it is one. It comes first, so that edges are
    /// even.
    #[inline(always)]
    pub fn edge(&mut self) {
        if self.pace.is_step() {
            self.coils.step();
        }
    }

    /// The second half, which takes longer: clocks from the event to the next one.
    #[inline(always)]
    pub fn advance(&mut self) -> Option<Ticks> {
        match self.pace.advance() {
            None => self.rest(),
            next => next,
        }
    }

    /// No step is to come. The rotor gets an interval to settle.
    #[cold]
    #[inline(never)]
    fn rest(&mut self) -> Option<Ticks> {
        if !self.coils.rests() {
            return None;
        }
        self.resting = !self.resting;
        if self.resting {
            return Some(self.pace.interval());
        }
        self.coils.off();
        None
    }
}
