//! Motors whose planning is interrupted between two pieces, as on a chip.

use stepwright::engine::WIRING;
use stepwright::entry::Entry;
use stepwright::profile::{Fit, Ramp, Unfit};
use stepwright::queue::{Next, Queue};
use stepwright::{
    Accel, Axis, AxisSet, Board, Change, Control, Cost, Jerk, Order, OrderedMotors, PlannedBoard,
    Playing, Rate, Refusal, Report, Speed, Timing, Travel,
};

/// An engine that does nothing.
struct Silent;

type Motors<'q> = OrderedMotors<'q, Silent, 2>;

impl Control for Silent {
    fn playing(&mut self, _: u8) -> Playing {
        Playing::Unknown
    }
    fn start(&mut self, _: u8) {}
    fn kill(&mut self, _: u8) {}
    fn report(&self, _: u8) -> Report {
        Report { position: 0, idle: true, forward: true }
    }
    fn set_position(&mut self, _: u8, _: i64) {}
    fn set_timing(&mut self, _: Timing) {}
    fn late(&self) -> u32 {
        0
    }
    fn clear_late(&mut self) {}
}

const UNO: Board<2> = {
    let Ok(rate) = Rate::from_hz(16_000_000) else { panic!() };
    Board {
        rate,
        timing: Timing { pulse: 32, setup: 16, hold: 16, min_interval: 133 },
        cost: Cost::any_pulse([133; 2]),
        fit: Fit::board(rate),
        horizon: 256_000,
        lead: 4_000,
        runs: u16::MAX,
    }
};

fn order(top: u32, accel: u32) -> Order {
    let ramp = Ramp::Accel(Accel::from_steps(accel).unwrap());
    let top = Speed::from_steps(top).unwrap();
    Order { start: Speed::ZERO, top, up: ramp, down: ramp, jerk: None, travel: Travel::By(3_000) }
}

/// The entries of axis 1, with a disturbance of axis 0 after this many pieces.
fn entries(pieces: Option<u32>, disturb: impl Fn(&mut Motors)) -> Vec<Entry> {
    let mut queues = [const { Queue::<8>::new() }; 2];
    let [x, y] = &mut queues;
    let ((x, mut x_end), (y, mut y_end)) = (x.split(), y.split());
    let mut motors = OrderedMotors::new(Silent, [x, y], UNO);
    match pieces {
        Some(_) => motors
            .start([
                (Axis::at::<0>(), order(4_000, 9_000)),
                (Axis::at::<1>(), order(9_000, 40_000)),
            ])
            .unwrap(),
        None => motors.start([(Axis::at::<1>(), order(9_000, 40_000))]).unwrap(),
    }
    let mut entries = Vec::new();
    for piece in 0.. {
        if pieces == Some(piece) {
            disturb(&mut motors);
        }
        motors.plan();
        while let Next::Entry(_) = x_end.take() {}
        loop {
            match y_end.take() {
                Next::Entry(entry) => entries.push(entry),
                Next::Late => break,
                Next::End => return entries,
            }
        }
    }
    entries
}

/// If an axis is disturbed while a run of it is half planned, the entries of the other axis are
/// those that it would make alone.
#[test]
fn what_happens_to_one_axis_leaves_the_other_as_it_is() {
    let alone = entries(None, |_| {});
    assert!(alone.len() > 30);
    for piece in 0..60 {
        assert_eq!(
            entries(Some(piece), |motors| motors.stop(Axis::X)),
            alone,
            "stopped at {piece}"
        );
        let kill = |motors: &mut Motors| motors.kill_at_switch(Axis::X);
        assert_eq!(entries(Some(piece), kill), alone, "killed at {piece}");
    }
}

/// Static motors of zeros plan like new ones after power-up.
#[test]
fn blank_motors_are_new_ones_once_they_are_powered_up() {
    #[derive(Clone, Copy)]
    enum Made {
        New,
        PoweredUp,
        Filled,
    }
    let entries = |made: Made| {
        let mut queues = [const { Queue::<8>::new() }; 2];
        let [x, y] = &mut queues;
        let ((x, mut x_end), (y, _)) = (x.split(), y.split());
        let feeds = [x, y];
        // SAFETY: it is powered up or filled next.
        let blank = || unsafe { Motors::blank(Silent) };
        let mut motors = match made {
            Made::New => OrderedMotors::new(Silent, feeds, UNO),
            Made::PoweredUp => {
                let (mut motors, mut ends) = (blank(), feeds.into_iter());
                let feed = |_, feed: &mut _| *feed = ends.next().unwrap();
                motors.power_up(feed, |board| *board = PlannedBoard::new(UNO));
                motors
            }
            Made::Filled => {
                let mut motors = blank();
                motors.fill(Silent, feeds, &UNO);
                motors
            }
        };
        assert!(motors.is_forward(Axis::X) && motors.is_forward(Axis::Y));
        assert_eq!(motors.start([(Axis::at::<0>(), order(4_000, 9_000))]), Ok(()));
        let too_fast = motors.start([(Axis::at::<1>(), order(200_000, 50_000_000))]);
        let mut entries = Vec::new();
        while motors.plan() {
            while let Next::Entry(entry) = x_end.take() {
                entries.push(entry);
            }
        }
        (too_fast, entries)
    };
    let new = entries(Made::New);
    assert!(new.1.len() > 10 && matches!(new.0, Err(Refusal::TooFast { .. })));
    assert_eq!(entries(Made::PoweredUp), new);
    assert_eq!(entries(Made::Filled), new);
}

