//! Resets of the programs `laws`, `cycles` and `stream`, at every moment: the position is known afterwards
//! if it is still true, and otherwise unknown, as with the controller (`reset.rs`).

use crate::common;
use crate::common::cycles::{prepare, wire};
use crate::feed::{Job, Line, Target, run, s_curve, terms};
use crate::stream::Awake;
use stepwright_austin::Recipe;
use stepwright_austin::line::Line as LawLine;
use stepwright_cycle::line::CycleLine;
use stepwright_cycle::{Leg, Motor};
use stepwright_rig::{Cause, Chip};
use stepwright_sim::Edge;

const PROGRAMS: [&str; 3] = ["laws", "cycles", "stream"];

/// A millisecond in cycles.
const MILLIS: u64 = 16_000;

/// A board that hears nothing and stands still from a cycle on.
struct Until(Awake, u64);

impl Target for Until {
    fn run_until(&mut self, cycle: u64) {
        self.0.run_until(cycle.min(self.1));
    }
    fn receive(&mut self, byte: u8) {
        self.0.receive(byte);
    }
    fn said(&mut self) -> Vec<u8> {
        self.0.said()
    }
    fn edges(&mut self) -> &[Edge] {
        self.0.edges()
    }
}

/// A board that has begun to move the first axis, until this many ms after the order.
fn moving(program: &str, millis: u64) -> Chip {
    if program == "stream" {
        let mut board = Until(Awake::new(), millis * MILLIS);
        let axis = s_curve(400, 1_500.0, 10_000.0, 100_000.0);
        run(&mut board, Job::new([axis, vec![], vec![]]), terms([10_000.0; 3]), Line::default());
        return board.0.chip;
    }
    let mut chip = common::program(program);
    if program == "laws" {
        chip.expect(&LawLine::Law(Recipe::AustinFixed(9_560, 500)).to_string(), "Y");
        chip.expect(&LawLine::Go(400).to_string(), "Y");
    } else {
        wire(&mut chip, 0, Motor::new(10, 1_000));
        prepare(&mut chip, &[&[Leg::Steps { count: 400, delay: 1_000 }]]);
        chip.expect(&CycleLine::Start(1).to_string(), "Y");
    }
    chip.run_for(millis * MILLIS);
    chip
}

/// Whether all positions are known; then they are 0.
#[track_caller]
fn is_known(chip: &mut Chip) -> bool {
    common::wake(chip);
    // Bytes of a frame that was under way at the reset may have been answered, too.
    chip.run_for(50 * MILLIS);
    chip.take_said();
    chip.expect("F", "R");
    let told: Vec<_> = (1..=3).map_while(|axis| chip.ask(&format!("V{axis}"))).collect();
    let axes = told.iter().take_while(|told| *told != "E axis").count();
    assert!(axes > 0);
    let known = told[0] == "0";
    let all = if known { "0" } else { "E uncertain" };
    assert!(told[..axes].iter().all(|told| told == all), "{told:?}");
    if !known {
        // Until it is set to 0.
        chip.expect("I1", "Y");
        chip.expect("V1", "0");
    }
    known
}

#[test]
fn a_reset_of_every_program_is_held_against_what_it_was_doing() {
    for program in PROGRAMS {
        for cause in [Cause::Power, Cause::Button, Cause::Watchdog] {
            let mut chip = common::program(program);
            chip.expect("V1", "0");
            chip.reset_by(cause);
            assert_eq!(is_known(&mut chip), cause != Cause::Watchdog, "{program}, {cause:?}");

            let mut chip = moving(program, 1_000);
            assert!(chip.edges().iter().filter(|edge| edge.is_step()).count() >= 400);
            chip.run_for(5 * MILLIS);
            chip.reset_by(cause);
            assert_eq!(is_known(&mut chip), cause == Cause::Power, "{program}, {cause:?}");
            // An unknown position does not become known by another reset.
            if cause != Cause::Power {
                chip.reset_by(Cause::Button);
                assert!(!is_known(&mut chip), "{program}, {cause:?} twice");
            }
        }
    }
}

/// A short loss of power distinguishes a board that moves from one that rests.
#[test]
fn a_loss_of_power_at_any_moment_of_a_motion_leaves_the_position_unknown() {
    for program in PROGRAMS {
        for millis in [100, 130, 160] {
            let mut chip = moving(program, millis);
            let steps = chip.edges().iter().filter(|edge| edge.is_step()).count();
            assert!(0 < steps && steps < 400, "{program}: {steps} steps");
            chip.reset_by(Cause::Power);
            assert!(!is_known(&mut chip), "{program} after {millis} ms");
        }
    }
}

/// The mark is set before the first step.
#[test]
fn a_loss_of_power_at_the_first_step_leaves_the_position_unknown() {
    for program in ["laws", "cycles"] {
        let mut chip = moving(program, 0);
        assert!(chip.edges().iter().all(|edge| !edge.is_step()), "{program} has stepped");
        let stepped = chip.run_to(200 * MILLIS, |chip| chip.edges().iter().any(Edge::is_step));
        assert!(stepped, "{program} never steps");
        chip.reset_by(Cause::Power);
        assert!(!is_known(&mut chip), "{program}");
    }
}

#[test]
fn a_board_that_is_switched_on_after_a_long_time_is_at_0() {
    for program in PROGRAMS {
        let mut chip = moving(program, 100);
        chip.power_loss(0xFF);
        assert!(is_known(&mut chip), "{program}");
    }
}
