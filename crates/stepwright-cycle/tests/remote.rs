//! Cycles ordered over the line, on the virtual board: the edges equal those of the same cycle
//! prepared by a program, and every wrong line is refused with what is allowed.

use std::cell::Cell;

use stepwright::Rate;
use stepwright_cycle::line::{
    CycleFault, CycleLine, CycleReport, LONGEST, LineAct, LineProgram, MotorPins,
};
use stepwright_cycle::{
    AtHardEnd, AtSoftEnd, Calibration, Clock, Cycle, CycleHold, DelayRamp, End, Faults, Homing,
    Leg, Motor, Program, Refusal, Remote, Strategies,
};
use stepwright_protocol::{BoardProgram, Fault, Incoming, ProgramSlave, Text, crc};
use stepwright_sim::{CycleBoard, Edge, Pin, Stand};

const HZ: u64 = 16_000_000;
/// Ticks from one poll of the board's main loop to the next.
const LOOK: u64 = 1_600;

type Host<'a> = CycleBoard<'a, Vec<Edge>, 3>;

struct Chip<'a>(Remote<'a, Host<'a>, 3>, ProgramSlave<CycleFault>);

fn legs() -> [Cell<Leg>; 24] {
    std::array::from_fn(|_| Cell::new(Leg::Wait { count: 0, delay: 0 }))
}

fn virtual_board<'a>(motors: [Motor; 3], stands: [Stand; 3], clock: Clock) -> Host<'a> {
    CycleBoard::new(motors, stands, clock, Rate::from_hz(HZ as u32).unwrap(), Vec::new())
}

/// Sends a line unchanged, and returns the answer.
fn say_to<'a, H: CycleHold<'a, 3>>(
    remote: &mut Remote<'a, H, 3>,
    slave: &mut ProgramSlave<CycleFault>,
    line: &str,
) -> String {
    let mut coming = Incoming::<LONGEST>::new();
    assert!(line.bytes().all(|byte| !coming.receive(Some(byte))) && coming.receive(Some(b'\r')));
    slave.obey(&mut coming, remote);
    let mut answer: Vec<u8> = std::iter::from_fn(|| slave.next_byte(remote)).collect();
    assert_eq!(answer.pop(), Some(b'\r'), "{line}");
    String::from_utf8(answer).unwrap()
}