/// Eight axes fill the set of axes: there is none beyond.
#[test]
fn a_change_is_for_axes_that_move() {
    let mut queues = [const { Queue::<8>::new() }; 8];
    let feeds = queues.each_mut().map(|queue| queue.split().0);
    let Board { rate, timing, runs, fit, horizon, lead, .. } = UNO;
    let board = Board { rate, timing, cost: Cost::any_pulse([133; 8]), runs, fit, horizon, lead };
    let mut eight = OrderedMotors::new(Silent, feeds, board);
    eight.start([(Axis::at::<7>(), order(4_000, 9_000))]).unwrap();
    let further = Change::Target(4_000);
    assert_eq!(eight.change(Axis::at::<7>(), further), Ok(()));
    assert_eq!(eight.change(Axis::X | Axis::at::<7>(), further), Err(Refusal::Resting));

    let mut queues = [const { Queue::<8>::new() }; 2];
    let mut two = OrderedMotors::new(Silent, queues.each_mut().map(|queue| queue.split().0), UNO);
    two.start([(Axis::at::<1>(), order(4_000, 9_000))]).unwrap();
    assert_eq!(two.change(Axis::Y, further), Ok(()));
    assert_eq!(two.change(Axis::X, further), Err(Refusal::Resting));
}

/// Two axes that get another target together do what each does when it gets that target alone:
/// ahead, ahead but too near (it passes and turns), and behind.
#[test]
fn axes_that_change_together_change_as_each_alone() {
    let changed = |steps: i32, jerk: Option<Jerk>, together: bool| {
        let mut queues = [const { Queue::<8>::new() }; 2];
        let [x, y] = &mut queues;
        let ((x, mut x_end), (y, mut y_end)) = (x.split(), y.split());
        let mut motors = OrderedMotors::new(Silent, [x, y], UNO);
        motors
            .start([
                (Axis::at::<0>(), Order { jerk, ..order(4_000, 9_000) }),
                (Axis::at::<1>(), Order { jerk, ..order(9_000, 40_000) }),
            ])
            .unwrap();
        for _ in 0..40 {
            motors.plan();
        }
        for axes in if together { vec![0b11] } else { vec![0b01, 0b10] } {
            let axes = AxisSet::from_bits(axes);
            motors.change(axes, Change::Target(steps)).unwrap();
        }
        let mut entries = [vec![], vec![]];
        for _ in 0..3_000 {
            motors.plan();
            for (end, entries) in [&mut x_end, &mut y_end].into_iter().zip(&mut entries) {
                while let Next::Entry(entry) = end.take() {
                    entries.push(entry);
                }
            }
        }
        assert!(entries.iter().all(|entries| entries.len() > 4), "{entries:?}");
        entries
    };
    for jerk in [None, Some(Jerk::from_steps(400_000).unwrap())] {
        for steps in [2_000, 5, -700] {
            assert_eq!(changed(steps, jerk, true), changed(steps, jerk, false), "{steps} {jerk:?}");
        }
    }
}

/// Two axes whose top speed is out of reach, and is more than the board can step together.
#[test]
fn axes_that_change_together_are_judged_by_their_top_speeds() {
    let changed = |jerk, axes, stops, change| {
        let mut queues = [const { Queue::<8>::new() }; 2];
        let feeds = queues.each_mut().map(|queue| queue.split().0);
        let mut motors = OrderedMotors::new(Silent, feeds, UNO);
        let order = Order { jerk, ..order(100_000, 9_000) };
        motors.start([(Axis::at::<0>(), order), (Axis::at::<1>(), order)]).unwrap();
        for _ in 0..40 {
            motors.plan();
        }
        if stops {
            motors.stop(Axis::at::<0>());
            motors.stop(Axis::at::<1>());
        }
        motors.change(AxisSet::from_bits(axes), change)
    };
    let faster = Change::Top(Speed::from_steps(110_000).unwrap());
    for jerk in [None, Some(Jerk::from_steps(400_000).unwrap())] {
        for change in [Change::Target(-700), Change::Target(2_900), faster] {
            assert_eq!(changed(jerk, 0b01, false, change), Ok(()), "{jerk:?} {change:?}");
            let both = changed(jerk, 0b11, false, change);
            assert!(matches!(both, Err(Refusal::TooFast { .. })), "{jerk:?} {change:?}");
        }
        // A stop gets no faster.
        assert_eq!(changed(jerk, 0b11, true, faster), Ok(()), "{jerk:?}");
    }
}

