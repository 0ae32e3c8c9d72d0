//! Steps and times as a driver sees them, from edges alone.

use stepwright_sim::{Edge, Pin};

/// The steps of one axis, from the edges of STEP and DIR: the times and the position after each.
pub fn steps_of(edges: &[Edge], axis: u8) -> Vec<(u64, i64)> {
    let (mut forward, mut position) = (true, 0i64);
    let mut steps = Vec::new();
    for edge in edges.iter().filter(|edge| edge.axis == axis) {
        match edge.pin {
            Pin::Direction => forward = edge.level,
            Pin::Step if edge.level => {
                position += if forward { 1 } else { -1 };
                steps.push((edge.time, position));
            }
            _ => {}
        }
    }
    steps
}

/// Checks the pulse width, and the set-up and hold times of DIR, as a driver sees them.
pub fn check_timing(edges: &[Edge], pulse: u64, setup: u64, hold: u64, min: u64) {
    for axis in 0..3 {
        let (mut rise, mut turn, mut high) = (None::<u64>, None::<u64>, false);
        for edge in edges.iter().filter(|edge| edge.axis == axis) {
            let t = edge.time;
            match (edge.pin, edge.level) {
                (Pin::Step, true) => {
                    assert!(!high, "axis {axis} rises twice");
                    if let Some(rise) = rise {
                        assert!(t - rise >= min, "axis {axis}: {} ticks apart at {t}", t - rise);
                    }
                    if let Some(turn) = turn {
                        assert!(t - turn >= setup, "axis {axis}: set-up {} at {t}", t - turn);
                    }
                    (rise, high) = (Some(t), true);
                }
                (Pin::Step, false) => {
                    assert!(high && t - rise.unwrap() >= pulse, "axis {axis}: pulse at {t}");
                    high = false;
                }
                (Pin::Direction, _) => {
                    if let Some(rise) = rise {
                        assert!(t - rise >= hold, "axis {axis}: hold {} at {t}", t - rise);
                    }
                    turn = Some(t);
                }
                _ => {}
            }
        }
        assert!(!high, "axis {axis} is left high");
    }
}
