//! The state between two calls of the page, and the future that the calls run.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Waker};
use std::time::Duration;

use stepwright_host::{Conversation, LinkError};
use stepwright_keeper::tap::Tap;
use stepwright_keeper::{Declined, Keeper, KeptBoard};
use stepwright_protocol::LeaseMillis;

use crate::page_desk::{PageDesk, Wake, WireEvent};

/// A board that hears nothing for this time brakes an endless run by itself. A page in the background is woken
/// once a second.
const LEASE: LeaseMillis = LeaseMillis::clamped(2500);

/// An event.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// Time has passed.
    Time,
    /// These bytes have come from the board.
    Bytes(&'a [u8]),
    /// A request: `NUMBER NAME`, a line feed, and its body.
    Ask(&'a str),
    /// A wire is open to the board of this name.
    Open(&'a str),
    /// No wire could be opened: the board's name, a line feed, the reason.
    Failed(&'a str),
    /// The wire is gone, for this reason.
    Gone(&'a str),
    /// The page wants another board.
    Leave,
    /// Whether the page wants the questions to the board too.
    Questions(bool),
}

/// A host whose bytes and time come from a page.
pub struct WasmHost {
    desk: Arc<PageDesk>,
    kept: Pin<Box<dyn Future<Output = ()>>>,
    tap: Tap,
}

impl Default for WasmHost {
    fn default() -> WasmHost {
        let desk = Arc::new(PageDesk::default());
        WasmHost { kept: Box::pin(keep(desk.clone())), desk, tap: Tap::default() }
    }
}

impl WasmHost {
    /// Handles an event at `now`, in s since the page began. Returns the bytes for the board, and in how many s
    /// to call again if nothing happens.
    pub fn turn(&mut self, now: f64, event: Event) -> (Vec<u8>, Option<f64>) {
        // Whole microseconds make shorter text.
        let now = (now * 1e6).round() / 1e6;
        self.desk.pass(now);
        match event {
            Event::Time => {}
            Event::Bytes(bytes) => {
                self.tap.answered(bytes, |line, answer| self.desk.heard(line, answer));
                self.desk.pipe().feed(bytes);
            }
            Event::Ask(request) => self.desk.ask(request),
            Event::Open(name) => self.desk.wire(WireEvent::Open(name.to_owned())),
            Event::Failed(text) => {
                let (name, why) = text.split_once('\n').unwrap_or((text, "it can't be opened"));
                self.desk.wire(WireEvent::Failed(name.to_owned(), why.to_owned()));
            }
            Event::Gone(why) => self.desk.pipe().lose(io::Error::other(why)),
            Event::Leave => self.desk.wire(WireEvent::Leave),
            Event::Questions(wanted) => self.desk.questions(wanted),
        }
        let mut context = Context::from_waker(Waker::noop());
        // The future never ends.
        let _ = self.kept.as_mut().poll(&mut context);
        let pipe = self.desk.pipe();
        let bytes = pipe.take_output();
        self.tap.said(&bytes, |line, answer| self.desk.heard(line, answer));
        let line = pipe.deadline().map(|deadline| deadline.as_secs_f64());
        let due = [line, self.desk.until()].into_iter().flatten().reduce(f64::min);
        (bytes, due.map(|due| (due - now).max(0.0)))
    }

    /// The messages since the last call, each one a line of JSON.
    pub fn take_messages(&mut self) -> String {
        self.desk.take_messages()
    }
}

/// Keeps the boards to which the page opens wires.
async fn keep(desk: Arc<PageDesk>) {
    let board = KeptBoard {
        name: String::new(),
        units: Vec::new(),
        home_within: Vec::new(),
        machine: None,
        lease: LEASE,
        leases_travels: false,
    };
    let mut keeper = Keeper::new(desk.clone(), board);
    let mut another = true;
    loop {
        let (name, open) = match desk.wire_event().await {
            WireEvent::Open(name) => (name, Ok(())),
            WireEvent::Failed(name, why) => (name, Err(LinkError::Gone(io::Error::other(why)))),
            WireEvent::Leave => {
                another = true;
                desk.closed(false);
                continue;
            }
        };
        if std::mem::take(&mut another) {
            keeper.keep(name);
        }
        let ended = match open {
            Ok(()) => attend(&desk, &mut keeper).await,
            Err(trouble) => Err(trouble),
        };
        match ended {
            Ok(()) => {
                another = true;
                keeper.leave();
                desk.close(Declined::away("no board was met yet"));
            }
            Err(trouble) => desk.close(keeper.lose(&trouble)),
        }
        desk.closed(!another);
    }
}

/// Meets the board at the end of the wire, and keeps it until the page wants another one.
async fn attend(desk: &Arc<PageDesk>, keeper: &mut Keeper<PageDesk>) -> Result<(), LinkError> {
    let mut talk = Conversation::new(desk.new_pipe());
    talk.meet().await?;
    keeper.begin(&mut talk).await?;
    desk.open();
    let mut pause = Duration::ZERO;
    loop {
        match desk.next(pause.as_secs_f64()).await {
            Wake::Turn(job) => pause = keeper.turn(&mut talk, job).await?,
            Wake::Leave => {
                // A board that is gone meanwhile counts as left, too.
                keeper.let_go(&mut talk).await.ok();
                return Ok(());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use stepwright_host::link::Link;
    use stepwright_host::link::simulated::{VirtualLink, VirtualUno};

    use super::{Event, WasmHost};

    /// A host with the virtual board at the end of its wire, as in a page.
    struct Bench {
        host: WasmHost,
        link: VirtualLink<VirtualUno>,
        said: String,
        /// The bytes of the last turn.
        bytes: Vec<u8>,
    }

    impl Bench {
        fn new() -> Bench {
            let link = VirtualLink::new(VirtualUno::new(), true);
            let host = WasmHost::default();
            let mut bench = Bench { host, link, said: String::new(), bytes: Vec::new() };
            bench.turn(Event::Open("the virtual board"));
            bench
        }

        fn turn(&mut self, event: Event) -> Option<f64> {
            let now = self.link.now().as_secs_f64();
            let (bytes, due) = self.host.turn(now, event);
            self.link.write(&bytes).unwrap();
            self.said += &self.host.take_messages();
            self.bytes = bytes;
            due
        }

        /// Goes on until the messages have this text, for at most 100 s of the board.
        fn until(&mut self, told: &str) {
            self.while_not(|bench| bench.said.contains(told));
        }

        /// Goes on until `holds` is true, for at most 100 s of the board.
        fn while_not(&mut self, holds: impl Fn(&Bench) -> bool) {
            let end = self.link.now() + Duration::from_secs(100);
            let mut due = self.turn(Event::Time);
            while !holds(self) {
                assert!(self.link.now() < end, "never: {}", self.said);
                let mut bytes = [0; 256];
                let limit = Duration::from_secs_f64(due.unwrap_or(1.0).max(0.001));
                let count = self.link.read(&mut bytes, limit).unwrap();
                due = self.turn(match count {
                    0 => Event::Time,
                    count => Event::Bytes(&bytes[..count]),
                });
            }
        }
    }

    #[test]
    fn a_request_is_answered_when_its_order_has_ended() {
        let mut bench = Bench::new();
        bench.until(r#""connected":true"#);
        bench.turn(Event::Ask("7 move?wait=true\n{\"axis\":1,\"to\":-400}"));
        bench.until(r#""type":"answer","id":7,"status":200"#);
        assert!(bench.said.contains(r#""outcome":"reached""#), "{}", bench.said);
        assert!(bench.said.contains(r#""position":-400,"target":-400"#));
        bench.turn(Event::Ask("8 jump"));
        bench.until(r#""id":8,"status":404"#);
    }

    #[test]
    fn a_board_is_left_even_if_it_is_gone_meanwhile_and_whoever_waits_is_answered() {
        for gone in [false, true] {
            let mut bench = Bench::new();
            bench.until(r#""connected":true"#);
            bench.turn(Event::Ask("5 move?wait=true\n{\"axis\":1,\"by\":100000}"));
            bench.until(r#""moving":true"#);
            bench.turn(Event::Leave);
            if gone {
                // While the host tells it to brake.
                bench.while_not(|bench| bench.bytes.starts_with(b"Z"));
                bench.turn(Event::Gone("pulled"));
            }
            bench.until(r#"{"type":"closed","lost":false}"#);
            assert!(!bench.said.contains(r#""lost":true"#), "{}", bench.said);
            assert!(bench.said.contains(r#""id":5,"status":503"#), "{}", bench.said);
        }
    }

    #[test]
    fn a_lost_board_declines_what_waits_and_is_met_again() {
        let mut bench = Bench::new();
        bench.turn(Event::Ask("1 kill\n{}"));
        assert!(bench.said.contains(r#""id":1,"status":503"#), "{}", bench.said);
        bench.until(r#""connected":true"#);
        bench.turn(Event::Ask("2 run\n{\"axis\":1,\"speed\":400}"));
        bench.until(r#""id":2,"status":200"#);
        bench.turn(Event::Gone("pulled"));
        bench.until(r#"{"type":"closed","lost":true}"#);
        assert!(bench.said.contains("the line is gone (pulled)"), "{}", bench.said);
        bench.said.clear();
        bench.turn(Event::Failed("the virtual board\nno port"));
        bench.until(r#"{"type":"closed","lost":true}"#);
        bench.turn(Event::Open("the virtual board"));
        bench.until("the virtual board is back");
        // Nobody has controlled the run meanwhile: it is braked.
        bench.until(r#""moving":false,"state":"ready","stop":{"name":"stop""#);
        bench.turn(Event::Leave);
        bench.until(r#"{"type":"closed","lost":false}"#);
        bench.turn(Event::Ask("3 kill\n{}"));
        assert!(bench.said.contains(r#""id":3,"status":503"#), "{}", bench.said);
    }

    #[test]
    fn another_board_may_have_fewer_axes() {
        let mut bench = Bench::new();
        bench.until(r#""connected":true"#);
        bench.turn(Event::Ask("2 run\n{\"axis\":3,\"speed\":400}"));
        bench.until(r#""id":2,"status":200"#);
        bench.turn(Event::Gone("pulled"));
        bench.until(r#"{"type":"closed","lost":true}"#);
        bench.link = VirtualLink::new(VirtualUno::of(1), true);
        bench.turn(Event::Open("the virtual board"));
        bench.until("the virtual board is back");
    }
}
