//! The test itself, on a chip or on a model of one.

use stepwright::{Axis, Control, OrderedMotors};

use crate::{Chip, Crc32, ORDERS, plan};

/// What captures the chip's own STEP.
pub trait Capture {
    /// From now on it is STEP of this axis that is captured, and the edge of number 0 comes next.
    fn begin(&mut self, axis: u8);

    /// Edges since then, as many as there is room for: at least
    /// [`MOST_PULSES`](crate::MOST_PULSES) and one more.
    fn count(&self) -> u32;

    /// When an edge rose, in ticks of the chip's rate, modulo 2³²; `None` if there was none of that number.
    fn rise(&self, number: u32) -> Option<u32>;
}

/// What was found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Orders that were taken.
    pub orders: u32,
    /// CRC-32 of all that was planned.
    pub plan: u32,
    /// Steps that were planned, and edges that were captured.
    pub steps: u32,
    /// See `steps`.
    pub edges: u32,
    /// The farthest that an edge was from its time in the plan, in ticks; both from the first edge of the
    /// order.
    pub off: u32,
    /// Late steps, as the engine counts them.
    pub late: u32,
}

/// Plays all orders of a chip, one axis after another.
///
/// Each is played first, and then planned once more and compared: that takes no time from the steps.
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
