//! TIMER0, free-running at 16 MHz with 32 bits: compare 0 steps.

use stepwright::HoldOff;
use stepwright::timer::StepTimer;
use stepwright_controller::Register;

/// A register of TIMER0.
const fn timer(offset: usize) -> Register {
    // SAFETY: the manual's table of TIMER: its tasks, events and registers are words.
    unsafe { Register::at(0x4000_8000 + offset) }
}

const START: Register = timer(0x000);
const CLEAR: Register = timer(0x00C);
/// Copies the counter into a compare register; the test uses 1, the main loop 2, the engine 3.
const CAPTURE: [Register; 4] = [timer(0x040), timer(0x044), timer(0x048), timer(0x04C)];
const COMPARED: Register = timer(0x140);
const INTERRUPT_ON: Register = timer(0x304);
const MODE: Register = timer(0x504);
const BITS: Register = timer(0x508);
const PRESCALER: Register = timer(0x510);
const COMPARE: [Register; 4] = [timer(0x540), timer(0x544), timer(0x548), timer(0x54C)];

/// The interrupt controller: enables, disables and pends interrupts, a bit each.
const ENABLES: usize = 0xE000_E100;
const DISABLES: Register = nvic(0x180);
const PENDS: Register = nvic(0x200);
/// TIMER0's bit.
const BIT: u32 = 1 << crate::vectors::TIMER0_NUMBER;
/// The interrupts that are held off together: also the less urgent ones, each of which would extend
/// a hold by its own length.
const HELD: u32 = BIT | 1 << crate::vectors::UART0_NUMBER;

const fn nvic(offset: usize) -> Register {
    // SAFETY: ARMv6-M: ISER, ICER and ISPR, where a written 0 changes nothing; IPR.
    unsafe { Register::at(0xE000_E000 + offset) }
}

/// The step timer.
pub struct Timer(());

/// The priorities of interrupts 8 to 11, a byte each, of which the two highest bits count: TIMER0's
/// is the first.
const PRIORITIES: Register = nvic(0x408);
/// The second most urgent priority.
const BEHIND_THE_URGENT: u32 = 0x40;

impl Timer {
    /// Starts TIMER0 at 0, its interrupt held off. If its priority is that of a reset, 0, it gets
    /// the next lower one, so that an interrupt of the program's own, with priority 0, does not
    /// wait for steps.
    ///
    /// # Safety
    /// Called once.
    pub unsafe fn start() -> Timer {
        let priorities = PRIORITIES.read();
        if priorities & 0xFF == 0 {
            PRIORITIES.write(priorities | BEHIND_THE_URGENT);
        }
        // SAFETY: CLOCK's task HFCLKSTART. Until the crystal is ready the RC oscillator counts.
        unsafe { Register::at(0x4000_0000) }.write(1);
        BITS.write(3);
        PRESCALER.write(0);
        MODE.write(0);
        CLEAR.write(1);
        INTERRUPT_ON.write(1 << 16);
        START.write(1);
        Timer(())
    }
}

/// The counter. Called in the main loop, with the step interrupt enabled.
#[inline(always)]
pub fn count() -> u32 {
    CAPTURE[2].write(1);
    COMPARE[2].read()
}

/// The counter, for a test in the step interrupt.
#[inline(always)]
pub fn captured() -> u32 {
    CAPTURE[1].write(1);
    COMPARE[1].read()
}

impl StepTimer for Timer {
    type Count = u32;
    /// Leaving and entering the interrupt takes 32 cycles, plus the registers that the handler
    /// saves.
    const LINGER: u32 = 48;
    /// 16 cycles, and some 35 instructions up to the edge of a single due step; twice as many for
    /// several steps.
    const REACTION: u32 = 140;

    #[inline(always)]
    fn now(&mut self) -> u32 {
        CAPTURE[3].write(1);
        COMPARE[3].read()
    }

    #[inline(always)]
    fn wake_at(&mut self, at: u32) {
        COMPARE[0].write(at);
        // Clears the request of the previous value. If the new value has passed already, its
        // request is cleared too, and the comparison with the counter detects that.
        COMPARED.write(0);
        if at.wrapping_sub(self.now()) as i32 <= 0 {
            PENDS.write(BIT);
        }
    }

    #[inline(always)]
    fn set_compare(&mut self, at: u32) {
        COMPARE[0].write(at);
        COMPARED.write(0);
    }
}

/// TIMER0's interrupt, and the less urgent ones.
pub struct StepInterrupt;

// SAFETY: the enable bits, 0 after a reset, include that of the one interrupt that calls the
// engine; barriers follow them, as ARM requires. Pending interrupts stay pending.
unsafe impl HoldOff for StepInterrupt {
    #[inline(always)]
    fn hold() {
        DISABLES.write(HELD);
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
    }

    #[inline(always)]
    fn release() {
        // All previous accesses are complete before the interrupt comes. A pending interrupt comes
        // now, not after other instructions of the compiler or after the next hold.
        // SAFETY: a write to ISER between two barriers.
        unsafe {
            core::arch::asm!(
                "dsb", "str {bits}, [{enables}]", "dsb", "isb",
                bits = in(reg) HELD,
                enables = in(reg) ENABLES,
                options(nostack, preserves_flags),
            );
        }
    }
}
