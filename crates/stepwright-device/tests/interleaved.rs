//! Orders whose pieces are mixed with all else that the main loop does: time passes, switches close,
//! inputs become active, between any two pieces of an order and any two bytes of a line.

use crate::common::{Meanwhile, Panel, Rig};
use stepwright::Axis;
use stepwright::queue::Queue;

/// A story of one seed.
struct Story<'q> {
    rig: Rig<'q>,
    random: Meanwhile,
}

impl<'q> Story<'q> {
    fn new(seed: u32, queues: &'q mut [Queue<8>; 2], settings: &str) -> Story<'q> {
        let mut rig = Rig::new(queues, Panel::new());
        rig.say(settings);
        rig.meanwhile = Some(Meanwhile::of(seed));
        Story { rig, random: Meanwhile::of(!seed) }
    }

    /// Sends an order of some axes, while some switches or the emergency stop become active; its
    /// answer, and the axes: bit 0 is axis 1.
    fn order(&mut self, switches: u8, emergency: bool) -> (String, u8) {
        let axes = 1 + self.random.below(3) as u8;
        let line = ["A1", "A2", "A0"][usize::from(axes) - 1];
        let travel = ["g+", "G+3", "G+90000"][self.random.below(3) as usize];
        self.rig.say(&format!("! PO {line} {travel}"));
        let moments = self.random.below(50);
        self.rig.meanwhile.as_mut().unwrap().low = Some((moments, switches, emergency));
        (self.rig.ask("E"), axes)
    }

    /// Lets a few moments pass.
    fn wait(&mut self) {
        for _ in 0..self.random.below(20) {
            self.rig.between();
        }
    }

    /// Ends all motion.
    fn rest(&mut self) {
        match self.random.below(3) {
            0 => self.rig.say("K"),
            _ => self.rig.say("A0 Z"),
        }
        self.rig.play_out();
        self.wait();
    }

    /// The letter of the last stop of each axis, and whether it moves.
    fn states(&mut self) -> Vec<(char, bool)> {
        self.rig.plan();
        let moving: Vec<_> =
            Axis::all().map(|axis| self.rig.device.motors().is_moving(axis)).collect();
        self.rig.told("stop").chars().zip(moving).collect()
    }
}

/// The rig itself compares mark and drivers with the motors at each moment.
#[test]
fn the_mark_and_the_drivers_hold_from_the_first_step_of_every_order() {
    let mut moved = 0;
    for seed in 0..300 {
        let mut queues = [const { Queue::new() }; 2];
        let mut story = Story::new(seed, &mut queues, "$idle-ms=1");
        for _ in 0..5 {
            assert_eq!(story.order(0, false).0, "Y", "seed {seed}");
            story.wait();
            moved += u32::from(story.rig.moving());
            story.rest();
        }
    }
    assert!(moved > 1_000, "{moved}");
}

/// An order whose axis has been stopped while it was started says so, and no other axis does.
#[test]
fn a_switch_that_closes_at_any_moment_is_told() {
    let mut stopped = 0;
    for seed in 0..600 {
        let mut queues = [const { Queue::new() }; 2];
        let mut story = Story::new(seed, &mut queues, "$switches=3 $switch-forward=3");
        let low = 1 + story.random.below(3) as u8;
        let (answer, axes) = story.order(low, false);
        story.wait();
        story.rig.meanwhile.as_mut().unwrap().low = None;
        let states = story.states();
        if answer != "Y" {
            assert_eq!((answer.as_str(), story.rig.told("last").as_str()), ("E", "fault"));
            assert!(states.iter().all(|state| *state == ('-', false)), "seed {seed}: {states:?}");
            continue;
        }
        for (axis, (letter, moves)) in states.into_iter().enumerate() {
            let stops = axes >> axis & 1 != 0 && !moves;
            assert_eq!(letter, if stops { 'S' } else { '-' }, "seed {seed}, axis {axis}");
            stopped += u32::from(stops);
        }
    }
    assert!(stopped > 100, "{stopped}");
}

/// As above: an emergency stop refuses an order that is being started, and stops one that has been.
#[test]
fn an_emergency_stop_at_any_moment_is_told() {
    let (mut stopped, mut refused) = (0, 0);
    for seed in 0..600 {
        let mut queues = [const { Queue::new() }; 2];
        let mut story = Story::new(seed, &mut queues, "$estop=1");
        let (answer, axes) = story.order(0, true);
        story.rig.panel.emergency = false;
        let states = story.states();
        assert!(states.iter().all(|state| !state.1), "seed {seed}: {states:?}");
        if answer == "Y" {
            for (axis, (letter, _)) in states.into_iter().enumerate() {
                assert_eq!(letter, if axes >> axis & 1 != 0 { 'E' } else { '-' }, "seed {seed}");
            }
            stopped += 1;
        } else {
            assert_eq!(story.rig.told("last"), "fault", "seed {seed}");
            assert_eq!(story.rig.told("uncertain"), "0", "seed {seed}: no motor has stepped");
            refused += 1;
        }
    }
    assert!(stopped > 100 && refused > 100, "{stopped} {refused}");
}
