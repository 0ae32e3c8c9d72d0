//! The work of the step interrupt: the edge, then the next interval.
//!
//! ```text
//!   begin        steps             the last      an interval later
//!     ▔▔▔▔▔▔▔▔▔▔▔╳▔▔▔▔▔╳▔▔▔▔▔╳▔▔▔▔▔▔▔╳▔▔▔▔▔▔▔▔▔▔▔┐
//!     current on                                 └ off, if the drive rests
//! ```
//!
//! Source: Austin for the L6219, whose current is on from the start until after the last step. The
//! caller switches everything else, such as enables.

use super::pace::Pace;
use stepwright::drive::{Coils, Port, Sequence};
use stepwright::units::Ticks;

/// A motor of the timed driver: its step times and its windings.
#[derive(Debug)]
pub struct Stepper<P> {
    /// The times of the events.
    pub pace: Pace,
    coils: Coils<P>,
    /// Whether the last step was made; then the due event switches the current off.
    resting: bool,
}

impl<P: Port> Stepper<P> {
    /// A motor at rest.
    pub const fn new(coils: Coils<P>) -> Stepper<P> {
        Stepper { pace: Pace::idle(), coils, resting: false }
    }

    /// Sets the lines of the motor.
    pub fn wire(&mut self, port: P, sequence: Sequence, mask: u8) {
        self.coils = Coils::new(port, sequence, mask);
    }

    /// The windings.
    #[inline]
    pub fn coils(&mut self) -> &mut Coils<P> {
        &mut self.coils
    }

    /// The row of the motor's table at which it is.
    pub const fn phase(&self) -> u8 {
        self.coils.phase()
    }

    /// Begins a motion now, and switches the current on at the motor's present phase. The first
    /// event is due one [`interval`](Pace::interval) later.
    pub fn begin(&mut self, pace: Pace, forward: bool) {
        self.pace = pace;
        self.resting = false;
        self.coils.set_forward(forward);
        self.coils.on();
    }

    /// Ends all events. The current goes off; the phase stays.
    pub fn stop(&mut self) {
        self.resting = false;
        self.coils.off();
    }

    /// Handles a due event: makes the step, if it is one, and returns the clocks to the next event.
    /// `None` after the last.
    #[inline(always)]
    pub fn event(&mut self) -> Option<Ticks> {
        self.edge();
        self.advance()
    }

    /// The first half of an event: makes the step, if it is one. It comes first, so that edges are
    /// even.
    #[inline(always)]
    pub fn edge(&mut self) {
        if self.pace.is_step() {
            self.coils.step();
        }
    }

    /// The second half, which takes longer: the clocks from this event to the next one.
    #[inline(always)]
    pub fn advance(&mut self) -> Option<Ticks> {
        match self.pace.advance() {
            None => self.rest(),
            next => next,
        }
    }

    /// No step is left. The rotor gets an interval to settle.
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
