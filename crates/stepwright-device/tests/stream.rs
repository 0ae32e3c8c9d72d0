//! The text lines of a board that plays streams, with bytes that come before they are obeyed.

use std::cell::Cell;
use std::collections::VecDeque;
use std::rc::Rc;

use stepwright::drive::Axes;
use stepwright::engine::WIRING;
use stepwright::queue::Queue;
use stepwright::{Control, Playing, Report, Timing};
use stepwright_device::main_loop::{Received, SerialPort, round};
use stepwright_device::{Mark, Reset, ResetIo, StreamDevice, StreamIo};
use stepwright_protocol::flash_text;
use stepwright_stream::credit::{Answered, CreditReader};
use stepwright_stream::frame::{FILL, FrameBytes, Kind};
use stepwright_stream::player::StreamPlayer;
use stepwright_stream::record::NOTHING;

/// An engine that notes a kill.
struct Killed(bool);

impl Control for Killed {
    fn start(&mut self, _: Axes) {}
    fn kill(&mut self, _: Axes) {
        self.0 = true;
    }
    fn report(&self, _: u8) -> Report {
        Report { position: 0, idle: true, forward: true }
    }
    fn playing(&mut self, _: u8) -> Playing {
        Playing::Unknown
    }
    fn set_position(&mut self, _: u8, _: i64) {}
    fn set_timing(&mut self, _: Timing) {}
    fn late(&self) -> u32 {
        0
    }
    fn clear_late(&mut self) {}
}

struct Still;

impl StreamIo for Still {
    fn now(&mut self) -> u16 {
        0
    }
    fn ticked(&mut self) -> bool {
        false
    }
    fn inputs(&mut self) -> u8 {
        0
    }
    fn enable(&mut self) {}
}

#[derive(Default)]
struct Wire {
    to: VecDeque<u8>,
    said: Vec<u8>,
}

impl SerialPort for Wire {
    fn receive(&mut self) -> Option<Received> {
        self.to.pop_front().map(Received::Byte)
    }
    fn has_room(&self) -> bool {
        true
    }
    fn send(&mut self, byte: u8) {
        self.said.push(byte);
    }
}

/// Whether a kill was obeyed, and the text answers, when these bytes come at once, or one each
/// round.
fn heard(bytes: &[u8], at_once: bool) -> (bool, String) {
    let mut queues = [const { Queue::<8>::new() }; 3];
    let feeds = queues.each_mut().map(|queue| queue.split().0);
    let player = StreamPlayer::<_, 8, 896>::new(Killed(false), feeds, [WIRING; 3], 72);
    let mut device = StreamDevice::new(player, Still, (), flash_text!("test"), 16_000_000);
    let mut wire = Wire::default();
    for byte in bytes {
        wire.to.push_back(*byte);
        if !at_once {
            round(&mut device, &mut wire);
        }
    }
    (0..200).for_each(|_| round(&mut device, &mut wire));
    let (mut reader, mut text) = (CreditReader::new(), String::new());
    for byte in wire.said {
        reader.hear(byte, |told| {
            if let Answered::Text(byte) = told {
                text.push(char::from(byte));
            }
        });
    }
    (device.player().engine().0, text)
}

#[test]
fn a_kill_is_obeyed_whatever_follows() {
    let ping = FrameBytes::new(Kind::Ping, 0, &[]);
    let ping = ping.as_bytes();
    for at_once in [true, false] {
        for before in [&[][..], ping] {
            for behind in [&[][..], b"\n", b"F\r", &[FILL; 4], ping, b"\nK\n", b"F"] {
                let bytes = [before, b"K\r", behind].concat();
                let (killed, said) = heard(&bytes, at_once);
                assert!(killed, "{bytes:?}: {said:?}");
                assert!(said.contains("Y\r"), "{bytes:?}: {said:?}");
            }
        }
    }
}

