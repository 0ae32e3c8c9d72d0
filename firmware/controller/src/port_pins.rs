//! STEP and DIR of a port whose pins rise or fall with one store.

use core::marker::PhantomData;

use stepwright::drive::{Axes, Drive};

use crate::{AXES, Turned};

/// Bits of all axes, at the first.
const ALL: u32 = (1 << AXES) - 1;

/// The port of a chip that STEP and DIR are on.
pub trait PinPort {
    /// Bit of STEP of axis 1; those of the others are in a row behind it.
    const STEP: u32;
    /// Likewise of DIR, high for forward.
    const DIR: u32;

    /// Raises pins by their bits, or lowers them. The others stay.
    fn set(bits: u32, high: bool);

    /// Which way the axes turn: a static of the chip's.
    fn turned() -> &'static Turned;

    /// Makes pins outputs, low, where they are not outputs yet.
    #[inline(always)]
    fn start(pins: u32) {
        Self::set(pins, false);
    }
}

/// STEP and DIR of all axes.
pub struct PortPins<P>(PhantomData<P>);

impl<P: PinPort> PortPins<P> {
    /// Makes them outputs, low.
    ///
    /// # Safety
    /// Called once for a port.
    #[inline(always)]
    pub unsafe fn new() -> Self {
        P::start(ALL << P::STEP | ALL << P::DIR);
        PortPins(PhantomData)
    }

    /// These axes turn the other way round, the others do not: what
    /// [`Panel::set_reverse`](crate::Panel::set_reverse) asks for.
    pub fn reverse(axes: Axes) {
        let levels = u32::from(P::turned().reverse(axes)) & ALL;
        P::set(levels << P::DIR, true);
        P::set((levels ^ ALL) << P::DIR, false);
    }
}

impl<P: PinPort> Drive for PortPins<P> {
    #[inline(always)]
    fn begin(&mut self, axes: Axes) {
        P::set(u32::from(axes) << P::STEP, true);
    }

    #[inline(always)]
    fn end(&mut self, axes: Axes) {
        P::set(u32::from(axes) << P::STEP, false);
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        let high = P::turned().direction(axis, forward);
        if usize::from(axis) < AXES {
            P::set(1u32.wrapping_shl(P::DIR + u32::from(axis)), high);
        }
    }
}

#[cfg(test)]
mod tests {
    use core::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    static LEVELS: AtomicU32 = AtomicU32::new(0);
    static TURNED: Turned = Turned::new();

    struct Port;

    impl PinPort for Port {
        const STEP: u32 = 2;
        const DIR: u32 = 8;

        fn set(bits: u32, high: bool) {
            if high {
                LEVELS.fetch_or(bits, Ordering::Relaxed);
            } else {
                LEVELS.fetch_and(!bits, Ordering::Relaxed);
            }
        }

        fn turned() -> &'static Turned {
            &TURNED
        }
    }

    #[test]
    fn each_axis_has_its_pins_and_no_others() {
        let levels = || LEVELS.load(Ordering::Relaxed);
        LEVELS.store(u32::MAX, Ordering::Relaxed);
        // SAFETY: once.
        let mut pins = unsafe { PortPins::<Port>::new() };
        assert_eq!(!levels(), 0b111 << 2 | 0b111 << 8);
        LEVELS.store(1 << 11, Ordering::Relaxed);
        pins.begin(0b101);
        assert_eq!(levels(), 0b101 << 2 | 1 << 11);
        pins.end(0b001);
        pins.direction(0, true);
        pins.direction(1, false);
        // An axis that there is not.
        pins.direction(3, false);
        assert_eq!(levels(), 0b100 << 2 | 1 << 8 | 1 << 11);
        // Axis 3 was told nothing yet, and faces forward.
        PortPins::<Port>::reverse(0b001);
        assert_eq!(levels(), 0b100 << 2 | 0b100 << 8 | 1 << 11);
    }
}
