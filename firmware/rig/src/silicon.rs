//! The simulator behind a safe interface: one chip, one instruction at a time.
//!
//! All unsafe code of the rig is here and in `probes.rs`.

use std::ffi::{CStr, CString};
use std::os::raw::c_void;
use std::ptr;

use simavr_ffi as ffi;

use crate::board::{HZ, Pin};
use crate::elf::Image;

/// The contents of RAM at power-up: bytes that still have this value have not been used.
const PAINT: u8 = 0xA5;

/// USART0's registers, the same on both chips.
const UCSR0A: usize = 0xC0;
const UBRR0: usize = 0xC4;

/// The reason of a reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The supply was gone, but so briefly that RAM has kept everything.
    Power,
    /// RESET was low: the button, or the host's DTR.
    Button,
    /// Its supply was too low.
    BrownOut,
    /// The watchdog. Only for a reset by the rig: the rig also tests a program that hangs.
    Watchdog,
}

/// simavr's number of a request.
const fn request(name: [u8; 4]) -> u32 {
    u32::from_be_bytes(name)
}

/// A simulated chip.
pub(crate) struct Silicon {
    pub(crate) avr: *mut ffi::avr_t,
    uart: *mut ffi::avr_uart_t,
    /// The closed switches: per port, the pins that are pulled from outside.
    pulled: Vec<(char, u8, u8)>,
}

impl Silicon {
    /// A chip with `image` in its flash, at reset.
    pub(crate) fn new(chip: &str, image: &Image) -> Silicon {
        let name = CString::new(chip).expect("a name without zeros");
        // SAFETY: the name is a C string; simavr allocates, and Drop frees.
        let avr = unsafe { ffi::avr_make_mcu_by_name(name.as_ptr()) };
        assert!(!avr.is_null(), "simavr has no {chip}");
        // SAFETY: `avr` is fresh from simavr. The code is copied, and simavr aborts if it is too
        // long, which is checked before.
        unsafe {
            (*avr).frequency = HZ as u32;
            assert_eq!(ffi::avr_init(avr), 0, "simavr can't set up the chip");
            let room = (*avr).flashend + 1;
            let size = image.flash.len() as u32;
            assert!(size <= room, "{size} bytes of firmware, {room} bytes of flash");
            ffi::avr_loadcode(avr, image.flash.as_ptr().cast_mut(), size, 0);
            (*avr).codeend = size;
            // Quiet: it would print what the chip sends, and sleep when it polls.
            let mut flags = 0u32;
            ffi::avr_ioctl(avr, request(*b"uas0"), ptr::from_mut(&mut flags).cast());
        }
        let mut silicon = Silicon { avr, uart: find_uart(avr), pulled: Vec::new() };
        silicon.paint();
        silicon
    }

    /// Fills the RAM with a pattern, in place of the noise at power-up.
    fn paint(&mut self) {
        // SAFETY: `data` has `ramend` + 1 bytes, registers first.
        unsafe {
            let (begin, end) =
                (usize::from((*self.avr).ioend) + 1, usize::from((*self.avr).ramend));
            ptr::write_bytes((*self.avr).data.add(begin), PAINT, end + 1 - begin);
        }
    }

    /// The bytes from the end of RAM down to the deepest one that was written; `statics` bytes at
    /// its beginning are not counted.
    pub(crate) fn stack(&self, statics: u32) -> u32 {
        let free = self.ram().get(statics as usize..).unwrap_or(&[]);
        let deepest = free.iter().position(|&byte| byte != PAINT).unwrap_or(free.len());
        (free.len() - deepest) as u32
    }

    /// The bytes of RAM, and the address of the last.
    pub(crate) fn room(&self) -> (u32, u16) {
        // SAFETY: `avr` is alive.
        (self.ram().len() as u32, unsafe { (*self.avr).ramend })
    }

    fn ram(&self) -> &[u8] {
        // SAFETY: as in `paint`; nothing writes while `self` is borrowed.
        unsafe {
            let begin = usize::from((*self.avr).ioend) + 1;
            let length = usize::from((*self.avr).ramend) + 1 - begin;
            std::slice::from_raw_parts((*self.avr).data.add(begin), length)
        }
    }

