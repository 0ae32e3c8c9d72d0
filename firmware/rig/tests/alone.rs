//! One axis alone on an idle line, at speeds and accelerations up to the limits: no step is late, by
//! the edges and by the board's own count.

use stepwright_rig::Board;

use crate::common::{board, chip, late_step, path_of_accel, rest, say, steps};

/// Steps/s, up to what is admitted, and steps/s².
const TOPS: [u32; 7] = [12_000, 21_000, 33_300, 48_000, 65_544, 90_877, 127_000];
const ACCELS: [u32; 5] = [40_000, 110_695, 200_000, 320_000, 480_000];
/// The highest speed at which an Uno counts no step of its third axis as late: timer 2 sees every
/// eighth cycle, and is read 12 cycles later than by the other axes.
const THIRD: u32 = 113_000;
/// More of them: the last run of a ramp has an odd number of steps, some 30.
const ODD: [(u32, u32); 5] =
    [(80_000, 480_000), (90_877, 459_509), (71_878, 233_722), (54_568, 41_450), (113_516, 294_276)];

fn is_on_time(axis: u8) {
    let mut chip = chip();
    let grid = TOPS.iter().flat_map(|&top| ACCELS.map(|accel| (top, accel)));
    let most = if axis == 2 && board() == Board::Uno { THIRD } else { u32::MAX };
    for (top, accel) in grid.chain(ODD) {
        let top = top.min(most);
        let way = (u64::from(top).pow(2) / u64::from(accel)) as u32 + top / 20;
        chip.take_edges();
        say(&mut chip, &format!("PO A{} s0 t{top} a{accel} d{accel} G+{way} E", axis + 1));
        // The line is silent.
        assert!(chip.run_to_silence(1_600_000, 16_000_000 * 20));
        let steps = steps(&chip, axis);
        assert_eq!(steps.len(), way as usize, "axis {axis}, {top} at {accel}");
        let late = late_step(&steps, &path_of_accel(0, top, accel, way));
        assert_eq!(late, None, "axis {axis}, {top} at {accel}");
        rest(&mut chip);
        let said = chip.ask("?").unwrap();
        assert!(said.contains(" late=0 "), "axis {axis}, {top} at {accel}: {said}");
    }
}

#[test]
fn the_first_axis_alone_is_on_time_up_to_every_limit() {
    is_on_time(0);
}

#[test]
fn the_second_axis_alone_is_on_time_up_to_every_limit() {
    is_on_time(1);
}

#[test]
fn the_third_axis_alone_is_on_time_up_to_every_limit() {
    is_on_time(2);
}
