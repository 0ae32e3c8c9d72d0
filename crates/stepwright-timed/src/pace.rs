//! The interrupt's half: the times of the steps.
//!
//! ```text
//!            update ▼
//!   ────┬───────────┬───────────┬──────────────┬─── steps
//!       │ old       │ new       │ new          │      ideal
//!       │ old       │ old TOP16 · new prescaler│ new  latched
//! ```
//!
//! The present interval is never changed once it has begun, so that a shortened top can't be
//! missed. An update writes two numbers, the next interval and the one after, which the interrupt
//! takes over. (The Arduino driver, third consideration of section 4.)

use super::order::{Control, Status};
use super::ramp::Ramp;
use crate::fit::{Fitted, Hardware};
use stepwright::units::Ticks;

/// When a new top takes effect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Model {
    /// At once: with the interval that begins at the step where the update is made.
    #[default]
    Ideal,
    /// As on a timer in fast PWM, whose prescaler changes at once and whose compare register
    /// changes at the end of the period: the one step after an update lasts the old 16-bit top at
    /// the new prescaler.
    Latched,
}

impl Model {
    /// The interval that begins at the next step, and those after it.
    #[inline]
    pub(crate) fn change(self, old_top: u32, new: &Fitted) -> Change {
        let (shift, after) = (new.shift(), new.interval());
        let next = match self {
            Model::Ideal => after,
            Model::Latched => old_top.wrapping_shl(shift.into()),
        };
        Change { next, after, shift }
    }
}

/// The two intervals that an update writes, both at one prescaler.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    next: Ticks,
    after: Ticks,
    /// log₂ of the prescaler.
    shift: u8,
}

impl Change {
    /// What is left of the change once its first interval has begun.
    fn rest(self) -> Option<Change> {
        (self.next != self.after).then_some(Change { next: self.after, ..self })
    }
}

/// The step interrupt's state of a motion. Between the calls of [`advance`](Pace::advance) the
/// foreground reads and changes it.
#[derive(Clone, Debug)]
pub struct Pace {
    /// The present interval: it stays as long as the speed does.
    now: Ticks,
    /// log₂ of its prescaler.
    shift: u8,
    /// The number of steps left; 0 is endless.
    steps_left: u32,
    moving: bool,
    /// Whether the due event is the end of the milliseconds, and not a step.
    ends: bool,
    /// Whether the next event takes over `next`, or milliseconds must be counted.
    rare: bool,
    /// Whether updates will be made here, under `IRQ_TIMING`.
    live: bool,
    /// Clocks from the next event to the next update, which is due then if this is not above 0.
    wait: i32,
    pub(crate) status: Status,
    /// The two intervals that an update has written, if any.
    change: Option<Change>,
    /// Clocks from the next event to the end by milliseconds, if there is one.
    millis: Option<u64>,
    /// The values for updates, if they are made in this half.
    clocked: Option<Clocked>,
}

/// Updates inside the step interrupt. They need no clock: the interrupt knows how long each
/// interval is.
#[derive(Clone, Debug)]
struct Clocked {
    hardware: Hardware,
    model: Model,
    ramp: Ramp,
    period: Period,
    update_ms: u16,
    /// When the last update was due: T in the article.
    time: u32,
    /// The top in the compare register.
    top: u32,
}

/// A period of milliseconds in clocks, if a millisecond is not a whole number of clocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Period {
    whole: u32,
    /// The remaining thousandths of a clock, and their sum so far.
    part: u16,
    sum: u16,
}

impl Period {
    /// `None` beyond 2³² clocks.
    pub fn of(millis: u16, hz: u32) -> Option<Period> {
        let millis = u32::from(millis);
        let part = millis * (hz % 1000); // below 2²⁶
        let whole = millis.checked_mul(hz / 1000)?.checked_add(part / 1000)?;
        // 999: an update that is due within a clock is due at its end.
        (whole < i32::MAX as u32).then_some(Period { whole, part: (part % 1000) as u16, sum: 999 })
    }

