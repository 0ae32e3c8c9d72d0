//! Programs with an executor, with RTIC and with their own main loop (`firmware/microbit`): their
//! positions agree with the edges of their pins, and the times with the virtual board.

use crate::planned;
use stepwright::{Axis, MoveError, Steppers};
use stepwright_qemu::boards::{MICROBIT, NRF51, VIRT};
use stepwright_qemu::{Edge, Machine, Pace, Simulated, machine, virtual_board};
use stepwright_sim::{Queues, SimEngine, virtual_engine};

/// Ticks between an edge and the virtual board's, for one axis alone, and for two: a visit of the
/// interrupt steps both, and takes entries for both.
const ALONE: f64 = 10.0;
const BESIDE: f64 = 250.0;
/// The same at the pace of the chip, where each visit takes eight times as long.
const SLOWLY: f64 = 8.0 * BESIDE;

/// Runs a program to its end. Returns its output, and its edges.
fn run(program: &str, pace: Pace) -> (String, Vec<Edge>) {
    let mut chip = Machine::start(&MICROBIT, program, pace).unwrap();
    let said = chip.hear().unwrap();
    (said, chip.end().unwrap())
}

/// The position of an axis after these edges.
fn position(edges: &[Edge], axis: u8) -> i64 {
    let (mut forward, mut at) = (false, 0);
    for edge in edges.iter().filter(|edge| edge.axis == axis) {
        if !edge.is_pulse {
            forward = edge.level;
        } else if edge.level {
            at += if forward { 1 } else { -1 };
        }
    }
    at
}

/// Checks the positions against the edges, and that none is late.
fn judge(said: &str, edges: &[Edge]) {
    let [x, y] = [0, 1].map(|axis| Some(position(edges, axis)));
    assert_eq!(said, format!("{x:?} {y:?} late 0"));
}

/// The motors of a virtual board.
type Virtual<'q> = Steppers<'q, SimEngine<'q, Vec<stepwright_sim::Edge>, u32>, 3>;