/// A line that comes before the previous one is answered is lost. No end of it is obeyed, wherever
/// in it the answer is given.
#[test]
fn no_end_of_a_lost_line_is_obeyed() {
    let ping = FrameBytes::new(Kind::Ping, 0, &[]);
    let mut waited = 0;
    for count in 1..30 {
        // The credit is being sent while F waits for its answer.
        let bytes = [ping.as_bytes(), b"F\r", &vec![b'X'; count][..], b"K\r"].concat();
        let (killed, said) = heard(&bytes, false);
        assert!(!killed && said.starts_with("R\r"), "{count}: {said:?}");
        waited += usize::from(said.contains('E'));
    }
    // Short ones are lost without an answer.
    assert!((1..29).contains(&waited), "{waited}");
}

/// A board on which a millisecond passes in each round.
struct Ticking(bool);

impl StreamIo for Ticking {
    fn now(&mut self) -> u16 {
        0
    }
    fn ticked(&mut self) -> bool {
        self.0 = !self.0;
        self.0
    }
    fn inputs(&mut self) -> u8 {
        0
    }
    fn enable(&mut self) {}
}

/// A place for marks that is seen from outside.
#[derive(Clone)]
struct Kept(Rc<Cell<Mark>>);

impl ResetIo for Kept {
    fn reset(&mut self) -> Reset {
        Reset::Other
    }
    fn mark(&self) -> Mark {
        self.0.get()
    }
    fn set_mark(&mut self, mark: Mark) {
        self.0.set(mark);
    }
}

/// It is marked as moving before a start can come, and until all is over.
#[test]
fn a_stream_is_marked_from_its_setup_on() {
    let kept = Kept(Rc::new(Cell::new(Mark::NONE)));
    let mut queues = [const { Queue::<8>::new() }; 3];
    let feeds = queues.each_mut().map(|queue| queue.split().0);
    let player = StreamPlayer::<_, 8, 896>::new(Killed(false), feeds, [WIRING; 3], 72);
    let mut device =
        StreamDevice::new(player, Ticking(false), kept.clone(), flash_text!("test"), 16_000_000);
    device.begin();
    assert_eq!(device.player().position(1), Some(0));
    let mut wire = Wire::default();
    let frames = [
        (Kind::Ping, &[][..], Mark::NONE),
        (Kind::Setup, &[0; 18], Mark::MOVING),
        (Kind::Start, &[7, 0, 0, 0], Mark::MOVING),
    ];
    for (number, (kind, payload, mark)) in (255u8..=255).chain(0..).zip(frames) {
        wire.to.extend(FrameBytes::new(kind, number, payload).as_bytes());
        (0..40).for_each(|_| round(&mut device, &mut wire));
        assert_eq!(kept.mark(), mark, "{kind:?}");
    }
    // Its engine is at rest at once.
    wire.to.extend(b"K\r");
    (0..40).for_each(|_| round(&mut device, &mut wire));
    assert_eq!(kept.mark(), Mark::MOVED);
    device.begin();
    assert!((0..3).all(|axis| device.player().position(axis).is_none()));
}

/// The end of a frame that would have four 0xFF is not data of a cut without data.
#[test]
fn a_bare_cut_may_end_as_a_frame_of_data() {
    for payload in [&[0][..], &[0, NOTHING]] {
        let mut queues = [const { Queue::<8>::new() }; 3];
        let feeds = queues.each_mut().map(|queue| queue.split().0);
        let player = StreamPlayer::<_, 8, 896>::new(Killed(false), feeds, [WIRING; 3], 72);
        let mut device = StreamDevice::new(player, Still, (), flash_text!("test"), 16_000_000);
        let mut wire = Wire::default();
        let free = device.player().credit().free;
        // The gate of the data is far ahead.
        let frames = [(Kind::Setup, &[0; 18][..]), (Kind::Data, &[100; 20]), (Kind::Cut, payload)];
        for (number, (kind, payload)) in (0..).zip(frames) {
            wire.to.extend(FrameBytes::new(kind, number, payload).as_bytes());
            (0..100).for_each(|_| round(&mut device, &mut wire));
        }
        let credit = device.player().credit();
        assert_eq!((credit.next, credit.free, credit.opened), (3, free, 0), "{payload:?}");
    }
}
