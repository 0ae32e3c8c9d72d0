//! The orders that the programs `planned` of several chips carry out, and the virtual board with
//! them.

use stepwright::{Axis, Control, MoveError, Steppers};

/// The number of orders. Each is carried out to its end before the next.
pub const ORDERS: u8 = 7;

/// Gives order `number`: lines of two axes there and back, two independent moves, lines of three
/// axes, of one axis, and a single move.
pub fn order(motors: &mut Steppers<'_, impl Control, 3>, number: u8) -> Result<(), MoveError> {
    match number {
        0 => motors.move_line_to([(Axis::X, 400), (Axis::Y, -200)]),
        1 => motors.move_line_to([(Axis::X, 100), (Axis::Y, -50)]),
        2 => {
            motors.move_to(Axis::X, -300)?;
            motors.move_to(Axis::Z, 250)
        }
        3 => motors.move_line_to([(Axis::X, 0), (Axis::Y, 250), (Axis::Z, -150)]),
        4 => motors.move_line_to([(Axis::X, -300)]),
        5 => motors.move_line_to([(Axis::Z, -450)]),
        _ => motors.move_to(Axis::X, -200),
    }
}
