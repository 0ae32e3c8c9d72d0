//! Planned moves and motor cycles on every drive: the lines of each table, row by row, at the times
//! of the virtual board.

use stepwright::drive::Sequence;
use stepwright::drive::sequence::{
    BRIDGE_HALF, L6219_FULL, L6219_HALF, L6219_QUARTER, SHIELD, UNIPOLAR_FULL, UNIPOLAR_HALF,
};
use stepwright::{Accel, Axis, AxisLimits, Rate, Speed};
use stepwright_cycle::{Calibration, Clock, Motor, Program};
use stepwright_rig::board::{HZ, Pin};
use stepwright_rig::edges::steps_of;
use stepwright_rig::{Board, Chip, firmware};
use stepwright_sim::{CycleBoard, Description, Edge, Queues, Stand, virtual_steppers};

use crate::common::board;

/// The largest difference between an edge and the virtual board's, in cycles: for planned moves,
/// beside which the main loop plans, and for motor cycles with two motors at once.
const PLANNED: u64 = 250;
const CYCLE: u64 = 1_600;

const TABLES: [(&str, Sequence, u8); 7] = [
    ("motor shield", SHIELD, 0b11),
    ("bridges, half steps", BRIDGE_HALF, 0b1111),
    ("unipolar, full steps", UNIPOLAR_FULL, 0b1111),
    ("unipolar, half steps", UNIPOLAR_HALF, 0b1111),
    ("L6219, full steps", L6219_FULL, 0b11_1111),
    ("L6219, half steps", L6219_HALF, 0b11_1111),
    ("L6219, quarter steps", L6219_QUARTER, 0b11_1111),
];

/// The observed pins of a program.
struct Seen {
    /// The steps by STEP: the time and the direction.
    steps: Vec<(u64, bool)>,
    /// The levels of the windings' port from each change on.
    levels: Vec<(u64, u8)>,
}

fn play(program: &str, seconds: u64) -> Seen {
    let image = firmware::load(&format!("{}-{program}", board()));
    let mut chip = Chip::new(board(), &image.unwrap_or_else(|error| panic!("{error:#}")));
    let (port, step, direction) = match board() {
        Board::Uno => ('B', Pin('D', 2), Pin('D', 5)),
        Board::Mega => ('A', Pin('C', 1), Pin('C', 2)),
    };
    let mut pins: Vec<Pin> = (0..6).map(|bit| Pin(port, bit)).collect();
    pins.extend([step, direction]);
    chip.watch_pins(&pins);
    chip.run_for(seconds * HZ);
    let mut seen = Seen { steps: Vec::new(), levels: Vec::new() };
    let (mut now, mut forward) = (0u8, false);
    for &(time, which, level) in chip.watched_changes() {
        match which {
            6 if level => seen.steps.push((time, forward)),
            6 => {}
            7 => forward = level,
            bit => {
                now = if level { now | 1 << bit } else { now & !(1 << bit) };
                match seen.levels.last_mut() {
                    Some(last) if last.0 == time => last.1 = now,
                    _ => seen.levels.push((time, now)),
                }
            }
        }
    }
    seen
}

/// The largest difference of times, each relative to its first.
#[track_caller]
fn off(real: &[u64], ideal: &[u64], what: &str) -> u64 {
    assert_eq!(real.len(), ideal.len(), "{what}");
    let off = |(r, i): (&u64, &u64)| (r - real[0]).abs_diff(i - ideal[0]);
    real.iter().zip(ideal).map(off).max().unwrap()
}

/// Takes the next steps through a table from the windings' changes. Returns their times.
#[track_caller]
fn rows(rest: &mut &[(u64, u8)], table: &[u8], mask: u8, what: &str) -> Vec<u64> {
    let many = table.len();
    let is_it = |all: &[(u64, u8)]| all.iter().zip(table).all(|(c, row)| c.1 & mask == *row);
    let begin = rest.windows(many).position(is_it);
    let begin = begin.unwrap_or_else(|| panic!("{what}: not its {many} steps"));
    let times = rest[begin..begin + many].iter().map(|change| change.0).collect();
    *rest = &rest[begin + many..];
    times
}