    /// The next period.
    fn next(&mut self) -> i32 {
        self.sum = self.sum.wrapping_add(self.part);
        if self.sum >= 1000 {
            self.sum = self.sum.wrapping_sub(1000);
            return self.whole.wrapping_add(1) as i32;
        }
        self.whole as i32
    }
}

/// The clocks of this many milliseconds: less than 2⁶³.
pub(crate) fn clocks_of(millis: u32, hz: u32) -> u64 {
    let (whole, part) = (hz / 1000, hz % 1000);
    // Seconds and the rest apart, so that the product with `part` needs no 64-bit division by 1000.
    let rest = (millis / 1000) * part + (millis % 1000) * part / 1000;
    u64::from(millis) * u64::from(whole) + u64::from(rest)
}

/// The beginning of a motion.
pub(crate) struct Begin {
    pub hardware: Hardware,
    pub model: Model,
    pub ramp: Ramp,
    pub fitted: Fitted,
    /// The period of the updates, if there are any.
    pub period: Option<Period>,
    pub update_ms: u16,
    /// The number of steps; 0 is endless.
    pub steps: u32,
    /// Clocks to the end by milliseconds.
    pub millis: Option<u64>,
    /// The caller's milliseconds.
    pub now: u32,
}

impl Pace {
    /// At rest.
    pub const fn idle() -> Pace {
        Pace {
            now: 0,
            shift: 0,
            steps_left: 0,
            moving: false,
            ends: false,
            rare: false,
            live: false,
            wait: 0,
            status: Status::NONE,
            change: None,
            millis: None,
            clocked: None,
        }
    }

    /// A motion whose first step comes an interval after its beginning.
    pub(crate) fn new(with: Begin) -> Pace {
        let interval = with.fitted.interval();
        let mut period = with.period.unwrap_or_default();
        let clocked = with.ramp.control.has(Control::IRQ_TIMING);
        let mut pace = Pace {
            now: interval,
            shift: with.fitted.shift(),
            steps_left: with.steps,
            moving: true,
            ends: false,
            rare: with.millis.is_some(),
            live: clocked && with.period.is_some(),
            wait: period.next().saturating_sub_unsigned(interval),
            status: if with.period.is_some() { Status::NONE } else { Status::SPIN_FIXED },
            change: None,
            millis: with.millis,
            clocked: None,
        };
        if clocked {
            pace.clocked = Some(Clocked {
                hardware: with.hardware,
                model: with.model,
                ramp: with.ramp,
                period,
                update_ms: with.update_ms,
                time: with.now,
                top: with.fitted.top(),
            });
        }
        pace.spend();
        pace
    }

    /// Whether the motor moves.
    pub const fn is_moving(&self) -> bool {
        self.moving
    }

    /// The number of steps left; 0 if the motion is endless or at rest.
    pub const fn steps_left(&self) -> u32 {
        self.steps_left
    }

    /// The speed and its updates, if they are made in this half.
    #[inline(always)]
    pub(crate) const fn ramp(&self) -> Option<&Ramp> {
        match &self.clocked {
            Some(clocked) => Some(&clocked.ramp),
            None => None,
        }
    }

    /// When the last update was due, if updates are made in this half.
    #[inline(always)]
    pub(crate) const fn time(&self) -> Option<u32> {
        match &self.clocked {
            Some(clocked) => Some(clocked.time),
            None => None,
        }
    }

    /// Clocks from the last event, or from the beginning, to the next event.
    pub const fn interval(&self) -> Ticks {
        self.now
    }

    /// The interval in the counts of a 16-bit timer: `top` counts at a prescaler of 2^`shift`. An
    /// interval that ends with the milliseconds is rounded down.
    pub const fn counts(&self) -> Counts {
        Counts { top: self.now.wrapping_shr(self.shift as u32), shift: self.shift }
    }

