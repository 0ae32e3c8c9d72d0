//! A motor that goes by a law, ordered over the serial line: without its pins, clock and bytes.
//!
//! ```text
//!   bytes ──► Line ──► Station ──► law: a delay at a time ──► Run of one step ──► queue
//!     ▲                   │        (main loop, some steps ahead)                    │
//!     └──── answers ◄─────┴──────── position, late steps ◄──────── engine ◄─────────┘
//! ```
//!
//! It is the same on a chip (`firmware/avr/src/bin/laws.rs`) and on the virtual board
//! (`stepwright-sim`): what calls it has a [`Control`] and a queue, moves bytes, and calls
//! [`work`](Station::work) as often as it can. A stop or a change of acceleration "from now on"
//! holds from the next delay that is made, behind those that are queued: [`AHEAD`] at most.

use super::choice::{AnyLaw, LawName, Recipe};
use super::line::{ENDLESS, LONGEST, Line, NAME, Refused};
use stepwright::queue::Producer;
use stepwright::{Accel, Control, Run, Ticks};
use stepwright_protocol::{bare, crc, hex};

/// Changes of acceleration that a travel may have ahead of it.
pub const CHANGES: usize = 4;
/// Delays made ahead of the step under way, at most.
pub const AHEAD: u8 = 6;
/// The axis that moves.
const AXIS: u8 = 0;
/// From the order to the change of direction, and from there to the first step: 250 µs.
const LEAD: Ticks = 250;
/// The shortest delay of each law that a board makes without being late, in ticks of 1 MHz.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Costs {
    /// The general form …
    pub austin: Ticks,
    /// … whose acceleration changes.
    pub changing: Ticks,
    /// The listing.
    pub austin_fixed: Ticks,
    /// The linear factor.
    pub linear_factor: Ticks,
    /// The power term, for each of p.
    pub power: Ticks,
    /// Piecewise.
    pub piecewise: Ticks,
}

impl Costs {
    /// An AVR of 16 MHz, by `firmware/rig/tests/laws_line.rs`.
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

/// What a station's board is.
#[derive(Clone, Copy, Debug)]
pub struct About {
    /// Its name: `uno`.
    pub name: &'static str,
    /// The rate of its timer in MHz.
    pub mhz: u32,
    /// How quick it is.
    pub costs: Costs,
}

/// A line as it comes, then, when it has been read, its answer on the way.
struct Answer {
    bytes: [u8; LONGEST],
    length: u8,
    sent: u8,
}

impl Answer {
    fn text(&mut self, text: &str) {
        text.bytes().for_each(|byte| self.byte(byte));
    }

    fn byte(&mut self, byte: u8) {
        if let Some(place) = self.bytes.get_mut(usize::from(self.length)) {
            *place = byte;
            self.length = self.length.wrapping_add(1);
        }
    }

    /// Ends it, with its checksum if it is to have one.
    #[inline(never)]
    fn end(&mut self, summed: bool) {
        if summed {
            let said = self.bytes.get(..usize::from(self.length)).unwrap_or_default();
            let sum = said.iter().fold(0, |sum, byte| crc(sum, *byte));
            [b'*', hex(sum >> 4), hex(sum)].into_iter().for_each(|byte| self.byte(byte));
        }
        self.byte(b'\r');
    }

    #[inline(never)]
    fn number(&mut self, number: u32) {
        let mut digits = [0; 10];
        let (mut rest, mut count) = (number, 0usize);
        for digit in &mut digits {
            *digit = b'0' + (rest % 10) as u8;
            (rest, count) = (rest / 10, count.wrapping_add(1));
            if rest == 0 {
                break;
            }
        }
        digits.iter().take(count).rev().for_each(|digit| self.byte(*digit));
    }
}

/// A motor, its law and its line.
pub struct Station<'q, E, const LEN: usize> {
    engine: E,
    feed: Producer<'q, LEN>,
    about: About,
    recipe: Option<Recipe>,
    /// Accelerations, and after how many steps of a travel each; 0: none.
    changes: [(u32, Accel); CHANGES],
    law: Option<AnyLaw>,
    /// A run that found no room yet.
    ready: Option<Run>,
    /// Pulses of the travel whose delays have been made.
    made: u32,
    last: Ticks,
    /// The engine plays the travel.
    begun: bool,
    uncertain: bool,
    /// Bytes of the line that have come.
    length: u8,
    /// A byte of the line was damaged, or there were too many.
    bad: bool,
    answer: Answer,
}