    /// A byte of the data space: a register or RAM.
    pub(crate) fn byte(&self, address: u16) -> u8 {
        // SAFETY: the address is held below the end.
        unsafe { *(*self.avr).data.add(usize::from(address.min((*self.avr).ramend))) }
    }

    /// Sets a byte of RAM, or one of the registers r0 to r31.
    pub(crate) fn set_byte(&mut self, address: u16, byte: u8) {
        // SAFETY: not a register of the hardware, and below the end.
        unsafe {
            let avr = &*self.avr;
            assert!(
                address < 32 || (avr.ioend + 1..=avr.ramend).contains(&address),
                "{address:#x} is a register of the hardware"
            );
            *avr.data.add(usize::from(address)) = byte;
        }
    }

    pub(crate) fn set_low_fuse(&mut self, byte: u8) {
        /// CLKPR; its divider as a power of 2 if CKDIV8 is programmed (0).
        const CLKPR: usize = 0x61;
        let divider = if byte & 0x80 == 0 { 3 } else { 0 };
        // SAFETY: a live chip, and no instruction runs; the register is inside `data`.
        unsafe {
            (*self.avr).fuse[0] = byte;
            *(*self.avr).data.add(CLKPR) = divider;
        }
    }

    /// Writes other code to the flash from `address` on, and returns the previous code.
    pub(crate) fn set_code(&mut self, address: u32, code: &[u8]) -> Vec<u8> {
        // SAFETY: `flash` has `flashend` + 1 bytes.
        unsafe {
            let end = address as usize + code.len();
            assert!(end <= (*self.avr).flashend as usize + 1, "beyond the end of the flash");
            let flash = std::slice::from_raw_parts_mut((*self.avr).flash, end);
            let before = flash[address as usize..].to_vec();
            flash[address as usize..].copy_from_slice(code);
            before
        }
    }

    /// Makes the instruction at `address` the next one; its RET leads to address 0.
    pub(crate) fn enter(&mut self, address: u32) {
        // SAFETY: `avr` is alive, and no instruction runs.
        unsafe {
            (*self.avr).pc = address;
            let sp = self.sp() - (*self.avr).address_size as u16;
            for place in sp + 1..=self.sp() {
                self.set_byte(place, 0);
            }
            let [low, high] = sp.to_le_bytes();
            *(*self.avr).data.add(0x5D) = low;
            *(*self.avr).data.add(0x5E) = high;
        }
    }

    /// Executes one instruction, with the activity of the hardware meanwhile.
    #[inline(always)]
    pub(crate) fn step(&mut self) {
        // SAFETY: `avr` is alive; its callbacks are ours, see `probes.rs`.
        let state = unsafe { ffi::avr_run(self.avr) } as u32;
        assert!(
            state == ffi::cpu_Running || state == ffi::cpu_Sleeping,
            "the chip has crashed at {:#x}",
            self.pc()
        );
    }

    /// Cycles since the last reset.
    #[inline(always)]
    pub(crate) fn cycle(&self) -> u64 {
        // SAFETY: `avr` is alive.
        unsafe { (*self.avr).cycle }
    }

    /// The address of the next instruction, in bytes.
    #[inline(always)]
    pub(crate) fn pc(&self) -> u32 {
        // SAFETY: `avr` is alive.
        unsafe { (*self.avr).pc }
    }

    /// The stack pointer.
    #[inline(always)]
    pub(crate) fn sp(&self) -> u16 {
        u16::from_le_bytes([self.byte(0x5D), self.byte(0x5E)])
    }

    /// Whether interrupts are enabled: the flag I of SREG.
    #[inline(always)]
    pub(crate) fn interrupts(&self) -> bool {
        // SAFETY: `avr` is alive.
        unsafe { (*self.avr).sreg[7] != 0 }
    }

