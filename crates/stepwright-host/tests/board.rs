//! Orders on a virtual board, and their outcomes.

use std::sync::mpsc::channel;
use std::time::Duration;

use crate::guests::Guest;
use stepwright::{Accel, Speed};
use stepwright_host::guests::GuestLine;
use stepwright_host::link::Link;
use stepwright_host::link::lossy::{Harm, Lossy};
use stepwright_host::link::simulated::{VirtualLink, VirtualUno};
use stepwright_host::motion::Action;
use stepwright_host::{Board, Error, LinkError, MotionLimits, Outcome, Played};
use stepwright_protocol::{
    AxisId, Command, Direction, Distance, Order, Ramp, Refusal, Script, Selection, Setting, Stop,
    Travel, Value,
};

fn motion(top: u32, accel: u32) -> MotionLimits {
    MotionLimits::new(Speed::from_steps(top).unwrap(), Accel::from_steps(accel).unwrap())
}

fn uno() -> Board {
    Board::virtual_uno(true).unwrap()
}

#[test]
fn an_axis_goes_where_it_is_sent() {
    let mut board = uno();
    let mut x = board.axis(1).unwrap();
    assert_eq!(x.move_to(400, &MotionLimits::default()).unwrap(), Outcome::Reached { at: 400 });
    assert_eq!(x.move_by(-150, &MotionLimits::default()).unwrap(), Outcome::Reached { at: 250 });
    assert_eq!(x.move_to(250, &MotionLimits::default()).unwrap(), Outcome::Reached { at: 250 });
    x.set_zero().unwrap();
    assert_eq!(x.position().unwrap(), Some(0));
    assert_eq!(board.axis(3).unwrap().position().unwrap(), Some(0));
    assert!(matches!(board.axis(4), Err(Error::NoAxis { axes: 3 })));
}

/// By v²/2a each ramp has 250 steps: 3 s at 1,000 steps/s, with two ramps.
#[test]
fn a_run_lasts_as_long_as_it_was_given() {
    let mut board = uno();
    let mut x = board.axis(1).unwrap();
    let fast = motion(1_000, 2_000);
    let outcome = x.run(Direction::Backward, &fast, Duration::from_secs(2)).unwrap();
    let Outcome::Reached { at } = outcome else { panic!("{outcome}") };
    // 250 up, 1,500 at top speed, 250 down. A look is at most 50 ms late, and the lines take a few ms.
    assert!((-2_080..=-1_990).contains(&at), "{at}");
}

#[test]
fn a_travel_is_changed_and_stopped_on_its_way() {
    let mut board = uno();
    let mut x = board.axis(1).unwrap();
    x.travel(5_000, &motion(1_000, 2_000)).unwrap();
    assert!(matches!(x.travel(5, &motion(1_000, 2_000)), Err(Error::Moving)));
    x.retarget(3_000).unwrap();
    x.set_top_speed(Speed::from_steps(2_000).unwrap()).unwrap();
    assert_eq!(x.wait(|_| Action::GoOn).unwrap(), Outcome::Reached { at: 3_000 });
    x.travel(5_000, &motion(1_000, 2_000)).unwrap();
    let stopped = x.stop().unwrap();
    assert!(
        matches!(stopped, Outcome::Stopped { at: 3_001..8_000, reason: Some(Stop::Soft) }),
        "{stopped}"
    );
    let refused = x.retarget(7).unwrap_err();
    assert!(matches!(refused, Error::Refused { reason: Some(Refusal::NoTravel), .. }));
}

/// Nothing was cut short: the axis is where its last order took it, or where it was called 0.
#[test]
fn a_stop_at_rest_stops_nothing() {
    let mut board = uno();
    let mut x = board.axis(1).unwrap();
    assert_eq!(x.stop().unwrap(), Outcome::Reached { at: 0 });
    let there = x.move_to(400, &motion(1_000, 2_000)).unwrap();
    assert_eq!((there, x.stop().unwrap()), (Outcome::Reached { at: 400 }, there));
    x.set_zero().unwrap();
    assert_eq!(x.stop().unwrap(), Outcome::Reached { at: 0 });
    x.travel(5_000, &motion(1_000, 2_000)).unwrap();
    let stopped = x.stop().unwrap();
    assert!(matches!(stopped, Outcome::Stopped { reason: Some(Stop::Soft), .. }), "{stopped}");
    assert_eq!(x.stop().unwrap(), stopped);
}

