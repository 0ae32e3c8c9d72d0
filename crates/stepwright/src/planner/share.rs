//! The length of the next run of a piece.

/// Steps of the next run, where `full` is its usual length and `room` is left of its piece. The
/// last two runs share the rest: short runs would come faster than a chip can plan them.
pub(super) fn share(room: u32, full: u16) -> u16 {
    // No run is longer than half of this.
    let room = if room >> 16 == 0 { room as u16 } else { u16::MAX };
    if room <= full {
        room
    } else if room / 2 < full {
        room - room / 2
    } else {
        full
    }
}

/// [`share`] for a ramp, where `full` is a power of two. The steps beyond a multiple of 32 come
/// last, in a run of their own, whose steps do not fit into groups of one size.
pub(super) fn share_of_ramp(room: u32, full: u16) -> u16 {
    const WHOLE: u16 = 32;
    let steps = share(room, full);
    if steps == full || steps <= WHOLE {
        steps
    } else if u32::from(steps) == room {
        steps & !(WHOLE - 1)
    } else {
        // No more than `full`, which is a multiple of 32 here: more than 32 steps are half of less
        // than twice `full`.
        steps.wrapping_add(WHOLE - 1) & !(WHOLE - 1)
    }
}
