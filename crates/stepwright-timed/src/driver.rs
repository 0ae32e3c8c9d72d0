//! The foreground's half: orders, the caller's update check, callbacks.

use super::dump::Dump;
use super::order::{Call, Code, Control, SetSpeed, Status};
use super::pace::{Begin, Model, Pace, Period, clocks_of};
use super::ramp::Ramp;
use crate::fit::{Hardware, Misfit};

/// The foreground's access to the interrupt's half.
///
/// On a chip an implementation MUST hold the step interrupt off during each of these calls; they
/// take some dozen cycles, except for [`begin`](Hold::begin).
pub trait Hold {
    /// Reads or changes the interrupt's half.
    fn with<R>(&mut self, look: impl FnOnce(&mut Pace) -> R) -> R;

    /// Begins a motion: `pace` replaces the previous one, its first event comes
    /// [`interval`](Pace::interval) clocks from now, and the drivers are switched on.
    fn begin(&mut self, pace: Pace, forward: bool);

    /// Ends all events and switches the drivers off. The motor's pattern stays.
    fn stop(&mut self);
}

/// The timed driver, for one motor.
///
/// ```
/// use stepwright_timed::{Code, Control, Driver, Hold, Model, Pace, SetSpeed, Status};
/// use stepwright_timed::fit::Hardware;
///
/// /// A host has no interrupt to hold off.
/// struct Here(Pace);
/// impl Hold for Here {
///     fn with<R>(&mut self, look: impl FnOnce(&mut Pace) -> R) -> R {
///         look(&mut self.0)
///     }
///     fn begin(&mut self, pace: Pace, _forward: bool) {
///         self.0 = pace;
///     }
///     fn stop(&mut self) {}
/// }
///
/// let mut here = Here(Pace::idle());
/// let mut driver = Driver::new(Hardware::avr16(16_000_000), Model::Ideal);
/// let order = SetSpeed { limit: 3, ..SetSpeed::fixed(Control::DRV_EN, 32_000) };
/// assert_eq!(driver.set_speed(&mut here, &order, 0), Code::FINE);
/// // What the step interrupt does.
/// assert_eq!(here.0.interval(), 32_000);
/// assert_eq!([(); 3].map(|()| here.0.advance()), [Some(32_000), Some(32_000), None]);
///
/// let mut calls = Vec::new();
/// driver.update_check(&mut here, 7, |call| calls.push(call));
/// driver.update_check(&mut here, 8, |call| calls.push(call));
/// assert_eq!(calls.len(), 1);
/// assert!(driver.status(&mut here).has(Status::REACHED));
/// ```
#[derive(Clone, Debug)]
pub struct Driver {
    hardware: Hardware,
    model: Model,
    order: SetSpeed,
    /// The caller's milliseconds when the last update was due: T in the article.
    time: u32,
    end: u32,
    /// The updates that the caller's check makes, without `IRQ_TIMING`.
    ramp: Ramp,
    live: bool,
    /// The top in the compare register.
    top: u32,
}

impl Driver {
    /// A driver at rest.
    pub const fn new(hardware: Hardware, model: Model) -> Driver {
        Driver {
            hardware,
            model,
            order: SetSpeed::STOP,
            time: 0,
            end: 0,
            ramp: Ramp::OFF,
            live: false,
            top: 0,
        }
    }

    /// The timer.
    pub const fn hardware(&self) -> &Hardware {
        &self.hardware
    }

    /// `motorSetSpeed`: carries out an order, at `now` milliseconds of the caller's clock.
    ///
    /// The first step comes one interval later. A stop switches the drivers off. A refused
    /// order leaves the motion as it is and sets the status.
    pub fn set_speed(&mut self, hold: &mut impl Hold, order: &SetSpeed, now: u32) -> Code {
        if !order.control.has(Control::DRV_EN) || order.top == 0 {
            let time = self.t(hold);
            hold.stop();
            hold.with(|pace| *pace = Pace::idle());
            *self = Driver { time, ..Driver::new(self.hardware, self.model) };
            return Code::FINE;
        }
        let variable = order.control.has(Control::SPEED_VARIABLE);
        let millis = order.control.has(Control::ENDPOINT_MILLIS) && order.limit != 0;
        let updates =
            variable && order.modification != 0 && order.update_ms != 0 && order.mod_counts != 0;

        let fitted = match self.hardware.fit(order.top) {
            Ok(fitted) => fitted,
            Err(misfit) => {
                hold.with(|pace| pace.status = pace.status.and(Status::of(misfit)));
                return match misfit {
                    Misfit::TooFast { .. } => Code::TOO_FAST,
                    Misfit::TooSlow { .. } => Code::TOO_SLOW,
                };
            }
        };
        let period = Period::of(order.update_ms, self.hardware.hz());
        if updates && period.is_none() {
            return Code::UPDATE_TOO_LONG;
        }

        self.order = if variable {
            *order
        } else {
            let SetSpeed { control, top, limit, .. } = *order;
            SetSpeed { limit, ..SetSpeed::fixed(control, top) }
        };
        self.ramp = Ramp::new(&self.order);
        self.time = now;
        self.end = if millis { now.wrapping_add(order.limit) } else { 0 };
        self.live = updates && !order.control.has(Control::IRQ_TIMING);
        self.top = fitted.top();
        let pace = Pace::new(Begin {
            hardware: self.hardware,
            model: self.model,
            ramp: self.ramp,
            fitted,
            period: if updates { period } else { None },
            update_ms: order.update_ms,
            steps: if millis { 0 } else { order.limit },
            millis: millis.then(|| clocks_of(order.limit, self.hardware.hz())),
            now,
        });
        hold.begin(pace, !order.control.has(Control::DIRECTION));
        if variable && !updates {
            Code::WARN_NO_UPDATES
        } else if updates && !self.ramp.stays_in_range(&self.hardware) {
            Code::WARN_RANGE
        } else {
            Code::FINE
        }
    }

