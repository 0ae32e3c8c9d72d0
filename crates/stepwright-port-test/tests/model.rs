//! A model of a timer's registers whose time passes with each access; timers on it that keep the contract,
//! and timers that do not.

use std::cell::Cell;
use std::marker::PhantomData;

use stepwright::timer::{Count, StepTimer};
use stepwright_port_test::{Checked, TestPort, TimerFault, TimerProbe, check};

/// The registers: a counter, a compare register that matches when the counter reaches it, and the interrupt
/// request.
#[derive(Default)]
struct Registers {
    count: Cell<u64>,
    compare: Cell<u64>,
    request: Cell<bool>,
    /// Ticks per access.
    access: u64,
}

impl Registers {
    fn pass(&self, mask: u64, ticks: u64) {
        for _ in 0..ticks {
            self.count.set((self.count.get() + 1) & mask);
            if self.count.get() == self.compare.get() {
                self.request.set(true);
            }
        }
    }
}

/// How `wake_at` handles a value that has passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// Writes the value, clears the old request, looks at the counter, and pends the interrupt.
    Right,
    /// Like `Right`, but looks at the counter before it writes the value.
    TooSoon,
    /// Does not look at the counter.
    Forgets,
    /// Looks at the counter, and then clears the request, its own too.
    ClearsLast,
    /// Compares counts as numbers, which is wrong after a wrap.
    Unsigned,
    /// Counts down.
    Down,
    /// Stands still.
    Stands,
}

/// The width of a counter: 16 or 32 bits.
trait Width: Count + Into<u64> {
    const MASK: u64;
    /// The low bits of a count.
    fn low(count: u64) -> Self;
}

impl Width for u16 {
    const MASK: u64 = 0xFFFF;
    fn low(count: u64) -> u16 {
        count as u16
    }
}

impl Width for u32 {
    const MASK: u64 = 0xFFFF_FFFF;
    fn low(count: u64) -> u32 {
        count as u32
    }
}

/// A timer of this width.
struct Model<'r, C> {
    registers: &'r Registers,
    way: Way,
    width: PhantomData<C>,
}

impl<C: Width> Model<'_, C> {
    const MASK: u64 = C::MASK;

    fn read(&self) -> u64 {
        if self.way != Way::Stands {
            self.registers.pass(Self::MASK, self.registers.access);
        }
        let count = self.registers.count.get();
        if self.way == Way::Down { Self::MASK - count } else { count }
    }

    fn write(&self, at: u64) {
        self.registers.pass(Self::MASK, self.registers.access);
        self.registers.compare.set(at);
    }

    fn has_passed(&self, at: u64) -> bool {
        let now = self.read();
        match self.way {
            Way::Unsigned => at <= now,
            _ => now.wrapping_sub(at) & Self::MASK <= Self::MASK / 2,
        }
    }

    fn wake(&self, at: u64) {
        let too_soon = self.way == Way::TooSoon && self.has_passed(at);
        self.write(at);
        if self.way != Way::ClearsLast {
            self.registers.request.set(false);
        }
        match self.way {
            Way::TooSoon => self.registers.request.set(too_soon || self.registers.request.get()),
            Way::Forgets => {}
            Way::ClearsLast => {
                if self.has_passed(at) {
                    self.registers.request.set(true);
                }
                self.registers.pass(Self::MASK, self.registers.access);
                self.registers.request.set(false);
            }
            _ if self.has_passed(at) => self.registers.request.set(true),
            _ => {}
        }
    }
}

impl<C: Width> StepTimer for Model<'_, C> {
    type Count = C;

    fn now(&mut self) -> C {
        C::low(self.read())
    }
    fn wake_at(&mut self, at: C) {
        self.wake(at.into());
    }
}

struct Bench<'r, C: Width> {
    probe: TimerProbe<Model<'r, C>>,
    registers: &'r Registers,
    can_set: bool,
}

impl<'r, C: Width> TestPort for Bench<'r, C> {
    type Timer = Model<'r, C>;

    fn with<R>(&mut self, ask: impl FnOnce(&mut TimerProbe<Self::Timer>) -> R) -> R {
        ask(&mut self.probe)
    }

    fn idle(&mut self) {
        self.registers.pass(C::MASK, 1);
        if self.registers.request.replace(false) {
            self.probe.on_compare();
        }
    }

    fn set_count(&mut self, count: C) -> bool {
        if self.can_set {
            self.registers.count.set(count.into());
        }
        self.can_set
    }
}

fn tried<C: Width>(way: Way, access: u64, can_set: bool) -> Result<Checked, TimerFault> {
    let registers = Registers { access, ..Registers::default() };
    let probe = TimerProbe::new(Model { registers: &registers, way, width: PhantomData::<C> });
    check(&mut Bench { probe, registers: &registers, can_set }, 200)
}

#[test]
fn a_timer_that_keeps_the_contract_passes() {
    for access in 1..=9 {
        let narrow = tried::<u16>(Way::Right, access, false).unwrap();
        assert!(narrow.wrapped && narrow.values > 300, "{narrow:?}");
        let wide = tried::<u32>(Way::Right, access, true).unwrap();
        assert!(wide.wrapped && wide.values > narrow.values, "{wide:?}");
        // The test does not wait for 2³² ticks.
        assert!(!tried::<u32>(Way::Right, access, false).unwrap().wrapped);
    }
}

/// The fault names the missed value: 0 ticks ahead, the first that is tried.
#[test]
fn a_timer_that_forgets_what_has_passed_fails() {
    for access in 1..=9 {
        let lost = |fault| matches!(fault, Err(TimerFault::Lost { ahead: 0, .. }));
        assert!(lost(tried::<u16>(Way::Forgets, access, false)));
        assert!(lost(tried::<u32>(Way::Forgets, access, true)));
    }
    let said = tried::<u32>(Way::Forgets, 3, true).unwrap_err().to_string();
    assert!(said.contains("a compare value 0 ticks ago: `wake_at` has to look"), "{said}");
}

#[test]
fn a_timer_that_looks_before_it_writes_fails() {
    for access in 2..=9 {
        let fault = tried::<u32>(Way::TooSoon, access, true);
        assert!(
            matches!(fault, Err(TimerFault::Lost { ahead: 1..=12, .. })),
            "{access}: {fault:?}"
        );
    }
}

#[test]
fn a_timer_that_clears_its_own_request_fails() {
    let fault = tried::<u32>(Way::ClearsLast, 2, true);
    assert!(matches!(fault, Err(TimerFault::Lost { .. })), "{fault:?}");
}

#[test]
fn a_timer_that_compares_numbers_fails_at_a_wrap() {
    let narrow = tried::<u16>(Way::Unsigned, 2, false);
    assert!(matches!(narrow, Err(TimerFault::Lost { .. })), "{narrow:?}");
    let wide = tried::<u32>(Way::Unsigned, 2, true);
    assert!(matches!(wide, Err(TimerFault::Lost { .. })), "{wide:?}");
}

#[test]
fn a_counter_that_does_not_count_up_fails() {
    assert_eq!(tried::<u32>(Way::Stands, 1, true), Err(TimerFault::StandsStill));
    assert!(tried::<u32>(Way::Down, 1, true).is_err());
}

/// Both widths have the same arithmetic.
#[test]
fn counts_wrap() {
    assert_eq!(5u16.since(u16::MAX), 6);
    assert_eq!(5u32.since(u32::MAX), 6);
}