impl<'a> Chip<'a> {
    fn new(stands: [Stand; 3], legs: &'a [Cell<Leg>]) -> Chip<'a> {
        let motors = [Motor::new(1, 1); 3];
        let board = virtual_board(motors, stands, Clock::Deadlines);
        Chip(Remote::new(board, legs), ProgramSlave::new())
    }

    /// Sends a line unchanged, and returns the answer.
    fn text(&mut self, line: &str) -> String {
        say_to(&mut self.0, &mut self.1, line)
    }

    /// Sends a line with a checksum, which the answer must have too.
    fn ask(&mut self, line: CycleLine) -> String {
        let line = line.to_string();
        let summed = |line: &str| {
            let sum = line.bytes().fold(0, crc);
            format!("{line}*{sum:02X}")
        };
        let answer = self.text(&summed(&line));
        let (bare, _) = answer.rsplit_once('*').unwrap_or_else(|| panic!("{line}: {answer}"));
        assert_eq!(answer, summed(bare), "{line}");
        bare.to_owned()
    }

    #[track_caller]
    fn say(&mut self, line: CycleLine) {
        assert_eq!(self.ask(line), "Y", "{line}");
    }

    fn fault(&mut self, line: CycleLine) -> Fault<CycleFault> {
        let answer = self.ask(line);
        Fault::read(answer.as_bytes()).unwrap_or_else(|| panic!("{line}: {answer}"))
    }

    fn look(&mut self) -> CycleReport {
        let answer = self.ask(CycleLine::Look);
        CycleReport::read(answer.as_bytes()).unwrap_or_else(|| panic!("{answer}"))
    }

    /// Lets time pass, in µs, while the main loop polls.
    fn run(&mut self, us: u64) {
        let end = self.0.hold().now() + us * HZ / 1_000_000;
        while self.0.hold().now() < end {
            let now = self.0.hold().now();
            self.0.hold().run_until((now + LOOK).min(end));
            self.0.poll();
        }
    }

    /// Runs until the cycle is over, at most a simulated minute.
    fn rest(&mut self) -> CycleReport {
        for _ in 0..600 {
            self.run(100_000);
            let report = self.look();
            if !report.running {
                return report;
            }
        }
        panic!("it never ends");
    }

    fn edges(&mut self) -> Vec<Edge> {
        self.0.hold().with_recorder(std::mem::take)
    }
}

/// Steps and turns from the first step on.
fn from_first(edges: &[Edge]) -> Vec<Edge> {
    let moves = edges.iter().filter(|edge| matches!(edge.pin, Pin::Step | Pin::Direction));
    let moves: Vec<Edge> = moves.copied().collect();
    let first = moves.iter().position(|edge| edge.pin == Pin::Step).expect("a step");
    let begun = moves[first].time;
    moves[first..].iter().map(|edge| Edge { time: edge.time - begun, ..*edge }).collect()
}

fn refused(refusal: Refusal) -> Fault<CycleFault> {
    Fault::Own(CycleFault::Refused(refusal))
}

const X: Motor = Motor::new(7_500, 500);
const LEGS: [Leg; 3] = [
    Leg::Steps { count: 30, delay: 1_000 },
    Leg::Wait { count: 1, delay: 30_000 },
    Leg::Steps { count: -31, delay: 700 },
];
const RAMP: DelayRamp = DelayRamp { from: 3_000, to: 600, by: 100 };

/// Every kind of program, three at a time.
fn programs<'a>() -> Vec<[(LineProgram, Program<'a>); 3]> {
    let steps =
        |count, delay| (LineProgram::Steps { count, delay }, Program::Steps { count, delay });
    let ramp = |steps, forward| {
        let ramp = RAMP;
        (LineProgram::Ramp { steps, forward, ramp }, Program::Ramp { steps, forward, ramp })
    };
    let whirl =
        |forward, delay| (LineProgram::Whirl { forward, delay }, Program::Whirl { forward, delay });
    let series = (LineProgram::Legs { first: 2, count: 3 }, Program::Series(&LEGS));
    vec![
        [steps(100, 1_000), series, ramp(Some(80), false)],
        [steps(-300, 0), whirl(true, 900), ramp(None, true)],
    ]
}

#[test]
fn every_program_steps_as_when_a_program_prepares_it() {
    for clock in [Clock::Deadlines, Clock::Tick { period: 100 }] {
        for (n, all) in programs().into_iter().enumerate() {
            let (legs, finish) = (legs(), 200_000);
            let mut chip = Chip::new([Stand::default(); 3], &legs);
            let mut ideal = virtual_board([X; 3], [Stand::default(); 3], clock);
            chip.say(CycleLine::New);
            chip.say(CycleLine::Clock(clock, Strategies::CANCEL));
            for (place, leg) in (2..).zip(LEGS) {
                chip.say(CycleLine::Leg(place, leg));
            }
            for (motor, (line, program)) in (0..).zip(all) {
                chip.say(CycleLine::Motor(motor, X));
                chip.say(CycleLine::Prepare(motor, Calibration::None, line));
                ideal.cycle().prepare(motor, program, Calibration::None).unwrap();
            }
            chip.say(CycleLine::Act(LineAct::Finish, finish * HZ / 1_000_000));
            chip.say(CycleLine::Start(1));
            ideal.cycle().start().unwrap();
            let report = chip.rest();
            ideal.run_until(finish * HZ / 1_000_000);
            ideal.cycle().finish();
            assert_eq!((report.number, report.error, report.late), (1, None, 0));
            let (real, ideal) = (from_first(&chip.edges()), ideal.with_recorder(std::mem::take));
            let mut all = [real, from_first(&ideal)];
            if clock != Clock::Deadlines {
                // A board plays it in one pass: STEP rises where it does in three.
                for edges in &mut all {
                    edges.retain(Edge::is_step);
                }
            }
            let [real, ideal] = all;
            assert_eq!(real, ideal, "{clock:?} {n}");
            assert!(real.len() > 200);
        }
    }
}

