//! The controller beside a program's own interrupt that is more urgent than the step interrupt: it
//! measures how long that interrupt waits. QEMU's plugin sees each wait, in units of 16 ns, as a
//! store.
#![no_std]
#![no_main]

use core::arch::asm;
use core::sync::atomic::{AtomicU32, Ordering};

use riscv::interrupt::Interrupt;
use stepwright_controller::{ControllerEngine, Register};
use stepwright_virt::board::BOARD;
use stepwright_virt::pins::{BoardPins, StepPins};
use stepwright_virt::timer::{self, StepInterrupt, Timer};
use stepwright_virt::uart::Uart;

#[path = "../../../qemu/chip/waits.rs"]
mod waits;

use waits::Waits;

static ENGINE: ControllerEngine<Timer, StepPins, StepInterrupt> = ControllerEngine::empty();

#[unsafe(no_mangle)]
static WAITS: Waits = Waits::new();

/// The time of the alarm, in ns.
static ALARM: AtomicU32 = AtomicU32::new(0);

/// A register of the clock (Goldfish), which counts ns.
const fn clock(offset: usize) -> Register {
    // SAFETY: the memory map of `virt`: the clock at 0x10_1000, words.
    unsafe { Register::at(0x0010_1000 + offset) }
}

/// A register of the interrupt controller.
const fn plic(offset: usize) -> Register {
    // SAFETY: as above: the PLIC at 0xC00_0000, words.
    unsafe { Register::at(0x0C00_0000 + offset) }
}

/// The clock's interrupt at the controller.
const CLOCK_NUMBER: usize = 11;
const CLAIM: Register = plic(0x20_0004);

#[riscv_rt::core_interrupt(Interrupt::MachineTimer)]
fn on_compare() {
    // SAFETY: this is the step interrupt, and the clock's interrupt does not use the motors.
    unsafe { timer::visit(|| ENGINE.on_compare()) };
}

/// The program's own interrupt.
#[riscv_rt::core_interrupt(Interrupt::MachineExternal)]
fn on_alarm() {
    let now = clock(0x00).read();
    let claimed = CLAIM.read();
    clock(0x1C).write(1);
    WAITS.tell(now.wrapping_sub(ALARM.load(Ordering::Relaxed)) / 16);
    set_alarm(30_000 + WAITS.luck(18));
    CLAIM.write(claimed);
}

/// Sets the alarm this many ns from now.
#[inline(always)]
fn set_alarm(after: u32) {
    // Reading the low half latches the high one.
    let (low, high) = (clock(0x00).read(), clock(0x04).read());
    let (at, carry) = low.overflowing_add(after);
    clock(0x0C).write(high.wrapping_add(carry.into()));
    clock(0x08).write(at);
    ALARM.store(at, Ordering::Relaxed);
}

/// Starts the clock's alarms.
fn start_urgent() {
    plic(4 * CLOCK_NUMBER).write(1);
    plic(0x2000).write(1 << CLOCK_NUMBER);
    plic(0x20_0000).write(0);
    clock(0x10).write(1);
    set_alarm(1_000_000);
    // SAFETY: MEIE of `mie`; the interrupt uses only the clock and `WAITS`.
    unsafe { asm!("csrs mie, {bit}", bit = in(reg) 1 << 11, options(nostack)) };
}

#[riscv_rt::entry]
fn main() -> ! {
    // SAFETY: each of them once.
    let (timer, pins, panel, mut line) =
        unsafe { (Timer::start(), StepPins::new(), BoardPins::new(), Uart::start()) };
    start_urgent();
    stepwright_controller::run(&ENGINE, timer, pins, BOARD, panel, &mut line)
}
