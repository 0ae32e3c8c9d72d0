//! The serial line: USART0 at 115200 baud, 8 bits, no parity, one stop bit.
//!
//! Interrupts move bytes between the line and two rings, so that the main
//! program may be planning while they come and go. A byte every 87 µs is
//! fast: the handlers are short, because each puts off the steps.

use core::cell::UnsafeCell;
use core::mem::offset_of;

use stepwright_device::main_loop::{Received, SerialPort};

use crate::chip::{TC0, USART0};

/// What the receiver puts in place of a byte that it lost or that came
/// damaged: no byte of any line.
#[doc(hidden)] // the handlers use it
pub const GARBLED: u8 = 0xFF;

/// 16 MHz / 8 / 115200 − 1; the rate is 2.1 % high, which the line allows.
const DIVISOR: u16 = 16;

/// The registers and their bits, for the handlers: alike on both chips.
#[doc(hidden)] // the handlers use it
pub const UCSR0A: u8 = 0xC0;
#[doc(hidden)] // the handlers use it
pub const UCSR0B: u8 = 0xC1;
#[doc(hidden)] // the handlers use it
pub const UDR0: u8 = 0xC6;
/// A damaged byte, or a lost one.
#[doc(hidden)] // the handlers use it
pub const ERRORS: u8 = 1 << 4 | 1 << 3;
/// `UCSR0B`: receiver and sender on, an interrupt for each byte that comes …
#[doc(hidden)] // the handlers use it
pub const LISTENING: u8 = 1 << 7 | 1 << 4 | 1 << 3;
/// … and one while the sender has room.
#[doc(hidden)] // the handlers use it
pub const SENDING: u8 = LISTENING | 1 << 5;

/// Bytes received since the beginning, and how many that may be, both modulo 256. An
/// instruction reaches these registers in one cycle, memory in two. They are the compare
/// registers of timer 0, alike on both chips, which compares nothing; the
/// general ones are the step interrupt's.
#[doc(hidden)] // the handlers use it
pub const CAME: u8 = 0x27; // OCR0A
#[doc(hidden)] // the handlers use it
pub const LIMIT: u8 = 0x28; // OCR0B

#[doc(hidden)] // the handlers use it
pub static RECEIVED: Inbox = Inbox::new();
#[doc(hidden)] // the handlers use it
pub static TO_SEND: Ring = Ring::new();

/// The serial line, for the main program.
pub struct Serial(());

impl Serial {
    /// Sets the line up. It works once interrupts are enabled.
    pub fn start(registers: USART0) -> Serial {
        // Double speed first: a simulator computes its times when the divisor
        // is written.
        registers.ucsr0a().write(|w| w.u2x0().set_bit());
        registers.ubrr0().write(|w| w.set(DIVISOR));
        registers.ucsr0c().write(|w| w.ucsz0().chr8());
        RECEIVED.begin();
        set_control(LISTENING);
        Serial(())
    }
}

impl SerialPort for Serial {
    fn receive(&mut self) -> Option<Received> {
        // SAFETY: there is one line, and this is its only reader.
        unsafe { RECEIVED.take() }.map(|byte| match byte {
            GARBLED => Received::Garbled,
            byte => Received::Byte(byte),
        })
    }

    fn has_room(&self) -> bool {
        !TO_SEND.is_full()
    }

    /// Without room it spoils a byte that is still to be sent.
    fn send(&mut self, byte: u8) {
        // The handler stops its interrupts when it has taken the last byte, and may
        // have taken this one when they start again: then it finds none, and stops
        // them again.
        // SAFETY: there is one line, and this is its only writer.
        unsafe { TO_SEND.put(byte) };
        set_control(SENDING);
    }
}

/// Writes `UCSR0B`: one instruction.
fn set_control(bits: u8) {
    // SAFETY: both handlers and the line expect these bits, and no others.
    unsafe { USART0::steal().ucsr0b().write(|w| w.bits(bits)) };
}

