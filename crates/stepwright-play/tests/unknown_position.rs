//! Cycles on a board that has lost a position by a kill, or is lost itself: a board with the program `cycles`, in
//! this process.

use std::cell::{Cell, RefCell};
use std::fmt::Display;
use std::io;
use std::rc::Rc;
use std::time::Duration;

use stepwright::Rate;
use stepwright_cycle::line::{CycleLine, LineProgram};
use stepwright_cycle::{Calibration, Clock, Leg, Motor};
use stepwright_host::link::Link;
use stepwright_host::link::simulated::{VirtualLink, VirtualProgram};
use stepwright_host::programs::CycleSession;
use stepwright_play::cycle::{CyclesOnBoard, PlayText};
use stepwright_play::page::play_cycles_on;
use stepwright_play::stream::{PlayEnd, PlayOrder};
use stepwright_play::{PlayFormat, PlayVoice};
use stepwright_sim::{CycleBoard, CycleLineBoard, Stand};

const HZ: u32 = 16_000_000;
/// Ticks of a byte at 115,200 baud.
const BYTE: u64 = 1_389;

/// Keeps the notes.
#[derive(Default)]
struct Notes(RefCell<String>);

impl PlayVoice for Notes {
    fn result(&self, _: &dyn Display) {}
    fn note(&self, note: &dyn Display) {
        self.0.borrow_mut().push_str(&note.to_string());
    }
    fn asked(&self) -> bool {
        false
    }
}

/// A line that can be unplugged.
struct Plug<L> {
    link: L,
    out: Rc<Cell<bool>>,
}

impl<L> Plug<L> {
    fn is_in(&self) -> io::Result<()> {
        if self.out.get() { Err(io::ErrorKind::BrokenPipe.into()) } else { Ok(()) }
    }
}

impl<L: Link> Link for Plug<L> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.is_in().and_then(|()| self.link.write(bytes))
    }
    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        self.is_in().and_then(|()| self.link.read(buffer, limit))
    }
    fn now(&self) -> Duration {
        self.link.now()
    }
    fn name(&self) -> String {
        self.link.name()
    }
    fn rest(&mut self, time: Duration) {
        self.link.rest(time);
    }
}

fn board() -> CycleSession {
    board_by(&Rc::default())
}

/// A board that is unplugged when this is set.
fn board_by(out: &Rc<Cell<bool>>) -> CycleSession {
    let (rate, stand) = (Rate::from_hz(HZ).unwrap(), Stand { min: None, max: None });
    let motors: CycleBoard<'static, (), 3> =
        CycleBoard::new([Motor::new(1, 500); 3], [stand; 3], Clock::Deadlines, rate, ());
    let legs = (0..24).map(|_| Cell::new(Leg::Steps { count: 0, delay: 0 }));
    let legs: &'static [Cell<Leg>] = legs.collect::<Vec<_>>().leak();
    let board = CycleLineBoard::new(motors, legs);
    let link = VirtualLink::new(VirtualProgram::new(board, HZ, BYTE), true);
    CycleSession::on(Box::new(Plug { link, out: out.clone() })).unwrap()
}

/// Kills a motor in a whirl.
fn killed(mut board: CycleSession) -> CycleSession {
    let whirl = LineProgram::Whirl { forward: true, delay: 1_000 };
    let rows = [
        CycleLine::New,
        CycleLine::Motor(0, Motor::new(1, 500)),
        CycleLine::Prepare(0, Calibration::None, whirl),
        CycleLine::Start(77),
    ];
    for row in rows {
        board.say(&row).unwrap();
    }
    assert_eq!(board.session().say(b"K").unwrap().as_deref(), Some("Y"));
    board
}

/// The notes while a board plays a file.
fn play(board: CycleSession, position: &str, calibrate: &str) -> String {
    let text = format!(
        "[[motor]]\nname = \"X\"\nstep = 1\nsmallest-delay-us = 500\n{position}\n\
         [[cycle]]\nmove.X = {{ steps = 9, delay-us = 1000{calibrate} }}\n"
    );
    let text = PlayText::named("unknown.toml", &text);
    let mut plan = stepwright_cyclefile::read(&text).unwrap();
    let mut stages = std::mem::take(&mut plan.stages);
    let notes = Notes::default();
    let mut player = CyclesOnBoard::new(board, &plan, &text, PlayFormat::Json, &notes, 60);
    player.play(&mut stages).unwrap();
    notes.0.take()
}

#[test]
fn a_position_that_is_only_counted_is_told() {
    let told = "the position of X is unknown since a kill or a reset, and counted from ";
    assert_eq!(play(board(), "", ""), "");
    let notes = play(killed(board()), "", "");
    assert!(notes.starts_with(told), "{notes:?}");
    assert_eq!(play(killed(board()), "position = 0", ""), "");
}

/// A board that is lost while it is told to stop may go on: the run has failed, and was not stopped.
#[test]
fn a_board_that_is_lost_has_not_been_stopped() {
    let text = "[[motor]]\nname = \"X\"\nstep = 1\nsmallest-delay-us = 500\n\
                [[cycle]]\nmove.X = { steps = 9000, delay-us = 1000 }\n";
    for (lost, stop) in [(false, true), (true, true), (true, false)] {
        for kill in [false, true] {
            let (out, order) = (Rc::default(), PlayOrder::default());
            let ended =
                play_cycles_on(board_by(&out), "lost.toml", text, &order, &mut |_, _, _| {
                    match (stop, kill) {
                        (true, true) => order.kill(),
                        (true, false) => order.stop(),
                        (false, _) => {}
                    }
                    out.set(lost);
                });
            match ended {
                Ok(end) if !lost => {
                    assert_eq!(end, if kill { PlayEnd::Killed } else { PlayEnd::Stopped });
                }
                Err(why) if lost => assert!(!why.interrupted, "{why:?}"),
                ended => panic!("lost {lost}, kill {kill}: {ended:?}"),
            }
        }
    }
}
