//! Streams on chips of 32 bits: their edges compared with those of the virtual board that plays the
//! same frames, and the effects of silence, noise and a hold. The checks are those for the AVR.

use crate::feed::guards;
use crate::feed::instants::{Befalls, Guarded, Outcome, Random, befall, instant, motion};
use crate::feed::judge::judge;
use crate::feed::wire::Wire;
use crate::feed::{
    self, Job, Line, MILLIS, Step, Target, Told, position_of, run, s_curve, steps_of,
};
use crate::streamed::{apart, organic, terms};
use stepwright::Rate;
use stepwright_controller::StreamBoard as Player;
use stepwright_feeder::{FeedState, FeedTerms};
use stepwright_qemu::boards::{NRF51, VIRT};
use stepwright_qemu::{Pace, Paced, Simulated, virtual_board};
use stepwright_sim::Edge;

/// The boards, and the parameters of their players.
const BOARDS: [(&Simulated, Player); 2] =
    [(&NRF51, stepwright_nrf51::board::STREAM), (&VIRT, stepwright_virt::board::STREAM)];

/// A chip with the program, whose time begins when it has started.
struct Awake {
    chip: Paced,
    begun: u64,
}

impl Awake {
    fn new(board: &Simulated, pace: Pace) -> Awake {
        let mut chip = Paced::start(board, "stream", pace).unwrap();
        chip.run_until(20 * MILLIS).unwrap();
        let begun = chip.now();
        Awake { chip, begun }
    }

    /// The answer to a line.
    fn ask(&mut self, line: &str) -> String {
        self.chip.said().unwrap();
        for byte in line.bytes().chain([b'\r']) {
            self.chip.send(&[byte]).unwrap();
            self.chip.run_until(self.chip.now() + MILLIS / 8).unwrap();
        }
        let mut answer = Vec::new();
        for _ in 0..400 {
            self.chip.run_until(self.chip.now() + MILLIS / 4).unwrap();
            answer.extend(self.chip.said().unwrap());
            if answer.contains(&b'\r') {
                break;
            }
        }
        String::from_utf8_lossy(&answer).trim_end().to_owned()
    }

    /// `late` and the positions that the chip reports.
    fn tells(&mut self) -> (u32, [i64; 3]) {
        self.chip.send(&[0xFF; 4]).unwrap();
        self.ask("");
        let about = self.ask("?");
        let late = about.split("late=").nth(1).and_then(|rest| rest.split(' ').next());
        let at = [1, 2, 3].map(|axis| self.ask(&format!("V{axis}")).parse().unwrap());
        (late.unwrap_or_else(|| panic!("{about}")).parse().unwrap(), at)
    }
}

impl Target for Awake {
    fn run_until(&mut self, cycle: u64) {
        self.chip.run_until(self.begun + cycle).unwrap();
    }
    fn receive(&mut self, byte: u8) {
        self.chip.send(&[byte]).unwrap();
    }
    fn said(&mut self) -> Vec<u8> {
        self.chip.said().unwrap()
    }
    fn edges(&mut self) -> &[Edge] {
        self.chip.edges()
    }
}

impl Guarded for Awake {
    fn now(&self) -> u64 {
        self.chip.now()
    }
    fn begun(&self) -> u64 {
        self.begun
    }
    fn close(&mut self, _: u8, closed: bool) {
        assert!(!closed, "QEMU's boards have no switches");
    }
}

/// Runs a job on a chip. Returns the result, late steps, and edges.
fn on_chip(
    board: &Simulated,
    pace: Pace,
    job: &[Vec<Step>; 3],
    terms: FeedTerms,
    line: Line,
) -> (Told, u32, Vec<Edge>) {
    let mut chip = Awake::new(board, pace);
    let told = run(&mut chip, Job::new(job.clone()), terms, line);
    println!("{}: {:?}, {} again, {} bytes", board.name, told.state, told.again, told.bytes);
    // After leaving the path it still brakes.
    chip.chip.run_until(chip.chip.now() + 2_000 * MILLIS).unwrap();
    let (late, positions) = chip.tells();
    let edges = chip.edges().to_vec();
    for axis in 0..3u8 {
        let at = position_of(&steps_of(&edges, axis));
        assert_eq!(positions[usize::from(axis)], at, "axis {axis}: the chip's, and the edges'");
    }
    (told, late, edges)
}

/// RISC-V at both paces, and the micro:bit at the chip's.
const RUNS: [(usize, Pace); 3] = [(1, Pace::Quick), (0, Pace::Chip), (1, Pace::Chip)];

