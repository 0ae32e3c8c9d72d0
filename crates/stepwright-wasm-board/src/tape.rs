//! The last edges of the board's pins, for the scope.

use stepwright_sim::{AXES, Edge, Pin, Recorder};

/// The number of edges that are kept: 10 s of one axis at 3,000 steps/s.
pub const KEPT: usize = 1 << 16;

/// A ring of edges, which overwrites the oldest.
pub struct Tape {
    times: [f64; KEPT],
    pins: [u8; KEPT],
    /// The number of edges so far.
    count: u32,
    /// The levels of DIR. The `Shaft` of the virtual board would not be all zeros.
    forward: [bool; AXES],
    shafts: [i64; AXES],
}

impl Default for Tape {
    fn default() -> Self {
        Tape::new()
    }
}

impl Tape {
    /// An empty tape: all zeros, which take no space in a module.
    pub const fn new() -> Tape {
        Tape {
            times: [0.0; KEPT],
            pins: [0; KEPT],
            count: 0,
            forward: [false; AXES],
            shafts: [0; AXES],
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        (self.count, self.forward, self.shafts) = (0, [false; AXES], [0; AXES]);
    }

    /// The times of the edges, in ticks; edge number `n` is at `n % KEPT`.
    pub fn times(&self) -> &[f64; KEPT] {
        &self.times
    }

    /// The pins of the edges: the axis from 0, times 8; plus 0 for STEP, 2 for DIR, 4 for enable; plus 1 for a
    /// rising edge.
    pub fn pins(&self) -> &[u8; KEPT] {
        &self.pins
    }

    /// The number of edges so far, modulo 2³².
    pub fn count(&self) -> u32 {
        self.count
    }

    /// The steps of an axis, forward minus backward, counted at its pins.
    pub fn shaft(&self, axis: usize) -> Option<i64> {
        self.shafts.get(axis).copied()
    }

    /// Adds an edge.
    pub fn add(&mut self, edge: Edge) {
        let axis = usize::from(edge.axis);
        let pin = match edge.pin {
            Pin::Step => 0,
            Pin::Direction => 2,
            _ => 4,
        };
        if edge.pin == Pin::Direction
            && let Some(forward) = self.forward.get_mut(axis)
        {
            *forward = edge.level;
        }
        if edge.is_step() {
            let way = if self.forward.get(axis) == Some(&true) { 1 } else { -1 };
            if let Some(shaft) = self.shafts.get_mut(axis) {
                *shaft = shaft.wrapping_add(way);
            }
        }
        let place = self.count as usize % KEPT;
        if let (Some(time), Some(code)) = (self.times.get_mut(place), self.pins.get_mut(place)) {
            *time = edge.time as f64;
            *code = edge.axis << 3 | pin | u8::from(edge.level);
        }
        self.count = self.count.wrapping_add(1);
    }
}

impl Recorder for &mut Tape {
    fn edge(&mut self, edge: Edge) {
        self.add(edge);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shafts_are_counted_at_the_pins_and_old_edges_written_over() {
        let mut tape = Box::new(Tape::new());
        let edge = |time, pin, level| Edge { time, axis: 1, pin, level };
        tape.add(edge(5, Pin::Direction, true));
        for n in 0..KEPT as u64 / 2 {
            tape.add(edge(10 * n + 10, Pin::Step, true));
            tape.add(edge(10 * n + 12, Pin::Step, false));
        }
        assert_eq!(tape.shaft(1), Some(KEPT as i64 / 2));
        assert_eq!((tape.shaft(0), tape.shaft(9)), (Some(0), None));
        // The very first edge is gone, the second is still there.
        assert_eq!(tape.count() as usize, KEPT + 1);
        assert_eq!((tape.times()[1], tape.pins()[1]), (10.0, 8 | 1));
        assert_eq!(tape.pins()[0], 8);
        tape.add(edge(9_000_000, Pin::Direction, false));
        tape.add(edge(9_000_010, Pin::Step, true));
        assert_eq!(tape.shaft(1), Some(KEPT as i64 / 2 - 1));
        tape.clear();
        assert_eq!((tape.count(), tape.shaft(1)), (0, Some(0)));
    }
}
