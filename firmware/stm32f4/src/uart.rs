//! The serial line: USART2, 115200 baud. Bytes are received by an interrupt, which the step interrupt
//! interrupts.

use cortex_m::peripheral::NVIC;
use stepwright_controller::Ring;
use stepwright_device::main_loop::{Received, SerialPort};
use stm32f4xx_hal::pac::{Interrupt, USART2};

/// What the interrupt has received.
static RING: Ring = Ring::new();

/// The interrupt of USART2.
///
/// # Safety
/// Called by that interrupt alone.
#[inline(always)]
pub unsafe fn on_receive() {
    // SAFETY: the receiver's half is the interrupt's.
    let line = unsafe { &*USART2::ptr() };
    let state = line.sr().read();
    // Read behind the state, it clears all that it tells.
    let byte = line.dr().read().bits() as u8;
    let damaged = state.pe().bit() || state.fe().bit() || state.nf().bit();
    // SAFETY: the caller's promise.
    unsafe {
        if damaged {
            RING.put_garbled();
        } else if state.rxne().bit() {
            RING.put(byte);
        }
        if state.ore().bit() {
            RING.put_garbled();
        }
    }
}

/// The line, for the main loop.
pub struct Uart(USART2);

impl Uart {
    /// Lets its interrupt come, which is behind the step timer's.
    pub fn start(line: USART2) -> Uart {
        line.cr1().modify(|_, w| w.rxneie().set_bit());
        // SAFETY: it is less urgent than the step interrupt, and touches the ring alone.
        unsafe { NVIC::unmask(Interrupt::USART2) };
        Uart(line)
    }
}

impl SerialPort for Uart {
    fn receive(&mut self) -> Option<Received> {
        // SAFETY: there is one `Uart`, the main loop's.
        unsafe { RING.take() }
    }

    fn has_room(&self) -> bool {
        self.0.sr().read().txe().bit()
    }

    fn send(&mut self, byte: u8) {
        // SAFETY: a byte.
        self.0.dr().write(|w| unsafe { w.bits(byte.into()) });
    }
}
