//! Guests: programs that ask through the one that has the line, over a line with noise.

use std::cell::Cell;
use std::io;
use std::rc::Rc;
use std::sync::mpsc::channel;
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

use stepwright::{Accel, Speed};
use stepwright_host::guests::{GuestLine, Guests};
use stepwright_host::link::Link;
use stepwright_host::link::simulated::{VirtualLink, VirtualUno};
#[cfg(unix)]
use stepwright_host::link::{guest::GuestLink, host::Host};
use stepwright_host::motion::Action;
use stepwright_host::{Board, MotionLimits, Outcome, Session};
use stepwright_protocol::{AxisId, Command, Reply, Selection, crc};

/// A line that flips one bit to the board, counted from when the test sets it.
struct Flips {
    line: VirtualLink<VirtualUno>,
    bit: Rc<Cell<Option<usize>>>,
}

impl Link for Flips {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        for &byte in bytes {
            let flipped = match self.bit.get() {
                Some(bit @ 0..8) => byte ^ 1 << bit,
                _ => byte,
            };
            self.bit.set(self.bit.get().and_then(|bit| bit.checked_sub(8)));
            self.line.write(&[flipped])?;
        }
        Ok(())
    }
    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        self.line.read(buffer, limit)
    }
    fn now(&self) -> Duration {
        self.line.now()
    }
    fn name(&self) -> String {
        "the board".to_owned()
    }
}

/// A guest that says one line.
pub struct Guest(pub Option<GuestLine>);

impl Guests for Guest {
    fn next(&mut self) -> Option<GuestLine> {
        self.0.take()
    }

    fn before(&self, _: Command) {}

    fn after(&self, _: Command, _: Reply) {}
}

/// A line with its checksum, as a guest says it.
fn summed(line: &str) -> Vec<u8> {
    let sum = line.bytes().fold(0, crc);
    format!("{line}*{sum:02X}").into_bytes()
}

fn axis(number: u8) -> Selection {
    Selection::One(AxisId::numbered(number).unwrap())
}

/// Axes 1 and 2 travel 480 steps, and a guest says a line for axis `number` while `bit` is flipped. Returns the
/// answer to the guest, and where both axes rest.
fn goes(bit: Option<usize>, number: u8, line: &str) -> (Option<String>, [Option<i64>; 2]) {
    let flip = Rc::new(Cell::new(None));
    let line_of = VirtualLink::new(VirtualUno::new(), true);
    let mut board = Board::on(Box::new(Flips { line: line_of, bit: flip.clone() })).unwrap();
    let way = MotionLimits::new(Speed::from_steps(800).unwrap(), Accel::from_steps(8_000).unwrap());
    for number in [2, 1] {
        board.axis(number).unwrap().travel(480, &way).unwrap();
    }
    let (answer, answered) = channel();
    let asked = GuestLine { line: summed(line), selection: axis(number), answer };
    board.session().serve(Box::new(Guest(Some(asked))));
    flip.set(bit);
    board.session().pause(Duration::from_millis(20)).unwrap();
    flip.set(None);
    let rest = [1, 2].map(|axis| match board.axis(axis).unwrap().wait(|_| Action::GoOn).unwrap() {
        Outcome::Reached { at } | Outcome::Stopped { at, .. } => Some(at),
        Outcome::Uncertain => None,
    });
    (answered.recv().unwrap(), rest)
}

/// Flips every bit of the selection for the guest, and of the guest's line.
#[test]
fn a_guests_line_is_taken_by_its_axis_or_by_none() {
    let taken = |answer: &Option<String>| answer.as_ref().is_some_and(|said| said.starts_with('Y'));
    for bit in 0..8 * 15 {
        let (answer, rest) = goes(Some(bit), 2, "@+900");
        let second = if taken(&answer) { 900 } else { 480 };
        assert_eq!(rest, [Some(480), Some(second)], "{bit}: {answer:?}");
    }
    assert_eq!(goes(None, 2, "@+900"), (Some("Y*88".to_owned()), [Some(480), Some(900)]));
    for bit in 0..8 * 6 {
        let (answer, [first, second]) = goes(Some(bit), 2, "Z");
        assert!(taken(&answer), "{bit}: {answer:?}");
        assert!(first == Some(480) && second < first, "{bit}: {first:?} {second:?}");
    }
}

/// The line is not said at all: it would apply to the axis that was selected before.
#[test]
fn a_guests_line_is_not_said_where_its_axis_is_not_selected() {
    assert_eq!(goes(None, 8, "@+900"), (None, [Some(480); 2]));
    // K applies to all axes, and is said.
    assert_eq!(goes(None, 8, "K"), (Some("Y*88".to_owned()), [None; 2]));
}

/// A guest that says `t1`, `t2` and so on.
struct Chatty(u32);

impl Guests for Chatty {
    fn next(&mut self) -> Option<GuestLine> {
        self.0 += 1;
        let (line, answer) = (summed(&format!("t{}", self.0)), channel().0);
        (self.0 <= 200).then_some(GuestLine { line, selection: axis(2), answer })
    }

