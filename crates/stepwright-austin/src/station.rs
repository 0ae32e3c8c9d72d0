//! A motor that follows a law, ordered over the serial line: without its pins, clock and bytes.
//!
//! ```text
//!   bytes ──► slave ─► Station ──► law: a delay at a time ──► Run of one step ──► queue
//!     ▲                   │        (main loop, some steps ahead)                    │
//!     └──── answers ◄─────┴──────── position, late steps ◄──────── engine ◄─────────┘
//! ```
//!
//! It is the same on a chip (`firmware/avr/src/bin/laws.rs`) and on the virtual board
//! (`stepwright-sim`). The caller has a [`Control`], a queue, and a `ProgramSlave` for the line. A
//! stop or a change of acceleration "from now on" takes effect with the next delay that is
//! computed, after the queued ones: at most [`AHEAD`].

use super::choice::{AnyLaw, Recipe};
use super::line::{ENDLESS, Line, Refused};
use stepwright::queue::Producer;
use stepwright::{Accel, Control, Run, Ticks};
use stepwright_protocol::{BoardProgram, Fault, Numbers, Piece, Said, Text, flash_text};

/// The changes of acceleration that a travel may have pending.
pub const CHANGES: usize = 4;
/// No changes.
const NO_CHANGES: [(u32, Accel); CHANGES] = [(0, Accel::MIN); CHANGES];
/// The most delays that are computed ahead of the present step.
pub const AHEAD: u8 = 6;
/// The axis that moves.
const AXIS: u8 = 0;
/// Ticks from the order to the change of direction, and from there to the first step: 250 µs.
const LEAD: Ticks = 250;
/// The shortest delay of each law that a board makes without being late, in ticks of 1 MHz.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Costs {
    /// The general form.
    pub austin: Ticks,
    /// The general form with a change of acceleration.
    pub changing: Ticks,
    /// The published listing.
    pub austin_fixed: Ticks,
    /// The linear factor.
    pub linear_factor: Ticks,
    /// The power term, for each p.
    pub power: Ticks,
    /// Piecewise.
    pub piecewise: Ticks,
}

impl Costs {
    /// An AVR of 16 MHz, as tested by `firmware/rig/tests/laws_line.rs`.
    pub const AVR: Costs = Costs {
        austin: 500,
        changing: 1_000,
        austin_fixed: 400,
        linear_factor: 800,
        power: 2_500,
        piecewise: 2_000,
    };

    /// The shortest delay of a law.
    pub fn of(&self, recipe: &Recipe) -> Ticks {
        match recipe {
            #[cfg(feature = "constant")]
            Recipe::Austin(_) => self.austin,
            #[cfg(feature = "constant")]
            Recipe::AustinFixed(..) => self.austin_fixed,
            #[cfg(feature = "transitions")]
            Recipe::LinearFactor(_) => self.linear_factor,
            #[cfg(feature = "power")]
            Recipe::Power(c) => self.power.wrapping_mul(c.power.into()),
            #[cfg(feature = "transitions")]
            Recipe::Piecewise(_) => self.piecewise,
        }
    }
}

/// The board of a station.
#[derive(Clone, Copy, Debug)]
pub struct About {
    /// Its name: `uno`.
    pub name: Text,
    /// The rate of its timer in MHz.
    pub mhz: u32,
    /// How fast it is.
    pub costs: Costs,
}

/// The laws of this build, as listed in the answer to `?`.
const CONSTANT: &str = if cfg!(feature = "constant") { ",austin,austin-fixed" } else { "" };
const TRANSITIONS: &str =
    if cfg!(feature = "transitions") { ",linear-factor,piecewise" } else { "" };
const POWER: &str = if cfg!(feature = "power") { ",power" } else { "" };

/// A motor and its law.
pub struct Station<'q, E, const LEN: usize> {
    engine: E,
    feed: Producer<'q, LEN>,
    about: About,
    recipe: Option<Recipe>,
    /// Accelerations, each with the number of steps of a travel after which it applies; 0: none.
    changes: [(u32, Accel); CHANGES],
    law: Option<AnyLaw>,
    /// A run for which there was no room yet.
    ready: Option<Run>,
    /// The number of pulses of the travel whose delays have been computed.
    made: u32,
    /// Whether the engine plays the travel.
    begun: bool,
    uncertain: bool,
}

impl<'q, E: Control, const LEN: usize> Station<'q, E, LEN> {
    /// A motor at rest at 0, without a law.
    pub const fn new(engine: E, feed: Producer<'q, LEN>, about: About) -> Self {
        Station {
            engine,
            feed,
            about,
            recipe: None,
            changes: NO_CHANGES,
            law: None,
            ready: None,
            made: 0,
            begun: false,
            uncertain: false,
        }
    }

    /// The engine.
    pub fn engine(&mut self) -> &mut E {
        &mut self.engine
    }

    fn is_moving(&self) -> bool {
        self.law.is_some() || self.begun
    }

    fn make(&mut self) {
        if self.ready.is_none() {
            self.ready = self.next();
        }
        let Some(run) = self.ready else {
            // The last step has been queued.
            self.feed.set_open(false);
            (self.law, self.changes) = (None, NO_CHANGES);
            return self.begin();
        };
        if self.feed.len() >= AHEAD || self.feed.push(run).is_err() {
            return self.begin();
        }
        self.ready = None;
    }

    /// Starts the engine, once some delays are computed.
    fn begin(&mut self) {
        if !self.begun {
            self.begun = true;
            self.engine.start(1 << AXIS);
        }
    }

