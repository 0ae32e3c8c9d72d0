//! Each byte of an order is lost or spoiled on its way: the motor makes exactly the ordered steps or none, and
//! the reports are true.

use std::cell::RefCell;
use std::io;
use std::rc::Rc;
use std::time::Duration;

use stepwright::Control;
use stepwright_host::Session;
use stepwright_host::link::Link;
use stepwright_host::link::lossy::{Harm, Lossy};
use stepwright_host::link::simulated::{VirtualLink, VirtualUno};
use stepwright_host::motion::{Action, Ended, RestPlace, Start};
use stepwright_protocol::{
    AxisId, Command, Distance, Info, Order, Ramp, RampSteps, Reply, Script, Selection, Travel,
};

/// A link to a board that the test also looks at.
#[derive(Clone)]
struct Shared(Rc<RefCell<VirtualLink<VirtualUno>>>);

impl Link for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.borrow_mut().write(bytes)
    }
    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        self.0.borrow_mut().read(buffer, limit)
    }
    fn now(&self) -> Duration {
        self.0.borrow().now()
    }
    fn name(&self) -> String {
        "the board".to_owned()
    }
}

/// The result of an order over a harmed line.
struct Went {
    /// The result that the program reports.
    said: Result<i64, String>,
    /// The true positions.
    is: [Option<i64>; 3],
    /// The simulated time.
    took: Duration,
}

const STEPS: i32 = 48;

fn order() -> Order {
    let speed = |steps| stepwright::Speed::from_steps(steps).unwrap();
    let ramp = Ramp::Steps(RampSteps::new(9).unwrap());
    let travel = Travel::By(Distance::new(STEPS));
    Order { start: speed(500), top: speed(1_500), up: ramp, down: ramp, jerk: None, travel }
}

/// Moves a motor as a program does.
fn say(session: &mut Session, axis: AxisId) -> Result<i64, String> {
    say_order(session, axis, &order())
}

fn say_order(session: &mut Session, axis: AxisId, order: &Order) -> Result<i64, String> {
    let lines: Vec<_> = Script::new(&[(axis, *order)]).unwrap().collect();
    session.meet().map_err(|trouble| trouble.to_string())?;
    let from = session.rest_position(axis).map_err(|trouble| trouble.to_string())?;
    session.begin(axis, order, &lines, from).map_err(|not| format!("{not:?}"))?;
    let watched = session.watch(axis, None, |_, _| Action::GoOn);
    match session.conclude(axis, watched) {
        Ended { end: RestPlace::At(at), .. } => Ok(at),
        Ended { adrift, .. } => Err(format!("{adrift:?}")),
    }
}

fn go(axis: AxisId, harm: Harm) -> Went {
    let board = Shared(Rc::new(RefCell::new(VirtualLink::new(VirtualUno::new(), true))));
    let mut session = Session::new(Box::new(Lossy::new(board.clone(), harm)));
    let said = say(&mut session, axis);
    let mut link = board.0.borrow_mut();
    let took = link.now();
    let board = link.board().board();
    while board.is_busy() {
        board.run_until(board.now() + 16_000);
    }
    Went { said, is: [0, 1, 2].map(|axis| board.position(axis)), took }
}

/// A bit more than the bytes in either direction of an undisturbed order.
const BYTES: usize = 250;

fn at(axis: u8, position: i64) -> [Option<i64>; 3] {
    let mut all = [Some(0); 3];
    all[usize::from(axis) - 1] = Some(position);
    all
}

fn each(harms: &[fn(usize) -> Harm], check: impl Fn(Harm, u8, Went)) {
    for number in [1, 2] {
        let axis = AxisId::numbered(number).unwrap();
        for n in 0..BYTES {
            for harm in harms {
                check(harm(n), number, go(axis, harm(n)));
            }
        }
    }
}

