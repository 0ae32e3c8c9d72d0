//! The serial line over USB: a port of the class CDC-ACM (`/dev/ttyACM0`, `COM3`), which the main
//! loop polls. According to the RP2040's datasheet, "USB", and the class's specification.
//!
//! The controller itself answers NAK while the main loop is busy elsewhere, so nothing is lost and
//! no interrupt is needed. (`usb-device` with a HAL's bus can panic, which this firmware must not.)

use core::cell::Cell;

use stepwright_controller::Register;

use crate::chip;
use crate::usb_answers::{self, Answer, Setup};

const MEMORY: usize = 0x5010_0000;
const CONTROLLER: usize = 0x5011_0000;

/// A word of the memory shared with the controller.
#[inline(always)]
const fn word(offset: usize) -> Register {
    // SAFETY: within the 4 KB of that memory, like all offsets below.
    unsafe { Register::at(MEMORY + offset) }
}

const fn register(offset: usize) -> Register {
    // SAFETY: the datasheet's table of the controller.
    unsafe { Register::at(CONTROLLER + offset) }
}

const ADDRESS: Register = register(0x00);
const SIE_STATUS: Register = register(0x50);
const BUFF_STATUS: Register = register(0x58);
const STALL_ARM: Register = register(0x68);

const BUS_RESET: u32 = 1 << 19;
const SETUP: u32 = 1 << 17;
/// The bus is suspended, or was since this bit was written: the datasheet says both.
const SUSPENDED: u32 = 1 << 4;

/// Bits of a buffer's control word.
const AVAILABLE: u32 = 1 << 10;
const STALL: u32 = 1 << 11;
const DATA_1: u32 = 1 << 13;
const FULL: u32 = 1 << 15;
const LENGTH: u32 = 0x3FF;

/// The control words of buffers: control, sent and received; data, sent and received. The buffer of
/// notifications is never used.
const CONTROL_IN: usize = 0x80;
const CONTROL_OUT: usize = 0x84;
const DATA_IN: usize = 0x90;
const DATA_OUT: usize = 0x94;
/// The addresses of the buffers.
const CONTROL: usize = 0x100;
const NOTES_AT: usize = 0x180;
const SENT_AT: usize = 0x1C0;
const HEARD_AT: usize = 0x200;
/// The bytes of a packet.
const PACKET: usize = 64;

/// The port, for the main loop.
pub struct Usb {
    /// The address that takes effect after the answer in progress; 0 for none.
    address: Cell<u8>,
    configured: Cell<bool>,
    /// Whether a program on the host has opened the port.
    opened: Cell<bool>,
    /// Whether the host has suspended the bus, and has sent nothing since.
    suspended: Cell<bool>,
    /// The rest of an answer on the control pipe.
    rest: Cell<&'static [u8]>,
    control_1: Cell<bool>,
    /// A received packet: the number of its bytes, and the number taken.
    heard: Cell<(usize, usize)>,
    heard_1: Cell<bool>,
    /// The bytes of the next packet, whether a packet is being sent, and whether an empty packet
    /// has to follow a full one.
    packet: [Cell<u8>; PACKET],
    filled: Cell<usize>,
    sends: Cell<bool>,
    sent_1: Cell<bool>,
    ends: Cell<bool>,
}

/// Makes a buffer available: writes the word without that bit first, and waits for the controller's
/// clock. Not inlined: its callers would be longer.
#[inline(never)]
fn arm(buffer: usize, value: u32) {
    word(buffer).write(value);
    cortex_m::asm::delay(12);
    word(buffer).write(value | AVAILABLE);
}

/// Copies bytes into the shared memory, in whole words. Returns their number.
fn copy(bytes: impl Iterator<Item = u8>, to: usize) -> u32 {
    let (mut count, mut held) = (0u32, 0);
    for byte in bytes.take(PACKET) {
        held |= u32::from(byte) << (8 * (count & 3));
        count = count.wrapping_add(1);
        if count & 3 == 0 {
            word(to + count as usize - 4).write(held);
            held = 0;
        }
    }
    if count & 3 != 0 {
        word(to + (count as usize & !3)).write(held);
    }
    count
}

