//! The state of a slave between lines: of each axis, of the order, of the selection.

use stepwright::Travel;

use crate::machine::Refusal;
use crate::motion_params::MotionParams;

/// The parameters and the travel that lines have set for one axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) params: MotionParams,
    /// The letter of its travel, g or G, which E starts; 0 for none.
    pub(super) staged: u8,
    pub(super) backward: bool,
    /// The distance of G; at most 2³¹.
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
    /// No order is open.
    No,
    /// PO has come.
    Yes,
    /// PO has come, and after it a refused line, or K: the reason of the first. No E starts the
    /// order. It stays open all the same: a g of it that is still under way must not be taken for a
    /// g that starts at once.
    Spoiled(Refusal),
}

/// The task of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Task {
    /// To obey the next line, or to send the answer to the last. If that line was V, this is its
    /// axis.
    Line(u8),
    /// To start an order, which is answered when it has started: check whether the settings allow
    /// the parameters of the axes from this one on.
    Check(u8),
    /// The settings allow the parameters of this axis; check whether its limits allow its travel.
    Admit(u8),
    /// All checks of this axis have passed; hand its travel to the machine.
    HandOver(u8),
    /// The machine has all travels, and starts them piece by piece. Meanwhile these axes have been
    /// stopped.
    Start(u8),
    /// The order is refused and has to be answered. None of its axes moves.
    Refuse(Refusal),
}

/// Whether it is clear that lines mean the selected axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Naming {
    /// Clear: an order has used the selection, or no A has ever come.
    Used,
    /// Clear: A has selected them, and no order has used the selection yet.
    Chosen,
    /// Unclear: PO has selected axis 1, and A had selected others, which stay selected too. No line
    /// may set or move anything before A names the axes.
    Unclear,
}
