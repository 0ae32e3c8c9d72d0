//! The serial line: USART0 at 115200 baud, 8 bits, no parity, one stop bit.
//!
//! Interrupts move bytes between the line and two rings, so that the main program can plan while
//! bytes arrive and are sent. At a byte every 87 µs the handlers must be short, because each delays
//! the steps.

use core::cell::UnsafeCell;
use core::mem::offset_of;

use stepwright_device::main_loop::{Received, SerialPort};

use crate::chip::{TC0, USART0};

/// The byte that the receiver stores in place of a lost or damaged one. No line contains this byte.
#[doc(hidden)] // the handlers use it
pub const GARBLED: u8 = 0xFF;

/// 16 MHz / 8 / 115200 − 1; the rate is 2.1 % high, which the line tolerates.
const DIVISOR: u16 = 16;

/// The registers and their bits, for the handlers: the same on both chips.
#[doc(hidden)] // the handlers use it
pub const UCSR0A: u8 = 0xC0;
#[doc(hidden)] // the handlers use it
pub const UCSR0B: u8 = 0xC1;
#[doc(hidden)] // the handlers use it
pub const UDR0: u8 = 0xC6;
/// A damaged byte, or a lost one.
#[doc(hidden)] // the handlers use it
pub const ERRORS: u8 = 1 << 4 | 1 << 3;
/// `UCSR0B`: receiver and sender on, an interrupt for each received byte …
#[doc(hidden)] // the handlers use it
pub const LISTENING: u8 = 1 << 7 | 1 << 4 | 1 << 3;
/// … and one while the sender has room.
#[doc(hidden)] // the handlers use it
pub const SENDING: u8 = LISTENING | 1 << 5;

/// Bytes received since the start, and the limit of that count, both modulo 256. An instruction
/// reaches these registers in one cycle, memory in two. They are the compare registers of timer 0,
/// the same on both chips, which are not used for comparing; the general-purpose registers belong
/// to the step interrupt.
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
    /// Sets up the line. It works once interrupts are enabled.
    pub fn start(registers: USART0) -> Serial {
        // Double speed first: a simulator computes its times when the divisor is written.
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

    /// Without room it overwrites a byte that is still to be sent.
    fn send(&mut self, byte: u8) {
        // The handler disables its interrupts when it has taken the last byte. It may have taken
        // this byte already when they are enabled here: then it finds none, and disables them
        // again.
        // SAFETY: there is one line, and this is its only writer.
        unsafe { TO_SEND.put(byte) };
        set_control(SENDING);
    }
}

/// Writes `UCSR0B` in one instruction.
fn set_control(bits: u8) {
    // SAFETY: both handlers and the line expect these bits, and no others.
    unsafe { USART0::steal().ucsr0b().write(|w| w.bits(bits)) };
}

/// Puts the line's interrupts into a program.
///
/// Both handlers are assembly, and let the step interrupt nest as soon as they can: a step is late
/// by the time for which they hold it off.
///
/// The receiver's handler counts its byte before it stores it. So a nested receiver's handler (a
/// stay in the step interrupt may be longer than a byte) stores the next byte behind it. The
/// sender's handler disables its own interrupt meanwhile.
///
/// Cycles on an Uno according to its data sheet, from the request on, including entry (4) and
/// vector (3); steps can interrupt from `sei` on.
///
/// | | up to `sei` | in all |
/// | --- | --- | --- |
/// | a byte was received | 27 | 49 |
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
            // A lost or damaged byte.
            "4: ldi r29, {garbled}",
            "rjmp 2b",
            // No room: overwrites the last byte in its place, so that the line which lacks a byte
            // is known to be damaged.
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

/// The ring of received bytes, a power of two. The master waits for its answer before it sends the
/// next line, and a line has at most 31 bytes.
#[doc(hidden)] // the handlers use it
pub const SIZE: u8 = 32;

/// The ring of bytes to send, a power of two: the main loop adds one a round, so they last for
/// several rounds.
#[doc(hidden)] // the handlers use it
pub const OUTGOING: u8 = 8;

/// Bytes from the receiver's handler to the foreground. One register counts received bytes, another
/// holds the count of taken bytes plus SIZE.
#[doc(hidden)]
#[repr(C)]
pub struct Inbox {
    bytes: UnsafeCell<[u8; SIZE as usize]>,
    /// The count of bytes taken, modulo 256. Only the foreground uses it.
    taken: UnsafeCell<u8>,
}

// SAFETY: the handler uses a place only while the registers say that it is free, the foreground
// only while they say that it is filled. Both registers are read and written as volatile bytes,
// each written by one side, after it has used the byte.
unsafe impl Sync for Inbox {}

impl Inbox {
    const fn new() -> Inbox {
        Inbox { bytes: UnsafeCell::new([0; SIZE as usize]), taken: UnsafeCell::new(0) }
    }

    /// Empties the ring; before the receiver is on.
    fn begin(&self) {
        // SAFETY: nothing else uses its compare registers.
        let timer = unsafe { TC0::steal() };
        timer.ocr0a().write(|w| w.set(0));
        timer.ocr0b().write(|w| w.set(SIZE));
    }

    /// Takes the oldest byte.
    ///
    /// # Safety
    /// Only for the foreground, one call at a time.
    unsafe fn take(&self) -> Option<u8> {
        // SAFETY: nothing else uses its compare registers.
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

/// The place of a counter's byte.
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
    /// The count of bytes put in, modulo 256; written by the writer.
    put: UnsafeCell<u8>,
    /// The count of bytes taken; written by the reader.
    taken: UnsafeCell<u8>,
}

#[doc(hidden)] // the handlers use it
pub const PUT: usize = offset_of!(Ring, put);
#[doc(hidden)] // the handlers use it
pub const TAKEN: usize = offset_of!(Ring, taken);

// SAFETY: a byte of the ring is read and written in one instruction, by the reader only while put −
// taken says that it is filled. The foreground stores its counter after it has used the byte, and
// reads and writes both counters as volatile bytes, which takes one instruction. (Atomic ones would
// disable interrupts for each.)
unsafe impl Sync for Ring {}

impl Ring {
    const fn new() -> Ring {
        // The handlers expect the bytes at offset 0.
        const { assert!(offset_of!(Ring, bytes) == 0 && offset_of!(Inbox, bytes) == 0) };
        Ring {
            bytes: UnsafeCell::new([0; OUTGOING as usize]),
            put: UnsafeCell::new(0),
            taken: UnsafeCell::new(0),
        }
    }

    /// Both counters.
    fn counters(&self) -> (u8, u8) {
        // SAFETY: one instruction each, and the handler changes only one of them.
        unsafe { (self.put.get().read_volatile(), self.taken.get().read_volatile()) }
    }

    fn is_full(&self) -> bool {
        let (put, taken) = self.counters();
        put.wrapping_sub(taken) >= OUTGOING
    }

    /// Puts in a byte. There must be room.
    ///
    /// # Safety
    /// Only for the foreground, one call at a time.
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