/// Runs that a chip keeps up with: no step late, all as on the virtual board. At the chip's pace a
/// visit of the step interrupt that prepares the next entries delays the steps of other axes.
fn keeps_up(
    runs: &[(usize, Pace)],
    what: &str,
    job: &[Vec<Step>; 3],
    decels: [f64; 3],
    [quick, chip]: [f64; 2],
) {
    for (number, pace) in runs.iter().copied() {
        let (board, player) = BOARDS[number];
        let most = if pace == Pace::Quick { quick } else { chip };
        let terms = terms(player, decels);
        let line = Line { polls: true, ..Line::default() };
        let (told, late, edges) = on_chip(board, pace, job, terms, line);
        let axes = (0..3).filter(|axis| !job[*axis].is_empty()).map(|axis| 1 << axis).sum();
        let description = virtual_board::description(board);
        let worst = apart(description, &edges, job, FeedTerms { axes, ..terms });
        println!(
            "{}, {what}: late {late}, {} answers, worst {worst:.2} us",
            board.name, told.answers
        );
        assert_eq!((told.state, told.again, late), (FeedState::Over, 0, 0));
        assert!(worst < most, "{worst}");
    }
}

/// Three equal axes with limited jerk, while `?` is sent back to back.
#[test]
fn three_axes_at_the_pace_of_the_chip() {
    let path = s_curve(9_000, 6_000.0, 20_000.0, 200_000.0);
    keeps_up(&RUNS, "three axes", &[path.clone(), path.clone(), path], [20_000.0; 3], [2.0, 5.0]);
}

#[test]
fn one_axis_at_the_pace_of_the_chip() {
    let path = s_curve(18_000, 12_000.0, 40_000.0, 400_000.0);
    keeps_up(&RUNS, "one axis", &[path, vec![], vec![]], [40_000.0; 3], [2.0, 5.0]);
}

/// RISC-V at the chip's pace makes one step of the whole motion late: at a turn at 5,000 steps/s.
#[test]
fn a_motion_that_wanders() {
    for (runs, size) in [(&RUNS[..2], 1.0), (&RUNS[2..], 0.75)] {
        keeps_up(runs, "it wanders", &organic(2.0, size), [40_000.0; 3], [12.0, 100.0]);
    }
}

/// A host that sleeps for less than the planned time ahead loses nothing; after a longer sleep it
/// finds the board off the path.
#[test]
fn a_stall_is_ridden_through_and_a_longer_one_brakes() {
    let (board, player) = BOARDS[1];
    let job = organic(4.0, 1.0);
    let decels = [30_000.0, 20_000.0, 10_000.0];
    for (sleep, state) in [(1_000, FeedState::Over), (4_000, FeedState::Off)] {
        let sleeps = vec![(1_500 * MILLIS, sleep * MILLIS)];
        let terms = FeedTerms { ahead: 1_400_000, lease: 2_000, ..terms(player, decels) };
        let line = Line { sleeps, ..Line::default() };
        let (told, late, edges) = on_chip(board, Pace::Quick, &job, terms, line);
        assert_eq!((told.state, late), (state, 0));
        for (n, axis) in (0..3u8).enumerate() {
            judge(&steps_of(&edges, axis), &job[n], decels[n]).unwrap();
        }
    }
}

#[test]
fn spoilt_bytes_lose_no_step() {
    let [x, y, _] = organic(2.0, 1.0);
    let job = [x, y, vec![]];
    for (board, player) in BOARDS {
        let line = Line { spoils: 100, seed: 3, ..Line::default() };
        let (told, late, edges) =
            on_chip(board, Pace::Chip, &job, terms(player, [40_000.0; 3]), line);
        assert_eq!((told.state, late), (FeedState::Over, 0), "{} again", told.again);
        assert!(told.again > 5, "nothing was spoilt");
        for axis in 0..3u8 {
            assert_eq!(steps_of(&edges, axis).len(), job[usize::from(axis)].len());
        }
    }
}

