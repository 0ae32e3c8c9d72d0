//! Boards with other programs than the controller, driven from a PC: rows that they obey or refuse, and which
//! program answers.

use std::cell::Cell;
use std::time::Duration;

use stepwright::Rate;
use stepwright_austin::line::{Line, Refused};
use stepwright_austin::{LawName, Recipe};
use stepwright_cycle::line::{CycleFault, CycleLine, LineProgram};
use stepwright_cycle::{Calibration, Clock, Leg, Motor, Refusal};
use stepwright_host::link::simulated::{VirtualLink, VirtualProgram, VirtualUno};
use stepwright_host::programs::{CycleSession, LawSession, RowProblem, TimedSession};
use stepwright_host::{Outcome, Session};
use stepwright_protocol::{AxisId, Fault};
use stepwright_sim::timed::TimedLineBoard;
use stepwright_sim::{CycleBoard, CycleLineBoard, Description, LawBoard, Queues, Stand};
use stepwright_timed::line::Unwired;

const HZ: u32 = 16_000_000;
/// The time of a byte on the line at 115,200 baud, in ticks.
const BYTE: u64 = 1_388;

fn laws() -> LawSession {
    let queues = Box::leak(Box::<Queues>::default());
    let board: LawBoard<'_, ()> = LawBoard::new(queues, Description::uno(), ());
    let link = VirtualLink::new(VirtualProgram::new(board, HZ, BYTE), true);
    LawSession::on(Box::new(link)).unwrap()
}

fn timed() -> TimedSession {
    let link = VirtualLink::new(VirtualProgram::new(TimedLineBoard::uno(), HZ, BYTE), true);
    TimedSession::on(Box::new(link)).unwrap()
}

fn cycles() -> CycleSession {
    let rate = Rate::from_hz(HZ).unwrap();
    let stand = Stand { min: None, max: None };
    let motors: CycleBoard<'static, (), 3> =
        CycleBoard::new([Motor::new(1, 500); 3], [stand; 3], Clock::Deadlines, rate, ());
    let legs = (0..24).map(|_| Cell::new(Leg::Steps { count: 0, delay: 0 }));
    let legs: &'static [Cell<Leg>] = legs.collect::<Vec<_>>().leak();
    let board = CycleLineBoard::new(motors, legs);
    let link = VirtualLink::new(VirtualProgram::new(board, HZ, BYTE), true);
    CycleSession::on(Box::new(link)).unwrap()
}

#[test]
fn a_law_moves_there_and_back_and_stops_on_the_way() {
    let mut board = laws();
    assert!(board.laws().any(|law| law == LawName::AustinFixed));
    board.set_law(&Recipe::AustinFixed(5_000, 1_000), &[]).unwrap();
    assert_eq!(board.move_by(400).unwrap(), Outcome::Reached { at: 400 });
    assert_eq!(board.move_by(-150).unwrap(), Outcome::Reached { at: 250 });
    assert_eq!(board.stop().unwrap(), Outcome::Reached { at: 250 });
    // Half a second at up to 1,000 steps/s, and the ramp to rest.
    let Outcome::Reached { at } = board.run(true, Duration::from_millis(500)).unwrap() else {
        panic!("it was not braked")
    };
    assert!((300..1_250).contains(&at), "{at}");
    assert_eq!(board.session().rest_position(AxisId::FIRST).unwrap(), Some(at));
    board.begin(&Line::Run(false), Some(at)).unwrap();
    board.pause(Duration::from_millis(300)).unwrap();
    let Outcome::Stopped { at: stop, .. } = board.stop().unwrap() else {
        panic!("a stop is a stop")
    };
    assert!((at - 1_250..at).contains(&stop), "{at} {stop}");
}

#[test]
fn a_law_that_is_too_fast_is_refused_with_the_delay_that_would_do() {
    let mut board = laws();
    let problem = board.set_law(&Recipe::AustinFixed(5_000, 1), &[]).unwrap_err();
    let RowProblem::Refused { reason: Fault::Own(Refused::Fast(ticks)), .. } = problem else {
        panic!("{problem}")
    };
    board.set_law(&Recipe::AustinFixed(5_000, ticks), &[]).unwrap();
}