impl Usb {
    /// Starts the controller: the host sees a device.
    ///
    /// # Safety
    /// Called once, after [`chip::start`].
    pub unsafe fn start() -> Usb {
        // SAFETY: the caller's promise.
        unsafe { chip::start_usb() };
        for offset in (0..CONTROL + PACKET).step_by(4) {
            word(offset).write(0);
        }
        // The controller's own pins; VBUS treated as present; device mode.
        register(0x74).write(1 << 0 | 1 << 3);
        register(0x78).write(1 << 2 | 1 << 3);
        register(0x40).write(1);
        register(0x4C).write(1 << 29 | 1 << 16);
        Usb {
            address: Cell::new(0),
            configured: Cell::new(false),
            opened: Cell::new(false),
            suspended: Cell::new(false),
            rest: Cell::new(&[]),
            control_1: Cell::new(true),
            heard: Cell::new((0, 0)),
            heard_1: Cell::new(false),
            packet: [const { Cell::new(0) }; PACKET],
            filled: Cell::new(0),
            sends: Cell::new(false),
            sent_1: Cell::new(false),
            ends: Cell::new(false),
        }
    }

    /// Whether a program on the host has opened the port.
    pub fn is_open(&self) -> bool {
        self.configured.get() && self.opened.get() && !self.suspended.get()
    }

    /// Handles the host's requests. Call it again and again.
    pub fn poll(&self) {
        let status = SIE_STATUS.read();
        if status & SUSPENDED != 0 {
            SIE_STATUS.write(SUSPENDED);
            self.suspended.set(true);
        }
        if status & BUS_RESET != 0 {
            self.forget();
            BUFF_STATUS.write(u32::MAX);
            ADDRESS.write(0);
            SIE_STATUS.write(BUS_RESET);
        }
        // Packets from before the host's new request come first.
        self.go_on();
        if status & SETUP != 0 {
            SIE_STATUS.write(SETUP);
            self.suspended.set(false);
            self.obey(&Setup::of([word(0).read(), word(4).read()]));
        }
    }

    /// Handles the packets that were sent or received.
    fn go_on(&self) {
        let done = BUFF_STATUS.read();
        if done == 0 {
            return;
        }
        BUFF_STATUS.write(done);
        self.suspended.set(false);
        if done & 1 << 0 != 0 {
            let address = self.address.replace(0);
            if address != 0 {
                ADDRESS.write(address.into());
            }
            if !self.rest.get().is_empty() {
                self.answer();
            }
        }
        // The bytes of a SET_LINE_CODING have come; they are not used.
        if done & 1 << 1 != 0 && word(CONTROL_OUT).read() & LENGTH != 0 {
            self.acknowledge();
        }
        if done & 1 << 4 != 0 {
            self.sends.set(false);
            self.flush();
        }
        if done & 1 << 5 != 0 {
            self.heard.set(((word(DATA_OUT).read() & LENGTH) as usize, 0));
            if self.heard.get().0 == 0 {
                self.listen();
            }
        }
    }

    fn forget(&self) {
        self.address.set(0);
        self.configured.set(false);
        self.opened.set(false);
        self.suspended.set(false);
        self.rest.set(&[]);
        self.begin();
    }

    /// Resets both directions.
    fn begin(&self) {
        word(DATA_IN).write(0);
        word(DATA_OUT).write(0);
        self.heard.set((0, 0));
        self.heard_1.set(false);
        self.filled.set(0);
        self.sends.set(false);
        self.sent_1.set(false);
        self.ends.set(false);
    }

