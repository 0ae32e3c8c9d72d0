//! Homing by stall.
//!
//! ```text
//!             current, dwell      least                       stop
//!   start ────────────────────────┊──────────────────────────►│  first pass: a stall
//!                                            ◄────────────────│  back off
//!                                            ────────────────►│  second pass, slower
//!                                            ◄────────────────│  back off; the position is known
//! ```

use embassy_futures::select::{Either, select};
use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::digital::Wait;
use embedded_io_async::{Read, Write};
use stepwright::profile::Unfit;
use stepwright::{Accel, AxisLimits, Control, MoveError, Speed};
use stepwright_embassy::{AsyncAxis, Outcome};

use crate::error::NotHomed;
use crate::line::Tmc2209;

/// How an axis is homed against a stop, without a switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StallHoming {
    /// The stop lies forward.
    pub forward: bool,
    /// Of the first pass. Well above the speed from which on stalls are told.
    pub speed: Speed,
    /// Of the second pass, likewise.
    pub second: Speed,
    /// Of both, and of backing off. The ramp up is a part of the least distance.
    pub accel: Accel,
    /// While it homes, in mA: less than else, so that the stop is met softly.
    pub milliamps: u16,
    /// ms after each change of the current: StallGuard's measure settles.
    pub dwell: u32,
    /// A stall in less than this many steps is none: the motor has not been at speed, or stood at the
    /// stop. Then it backs off by twice as many, and tries once more.
    pub least: u32,
    /// Steps back from the stop. The second pass is twice as many at most.
    pub back_off: u32,
    /// The most steps that it searches for the stop.
    pub most: u32,
    /// What the position of the stop is called.
    pub position: i64,
}

impl StallHoming {
    /// Homes an axis: it ends `back_off` steps from the stop, its position known.
    ///
    /// The position is as exact as a motor is that was pressed against a stop: within two full steps
    /// of it.
    ///
    /// A future that is dropped on the way brakes; the current and the limits are then those of the
    /// homing still, and the position is one that means nothing: home again.
    ///
    /// # Errors
    /// [`NotHomed`]. The axis rests, its position is not known, its limits and the current are as before.
    /// It is [`Unfit::TooLong`] before anything has moved if `most`, twice `least` or twice `back_off` is
    /// more than a travel may have, 2³¹ − 1 steps.
    pub async fn home<E, U, D, P, const N: usize, const Q: usize>(
        &self,
        axis: &mut AsyncAxis<'_, '_, E, N, Q>,
        driver: &mut Tmc2209<U, D>,
        diag: &mut P,
    ) -> Result<(), NotHomed<U::Error, P::Error>>
    where
        E: Control,
        U: Read + Write,
        D: DelayNs,
        P: Wait,
    {
        axis.rest().await;
        let limits = axis.limits();
        let set = driver.set_run_current(self.milliamps).await;
        let mut homed = set.map_err(NotHomed::Driver);
        if homed.is_ok() {
            driver.delay.delay_ms(self.dwell).await;
            homed = self.passes(axis, driver, diag).await;
        }
        axis.rest().await;
        axis.set_limits(limits);
        let restored = driver.restore_current().await.map_err(NotHomed::Driver);
        driver.delay.delay_ms(self.dwell).await;
        let homed = homed.and(restored);
        if homed.is_err() {
            axis.mark_unknown();
        }
        homed
    }

    /// Both passes, at the current of homing.
    async fn passes<E, U, D, P, const N: usize, const Q: usize>(
        &self,
        axis: &mut AsyncAxis<'_, '_, E, N, Q>,
        driver: &mut Tmc2209<U, D>,
        diag: &mut P,
    ) -> Result<(), NotHomed<U::Error, P::Error>>
    where
        E: Control,
        U: Read + Write,
        D: DelayNs,
        P: Wait,
    {
        let (most, twice_least) = (travel(self.most)?, travel(self.least.saturating_mul(2))?);
        let (back_off, twice_back) =
            (travel(self.back_off)?, travel(self.back_off.saturating_mul(2))?);
        axis.set_limits(AxisLimits::new(self.speed, self.accel));
        let mut made = self.pass(most, axis, driver, diag).await?;
        if made < self.least.into() {
            self.back(twice_least, axis).await?;
            made = self.pass(most, axis, driver, diag).await?;
        }
        if made < self.least.into() {
            return Err(NotHomed::TooSoon);
        }
        self.back(back_off, axis).await?;
        driver.delay.delay_ms(self.dwell).await;
        axis.set_limits(AxisLimits::new(self.second, self.accel));
        let made = self.pass(twice_back, axis, driver, diag).await?;
        // Where the first pass has been pressed against the stop, the way back is shorter.
        if made < i64::from(self.back_off / 2) {
            return Err(NotHomed::TooSoon);
        }
        axis.set_position(self.position)?;
        self.back(back_off, axis).await
    }

    /// Towards the stop: how many steps were made up to the stall. The axis rests.
    async fn pass<E, U, D, P, const N: usize, const Q: usize>(
        &self,
        most: i32,
        axis: &mut AsyncAxis<'_, '_, E, N, Q>,
        driver: &mut Tmc2209<U, D>,
        diag: &mut P,
    ) -> Result<i64, NotHomed<U::Error, P::Error>>
    where
        E: Control,
        U: Read + Write,
        D: DelayNs,
        P: Wait,
    {
        axis.set_position(0)?;
        let steps = if self.forward { most } else { -most };
        let ended = select(axis.move_by(steps), diag.wait_for_high()).await;
        let made = axis.position();
        axis.rest().await;
        match ended {
            Either::First(Ok(Outcome::Reached { .. })) => Err(NotHomed::NoStall),
            Either::First(Ok(_)) => Err(NotHomed::Stopped),
            Either::First(Err(error)) => Err(NotHomed::Move(error)),
            Either::Second(Err(error)) => Err(NotHomed::Pin(error)),
            Either::Second(Ok(())) => {
                let faults = driver.faults().await?;
                if faults.lets_go() {
                    return Err(NotHomed::Faulty(faults));
                }
                Ok(made.map_or(0, i64::abs))
            }
        }
    }

    /// Away from the stop.
    async fn back<E: Control, F, P, const N: usize, const Q: usize>(
        &self,
        steps: i32,
        axis: &mut AsyncAxis<'_, '_, E, N, Q>,
    ) -> Result<(), NotHomed<F, P>> {
        match axis.move_by(if self.forward { -steps } else { steps }).await? {
            Outcome::Reached { .. } => Ok(()),
            _ => Err(NotHomed::Stopped),
        }
    }
}

/// Steps of a travel, either way.
fn travel(steps: u32) -> Result<i32, MoveError> {
    i32::try_from(steps).map_err(|_| Unfit::TooLong.into())
}
