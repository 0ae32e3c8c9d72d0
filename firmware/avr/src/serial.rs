//! The serial line: USART0 at 115200 baud, 8 bits, no parity, one stop bit.
//!
//! Interrupts move bytes between the line and two rings, so that the main
//! program may be planning while they come and go. A byte every 87 µs is
//! fast: the handlers are short, because each puts off the steps.

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicU8, Ordering};

use crate::chip::USART0;
use crate::interrupt::handler;

/// What the receiver puts in place of a byte that it lost or that came
/// damaged: no byte of any line.
const GARBLED: u8 = 0xFF;

/// 16 MHz / 8 / 115200 − 1; the rate is 2.1 % high, which the line allows.
const DIVISOR: u16 = 16;

static RECEIVED: Ring<32> = Ring::new();
static TO_SEND: Ring<32> = Ring::new();

/// A byte of the line, or what has become of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// It came.
    Byte(u8),
    /// It was lost or damaged on the way.
    Garbled,
}

/// The serial line, for the main program.
pub struct Serial(());

impl Serial {
    /// Sets the line up. It works once interrupts are enabled.
    pub fn start(registers: USART0) -> Serial {
        // Double speed first: a simulator reckons its times when the divisor
        // is written.
        registers.ucsr0a().write(|w| w.u2x0().set_bit());
        registers.ubrr0().write(|w| w.set(DIVISOR));
        registers.ucsr0c().write(|w| w.ucsz0().chr8());
        registers.ucsr0b().write(|w| w.rxen0().set_bit().txen0().set_bit().rxcie0().set_bit());
        Serial(())
    }

    /// The next byte that has come, if one has.
    pub fn receive(&mut self) -> Option<Received> {
        RECEIVED.take().map(|byte| match byte {
            GARBLED => Received::Garbled,
            byte => Received::Byte(byte),
        })
    }

    /// Whether there is room for a byte to send.
    pub fn has_room(&self) -> bool {
        !TO_SEND.is_full()
    }

    /// Sends a byte; forgets it if there is no room.
    pub fn send(&mut self, byte: u8) {
        if TO_SEND.put(byte) {
            // All bits are written, so that it does not matter if the handler
            // has just cleared its own.
            // SAFETY: one write, of what `start` wrote and the sender's bit.
            unsafe { USART0::steal() }.ucsr0b().write(|w| {
                w.rxen0().set_bit().txen0().set_bit().rxcie0().set_bit().udrie0().set_bit()
            });
        }
    }
}

handler!(USART_RX, USART0_RX, {
    // SAFETY: only this handler reads the receiver.
    let line = unsafe { USART0::steal() };
    let status = line.ucsr0a().read();
    let byte = line.udr0().read().bits();
    if status.fe0().bit_is_set() || status.dor0().bit_is_set() {
        RECEIVED.put(GARBLED);
    } else if !RECEIVED.put(byte) {
        RECEIVED.spoil();
    }
});

handler!(USART_UDRE, USART0_UDRE, {
    // SAFETY: only this handler writes to the sender.
    let line = unsafe { USART0::steal() };
    match TO_SEND.take() {
        Some(byte) => line.udr0().write(|w| w.set(byte)),
        // Nothing left: no more of these interrupts.
        None => line.ucsr0b().write(|w| w.rxen0().set_bit().txen0().set_bit().rxcie0().set_bit()),
    };
});

/// Bytes from one writer to one reader; one of them is an interrupt handler.
struct Ring<const LEN: usize> {
    bytes: UnsafeCell<[u8; LEN]>,
    /// Bytes put in since the beginning, modulo 256; written by the writer.
    put: AtomicU8,
    /// Bytes taken out; written by the reader.
    taken: AtomicU8,
}

// SAFETY: a byte of the ring is touched by the writer only while put − taken
// leaves it free, by the reader only while put − taken says it is filled, and
// the counters are stored after the byte is used. `spoil` has its own reason.
unsafe impl<const LEN: usize> Sync for Ring<LEN> {}

impl<const LEN: usize> Ring<LEN> {
    const fn new() -> Ring<LEN> {
        const { assert!(LEN.is_power_of_two() && LEN <= 128) };
        Ring { bytes: UnsafeCell::new([0; LEN]), put: AtomicU8::new(0), taken: AtomicU8::new(0) }
    }

    /// The place that a counter stands for.
    #[inline(always)]
    fn place(&self, counter: u8) -> *mut u8 {
        // SAFETY: LEN is a power of two, so the place lies in the ring.
        unsafe { self.bytes.get().cast::<u8>().add(usize::from(counter & (LEN as u8 - 1))) }
    }

    #[inline(always)]
    fn filled(&self) -> u8 {
        self.put.load(Ordering::Acquire).wrapping_sub(self.taken.load(Ordering::Acquire))
    }

    #[inline(always)]
    fn is_full(&self) -> bool {
        self.filled() >= LEN as u8
    }

    /// Puts a byte in; false if there is no room.
    #[inline(always)]
    fn put(&self, byte: u8) -> bool {
        if self.is_full() {
            return false;
        }
        let at = self.put.load(Ordering::Relaxed);
        // SAFETY: the place is free, and there is one writer.
        unsafe { self.place(at).write(byte) };
        self.put.store(at.wrapping_add(1), Ordering::Release);
        true
    }

    /// Takes the oldest byte out.
    #[inline(always)]
    fn take(&self) -> Option<u8> {
        if self.filled() == 0 {
            return None;
        }
        let at = self.taken.load(Ordering::Relaxed);
        // SAFETY: the place is filled, and there is one reader.
        let byte = unsafe { self.place(at).read() };
        self.taken.store(at.wrapping_add(1), Ordering::Release);
        Some(byte)
    }

    /// A byte found no room: the last one is spoiled in its place, so that the
    /// line which lacks a byte is known.
    #[inline(always)]
    fn spoil(&self) {
        let at = self.put.load(Ordering::Relaxed).wrapping_sub(1);
        // SAFETY: the ring is full, so the reader, which this handler has
        // interrupted, is at another place.
        unsafe { self.place(at).write(GARBLED) };
    }
}