#[test]
fn a_pause_on_the_way_comes_at_its_time() {
    let legs = legs();
    let mut chip = Chip::new([Stand::default(); 3], &legs);
    chip.say(CycleLine::Motor(0, X));
    let program = LineProgram::Steps { count: 100, delay: 1_000 };
    chip.say(CycleLine::Prepare(0, Calibration::None, program));
    chip.say(CycleLine::Act(LineAct::Pause, 30_500 * 16));
    chip.say(CycleLine::Act(LineAct::Resume, 80_700 * 16));
    chip.say(CycleLine::Start(9));
    chip.run(60_000);
    let report = chip.look();
    assert!(report.paused && report.running);
    assert_eq!(report.motors[0].position, 30 * 7_500);
    let report = chip.rest();
    assert_eq!(report.motors[0].position, 100 * 7_500);
    // Within one poll.
    let near = |at: Option<u64>, us: u64| (us * 16..us * 16 + LOOK + 2).contains(&at.unwrap());
    assert!(near(report.acts[0], 30_500) && near(report.acts[1], 80_700), "{report:?}");
    assert!(report.acts[2].is_none() && near(Some(report.time), 150_200), "{report:?}");
}

#[test]
fn now_is_now() {
    let legs = legs();
    let mut chip = Chip::new([Stand::default(); 3], &legs);
    chip.say(CycleLine::Motor(2, X));
    let program = LineProgram::Whirl { forward: false, delay: 500 };
    chip.say(CycleLine::Prepare(2, Calibration::None, program));
    chip.say(CycleLine::Start(1));
    chip.run(10_000);
    chip.say(CycleLine::Now(LineAct::Pause));
    let at = chip.look().motors[2].position;
    chip.run(10_000);
    assert_eq!(chip.look().motors[2].position, at);
    chip.say(CycleLine::Now(LineAct::Resume));
    chip.run(10_000);
    assert!(chip.look().motors[2].position < at);
    chip.say(CycleLine::Now(LineAct::Finish));
    chip.run(1_000);
    let report = chip.look();
    assert!(!report.running && report.acts[2].is_some() && report.error.is_none());
    // Nothing is left to finish; that is fine.
    chip.say(CycleLine::Now(LineAct::Finish));
}

/// However slowly the line takes the answer: 87 µs a byte here, at 2,000 steps/s.
#[test]
fn positions_are_those_of_one_moment() {
    let legs = legs();
    let mut chip = Chip::new([Stand::default(); 3], &legs);
    for motor in 0..3 {
        chip.say(CycleLine::Motor(motor, Motor::new(1, 1)));
        let program = LineProgram::Whirl { forward: true, delay: 500 };
        chip.say(CycleLine::Prepare(motor, Calibration::None, program));
    }
    chip.say(CycleLine::Start(1));
    chip.run(10_000);
    // A slave that has seen no checksum yet.
    let (remote, slave) = (&mut chip.0, &mut ProgramSlave::new());
    let mut line = Incoming::<LONGEST>::new();
    let ended = |byte| line.receive(Some(byte));
    assert!(CycleLine::Look.to_string().bytes().chain([b'\r']).map(ended).last().unwrap());
    let asked = remote.hold().now();
    slave.obey(&mut line, remote);
    let mut answer = Vec::new();
    while let Some(byte) = slave.next_byte(remote) {
        answer.push(byte);
        let now = remote.hold().now();
        remote.hold().run_until(now + HZ * 87 / 1_000_000);
        remote.poll();
    }
    assert!(remote.hold().now() - asked > 3 * HZ / 1_000, "as long as six steps");
    answer.pop();
    let report = CycleReport::read(&answer).unwrap();
    assert_eq!(report.motors[..3].iter().map(|m| m.position).collect::<Vec<_>>(), [20; 3]);
    // Two questions of the line since the start.
    assert_eq!(report.time / (HZ / 1_000_000), 10_002);
}