/// The way back from where both have come to rest is counted in 32 bits.
#[test]
fn a_target_of_two_axes_far_behind_is_refused() {
    let changed = |target| {
        let mut queues = [const { Queue::<8>::new() }; 2];
        let feeds = queues.each_mut().map(|queue| queue.split().0);
        let mut motors = OrderedMotors::new(Silent, feeds, UNO);
        let order = Order { travel: Travel::By(i32::MAX), ..order(9_000, 9_000) };
        motors.start([(Axis::at::<0>(), order), (Axis::at::<1>(), order)]).unwrap();
        for _ in 0..40 {
            motors.plan();
        }
        motors.change(AxisSet::from_bits(0b11), Change::Target(target))
    };
    assert_eq!(changed(-1_000_000_000), Ok(()));
    assert_eq!(changed(i32::MIN), Err(Refusal::Unfit(Unfit::TooLong)));
}

/// The waits before the first pulse, in 2⁻¹⁶ ticks, for an order that has to wait for this many
/// ticks.
fn beginning(wait: u32) -> Vec<u64> {
    let mut queues = [const { Queue::<8>::new() }; 2];
    let [x, y] = &mut queues;
    let ((x, mut entries), (y, _)) = (x.split(), y.split());
    let mut motors = OrderedMotors::new(Silent, [x, y], UNO);
    motors.prepare(Axis::X, &order(4_000, 9_000)).unwrap();
    while motors.commit(|| wait).map(Result::unwrap).is_pending() {}
    let mut waits = Vec::new();
    while let Next::Entry(entry) = entries.take() {
        assert!(entry.play().all(|(pins, _)| pins == 0), "nothing turns, and no step is made");
        waits.push(entry.play().map(|(_, wait)| u64::from(wait)).sum());
    }
    waits
}

/// A wait that is longer than the lead is a turn, possibly to the same side: the first step after
/// it is a near one. A shorter wait is part of the first interval. After a wait longer than the
/// board plans ahead, 256,000 ticks, only that step is planned.
#[test]
fn a_long_wait_is_a_turn() {
    // DIR's hold and set-up time are 16 ticks each.
    let (lead, half) = (4_016, 1 << 15);
    let first = |ticks: u64| ticks << 16 | half;
    assert_eq!(beginning(0), [first(lead + 16)]);
    assert_eq!(beginning(4_000), [first(2 * lead)]);
    let turn = |ticks: u64| ticks << 16;
    assert_eq!(beginning(4_001), [turn(4_017), first(lead)]);
    assert_eq!(beginning(255_984), [turn(256_000), first(lead)]);
    assert_eq!(beginning(900_000), [turn(900_016), first(lead)]);
}

/// An endless travel counts its steps up to the range of a number. Beyond that, nothing that needs
/// the count is returned or accepted, however far the travel goes.
#[test]
fn beyond_what_is_counted_a_travel_takes_no_target() {
    let rate = Rate::from_hz(200_000_000).unwrap();
    let Board { timing, runs, lead, .. } = UNO;
    let fit = Fit::EXACT.lasting(10_000_000);
    let cost = Cost::any_pulse([1]);
    let board = Board { rate, timing, cost, runs, fit, horizon: 30_000_000, lead };
    let mut queue = Queue::<8>::new();
    let (feed, mut entries) = queue.split();
    let mut motors = OrderedMotors::new(Silent, [feed], board);
    let top = Speed::from_steps(1_000_000).unwrap();
    let up = Ramp::Accel(Accel::MAX);
    let travel = Travel::Endless(true);
    let endless = Order { start: top, top, up, down: up, jerk: None, travel };
    motors.start([(Axis::X, endless)]).unwrap();
    let (mut steps, mut told) = (0i64, 0);
    while steps < 3 << 31 {
        while motors.plan() {}
        while let Next::Entry(entry) = entries.take() {
            for (pins, events, _) in entry.groups() {
                if pins & WIRING.step != 0 {
                    steps += i64::from(events);
                }
            }
        }
        // The last planned step waits for the entry that follows it.
        let planned = motors.planned(Axis::X);
        assert!(
            planned.is_none_or(|planned| i64::from(planned) == steps + 1),
            "{planned:?} of {steps}"
        );
        told = if planned.is_some() { steps } else { told };
    }
    assert!(told > (1 << 31) - (2 << 24), "counted to {told}");
    let back = motors.change(Axis::X, Change::Target(5));
    assert_eq!(back, Err(Refusal::Unfit(Unfit::TooLong)));
}
