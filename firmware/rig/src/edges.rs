//! The drivers' view: steps, positions and times from the edges alone.

use stepwright_sim::{Edge, Pin};

/// A step: its cycle, and the position after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// The cycle of its rising edge.
    pub time: u64,
    /// The steps forward minus the steps backward so far.
    pub position: i64,
}

/// The steps of one axis. DIR is high for forward.
pub fn steps_of(edges: &[Edge], axis: u8) -> Vec<Step> {
    let (mut forward, mut position) = (false, 0i64);
    let mut steps = Vec::new();
    for edge in edges.iter().filter(|edge| edge.axis == axis) {
        match edge.pin {
            Pin::Direction => forward = edge.level,
            Pin::Step if edge.level => {
                position += if forward { 1 } else { -1 };
                steps.push(Step { time: edge.time, position });
            }
            _ => {}
        }
    }
    steps
}

/// The position of one axis after all of `edges`.
pub fn position_of(edges: &[Edge], axis: u8) -> i64 {
    steps_of(edges, axis).last().map_or(0, |step| step.position)
}

/// Intervals between the steps of one axis.
pub fn intervals_of(edges: &[Edge], axis: u8) -> Vec<u64> {
    steps_of(edges, axis).windows(2).map(|pair| pair[1].time - pair[0].time).collect()
}

/// The requirements of a driver for its pins, in cycles.
#[derive(Clone, Copy, Debug)]
pub struct Needs {
    /// The least time for which STEP stays high.
    pub pulse: u64,
    /// The time from DIR to the rising edge of STEP.
    pub setup: u64,
    /// The time from the rising edge of STEP to DIR.
    pub hold: u64,
    /// The time from one rising edge of STEP to the next.
    pub interval: u64,
}

impl Needs {
    /// The firmware's default: 2 µs, 1 µs, 1 µs, and at least a pulse and a pause between steps.
    pub const DEFAULT: Needs = Needs { pulse: 32, setup: 16, hold: 16, interval: 64 };
}

/// Checks that every driver's requirements were met.
///
/// # Errors
/// A sentence about the first violation.
pub fn check(edges: &[Edge], needs: Needs) -> Result<(), String> {
    let axes = edges.iter().map(|edge| edge.axis).max().map_or(0, |axis| axis + 1);
    (0..axes).try_for_each(|axis| check_axis(edges, axis, needs))
}

fn check_axis(edges: &[Edge], axis: u8, needs: Needs) -> Result<(), String> {
    let (mut rise, mut turn, mut high) = (None::<u64>, None::<u64>, false);
    let long_enough = |what: &str, from: Option<u64>, to: u64, least: u64| match from {
        Some(from) if to - from < least => {
            Err(format!("axis {axis}: {what} of {} cycles at {to}, less than {least}", to - from))
        }
        _ => Ok(()),
    };
    for edge in edges.iter().filter(|edge| edge.axis == axis) {
        let now = edge.time;
        match (edge.pin, edge.level) {
            (Pin::Step, true) => {
                if high {
                    return Err(format!("axis {axis} rises twice at {now}"));
                }
                long_enough("an interval", rise, now, needs.interval)?;
                long_enough("a set-up", turn, now, needs.setup)?;
                (rise, high) = (Some(now), true);
            }
            (Pin::Step, false) => {
                long_enough("a pulse", rise, now, needs.pulse)?;
                high = false;
            }
            (Pin::Direction, _) => {
                long_enough("a hold", rise, now, needs.hold)?;
                turn = Some(now);
            }
            // Enables and switches have no such requirements.
            (Pin::Coil(_) | Pin::Enable | Pin::Min | Pin::Max, _) => {}
        }
    }
    if high { Err(format!("axis {axis} is left high")) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(time: u64, pin: Pin, level: bool) -> Edge {
        Edge { time, axis: 0, pin, level }
    }

    #[test]
    fn positions_come_from_edges_alone() {
        let mut edges = vec![edge(0, Pin::Direction, true)];
        for time in [100, 200, 300] {
            edges.extend([edge(time, Pin::Step, true), edge(time + 40, Pin::Step, false)]);
        }
        edges.push(edge(400, Pin::Direction, false));
        edges.extend([edge(500, Pin::Step, true), edge(540, Pin::Step, false)]);
        assert_eq!(position_of(&edges, 0), 2);
        assert_eq!(intervals_of(&edges, 0), [100, 100, 200]);
        assert_eq!(check(&edges, Needs::DEFAULT), Ok(()));
    }

    #[test]
    fn every_need_is_looked_at() {
        let step = |at| [edge(at, Pin::Step, true), edge(at + 32, Pin::Step, false)];
        let says = |edges: &[Edge], what: &str| {
            let error = check(edges, Needs::DEFAULT).unwrap_err();
            assert!(error.contains(what), "{error}");
        };
        says(&[edge(0, Pin::Step, true), edge(31, Pin::Step, false)], "a pulse");
        says(&[step(0), step(63)].concat(), "an interval");
        says(&[&[edge(0, Pin::Direction, true)][..], &step(15)].concat(), "a set-up");
        says(&[&step(0)[..], &[edge(15, Pin::Direction, true)]].concat(), "a hold");
        says(&[edge(0, Pin::Step, true)], "left high");
    }
}