    fn before(&self, _: Command) {}

    fn after(&self, _: Command, _: Reply) {}
}

/// A holder that never asks for changes keeps the last ones.
#[test]
fn changes_that_nobody_asks_for_are_dropped() {
    let mut board = Board::virtual_uno(true).unwrap();
    board.session().serve(Box::new(Chatty(0)));
    for _ in 0..210 {
        board.session().pause(Duration::ZERO).unwrap();
    }
    let kept: Vec<_> = std::iter::from_fn(|| board.session().next_change()).collect();
    assert_eq!(kept.len(), 64);
    let last = Command::parse(b"t200").unwrap();
    assert_eq!(kept.last().unwrap().command, last);
    assert!(board.session().was_changed());
}

/// The holder is told of every line that changes the travel of an axis, or of all.
#[test]
fn the_holder_hears_of_every_change() {
    for (line, words) in [
        ("t500", "top speed 500 steps/s"),
        ("m500500", "top speed 500.5 steps/s"),
        ("a900", "acceleration 900 steps/s²"),
        ("d900", "deceleration 900 steps/s²"),
        ("@+900", "target 900"),
        ("Z", "stop"),
        ("K", "kill"),
    ] {
        let mut board = Board::virtual_uno(true).unwrap();
        board.axis(2).unwrap().travel(5_000, &MotionLimits::default()).unwrap();
        let (answer, answered) = channel();
        let asked = GuestLine { line: summed(line), selection: axis(2), answer };
        board.session().serve(Box::new(Guest(Some(asked))));
        board.session().pause(Duration::from_millis(20)).unwrap();
        assert_eq!(answered.recv().unwrap().as_deref(), Some("Y*88"), "{line}");
        let change = board.session().next_change().unwrap();
        assert_eq!(change.to_string(), words);
        let all = if line == "K" { Selection::All } else { axis(2) };
        assert_eq!(change.axes, all, "{line}");
    }
}

/// A port, its holder, and a guest that waits 50 ms for an answer.
#[cfg(unix)]
fn held() -> (tempfile::NamedTempFile, Host, GuestLink) {
    let port = tempfile::NamedTempFile::new().unwrap();
    let host = Host::open(port.path()).unwrap();
    let guest = GuestLink::open(port.path(), Duration::from_millis(50)).unwrap();
    (port, host, guest)
}

/// The next line of a guest within 5 s.
#[cfg(unix)]
fn next_of(host: &mut Host) -> Option<GuestLine> {
    let end = Instant::now() + Duration::from_secs(5);
    while Instant::now() < end {
        if let Some(line) = host.next() {
            return Some(line);
        }
        sleep(Duration::from_millis(1));
    }
    None
}

/// The holder was suspended, say: once it goes on, what the guest has given up must not happen.
#[cfg(unix)]
#[test]
fn a_line_that_its_guest_has_given_up_is_not_said() {
    let (_port, mut host, mut guest) = held();
    guest.write(b"@+900\r").unwrap();
    sleep(Duration::from_millis(100));
    assert_eq!(guest.write(b"F\r").unwrap_err().kind(), io::ErrorKind::TimedOut);
    guest.write(b"F\r").unwrap();
    let asked = next_of(&mut host).unwrap();
    assert_eq!(String::from_utf8(asked.line).unwrap(), "F");
    asked.answer.send(Some("R".to_owned())).unwrap();
    let mut answer = [0; 8];
    assert_eq!(guest.read(&mut answer, Duration::from_secs(5)).unwrap(), 2);
    assert_eq!(&answer[..2], b"R\r");
    // A guest that ends gives up too.
    guest.write(b"Z\r").unwrap();
    sleep(Duration::from_millis(100));
    drop(guest);
    assert!(host.next().is_none());
}

/// A new connection has the first axis selected, whatever was selected before.
#[cfg(unix)]
#[test]
fn a_guest_that_connects_again_selects_its_axis_again() {
    let (_port, mut host, guest) = held();
    let holder = spawn(move || {
        let mut unanswered = Vec::new();
        loop {
            let asked = next_of(&mut host).unwrap();
            let answer = match asked.line.as_slice() {
                b"F" => "R",
                b"?" => "stepwright 0.1 axes=3 max=1 late=0 refused=0 last=none uncertain=0",
                b"A2" => "Y",
                b"$" => {
                    unanswered.push(asked);
                    continue;
                }
                _ => return asked,
            };
            asked.answer.send(Some(answer.to_owned())).unwrap();
        }
    });
    let mut guest = Session::new(Box::new(guest));
    guest.meet().unwrap();
    guest.select(axis(2)).unwrap();
    for _ in 0..2 {
        assert_eq!(guest.once(Command::Settings).unwrap(), None);
    }
    let _ = guest.ask_of(axis(2), Command::Stop);
    let asked = holder.join().unwrap();
    assert_eq!((asked.line.as_slice(), asked.selection), (&b"Z"[..], axis(2)));
}
