//! The rates that a timer can make (the Arduino driver, section 6).

use stepwright::Geometry;
use stepwright_timed::fit::Hardware;

use crate::sheet::{Cell, Sheet};

/// The lowest and the highest rate of all prescalers together, and of each.
pub fn range(hardware: &Hardware, geometry: &Geometry) -> Sheet {
    let turn = f64::from(geometry.steps_per_turn());
    let (hz, bits) = (f64::from(hardware.hz()), hardware.bits());
    // A step each time the counter wraps. A wide counter does not wrap within the longest interval.
    let whole = hardware.span() - 1 <= u64::from(hardware.max_top());
    let longest = if whole { hardware.span() } else { hardware.max_top().into() };
    let lowest = hz / longest as f64;
    let highest = hz / f64::from(hardware.min_top());

    let title = format!("A timer of {bits} bits at {} Hz", hardware.hz());
    let mut sheet = Sheet::new(title);
    sheet.fact("lowest_steps_s", "lowest rate", Cell::digits(lowest, 9), "steps/s");
    sheet.fact("lowest_rpm", "… speed", Cell::digits(lowest * 60.0 / turn, 9), "rpm");
    sheet.fact("turn_s", "… one turn takes", Cell::digits(turn / lowest, 9), "s");
    sheet.fact("max_top", "longest virtual top", hardware.max_top(), "clocks");
    sheet.fact("highest_steps_s", "highest rate", Cell::digits(highest, 9), "steps/s");
    sheet.fact("highest_rpm", "… speed", Cell::digits(highest * 60.0 / turn, 9), "rpm");
    sheet.fact("min_top", "shortest virtual top", hardware.min_top(), "clocks");

    sheet.columns = vec![
        ("prescaler", "prescaler"),
        ("lowest_steps_s", "lowest, steps/s"),
        ("lowest_rpm", "rpm"),
        ("largest_top_steps_s", "largest top, steps/s"),
        ("largest_top_rpm", "rpm"),
        ("highest_steps_s", "highest, steps/s"),
        ("highest_rpm", "rpm"),
    ];
    for &shift in hardware.shifts() {
        let clocks = |counts: u64| (counts << shift).min(longest) as f64;
        let counts = 1u64 << bits;
        // The fewest counts that take no less than the shortest interval.
        let least = u64::from(hardware.min_top()).div_ceil(1 << shift);
        let mut row = vec![Cell::from(1u32 << shift)];
        for counts in [counts, counts - 1, least] {
            let rate = hz / clocks(counts);
            row.extend([Cell::digits(rate, 9), Cell::digits(rate * 60.0 / turn, 7)]);
        }
        sheet.rows.push(row);
    }
    sheet.notes.push(match whole {
        true => format!(
            "lowest: one step each 2^{bits} counts; largest top: the register holds 2^{bits} − 1."
        ),
        false => format!("lowest, largest top: no interval has more than {longest} clocks."),
    });
    sheet
}