#[test]
fn a_cycle_is_played_to_its_end_and_can_be_finished_on_its_way() {
    let mut board = cycles();
    assert_eq!((board.motors(), board.legs(), board.hz()), (3, 24, HZ));
    let steps = |count| LineProgram::Steps { count, delay: 1_000 };
    let prepare = |motor, count| CycleLine::Prepare(motor, Calibration::None, steps(count));
    for line in [CycleLine::New, prepare(0, -400), prepare(2, 700)] {
        board.say(&line).unwrap();
    }
    let mut looks = 0;
    let report = board
        .play(|_| {
            looks += 1;
            true
        })
        .unwrap();
    assert_eq!([0, 1, 2].map(|n: usize| report.motors[n].position), [-400, 0, 700]);
    // 0.7 s, with ten looks a second.
    assert!((5..=9).contains(&looks), "{looks}");
    for line in [CycleLine::New, prepare(0, 10_000)] {
        board.say(&line).unwrap();
    }
    let report = board.play(|report| report.motors[0].position < -200).unwrap();
    let at = report.motors[0].position;
    assert!(!report.running && (-200..9_600).contains(&at), "{at}");
}

#[test]
fn a_cycle_that_nobody_prepared_is_refused() {
    let problem = cycles().play(|_| true).unwrap_err();
    let reason = Fault::Own(CycleFault::Refused(Refusal::Nothing));
    assert!(
        matches!(&problem, RowProblem::Refused { reason: why, .. } if *why == reason),
        "{problem}"
    );
}

#[test]
fn a_timer_without_a_motor_is_refused() {
    let problem = timed().look(7).unwrap_err();
    // A refusal of a report shows as an answer that is no report.
    assert!(matches!(problem, RowProblem::Nonsense { .. }), "{problem}");
    let mut board = timed();
    assert!(board.timers().eq([1]));
    board.stop(1).unwrap();
    assert!(board.stop(7).is_err());
    let problem = board.say(&stepwright_timed::line::Line::Check(7, 10)).unwrap_err();
    assert!(
        matches!(problem, RowProblem::Refused { reason: Fault::Own(Unwired::Timer), .. }),
        "{problem}"
    );
}

#[test]
fn a_controller_is_another_program_and_a_program_is_not_another() {
    let link = VirtualLink::new(VirtualUno::new(), true);
    let Err(problem) = CycleSession::on(Box::new(link)) else { panic!("it plays no cycles") };
    assert!(matches!(&problem, RowProblem::OtherProgram(about) if about == "stepwright"));
    let link = VirtualLink::new(VirtualProgram::new(TimedLineBoard::uno(), HZ, BYTE), true);
    let mut session = Session::new(Box::new(link));
    let about = session.meet_program().unwrap();
    assert!(LawSession::of(session, about).is_err());
}

/// A calibration may make no step, or end before the switch.
#[test]
fn a_doubt_ends_when_the_position_is_set() {
    let mut board = cycles();
    let whirl = LineProgram::Whirl { forward: true, delay: 1_000 };
    let mut number = 0;
    let mut begin = |board: &mut CycleSession, calibration, program| {
        number += 1;
        let prepare = CycleLine::Prepare(0, calibration, program);
        for row in [CycleLine::New, prepare, CycleLine::Start(number)] {
            board.say(&row).unwrap();
        }
    };
    begin(&mut board, Calibration::None, whirl);
    assert_eq!(board.session().say(b"K").unwrap().as_deref(), Some("Y"));
    let steps = LineProgram::Steps { count: -9, delay: 1_000 };
    for calibration in [Calibration::None, Calibration::BoundsMax, Calibration::StartMin] {
        begin(&mut board, calibration, steps);
        board.pause(Duration::from_secs(1)).unwrap();
        assert!(board.look().unwrap().motors[0].uncertain, "{calibration:?}");
        assert_eq!(board.session().rest_position(AxisId::FIRST).unwrap(), None, "{calibration:?}");
    }
    board.say(&CycleLine::Position(0, 70)).unwrap();
    assert!(!board.look().unwrap().motors[0].uncertain);
    assert_eq!(board.session().rest_position(AxisId::FIRST).unwrap(), Some(70));
}
