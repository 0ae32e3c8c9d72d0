//! Drives on pins of a port that is chosen while the program runs.
//!
//! ```text
//!   AnyDrive::step_dir(b'D', 2, 5)                 STEP on PD2, DIR on PD5
//!   AnyDrive::windings(b'B', UNIPOLAR_HALF, 0xF)   four lines on PB0 to PB3
//! ```
//!
//! Each of them works with any source of steps: planned moves
//! ([`planned_motor!`](crate::planned_motor)), motor cycles
//! ([`cycle_motors!`](crate::cycle_motors)), a law in the interrupt
//! ([`asked_motor!`](crate::asked_motor)).

use stepwright::drive::{Axes, Coils, Drive, PortDrive, Sequence};

use crate::asked::Output;
use crate::timed::{AnyPort, Pins};

/// The drive of a motor.
pub enum AnyDrive {
    /// A driver with STEP and DIR.
    StepDir(PortDrive<AnyPort>),
    /// Windings, by a table of levels.
    Windings(Coils<AnyPort>),
}

impl AnyDrive {
    /// STEP and DIR on two bits of a port, which become outputs; `None` if the chip has no such
    /// port, or a bit is the serial line's.
    pub fn step_dir(letter: u8, step: u8, direction: u8) -> Option<AnyDrive> {
        let port = outputs(letter, bit(step) | bit(direction))?;
        Some(AnyDrive::StepDir(PortDrive::new(port, step, direction, 0)))
    }

    /// Windings on the bits of a port in `mask`; `sequence` uses these bits. The current is off
    /// until [`Output::on`]. `None` as for [`step_dir`](AnyDrive::step_dir).
    pub fn windings(letter: u8, sequence: Sequence, mask: u8) -> Option<AnyDrive> {
        let mut coils = Coils::new(outputs(letter, mask)?, sequence, mask);
        coils.off();
        Some(AnyDrive::Windings(coils))
    }
}

fn bit(number: u8) -> u8 {
    1u8.checked_shl(number.into()).unwrap_or(0)
}

/// Makes pins of a port outputs.
fn outputs(letter: u8, mask: u8) -> Option<AnyPort> {
    let mut port = AnyPort::of(letter, mask)?;
    port.drive(mask);
    Some(port)
}

impl Drive for AnyDrive {
    #[inline(always)]
    fn begin(&mut self, axes: Axes) {
        match self {
            AnyDrive::StepDir(drive) => drive.begin(axes),
            AnyDrive::Windings(drive) => drive.begin(axes),
        }
    }

    fn end(&mut self, axes: Axes) {
        match self {
            AnyDrive::StepDir(drive) => drive.end(axes),
            AnyDrive::Windings(drive) => drive.end(axes),
        }
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        match self {
            AnyDrive::StepDir(drive) => drive.direction(axis, forward),
            AnyDrive::Windings(drive) => drive.direction(axis, forward),
        }
    }
}

impl Output for AnyDrive {
    fn on(&mut self) {
        if let AnyDrive::Windings(drive) = self {
            drive.on();
        }
    }

    fn off(&mut self) {
        if let AnyDrive::Windings(drive) = self {
            drive.off();
        }
    }
}

/// A drive for each of N motors, once it is wired.
pub struct Several<D, const N: usize> {
    drives: [Option<D>; N],
    /// The motors whose direction is backward.
    backward: Axes,
}

impl<D: Output, const N: usize> Several<D, N> {
    /// No drives.
    pub(crate) const fn none() -> Several<D, N> {
        Several { drives: [const { None }; N], backward: 0 }
    }

    /// Puts a motor, which must rest, on a drive and switches its current on. The current of the
    /// previous drive is switched off.
    pub fn wire(&mut self, motor: u8, mut drive: D) {
        if let Some(place) = self.drives.get_mut(usize::from(motor)) {
            if let Some(before) = place {
                before.off();
            }
            drive.direction(0, self.backward & bit(motor) == 0);
            drive.on();
            *place = Some(drive);
        }
    }
}

impl<D: Drive, const N: usize> Drive for Several<D, N> {
    #[inline(always)]
    fn begin(&mut self, mut axes: Axes) {
        for drive in &mut self.drives {
            if let (1, Some(drive)) = (axes & 1, drive) {
                drive.begin(1);
            }
            axes >>= 1;
        }
    }

    #[inline(always)]
    fn end(&mut self, mut axes: Axes) {
        for drive in &mut self.drives {
            if let (1, Some(drive)) = (axes & 1, drive) {
                drive.end(1);
            }
            axes >>= 1;
        }
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        self.backward &= !bit(axis);
        if !forward {
            self.backward |= bit(axis);
        }
        if let Some(Some(drive)) = self.drives.get_mut(usize::from(axis)) {
            drive.direction(0, forward);
        }
    }
}
