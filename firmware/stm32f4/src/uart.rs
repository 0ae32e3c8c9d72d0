//! The serial line: USART2, 115200 baud. An interrupt receives the bytes; the step interrupt can
//! preempt it.

use cortex_m::peripheral::NVIC;
use stepwright_controller::Ring;
use stepwright_device::main_loop::{Received, SerialPort};
use stm32f4xx_hal::pac::{Interrupt, USART2};

/// The bytes that the interrupt has received.
static RING: Ring = Ring::new();

/// The interrupt of USART2.
///
/// # Safety
/// Called by that interrupt only.
#[inline(always)]
pub unsafe fn on_receive() {
    // SAFETY: the interrupt owns the receiver's half.
    let line = unsafe { &*USART2::ptr() };
    let state = line.sr().read();
    // Reading it after the state clears all flags of the state.
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
    /// Enables its interrupt, which is less urgent than the step timer's.
    pub fn start(line: USART2) -> Uart {
        line.cr1().modify(|_, w| w.rxneie().set_bit());
        // SAFETY: it is less urgent than the step interrupt, and uses only the ring.
        unsafe { NVIC::unmask(Interrupt::USART2) };
        Uart(line)
    }
}

impl SerialPort for Uart {
    fn receive(&mut self) -> Option<Received> {
        // SAFETY: there is one `Uart`, which the main loop owns.
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