    /// The `top` after this one, as far as it is known: the value for a buffered compare register
    /// meanwhile. With [`Latched`](Model::Latched) it is that of the next interval unless the
    /// foreground writes another before.
    pub const fn next_top(&self) -> u32 {
        match self.change {
            Some(change) => change.next.wrapping_shr(change.shift as u32),
            None => self.counts().top,
        }
    }

    /// Whether the next [`advance`](Pace::advance) may lead to another interval than the present
    /// one; if not, it is a short call.
    #[inline(always)]
    const fn is_changing(&self) -> bool {
        (self.live && self.wait <= 0) || self.rare
    }

    /// Whether the due event is a step. Then make the step before anything else, so that edges are
    /// even. It is not a step when the milliseconds have passed.
    #[inline(always)]
    pub const fn is_step(&self) -> bool {
        self.moving && !self.ends
    }

    /// Called after the due event: returns the clocks to the next one, `None` if it was the last.
    ///
    /// At an unchanged speed this is two subtractions.
    #[inline(always)]
    pub fn advance(&mut self) -> Option<Ticks> {
        if !self.moving {
            return None;
        }
        if self.steps_left != 0 {
            self.steps_left = self.steps_left.wrapping_sub(1);
            if self.steps_left == 0 {
                self.reach();
                return None;
            }
        }
        if self.is_changing() {
            return self.change();
        }
        self.wait = self.wait.wrapping_sub(self.now as i32);
        Some(self.now)
    }

    /// The rest of `advance`, if the next interval may be another one.
    #[cold]
    #[inline(never)]
    fn change(&mut self) -> Option<Ticks> {
        if self.ends {
            self.reach();
            return None;
        }
        // The register takes over the value that was written for it …
        if let Some(change) = self.change {
            self.play(change);
        }
        // … unless the update at this step changes it at once.
        if self.live && self.wait <= 0 {
            self.update();
        }
        // Saturating: for when the interval of an update and of a step exceed 2³¹ clocks.
        self.wait = self.wait.saturating_sub_unsigned(self.now);
        if self.millis.is_some() {
            self.spend();
        }
        self.rare = self.change.is_some() || self.millis.is_some();
        Some(self.now)
    }

    /// Makes the due update.
    fn update(&mut self) {
        let Some(clocked) = &mut self.clocked else { return };
        self.wait = self.wait.saturating_add(clocked.period.next());
        clocked.time = clocked.time.wrapping_add(clocked.update_ms.into());
        let updated = clocked.ramp.update(&clocked.hardware);
        self.live = self.status.note(&updated, clocked.ramp.counts);
        if let Ok(fitted) = &updated {
            let change = clocked.model.change(clocked.top, fitted);
            clocked.top = fitted.top();
            self.play(change);
        }
    }

    /// Begins the first interval of a change.
    fn play(&mut self, change: Change) {
        (self.now, self.shift) = (change.next, change.shift);
        self.change = change.rest();
    }

    /// Counts the present interval against the milliseconds, or cuts it short with them.
    fn spend(&mut self) {
        if let Some(left) = &mut self.millis {
            if u64::from(self.now) >= *left {
                self.now = *left as Ticks;
                self.ends = true;
            }
            *left = left.wrapping_sub(self.now.into());
        }
    }

    #[cold]
    #[inline(never)]
    fn reach(&mut self) {
        self.moving = false;
        self.steps_left = 0;
        self.status = self.status.without(Status::SPIN_FIXED).and(Status::REACHED);
    }

    /// Writes the change of the foreground's update: two numbers, which the next event takes over.
    #[inline]
    pub(crate) fn put_down(&mut self, change: Change) {
        self.change = Some(change);
        self.rare = true;
    }
}

/// An interval in counts of a timer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// The count.
    pub top: u32,
    /// log₂ of the prescaler.
    pub shift: u8,
}