#[test]
fn a_spoiled_byte_or_a_lost_answer_is_made_good() {
    each(&[Harm::SpoilThere, Harm::SpoilBack, Harm::LoseBack], |harm, axis, went| {
        assert_eq!(went.is, at(axis, STEPS.into()), "{harm:?}");
        assert_eq!(went.said, Ok(STEPS.into()), "{harm:?}");
        assert!(went.took < Duration::from_secs(3), "{harm:?} {:?}", went.took);
    });
}

/// A line that has lost a byte is invalid, or does not fit its checksum.
#[test]
fn a_lost_byte_is_made_good() {
    each(&[Harm::LoseThere], |harm, axis, went| {
        assert_eq!(went.is, at(axis, STEPS.into()), "{harm:?}");
        assert_eq!(went.said, Ok(STEPS.into()), "{harm:?}");
    });
}

/// Also a digit that becomes another digit.
#[test]
fn a_flipped_bit_is_made_good() {
    // The bits that turn digits into digits, and every bit in turn.
    each(
        &[
            |n| Harm::FlipThere(8 * n),
            |n| Harm::FlipThere(8 * n + 1),
            |n| Harm::FlipThere(8 * n + 2 + n % 6),
        ],
        |harm, axis, went| {
            assert_eq!(went.is, at(axis, STEPS.into()), "{harm:?}");
            assert_eq!(went.said, Ok(STEPS.into()), "{harm:?}");
            assert!(went.took < Duration::from_secs(3), "{harm:?} {:?}", went.took);
        },
    );
}

/// A line that is harmless twice is repeated if the board received another one.
#[test]
fn a_question_is_asked_again_when_it_arrived_damaged() {
    let axis = AxisId::FIRST;
    // F, ?, and then I1 and V1 with their checksums.
    for bit in 0..8 * 17 {
        let board = VirtualLink::new(VirtualUno::new(), true);
        let mut session = Session::new(Box::new(Lossy::new(board, Harm::FlipThere(bit))));
        session.meet().unwrap();
        assert_eq!(session.ask(Command::Zero(axis)).unwrap(), Reply::Yes, "{bit}");
        assert_eq!(session.ask(Command::Position(axis)).unwrap(), Reply::Position(0), "{bit}");
    }
}

/// The first lines have no checksum yet: what they say of the board is true all the same.
#[test]
fn a_board_is_known_in_spite_of_noise() {
    let harms: [fn(usize) -> Harm; 2] = [Harm::FlipThere, Harm::FlipBack];
    for bit in 0..8 * BYTES {
        for harm in harms {
            let board = VirtualLink::new(VirtualUno::new(), true);
            let mut session = Session::new(Box::new(Lossy::new(board, harm(bit))));
            session.meet().unwrap();
            assert!(session.talk().has_sums(), "{:?}", harm(bit));
            let fixed = |info: Info| (info.version, info.axes, info.max, info.can);
            let met = session.info().copied().map(fixed);
            assert_eq!(met, session.ask_info().unwrap().map(fixed), "{:?}", harm(bit));
        }
    }
}

#[test]
fn a_cut_line_is_noticed_and_never_doubles_a_travel() {
    each(&[Harm::CutThere, Harm::CutBack], |harm, axis, went| {
        assert!([at(axis, 0), at(axis, STEPS.into())].contains(&went.is), "{harm:?} {:?}", went.is);
        if went.said.is_ok() {
            assert_eq!(went.is, at(axis, STEPS.into()), "{harm:?}");
        }
        assert!(went.took < Duration::from_secs(10), "{harm:?} {:?}", went.took);
    });
}

#[test]
fn in_lasting_noise_nothing_false_is_said() {
    let mut arrived = 0;
    for seed in 0..400 {
        let axis = 1 + (seed % 2) as u8;
        let went = go(AxisId::numbered(axis).unwrap(), Harm::Noise(seed));
        let whole = at(axis, STEPS.into());
        assert!([at(axis, 0), whole].contains(&went.is), "{seed} {:?}", went.is);
        if let Ok(said) = went.said {
            assert_eq!((said, went.is), (STEPS.into(), whole), "{seed}");
            arrived += 1;
        }
    }
    // Nearly every order is carried out in spite of the noise.
    assert!(arrived > 300, "{arrived}");
}