#[test]
fn ends_and_faults_are_reported_with_their_times() {
    let legs = legs();
    let stands = [Stand { min: Some(-20), max: None }, Stand::default(), Stand::default()];
    let mut chip = Chip::new(stands, &legs);
    let strategies = Strategies {
        hard_end: AtHardEnd::StopMotor,
        soft_end: AtSoftEnd::StopMotor,
        ..Strategies::CANCEL
    };
    chip.say(CycleLine::Clock(Clock::Deadlines, strategies));
    chip.say(CycleLine::Motor(0, X));
    chip.say(CycleLine::Motor(1, X.between(0, 75_000)));
    chip.say(CycleLine::Position(0, 1_000_000));
    for (motor, count) in [(0, -100), (1, 100)] {
        let program = LineProgram::Steps { count, delay: 1_000 };
        chip.say(CycleLine::Prepare(motor, Calibration::None, program));
    }
    chip.say(CycleLine::Start(1));
    let report = chip.rest();
    let [x, y, _] = [report.motors[0], report.motors[1], report.motors[2]];
    assert_eq!(x.position, 1_000_000 - 20 * 7_500);
    assert_eq!((x.faults, y.faults), (Faults::HARD_END_MIN.bits(), Faults::SOFT_END_MAX.bits()));
    assert_eq!((y.position, y.max), (75_000, Some(75_000)));
    let near = |at: Option<u64>, ms: u64| (ms * 16_000..(ms + 1) * 16_000).contains(&at.unwrap());
    assert!(near(x.fault_at, 20) && near(y.fault_at, 11), "{report:?}");
    assert!(report.error.is_none());
    // The next cycle has none, and starts from there; a motor that takes no part keeps its own.
    chip.say(CycleLine::New);
    let program = LineProgram::Steps { count: 10, delay: 0 };
    chip.say(CycleLine::Prepare(0, Calibration::None, program));
    chip.say(CycleLine::Start(2));
    let report = chip.rest();
    assert_eq!((report.motors[0].faults, report.motors[0].status), (0, 2));
    assert_eq!(report.motors[0].position, 1_000_000 - 10 * 7_500);
    assert_eq!((report.motors[1].fault_at, report.motors[1].status), (None, 0));
}

#[test]
fn a_motor_is_homed_and_its_way_calibrated() {
    let legs = legs();
    let stands = [Stand { min: Some(-50), max: Some(200) }, Stand::default(), Stand::default()];
    let mut chip = Chip::new(stands, &legs);
    chip.say(CycleLine::Motor(0, X.between(0, 1_000_000_000)));
    chip.say(CycleLine::Home(1, Homing::new(0, End::Min, 1_000, 20).delays(600, 2_000)));
    let report = chip.rest();
    assert_eq!((report.home, report.motors[0].position), (2, 0));
    let strategies = Strategies { hard_end: AtHardEnd::StopMotor, ..Strategies::CANCEL };
    chip.say(CycleLine::Clock(Clock::Deadlines, strategies));
    let program = LineProgram::Whirl { forward: true, delay: 600 };
    chip.say(CycleLine::Prepare(0, Calibration::BoundsMax, program));
    chip.say(CycleLine::Start(2));
    let report = chip.rest();
    assert_eq!(report.motors[0].position, 250 * 7_500);
    assert_eq!(report.motors[0].max, Some(250 * 7_500));
    // No switch within the reach.
    chip.say(CycleLine::Motor(1, X));
    chip.say(CycleLine::Home(3, Homing::new(1, End::Min, 10, 5)));
    assert_eq!(chip.rest().home, 3);
    // The homing is given up.
    chip.say(CycleLine::Home(4, Homing::new(1, End::Min, 100_000, 5)));
    chip.run(10_000);
    chip.say(CycleLine::Now(LineAct::Finish));
    assert_eq!(chip.rest().home, 5);
}