    /// A reset for a reason: RAM and EEPROM keep their contents.
    pub(crate) fn reset(&mut self, cause: Cause) {
        // SAFETY: `avr` is alive, and no callback runs.
        unsafe {
            let flags = (*self.avr).reset_flags;
            let (own, others) = match cause {
                Cause::Power => (flags.porf, [flags.extrf, flags.borf, flags.wdrf]),
                // They stay until the program clears them.
                Cause::Button => (flags.extrf, [flags.extrf; 3]),
                Cause::BrownOut => (flags.borf, [flags.borf; 3]),
                Cause::Watchdog => (flags.wdrf, [flags.wdrf; 3]),
            };
            others.into_iter().for_each(|flag| set(self.avr, flag, false));
            set(self.avr, own, true);
            ffi::avr_reset(self.avr);
        }
    }

    /// Clears the reason of the reset, as a boot loader does before the program.
    pub(crate) fn clear_cause(&mut self) {
        // SAFETY: as above.
        unsafe {
            let flags = (*self.avr).reset_flags;
            [flags.porf, flags.extrf, flags.borf, flags.wdrf]
                .into_iter()
                .for_each(|flag| set(self.avr, flag, false));
        }
    }

    /// Switches the power off and on: only flash and EEPROM keep their contents.
    pub(crate) fn power_cycle(&mut self) {
        self.paint();
        self.reset(Cause::Power);
    }

    /// The cycles of a byte on the line, as the firmware has set up USART0.
    pub(crate) fn byte_time(&self) -> u64 {
        let divider =
            u64::from(self.byte(UBRR0 as u16)) | u64::from(self.byte(UBRR0 as u16 + 1)) << 8;
        let bit = (divider + 1) * if self.byte(UCSR0A as u16) & 2 != 0 { 8 } else { 16 };
        10 * bit
    }

    /// Whether the firmware has read every byte that USART0 got.
    pub(crate) fn receiver_is_empty(&self) -> bool {
        // SAFETY: `uart` belongs to `avr`.
        unsafe { (*self.uart).input.read == (*self.uart).input.write }
    }

    /// Delivers a byte now. Only while the receiver is empty.
    pub(crate) fn receive(&mut self, byte: u8) {
        // SAFETY: as above; simavr created the irq. The receiver counts the time of a byte from its
        // arrival, but that time has passed already.
        unsafe {
            (*self.uart).cycles_per_byte = 1;
            ffi::avr_raise_irq((*self.uart).io.irq, u32::from(byte));
            (*self.uart).cycles_per_byte = self.byte_time();
        }
    }

    /// Sets simavr's time for a byte.
    pub(crate) fn set_byte_time(&self, cycles: u64) {
        // SAFETY: `uart` belongs to `avr`.
        unsafe { (*self.uart).cycles_per_byte = cycles }
    }

    /// Reports a data overrun: a byte was lost.
    pub(crate) fn overrun(&mut self) {
        // SAFETY: UCSR0A is inside `data`; its bit 3 is DOR.
        unsafe { *(*self.avr).data.add(UCSR0A) |= 1 << 3 }
    }

    /// Holds an input pin low, or leaves it to its pull-up.
    pub(crate) fn pull(&mut self, pin: Pin, low: bool) {
        let Pin(port, bit) = pin;
        let index = self.pulled.iter().position(|(name, ..)| *name == port).unwrap_or_else(|| {
            self.pulled.push((port, 0, 0));
            self.pulled.len() - 1
        });
        let (_, mask, value) = &mut self.pulled[index];
        *mask |= 1 << bit;
        *value = *value & !(1 << bit) | u8::from(!low) << bit;
        let (mask, value) = (u64::from(*mask), u64::from(*value));
        // SAFETY: the structure is simavr's, and simavr copies it.
        unsafe {
            let mut external: ffi::avr_ioport_external_t = std::mem::zeroed();
            external.set_name(u64::from(port as u8));
            external.set_mask(mask);
            external.set_value(value);
            let name = request([b'i', b'o', b'p', port as u8]);
            ffi::avr_ioctl(self.avr, name, ptr::from_mut(&mut external).cast());
            ffi::avr_raise_irq(self.pin(pin), u32::from(!low));
        }
    }

