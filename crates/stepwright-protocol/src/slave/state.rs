//! What a slave keeps between lines: of each axis, of the order, of the selection.

use stepwright::Travel;

use crate::machine::Refusal;
use crate::motion_params::MotionParams;

/// What the lines have said of one axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) params: MotionParams,
    /// Whether it is to travel once E comes: g or G, and else 0.
    pub(super) staged: u8,
    pub(super) backward: bool,
    /// How far G goes; at most 2³¹ − 1.
    pub(super) steps: u32,
}

impl Axis {
    pub(super) fn travel(&self) -> Travel {
        if self.staged == b'g' {
            return Travel::Endless(!self.backward);
        }
        let steps = self.steps as i32;
        Travel::By(if self.backward { steps.wrapping_neg() } else { steps })
    }
}

/// The order that is being programmed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Open {
    /// There is none.
    No,
    /// PO has come.
    Yes,
    /// PO has come, and after it a line that was refused, or K: the reason of
    /// the first. No E starts it. It stays open all the same: a g of it that
    /// is still on its way must not be taken for one that starts at once.
    Spoiled(Refusal),
}

/// What the slave is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Task {
    /// The next line, or the answer to the last: of the position of this axis, if that was
    /// asked for.
    Line(u8),
    /// An order, which is answered when it has started: the settings are to allow what the
    /// axes from this one on do.
    Check(u8),
    /// They do so of this one, whose limits are to allow its travel.
    Admit(u8),
    /// All of that holds for this one, whose travel is to be handed to the machine.
    HandOver(u8),
    /// The machine has all of them, and starts them piece by piece.
    Start,
    /// The order is refused, which is to be answered. Nothing of it moves.
    Refuse(Refusal),
}

/// Whether the lines mean the axes that are selected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Naming {
    /// Yes: an order has used them, or nobody has ever said A.
    Used,
    /// Yes: A has said so, and no order has used it yet.
    Chosen,
    /// No: PO has selected axis 1, and A had said others, which stay selected with
    /// it. No line may set or move anything before A says which are meant.
    Unclear,
}
