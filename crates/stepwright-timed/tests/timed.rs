//! The timed driver's rules, and its times against an independent computation.

use proptest::prelude::*;
use stepwright::drive::{Coils, Port, sequence};
use stepwright::engine::{Engine, Timing};
use stepwright::queue::Asked;
use stepwright::timer::{Count, StepTimer};
use stepwright_timed::fit::Hardware;
use stepwright_timed::{
    Call, Code, Control, Driver, Hold, Model, Pace, SetSpeed, Status, Stepper, Timed,
};

const UNO: Hardware = Hardware::avr16(16_000_000);
const ON: Control = Control::DRV_EN;
const VARIABLE: Control = ON.and(Control::SPEED_VARIABLE);

/// The interrupt's half without an interrupt.
struct Here {
    pace: Pace,
    on: bool,
    forward: bool,
}

impl Hold for Here {
    fn with<R>(&mut self, look: impl FnOnce(&mut Pace) -> R) -> R {
        look(&mut self.pace)
    }
    fn begin(&mut self, pace: Pace, forward: bool) {
        *self = Here { pace, on: true, forward };
    }
    fn stop(&mut self) {
        self.on = false;
    }
}

fn driver() -> (Driver, Here) {
    let here = Here { pace: Pace::idle(), on: false, forward: true };
    (Driver::new(UNO, Model::Ideal), here)
}

/// A linear ramp of the manual: 29 updates of 91264 from 2666666 end at 20010.
#[test]
fn the_manuals_example() {
    let order = SetSpeed {
        control: VARIABLE | Control::IRQ_TIMING | Control::FASTER,
        top: 2_666_666,
        limit: 0,
        modification: 91_264,
        update_ms: 250,
        mod_counts: 29,
    };
    let (mut driver, mut here) = driver();
    assert_eq!(driver.set_speed(&mut here, &order, 0), Code::FINE);
    for _ in 0..5_000 {
        here.pace.advance();
    }
    let dump = driver.dump(&mut here, 0);
    assert_eq!((dump.top, dump.modification, dump.counts), (20_010, 91_264, 0));
    assert_eq!(dump.status, Status::SPIN_FIXED);
    assert_eq!(dump.time, 29 * 250);
}

#[test]
fn fixed_speeds_of_the_manual() {
    let order = SetSpeed { limit: 20_000, ..SetSpeed::fixed(ON, 64_000) };
    let delays: Vec<_> = Timed::new(UNO, Model::Ideal, &order).unwrap().collect();
    assert_eq!(delays.len(), 20_000);
    assert!(delays.iter().all(|delay| *delay == 64_000));
    // Without SPEED_VARIABLE the modification is ignored.
    let order = SetSpeed { modification: 9, update_ms: 1, mod_counts: 9, ..order };
    let (mut driver, mut here) = driver();
    assert_eq!(driver.set_speed(&mut here, &order, 0), Code::FINE);
    assert_eq!(driver.status(&mut here), Status::SPIN_FIXED);
    assert_eq!(driver.dump(&mut here, 2).modification, 0);
}

#[test]
fn without_enable_or_top_it_stops() {
    let moving = SetSpeed { limit: 9, ..SetSpeed::fixed(ON | Control::DIRECTION, 64_000) };
    for stop in [
        SetSpeed::STOP,
        SetSpeed::fixed(ON, 0),
        SetSpeed { control: Control::SPEED_VARIABLE, ..moving },
    ] {
        let (mut driver, mut here) = driver();
        assert_eq!(driver.set_speed(&mut here, &moving, 5), Code::FINE);
        assert!(here.on && !here.forward);
        assert_eq!(driver.set_speed(&mut here, &stop, 6), Code::FINE);
        assert!(!here.on && !here.pace.is_moving() && !here.pace.is_step());
        assert_eq!(here.pace.advance(), None);
        assert_eq!(driver.status(&mut here), Status::NONE);
        let dump = driver.dump(&mut here, 3);
        assert_eq!(dump, stepwright_timed::Dump { time: 5, ..Default::default() });
    }
}

