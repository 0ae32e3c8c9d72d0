//! Alarms of the pin DIAG while the motors work.

use embedded_hal_async::digital::Wait;
use stepwright::{AxisSet, Control};
use stepwright_embassy::Motors;

/// Brakes these axes along their ramps and makes their positions unknown whenever their driver's
/// DIAG rises: their moves end as `Uncertain`. DIAG is high on a stall, if stall detection is set
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
            Ok(()) => diag.wait_for_low().await,
            Err(error) => Err(error),
        };
        if let Err(error) = fallen {
            motors.fault(axes);
            return error;
        }
    }
}