impl<'q, E: Control, const LEN: usize> Station<'q, E, LEN> {
    /// A motor at rest at 0, without a law.
    pub const fn new(engine: E, feed: Producer<'q, LEN>, about: About) -> Self {
        Station {
            engine,
            feed,
            about,
            recipe: None,
            changes: [(0, Accel::MIN); CHANGES],
            law: None,
            ready: None,
            made: 0,
            last: 0,
            begun: false,
            uncertain: false,
            length: 0,
            bad: false,
            answer: Answer { bytes: [0; LONGEST], length: 0, sent: 0 },
        }
    }

    /// The engine.
    pub fn engine(&mut self) -> &mut E {
        &mut self.engine
    }

    /// Whether the motor moves, or is about to.
    pub fn is_moving(&self) -> bool {
        self.law.is_some() || self.begun
    }

    /// Steps since the power came or the position was 0; `None` once a kill has lost it.
    pub fn position(&self) -> Option<i64> {
        (!self.uncertain).then(|| self.engine.position(AXIS))
    }

    /// A byte of the line has come; `None` is a damaged one. Not to be called while an answer
    /// is on its way ([`is_answering`](Self::is_answering)).
    pub fn receive(&mut self, byte: Option<u8>) {
        match byte {
            Some(b'\r') => self.obey(),
            // Between two lines; within one it is a damaged byte.
            Some(b'\n') if self.length == 0 => {}
            Some(b'\n') => self.bad = true,
            Some(byte) => match self.answer.bytes.get_mut(usize::from(self.length)) {
                Some(place) => {
                    *place = byte;
                    self.length = self.length.wrapping_add(1);
                }
                None => self.bad = true,
            },
            None => self.bad = true,
        }
    }

    /// Whether there is a byte to send.
    pub fn is_answering(&self) -> bool {
        self.answer.sent < self.answer.length
    }

    /// The next byte of the answer.
    pub fn next_byte(&mut self) -> Option<u8> {
        if !self.is_answering() {
            return None;
        }
        let byte = self.answer.bytes.get(usize::from(self.answer.sent)).copied();
        self.answer.sent = self.answer.sent.wrapping_add(1);
        byte
    }

    /// Makes one delay if the queue has room for it. To be called as often as can be.
    #[inline(never)]
    pub fn work(&mut self) {
        if self.law.is_some() {
            self.make();
        } else if self.begun && self.engine.is_idle(AXIS) {
            self.begun = false;
        }
        self.engine.refill();
    }

    fn make(&mut self) {
        if self.ready.is_none() {
            self.ready = self.next();
        }
        let Some(run) = self.ready else {
            // That was the last step.
            self.feed.set_open(false);
            self.law = None;
            return self.begin();
        };
        if self.feed.len() >= AHEAD || self.feed.push(run).is_err() {
            return self.begin();
        }
        self.ready = None;
    }

    /// The engine begins, once some delays are made.
    fn begin(&mut self) {
        if !self.begun {
            self.begun = true;
            self.engine.start(1 << AXIS);
        }
    }

