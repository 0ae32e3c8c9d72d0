//! A keeper and a virtual board.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use stepwright_host::Session;
use stepwright_host::guests::{GuestLine, Guests};
use stepwright_host::link::lossy::{Harm, Lossy};
use stepwright_host::link::simulated::{VirtualLink, VirtualUno};
use stepwright_keeper::report::{BoardSheet, Done, LiveState, PlannedCurve};
use stepwright_keeper::{Declined, Hand, Job, Keeper, KeeperDesk, KeptBoard, asked};
use stepwright_protocol::{Command, LeaseMillis, Reply, Selection};

#[derive(Default)]
struct Desk {
    time: Mutex<f64>,
    notes: Mutex<Vec<String>>,
    sheet: Mutex<Option<BoardSheet>>,
}

impl KeeperDesk for Desk {
    fn time(&self) -> f64 {
        *self.time.lock().unwrap()
    }
    fn is_urgent(&self) -> bool {
        false
    }
    fn is_there(&self, _: Hand) -> bool {
        true
    }
    fn is_live(&self, _: Hand) -> bool {
        true
    }
    fn describe(&self, sheet: BoardSheet) {
        *self.sheet.lock().unwrap() = Some(sheet);
    }
    fn publish(&self, _: LiveState) {}
    fn note(&self, text: String) {
        self.notes.lock().unwrap().push(text);
    }
    fn plan(&self, _: PlannedCurve) {}
    fn unplan(&self, _: u8) {}
}

/// A board that is kept.
struct Kept {
    session: Session,
    desk: Arc<Desk>,
    keeper: Keeper<Desk>,
}

impl Kept {
    fn new() -> Kept {
        // No byte is so far away.
        Kept::harmed(Harm::SpoilBack(usize::MAX))
    }

    fn harmed(harm: Harm) -> Kept {
        let desk = Arc::new(Desk::default());
        let board = KeptBoard {
            name: "the board".to_owned(),
            units: Vec::new(),
            home_within: Vec::new(),
            machine: None,
            lease: LeaseMillis::SMALLEST,
            leases_travels: false,
        };
        let mut keeper = Keeper::new(desk.clone(), board);
        let line = VirtualLink::new(VirtualUno::new(), true);
        let mut session = Session::new(Box::new(Lossy::new(line, harm)));
        session.meet().unwrap();
        session.wait(async |talk| keeper.begin(talk).await).unwrap().unwrap();
        Kept { session, desk, keeper }
    }

    /// Begins an order. Its answer comes when the order has ended.
    fn order(&mut self, name: &str, body: &str) -> Receiver<Result<Done, Declined>> {
        let (wish, _) = asked::wish(name, body, Hand(1)).unwrap();
        let (to, answer) = channel();
        self.turn(Some(Job::new(wish, true, move |ended| drop(to.send(ended)))));
        answer
    }

    fn turn(&mut self, job: Option<Job>) {
        *self.desk.time.lock().unwrap() = self.session.now().as_secs_f64();
        let turned = self.session.wait(async |talk| self.keeper.turn(talk, job).await);
        let pause = turned.unwrap().unwrap();
        self.session.pause(pause.max(Duration::from_millis(1))).unwrap();
    }

    /// Waits for the end of an order: the outcome, and each axis' position and target.
    fn end(
        &mut self,
        answer: &Receiver<Result<Done, Declined>>,
    ) -> (&'static str, Vec<[Option<i64>; 2]>) {
        for _ in 0..10_000 {
            if let Ok(ended) = answer.try_recv() {
                let ended = ended.unwrap().ended.unwrap();
                let axes = ended.axes.iter().map(|axis| [axis.position, axis.target]);
                return (ended.outcome, axes.collect());
            }
            self.turn(None);
        }
        panic!("the order does not end");
    }
}

/// A guest that says one line.
struct Guest(Option<GuestLine>);

impl Guests for Guest {
    fn next(&mut self) -> Option<GuestLine> {
        self.0.take()
    }
    fn before(&self, _: Command) {}
    fn after(&self, _: Command, _: Reply) {}
}

/// The new target counts from where the travel of each axis began.
#[test]
fn a_guest_gives_all_axes_a_target() {
    let mut kept = Kept::new();
    let moved = kept.order("move", r#"{"axis": 2, "by": 100}"#);
    assert_eq!(kept.end(&moved), ("reached", vec![[Some(100); 2]]));
    let line = kept.order("line", r#"{"by": [9000, 9000, 9000]}"#);
    let (answer, answered): (Sender<Option<String>>, _) = channel();
    let asked = GuestLine { line: b"@+900".to_vec(), selection: Selection::All, answer };
    kept.session.serve(Box::new(Guest(Some(asked))));
    let ends = [900, 1000, 900].map(|end| [Some(end); 2]);
    assert_eq!(kept.end(&line), ("reached", ends.to_vec()));
    assert_eq!(answered.recv().unwrap().as_deref(), Some("Y"));
    let notes = kept.desk.notes.lock().unwrap();
    assert_eq!(*notes, ["another terminal: target +900 steps from where the travel began"]);
}

/// The board is described once, when it is met.
#[test]
fn a_board_has_its_settings_in_spite_of_noise() {
    let settings = |harm| {
        let sheet = Kept::harmed(harm).desk.sheet.lock().unwrap().take().unwrap();
        sheet.settings.iter().map(|one| (one.name, one.value)).collect::<Vec<_>>()
    };
    let all = settings(Harm::SpoilBack(usize::MAX));
    assert!(all.len() > 10);
    for byte in (0..2_000).step_by(17) {
        assert_eq!(settings(Harm::SpoilBack(byte)), all, "{byte}");
    }
}
