//! Random sequences for three axes that are changed between any two pieces of planning, as on a
//! chip: no step is lost, made twice, or made by another axis.
//!
//! Checked by the entries that are played. `STEPWRIGHT_CASES` sets the number of sequences.

use std::cell::RefCell;

use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use stepwright::engine::WIRING;
use stepwright::profile::{Fit, Ramp};
use stepwright::queue::{Consumer, Next, Queue, Source};
use stepwright::{
    Accel, Axis, Board, Change, Control, Cost, Order, OrderedMotors, Playing, Rate, Refusal,
    Report, Speed, Timing, Travel,
};

const STORIES: u32 = 2_000;
const AXES: usize = 3;

/// The player of an axis: takes entries, and counts their steps.
struct Player<'q> {
    entries: Consumer<'q, 8>,
    /// Whether a travel is in progress.
    moving: bool,
    forward: bool,
    /// Steps since the travel began.
    made: i32,
}

impl Player<'_> {
    fn take(&mut self) {
        if !self.moving {
            return;
        }
        match self.entries.take() {
            Next::Entry(entry) => {
                for (pins, events, _) in entry.groups() {
                    self.forward ^= pins & WIRING.turn != 0;
                    if pins & WIRING.step != 0 {
                        let steps = events as i32;
                        self.made += if self.forward { steps } else { -steps };
                    }
                }
            }
            Next::Late => {}
            Next::End => self.moving = false,
        }
    }
}

struct Players<'a, 'q>(&'a RefCell<[Player<'q>; AXES]>);

impl Control for Players<'_, '_> {
    fn playing(&mut self, _: u8) -> Playing {
        Playing::Unknown
    }
    fn start(&mut self, axes: u8) {
        for (n, player) in self.0.borrow_mut().iter_mut().enumerate() {
            player.moving |= axes >> n & 1 != 0;
        }
    }
    fn kill(&mut self, axes: u8) {
        for (n, player) in self.0.borrow_mut().iter_mut().enumerate() {
            if axes >> n & 1 != 0 {
                player.entries.clear(player.forward);
                player.moving = false;
            }
        }
    }
    fn report(&self, axis: u8) -> Report {
        let player = &self.0.borrow()[usize::from(axis)];
        Report { position: player.made.into(), idle: !player.moving, forward: player.forward }
    }
    fn set_position(&mut self, _: u8, _: i64) {}
    fn set_timing(&mut self, _: Timing) {}
    fn late(&self) -> u32 {
        0
    }
    fn clear_late(&mut self) {}
}

const BOARD: Board<AXES> = {
    let Ok(rate) = Rate::from_hz(16_000_000) else { panic!() };
    Board {
        rate,
        timing: Timing { pulse: 32, setup: 16, hold: 16, min_interval: 133 },
        cost: Cost::any_pulse([133; AXES]),
        fit: Fit::board(rate),
        horizon: 256_000,
        lead: 4_000,
        runs: u16::MAX,
    }
};

/// Where an axis must end.
#[derive(Clone, Copy, Debug)]
enum Ends {
    /// This many steps from where its travel began.
    At(i32),
    /// Where it is planned to: it brakes.
    Planned,
    /// Anywhere: it was killed.
    Anywhere,
}

/// An action before some pieces of planning, after each of which some entries are played.
#[derive(Clone, Debug)]
enum Deed {
    Start(i32),
    Target(i32),
    Top(u32),
    Stop,
    Kill,
}

fn deed() -> impl Strategy<Value = (u8, Deed, u8, u8)> {
    let deed = prop_oneof![
        3 => (-3_000i32..3_000).prop_map(Deed::Start),
        2 => (-3_000i32..3_000).prop_map(Deed::Target),
        1 => (1_000u32..15_000).prop_map(Deed::Top),
        1 => Just(Deed::Stop),
        1 => Just(Deed::Kill),
    ];
    (0..AXES as u8, deed, 0u8..24, 0u8..4)
}

fn order(steps: i32) -> Order {
    let ramp = Ramp::Accel(Accel::from_steps(40_000).unwrap());
    let top = Speed::from_steps(9_000).unwrap();
    let travel = Travel::By(steps);
    Order { start: Speed::ZERO, top, up: ramp, down: ramp, jerk: None, travel }
}

fn story(deeds: &[(u8, Deed, u8, u8)]) -> Result<(), TestCaseError> {
    let mut queues = [const { Queue::<8>::new() }; AXES];
    let ends = queues.each_mut().map(Queue::split);
    let (mut feeds, mut players) = (Vec::new(), Vec::new());
    for (feed, end) in ends {
        feeds.push(feed);
        players.push(Player { entries: end, moving: false, forward: true, made: 0 });
    }
    let feeds: [_; AXES] = feeds.try_into().ok().unwrap();
    let players = RefCell::new(players.try_into().ok().unwrap());
    let mut motors = OrderedMotors::new(Players(&players), feeds, BOARD);
    let mut ends = [Ends::At(0); AXES];
    for (axis, deed, pieces, played) in deeds {
        let index = usize::from(*axis);
        let axis = Axis::new(index).unwrap();
        match deed {
            Deed::Start(steps) => match motors.start([(axis, order(*steps))]) {
                Ok(()) => {
                    players.borrow_mut()[index].made = 0;
                    ends[index] = Ends::At(*steps);
                }
                Err(refusal) => prop_assert_eq!(refusal, Refusal::Busy),
            },
            Deed::Target(steps) => {
                if motors.change(axis, Change::Target(*steps)).is_ok() {
                    ends[index] = Ends::At(*steps);
                }
            }
            Deed::Top(top) => {
                let top = Change::Top(Speed::from_steps(*top).unwrap());
                let _ = motors.change(axis, top);
            }
            Deed::Stop if motors.is_moving(axis) => {
                motors.stop(axis);
                ends[index] = Ends::Planned;
            }
            Deed::Stop => {}
            Deed::Kill => {
                motors.kill_at_switch(axis);
                prop_assert!(!motors.is_moving(axis));
                ends[index] = Ends::Anywhere;
            }
        }
        for _ in 0..*pieces {
            motors.plan();
            for _ in 0..*played {
                players.borrow_mut().iter_mut().for_each(Player::take);
            }
        }
    }
    // All of it to its end.
    let mut calls = 0;
    while motors.any_moving() {
        motors.plan();
        players.borrow_mut().iter_mut().for_each(Player::take);
        calls += 1;
        prop_assert!(calls < 1_000_000, "it never ends");
    }
    for (axis, ends) in Axis::all().zip(ends) {
        let made = players.borrow()[axis.index()].made;
        match ends {
            Ends::At(target) => prop_assert_eq!(made, target, "{:?}", axis),
            Ends::Planned => prop_assert_eq!(Some(made), motors.planned(axis), "{:?}", axis),
            Ends::Anywhere => {}
        }
    }
    Ok(())
}

#[test]
fn no_step_is_lost_between_two_pieces() {
    let cases = std::env::var("STEPWRIGHT_CASES").ok().and_then(|cases| cases.parse().ok());
    let config = ProptestConfig {
        cases: cases.unwrap_or(STORIES),
        failure_persistence: None,
        ..Default::default()
    };
    let deeds = prop::collection::vec(deed(), 1..40);
    let told = TestRunner::new(config).run(&deeds, |deeds| story(&deeds));
    if let Err(failure) = told {
        panic!("{failure}");
    }
}