    /// simavr's signal of a pin.
    pub(crate) fn pin(&self, Pin(port, bit): Pin) -> *mut ffi::avr_irq_t {
        let name = request([b'i', b'o', b'g', port as u8]);
        // SAFETY: `avr` is alive; null if it has no such pin.
        let irq = unsafe { ffi::avr_io_getirq(self.avr, name, i32::from(bit)) };
        assert!(!irq.is_null(), "no pin P{port}{bit}");
        irq
    }

    /// simavr's signal of a byte that USART0 sends.
    pub(crate) fn sent(&self) -> *mut ffi::avr_irq_t {
        // SAFETY: `uart` belongs to `avr` and has four irqs.
        unsafe { (*self.uart).io.irq.add(ffi::UART_IRQ_OUTPUT as usize) }
    }

    /// The timer with this number.
    pub(crate) fn timer(&self, number: u8) -> *mut ffi::avr_timer_t {
        // SAFETY: `find` returns live ones.
        find(self.avr, c"timer", |timer: *mut ffi::avr_timer_t| unsafe {
            (*timer).name as u8 == b'0' + number
        })
    }

    /// The whole EEPROM.
    pub(crate) fn eeprom(&self) -> Vec<u8> {
        // SAFETY: the description's length is the buffer's.
        unsafe {
            let mut bytes = vec![0; (*self.avr).e2end as usize + 1];
            let mut what = ffi::avr_eeprom_desc_t {
                ee: bytes.as_mut_ptr(),
                offset: 0,
                size: bytes.len() as u32,
            };
            ffi::avr_ioctl(self.avr, request(*b"eegp"), ptr::from_mut(&mut what).cast());
            bytes
        }
    }

    /// Writes `bytes` to the EEPROM from `offset` on.
    pub(crate) fn set_eeprom(&mut self, offset: u16, bytes: &[u8]) {
        let mut bytes = bytes.to_vec();
        // SAFETY: the description's length is the buffer's; simavr refuses bytes beyond the end.
        let result = unsafe {
            let mut what =
                ffi::avr_eeprom_desc_t { ee: bytes.as_mut_ptr(), offset, size: bytes.len() as u32 };
            ffi::avr_ioctl(self.avr, request(*b"eesp"), ptr::from_mut(&mut what).cast())
        };
        assert_eq!(result, 0, "beyond the end of the EEPROM");
    }
}

impl Drop for Silicon {
    fn drop(&mut self) {
        // SAFETY: the last use.
        unsafe {
            ffi::avr_terminate(self.avr);
        }
    }
}

/// The module of a kind and name in simavr's list, as its own structure.
fn find<T>(avr: *mut ffi::avr_t, kind: &CStr, is_it: impl Fn(*mut T) -> bool) -> *mut T {
    // SAFETY: the list ends with null; a module of a kind is the beginning of that kind's
    // structure, and the callers pass the right one.
    unsafe {
        let mut module = (*avr).io_port;
        while !module.is_null() {
            if CStr::from_ptr((*module).kind) == kind && is_it(module.cast()) {
                return module.cast();
            }
            module = (*module).next;
        }
    }
    panic!("the chip lacks a {kind:?}")
}

/// USART0.
fn find_uart(avr: *mut ffi::avr_t) -> *mut ffi::avr_uart_t {
    // SAFETY: `find` returns live ones.
    find(avr, c"uart", |uart: *mut ffi::avr_uart_t| unsafe { (*uart).name as u8 == b'0' })
}

/// Sets or clears a bit of a register.
///
/// # Safety
/// `avr` is alive and the bit is one of its own.
unsafe fn set(avr: *mut ffi::avr_t, bit: ffi::avr_regbit_t, to: bool) {
    let (register, mask) = (bit.reg() as usize, 1u8 << bit.bit());
    if register == 0 {
        return;
    }
    // SAFETY: the caller's promise.
    unsafe {
        let byte = (*avr).data.add(register);
        *byte = if to { *byte | mask } else { *byte & !mask };
    }
}

/// A pointer for simavr's callbacks.
pub(crate) fn opaque<T>(of: &mut T) -> *mut c_void {
    ptr::from_mut(of).cast()
}