#[test]
fn what_is_refused_changes_the_status_alone() {
    let moving = SetSpeed::fixed(ON, 64_000);
    let (mut driver, mut here) = driver();
    driver.set_speed(&mut here, &moving, 0);
    assert_eq!(driver.set_speed(&mut here, &SetSpeed::fixed(ON, 639), 1), Code::TOO_FAST);
    assert_eq!(driver.status(&mut here), Status::FAULT.and(Status::SPIN_FIXED));
    assert_eq!(here.pace.advance(), Some(64_000));
    assert_eq!(driver.set_speed(&mut here, &SetSpeed::fixed(ON, 0x400_0000), 2), Code::TOO_SLOW);
    let mut calls = Vec::new();
    driver.update_check(&mut here, 3, |call| calls.push(call));
    driver.update_check(&mut here, 4, |call| calls.push(call));
    assert_eq!(calls, [Call::Fault]);
    let fault = Status::FAULT.and(Status::FAULT_CALLED).and(Status::TIMER_DIV_ERROR);
    let fault = fault.and(Status::TIMER_DIV_CALLED).and(Status::SPIN_FIXED);
    assert_eq!(driver.status(&mut here), fault);
    // The next order starts with a new status.
    assert_eq!(driver.set_speed(&mut here, &moving, 5), Code::FINE);
    assert_eq!(driver.status(&mut here), Status::SPIN_FIXED);
    assert!(Timed::new(UNO, Model::Ideal, &SetSpeed::fixed(ON, 1)).is_err());
}

#[test]
fn warnings_come_beforehand() {
    let order = SetSpeed {
        control: VARIABLE | Control::FASTER,
        top: 10_000,
        limit: 0,
        modification: 1_000,
        update_ms: 10,
        mod_counts: 9,
    };
    let code = |order: SetSpeed| {
        let (mut driver, mut here) = driver();
        driver.set_speed(&mut here, &order, 0)
    };
    assert_eq!(code(order), Code::FINE);
    assert_eq!(code(SetSpeed { mod_counts: 10, ..order }), Code::WARN_RANGE);
    assert_eq!(code(SetSpeed { modification: 0, ..order }), Code::WARN_NO_UPDATES);
    assert_eq!(code(SetSpeed { update_ms: 0, ..order }), Code::WARN_NO_UPDATES);
    assert_eq!(code(SetSpeed { mod_counts: 0, ..order }), Code::WARN_NO_UPDATES);
    let power = VARIABLE | Control::VARIABLE_PWR;
    let slower = SetSpeed { control: power, modification: 1, ..order };
    assert_eq!(code(SetSpeed { mod_counts: 25, ..slower }), Code::FINE);
    assert_eq!(code(SetSpeed { mod_counts: 26, ..slower }), Code::WARN_RANGE);
    assert_eq!(code(SetSpeed { mod_counts: u16::MAX, ..slower }), Code::WARN_RANGE);
    let fast = Hardware::wide32(100_000_000);
    let (mut driver, mut here) =
        (Driver::new(fast, Model::Ideal), Here { pace: Pace::idle(), on: false, forward: true });
    let long = SetSpeed { update_ms: 60_000, ..order };
    assert_eq!(driver.set_speed(&mut here, &long, 0), Code::UPDATE_TOO_LONG);
    assert!(!here.on);
}

/// An update that would leave the valid range: fault, the last valid top, fixed speed.
#[test]
fn an_update_beyond_the_range_faults_and_keeps_the_speed() {
    for (control, top, modification, status) in [
        (Control::FASTER, 2_000, 700, Status::FAULT),
        (Control::FASTER, 2_000, u32::MAX, Status::FAULT),
        (Control::SLOWER, 0x3FF_0000, 0x1_0000, Status::FAULT.and(Status::TIMER_DIV_ERROR)),
        (Control::SLOWER, 0x3FF_0000, u32::MAX, Status::FAULT.and(Status::TIMER_DIV_ERROR)),
    ] {
        for clocked in [Control::IRQ_TIMING, Control::OFF] {
            let order = SetSpeed {
                control: VARIABLE | control | clocked,
                top,
                limit: 0,
                modification,
                update_ms: 10,
                mod_counts: 100,
            };
            let (mut driver, mut here) = driver();
            assert_eq!(driver.set_speed(&mut here, &order, 0), Code::WARN_RANGE);
            let mut calls = 0;
            let mut last = 0;
            for n in 1..=1_000 {
                last = here.pace.advance().unwrap();
                driver.update_check(&mut here, n * 10, |call| {
                    assert_eq!(call, Call::Fault);
                    calls += 1;
                });
            }
            let told = driver.status(&mut here);
            assert!(told.has(status.and(Status::SPIN_FIXED)), "{told:?}");
            let dump = driver.dump(&mut here, 0);
            assert!((640..=0x3FF_FFFF).contains(&dump.top));
            assert_eq!(last, UNO.fit(dump.top).unwrap().interval());
            // Only the caller's own check calls back.
            assert_eq!(calls, u32::from(clocked == Control::OFF));
            assert_eq!(told.has(Status::FAULT_CALLED), clocked == Control::OFF);
        }
    }
}