    /// `motorTimerUpdateCheck`: called by the program every 2 to 50 ms. Makes the update that is
    /// due at `now` milliseconds, and calls back, for each [`Call`] at most once per order. Does
    /// nothing under [`Control::IRQ_TIMING`].
    ///
    /// Updates are due at whole multiples of their interval after the order, however late this is
    /// called; each call makes at most one update.
    pub fn update_check(&mut self, hold: &mut impl Hold, now: u32, mut call: impl FnMut(Call)) {
        if self.order.control.has(Control::IRQ_TIMING) {
            return;
        }
        let moving = hold.with(|pace| pace.is_moving());
        let interval = self.order.update_ms.into();
        if self.live && moving && now.wrapping_sub(self.time) >= interval {
            self.time = self.time.wrapping_add(interval);
            self.update(hold);
        }
        for (what, call_for) in [
            (Status::FAULT.and(Status::FAULT_CALLED), Call::Fault),
            (Status::REACHED.and(Status::REACH_CALLED), Call::Reached),
        ] {
            if self.calls(hold, what) {
                call(call_for);
            }
        }
    }

    fn update(&mut self, hold: &mut impl Hold) {
        let updated = self.ramp.update(&self.hardware);
        if let Ok(fitted) = &updated {
            let change = self.model.change(self.top, fitted);
            self.top = fitted.top();
            hold.with(|pace| pace.put_down(change));
        }
        self.live = hold.with(|pace| pace.status.note(&updated, self.ramp.counts));
    }

    /// Whether a callback is due now: its condition holds, and it has not been called yet.
    fn calls(&self, hold: &mut impl Hold, both: Status) -> bool {
        hold.with(|pace| {
            let what = both.without(Status::FAULT_CALLED).without(Status::REACH_CALLED);
            let due = pace.status.has(what) && !pace.status.has(both);
            if due {
                pace.status = pace.status.and(both);
                if both.has(Status::FAULT) && pace.status.has(Status::TIMER_DIV_ERROR) {
                    pace.status = pace.status.and(Status::TIMER_DIV_CALLED);
                }
            }
            due
        })
    }

    /// Whether the caller's check still has updates to make.
    pub(crate) const fn is_waiting(&self) -> bool {
        self.live
    }

    /// `motorReadStatus`.
    pub fn status(&self, hold: &mut impl Hold) -> Status {
        hold.with(|pace| pace.status)
    }

    /// T in the article.
    fn t(&self, hold: &mut impl Hold) -> u32 {
        hold.with(|pace| pace.time().unwrap_or(self.time))
    }

    /// The fields of the article's debug dump. `pattern` is that of the motor: 0 to 3.
    ///
    /// Each number is read by itself, so that the step interrupt is held off for some cycles only:
    /// a value that changes meanwhile may be newer than the one before it, as in the article.
    pub fn dump(&self, hold: &mut impl Hold, pattern: u8) -> Dump {
        let ramp = self.ramp;
        let top = hold.with(|pace| pace.ramp().unwrap_or(&ramp).top);
        let modification = hold.with(|pace| pace.ramp().unwrap_or(&ramp).modification);
        let counts = hold.with(|pace| pace.ramp().unwrap_or(&ramp).counts);
        Dump {
            control: self.order.control,
            top,
            modification,
            steps_left: hold.with(|pace| pace.steps_left()),
            time: self.t(hold),
            status: self.status(hold),
            update_ms: self.order.update_ms,
            end: self.end,
            counts,
            pattern: if self.order == SetSpeed::STOP { 0 } else { pattern },
        }
    }
}