#[test]
fn what_is_wrong_is_refused_and_nothing_moves() {
    let legs = legs();
    let mut chip = Chip::new([Stand::default(); 3], &legs);
    assert_eq!(chip.fault(CycleLine::Start(1)), refused(Refusal::Nothing));
    let program = LineProgram::Steps { count: 10, delay: 400 };
    chip.say(CycleLine::Motor(0, X));
    chip.say(CycleLine::Prepare(0, Calibration::None, program));
    let small = refused(Refusal::SmallDelay { motor: 0, needs: 500 });
    assert_eq!(chip.fault(CycleLine::Start(1)), small);
    chip.say(CycleLine::Prepare(0, Calibration::None, program));
    chip.say(CycleLine::New);
    assert_eq!(chip.fault(CycleLine::Start(1)), refused(Refusal::Nothing));
    let pins = MotorPins { codes: [1, 2, 3, 99, MotorPins::NO_PIN] };
    assert_eq!(chip.fault(CycleLine::Wire(0, pins)), Fault::Own(CycleFault::Pin { number: 5 }));
    // A corrupted line, one that is too long, one without a checksum.
    assert_eq!(
        chip.text(":S0,0,10,1000*00"),
        format!("E sum*{:02X}", b"E sum".iter().fold(0, |sum, byte| crc(sum, *byte)))
    );
    assert_eq!(chip.text(&"1".repeat(100)), "E line");
    // A row without a checksum does not come from a master that uses them.
    assert_eq!(chip.text(":S0,0,10,1000"), "E sum");
    assert_eq!(chip.text("F"), "R");
    assert_eq!(chip.text(":S0,0,10,1000"), "Y");
    assert_eq!(chip.text(":S0,3,10,1000"), "E range 2,0,2");
    // While a cycle runs, other lines are refused.
    chip.say(CycleLine::Start(1));
    chip.say(CycleLine::Start(1));
    let running = Fault::Busy;
    for line in [
        CycleLine::New,
        CycleLine::Start(2),
        CycleLine::Motor(1, X),
        CycleLine::Wire(1, MotorPins::NONE),
        CycleLine::Position(0, 1),
        CycleLine::Leg(0, LEGS[0]),
        CycleLine::Prepare(1, Calibration::None, program),
        CycleLine::Clock(Clock::Deadlines, Strategies::CANCEL),
        CycleLine::Home(2, Homing::new(1, End::Min, 1, 1)),
    ] {
        assert_eq!(chip.fault(line), running, "{line}");
    }
    let report = chip.rest();
    assert_eq!(report.motors[0].position, 75_000);
    // The same number again is the same cycle, which is over.
    chip.say(CycleLine::Start(1));
    chip.run(20_000);
    assert_eq!(chip.look().motors[0].position, 75_000);
    let about =
        "stepwright-cycle virtual hz=16000000 axes=3 legs=24 late=0 can=sum,brakes,home,tick";
    assert_eq!(chip.text("?"), about);
}

/// A board on which each call of the main loop takes 3 µs, during which the motors continue.
struct Slow<'a>(Host<'a>);

impl<'a> CycleHold<'a, 3> for Slow<'a> {
    type Timer = <Host<'a> as CycleHold<'a, 3>>::Timer;
    type Drive = <Host<'a> as CycleHold<'a, 3>>::Drive;
    type Io = <Host<'a> as CycleHold<'a, 3>>::Io;

    fn with<R>(
        &mut self,
        ask: impl FnOnce(&mut Cycle<'a, Self::Timer, Self::Drive, Self::Io, 3>) -> R,
    ) -> R {
        let now = self.0.now();
        self.0.run_until(now + 48);
        self.0.with(ask)
    }

    fn wire(&mut self, motor: u8, pins: &MotorPins) -> Result<(), u8> {
        self.0.wire(motor, pins)
    }

    fn about(&self) -> (Text, Text) {
        self.0.about()
    }
}

/// The answer to a line.
fn asked<'a>(chip: &mut Remote<'a, Slow<'a>, 3>, line: CycleLine) -> String {
    say_to(chip, &mut ProgramSlave::new(), &line.to_string())
}

/// A switch may end the cycle at any point of the main loop.
#[test]
fn a_fault_in_any_moment_is_reported() {
    for phase in 0..60 {
        let legs = legs();
        let stands = [Stand { min: Some(-5), max: None }, Stand::default(), Stand::default()];
        let board = virtual_board([Motor::new(1, 1); 3], stands, Clock::Deadlines);
        let mut chip = Remote::new(Slow(board), &legs);
        let program = LineProgram::Steps { count: -100, delay: 500 };
        for line in [
            CycleLine::Motor(0, X),
            CycleLine::Prepare(0, Calibration::None, program),
            CycleLine::Start(1),
        ] {
            assert_eq!(asked(&mut chip, line), "Y", "{line}");
        }
        let begin = chip.hold().0.now() + phase * 7;
        chip.hold().0.run_until(begin);
        let report = loop {
            chip.poll();
            let answer = asked(&mut chip, CycleLine::Look);
            let report = CycleReport::read(answer.as_bytes()).expect(&answer);
            if !report.running {
                break report;
            }
        };
        assert_eq!(report.motors[0].faults, Faults::HARD_END_MIN.bits(), "{phase}");
    }
}
