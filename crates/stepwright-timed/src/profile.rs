//! Timed speed as a profile: an iterator of delays, and a feed of the engine.

use super::driver::{Driver, Hold};
use super::order::{Code, Control, SetSpeed};
use super::pace::{Model, Pace, clocks_of};
use crate::fit::Hardware;
use stepwright::queue::{Feed, Taken};
use stepwright::run::Run;
use stepwright::units::Ticks;

/// The delays of an order, each the time before its step; the first is one interval.
///
/// ```
/// use stepwright_timed::{Control, Model, SetSpeed, Timed};
/// use stepwright_timed::fit::Hardware;
/// // 100 steps/s, 20 ms later 50: at 1 MHz.
/// let order = SetSpeed {
///     control: Control::DRV_EN | Control::SPEED_VARIABLE | Control::IRQ_TIMING,
///     top: 10_000,
///     limit: 5,
///     modification: 10_000,
///     update_ms: 20,
///     mod_counts: 1,
/// };
/// let delays = Timed::new(Hardware::capture16(1_000_000), Model::Ideal, &order)?;
/// assert_eq!(delays.collect::<Vec<_>>(), [10_000, 10_000, 20_000, 20_000, 20_000]);
/// # Ok::<(), stepwright_timed::Code>(())
/// ```
#[derive(Clone, Debug)]
pub struct Timed {
    driver: Driver,
    here: Here,
    /// The delay before the next event.
    due: Option<Ticks>,
    /// The interval of the caller's check in milliseconds, without `IRQ_TIMING`.
    poll_ms: u32,
    /// Milliseconds of the last check, and clocks from the order to the last event.
    polled: u32,
    clocks: u64,
}

/// A foreground without an interrupt to hold off.
#[derive(Clone, Debug)]
struct Here(Pace);

impl Hold for Here {
    fn with<R>(&mut self, look: impl FnOnce(&mut Pace) -> R) -> R {
        look(&mut self.0)
    }
    fn begin(&mut self, pace: Pace, _: bool) {
        self.0 = pace;
    }
    fn stop(&mut self) {
        self.0 = Pace::idle();
    }
}

impl Timed {
    /// The delays of an order. Without [`Control::IRQ_TIMING`] the updates are checked every 20 ms,
    /// as the article recommends.
    ///
    /// # Errors
    /// The code below 0 with which the driver refuses the order.
    pub fn new(hardware: Hardware, model: Model, order: &SetSpeed) -> Result<Timed, Code> {
        Timed::polled(hardware, model, order, 20)
    }

    /// The delays of an order. Without [`Control::IRQ_TIMING`] the updates are checked every
    /// `poll_ms` ms (at least 1).
    ///
    /// # Errors
    /// Those of [`new`](Timed::new).
    pub fn polled(
        hardware: Hardware,
        model: Model,
        order: &SetSpeed,
        poll_ms: u32,
    ) -> Result<Timed, Code> {
        let (mut driver, mut here) = (Driver::new(hardware, model), Here(Pace::idle()));
        let code = driver.set_speed(&mut here, order, 0);
        if code.is_error() {
            return Err(code);
        }
        let due = here.0.is_moving().then(|| here.0.interval());
        Ok(Timed { driver, here, due, poll_ms: poll_ms.max(1), polled: 0, clocks: 0 })
    }

    /// Whether the order goes forward.
    pub const fn forward(order: &SetSpeed) -> bool {
        !order.control.has(Control::DIRECTION)
    }

    /// Makes the checks up to the present.
    fn check(&mut self) {
        let hz = self.driver.hardware().hz();
        while self.here.0.is_moving() {
            let next = self.polled.saturating_add(self.poll_ms);
            if clocks_of(next, hz) > self.clocks || next == self.polled {
                return;
            }
            self.polled = next;
            self.driver.update_check(&mut self.here, next, |_| {});
            if !self.driver.is_waiting() {
                self.polled = u32::MAX;
            }
        }
    }
}

impl Iterator for Timed {
    type Item = Ticks;

    fn next(&mut self) -> Option<Ticks> {
        let delay = self.due?;
        self.clocks = self.clocks.saturating_add(delay.into());
        if self.driver.is_waiting() {
            self.check();
        }
        let step = self.here.0.is_step();
        self.due = self.here.0.advance();
        step.then_some(delay)
    }
}

/// One step at a time, as the engine asks for them.
impl Feed for Timed {
    fn take(&mut self) -> Taken {
        match self.next() {
            Some(delay) => Taken::Run(Run::steady(delay, 1)),
            None => Taken::End,
        }
    }

    fn clear(&mut self) {
        self.due = None;
    }
}
