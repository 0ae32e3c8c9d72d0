//! Homing by stall detection.
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

/// Parameters of homing an axis against a stop, without a switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StallHoming {
    /// Whether the stop lies forward.
    pub forward: bool,
    /// The speed of the first pass. Well above the speed from which stalls are detected.
    pub speed: Speed,
    /// The speed of the second pass, likewise well above.
    pub second: Speed,
    /// The acceleration of both passes and of backing off. The ramp up is part of the least
    /// distance.
    pub accel: Accel,
    /// The current during homing, in mA: lower than usual, so that the axis meets the stop softly.
    pub milliamps: u16,
    /// The wait after each change of the current, in ms, until StallGuard's measure has settled.
    pub dwell: u32,
    /// The least distance in steps. An earlier stall does not count: the motor was not at speed
    /// yet, or stood at the stop. Then the axis backs off by twice this distance, and tries once
    /// more.
    pub least: u32,
    /// The distance to back off from the stop, in steps. The second pass searches at most twice as
    /// far.
    pub back_off: u32,
    /// The longest search for the stop, in steps.
    pub most: u32,
    /// The position to give the stop.
    pub position: i64,
}

impl StallHoming {
    /// Homes an axis. It ends `back_off` steps from the stop, with a known position.
    ///
    /// The position is within two full steps of the stop, the accuracy of a motor that was pressed
    /// against a stop.
    ///
    /// A future that is dropped on the way brakes the axis. The current and the limits then remain
    /// those of homing, and the position is meaningless: home again.
    ///
    /// # Errors
    /// [`NotHomed`]. The axis rests, its position is unknown, its limits and the current are as
    /// before. Nothing moves if the driver reports a fault that
    /// [lets the motor go](crate::DriverFaults::lets_go), past ones too: see
    /// [`forget_faults`](Tmc2209::forget_faults). The error is [`Unfit::TooLong`], before anything has moved, if `most`, twice `least`
    /// or twice `back_off` exceeds the longest travel of 2³¹ − 1 steps.
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
        if let Err(error) = no_fault(driver).await {
            axis.mark_unknown();
            return Err(error);
        }
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

    /// Makes both passes, at the homing current.
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
        // After a first pass that pressed against the stop, the way back is shorter.
        if made < i64::from(self.back_off / 2) {
            return Err(NotHomed::TooSoon);
        }
        axis.set_position(self.position)?;
        self.back(back_off, axis).await
    }

    /// Moves towards the stop until a stall, and returns the steps made up to it. The axis rests
    /// afterwards.
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
                no_fault(driver).await?;
                Ok(made.map_or(0, i64::abs))
            }
        }
    }

    /// Moves away from the stop.
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

/// Checks that the driver holds the motor, and has its settings.
async fn no_fault<U: Read + Write, D: DelayNs, P>(
    driver: &mut Tmc2209<U, D>,
) -> Result<(), NotHomed<U::Error, P>> {
    let faults = driver.faults().await?;
    if faults.lets_go() { Err(NotHomed::Faulty(faults)) } else { Ok(()) }
}

/// The steps of a travel in either direction.
fn travel(steps: u32) -> Result<i32, MoveError> {
    i32::try_from(steps).map_err(|_| Unfit::TooLong.into())
}