    /// The next step.
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
        self.last = delay;
        let delay = if first { LEAD } else { delay };
        Some(Run::steady(delay.wrapping_mul(self.about.mhz), 1))
    }

    /// Does what the line says, and answers.
    fn obey(&mut self) {
        let text = self.answer.bytes.get(..usize::from(self.length)).unwrap_or_default();
        // What is damaged is not looked into.
        let text = if self.bad { &[] } else { text };
        let marked = text.contains(&b'*');
        let line = match bare(text) {
            Some((line, _)) => Line::read(line).ok_or(Refused::Line),
            None => Err(Refused::Sum),
        };
        (self.length, self.bad) = (0, false);
        (self.answer.length, self.answer.sent) = (0, 0);
        match line.and_then(|line| self.carry_out(line)) {
            Ok(()) => {}
            Err(refused) => {
                let (word, number) = refused.parts();
                self.answer.text("E ");
                self.answer.text(word);
                if let Some(number) = number {
                    self.answer.text(" ");
                    self.answer.number(number);
                }
            }
        }
        self.answer.end(marked);
    }

    /// Does what a line says, and answers but for the end.
    fn carry_out(&mut self, line: Line) -> Result<(), Refused> {
        match line {
            Line::Info => {
                self.introduce();
                return Ok(());
            }
            Line::Look => {
                self.look();
                return Ok(());
            }
            Line::Law(recipe) => self.take(&recipe)?,
            Line::Change(after, accel) => self.change(after, accel)?,
            Line::Go(steps) => self.go(steps.unsigned_abs(), steps >= 0)?,
            Line::Run(forward) => self.go(ENDLESS, forward)?,
            Line::Stop => {
                if let Some(law) = &mut self.law {
                    law.stop();
                }
            }
            Line::Kill => self.kill(),
            Line::Zero => self.zero()?,
        }
        self.answer.text("Y");
        Ok(())
    }

    fn rests(&self) -> Result<(), Refused> {
        if self.is_moving() { Err(Refused::Moving) } else { Ok(()) }
    }

    #[inline(never)]
    fn take(&mut self, recipe: &Recipe) -> Result<(), Refused> {
        self.rests()?;
        if !recipe.is_sound() {
            return Err(Refused::Range);
        }
        let least = self.about.costs.of(recipe);
        if recipe.shortest() < least {
            return Err(Refused::Fast(least));
        }
        self.recipe = Some(*recipe);
        self.changes = [(0, Accel::MIN); CHANGES];
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
        *free.ok_or(Refused::Range)? = (after, accel);
        Ok(())
    }

    #[inline(never)]
    fn go(&mut self, pulses: u32, forward: bool) -> Result<(), Refused> {
        self.rests()?;
        let recipe = self.recipe.as_ref().ok_or(Refused::Law)?;
        if pulses == 0 {
            return Ok(());
        }
        self.law = Some(recipe.delays(pulses));
        (self.made, self.last, self.ready) = (0, 0, None);
        self.feed.set_open(true);
        // The queue is empty.
        let _ = self.feed.push(Run::turn(LEAD.wrapping_mul(self.about.mhz), forward));
        Ok(())
    }

    fn kill(&mut self) {
        self.uncertain |= self.is_moving();
        self.engine.kill(1 << AXIS);
        self.feed.set_open(false);
        (self.law, self.ready, self.begun) = (None, None, false);
    }

    fn zero(&mut self) -> Result<(), Refused> {
        self.rests()?;
        self.engine.set_position(AXIS, 0);
        self.uncertain = false;
        Ok(())
    }

    #[inline(never)]
    fn introduce(&mut self) {
        self.answer.text(NAME);
        self.answer.text(" ");
        self.answer.text(self.about.name);
        self.answer.text(" hz=");
        self.answer.number(self.about.mhz.wrapping_mul(1_000_000));
        let mut between = " can=";
        for law in LawName::HERE {
            self.answer.text(core::mem::replace(&mut between, ","));
            self.answer.text(law.name());
        }
    }

    #[inline(never)]
    fn look(&mut self) {
        let position = self.engine.position(AXIS);
        self.answer.number(self.is_moving().into());
        self.answer.text(",");
        self.answer.number((!self.uncertain).into());
        self.answer.text(if position < 0 { ",-" } else { "," });
        self.answer.number(u32::try_from(position.unsigned_abs()).unwrap_or(u32::MAX));
        self.answer.text(",");
        self.answer.number(self.engine.late());
        self.answer.text(",");
        self.answer.number(self.last);
    }
}
