#![no_std]
//! Tests whether a [`StepTimer`] keeps its contract.
//!
//! ```text
//!   check ── with ──► TimerProbe ── wake_at ──► timer
//!     │ idle            ▲                    │
//!     │                 └──── on_compare ◄───┘ interrupt
//!     └─► Checked, or the TimerFault
//! ```
//!
//! [`TimerProbe`] takes the place of an engine: it sets the compare register for one deadline, and the
//! interrupt tells it when the deadline has come. [`check`] tries deadlines ahead, now and passed; each wrap of
//! the counter that can be reached; an interrupt without a reason; an interrupt that was held off; and a
//! program that was interrupted between a look at the counter and the write of the compare register, as by an
//! interrupt of higher priority. It runs where the timer runs: on a chip, in a simulator, on a PC.

mod fault;
mod probe;

pub use fault::TimerFault;
pub use probe::TimerProbe;

use stepwright::Ticks;
use stepwright::timer::{Count, StepTimer};

/// A timer with its interrupt, which calls [`TimerProbe::on_compare`].
pub trait TestPort {
    /// The timer under test.
    type Timer: StepTimer;

    /// Calls `ask` with the probe while the step interrupt is held off. An interrupt that becomes pending
    /// meanwhile comes afterwards.
    fn with<R>(&mut self, ask: impl FnOnce(&mut TimerProbe<Self::Timer>) -> R) -> R;

    /// Lets the interrupt come and time pass, in a model by a tick. A chip has nothing to do here.
    fn idle(&mut self);

    /// Lets a model's time pass by a tick while the program waits with the interrupt held off. A chip has
    /// nothing to do here.
    fn tick(timer: &mut Self::Timer) {
        let _ = timer;
    }

    /// Sets the counter, so that the test need not wait for a wrap. False if the timer can't.
    fn set_count(&mut self, count: <Self::Timer as StepTimer>::Count) -> bool {
        let _ = count;
        false
    }
}

/// The tests that ran without a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Checked {
    /// The number of deadlines.
    pub values: u32,
    /// Interrupts without a deadline. They are allowed, but cost time.
    pub spurious: u32,
    /// Whether the counter wrapped during the test. A counter of 32 bits has to be
    /// [set](TestPort::set_count) for that.
    pub wrapped: bool,
}

/// Ticks from the counter to the deadline; negative if it has passed.
const NEAR: [i32; 15] = [0, 1, 2, 3, 5, 10, 100, 1_000, 7_000, -1, -2, -3, -10, -100, -7_000];

/// Calls of [`TestPort::idle`] without a change after which a counter counts as standing still.
const STANDS: u32 = 10_000_000;

/// Tests a timer. Its interrupt has to come within `latency` ticks, 1 to a quarter of the counter, after a
/// deadline, or after the moment from which it is no longer held off.
///
/// # Errors
/// The first [`TimerFault`].
pub fn check<P: TestPort>(port: &mut P, latency: Ticks) -> Result<Checked, TimerFault> {
    let mut trial = Trial { port, latency: latency as i32, values: 0 };
    for ahead in NEAR {
        trial.deadline(ahead, 0)?;
        // The interrupt is held off until the deadline has passed.
        trial.deadline(ahead, 50)?;
    }
    // The program is interrupted for this long before it writes the compare register.
    for ahead in 1..=12 {
        for away in 0..=16 {
            trial.away(ahead, away)?;
        }
    }
    trial.replaced()?;
    trial.for_nothing()?;
    let wrapped = trial.wraps()?;
    let values = trial.values;
    let spurious = port.with(|probe| probe.spurious());
    Ok(Checked { values, spurious, wrapped })
}

struct Trial<'p, P> {
    port: &'p mut P,
    latency: i32,
    values: u32,
}

/// The count of a port's timer.
type CountOf<P> = <<P as TestPort>::Timer as StepTimer>::Count;