/// Moves two motors together as a program does, and returns the reported positions at rest.
fn say_together(session: &mut Session) -> Result<Vec<Option<i64>>, String> {
    let axes = [2, 3].map(|number| AxisId::numbered(number).unwrap());
    let orders = axes.map(|axis| (axis, order()));
    let lines: Vec<_> = Script::new(&orders).unwrap().collect();
    let text = |trouble: stepwright_host::LinkError| trouble.to_string();
    session.meet().map_err(text)?;
    let starts = orders.map(|(axis, order)| Start { axis, from: Some(0), order });
    session.begin_together(&starts, &lines).map_err(|not| format!("{not:?}"))?;
    while session.is_busy(Selection::All).map_err(text)? {}
    axes.iter().map(|axis| session.rest_position(*axis).map_err(text)).collect()
}

/// Each byte of the orders of two axes, and of the answers.
#[test]
fn axes_begin_together_in_spite_of_noise() {
    let harms: [fn(usize) -> Harm; 5] =
        [Harm::SpoilThere, Harm::SpoilBack, Harm::LoseThere, Harm::LoseBack, |n| {
            Harm::FlipThere(8 * n + n % 8)
        }];
    for n in 0..BYTES {
        for harm in harms {
            let harm = harm(n);
            let board = Shared(Rc::new(RefCell::new(VirtualLink::new(VirtualUno::new(), true))));
            let mut session = Session::new(Box::new(Lossy::new(board.clone(), harm)));
            let steps = Some(i64::from(STEPS));
            assert_eq!(say_together(&mut session), Ok(vec![steps; 2]), "{harm:?}");
            let mut link = board.0.borrow_mut();
            let is = [0, 1, 2].map(|axis| link.board().board().position(axis));
            assert_eq!(is, [Some(0), steps, steps], "{harm:?}");
        }
    }
}

/// A line that loses ten bytes from the board, from this one on.
struct Gap<L> {
    line: L,
    from: usize,
    read: usize,
}

impl<L: Link> Link for Gap<L> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.line.write(bytes)
    }
    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        let mut kept = 0;
        for n in 0..self.line.read(buffer, limit)? {
            buffer[kept] = buffer[n];
            kept += usize::from(!(self.from..self.from + 10).contains(&self.read));
            self.read += 1;
        }
        Ok(kept)
    }
    fn now(&self) -> Duration {
        self.line.now()
    }
    fn name(&self) -> String {
        self.line.name()
    }
}

/// With a position that a kill has made unknown, nothing tells that a short travel is over: it is made once, or
/// the program learns that it does not know.
#[test]
fn a_travel_from_an_unknown_place_is_made_once() {
    // It is over before the program looks.
    const SHORT: i32 = 3;
    let axis = AxisId::FIRST;
    let (long, short) = (order(), Order { travel: Travel::By(Distance::new(SHORT)), ..order() });
    let lines: Vec<_> = Script::new(&[(axis, long)]).unwrap().collect();
    let mut unsure = 0;
    for from in 0..4 * BYTES {
        let board = Shared(Rc::new(RefCell::new(VirtualLink::new(VirtualUno::new(), true))));
        let mut session = Session::new(Box::new(board.clone()));
        session.meet().unwrap();
        session.begin(axis, &long, &lines, Some(0)).unwrap();
        session.kill().unwrap();
        assert_eq!(session.rest_position(axis).unwrap(), None);
        let steps = || board.0.borrow_mut().board().board().motors().engine().report(0).position;
        let before = steps();
        let gap = Gap { line: board.clone(), from, read: 0 };
        let said = say_order(&mut Session::new(Box::new(gap)), axis, &short);
        let went = steps() - before;
        assert!(went == i64::from(SHORT) || said.is_err() && went == 0, "{from}: {went}, {said:?}");
        unsure += u32::from(said.is_err_and(|why| why.contains("moving: true")));
    }
    assert!((1..20).contains(&unsure), "{unsure} unsure");
}
