//! The steps of a route in ticks of a timer, axis by axis. A cycle plays them, and [`legs`](crate::legs) makes
//! runs of them.

use stepwright::{Rate, Ticks};
use stepwright_cycle::Pace;

use crate::legs::WAIT;
use crate::route::RouteStep;

/// The steps of each axis, each at the tick nearest to its time, `lead` ticks after the start. Errors do not
/// accumulate. Steps of an axis beyond N are left out.
///
/// ```
/// use stepwright::Rate;
/// use stepwright_path::{AxisPace, Route, legs, paces};
/// let axis = AxisPace { step: 0.01, speed: 100.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };
/// let mut route = Route::new([axis; 2])?;
/// route.line_to([10.0, 5.0], 80.0)?;
/// route.close();
/// let [x, y] = paces(&mut route, Rate::MHZ, 1_000);
/// assert_eq!((x.len(), y.len()), (1_000, 500));
/// // A board keeps it in a few runs, each step within 2 µs.
/// assert!(legs(x, 2, 10).len() < 60);
/// # Ok::<(), stepwright_path::Unplannable>(())
/// ```
pub fn paces<const N: usize>(
    steps: impl IntoIterator<Item = RouteStep>,
    rate: Rate,
    lead: Ticks,
) -> [Vec<Pace>; N] {
    let hz = f64::from(rate.hz());
    let mut axes = [const { Vec::new() }; N];
    let mut gone = [0u64; N];
    for RouteStep { time, axis, forward } in steps {
        let (Some(paces), Some(gone)) = (axes.get_mut(axis), gone.get_mut(axis)) else { continue };
        let due = ((time * hz).round() as u64).saturating_add(lead.into());
        let mut left = due.saturating_sub(*gone);
        *gone = due;
        while left > WAIT {
            paces.push(Pace::Wait { ticks: WAIT as Ticks });
            left -= WAIT;
        }
        paces.push(Pace::Step { ticks: left as Ticks, forward });
    }
    axes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_the_nearest_and_long_waits_several() {
        let step = |time, axis, forward| RouteStep { time, axis, forward };
        let steps = [
            step(0.000_001_4, 0, true),
            step(0.000_002_8, 0, false),
            step(0.5, 7, true),
            step(3_000.0, 1, true),
        ];
        let [x, y] = paces(steps, Rate::MHZ, 10);
        let steps = [(11, true), (2, false)];
        assert_eq!(x, steps.map(|(ticks, forward)| Pace::Step { ticks, forward }));
        let wait = Pace::Wait { ticks: 1 << 30 };
        let last = Pace::Step { ticks: (3_000_000_010u64 - 2 * WAIT) as Ticks, forward: true };
        assert_eq!(y, [wait, wait, last]);
    }
}