impl<P: TestPort> Trial<'_, P> {
    /// Tries a deadline `ahead` ticks ahead, set while the interrupt is held off, which stays so for `held`
    /// ticks.
    fn deadline(&mut self, ahead: i32, held: i32) -> Result<(), TimerFault> {
        let at = self.port.with(|probe| {
            let now = probe.timer().now();
            let at = now.plus(ahead as Ticks);
            probe.set(at);
            probe.pass(now, held, P::tick).then_some(at)
        });
        self.comes(at.ok_or(TimerFault::StandsStill)?, ahead)
    }

    /// Tries a deadline that is set `away` ticks after the look at the counter.
    fn away(&mut self, ahead: i32, away: i32) -> Result<(), TimerFault> {
        let at = self.port.with(|probe| {
            let now = probe.timer().now();
            let at = now.plus(ahead as Ticks);
            let passed = probe.pass(now, away, P::tick);
            probe.set(at);
            passed.then_some(at)
        });
        self.comes(at.ok_or(TimerFault::StandsStill)?, ahead.wrapping_sub(away))
    }

    /// Replaces a deadline by a later and by a sooner one.
    fn replaced(&mut self) -> Result<(), TimerFault> {
        for (first, then) in [(20, 2_000), (2_000, 20), (3, 500), (-5, 500)] {
            let at = self.port.with(|probe| {
                let now = probe.timer().now();
                probe.set(now.plus(first as Ticks));
                let at = now.plus(then as Ticks);
                probe.set(at);
                at
            });
            self.comes(at, then)?;
        }
        Ok(())
    }

    /// Calls the interrupt while nothing is due.
    fn for_nothing(&mut self) -> Result<(), TimerFault> {
        for ahead in [3, 50, 1_000] {
            let at = self.port.with(|probe| {
                let at = probe.timer().now().plus(ahead as Ticks);
                probe.set(at);
                probe.on_compare();
                at
            });
            self.comes(at, ahead)?;
        }
        Ok(())
    }

    /// Tries deadlines on both sides of each carry: from the low half of a counter, at its sign bit, and at
    /// its wrap. Returns whether the counter wrapped.
    fn wraps(&mut self) -> Result<bool, TimerFault> {
        for k in [15, 16, 23, 24, 31, 32].into_iter().filter(|k| *k <= 2 + CountOf::<P>::HOP_BITS) {
            let carry = 1u64.wrapping_shl(k.into()) as Ticks;
            for (before, ahead) in [(30, 60), (60, 30), (0, 1), (1, 1), (1, 0), (0, -1), (0, -40)] {
                let near = CountOf::<P>::ZERO.0.plus(carry.wrapping_sub(before));
                if !self.go_to(near)? {
                    return Ok(false);
                }
                self.deadline(ahead, 0)?;
                self.deadline(ahead, 90)?;
            }
        }
        Ok(true)
    }

    /// Waits until the counter is at this count or a little beyond. False if that takes a turn of 32 bits.
    fn go_to(&mut self, count: CountOf<P>) -> Result<bool, TimerFault> {
        if self.port.set_count(count) {
            return Ok(true);
        }
        loop {
            let left = count.since(self.port.with(|probe| probe.timer().now()));
            let hop = CountOf::<P>::HOP as i32;
            if CountOf::<P>::WIDE {
                return Ok(false);
            }
            let last = (1..=hop).contains(&left);
            self.deadline(if last { left } else { hop }, 0)?;
            if last {
                return Ok(true);
            }
        }
    }

    /// Waits for the deadline that was `ahead` ticks ahead.
    fn comes(&mut self, at: CountOf<P>, ahead: i32) -> Result<(), TimerFault> {
        let begun = self.port.with(|probe| probe.timer().now());
        // For a deadline that has passed, the time counts from now.
        let from = if at.is_after(begun) { at } else { begun };
        let (mut before, mut same) = (begun, 0);
        loop {
            self.port.idle();
            let (served, now) = self.port.with(|probe| (probe.served(), probe.timer().now()));
            if let Some(when) = served {
                let early = at.since(when);
                self.values = self.values.saturating_add(1);
                return if early > 0 {
                    Err(TimerFault::Early { ahead, by: early })
                } else {
                    Ok(())
                };
            }
            if now.since(from) > self.latency {
                return Err(TimerFault::Lost { ahead, waited: now.since(begun) });
            }
            if now.since(before) < 0 {
                return Err(TimerFault::Backward);
            }
            same = if now == before { same + 1 } else { 0 };
            if same > STANDS {
                return Err(TimerFault::StandsStill);
            }
            before = now;
        }
    }
}
