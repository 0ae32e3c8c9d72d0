//! Debouncing of limit switches.
//!
//! ```text
//!   contact  ──────┐ ┌┐ ┌┐  closed   ┌┐ ┌─┐ ┌──────────────  open
//!                  └─┘└─┘└───────────┘└─┘ └─┘
//!   counts   ──────┐                                ┌──────
//!   as             └────────────────────────────────┘
//!                                           ├ debounce ┤
//! ```
//!
//! The first closed sample counts at once, because it stops a motor. A switch counts as open again
//! when no sample was closed for `debounce-ms`.

use stepwright::drive::Axes;

/// The number of axes that can have a switch in the settings.
const AXES: usize = 3;

/// The switches that count as closed since an earlier sample.
pub(crate) struct Contacts {
    /// The time for which the switch of each axis still counts as closed, in ms.
    left: [u8; AXES],
}

impl Contacts {
    /// All switches open.
    pub(crate) const OPEN: Contacts = Contacts { left: [0; AXES] };

    /// Takes a sample `millis` after the previous one: the axes whose switch is closed. They count
    /// as closed for at least `debounce` ms; with 0, only in this sample.
    pub(crate) fn sample(&mut self, millis: u8, closed: Axes, debounce: u8) {
        // One more, because the present millisecond has begun already.
        let hold = if debounce == 0 { 0 } else { debounce.saturating_add(1) };
        let mut bits = closed;
        for left in &mut self.left {
            *left = if bits & 1 != 0 { hold } else { left.saturating_sub(millis) };
            bits >>= 1;
        }
    }

    /// The axes whose switch counts as closed since an earlier sample.
    pub(crate) fn held(&self) -> Axes {
        self.left.iter().rev().fold(0, |held, left| held << 1 | Axes::from(*left != 0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contact_counts_until_it_has_been_open_for_long_enough() {
        let mut contacts = Contacts::OPEN;
        contacts.sample(1, 0b101, 3);
        assert_eq!(contacts.held(), 0b101);
        contacts.sample(1, 0b100, 3);
        contacts.sample(2, 0, 3);
        assert_eq!(contacts.held(), 0b101);
        // The contact of axis 3 bounces; that of axis 1 has been open for 4 ms.
        contacts.sample(1, 0b100, 3);
        assert_eq!(contacts.held(), 0b100);
        contacts.sample(3, 0, 3);
        assert_eq!(contacts.held(), 0b100);
        contacts.sample(1, 0, 3);
        assert_eq!(contacts.held(), 0);
    }

    #[test]
    fn the_longest_time_and_none() {
        let mut contacts = Contacts::OPEN;
        contacts.sample(0, 0b101, 250);
        contacts.sample(250, 0, 250);
        assert_eq!(contacts.held(), 0b101);
        contacts.sample(1, 0, 250);
        assert_eq!(contacts.held(), 0);
        contacts.sample(1, 1, 0);
        assert_eq!(contacts.held(), 0);
    }
}