    /// Computes the next step.
    #[inline(never)]
    fn next(&mut self) -> Option<Run> {
        let law = self.law.as_mut()?;
        for (after, accel) in &mut self.changes {
            if *after != 0 && *after <= self.made {
                law.set_accel(*accel);
                *after = 0;
            }
        }
        let delay = law.next()?;
        let first = self.made == 0;
        self.made = self.made.wrapping_add(1);
        let delay = if first { LEAD } else { delay };
        Some(Run::steady(delay.wrapping_mul(self.about.mhz), 1))
    }

    fn rests(&self) -> Result<(), Fault<Refused>> {
        if self.is_moving() { Err(Fault::Busy) } else { Ok(()) }
    }

    #[inline(never)]
    fn take(&mut self, recipe: &Recipe) -> Result<(), Fault<Refused>> {
        self.rests()?;
        if !recipe.is_sound() {
            return Err(Fault::Own(Refused::Unsound));
        }
        let least = self.about.costs.of(recipe);
        if recipe.shortest() < least {
            return Err(Fault::Own(Refused::Fast(least)));
        }
        self.recipe = Some(*recipe);
        self.changes = NO_CHANGES;
        Ok(())
    }

    #[inline(never)]
    fn change(&mut self, after: u32, accel: Accel) -> Result<(), Refused> {
        let recipe = self.recipe.as_ref().filter(|recipe| recipe.changes()).ok_or(Refused::Law)?;
        let least = self.about.costs.changing;
        if recipe.shortest() < least {
            return Err(Refused::Fast(least));
        }
        if after == 0 {
            let law = self.law.as_mut().ok_or(Refused::Rest)?;
            return if law.set_accel(accel) { Ok(()) } else { Err(Refused::Rest) };
        }
        let free = self.changes.iter_mut().find(|(after, _)| *after == 0);
        *free.ok_or(Refused::Full)? = (after, accel);
        Ok(())
    }

    #[inline(never)]
    fn go(&mut self, pulses: u32, forward: bool) -> Result<(), Fault<Refused>> {
        self.rests()?;
        let recipe = self.recipe.as_ref().ok_or(Fault::Own(Refused::Law))?;
        if pulses == 0 {
            return Ok(());
        }
        self.law = Some(recipe.delays(pulses));
        (self.made, self.ready) = (0, None);
        self.feed.set_open(true);
        // The queue is empty.
        let _ = self.feed.push(Run::turn(LEAD.wrapping_mul(self.about.mhz), forward));
        Ok(())
    }
}

impl<E: Control, const LEN: usize> BoardProgram for Station<'_, E, LEN> {
    type Row = Line;
    type Reason = Refused;

    fn about(&mut self, n: u8) -> Option<Piece> {
        Some(Piece::Text(match n {
            0 => flash_text!("stepwright-laws "),
            1 => self.about.name,
            2 => flash_text!(" hz="),
            3 => return Some(Piece::Number(self.about.mhz.wrapping_mul(1_000_000))),
            4 => flash_text!(" axes=1 late="),
            5 => return Some(Piece::Number(self.engine.late())),
            6 => flash_text!(" can=sum"),
            7 => flash_text!(CONSTANT),
            8 => flash_text!(TRANSITIONS),
            9 => flash_text!(POWER),
            _ => return None,
        }))
    }

    fn axes(&self) -> u8 {
        1
    }

    fn read(&self, letter: u8, numbers: &mut Numbers<'_>) -> Option<Line> {
        Line::read(letter, numbers)
    }

    fn carry_out(&mut self, line: &Line) -> Result<Said, Fault<Refused>> {
        match line {
            Line::Law(recipe) => self.take(recipe)?,
            Line::Change(after, accel) => self.change(*after, *accel).map_err(Fault::Own)?,
            Line::Go(steps) => self.go(steps.unsigned_abs(), *steps >= 0)?,
            Line::Run(forward) => self.go(ENDLESS, *forward)?,
        }
        Ok(Said::Yes)
    }

    fn is_busy(&mut self) -> bool {
        self.is_moving()
    }

    fn position(&mut self, _: u8) -> Option<i64> {
        (!self.uncertain).then(|| self.engine.position(AXIS))
    }

    fn set_zero(&mut self, _: u8) {
        self.engine.set_position(AXIS, 0);
        self.uncertain = false;
    }

    fn mark_unknown(&mut self) {
        self.uncertain = true;
    }

    fn stop(&mut self) {
        if let Some(law) = &mut self.law {
            law.stop();
        }
    }

    fn kill(&mut self) {
        self.uncertain |= self.is_moving();
        self.engine.kill(1 << AXIS);
        self.feed.set_open(false);
        (self.law, self.ready, self.begun) = (None, None, false);
        self.changes = NO_CHANGES;
    }

    /// Computes one delay if the queue has room for it.
    #[inline(never)]
    fn poll(&mut self) {
        if self.law.is_some() {
            self.make();
        } else if self.begun && self.engine.is_idle(AXIS) {
            self.begun = false;
        }
        self.engine.refill();
    }
}

#[cfg(test)]
mod tests {
    use super::{CONSTANT, POWER, TRANSITIONS};
    use crate::choice::LawName;

    #[test]
    fn the_laws_are_called_by_their_names() {
        for law in LawName::HERE {
            let all = [CONSTANT, TRANSITIONS, POWER];
            let named = |list: &&str| list.split(',').any(|word| word == law.name());
            assert_eq!(all.iter().filter(|list| named(list)).count(), 1, "{law:?}");
        }
    }
}
