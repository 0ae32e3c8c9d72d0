//! An order that was ended early or refused has no effect on the next one.

use std::cell::Cell;

use stepwright::{Accel, Rate, Speed};
use stepwright_austin::line::Line;
use stepwright_austin::{Austin, Recipe};
use stepwright_cycle::{Clock, Leg, Motor};
use stepwright_sim::timed::TimedLineBoard;
use stepwright_sim::{
    CycleBoard, CycleLineBoard, Description, LawBoard, ProgramBoard, Queues, SimProgram, Stand,
};

/// Says lines, and lets this many ms pass.
fn say<P: SimProgram, const L: usize>(board: &mut ProgramBoard<P, L>, lines: &[&str], ms: u64) {
    for line in lines {
        line.bytes().chain([b'\r']).for_each(|byte| board.receive(byte));
        board.run_until(board.now() + 16_000);
    }
    board.run_until(board.now() + 16_000 * ms);
}

/// A change that waits for a step does not apply to another travel.
#[test]
fn a_killed_travel_takes_its_changes_along() {
    let (top, accel) = (Speed::from_steps(1_000).unwrap(), Accel::from_steps(1_000).unwrap());
    let constants = Austin::new(Rate::MHZ, top, accel).constants(1_000).unwrap();
    let law = Line::Law(Recipe::Austin(constants)).to_string();
    let intervals = |before: &[&str], early: u64| {
        let mut queues = Queues::default();
        let mut board: LawBoard<'_, Vec<_>> =
            LawBoard::new(&mut queues, Description::uno(), Vec::new());
        say(&mut board, &[&law], 0);
        say(&mut board, before, early);
        say(&mut board, &["K", "I1"], 10);
        let made = board.recorder().len();
        say(&mut board, &[":G100"], 2_000);
        let steps = board.recorder()[made..].iter().filter(|edge| edge.is_step());
        let times: Vec<_> = steps.map(|edge| edge.time).collect();
        times.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>()
    };
    let whole = intervals(&[], 0);
    assert_eq!(whole.len(), 99);
    // Killed on its way, and ended before the change.
    assert_eq!(intervals(&[":C50,400000", ":G500"], 100), whole);
    assert_eq!(intervals(&[":C50,400000", ":G20"], 1_000), whole);
}

/// One update per second, whatever is refused meanwhile.
#[test]
fn a_refused_speed_leaves_the_clock_of_the_one_before() {
    let wire = ":W1,66,48,0,0,1,0,0,16,48,32";
    let steps = |meanwhile: &[&str]| {
        let mut board = TimedLineBoard::uno();
        say(&mut board, &[wire, ":U1,10", ":M1,192,32000,0,100,1000,200,1009"], 2_500);
        say(&mut board, meanwhile, 0);
        let until = 16_000_000 * 6;
        board.run_until(until);
        board.program().steps().to_vec()
    };
    let alone = steps(&[]);
    assert!(alone.len() > 100, "{}", alone.len());
    assert_eq!(steps(&[":M1,192,5,0,100,1000,200,1009"]), alone);
}

/// A pending act does not apply to another cycle.
#[test]
fn a_cycle_takes_its_acts_along() {
    let legs = [const { Cell::new(Leg::Wait { count: 0, delay: 0 }) }; 4];
    let (motors, stands) = ([Motor::new(1, 1); 3], [Stand::default(); 3]);
    let rate = Rate::from_hz(16_000_000).unwrap();
    let cycles = CycleBoard::new(motors, stands, Clock::Deadlines, rate, Vec::new());
    let mut board: CycleLineBoard<'_, Vec<_>, 3> = CycleLineBoard::new(cycles, &legs);
    let motor = ":M0,10,1000,0,0,0,0,0";
    // An act at 20 ms finishes the cycle, which ends after 5 ms.
    say(&mut board, &[motor, ":S0,0,5,1000", ":T2,320000", ":G1"], 100);
    assert_eq!(board.position(0), Some(50));
    say(&mut board, &[":S0,0,60,1000", ":G2"], 200);
    assert_eq!(board.position(0), Some(650));
}