/// The steps that the virtual board makes, one order after the other.
fn ideal<T>(
    of: &Simulated,
    orders: impl IntoIterator<Item = T>,
    order: impl Fn(&mut Virtual<'_>, T) -> Result<(), MoveError>,
) -> [Vec<u64>; 3] {
    let (mut queues, description) = (Queues::default(), virtual_board::description(of));
    let (engine, feeds, board) = virtual_engine::<u32, _>(&mut queues, description, Vec::new());
    let mut motors = Steppers::new(engine, feeds, board);
    for one in orders {
        order(&mut motors, one).unwrap();
        while motors.any_moving() {
            while motors.plan() {}
            motors.engine().pass(1_600);
        }
    }
    let edges = motors.engine().recorder();
    [0, 1, 2].map(|axis| virtual_board::steps(edges, axis))
}

/// The largest distance of two steps, when the median is aligned.
fn worst(real: &[f64], ideal: &[u64]) -> f64 {
    assert_eq!(real.len(), ideal.len());
    let off = real.iter().zip(ideal).map(|(real, ideal)| real - *ideal as f64);
    let mut sorted: Vec<f64> = off.clone().collect();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    off.map(|off| (off - median).abs().round()).fold(0.0, f64::max)
}

#[test]
fn embassy_awaits_joins_and_races_moves() {
    for pace in [Pace::Quick, Pace::Chip] {
        let (said, edges) = run("embassy", pace);
        println!("{pace:?}: {said}");
        judge(&said, &edges);
        let [x, y] = [0, 1].map(|axis| machine::steps(&edges, axis));
        // There, and back beside the other; then a run, which ends when the other has returned: 200
        // steps at up to 447 steps/s take 0.9 s, and then it brakes.
        assert!(y.len() == 400 && (1_050..1_300).contains(&x.len()), "{} {}", x.len(), y.len());
        let last: Vec<f64> = x.windows(2).rev().take(50).map(|two| two[1] - two[0]).collect();
        assert!(last.windows(2).all(|two| two[1] < two[0] + BESIDE), "it brakes: {last:?}");
        let first = ideal(&MICROBIT, [400], |motors, target| motors.move_to(Axis::X, target));
        let off = worst(&x[..400], &first[0]);
        println!("{off} ticks");
        assert!(off <= if pace == Pace::Quick { ALONE } else { SLOWLY }, "{off} ticks");
    }
}

/// Two axes there and back, 400 and 200 steps, then 300 and 150: compared with the virtual board.
fn there_and_back(program: &str, ideal: &[Vec<u64>; 3]) {
    for pace in [Pace::Quick, Pace::Chip] {
        let (said, edges) = run(program, pace);
        judge(&said, &edges);
        assert_eq!([position(&edges, 0), position(&edges, 1)], [100, -50]);
        for (axis, part) in [(0, [0..400, 400..700]), (1, [0..200, 200..350])] {
            let real = machine::steps(&edges, axis);
            assert_eq!(real.len(), part[1].end);
            for part in part {
                let off = worst(&real[part.clone()], &ideal[usize::from(axis)][part]);
                println!("{program}, {pace:?}, axis {axis}: {off} ticks");
                let most = if pace == Pace::Quick { BESIDE } else { SLOWLY };
                assert!(off <= most, "{program}, {pace:?}, axis {axis}: {off} ticks");
            }
        }
    }
}

#[test]
fn rtic_steps_as_the_virtual_board() {
    let ideal = ideal(&MICROBIT, [400, 100], |motors, target| {
        motors.move_to(Axis::X, target)?;
        motors.move_to(Axis::Y, -target / 2)
    });
    there_and_back("rtic", &ideal);
}

#[test]
fn a_main_loop_steps_as_the_virtual_board() {
    let ideal = ideal(&MICROBIT, [400, 100], |motors, target| {
        motors.move_line_to([(Axis::X, target), (Axis::Y, -target / 2)])
    });
    there_and_back("bare", &ideal);
}

/// Without an executor, linked so that nothing in it can panic.
#[test]
fn moves_are_awaited_without_an_executor() {
    let ideal = ideal(&NRF51, [400, 100], |motors, target| motors.move_to(Axis::X, target));
    for pace in [Pace::Quick, Pace::Chip] {
        let mut chip = Machine::start(&NRF51, "awaits", pace).unwrap();
        let said = chip.hear().unwrap();
        let edges = chip.end().unwrap();
        assert_eq!((said.as_str(), position(&edges, 0)), ("reached", 100));
        for part in [0..400, 400..700] {
            let off = worst(&machine::steps(&edges, 0)[part.clone()], &ideal[0][part]);
            println!("awaits, {pace:?}: {off} ticks");
            assert!(off <= if pace == Pace::Quick { ALONE } else { SLOWLY }, "{off} ticks");
        }
    }
}

/// On a Cortex-M0 and on RISC-V: lines of two axes, of three and of one, and moves; linked so that
/// nothing in it can panic.
#[test]
fn planned_motors_step_as_the_virtual_board() {
    for board in [&NRF51, &VIRT] {
        #[expect(clippy::redundant_closure, reason = "the function is not general enough")]
        let ideal =
            ideal(board, 0..planned::ORDERS, |motors, number| planned::order(motors, number));
        let mut chip = Machine::start(board, "planned", Pace::Quick).unwrap();
        assert_eq!(chip.hear().unwrap(), "reached", "{}", board.name);
        let edges = chip.end().unwrap();
        assert_eq!([0, 1, 2].map(|axis| position(&edges, axis)), [-200, 250, -450]);
        let parts = [
            (0, 0..400, BESIDE),
            (0, 400..700, BESIDE),
            (0, 700..1_100, BESIDE),
            (0, 1_100..1_400, BESIDE),
            (0, 1_400..1_700, ALONE),
            (0, 1_700..1_800, ALONE),
            (1, 0..200, BESIDE),
            (1, 200..350, BESIDE),
            (1, 350..650, BESIDE),
            (2, 0..250, BESIDE),
            (2, 250..650, BESIDE),
            (2, 650..950, ALONE),
        ];
        for (axis, part, most) in parts {
            let (real, ideal) = (machine::steps(&edges, axis), &ideal[usize::from(axis)]);
            assert_eq!(real.len(), ideal.len(), "{}, axis {axis}", board.name);
            let off = worst(&real[part.clone()], &ideal[part.clone()]);
            println!("{}, axis {axis}, {part:?}: {off} ticks", board.name);
            assert!(off <= most, "{}, axis {axis}, {part:?}: {off} ticks", board.name);
        }
    }
}

/// The documentation shows the program that runs here, and the lengths of the others.
#[test]
fn the_page_shows_what_runs() {
    let page = include_str!("../../../docs/embassy.md");
    let programs = [
        ("embassy", include_str!("../../microbit/src/bin/embassy.rs"), 30),
        ("rtic", include_str!("../../microbit/src/bin/rtic.rs"), 45),
        ("bare", include_str!("../../microbit/src/bin/bare.rs"), 45),
    ];
    assert!(page.contains(programs[0].1), "docs/embassy.md has another program");
    for (name, program, most) in programs {
        let lines = program.lines().map(str::trim).filter(|line| !line.is_empty());
        let lines = lines.filter(|line| !line.starts_with("//")).count();
        assert!(lines <= most, "{name}: {lines} lines");
        assert!(
            name == "embassy" || page.contains(&format!("{name}.rs), {lines} lines")),
            "{name}"
        );
    }
}
