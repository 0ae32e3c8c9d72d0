//! Other programs that ask through the one that has the line, over a line with noise.

use std::cell::Cell;
use std::io;
use std::rc::Rc;
use std::sync::mpsc::channel;
use std::time::Duration;

use stepwright::{Accel, Speed};
use stepwright_host::guests::{GuestLine, Guests};
use stepwright_host::link::Link;
use stepwright_host::link::simulated::{VirtualLink, VirtualUno};
use stepwright_host::motion::Action;
use stepwright_host::{Board, MotionLimits, Outcome};
use stepwright_protocol::{Command, Reply, crc};

/// A line that flips a bit to the board, counted from when that is asked for.
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

/// Another program, which says one line.
struct Guest(Option<GuestLine>);

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

/// Axes 1 and 2 on a travel of 480 steps, and a guest who says a line of the axis that `select`
/// selects while this bit is flipped: what it is answered, and where both rest.
fn goes(bit: Option<usize>, select: &str, line: &str) -> (Option<String>, [Option<i64>; 2]) {
    let flip = Rc::new(Cell::new(None));
    let line_of = VirtualLink::new(VirtualUno::new(), true);
    let mut board = Board::on(Box::new(Flips { line: line_of, bit: flip.clone() })).unwrap();
    let way = MotionLimits::new(Speed::from_steps(800).unwrap(), Accel::from_steps(8_000).unwrap());
    for axis in [2, 1] {
        board.axis(axis).unwrap().travel(480, &way).unwrap();
    }
    let (answer, answered) = channel();
    let asked = GuestLine { line: summed(line), selection: Some(summed(select)), answer };
    board.session().serve(Box::new(Guest(Some(asked))));
    flip.set(bit);
    board.session().pause(Duration::from_millis(20)).unwrap();
    flip.set(None);
    let rest =
        [1, 2].map(|axis| match board.axis(axis).unwrap().wait(480, |_| Action::GoOn).unwrap() {
            Outcome::Reached { at } | Outcome::Stopped { at, .. } => Some(at),
            Outcome::Uncertain => None,
        });
    (answered.recv().unwrap(), rest)
}

/// Every bit of the selection that is said for a guest, and of its line.
#[test]
fn a_guests_line_is_taken_by_its_axis_or_by_none() {
    let taken = |answer: &Option<String>| answer.as_ref().is_some_and(|said| said.starts_with('Y'));
    for bit in 0..8 * 15 {
        let (answer, rest) = goes(Some(bit), "A2", "@+900");
        let second = if taken(&answer) { 900 } else { 480 };
        assert_eq!(rest, [Some(480), Some(second)], "{bit}: {answer:?}");
    }
    assert_eq!(goes(None, "A2", "@+900"), (Some("Y*88".to_owned()), [Some(480), Some(900)]));
    for bit in 0..8 * 6 {
        let (answer, [first, second]) = goes(Some(bit), "A2", "Z");
        assert!(taken(&answer), "{bit}: {answer:?}");
        assert!(first == Some(480) && second < first, "{bit}: {first:?} {second:?}");
    }
}

/// Its line is not said at all: it would be of whatever was selected before.
#[test]
fn a_guests_line_is_not_said_where_its_axis_is_not_selected() {
    assert_eq!(goes(None, "A8", "@+900"), (None, [Some(480); 2]));
    // But for one that is of all axes.
    assert_eq!(goes(None, "A8", "K"), (Some("Y*88".to_owned()), [None; 2]));
}