/// The last target counts, whatever was expected before.
#[test]
fn a_travel_is_expected_where_it_was_sent_last() {
    let mut board = uno();
    let way = motion(1_000, 2_000);
    let mut x = board.axis(1).unwrap();
    x.travel(5_000, &way).unwrap();
    x.retarget_by(3_000).unwrap();
    assert_eq!(x.wait(|_| Action::GoOn).unwrap(), Outcome::Reached { at: 3_000 });
    x.travel(5_000, &way).unwrap();
    let mut say = Some(Action::Say(Command::Retarget(Distance::new(-1_000))));
    let ended = x.wait(|_| say.take().unwrap_or(Action::GoOn)).unwrap();
    assert_eq!(ended, Outcome::Reached { at: 2_000 });
}

/// The target of `retarget` is a position, and the end of `travel` is known, wherever the axis began.
#[test]
fn a_target_is_a_position() {
    let mut board = uno();
    let way = motion(1_000, 2_000);
    let mut x = board.axis(1).unwrap();
    assert_eq!(x.move_to(2_000, &way).unwrap(), Outcome::Reached { at: 2_000 });
    x.travel(4_000, &way).unwrap();
    assert_eq!(x.wait(|_| Action::GoOn).unwrap(), Outcome::Reached { at: 6_000 });
    x.travel(-4_000, &way).unwrap();
    x.retarget(500).unwrap();
    assert_eq!(x.wait(|_| Action::GoOn).unwrap(), Outcome::Reached { at: 500 });
    x.travel(4_000, &way).unwrap();
    assert!(matches!(x.retarget(1 << 40), Err(Error::TooFar { .. })));
    x.retarget_by(-700).unwrap();
    assert_eq!(x.wait(|_| Action::GoOn).unwrap(), Outcome::Reached { at: -200 });
}

/// Another program, since gone, began the travel.
#[test]
fn a_travel_of_another_program_has_no_known_begin() {
    let mut board = uno();
    let travel = Travel::By(Distance::new(3_000));
    let ramp = Ramp::Accel(Accel::from_steps(2_000).unwrap());
    let top = Speed::from_steps(1_000).unwrap();
    let order = Order { start: Speed::ZERO, top, up: ramp, down: ramp, jerk: None, travel };
    let orders = [(AxisId::FIRST, order)];
    let lines: Vec<_> = Script::new(&orders).unwrap().collect();
    assert_eq!(board.session().play(&lines).unwrap(), Played::Accepted);
    let mut x = board.axis(1).unwrap();
    assert!(matches!(x.retarget(2_000), Err(Error::BeginUnknown)));
    assert_eq!(x.wait(|_| Action::GoOn).unwrap(), Outcome::Reached { at: 3_000 });
}

#[test]
fn our_target_counts_after_that_of_another_program() {
    let mut board = uno();
    board.axis(1).unwrap().travel(5_000, &motion(1_000, 2_000)).unwrap();
    let (answer, answered) = channel();
    let line = GuestLine { line: b"@+3000".to_vec(), selection: Selection::FIRST, answer };
    board.session().serve(Box::new(Guest(Some(line))));
    board.session().pause(Duration::from_millis(100)).unwrap();
    assert_eq!(answered.recv().unwrap().as_deref(), Some("Y"));
    let mut x = board.axis(1).unwrap();
    x.retarget(4_000).unwrap();
    assert_eq!(x.wait(|_| Action::GoOn).unwrap(), Outcome::Reached { at: 4_000 });
}

#[test]
fn a_guest_hears_why_an_order_is_refused() {
    let reason = Some(Refusal::Line);
    let words = Error::Refused { line: Command::Program, reason }.to_string();
    assert!(words.contains("a program that holds its port"), "{words}");
}

#[test]
fn a_kill_loses_the_position() {
    let mut board = uno();
    board.axis(1).unwrap().travel(5_000, &MotionLimits::default()).unwrap();
    board.session().pause(Duration::from_millis(200)).unwrap();
    board.kill().unwrap();
    let mut x = board.axis(1).unwrap();
    assert_eq!(x.position().unwrap(), None);
    assert!(matches!(x.move_by(1, &MotionLimits::default()), Err(Error::Uncertain)));
    x.set_zero().unwrap();
    assert_eq!(x.move_by(1, &MotionLimits::default()).unwrap(), Outcome::Reached { at: 1 });
}

