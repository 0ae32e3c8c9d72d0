//! The test itself, on a chip or on a model of a chip.

use stepwright::{Axis, Control, OrderedMotors};

use crate::{Chip, Crc32, ORDERS, plan};

/// The capture of the chip's own STEP.
pub trait Capture {
    /// Starts capturing STEP of this axis; the next edge has the number 0.
    fn begin(&mut self, axis: u8);

    /// The edges since `begin`, up to the capacity, which is at least
    /// [`MOST_PULSES`](crate::MOST_PULSES) + 1.
    fn count(&self) -> u32;

    /// When an edge rose, in ticks of the chip's rate modulo 2³²; `None` if no edge has that
    /// number.
    fn rise(&self, number: u32) -> Option<u32>;
}

/// The results of a test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// The orders that were taken.
    pub orders: u32,
    /// The CRC-32 of the whole plan.
    pub plan: u32,
    /// The steps that were planned.
    pub steps: u32,
    /// The edges that were captured.
    pub edges: u32,
    /// The largest distance of an edge from its time in the plan, in ticks, both counted from the
    /// order's first edge.
    pub off: u32,
    /// The late steps, as counted by the engine.
    pub late: u32,
}

/// Plays all orders of a chip, on one axis after another.
///
/// Each is played first, and then planned again for the comparison, which takes no time from the
/// steps.
pub fn run<E: Control, const N: usize, const Q: usize>(
    motors: &mut OrderedMotors<'_, E, N, Q>,
    chip: &Chip,
    capture: &mut impl Capture,
) -> Found {
    let mut found = Found::default();
    let mut sum = Crc32::new();
    let mut places = (0..N).cycle();
    for number in 0..ORDERS {
        let place = places.next().unwrap_or(0);
        let axis = Axis::new(place).unwrap_or(Axis::X);
        capture.begin(place as u8);
        if motors.start([(axis, chip.order(number))]).is_err() {
            continue;
        }
        while motors.is_moving(axis) {
            motors.plan();
        }
        found.orders = found.orders.wrapping_add(1);
        found.edges = found.edges.saturating_add(capture.count());
        let (mut edge, mut first) = (0u32, 0u64);
        plan(chip, number, &mut sum, |time| {
            if edge == 0 {
                first = time;
            }
            let planned = time.wrapping_sub(first).wrapping_add(0x8000) >> 16;
            if let (Some(rise), Some(begun)) = (capture.rise(edge), capture.rise(0)) {
                let off = rise.wrapping_sub(begun).wrapping_sub(planned as u32) as i32;
                found.off = found.off.max(off.unsigned_abs());
            }
            edge = edge.wrapping_add(1);
        });
        found.steps = found.steps.saturating_add(edge);
    }
    found.plan = sum.end();
    found.late = motors.engine().late();
    found
}