    fn obey(&self, setup: &Setup) {
        self.control_1.set(true);
        self.rest.set(&[]);
        match usb_answers::answer(setup) {
            Answer::Bytes(bytes) => self.reply(setup, bytes),
            Answer::Configuration => {
                self.reply(setup, if self.configured.get() { &[1] } else { &[0] });
            }
            Answer::Address(address) => {
                self.address.set(address);
                self.acknowledge();
            }
            Answer::Configured(configured) => {
                self.begin();
                self.configured.set(configured);
                self.opened.set(false);
                // Interrupt, bulk, bulk: each enabled; the bulk buffers report in BUFF_STATUS.
                let enabled = u32::from(configured) << 31;
                word(0x08).write(enabled | 3 << 26 | NOTES_AT as u32);
                word(0x10).write(enabled | 1 << 29 | 2 << 26 | SENT_AT as u32);
                word(0x14).write(enabled | 1 << 29 | 2 << 26 | HEARD_AT as u32);
                if configured {
                    self.listen();
                }
                self.acknowledge();
            }
            Answer::Unhalted(endpoint) => {
                self.unhalt(endpoint);
                self.acknowledge();
            }
            Answer::Opened(opened) => {
                if !opened {
                    self.filled.set(0);
                }
                self.opened.set(opened);
                self.acknowledge();
            }
            Answer::Takes => arm(CONTROL_OUT, DATA_1 | PACKET as u32),
            Answer::Done => self.acknowledge(),
            Answer::Refused => {
                STALL_ARM.write(0b11);
                word(CONTROL_IN).write(STALL);
                word(CONTROL_OUT).write(STALL);
            }
        }
    }

    /// Begins an endpoint again with DATA0; a packet that waits there stays.
    fn unhalt(&self, endpoint: u8) {
        match endpoint {
            0x82 => {
                self.sent_1.set(self.sends.get());
                if self.sends.get() {
                    arm(DATA_IN, FULL | word(DATA_IN).read() & LENGTH);
                }
            }
            0x02 if self.configured.get() => {
                self.heard_1.set(false);
                let (count, taken) = self.heard.get();
                if taken >= count {
                    self.listen();
                }
            }
            _ => {}
        }
    }

    /// Begins an answer on the control pipe.
    fn reply(&self, setup: &Setup, bytes: &'static [u8]) {
        let wanted = usize::from(setup.length);
        self.rest.set(bytes.get(..wanted).unwrap_or(bytes));
        // The host ends the transfer with an empty packet.
        arm(CONTROL_OUT, DATA_1);
        self.answer();
    }

    /// Sends the next packet of an answer on the control pipe.
    fn answer(&self) {
        let (now, later) =
            self.rest.get().split_at_checked(PACKET).unwrap_or((self.rest.get(), &[]));
        self.rest.set(later);
        let count = copy(now.iter().copied(), CONTROL);
        let data_1 = self.control_1.replace(!self.control_1.get());
        arm(CONTROL_IN, FULL | count | if data_1 { DATA_1 } else { 0 });
    }

    /// Sends an empty answer.
    fn acknowledge(&self) {
        arm(CONTROL_IN, FULL | DATA_1);
    }

    /// Makes the buffer for the next packet available.
    fn listen(&self) {
        let data_1 = self.heard_1.replace(!self.heard_1.get());
        arm(DATA_OUT, PACKET as u32 | if data_1 { DATA_1 } else { 0 });
    }

    /// Sends the collected bytes, unless a packet is being sent.
    fn flush(&self) {
        let count = self.filled.get();
        if self.sends.get() || !self.configured.get() || count == 0 && !self.ends.get() {
            return;
        }
        let count = copy(self.packet.iter().map(Cell::get).take(count), SENT_AT);
        self.filled.set(0);
        self.ends.set(count as usize == PACKET);
        self.sends.set(true);
        let data_1 = self.sent_1.replace(!self.sent_1.get());
        arm(DATA_IN, FULL | count | if data_1 { DATA_1 } else { 0 });
    }

    /// The next received byte.
    pub fn receive(&self) -> Option<u8> {
        let (count, taken) = self.heard.get();
        if taken >= count {
            return None;
        }
        let byte = word(HEARD_AT + (taken & !3)).read() >> (8 * (taken & 3));
        self.heard.set((count, taken + 1));
        if taken + 1 == count {
            self.listen();
        }
        Some(byte as u8)
    }

    /// Whether there is room for a byte to send.
    pub fn has_room(&self) -> bool {
        self.filled.get() < PACKET
    }

    /// Sends a byte, together with later ones that come before the previous packet is sent.
    pub fn send(&self, byte: u8) {
        if let Some(place) = self.packet.get(self.filled.get()) {
            place.set(byte);
            self.filled.set(self.filled.get() + 1);
        }
        self.flush();
    }
}