#[test]
fn the_end_is_called_once_and_never_from_the_interrupt() {
    for clocked in [Control::IRQ_TIMING, Control::OFF] {
        let order = SetSpeed { limit: 3, ..SetSpeed::fixed(ON | clocked, 16_000) };
        let (mut driver, mut here) = driver();
        let mut calls = Vec::new();
        for round in 1..=2 {
            driver.set_speed(&mut here, &order, 0);
            for now in 0..9 {
                driver.update_check(&mut here, now, |call| calls.push(call));
                here.pace.advance();
            }
            let expected = if clocked == Control::OFF { round } else { 0 };
            assert_eq!(calls, vec![Call::Reached; expected]);
            assert!(driver.status(&mut here).has(Status::REACHED));
        }
    }
}

/// Milliseconds end between two steps: no step at the end or after it.
#[test]
fn an_end_in_milliseconds() {
    let order =
        |limit| SetSpeed { limit, ..SetSpeed::fixed(ON | Control::ENDPOINT_MILLIS, 48_000) };
    let steps = |limit| Timed::new(UNO, Model::Ideal, &order(limit)).unwrap().count();
    assert_eq!([1, 2, 3, 4, 6, 7, 9, 10].map(steps), [0, 0, 0, 1, 1, 2, 2, 3]);
    let (mut driver, mut here) = driver();
    driver.set_speed(&mut here, &order(7), u32::MAX - 2);
    assert_eq!(driver.dump(&mut here, 0).end, 4); // the caller's clock wraps
    assert_eq!(here.pace.advance(), Some(48_000));
    assert!(here.pace.is_step());
    assert_eq!(here.pace.advance(), Some(16_000));
    assert!(!here.pace.is_step());
    assert_eq!(here.pace.advance(), None);
    assert!(driver.status(&mut here).has(Status::REACHED));
}

/// The one step after an update lasts the old top at the new prescaler.
#[test]
fn the_latched_model() {
    // 60000 at 1 becomes 80000: 10000 at 8.
    let order = SetSpeed {
        control: VARIABLE | Control::IRQ_TIMING,
        top: 60_000,
        limit: 5,
        modification: 20_000,
        update_ms: 7,
        mod_counts: 1,
    };
    let delays = |model| Timed::new(UNO, model, &order).unwrap().collect::<Vec<_>>();
    assert_eq!(delays(Model::Ideal), [60_000, 60_000, 80_000, 80_000, 80_000]);
    assert_eq!(delays(Model::Latched), [60_000, 60_000, 480_000, 80_000, 80_000]);
}

/// A clock with a fractional number of clocks per millisecond: updates do not drift.
#[test]
fn updates_do_not_drift_on_an_odd_clock() {
    let hardware = Hardware::capture16(62_500);
    let order = SetSpeed {
        control: VARIABLE | Control::IRQ_TIMING,
        top: 1,
        limit: 62_500 * 10,
        modification: 1,
        update_ms: 3,
        mod_counts: 1,
    };
    // Updates at 187.5 clocks: at the 188th step.
    let first = Timed::new(hardware, Model::Ideal, &order).unwrap().position(|delay| delay == 2);
    assert_eq!(first, Some(188));
    let many = SetSpeed { update_ms: 33, mod_counts: 1_000, top: 100, ..order };
    let mut timed = Timed::new(hardware, Model::Ideal, &many).unwrap();
    let mut time = 0;
    for delay in timed.by_ref().take_while(|delay| *delay < 1_100) {
        time += u64::from(delay);
    }
    // 1000 updates of 2062.5 clocks, and less than a step more.
    assert!((2_062_500..2_062_500 + 1_100).contains(&time), "{time}");
}

