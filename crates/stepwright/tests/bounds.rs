//! Orders, changes and rests at their limits: each is tried on both sides.

use stepwright::engine::Playing;
use stepwright::profile::{Fit, Ramp, Unfit};
use stepwright::queue::{Consumer, Next, Producer, Queue, Source};
use stepwright::units::Jerk;
use stepwright::{
    Accel, Axis, AxisSet, Board, Change, Control, Cost, Order, OrderedMotors, Rate, Refusal,
    Report, Speed, Timing, Travel,
};

/// The pins of an entry.
const STEP: u8 = 1;
const TURN: u8 = 2;

/// An engine that plays nothing and returns preset values.
#[derive(Default)]
struct Player {
    moving: u8,
}

type Motors<'q, const N: usize> = OrderedMotors<'q, Player, N>;

/// Motors at rest, with these feeds.
fn motors<const N: usize>(feeds: [Producer<'_, 8>; N], board: Board<N>) -> Motors<'_, N> {
    OrderedMotors::new(Player::default(), feeds, board)
}

impl Control for Player {
    fn playing(&mut self, _: u8) -> Playing {
        Playing::Unknown
    }
    fn start(&mut self, axes: u8) {
        self.moving |= axes;
    }
    fn kill(&mut self, axes: u8) {
        self.moving &= !axes;
    }
    fn report(&self, axis: u8) -> Report {
        Report { position: 0, idle: self.moving >> axis & 1 == 0, forward: true }
    }
    fn set_position(&mut self, _: u8, _: i64) {}
    fn set_timing(&mut self, _: Timing) {}
    fn late(&self) -> u32 {
        0
    }
    fn clear_late(&mut self) {}
}

/// A board of 16 MHz on which a step costs this many ticks, for any number of moving axes.
fn board<const N: usize>(cost: u32) -> Board<N> {
    let rate = Rate::from_hz(16_000_000).unwrap();
    Board {
        rate,
        timing: Timing { pulse: 32, setup: 16, hold: 16, min_interval: cost },
        cost: Cost::any_pulse([cost; N]),
        fit: Fit::board(rate),
        horizon: 256_000,
        lead: 4_000,
        runs: u16::MAX,
    }
}

fn speed(millisteps: u32) -> Speed {
    Speed::from_millisteps(millisteps).unwrap()
}

fn ramp(accel: u32) -> Ramp {
    Ramp::Accel(Accel::from_steps(accel).unwrap())
}

/// From `start` to `top` steps/s, at `accel` steps/s² in both ramps.
fn order(start: u32, top: u32, accel: u32, travel: Travel) -> Order {
    let (start, top) = (speed(start * 1000), speed(top * 1000));
    Order { start, top, up: ramp(accel), down: ramp(accel), jerk: None, travel }
}

const FORWARD: Travel = Travel::Endless(true);

/// Plans until the queues are full.
fn plan<const N: usize>(motors: &mut Motors<N>) {
    while motors.plan() {}
}

/// The pins of the queued events and the ticks after them.
fn events(entries: &mut Consumer<8>) -> Vec<(u8, u64)> {
    let mut events = Vec::new();
    while let Next::Entry(entry) = entries.take() {
        events.extend(entry.play().map(|(pins, wait)| (pins, u64::from(wait) >> 16)));
    }
    events
}

/// Ticks until an event with these pins.
fn before(events: &[(u8, u64)], pins: u8) -> u64 {
    events.iter().take_while(|event| event.0 & pins == 0).map(|event| event.1).sum()
}

// ----- speeds beside other axes

/// Two axes share 8,000 steps/s. A change is checked against all moving axes, with their present
/// speeds.
#[test]
fn a_change_is_judged_beside_what_moves() {
    let too_fast = |steps: u32| Err(Refusal::TooFast { max: speed(steps * 1000) });
    let top = |steps: u32| Change::Top(speed(steps * 1000));
    let mut queues = [const { Queue::<8>::new() }; 2];
    let mut motors = motors(queues.each_mut().map(|queue| queue.split().0), board::<2>(2000));
    motors.start([(Axis::X, order(100, 1000, 9000, FORWARD))]).unwrap();
    plan(&mut motors);
    assert_eq!(motors.change(Axis::X, top(8001)), too_fast(8000));
    assert_eq!(motors.change(Axis::X, top(8000)), Ok(()));
    assert_eq!(motors.start([(Axis::Y, order(100, 4000, 9000, FORWARD))]), too_fast(0));
    assert_eq!(motors.change(Axis::X, top(1000)), Ok(()));
    motors.start([(Axis::Y, order(100, 4000, 9000, FORWARD))]).unwrap();
    plan(&mut motors);
    assert_eq!(motors.change(Axis::X, top(4001)), too_fast(4000));
    assert_eq!(motors.change(Axis::X, top(4000)), Ok(()));
    // A refused change has changed nothing; an accepted one counts from now on.
    assert_eq!(motors.change(Axis::Y, top(4001)), too_fast(4000));
    // In a change of both, each is checked beside the other.
    assert!(matches!(motors.change(AxisSet::ALL, top(4001)), Err(Refusal::TooFast { .. })));
    assert_eq!(motors.change(AxisSet::ALL, top(4000)), Ok(()));
    // An axis at rest takes no part.
    motors.kill_at_switch(Axis::Y);
    assert_eq!(motors.change(Axis::X, top(8001)), too_fast(8000));
    assert_eq!(motors.change(Axis::X, top(8000)), Ok(()));
}

/// Axes with hardware of their own do not share: each is as fast beside the others as alone.
#[test]
fn independent_axes_are_judged_alone() {
    let mut queues = [const { Queue::<8>::new() }; 3];
    let feeds = queues.each_mut().map(|queue| queue.split().0);
    // 1,600 ticks of 16 MHz: 10,000 steps/s.
    let board = Board { cost: Cost::independent(1_600), ..board::<3>(133) };
    let mut motors = motors(feeds, board);
    let fast = |steps| order(100, steps, 9000, FORWARD);
    motors.start([(Axis::X, fast(10_000)), (Axis::Y, fast(10_000))]).unwrap();
    plan(&mut motors);
    let too_fast = motors.start([(Axis::Z, fast(10_001))]);
    assert_eq!(too_fast, Err(Refusal::TooFast { max: speed(10_000_000) }));
    assert_eq!(motors.start([(Axis::Z, fast(10_000))]), Ok(()));
}

/// A travel too short for its top speed is checked with the speed that it reaches: at 1000 steps/s²
/// half of the distance up and half down. 0.001 steps/s, rounded up, decide.
#[test]
fn a_peak_is_rounded_up() {
    for steps in [4, 7, 30, 47, 98, 301] {
        // √(a · (n − 1)), from rest at both ends: the travel begins with the first pulse.
        let peak = (1000.0 * f64::from(steps - 1)).sqrt() * 1000.0;
        assert!(peak.fract() > 0.01, "{steps}: {peak}");
        let short = order(0, 5000, 1000, Travel::By(steps));
        for (most, fits) in [(peak.floor(), false), (peak.ceil(), true)] {
            // Another axis takes the rest of 8,000 steps/s.
            let rest = speed(8_000_000 - most as u32);
            let other = Order { start: rest, top: rest, ..order(0, 1, 1000, FORWARD) };
            let mut queues = [const { Queue::<8>::new() }; 2];
            let feeds = queues.each_mut().map(|queue| queue.split().0);
            let mut motors = motors(feeds, board::<2>(2000));
            motors.start([(Axis::Y, other)]).unwrap();
            let started = motors.start([(Axis::X, short)]);
            let fast = matches!(started, Err(Refusal::TooFast { .. }));
            assert_eq!((started.is_ok(), fast), (fits, !fits), "{steps}: {peak}, {started:?}");
        }
    }
}

// ----- ramps beside other axes

/// 2,000 runs a second. A ramp of 40,000 steps/s² needs 912 of them, or 857 to 1,058 by the board's
/// formula; an axis at speed takes the time of its steps, a run for each 65.536 of them. The order
/// of the two makes no difference.
#[test]
fn a_ramp_has_what_the_steps_of_others_leave() {
    let at = |steps: u32| Order { start: speed(steps * 1000), ..order(0, steps, 1, FORWARD) };
    let ramps = |top: u32| order(0, top, 40_000, FORWARD);
    // 80,000,000 / 65,536 = 1,220.7
    let too_steep = Err(Refusal::TooSteep { runs: 2_000 - 1_220 });
    let start = |first: Order, second: Order, change: Option<u32>| {
        let mut queues = [const { Queue::<8>::new() }; 2];
        let feeds = queues.each_mut().map(|queue| queue.split().0);
        let mut motors = motors(feeds, Board { runs: 2_000, ..board::<2>(10) });
        motors.start([(Axis::X, first)]).unwrap();
        plan(&mut motors);
        motors.start([(Axis::Y, second)])?;
        plan(&mut motors);
        change.map_or(Ok(()), |top| motors.change(Axis::Y, Change::Top(speed(top * 1000))))
    };
    assert_eq!(start(at(30_000), ramps(9_000), None), Ok(()));
    assert_eq!(start(at(80_000), ramps(9_000), None), too_steep);
    assert_eq!(start(ramps(9_000), at(30_000), None), Ok(()));
    let others = start(ramps(9_000), at(80_000), None);
    assert!(matches!(others, Err(Refusal::TooSteep { runs: 942..=1_143 })), "{others:?}");
    // Its own steps do not count beside its own ramp.
    assert_eq!(start(ramps(60_000), ramps(9_000), None), Ok(()));
    assert_eq!(start(at(30_000), ramps(9_000), Some(60_000)), Ok(()));
    let change = start(at(30_000), ramps(9_000), Some(110_000));
    assert!(matches!(change, Err(Refusal::TooSteep { .. })), "{change:?}");
    // For one axis an eighth is kept back for a change: (612 · a)^0.4 is 1,750 at 209,400.
    let one = |steps: u32, accel: u32| {
        let mut queue = Queue::<8>::new();
        let mut motors = motors([queue.split().0], Board { runs: 2_000, ..board::<1>(10) });
        motors.start([(Axis::X, order(0, steps, accel, FORWARD))])
    };
    assert_eq!(one(200_000, 140_000), Ok(()));
    assert_eq!(one(200_000, 250_000), Err(Refusal::TooSteep { runs: 1_750 }));
    // For three axes a sixteenth is kept back for a stop of all. 20,000,000 / 65,536 = 305.2
    let third = |accel: u32| {
        let mut queues = [const { Queue::<8>::new() }; 3];
        let feeds = queues.each_mut().map(|queue| queue.split().0);
        let mut motors = motors(feeds, Board { runs: 2_000, ..board::<3>(10) });
        motors.start([(Axis::X, at(20_000)), (Axis::Y, at(20_000))]).unwrap();
        plan(&mut motors);
        motors.start([(Axis::Z, order(0, 20_000, accel, FORWARD))])
    };
    assert_eq!(third(60_000), Ok(()));
    // (612 · a)^0.4 is 1,300, of which three axes leave 1,265.
    assert_eq!(third(100_000), Err(Refusal::TooSteep { runs: 2_000 - 125 - 610 }));
    // Speeds alone do not count for planning.
    assert_eq!(start(at(200_000), at(200_000), None), Ok(()));
}

// ----- distances

/// All that is planned of the present leg; the axis is at rest then.
fn play_all(motors: &mut Motors<1>, entries: &mut Consumer<8>) -> Vec<(u8, u64)> {
    let mut all = Vec::new();
    for _ in 0..100 {
        plan(motors);
        all.extend(events(entries));
    }
    motors.engine().moving = 0;
    plan(motors);
    all
}

/// −2³¹ has no opposite, and goes backward whatever the direction.
#[test]
fn the_longest_travel_leads_backward() {
    for first in [10, -10] {
        let mut queue = Queue::<8>::new();
        let (feed, mut entries) = queue.split();
        let mut motors = motors([feed], board::<1>(133));
        motors.start([(Axis::X, order(50, 1000, 9000, Travel::By(first)))]).unwrap();
        play_all(&mut motors, &mut entries);
        let faces_forward = first > 0;
        motors.start([(Axis::X, order(50, 1000, 9000, Travel::By(i32::MIN)))]).unwrap();
        plan(&mut motors);
        let turns = events(&mut entries).iter().any(|(pins, _)| pins & TURN != 0);
        assert_eq!(turns, faces_forward, "{first}");
        assert!(motors.planned(Axis::X).is_some_and(|at| at < 0), "{first}");
    }
}

/// A target 2³¹ steps or more from the planned part is refused; a nearer one is accepted, even on
/// the other side of where the travel began.
#[test]
fn a_target_that_32_bits_do_not_reach_is_refused() {
    let travel = |steps| {
        let mut queue = Queue::<8>::new();
        let (feed, mut entries) = queue.split();
        // At 10⁶ steps/s a run has many steps.
        let mut motors = motors([feed], board::<1>(10));
        let fast = order(1_000_000, 1_000_000, 1_000_000, Travel::By(steps));
        motors.start([(Axis::X, fast)]).unwrap();
        while motors.planned(Axis::X).is_some_and(|at| at.unsigned_abs() < 300_000_000) {
            plan(&mut motors);
            events(&mut entries);
        }
        let planned = i64::from(motors.planned(Axis::X).unwrap());
        for (to, far) in [(i32::MIN, true), (-1_900_000_000, true), (-1_840_000_000, false)] {
            let to = if steps < 0 { to.saturating_neg() } else { to };
            assert_eq!((i64::from(to) - planned).unsigned_abs() >= 1 << 31, far, "{planned}");
            let refused = motors.change(Axis::X, Change::Target(to));
            let want = if far { Err(Refusal::Unfit(Unfit::TooLong)) } else { Ok(()) };
            assert_eq!(refused, want, "{to}");
        }
    };
    travel(i32::MAX);
    travel(-i32::MAX);
}

// ----- rests

/// A leg that turns waits for DIR's hold time or its rest, an interval of the start speed,
/// whichever is longer.
#[test]
fn a_turn_waits_for_hold_and_rest() {
    for (hold, start, want) in [(200_000, 500, 200_000), (20_000, 500, 32_000)] {
        let mut queue = Queue::<8>::new();
        let (feed, mut entries) = queue.split();
        let mut board = board::<1>(133);
        board.timing.hold = hold;
        let mut motors = motors([feed], board);
        motors.start([(Axis::X, order(start, 1000, 9000, Travel::By(5)))]).unwrap();
        plan(&mut motors);
        assert!(!events(&mut entries).is_empty());
        motors.change(Axis::X, Change::Target(-5)).unwrap();
        // All of the first leg.
        while motors.planned(Axis::X) != Some(5) || entries.take() != Next::End {
            plan(&mut motors);
        }
        motors.engine().moving = 0;
        plan(&mut motors);
        let events = events(&mut entries);
        assert_eq!(before(&events, TURN), want, "{hold}: {events:?}");
        assert_eq!(before(&events, STEP), want + 4_016);
    }
}

/// After a kill the next travel rests as after an end: an interval of the start speed.
#[test]
fn a_kill_is_followed_by_a_rest() {
    for kill in [false, true] {
        let mut queue = Queue::<8>::new();
        let (feed, mut entries) = queue.split();
        let mut motors = motors([feed], board::<1>(133));
        motors.start([(Axis::X, order(50, 1000, 9000, Travel::By(40)))]).unwrap();
        if kill {
            plan(&mut motors);
            motors.kill_at_switch(Axis::X);
            entries.clear(true);
        } else {
            while entries.take() != Next::End {
                plan(&mut motors);
            }
            motors.engine().moving = 0;
        }
        assert!(!motors.is_moving(Axis::X));
        motors.start([(Axis::X, order(50, 1000, 9000, Travel::By(40)))]).unwrap();
        plan(&mut motors);
        let wait = before(&events(&mut entries), STEP);
        assert_eq!(wait, 320_000 + 4_016, "killed: {kill}");
        // Time that has passed at rest is not waited for again.
        motors.kill_at_switch(Axis::X);
        entries.clear(true);
        (0..11).for_each(|_| motors.count_rest(16_000));
        motors.start([(Axis::X, order(50, 1000, 9000, Travel::By(40)))]).unwrap();
        plan(&mut motors);
        // The time before the axis was seen at rest does not count.
        assert_eq!(before(&events(&mut entries), STEP), 160_000 + 4_016);
    }
}

// ----- targets that can't be counted to

/// At 1,000,000 steps/s: the braking distance is so long that a target, or the distance to it,
/// exceeds 32 bits.
#[test]
fn a_target_beyond_what_is_counted_is_refused() {
    let too_long = Err(Refusal::Unfit(Unfit::TooLong));
    let change = |travel: i32, changes: &[Change]| {
        let mut queue = Queue::<8>::new();
        let (feed, mut entries) = queue.split();
        let mut motors = motors([feed], board::<1>(1));
        let quick = order(1, 1_000_000, 90_000_000, Travel::By(travel));
        motors.start([(Axis::X, quick)]).unwrap();
        for _ in 0..50 {
            plan(&mut motors);
            events(&mut entries);
        }
        assert!(motors.planned(Axis::X).is_some_and(|at| (100_000..1_000_000).contains(&at)));
        changes.iter().map(|change| motors.change(Axis::X, *change)).last().unwrap()
    };
    let decel = |accel: u32| Change::Decel(Accel::from_steps(accel).unwrap());
    // 5·10⁸ steps to rest; the target is 2·10⁹ steps back from there: too many between.
    assert_eq!(change(i32::MAX, &[decel(1000), Change::Target(-1_000_000_000)]), Ok(()));
    assert_eq!(change(i32::MAX, &[decel(1000), Change::Target(-2_000_000_000)]), too_long);
    assert_eq!(change(i32::MAX, &[decel(1000), Change::Target(5)]), Ok(()));
    // 2.5·10⁹ steps to rest.
    assert_eq!(change(i32::MAX, &[decel(200)]), Err(Refusal::Unfit(Unfit::TooGentle)));
    assert_eq!(change(1_000_000, &[decel(1000)]), Ok(()));
}

/// A fall of a curve that has begun ends before a target further on, and the axis travels there
/// afterwards.
#[test]
fn a_falling_curve_takes_a_target_further_on() {
    let mut queue = Queue::<8>::new();
    let (feed, mut entries) = queue.split();
    let mut motors = motors([feed], board::<1>(133));
    let jerk = Some(Jerk::from_steps(40_000).unwrap());
    let curve = Order { jerk, ..order(50, 1000, 2000, Travel::By(2000)) };
    motors.start([(Axis::X, curve)]).unwrap();
    let mut further = 2000;
    while motors.is_moving(Axis::X) && further < 20_000 {
        plan(&mut motors);
        if motors.planned(Axis::X) > Some(1800) {
            further += 10;
            assert_eq!(motors.change(Axis::X, Change::Target(further)), Ok(()), "{further}");
        }
        match entries.take() {
            Next::End => motors.engine().moving = 0,
            Next::Entry(_) | Next::Late => {}
        }
    }
}

// ----- intervals and ramps that a timer can't hold

fn started(rate: u32, order: Order) -> Result<(), Refusal> {
    let rate = Rate::from_hz(rate).unwrap();
    let (timing, lead) = (Timing { pulse: 2, setup: 2, hold: 2, min_interval: 4 }, 10);
    let cost = Cost::any_pulse([4]);
    let board =
        Board { rate, timing, cost, fit: Fit::board(rate), horizon: 1000, lead, runs: u16::MAX };
    let mut queue = Queue::<8>::new();
    motors([queue.split().0], board).start([(Axis::X, order)])
}

/// No interval takes 2³² ticks: that of the start speed, or from rest the first, the last and one
/// of the top speed together.
#[test]
fn an_interval_fits_32_bits() {
    let too_slow = Err(Refusal::Unfit(Unfit::TooSlow));
    let slow = |start: u32, top: u32| Order {
        start: speed(start),
        top: speed(top),
        ..order(0, 1, 1000, Travel::By(5))
    };
    // 2³² ticks of 200 MHz are 21.47 s: 0.04657 steps/s.
    assert_eq!(started(200_000_000, slow(46, 1000)), too_slow);
    assert_eq!(started(200_000_000, slow(47, 1000)), Ok(()));
    assert_eq!(started(200_000_000, slow(46, 46)), too_slow);
    assert_eq!(started(200_000_000, slow(47, 47)), Ok(()));
    // With a jerk limit from rest, the first step alone may be too long.
    let bent = |jerk: u64| Order {
        jerk: Some(Jerk::from_millisteps(jerk).unwrap()),
        ..order(0, 10, 1000, Travel::By(50))
    };
    assert_eq!(started(200_000_000, bent(100)), too_slow);
    assert_eq!(started(200_000_000, bent(100_000)), Ok(()));
    // From rest: 2 · √(2/a) + 1/v, each of which alone is less.
    let rests = |top: u32, accel: u32| {
        let slope = Ramp::Accel(Accel::from_millisteps(accel.into()).unwrap());
        Order { up: slope, down: slope, ..slow(0, top) }
    };
    for (top, accel) in [(100, 31), (60, 150), (200, 20), (1000, 19)] {
        let takes = 2.0 * (2000.0 / f64::from(accel)).sqrt() + 1000.0 / f64::from(top);
        let fits = takes * 2e8 < 2f64.powi(32);
        assert_eq!(started(200_000_000, rests(top, accel)).is_ok(), fits, "{top} {accel} {takes}");
    }
}

/// Ramps of an endless travel take less than 2³¹ steps, those of a curve less than 2²¹ and its
/// bends; otherwise a target bounds them.
#[test]
fn a_ramp_ends() {
    let too_gentle = Err(Refusal::Unfit(Unfit::TooGentle));
    let gentle = |accel: f64, travel| {
        let slope = Ramp::Accel(Accel::from_millisteps((accel * 1000.0) as u64).unwrap());
        Order { up: slope, down: slope, ..order(10, 100_000, 1, travel) }
    };
    let by = |steps: f64| 1e10 / 2.0 / steps;
    assert_eq!(started(16_000_000, gentle(by(2f64.powi(31)) * 0.99, FORWARD)), too_gentle);
    assert_eq!(started(16_000_000, gentle(by(2f64.powi(31)) * 1.01, FORWARD)), Ok(()));
    assert_eq!(started(16_000_000, gentle(0.5, Travel::By(i32::MAX))), Ok(()));
    let curve = |accel: f64| Order {
        jerk: Some(Jerk::from_steps(100_000).unwrap()),
        ..gentle(accel, FORWARD)
    };
    assert_eq!(started(16_000_000, curve(by(2f64.powi(21)) * 0.98)), too_gentle);
    assert_eq!(started(16_000_000, curve(by(2f64.powi(21)) * 1.02)), Ok(()));
    // Bends only, √(v³/J) steps: 2²² at 57 steps/s³.
    let bends = |jerk: u64| Order { jerk: Some(Jerk::from_steps(jerk).unwrap()), ..curve(9_000.0) };
    assert_eq!(started(16_000_000, bends(55)), too_gentle);
    assert_eq!(started(16_000_000, bends(59)), Ok(()));
}