/// The rows of these steps from a phase on; updates the phase.
fn table(sequence: Sequence, phase: &mut u8, steps: usize, forward: bool) -> Vec<u8> {
    let mut next = || {
        *phase = sequence.after(*phase, forward);
        sequence.levels(*phase)
    };
    (0..steps).map(|_| next()).collect()
}

/// A travel of the planned motor on the virtual board.
fn planned() -> Vec<u64> {
    let mut queues = Queues::default();
    let mut motors = virtual_steppers(&mut queues, Description::uno(), Vec::<Edge>::new());
    let limits =
        AxisLimits::new(Speed::from_steps(800).unwrap(), Accel::from_steps(4_000).unwrap());
    motors.set_limits(Axis::X, limits);
    motors.move_to(Axis::X, 200).unwrap();
    while motors.is_moving(Axis::X) {
        motors.poll();
        motors.engine().pass(1_000);
    }
    let edges = std::mem::take(motors.engine().recorder());
    steps_of(&edges, 0).iter().map(|step| step.time).collect()
}

#[test]
fn planned_moves_on_every_drive() {
    let seen = play("drives-planned", 12);
    let ideal = planned();
    assert_eq!(ideal.len(), 200);
    let ways: Vec<bool> = seen.steps.iter().map(|step| step.1).collect();
    assert_eq!(ways, [[true; 200], [false; 200]].concat());
    for way in seen.steps.chunks(200) {
        let real: Vec<u64> = way.iter().map(|step| step.0).collect();
        let off = off(&real, &ideal, "step and direction");
        println!("step and direction: {off} cycles");
        assert!(off <= PLANNED, "{off} cycles");
    }
    let mut rest = &seen.levels[..];
    for (name, sequence, mask) in TABLES {
        let mut phase = 0;
        for forward in [true, false] {
            let rows = rows(&mut rest, &table(sequence, &mut phase, 200, forward), mask, name);
            let off = off(&rows, &ideal, name);
            println!("{name}: {off} cycles");
            assert!(off <= PLANNED, "{name}: {off} cycles");
        }
        assert_eq!(phase, 0, "{name}: there and back");
    }
}

/// Both motors of the cycle on the virtual board.
fn cycled() -> [Vec<u64>; 2] {
    let rate = Rate::from_hz(HZ as u32).unwrap();
    let (motors, stands) = ([Motor::new(1, 1_000); 2], [Stand::default(); 2]);
    let mut board: CycleBoard<'_, Vec<Edge>, 2> =
        CycleBoard::new(motors, stands, Clock::Deadlines, rate, Vec::new());
    for (motor, count, delay) in [(0, 150, 1_500), (1, 100, 2_100)] {
        let program = Program::Steps { count, delay };
        board.cycle().prepare(motor, program, Calibration::None).unwrap();
    }
    board.cycle().start().unwrap();
    board.run_until(HZ);
    let edges = board.with_recorder(std::mem::take);
    [0, 1].map(|motor| {
        let rises = edges.iter().filter(|edge| edge.axis == motor && edge.is_step() && edge.level);
        rises.map(|edge| edge.time).collect()
    })
}

#[test]
fn motor_cycles_on_every_drive() {
    let seen = play("drives-cycles", 5);
    let [first, second] = cycled();
    assert_eq!((first.len(), second.len()), (150, 100));
    assert_eq!(seen.steps.len(), 14 * 150);
    let mut rest = &seen.levels[..];
    let mut travels = seen.steps.chunks(150);
    for (name, sequence, mask) in TABLES {
        let mut phase = 0;
        for forward in [true, false] {
            let steps = travels.next().unwrap();
            assert!(steps.iter().all(|step| step.1 == forward), "{name}");
            let steps: Vec<u64> = steps.iter().map(|step| step.0).collect();
            let rows = rows(&mut rest, &table(sequence, &mut phase, 100, forward), mask, name);
            // Both times count from the first step of either.
            let begun = (steps[0].min(rows[0]), first[0].min(second[0]));
            let off = |real: &[u64], ideal: &[u64]| {
                let off = |(r, i): (&u64, &u64)| (r - begun.0).abs_diff(i - begun.1);
                real.iter().zip(ideal).map(off).max().unwrap()
            };
            let off = off(&steps, &first).max(off(&rows, &second));
            println!("{name}: {off} cycles");
            assert!(off <= CYCLE, "{name}: {off} cycles");
        }
    }
}