/// A counter that the test moves.
struct Counter {
    now: u32,
    wake: u32,
}

impl StepTimer for Counter {
    type Count = u32;
    fn now(&mut self) -> u32 {
        self.now
    }
    fn wake_at(&mut self, at: u32) {
        self.wake = if at.is_after(self.now) { at } else { self.now };
    }
}

#[derive(Default)]
struct Pins(u8);

impl Port for Pins {
    fn set(&mut self, mask: u8) {
        self.0 |= mask;
    }
    fn clear(&mut self, mask: u8) {
        self.0 &= !mask;
    }
}

/// Timed speed played by the engine: the same times, on coils.
#[test]
fn the_engine_plays_it() {
    let order = SetSpeed {
        control: VARIABLE | Control::IRQ_TIMING | Control::VARIABLE_PWR,
        top: 15_000,
        limit: 500,
        modification: 64,
        update_ms: 50,
        mod_counts: 9,
    };
    let timed = Timed::new(UNO, Model::Latched, &order).unwrap();
    let delays: Vec<u32> = timed.clone().collect();
    let coils = Coils::new(Pins::default(), sequence::SHIELD, 0b11);
    let timing = Timing { pulse: 0, setup: 0, hold: 0, min_interval: 640 };
    let rate = stepwright::Rate::from_hz(16_000_000).unwrap();
    let mut engine =
        Engine::new(Counter { now: 0, wake: 0 }, coils, [Asked::new(timed)], timing, rate);
    engine.start(1);
    let mut times = Vec::new();
    while !engine.report(0).idle {
        let before = engine.drive().phase();
        let wake = engine.timer().wake;
        engine.timer().now = wake;
        engine.on_compare();
        if engine.drive().phase() != before {
            times.push(wake);
        }
    }
    let mut sum = 0;
    let expected: Vec<u32> = delays
        .iter()
        .map(|delay| {
            sum += delay;
            sum
        })
        .collect();
    assert_eq!(times, expected);
    assert_eq!(engine.report(0).position, 500);
    assert_eq!(engine.late(), 0);
}

/// A drive rests or holds, as chosen: the current is off an interval after the last step, or on
/// until it is stopped.
#[test]
fn a_drive_rests_or_holds() {
    let order = SetSpeed { limit: 3, ..SetSpeed::fixed(ON, 32_000) };
    let bridges = sequence::BRIDGE_FULL;
    for (sequence, rests) in [
        (bridges, false),
        (bridges.resting(), true),
        (bridges.resting().holding(), false),
        (sequence::L6219_HALF, true),
        (sequence::L6219_HALF.holding(), false),
    ] {
        let (mut driver, mut here) = driver();
        driver.set_speed(&mut here, &order, 0);
        let mut stepper = Stepper::new(Coils::new(Pins::default(), sequence, 0xFF));
        stepper.begin(here.pace, true);
        let mut intervals = Vec::new();
        while let Some(interval) = stepper.event() {
            intervals.push(interval);
        }
        assert_eq!(intervals.len(), if rests { 3 } else { 2 });
        assert!(intervals.iter().all(|interval| *interval == 32_000));
        let now = if rests { sequence.off() } else { sequence.levels(3) };
        assert_eq!(stepper.coils().port().0, now);
        assert_eq!(stepper.phase(), 3);
        stepper.stop();
        assert_eq!(stepper.coils().port().0, sequence.off());
    }
}