/// A hold: frames sent ahead are taken back, and the axis brakes by the frames that replace them.
#[test]
fn a_hold_brakes_within_50_ms() {
    const SPEED: f64 = 8_000.0;
    const DECEL: f64 = 20_000.0;
    for (board, player) in BOARDS {
        let level = s_curve(24_000, SPEED, 40_000.0, 400_000.0);
        let mut chip = Awake::new(board, Pace::Chip);
        let axes = 1;
        let terms = FeedTerms { axes, ..terms(player, [DECEL; 3]) };
        let mut wire = Wire::new(Job::new([level.clone(), vec![], vec![]]), terms, 0);
        wire.feed(&mut chip, 1_200 * MILLIS);
        let (asked, mut kept, mut path) = (chip.now(), 0, level.clone());
        let took = wire.replan(|cut| {
            kept = cut.steps as usize;
            // From the last kept step on: x = v·t − a·t²/2.
            let last = level[kept - 1].0;
            let behind = (1..).map_while(|n| {
                let under = SPEED * SPEED - 2.0 * DECEL * f64::from(n);
                (under >= 0.0).then(|| (last + (SPEED - under.sqrt()) / DECEL, true))
            });
            path.truncate(kept);
            path.extend(behind);
            Job::new([path[kept..].to_vec(), vec![], vec![]])
        });
        assert!(took, "{}", board.name);
        wire.feed(&mut chip, 2_500 * MILLIS);
        assert_eq!(wire.feeder().state(), FeedState::Over);
        let steps = steps_of(chip.edges(), 0);
        let begins = (steps[kept - 1].0 - asked) as f64 / MILLIS as f64;
        println!("{}: brakes {begins:.1} ms later", board.name);
        assert!(begins < 50.0);
        let (worst, _) = feed::worst(chip.edges(), &[path, vec![], vec![]], 0.0, 0.0);
        // With little sent ahead the host keeps within 25 µs.
        assert!(worst < 30.0, "{worst} us");
        assert_eq!(chip.tells(), (0, [steps.len() as i64, 0, 0]));
    }
}

fn number(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |value| value.parse().expect(name))
}

/// A host falls silent at random instants of runs that the chip keeps up with.
#[test]
fn silence_at_any_instant_brakes_every_axis() {
    let (instants, seed) = (number("STEPWRIGHT_INSTANTS", 5), number("STEPWRIGHT_SEED", 1));
    let ((board, player), mut off, mut most) = (BOARDS[1], 0, 0.0f64);
    for n in 0..instants {
        // The kinds of motion with turns, slow ones, and axes of all speeds.
        let kind = [2, 3, 5, 7][n as usize % 4];
        let mut random = Random::new(seed + n);
        let mut motion = motion(kind, &mut random);
        motion.lease = [0, 200, 1_000][random.below(3) as usize];
        let at = instant(&motion, &mut random);
        let mut befalls = Befalls::any(&mut random);
        if matches!(befalls, Befalls::Input(_)) {
            befalls = Befalls::Plug;
        }
        let mut chip = Awake::new(board, Pace::Quick);
        let own = terms(player, motion.decels);
        let terms = FeedTerms { hz: own.hz, brakes: own.brakes, stagger: 0, ..motion.terms() };
        let mut wire = Wire::new(Job::new(motion.path.clone()), terms, 0);
        wire.feed(&mut chip, at);
        let told = befall(&mut chip, &mut wire, &motion, befalls, &mut random);
        let Outcome { off: left, axes, .. } = told.unwrap_or_else(|why| {
            panic!("seed {}, {}, {befalls:?} at {} ms: {why}", seed + n, motion.name, at / MILLIS)
        });
        off += u64::from(left);
        most = axes.iter().map(|axis| axis.steepest).fold(most, f64::max);
    }
    println!("{instants} instants, {off} off the path, at most {most:.3} of a deceleration");
    assert!(off > 0);
}

#[test]
fn z_brakes_and_k_stops() {
    guards::z_brakes_and_f_tells(&mut Awake::new(&NRF51, Pace::Quick));
    guards::k_stops_at_once(&mut Awake::new(&NRF51, Pace::Quick));
    guards::what_was_not_started_is_forgotten(&mut Awake::new(&NRF51, Pace::Quick));
}

/// A board's information about itself.
#[test]
fn a_board_says_what_it_is() {
    for (board, player) in BOARDS {
        let hz = Rate::hz(player.rate);
        let about = Awake::new(board, Pace::Chip).ask("?");
        assert!(about.contains(&format!(" hz={hz} axes=3 late=0 fifo=4096")), "{about}");
    }
}

/// With enough sent ahead to continue: the silence makes it brake.
#[test]
fn a_lease_counts_until_the_end() {
    guards::a_lease_counts_until_the_end(&mut Awake::new(BOARDS[0].0, Pace::Quick));
}