/// Puts the line's interrupts into a program.
///
/// Both handlers are assembly, and let the step interrupt come in between as soon
/// as they can: what they keep it waiting for, a step is late by.
///
/// The receiver's counts its byte before it stores it, so that a handler which
/// came in between (a visit of the step interrupt may take longer than a byte)
/// would store the next one behind it. The sender's switches its own interrupt
/// off meanwhile.
///
/// Cycles on an Uno by its data sheet, from the request on, entry (4) and vector (3)
/// included; steps may come from `sei` on.
///
/// | | up to `sei` | in all |
/// | --- | --- | --- |
/// | a byte has come | 27 | 49 |
/// | the sender has room, and there is a byte that isn't the last | 16 | 60 |
#[macro_export]
macro_rules! serial_interrupts {
    () => {
        core::arch::global_asm!(
            concat!(".global ", $crate::vector!(received)),
            concat!(".type ", $crate::vector!(received), ", @function"),
            concat!($crate::vector!(received), ":"),
            $crate::entry!(),
            "push r29",
            "push r30",
            "in   r30, 0x3F",
            "push r30",
            "push r31",
            "lds  r31, {status}", // before the byte, which clears it
            "in   r30, {came}",
            "in   r29, {limit}",
            "cp   r30, r29",
            "breq 5f",
            "inc  r30",
            "out  {came}, r30",
            "3: lds r29, {data}",
            "sei",
            "andi r31, {errors}",
            "brne 4f",
            "2: dec r30",
            "andi r30, {size} - 1",
            "ldi  r31, 0",
            "subi r30, lo8(-({ring}))",
            "sbci r31, hi8(-({ring}))",
            "st   Z, r29",
            "pop  r31",
            "pop  r30",
            "out  0x3F, r30",
            "pop  r30",
            "pop  r29",
            "reti",
            // Lost or damaged.
            "4: ldi r29, {garbled}",
            "rjmp 2b",
            // No room: the last byte is spoiled in its place, so that the line
            // which lacks a byte is known.
            "5: ldi r31, {errors}",
            "rjmp 3b",

            concat!(".global ", $crate::vector!(has_room)),
            concat!(".type ", $crate::vector!(has_room), ", @function"),
            concat!($crate::vector!(has_room), ":"),
            $crate::entry!(),
            "push r30",
            "in   r30, 0x3F",
            "push r30",
            "ldi  r30, {listening}",
            "sts  {control}, r30",
            "sei",
            "push r29",
            "push r31",
            "lds  r30, {queue} + {taken}",
            "lds  r31, {queue} + {put}",
            "cp   r30, r31",
            "breq 6f", // there is none
            "inc  r30",
            "sts  {queue} + {taken}, r30",
            "dec  r30",
            "andi r30, {outgoing} - 1",
            "ldi  r31, 0",
            "subi r30, lo8(-({queue}))",
            "sbci r31, hi8(-({queue}))",
            "ld   r29, Z",
            "sts  {data}, r29",
            "lds  r30, {queue} + {taken}",
            "lds  r31, {queue} + {put}",
            "cp   r30, r31",
            "breq 6f", // that was the last
            "ldi  r30, {sending}",
            "sts  {control}, r30",
            "6: pop r31",
            "pop  r29",
            "pop  r30",
            "out  0x3F, r30",
            "pop  r30",
            "reti",
            status = const $crate::serial::UCSR0A,
            control = const $crate::serial::UCSR0B,
            data = const $crate::serial::UDR0,
            errors = const $crate::serial::ERRORS,
            garbled = const $crate::serial::GARBLED,
            listening = const $crate::serial::LISTENING,
            sending = const $crate::serial::SENDING,
            came = const $crate::serial::CAME,
            limit = const $crate::serial::LIMIT,
            ring = sym $crate::serial::RECEIVED,
            queue = sym $crate::serial::TO_SEND,
            put = const $crate::serial::PUT,
            taken = const $crate::serial::TAKEN,
            size = const $crate::serial::SIZE,
            outgoing = const $crate::serial::OUTGOING,
        );
    };
}

/// Bytes that come for the foreground, a power of two. The master waits for its answer
/// before it says the next line, and a line has at most 31 bytes.
#[doc(hidden)] // the handlers use it
pub const SIZE: u8 = 32;

/// Bytes that go out, a power of two: the main loop adds one a round, so they last for several.
#[doc(hidden)] // the handlers use it
pub const OUTGOING: u8 = 8;

