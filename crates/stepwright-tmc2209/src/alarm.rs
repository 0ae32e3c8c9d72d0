//! Alarms of the pin DIAG while the motors work.

use core::convert::Infallible;

use embassy_futures::select::{Either, select};
use embedded_hal_async::digital::Wait;
use stepwright::{AxisSet, Control};
use stepwright_embassy::Motors;

/// Brakes these axes along their ramps and makes their positions unknown when their driver's DIAG
/// rises, and whenever they move while it is high: their moves end as `Uncertain`. DIAG is high on a stall, if stall detection is set
/// up, and while the driver is off because of a fault; [`faults`](crate::Tmc2209::faults) tells
/// which.
///
/// Run it in a task of its own, or in a `select` with the code that moves the axes. If the pin
/// can't be read, it treats that as an alarm and returns the error.
pub async fn brake_on_alarm<E: Control, P: Wait, const N: usize, const Q: usize>(
    motors: &Motors<'_, E, N, Q>,
    axes: impl Into<AxisSet<N>>,
    diag: &mut P,
) -> P::Error {
    let axes = axes.into();
    loop {
        let risen = diag.wait_for_high().await;
        motors.fault(axes);
        let fallen = match risen {
            Ok(()) => {
                let Either::First(fallen) =
                    select(diag.wait_for_low(), brake_always(motors, axes)).await;
                fallen
            }
            Err(error) => Err(error),
        };
        if let Err(error) = fallen {
            motors.fault(axes);
            return error;
        }
    }
}

/// Brakes each move of these axes.
async fn brake_always<E: Control, const N: usize, const Q: usize>(
    motors: &Motors<'_, E, N, Q>,
    axes: AxisSet<N>,
) -> Infallible {
    loop {
        motors.motion(axes).await;
        motors.fault(axes);
        for axis in axes.iter() {
            motors.axis(axis).rest().await;
        }
    }
}
