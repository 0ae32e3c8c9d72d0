//! DIAG, while the motors are at work.

use embedded_hal_async::digital::Wait;
use stepwright::{AxisSet, Control};
use stepwright_embassy::Motors;

/// Brakes these axes along their ramps whenever DIAG of their driver rises, and forgets where they are:
/// their moves end as `Uncertain`. It is high on a stall, if those are set up, and while the
/// driver is off because of a fault; [`faults`](crate::Tmc2209::faults) tells which.
///
/// For a task of its own, or a `select` with what moves the axes. It ends if the pin can't be read, and
/// takes that for an alarm.
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