/// Bytes from the receiver's handler to the foreground. What came is counted in a
/// register, and another one has what is taken and SIZE more.
#[doc(hidden)]
#[repr(C)]
pub struct Inbox {
    bytes: UnsafeCell<[u8; SIZE as usize]>,
    /// Bytes taken out, modulo 256; the foreground's alone.
    taken: UnsafeCell<u8>,
}

// SAFETY: a byte is touched by the handler only while the registers leave it free, by
// the foreground only while they say that it is filled. Both registers are read and
// written as volatile bytes, each by one side, after the byte has been used.
unsafe impl Sync for Inbox {}

impl Inbox {
    const fn new() -> Inbox {
        Inbox { bytes: UnsafeCell::new([0; SIZE as usize]), taken: UnsafeCell::new(0) }
    }

    /// Empty; before the receiver is on.
    fn begin(&self) {
        // SAFETY: nobody else uses its compare registers.
        let timer = unsafe { TC0::steal() };
        timer.ocr0a().write(|w| w.set(0));
        timer.ocr0b().write(|w| w.set(SIZE));
    }

    /// Takes the oldest byte out.
    ///
    /// # Safety
    /// For the foreground alone, one call at a time.
    unsafe fn take(&self) -> Option<u8> {
        // SAFETY: nobody else uses its compare registers.
        let timer = unsafe { TC0::steal() };
        // SAFETY: the caller's promise.
        let taken = unsafe { &mut *self.taken.get() };
        if timer.ocr0a().read().bits() == *taken {
            return None;
        }
        // SAFETY: the place is filled, and there is one reader.
        let byte = unsafe { place(&self.bytes, *taken).read_volatile() };
        *taken = taken.wrapping_add(1);
        timer.ocr0b().write(|w| w.set(taken.wrapping_add(SIZE)));
        Some(byte)
    }
}

/// The place that a counter stands for.
fn place<const N: usize>(bytes: &UnsafeCell<[u8; N]>, counter: u8) -> *mut u8 {
    const { assert!(N.is_power_of_two() && N <= 128) };
    // SAFETY: N is a power of two, so the place lies in the ring.
    unsafe { bytes.get().cast::<u8>().add(usize::from(counter & (N as u8 - 1))) }
}

/// Bytes from the foreground to the sender's handler.
#[doc(hidden)]
#[repr(C)]
pub struct Ring {
    bytes: UnsafeCell<[u8; OUTGOING as usize]>,
    /// Bytes put in since the beginning, modulo 256; written by the writer.
    put: UnsafeCell<u8>,
    /// Bytes taken out; written by the reader.
    taken: UnsafeCell<u8>,
}

#[doc(hidden)] // the handlers use it
pub const PUT: usize = offset_of!(Ring, put);
#[doc(hidden)] // the handlers use it
pub const TAKEN: usize = offset_of!(Ring, taken);

// SAFETY: a byte of the ring is read and written in one instruction, by the reader only while
// put − taken says that it is filled.
// The foreground stores its counter after it has used the byte, and reads and
// writes both counters as volatile bytes, which takes one instruction. (Atomic
// ones would hold interrupts off for each.)
unsafe impl Sync for Ring {}

impl Ring {
    const fn new() -> Ring {
        // Where the handlers look for the bytes.
        const { assert!(offset_of!(Ring, bytes) == 0 && offset_of!(Inbox, bytes) == 0) };
        Ring {
            bytes: UnsafeCell::new([0; OUTGOING as usize]),
            put: UnsafeCell::new(0),
            taken: UnsafeCell::new(0),
        }
    }

    /// Both counters.
    fn counters(&self) -> (u8, u8) {
        // SAFETY: one instruction each, and the handler changes but one.
        unsafe { (self.put.get().read_volatile(), self.taken.get().read_volatile()) }
    }

    fn is_full(&self) -> bool {
        let (put, taken) = self.counters();
        put.wrapping_sub(taken) >= OUTGOING
    }

    /// Puts a byte in, for which there is room.
    ///
    /// # Safety
    /// For the foreground alone, one call at a time.
    unsafe fn put(&self, byte: u8) {
        let (put, _) = self.counters();
        // SAFETY: there is one writer, and the handler reads a byte in one instruction. Volatile
        // writes keep their order.
        unsafe {
            place(&self.bytes, put).write_volatile(byte);
            self.put.get().write_volatile(put.wrapping_add(1));
        }
    }
}