/// A second, naive implementation of the article's rules, with time in whole clocks and u128.
fn oracle(order: &SetSpeed, latched: bool, steps: usize) -> Vec<u128> {
    let has = |bit| order.control.has(bit);
    let fit = |top: u128| {
        let (mut top, mut prescaler) = (top, 1);
        for (shift, next) in [(3, 8), (3, 64), (2, 256), (2, 1024)] {
            if top > 0xFFFF {
                (top, prescaler) = (top >> shift, next);
            }
        }
        (top, prescaler)
    };
    let (mut top, mut modification) = (u128::from(order.top), u128::from(order.modification));
    let (mut counts, mut last) = (order.mod_counts, 0u128);
    let (mut top16, mut prescaler) = fit(top);
    let mut override_next = None;
    let (mut now, mut times) = (0u128, Vec::new());
    while times.len() < steps {
        let (t, p) = override_next.take().unwrap_or((top16, prescaler));
        now += t * p;
        times.push(now);
        if counts > 0 && now - last >= u128::from(order.update_ms) * 16_000 {
            last += u128::from(order.update_ms) * 16_000;
            let next = if has(Control::FASTER) {
                top.saturating_sub(modification)
            } else {
                top + modification
            };
            if !(640..=0x3FF_FFFF).contains(&next) {
                counts = 0;
                continue;
            }
            let old = top16;
            (top, counts) = (next, counts - 1);
            (top16, prescaler) = fit(top);
            if latched {
                override_next = Some((old, prescaler));
            }
            if has(Control::VARIABLE_PWR) {
                modification =
                    if has(Control::FASTER) { modification / 2 } else { modification * 2 };
            }
        }
    }
    times
}

proptest! {
    #[test]
    fn times_are_the_documents(
        top in 640u32..0x3FF_FFFF,
        shift in 0u32..20,
        modification: u32,
        update_ms in 1u16..3_000,
        mod_counts in 1u16..40,
        bits in 0u8..4,
        latched: bool,
    ) {
        let mut control = VARIABLE | Control::IRQ_TIMING;
        if bits & 1 != 0 { control = control | Control::FASTER; }
        if bits & 2 != 0 { control = control | Control::VARIABLE_PWR; }
        let (top, modification) = ((top >> shift).max(640), modification >> (shift + 6).min(31));
        prop_assume!(modification > 0);
        let order = SetSpeed { control, top, limit: 300, modification, update_ms, mod_counts };
        let model = if latched { Model::Latched } else { Model::Ideal };
        let mut now = 0u128;
        let times: Vec<u128> = Timed::new(UNO, model, &order)
            .unwrap()
            .map(|delay| { now += u128::from(delay); now })
            .collect();
        prop_assert_eq!(times, oracle(&order, latched, 300));
    }

    /// A timer in fast PWM with the numbers that the interrupt gives it: the counter takes the
    /// buffer over at the end of the period, and the prescaler changes at once.
    #[test]
    fn a_buffered_register_plays_the_latched_model(
        top in 640u32..0x3FF_FFFF, shift in 0u32..20, modification: u32,
        update_ms in 1u16..3_000, mod_counts in 1u16..40, bits in 0u8..4,
    ) {
        let mut control = VARIABLE | Control::IRQ_TIMING;
        if bits & 1 != 0 { control = control | Control::FASTER; }
        if bits & 2 != 0 { control = control | Control::VARIABLE_PWR; }
        let (top, modification) = ((top >> shift).max(640), modification >> (shift + 6).min(31));
        let order = SetSpeed { control, top, limit: 300, modification, update_ms, mod_counts };
        let mut here = driver().1;
        let code = Driver::new(UNO, Model::Latched).set_speed(&mut here, &order, 0);
        prop_assert!(!code.is_error());
        let pace = &mut here.pace;
        let mut register = pace.counts().top;
        let mut buffer = register;
        let mut steps = 0;
        loop {
            prop_assert!(register <= 0xFFFF);
            prop_assert_eq!(register << pace.counts().shift, pace.interval());
            register = buffer;
            steps += 1;
            if pace.advance().is_none() {
                break;
            }
            buffer = pace.next_top();
        }
        prop_assert_eq!(steps, 300);
    }

    /// Nothing panics, and every accepted order stays in the timer's range.
    #[test]
    fn any_order_is_answered(
        control: u8, top: u32, limit in 0u32..500, modification: u32, update_ms: u16,
        mod_counts: u16, latched: bool, poll in 0u32..5_000,
    ) {
        let control = Control::from_bits(control | 0x80);
        let order = SetSpeed { control, top, limit, modification, update_ms, mod_counts };
        let model = if latched { Model::Latched } else { Model::Ideal };
        for hardware in [UNO, Hardware::avr8(128_000), Hardware::wide32(200_000_000)] {
            if let Ok(timed) = Timed::polled(hardware, model, &order, poll) {
                for delay in timed.take(600) {
                    prop_assert!(delay >= hardware.min_top() || latched);
                    prop_assert!(delay <= hardware.max_top() || latched);
                }
            }
        }
    }
}
