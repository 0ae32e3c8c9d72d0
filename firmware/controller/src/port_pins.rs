//! STEP and DIR on a port whose pins rise or fall with one store.

use core::marker::PhantomData;

use stepwright::drive::{Axes, Drive};

use crate::{AXES, Turned};

/// The bits of all axes, from bit 0.
const ALL: u32 = (1 << AXES) - 1;

/// The port of a chip with STEP and DIR.
pub trait PinPort {
    /// The bit of STEP of axis 1; those of the other axes follow.
    const STEP: u32;
    /// The bit of DIR of axis 1, high for forward; those of the other axes follow.
    const DIR: u32;

    /// Raises or lowers the pins with these bits. The others do not change.
    fn set(bits: u32, high: bool);

    /// The directions of the axes: a static of the chip.
    fn turned() -> &'static Turned;

    /// Makes pins outputs, low, unless they are outputs already.
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

    /// Sets the axes that turn the other way round, as
    /// [`Panel::set_reverse`](crate::Panel::set_reverse) requires.
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
        // SAFETY: called once.
        let mut pins = unsafe { PortPins::<Port>::new() };
        assert_eq!(!levels(), 0b111 << 2 | 0b111 << 8);
        LEVELS.store(1 << 11, Ordering::Relaxed);
        pins.begin(0b101);
        assert_eq!(levels(), 0b101 << 2 | 1 << 11);
        pins.end(0b001);
        pins.direction(0, true);
        pins.direction(1, false);
        // An axis that does not exist.
        pins.direction(3, false);
        assert_eq!(levels(), 0b100 << 2 | 1 << 8 | 1 << 11);
        // Axis 3 has had no direction yet, and faces forward.
        PortPins::<Port>::reverse(0b001);
        assert_eq!(levels(), 0b100 << 2 | 0b100 << 8 | 1 << 11);
    }
}