#[test]
fn what_is_refused_says_why_and_moves_nothing() {
    let mut board = uno();
    let mut x = board.axis(1).unwrap();
    let why = |error| match error {
        Error::Refused { reason, .. } => reason,
        other => panic!("{other}"),
    };
    let fast = x.move_by(9_000_000, &motion(300_000, 40_000)).unwrap_err();
    assert_eq!(why(fast), Some(Refusal::TooFast));
    let steep = x.move_by(90_000, &motion(50_000, 3_000_000)).unwrap_err();
    assert_eq!(why(steep), Some(Refusal::TooSteep));
    let far = x.move_by(1 << 40, &MotionLimits::default()).unwrap_err();
    assert!(matches!(far, Error::TooFar { .. }));
    assert_eq!(x.position().unwrap(), Some(0));
    assert!(matches!(
        x.home(&MotionLimits::default(), &MotionLimits::default(), 9, 9),
        Err(Error::NoSwitch)
    ));
}

/// For each byte of an order, lost or spoiled in either direction, the motor reaches its target.
#[test]
fn noise_moves_nothing_by_mistake() {
    for n in 0..200 {
        for harm in [Harm::LoseThere(n), Harm::LoseBack(n), Harm::SpoilThere(n), Harm::SpoilBack(n)]
        {
            let line = VirtualLink::new(VirtualUno::new(), true);
            let mut board = Board::on(Box::new(Lossy::new(line, harm))).unwrap();
            let mut x = board.axis(1).unwrap();
            let outcome = x.move_to(48, &motion(3_000, 90_000));
            assert_eq!(outcome.unwrap(), Outcome::Reached { at: 48 }, "{harm:?}");
        }
    }
}

/// On a line that is cut during an order, the error claims only what is known.
#[test]
fn a_cut_line_is_said_so() {
    for n in 0..90 {
        let line = VirtualLink::new(VirtualUno::new(), true);
        match Board::on(Box::new(Lossy::new(line, Harm::CutBack(n)))) {
            Err(error) => assert!(matches!(error, Error::Lost { moving: false, .. }), "{error}"),
            Ok(mut board) => {
                let ended = board.axis(1).unwrap().move_to(480, &MotionLimits::default());
                assert!(matches!(ended, Err(Error::Lost { .. })), "{n}: {ended:?}");
            }
        }
    }
}

/// On a line that is cut while a motor moves, every error says that a motor may be moving.
#[test]
fn a_line_that_is_lost_on_the_way_says_that_a_motor_may_move() {
    let line = VirtualLink::new(VirtualUno::new(), true);
    let mut board = Board::on(Box::new(Lossy::new(line, Harm::CutBack(400)))).unwrap();
    let mut x = board.axis(1).unwrap();
    x.travel(90_000, &MotionLimits::default()).unwrap();
    let lost = (0..99).find_map(|_| x.position().err()).unwrap();
    assert!(matches!(lost, Error::Lost { moving: true, .. }), "{lost}");
    assert!(matches!(x.retarget_by(5), Err(Error::Lost { moving: true, .. })));
}

/// A silent line, or one that is gone.
struct Dead(Option<std::io::ErrorKind>, Duration);

impl Link for Dead {
    fn write(&mut self, _: &[u8]) -> std::io::Result<()> {
        Ok(())
    }
    fn read(&mut self, _: &mut [u8], limit: Duration) -> std::io::Result<usize> {
        self.1 += limit;
        self.0.map_or(Ok(0), |kind| Err(kind.into()))
    }
    fn now(&self) -> Duration {
        self.1
    }
    fn name(&self) -> String {
        "nothing".to_owned()
    }
}

#[test]
fn a_line_without_a_board_is_told_from_one_that_is_gone() {
    let silent = Board::on(Box::new(Dead(None, Duration::ZERO))).err().unwrap();
    assert!(matches!(silent, Error::Lost { trouble: LinkError::Silent, moving: false }));
    let gone = std::io::ErrorKind::BrokenPipe;
    let gone = Board::on(Box::new(Dead(Some(gone), Duration::ZERO))).err().unwrap();
    assert!(matches!(gone, Error::Lost { trouble: LinkError::Gone(_), moving: false }));
}

#[test]
fn settings_go_through_the_session() {
    let mut board = uno();
    let value = Value::new(Setting::MaxSpeed, 500).unwrap();
    let said = board.session().ask(Command::Set(value)).unwrap();
    assert_eq!(said, stepwright_protocol::Reply::Yes);
    let refused = board.axis(1).unwrap().move_by(9, &motion(501, 9_000)).unwrap_err();
    assert!(matches!(refused, Error::Refused { reason: Some(Refusal::TooFast), .. }));
}

/// `fn main() -> Result<(), Error>` shows an error by its `Debug`.
#[test]
fn an_error_that_ends_a_program_is_said_in_words() {
    let error = uno().axis(4).err().unwrap();
    assert_eq!(format!("{error:?}"), "no such axis: give 1 to 3");
}
